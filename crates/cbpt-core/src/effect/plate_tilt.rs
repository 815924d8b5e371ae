//! Plates that are not parallel.
//!
//! zeta_i = R_pair (c cos(phi_i) + s sin(phi_i)) in both pairs, phi_i from the line of centres: a tilt psi = hypot(c, s)
//! that turns with the crank, about an axis at the phase atan2(s, c).

use super::port::{Action, Ball};
use super::spec::{Class, Dimension, Parameter, Port, Spec};

/// The effect.
pub static SPEC: Spec = Spec {
    id: "plate_tilt",
    class: Class::Effect,
    port: Port::Gap,
    equation: "zeta_i = R_pair (c cos(phi_i) + s sin(phi_i)), phi_i from the line of centres",
    source: "geometry of a tilted plane",
    tell_tale: "linear in torque",
    parameters: &[
        tilt("tilt_cosine", "tilt that presses the balls on the line of centres"),
        tilt("tilt_sine", "tilt that presses the balls across the line of centres"),
    ],
    twins: &[],
    action: Action::Gap(shape),
};

const fn tilt(stem: &'static str, meaning: &'static str) -> Parameter {
    Parameter::size(stem, Dimension::Angle, meaning).shown("urad", 1e-6).within(-0.1, 0.1).likely(-1e-3, 1e-3)
}

fn shape(_: &[f64], size: usize, ball: &Ball) -> [f64; 3] {
    let (sin, cos) = ball.from_line_rad.sin_cos();
    [ball.pitch_radius_m * if size == 0 { cos } else { sin }, 0.0, 0.0]
}

#[cfg(test)]
#[allow(clippy::float_cmp)] // where nothing is rounded
mod tests {
    use super::*;
    use crate::effect::testing::{BALL, assert_close, gap, vanishes};

    #[test]
    fn it_lifts_every_ball_by_its_place() {
        assert_close(gap(&SPEC, &[0.0, 0.0], 0, &BALL)[0], BALL.pitch_radius_m * BALL.from_line_rad.cos());
        assert_close(gap(&SPEC, &[0.0, 0.0], 1, &BALL)[0], BALL.pitch_radius_m * BALL.from_line_rad.sin());
    }

    #[test]
    fn it_vanishes() {
        vanishes(&SPEC);
    }
}
