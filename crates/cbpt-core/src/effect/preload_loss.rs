//! Part of the preload does not reach the meshing points.
//!
//! N_Z -> (1 - eta) N_Z - F, the friction of an axial guide by the law of two terms: one is proportional to the preload, the other does
//! not depend on it. Wedging of the balls along the axis alone can hold back about mu cot(beta); F is the drag of
//! a seal or the pull of a return spring. The less the preload, the larger the share that F takes. At F = 0 the loss is a
//! constant share.

use super::dual::Dual;
use super::port::{Action, Load, Row};
use super::spec::{Class, Parameter, Port, Reducers, Spec};
use crate::units::Quantity;

/// The effect.
pub static SPEC: Spec = Spec {
    id: "preload_loss",
    class: Class::Effect,
    port: Port::Load,
    reducers: Reducers::BallDrives,
    equation: "N_Z -> (1 - eta) N_Z - F",
    source: "friction of two terms in the axial guide: Coulomb (1785); Derjaguin, Z. Phys. 88 (1934) 661",
    tell_tale: "the readings look as if the preload were lower; with F, mainly at low preload",
    parameters: &[
        Parameter::size(
            "lost_share",
            Quantity::Number,
            "share eta of the preload that does not reach the meshing points",
        )
        .within(0.0, 0.99)
        .likely(0.0, 0.6),
        Parameter::size(
            "lost_force",
            Quantity::Force,
            "force F that does not reach the meshing points, at any preload",
        )
        .within(0.0, 1e6)
        .likely(0.0, 500.0)
        .without_twin(),
    ],
    twins: &["preload_scale", "torque_scale", "contact_angle"],
    action: Action::Load(act),
};

fn act(own: &[Dual], _: &Row, load: &mut Load) {
    load.preload_N = load.preload_N * (-own[0] + 1.0) - own[1];
}

#[cfg(test)]
#[allow(clippy::float_cmp)] // where nothing is rounded
mod tests {
    use super::*;
    use crate::effect::testing::{ROW, assert_close, load, vanishes};

    #[test]
    fn it_takes_its_share_of_the_preload() {
        assert_close(load(&SPEC, &[0.25, 0.0]).preload_N.value, 0.75 * ROW.preload_N);
    }

    #[test]
    fn it_takes_a_force_beside_it() {
        assert_close(load(&SPEC, &[0.0, 40.0]).preload_N.value, ROW.preload_N - 40.0);
        assert_close(load(&SPEC, &[0.25, 40.0]).preload_N.value, 0.75 * ROW.preload_N - 40.0);
    }

    #[test]
    fn it_vanishes() {
        vanishes(&SPEC);
    }
}
