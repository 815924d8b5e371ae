//! Permanent set of the first loading, and settling over the load cycles.
//!
//! alpha += set (largest |torque| so far)/(largest |torque| of the table); so far in the table, or in each run anew where
//! every run is set up afresh; or alpha += set (1 - exp(-c/c0)), c the cycles done (the runs, where no cycle was counted). Each set
//! has the sign of the load that made it. Order is that of time.

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
    equation: "alpha += set (largest |M0| so far)/(largest |M0| of the table), counted over the table or over each run; or alpha += set (1 - exp(-c/c0)), where c is the number of cycles done",
    source: "plastic flow of asperities at their first loading; decay of its increments over the cycles: Merwin and Johnson, Proc. IMechE 177 (1963) 676",
    tell_tale: "the first load cycle differs from all later ones",
    parameters: &[
        set("permanent_set", "set after the largest torque"),
        set("permanent_set_of_run", "set after the largest torque, starting again in every run"),
        set("settled", "set after many load cycles, or runs where no cycle is counted"),
        Parameter::shape(
            "settling_cycles",
            Quantity::Number,
            1.0,
            "number of cycles c0 over which it settles",
        )
        .within(1e-3, 1e6)
        .likely(0.3, 30.0)
        .log(),
    ],
    twins: &[],
    action: Action::Series(act),
};

const fn set(stem: &'static str, meaning: &'static str) -> Parameter {
    Parameter::size(stem, Quantity::Angle, meaning).within(-0.1, 0.1).likely(-30.0 * ARCSEC, 30.0 * ARCSEC)
}

fn act(own: &[Dual], row: &Row, _: &DriveNumbers, _: Dual) -> Dual {
    own[0] * row.largest_torque_share
        + own[1] * row.largest_torque_share_of_run
        + own[2] * own[3].settled(row.cycles_done)
}

#[cfg(test)]
#[allow(clippy::float_cmp)] // where nothing is rounded
mod tests {
    use super::*;
    use crate::effect::testing::{assert_close, series, vanishes};

    /// The largest torque so far is 0.75 of the table's, in the run 0.5; two cycles are done.
    #[test]
    fn it_sets_with_the_largest_torque_so_far() {
        assert_close(series(&SPEC, &[2e-5, 0.0, 0.0, 1.0], 0.0), 1.5e-5);
        assert_close(series(&SPEC, &[0.0, 2e-5, 0.0, 1.0], 0.0), 1e-5);
        assert_close(series(&SPEC, &[0.0, 0.0, 2e-5, 1.0], 0.0), 2e-5 * (1.0 - (-2.0_f64).exp()));
        assert_close(series(&SPEC, &[0.0, 0.0, -2e-5, 4.0], 0.0), -2e-5 * (1.0 - (-0.5_f64).exp()));
    }

    #[test]
    fn it_vanishes() {
        vanishes(&SPEC);
    }
}
