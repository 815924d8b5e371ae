//! Gain of the angle readings.
//!
//! The instrument shows g alpha.

use super::dual::Dual;
use super::port::{Action, Row};
use super::spec::{Class, Parameter, Port, Reducers, Spec};

/// The effect.
pub static SPEC: Spec = Spec {
    id: "sensor_gain",
    class: Class::Rig,
    port: Port::Reading,
    reducers: Reducers::All,
    equation: "reading = g alpha",
    source: "calibration of the angle sensor and of its lever arm",
    tell_tale: "every angle changes by the same factor; the onset of contact loss stays at the same torque",
    parameters: &[Parameter::gain("sensor_gain", "reading divided by the true angle")
        .within(0.1, 10.0)
        .likely(0.7, 1.4)],
    twins: &["contact_stiffness"],
    action: Action::Reading(act),
};

fn act(own: &[Dual], _: &Row, angle_rad: Dual) -> Dual {
    angle_rad * own[0]
}

#[cfg(test)]
#[allow(clippy::float_cmp)] // where nothing is rounded
mod tests {
    use super::*;
    use crate::effect::testing::{assert_close, reading, vanishes};

    #[test]
    fn it_scales_the_angle() {
        assert_close(reading(&SPEC, &[1.2], 1e-4), 1.2e-4);
    }

    #[test]
    fn it_vanishes() {
        vanishes(&SPEC);
    }
}
