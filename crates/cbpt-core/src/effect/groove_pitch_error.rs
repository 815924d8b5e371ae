//! Pitch error of a groove of the deceleration pair.
//!
//! p_i = c cos(h t_i) + s sin(h t_i), t_i the ball's angle along the fixed groove or along the planet's, h the harmonic
//! round it; several instances make a sum over harmonics.

use super::port::{Action, Ball};
use super::spec::{Class, Parameter, Port, Reducers, Spec};
use crate::units::Quantity;

/// The effect.
pub static SPEC: Spec = Spec {
    id: "groove_pitch_error",
    class: Class::Effect,
    port: Port::Gap,
    reducers: Reducers::BallDrives,
    equation: "p_i = c cos(h t_i) + s sin(h t_i), where t_i is the angle of ball i along the fixed groove or the planet's groove",
    source: "Fourier series of the pitch error",
    tell_tale: "the residual has several waves per turn of the crank and depends little on load",
    parameters: &[
        Parameter::chosen("harmonic", 2.0, "waves h round the groove").within(1.0, 1000.0).likely(2.0, 8.0),
        amplitude("cosine", "amplitude of cos(h t)"),
        amplitude("sine", "amplitude of sin(h t)"),
        amplitude("planet_cosine", "amplitude of cos(h t) along the planet's groove"),
        amplitude("planet_sine", "amplitude of sin(h t) along the planet's groove"),
    ],
    twins: &[],
    action: Action::Gap(shape),
};

const fn amplitude(stem: &'static str, meaning: &'static str) -> Parameter {
    Parameter::size(stem, Quantity::Length, meaning).within(-1e-3, 1e-3).likely(-10e-6, 10e-6)
}

fn shape(own: &[f64], size: usize, ball: &Ball) -> [f64; 3] {
    if !ball.decelerates {
        return [0.0; 3];
    }
    let along = if size < 3 { ball.on_fixed_groove_rad } else { ball.on_planet_groove_rad };
    let (sin, cos) = (own[0] * along).sin_cos();
    [0.0, 0.0, if size % 2 == 1 { cos } else { sin }]
}

#[cfg(test)]
#[allow(clippy::float_cmp)] // where nothing is rounded
mod tests {
    use super::*;
    use crate::effect::testing::{BALL, assert_close, gap, vanishes};

    #[test]
    fn it_shifts_the_deceleration_balls_by_a_harmonic() {
        let own = [3.0, 0.0, 0.0, 0.0, 0.0];
        let shift = |size| gap(&SPEC, &own, size, &BALL);
        assert_close(shift(1)[2], (3.0 * BALL.on_fixed_groove_rad).cos());
        assert_close(shift(2)[2], (3.0 * BALL.on_fixed_groove_rad).sin());
        assert_close(shift(3)[2], (3.0 * BALL.on_planet_groove_rad).cos());
        assert_close(shift(4)[2], (3.0 * BALL.on_planet_groove_rad).sin());
        assert_eq!([shift(1)[0], shift(1)[1]], [0.0; 2]);
        assert_eq!(gap(&SPEC, &own, 1, &Ball { decelerates: false, ..BALL }), [0.0; 3]);
    }

    #[test]
    fn it_vanishes() {
        vanishes(&SPEC);
    }
}
