//! Permanent set of the first loading.
//!
//! alpha += set (largest |torque| so far)/(largest |torque| of the table); so far in the table, or in each run anew where
//! every run is set up afresh; or settling by the load cycle, alpha += set (1 - exp(-c)), c the cycles done.

use super::dual::Dual;
use super::port::{Action, DriveNumbers, Row};
use super::spec::{Class, Parameter, Port, Reducers, Spec};
use crate::units::{ARCSEC, Quantity};

/// The effect.
pub static SPEC: Spec = Spec {
    id: "run_in",
    class: Class::Effect,
    port: Port::Series,
    reducers: Reducers::All,
    equation: "alpha += set (largest |M0| so far)/(largest |M0| of the table), counted over the table or over each run; or alpha += set (1 - exp(-cycles done))",
    source: "plastic flow of asperities at their first loading",
    tell_tale: "the first load cycle differs from all later ones",
    parameters: &[
        set("permanent_set", "set after the largest torque"),
        set("permanent_set_of_run", "set after the largest torque, starting again in every run"),
        set("settled", "set after many load cycles"),
    ],
    twins: &[],
    action: Action::Series(act),
};

const fn set(stem: &'static str, meaning: &'static str) -> Parameter {
    Parameter::size(stem, Quantity::Angle, meaning).within(-0.1, 0.1).likely(0.0, 30.0 * ARCSEC)
}

fn act(own: &[Dual], row: &Row, _: &DriveNumbers, _: Dual) -> Dual {
    own[0] * row.largest_torque_share
        + own[1] * row.largest_torque_share_of_run
        + own[2] * -(-row.cycles_done).exp_m1()
}

#[cfg(test)]
#[allow(clippy::float_cmp)] // where nothing is rounded
mod tests {
    use super::*;
    use crate::effect::testing::{assert_close, series, vanishes};

    /// The largest torque so far is 0.75 of the table's, in the run 0.5; two cycles are done.
    #[test]
    fn it_sets_with_the_largest_torque_so_far() {
        assert_close(series(&SPEC, &[2e-5, 0.0, 0.0], 0.0), 1.5e-5);
        assert_close(series(&SPEC, &[0.0, 2e-5, 0.0], 0.0), 1e-5);
        assert_close(series(&SPEC, &[0.0, 0.0, 2e-5], 0.0), 2e-5 * (1.0 - (-2.0_f64).exp()));
    }

    #[test]
    fn it_vanishes() {
        vanishes(&SPEC);
    }
}
