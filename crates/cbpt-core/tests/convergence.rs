//! The solver reaches its tolerance from a cold start over the whole range it promises.

use crate::common::{any_pair, preload_N};
use cbpt_core::Status;
use cbpt_core::equilibrium::solve::solve_pair;
use proptest::prelude::*;

/// Share of what the preload can hold: 0 to 99.99 %, with as many cases in the last per cent as below it.
fn share_of_hold() -> impl Strategy<Value = f64> {
    prop_oneof![
        0.0..0.99,
        (2.0..4.0_f64).prop_map(|nines| 1.0 - 10_f64.powf(-nines)),
        Just(0.0),
        Just(0.9999)
    ]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(4000))]

    #[test]
    fn every_torque_below_the_limit_is_solved(
        points in any_pair(),
        preload in preload_N(),
        share in share_of_hold(),
        negative in any::<bool>(),
    ) {
        let sign = if negative { -1.0 } else { 1.0 };
        let torque = sign * share * preload * points.holding_arm_m(sign);
        let (status, state) = solve_pair(&points, torque, preload);
        prop_assert!(status.has_solution(), "{status:?} at share {share}");
        let state = state.unwrap();
        prop_assert!(state.residual <= 1e-11, "{}", state.residual);
        prop_assert!(state.steps <= 60, "{} steps at share {share}", state.steps);
    }

    #[test]
    fn every_torque_beyond_the_limit_is_refused_with_the_preload_that_holds(
        points in any_pair(),
        preload in preload_N(),
        beyond in prop_oneof![Just(1.0), 1.0..1000.0],
        negative in any::<bool>(),
    ) {
        let sign = if negative { -1.0 } else { 1.0 };
        // One unit in the last place above the product, which may itself round below the limit.
        let torque = sign * (beyond * preload * points.holding_arm_m(sign)).next_up();
        prop_assume!(points.holding_arm_m(sign) > 0.0);
        let (status, state) = solve_pair(&points, torque, preload);
        prop_assert!(state.is_none());
        let Status::BeyondHold { hold_preload_N } = status else { panic!("{status:?}") };
        prop_assert!((hold_preload_N / (beyond * preload) - 1.0).abs() < 1e-12);
        let (status, _) = solve_pair(&points, torque, hold_preload_N * 1.001);
        prop_assert!(status.has_solution(), "{status:?}");
    }
}
