//! Runout: the centre of a groove lies away from the centre of its plate.
//!
//! An offset of the fixed plate turns the output by (de/(Zo e)) sin(theta + phase); one of the planet goes with theta Z1/Z3
//! (Z3/Z1 with the epicycloid plate as output). Written with the amplitudes of sine and cosine, which are smooth where
//! the offset vanishes: offset = hypot(sine, cosine), phase = atan2(cosine, sine).

use super::dual::Dual;
use super::port::{Action, DriveNumbers, Row};
use super::spec::{Class, Parameter, Port, Reducers, Spec};
use crate::units::Quantity;

/// The effect.
pub static SPEC: Spec = Spec {
    id: "eccentricity_error",
    class: Class::Effect,
    port: Port::Series,
    reducers: Reducers::AllByRadius,
    equation: "alpha += (s sin(theta) + c cos(theta))/(Zo e); for an offset of the planet, theta Z1/Z3 takes the place of theta",
    source: "kinematics of an eccentric groove",
    tell_tale: "the residual repeats with each turn and does not depend on load; it vanishes if the angle is set to zero at each input angle",
    parameters: &[
        amplitude("offset_sine", "offset of the fixed plate, in phase with sin(theta)"),
        amplitude("offset_cosine", "offset of the fixed plate, in phase with cos(theta)"),
        amplitude("planet_offset_sine", "offset of the planet, in phase with sin(theta Z1/Z3)"),
        amplitude("planet_offset_cosine", "offset of the planet, in phase with cos(theta Z1/Z3)"),
    ],
    twins: &[],
    action: Action::Series(act),
};

const fn amplitude(stem: &'static str, meaning: &'static str) -> Parameter {
    Parameter::size(stem, Quantity::Length, meaning).within(-1e-3, 1e-3).likely(-20e-6, 20e-6)
}

fn act(own: &[Dual], row: &Row, drive: &DriveNumbers, _: Dual) -> Dual {
    let (sin, cos) = row.input_angle_rad.sin_cos();
    let (planet_sin, planet_cos) = (row.input_angle_rad * drive.planet_turn).sin_cos();
    let offset = own[0] * sin + own[1] * cos + own[2] * planet_sin + own[3] * planet_cos;
    offset * (1.0 / drive.pitch_arm_m)
}

#[cfg(test)]
#[allow(clippy::float_cmp)] // where nothing is rounded
mod tests {
    use super::*;
    use crate::effect::testing::{ROW, assert_close, series, vanishes};

    /// At a crank angle of 30 degrees; the planet's groove turns 0.9 times as far.
    #[test]
    fn it_turns_with_the_crank() {
        let planet = 0.9 * ROW.input_angle_rad;
        assert_close(series(&SPEC, &[2e-6, 0.0, 0.0, 0.0], 1.0), 1e-6 / 0.04);
        assert_close(series(&SPEC, &[0.0, 2e-6, 0.0, 0.0], 1.0), 2e-6 * 0.75_f64.sqrt() / 0.04);
        assert_close(series(&SPEC, &[0.0, 0.0, 2e-6, 0.0], 1.0), 2e-6 * planet.sin() / 0.04);
        assert_close(series(&SPEC, &[0.0, 0.0, 0.0, 2e-6], 1.0), 2e-6 * planet.cos() / 0.04);
    }

    #[test]
    fn it_vanishes() {
        vanishes(&SPEC);
    }
}
