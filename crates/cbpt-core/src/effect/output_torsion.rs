//! Torsion of the output shaft or of a joint behind it.
//!
//! alpha += c M0, c = 1/k_t.

use super::dual::Dual;
use super::port::{Action, DriveNumbers, Row};
use super::spec::{Class, Parameter, Port, Reducers, Spec};
use crate::units::Quantity;

/// The effect.
pub static SPEC: Spec = Spec {
    id: "output_torsion",
    class: Class::Effect,
    port: Port::Series,
    reducers: Reducers::All,
    equation: "alpha += M0/k_t",
    source: "torsion of an elastic shaft",
    tell_tale: "the residual is proportional to torque, does not depend on preload and has no loop",
    parameters: &[Parameter::size("compliance", Quantity::AnglePerTorque, "torsional compliance 1/k_t")
        .within(0.0, 1.0)
        .likely(1e-7, 1e-4)
        .log()],
    twins: &[],
    action: Action::Series(act),
};

fn act(own: &[Dual], _: &Row, _: &DriveNumbers, torque_Nm: Dual) -> Dual {
    own[0] * torque_Nm
}

#[cfg(test)]
#[allow(clippy::float_cmp)] // where nothing is rounded
mod tests {
    use super::*;
    use crate::effect::testing::{assert_close, series, vanishes};

    #[test]
    fn it_is_linear_in_torque() {
        assert_close(series(&SPEC, &[1e-6], -3.0), -3e-6);
    }

    #[test]
    fn it_vanishes() {
        vanishes(&SPEC);
    }
}
