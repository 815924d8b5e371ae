//! Crosstalk from the torque to the preload.
//!
//! N_Z = N_read + F M_read/M_ref: a preload sensor that feels the torque, or an axial force that grows with it.

use super::dual::Dual;
use super::port::{Action, Load, Row};
use super::spec::{Class, Parameter, Port, Reducers, Spec};
use crate::units::Quantity;

/// The effect.
pub static SPEC: Spec = Spec {
    id: "preload_crosstalk",
    class: Class::Rig,
    port: Port::Reading,
    reducers: Reducers::BallDrives,
    equation: "N_Z = N_read + F M_read/M_ref",
    source: "crosstalk as data sheets of multi-axis load cells state it",
    tell_tale: "the drive is softer under a torque of one sign, the more the larger the torque is",
    parameters: &[
        Parameter::size("crosstalk_force", Quantity::Force, "force F by which the preload is off at M_ref")
            .within(-1e6, 1e6)
            .likely(-200.0, 200.0),
        Parameter::shape("reference_torque", Quantity::Torque, 1.0, "torque M_ref of the force")
            .within(1e-6, 1e6)
            .likely(0.1, 100.0)
            .log(),
    ],
    twins: &[],
    action: Action::Load(act),
};

fn act(own: &[Dual], row: &Row, load: &mut Load) {
    load.preload_N += own[0].quotient(&own[1]) * row.torque_Nm;
}

#[cfg(test)]
#[allow(clippy::float_cmp)] // where nothing is rounded
mod tests {
    use super::*;
    use crate::effect::testing::{ROW, assert_close, load, vanishes};

    #[test]
    fn the_torque_changes_the_preload() {
        let preload = load(&SPEC, &[-20.0, 4.0]).preload_N.value;
        assert_close(preload, ROW.preload_N - 5.0 * ROW.torque_Nm);
    }

    #[test]
    fn it_vanishes() {
        vanishes(&SPEC);
    }
}
