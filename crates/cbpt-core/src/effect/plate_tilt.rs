//! Plates that are not parallel.
//!
//! zeta_i = R_pair (c cos(phi_i) + s sin(phi_i)) in both pairs, phi_i from the line of centres: a tilt psi = hypot(c, s)
//! that turns with the crank, about an axis at the phase atan2(s, c). A tilt that stands in the housing has the ball's
//! angle in the housing in place of phi_i.

use super::port::{Action, Ball};
use super::spec::{Class, Parameter, Port, Reducers, Spec};
use crate::units::Quantity;

/// The effect.
pub static SPEC: Spec = Spec {
    id: "plate_tilt",
    class: Class::Effect,
    port: Port::Gap,
    reducers: Reducers::BallDrives,
    equation: "zeta_i = R_pair (c cos(phi_i) + s sin(phi_i)), where phi_i is the angle of ball i from the line of centres or in the housing",
    source: "geometry of a tilted plane",
    tell_tale: "the residual is proportional to torque",
    parameters: &[
        tilt("tilt_cosine", "tilt that presses on the balls along the line of centres"),
        tilt("tilt_sine", "tilt that presses on the balls across the line of centres"),
        tilt("housing_tilt_cosine", "tilt fixed in the housing, along the line of centres at crank angle 0"),
        tilt("housing_tilt_sine", "tilt fixed in the housing, across the line of centres at crank angle 0"),
    ],
    twins: &[],
    action: Action::Gap(shape),
};

const fn tilt(stem: &'static str, meaning: &'static str) -> Parameter {
    Parameter::size(stem, Quantity::Angle, meaning).shown("urad").within(-0.1, 0.1).likely(-1e-3, 1e-3)
}

fn shape(_: &[f64], size: usize, ball: &Ball) -> [f64; 3] {
    let (sin, cos) = if size < 2 { ball.from_line_rad } else { ball.on_fixed_groove_rad }.sin_cos();
    [ball.pitch_radius_m * if size.is_multiple_of(2) { cos } else { sin }, 0.0, 0.0]
}

#[cfg(test)]
#[allow(clippy::float_cmp)] // where nothing is rounded
mod tests {
    use super::*;
    use crate::effect::testing::{BALL, assert_close, gap, vanishes};

    #[test]
    fn it_lifts_every_ball_by_its_place() {
        let lift = |size| gap(&SPEC, &[0.0; 4], size, &BALL)[0] / BALL.pitch_radius_m;
        assert_close(lift(0), BALL.from_line_rad.cos());
        assert_close(lift(1), BALL.from_line_rad.sin());
        assert_close(lift(2), BALL.on_fixed_groove_rad.cos());
        assert_close(lift(3), BALL.on_fixed_groove_rad.sin());
    }

    #[test]
    fn it_vanishes() {
        vanishes(&SPEC);
    }
}
