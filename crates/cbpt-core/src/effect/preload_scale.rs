//! Gain of the preload readings.
//!
//! N_Z = g times the reading, before anything else acts.

use super::dual::Dual;
use super::port::{Action, Load, Row};
use super::spec::{Class, Parameter, Port, Reducers, Spec};

/// The effect.
pub static SPEC: Spec = Spec {
    id: "preload_scale",
    class: Class::Rig,
    port: Port::Reading,
    reducers: Reducers::BallDrives,
    equation: "N_Z = g N_read",
    source: "calibration of the preload sensor",
    tell_tale: "the onset of contact loss moves to another torque; the readings cannot tell it from a preload_loss without lost_force",
    parameters: &[Parameter::gain("preload_gain", "true preload divided by the reading")
        .within(0.1, 10.0)
        .likely(0.7, 1.4)],
    twins: &["preload_loss", "torque_scale", "contact_angle"],
    action: Action::Load(act),
};

fn act(own: &[Dual], _: &Row, load: &mut Load) {
    load.preload_N *= own[0];
}

#[cfg(test)]
#[allow(clippy::float_cmp)] // where nothing is rounded
mod tests {
    use super::*;
    use crate::effect::testing::{ROW, assert_close, load, vanishes};

    #[test]
    fn it_scales_the_preload() {
        assert_close(load(&SPEC, &[0.9]).preload_N.value, 0.9 * ROW.preload_N);
    }

    #[test]
    fn it_vanishes() {
        vanishes(&SPEC);
    }
}
