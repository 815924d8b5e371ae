//! Play of the eccentric bearing.
//!
//! A diametral clearance c lets the planet move by c/2 to either side: alpha += sgn(M0) (c/2)/(Zo e), 0 at M0 = 0.

use super::dual::Dual;
use super::port::{Action, DriveNumbers, Row};
use super::spec::{Class, Parameter, Port, Reducers, Spec};
use crate::units::Quantity;

/// The effect.
pub static SPEC: Spec = Spec {
    id: "bearing_play",
    class: Class::Effect,
    port: Port::Series,
    reducers: Reducers::AllByRadius,
    equation: "alpha += sgn(M0) (c/2)/(Zo e)",
    source: "geometry of a bearing with diametral clearance",
    tell_tale: "the angle steps where the torque reverses",
    parameters: &[Parameter::size("clearance", Quantity::Length, "diametral clearance c")
        .within(0.0, 1e-3)
        .likely(0.0, 20e-6)],
    twins: &[],
    action: Action::Series(act),
};

fn act(own: &[Dual], _: &Row, drive: &DriveNumbers, torque_Nm: Dual) -> Dual {
    let side = if torque_Nm.value == 0.0 { 0.0 } else { torque_Nm.value.signum() };
    own[0] * (0.5 * side / drive.pitch_arm_m)
}

#[cfg(test)]
#[allow(clippy::float_cmp)] // where nothing is rounded
mod tests {
    use super::*;
    use crate::effect::testing::{assert_close, series, vanishes};

    #[test]
    fn it_steps_where_the_torque_reverses() {
        assert_close(series(&SPEC, &[8e-6], 0.1), 4e-6 / 0.04);
        assert_close(series(&SPEC, &[8e-6], -9.0), -4e-6 / 0.04);
        assert_eq!(series(&SPEC, &[8e-6], 0.0), 0.0);
    }

    #[test]
    fn it_vanishes() {
        vanishes(&SPEC);
    }
}
