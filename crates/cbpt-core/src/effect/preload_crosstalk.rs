//! Crosstalk from the torque to the preload.
//!
//! N_Z = N_read + (F + s N_read) M_read/M_ref: a preload sensor that feels the torque, or an axial force that grows with it (F); a
//! screw or a guide that the torque turns, and with it what it presses with (s).

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
    equation: "N_Z = N_read + (F + s N_read) M_read/M_ref",
    source: "crosstalk as data sheets of multi-axis load cells state it",
    tell_tale: "the drive is softer under a torque of one sign, the more the larger the torque is",
    parameters: &[
        Parameter::size("crosstalk_force", Quantity::Force, "force F by which the preload is off at M_ref")
            .within(-1e6, 1e6)
            .likely(-200.0, 200.0),
        Parameter::size(
            "crosstalk_share",
            Quantity::Number,
            "share s of the preload by which it is off at M_ref",
        )
        .within(-10.0, 10.0)
        .likely(-0.3, 0.3),
        Parameter::shape("reference_torque", Quantity::Torque, 1.0, "torque M_ref of force and share")
            .within(1e-6, 1e6)
            .likely(0.1, 100.0)
            .log(),
    ],
    twins: &[],
    action: Action::Load(act),
};

fn act(own: &[Dual], row: &Row, load: &mut Load) {
    let [force, share, reference] = [&own[0], &own[1], &own[2]];
    let mut off = *force;
    off.add_product(1.0, share, &load.preload_N);
    load.preload_N += off.quotient(reference) * row.torque_Nm;
}

#[cfg(test)]
#[allow(clippy::float_cmp)] // where nothing is rounded
mod tests {
    use super::*;
    use crate::effect::testing::{ROW, assert_close, load, vanishes};

    #[test]
    fn the_torque_changes_the_preload() {
        let preload = |own: &[f64]| load(&SPEC, own).preload_N.value;
        assert_close(preload(&[-20.0, 0.0, 4.0]), ROW.preload_N - 5.0 * ROW.torque_Nm);
        assert_close(preload(&[0.0, 0.1, 4.0]), ROW.preload_N * (1.0 + 0.025 * ROW.torque_Nm));
    }

    #[test]
    fn it_vanishes() {
        vanishes(&SPEC);
    }
}
