//! Balls of unequal size in the deceleration pair.
//!
//! g_i = the interference of ball i along its normals; several instances make a lot.

use super::port::{Action, Ball};
use super::spec::{Class, Parameter, Port, Reducers, Spec};
use crate::units::Quantity;

/// The effect.
pub static SPEC: Spec = Spec {
    id: "ball_diameter_lot",
    class: Class::Effect,
    port: Port::Gap,
    reducers: Reducers::BallDrives,
    equation: "g_i = oversize of ball i of the deceleration pair; one entry for each ball",
    source: "lot variation of ball diameters, ISO 3290",
    tell_tale: "the residual repeats with the period of the ball ring and is larger at low preload",
    parameters: &[
        Parameter::chosen("ball", 0.0, "number of the ball, from 0").within(0.0, 999.0).likely(0.0, 999.0),
        Parameter::size("oversize", Quantity::Length, "excess of the ball's diameter")
            .within(-1e-3, 1e-3)
            .likely(-3e-6, 3e-6),
    ],
    twins: &[],
    action: Action::Gap(shape),
};

#[allow(clippy::float_cmp)] // both are whole numbers
fn shape(own: &[f64], _: usize, ball: &Ball) -> [f64; 3] {
    let this = ball.decelerates && ball.number as f64 == own[0];
    [0.0, f64::from(this), 0.0]
}

#[cfg(test)]
#[allow(clippy::float_cmp)] // where nothing is rounded
mod tests {
    use super::*;
    use crate::effect::testing::{BALL, gap, vanishes};

    #[test]
    fn it_squeezes_one_ball_along_its_normals() {
        assert_eq!(gap(&SPEC, &[4.0, 0.0], 1, &BALL), [0.0, 1.0, 0.0]);
        assert_eq!(gap(&SPEC, &[5.0, 0.0], 1, &BALL), [0.0; 3]);
        assert_eq!(gap(&SPEC, &[4.0, 0.0], 1, &Ball { decelerates: false, ..BALL }), [0.0; 3]);
    }

    #[test]
    fn it_vanishes() {
        vanishes(&SPEC);
    }
}
