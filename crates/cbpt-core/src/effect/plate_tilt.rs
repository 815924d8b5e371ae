//! Plates that are not parallel.
//!
//! zeta_i = R_pair (c cos(phi_i) + s sin(phi_i)) in both pairs, phi_i from the line of centres: a tilt psi = hypot(c, s)
//! that turns with the crank, about an axis at the phase atan2(s, c). A tilt that stands in the housing has the ball's
//! angle in the housing in place of phi_i. The fixed plate faces the deceleration balls alone, the plate of the output the
//! equal-speed balls alone, so a tilt of one of them lifts the balls of its pair. The tilt of the fixed plate stands in the
//! housing, that of the output's plate turns with it: by one turn of the output in as many of the crank as the drive reduces by.

use super::port::{Action, Ball};
use super::spec::{Class, Parameter, Port, Reducers, Spec};
use crate::units::Quantity;

/// The effect.
pub static SPEC: Spec = Spec {
    id: "plate_tilt",
    class: Class::Effect,
    port: Port::Gap,
    reducers: Reducers::BallDrives,
    equation: "zeta_i = R_pair (c cos(phi_i) + s sin(phi_i)), where phi_i is the angle of ball i from the line of centres, in the housing or in the plate; in both pairs or in that of one plate",
    source: "geometry of a tilted plane",
    tell_tale: "the residual is proportional to torque",
    parameters: &[
        tilt("tilt_cosine", "tilt that presses on the balls along the line of centres"),
        tilt("tilt_sine", "tilt that presses on the balls across the line of centres"),
        tilt("housing_tilt_cosine", "tilt fixed in the housing, along the line of centres at crank angle 0"),
        tilt("housing_tilt_sine", "tilt fixed in the housing, across the line of centres at crank angle 0"),
        tilt(
            "fixed_plate_tilt_cosine",
            "tilt of the fixed plate alone, along the line of centres at crank angle 0",
        ),
        tilt(
            "fixed_plate_tilt_sine",
            "tilt of the fixed plate alone, across the line of centres at crank angle 0",
        ),
        tilt(
            "output_plate_tilt_cosine",
            "tilt of the output's plate alone, which turns with it, towards equal-speed ball 0",
        ),
        tilt(
            "output_plate_tilt_sine",
            "tilt of the output's plate alone, which turns with it, 90 deg from equal-speed ball 0",
        ),
    ],
    twins: &[],
    action: Action::Gap(shape),
};

const fn tilt(stem: &'static str, meaning: &'static str) -> Parameter {
    Parameter::size(stem, Quantity::Angle, meaning).shown("urad").within(-0.1, 0.1).likely(-1e-3, 1e-3)
}

fn shape(_: &[f64], size: usize, ball: &Ball) -> [f64; 3] {
    let (lifted, angle_rad) = match size / 2 {
        0 => (true, ball.from_line_rad),
        1 => (true, ball.on_fixed_groove_rad),
        2 => (ball.decelerates, ball.on_fixed_groove_rad),
        _ => (!ball.decelerates, ball.in_plate_rad),
    };
    let (sin, cos) = angle_rad.sin_cos();
    let lift = if size.is_multiple_of(2) { cos } else { sin };
    [if lifted { ball.pitch_radius_m * lift } else { 0.0 }, 0.0, 0.0]
}

#[cfg(test)]
#[allow(clippy::float_cmp)] // where nothing is rounded
mod tests {
    use super::*;
    use crate::effect::testing::{BALL, assert_close, gap, vanishes};

    #[test]
    fn it_lifts_every_ball_by_its_place() {
        let lift = |size| gap(&SPEC, &[0.0; 8], size, &BALL)[0] / BALL.pitch_radius_m;
        assert_close(lift(0), BALL.from_line_rad.cos());
        assert_close(lift(1), BALL.from_line_rad.sin());
        assert_close(lift(2), BALL.on_fixed_groove_rad.cos());
        assert_close(lift(3), BALL.on_fixed_groove_rad.sin());
    }

    /// Each plate lifts the balls of its own pair: the fixed one as a tilt of both does, the output's by their places in it.
    #[test]
    fn a_plate_lifts_its_own_pair() {
        let lift = |size, ball: &Ball| gap(&SPEC, &[0.0; 8], size, ball);
        let equal_speed = Ball { decelerates: false, ..BALL };
        for part in [0, 1] {
            let [both, fixed, output] = [2, 4, 6].map(|first| first + part);
            assert!(lift(both, &BALL)[0] != 0.0);
            assert_eq!(lift(fixed, &BALL), lift(both, &BALL));
            assert_eq!(lift(fixed, &equal_speed), [0.0; 3]);
            assert_eq!(lift(output, &BALL), [0.0; 3]);
            let crank_at_0 = Ball { in_plate_rad: BALL.on_fixed_groove_rad, ..equal_speed };
            assert_eq!(lift(output, &crank_at_0), lift(both, &equal_speed));
        }
        let turning = |size| lift(size, &equal_speed)[0] / BALL.pitch_radius_m;
        assert_close(turning(6), BALL.in_plate_rad.cos());
        assert_close(turning(7), BALL.in_plate_rad.sin());
    }

    #[test]
    fn it_vanishes() {
        vanishes(&SPEC);
    }
}
