//! Permanent set of the first loading.
//!
//! alpha += set (largest |torque| so far)/(largest |torque| of the table).

use super::dual::Dual;
use super::port::{Action, DriveNumbers, Row};
use super::spec::{ARCSEC, Class, Dimension, Parameter, Port, Spec};

/// The effect.
pub static SPEC: Spec = Spec {
    id: "run_in",
    class: Class::Effect,
    port: Port::Series,
    equation: "alpha += set (largest |M| so far)/(largest |M| of the table)",
    source: "plastic flow of asperities at their first loading",
    tell_tale: "the first cycle differs from all others",
    parameters: &[Parameter::size("permanent_set", Dimension::Angle, "set after the largest torque")
        .within(-0.1, 0.1)
        .likely(0.0, 30.0 * ARCSEC)],
    twins: &[],
    action: Action::Series(act),
};

fn act(own: &[Dual], row: &Row, _: &DriveNumbers, _: Dual) -> Dual {
    own[0] * row.largest_torque_share
}

#[cfg(test)]
#[allow(clippy::float_cmp)] // where nothing is rounded
mod tests {
    use super::*;
    use crate::effect::testing::{assert_close, series, vanishes};

    /// The largest torque so far is 0.75 of the table's.
    #[test]
    fn it_sets_with_the_largest_torque_so_far() {
        assert_close(series(&SPEC, &[2e-5], 0.0), 1.5e-5);
    }

    #[test]
    fn it_vanishes() {
        vanishes(&SPEC);
    }
}
