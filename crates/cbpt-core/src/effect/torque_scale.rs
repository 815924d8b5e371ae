//! Gain of the torque readings.
//!
//! M0 = g times the reading, before anything else acts.

use super::dual::Dual;
use super::port::{Action, Load, Row};
use super::spec::{Class, Parameter, Port, Reducers, Spec};

/// The effect.
pub static SPEC: Spec = Spec {
    id: "torque_scale",
    class: Class::Rig,
    port: Port::Reading,
    reducers: Reducers::All,
    equation: "M0 = g M_read",
    source: "calibration of the torque sensor",
    tell_tale: "the onset of contact loss moves to another torque",
    parameters: &[Parameter::gain("torque_gain", "true torque divided by the reading")
        .within(0.1, 10.0)
        .likely(0.7, 1.4)],
    twins: &["preload_scale", "preload_loss", "contact_angle"],
    action: Action::Load(act),
};

fn act(own: &[Dual], _: &Row, load: &mut Load) {
    load.torque_Nm *= own[0];
}

#[cfg(test)]
#[allow(clippy::float_cmp)] // where nothing is rounded
mod tests {
    use super::*;
    use crate::effect::testing::{ROW, assert_close, load, vanishes};

    #[test]
    fn it_scales_the_torque() {
        assert_close(load(&SPEC, &[1.1]).torque_Nm.value, 1.1 * ROW.torque_Nm);
    }

    #[test]
    fn it_vanishes() {
        vanishes(&SPEC);
    }
}
