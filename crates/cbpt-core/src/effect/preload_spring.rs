//! A preload that falls as the plates move apart.
//!
//! N_Z -> N_Z - k_c (d - d0) at each pair by its own approach d; d0 is that without torque.

use super::dual::Dual;
use super::port::{Action, Load, Row};
use super::spec::{Class, Parameter, Port, Reducers, Spec};
use crate::units::Quantity;

/// The effect.
pub static SPEC: Spec = Spec {
    id: "preload_spring",
    class: Class::Effect,
    port: Port::Load,
    reducers: Reducers::BallDrives,
    equation: "N_Z -> N_Z - k_c (d - d0), where d is the axial approach of each pair and d0 the approach without torque",
    source: "elasticity of the clearance mediation mechanism",
    tell_tale: "the bend of the torque-angle curve at the onset of contact loss is weaker",
    parameters: &[Parameter::size(
        "spring_rate",
        Quantity::ForcePerLength,
        "stiffness k_c of the mechanism that applies the preload",
    )
    .within(0.0, 1e12)
    .likely(0.0, 2e9)],
    twins: &[],
    action: Action::Load(act),
};

fn act(own: &[Dual], _: &Row, load: &mut Load) {
    load.spring_N_per_m += own[0];
}

#[cfg(test)]
#[allow(clippy::float_cmp)] // where nothing is rounded
mod tests {
    use super::*;
    use crate::effect::testing::{load, vanishes};

    #[test]
    fn it_sets_the_axial_spring() {
        assert_eq!(load(&SPEC, &[2e8]).spring_N_per_m.value, 2e8);
    }

    #[test]
    fn it_vanishes() {
        vanishes(&SPEC);
    }
}
