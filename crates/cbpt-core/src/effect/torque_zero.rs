//! Zero error of the torque readings.
//!
//! The drive carries M0 = M_read - M_z - r t, M_z + r t what the sensor reads without a torque at the time t after the first reading.

use super::dual::Dual;
use super::port::{Action, Load, Row};
use super::spec::{Class, Parameter, Port, Reducers, Spec};
use crate::units::Quantity;

/// The effect.
pub static SPEC: Spec = Spec {
    id: "torque_zero",
    class: Class::Rig,
    port: Port::Reading,
    reducers: Reducers::All,
    equation: "M0 = M_read - M_z - r t, t since the first reading",
    source: "tare of the torque sensor, and its zero stability as data sheets state it",
    tell_tale: "the residual has one sign at torques of both signs and is largest where the drive is soft: at low preload, under load",
    parameters: &[
        Parameter::size("zero_error", Quantity::Torque, "reading M_z without a torque")
            .within(-1e6, 1e6)
            .likely(-10.0, 10.0),
        Parameter::size("zero_drift", Quantity::TorquePerTime, "rate r at which that reading grows")
            .within(-1e3, 1e3)
            .likely(-0.01, 0.01),
    ],
    twins: &[],
    action: Action::Load(act),
};

fn act(own: &[Dual], row: &Row, load: &mut Load) {
    load.torque_Nm = load.torque_Nm - own[0] - own[1] * row.time_s;
}

#[cfg(test)]
#[allow(clippy::float_cmp)] // where nothing is rounded
mod tests {
    use super::*;
    use crate::effect::testing::{ROW, assert_close, load, vanishes};

    #[test]
    fn it_shifts_the_torque() {
        assert_close(load(&SPEC, &[0.3, 0.0]).torque_Nm.value, ROW.torque_Nm - 0.3);
    }

    /// 500 s.
    #[test]
    fn the_shift_grows_with_time() {
        assert_close(load(&SPEC, &[0.3, 2e-4]).torque_Nm.value, ROW.torque_Nm - 0.3 - 0.1);
    }

    #[test]
    fn it_vanishes() {
        vanishes(&SPEC);
    }
}
