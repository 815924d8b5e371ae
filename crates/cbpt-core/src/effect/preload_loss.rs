//! Preload held back on its way to the meshing points.
//!
//! N_Z -> (1 - eta) N_Z: wedging of the balls along the axis alone can hold back about mu cot(beta).

use super::dual::Dual;
use super::port::{Action, Load, Row};
use super::spec::{Class, Dimension, Parameter, Port, Reducers, Spec};

/// The effect.
pub static SPEC: Spec = Spec {
    id: "preload_loss",
    class: Class::Effect,
    port: Port::Load,
    reducers: Reducers::BallDrives,
    equation: "N_Z -> (1 - eta) N_Z",
    source: "Coulomb friction in the axial guide",
    tell_tale: "looks like a lower preload",
    parameters: &[Parameter::size(
        "lost_share",
        Dimension::Number,
        "share eta of the preload that is held back",
    )
    .within(0.0, 0.99)
    .likely(0.0, 0.6)],
    twins: &["preload_scale", "torque_scale", "contact_angle"],
    action: Action::Load(act),
};

fn act(own: &[Dual], _: &Row, load: &mut Load) {
    load.preload_N *= -own[0] + 1.0;
}

#[cfg(test)]
#[allow(clippy::float_cmp)] // where nothing is rounded
mod tests {
    use super::*;
    use crate::effect::testing::{ROW, assert_close, load, vanishes};

    #[test]
    fn it_takes_its_share_of_the_preload() {
        assert_close(load(&SPEC, &[0.25]).preload_N.value, 0.75 * ROW.preload_N);
    }

    #[test]
    fn it_vanishes() {
        vanishes(&SPEC);
    }
}
