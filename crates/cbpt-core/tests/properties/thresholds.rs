//! Thresholds of the preload.

use cbpt_core::drive::EqualSpeed;
use cbpt_core::equilibrium::solve::{PairState, solve_pair};
use cbpt_core::pair::MeshingPoints;
use cbpt_core::preload::pair_thresholds;
use cbpt_core::{Drive, Load, PreloadThresholds, Status};
use proptest::prelude::*;

use crate::common::{any_drive, any_pair, small_drive, solved};
use crate::{Checked, SAME, close, common, existing};

/// The smallest and the largest deformation of the meshing points that exist, m.
fn extreme_deformations_m(points: &MeshingPoints, state: &PairState) -> (f64, f64) {
    existing(points)
        .map(|point| state.state.deformation_m(point))
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(least, most), deformation| {
            (least.min(deformation), most.max(deformation))
        })
}

fn each_close(found: PreloadThresholds, expected: PreloadThresholds, relative: f64, what: &str) -> Checked {
    for (found, expected) in [
        (found.hold_N, expected.hold_N),
        (found.continuous_N, expected.continuous_N),
        (found.zero_backlash_N, expected.zero_backlash_N),
    ] {
        if expected.is_infinite() {
            prop_assert!(found.is_infinite(), "{what}: {found} against {expected}");
        } else {
            close(found, expected, relative * expected, what)?;
        }
    }
    Ok(())
}

proptest! {
    #![proptest_config(common::config(700))]

    /// What keeps every diagonal keeps every ball, and what keeps every ball holds.
    #[test]
    fn hold_is_below_continuous_is_below_zero_backlash(
        points in any_pair(),
        torque in -50.0..50.0_f64,
    ) {
        let found = pair_thresholds(&points, torque);
        prop_assert!(found.hold_N > 0.0 && found.hold_N.is_finite());
        prop_assert!(found.hold_N <= found.continuous_N * (1.0 + 1e-12), "{found:?}");
        prop_assert!(found.continuous_N <= found.zero_backlash_N * (1.0 + 1e-12), "{found:?}");
    }

    /// Thresholds are ratios of preload to torque: they go with the torque, not with the stiffness of the contacts.
    #[test]
    fn thresholds_go_with_the_torque(
        points in any_pair(),
        torque in 0.01..50.0_f64,
        factor in 0.01..100.0_f64,
        exponent in prop_oneof![Just(1.5), 1.2..3.0_f64],
    ) {
        let mirrored = MeshingPoints { exponent, ..points.pair.at(-points.phase_rad) };
        let points = MeshingPoints { exponent, ..points.points };
        let found = pair_thresholds(&points, torque);
        let times = |thresholds: PreloadThresholds, factor: f64| PreloadThresholds {
            hold_N: thresholds.hold_N * factor,
            continuous_N: thresholds.continuous_N * factor,
            zero_backlash_N: thresholds.zero_backlash_N * factor,
        };
        each_close(pair_thresholds(&points, factor * torque), times(found, factor), 1e-12, "torque")?;
        let mut stiffer = points.clone();
        for point in &mut stiffer.points {
            point.stiffness *= factor;
        }
        each_close(pair_thresholds(&stiffer, torque), found, SAME, "stiffness")?;
        each_close(pair_thresholds(&mirrored, -torque), found, SAME, "mirror image")?;
        each_close(pair_thresholds(&points, 0.0), times(found, 0.0), 0.0, "no torque")?;
    }

    /// Just above the hold threshold there is a balance, at it and below there is none.
    #[test]
    fn above_hold_is_solved_and_below_refused(
        points in any_pair(),
        torque in prop_oneof![0.01..50.0_f64, -50.0..-0.01_f64],
    ) {
        let hold = pair_thresholds(&points, torque).hold_N;
        prop_assert!(solve_pair(&points, torque, hold * (1.0 + 1.01e-4)).0.has_solution());
        for preload in [hold * (1.0 - 1e-12), 0.5 * hold] {
            let (status, state) = solve_pair(&points, torque, preload);
            prop_assert!(state.is_none());
            let Status::BeyondHold { hold_preload_N } = status else { panic!("{status:?}") };
            close(hold_preload_N, hold, 1e-12 * hold, "preload that would hold")?;
        }
    }

    /// Continuous transmission: the state d = 0, in which the torque alone loads the diagonals; with less preload the
    /// plates move apart, with more they move together.
    #[test]
    fn at_the_continuous_threshold_the_approach_is_zero(
        points in any_pair(),
        torque in prop_oneof![0.01..50.0_f64, -50.0..-0.01_f64],
        exponent in prop_oneof![Just(1.5), 1.2..3.0_f64],
    ) {
        let points = MeshingPoints { exponent, ..points.points };
        let found = pair_thresholds(&points, torque);
        // Where one ball carries all, the state d = 0 is that of the limit itself.
        prop_assume!(found.continuous_N > found.hold_N * 1.001);
        let state = |preload: f64| solved(&points, torque, preload).state;
        let at = state(found.continuous_N);
        let size = points.largest_arm_m() * at.rotation_rad.abs();
        close(at.approach_m(), 0.0, 1e-8 * size, "approach")?;
        prop_assert!(state(found.continuous_N * (1.0 - 1e-4)).approach_m() < 0.0);
        prop_assert!(state(found.continuous_N * (1.0 + 1e-4)).approach_m() > 0.0);
    }

    /// Zero backlash: the first diagonal is about to part; with less preload it has parted, with more none has.
    #[test]
    fn at_the_zero_backlash_threshold_the_first_diagonal_parts(
        points in any_pair(),
        torque in prop_oneof![0.01..50.0_f64, -50.0..-0.01_f64],
        exponent in prop_oneof![Just(1.5), 1.2..3.0_f64],
        beyond in 1.0..50.0_f64,
    ) {
        let points = MeshingPoints { exponent, ..points.points };
        let threshold = pair_thresholds(&points, torque).zero_backlash_N;
        prop_assert!(threshold.is_finite());
        let extremes = |preload: f64| extreme_deformations_m(&points, &solved(&points, torque, preload));
        let (least, most) = extremes(threshold);
        close(least, 0.0, 1e-9 * most, "smallest deformation")?;
        prop_assert!(extremes(threshold * (1.0 - 1e-6)).0 < 0.0);
        prop_assert!(extremes(threshold * (1.0 + 1e-6)).0 > 0.0);
        prop_assert!(extremes(threshold * beyond * (1.0 + 1e-6)).0 > 0.0);
    }
}

/// Mostly drives of few balls, which are soon sampled.
fn mostly_small_drive() -> impl Strategy<Value = Drive> {
    prop_oneof![7 => small_drive(), 1 => any_drive()]
}

proptest! {
    #![proptest_config(common::config(50))]

    /// The maximum over a period is reached and never exceeded; a cross-slide is the same everywhere.
    #[test]
    fn thresholds_over_a_period_are_the_largest_of_any_angle(
        drive in mostly_small_drive(),
        torque in -50.0..50.0_f64,
        angles in proptest::collection::vec(-7.0..7.0_f64, 20),
    ) {
        let most = drive.preload_thresholds(torque);
        for angle in angles {
            let here = drive.preload_thresholds_at(torque, angle);
            for (most, here) in [(most.deceleration, here.deceleration), (most.equal_speed, here.equal_speed)] {
                for (most, here) in [
                    (most.hold_N, here.hold_N),
                    (most.continuous_N, here.continuous_N),
                    (most.zero_backlash_N, here.zero_backlash_N),
                ] {
                    prop_assert!(here <= most * (1.0 + 1e-9), "{here} at {angle}, {most} at most");
                }
            }
            if matches!(drive.equal_speed(), EqualSpeed::CrossSlide(_)) {
                each_close(here.equal_speed, most.equal_speed, 0.0, "cross-slide")?;
            }
            let (both, whole) = (here.drive(), here.deceleration.max(here.equal_speed));
            each_close(both, whole, 0.0, "drive")?;
            prop_assert!(both.hold_N >= here.deceleration.hold_N && both.hold_N >= here.equal_speed.hold_N);
        }
    }

    /// A preload above the drive's hold threshold holds at every angle of the crank, one below it fails at some.
    #[test]
    fn the_hold_threshold_of_the_drive_is_that_of_its_solutions(
        drive in mostly_small_drive(),
        torque in prop_oneof![0.01..50.0_f64, -50.0..-0.01_f64],
        angle in -7.0..7.0_f64,
    ) {
        let at = drive.preload_thresholds_at(torque, angle).drive().hold_N;
        let solve = |preload: f64| drive.solve(&Load::new(torque, preload, angle).unwrap());
        let solution = solve(at * (1.0 + 1.01e-4));
        prop_assert!(solution.status.has_solution(), "{}", solution.status);
        let refused = solve(at * (1.0 - 1e-9));
        prop_assert!(refused.angles.is_none() && refused.deceleration.is_none());
        let Status::BeyondHold { hold_preload_N } = refused.status else { panic!("{}", refused.status) };
        close(hold_preload_N, at, 1e-12 * at, "preload that would hold")?;
        let anywhere = drive.preload_thresholds(torque).drive().hold_N;
        prop_assert!(solve(anywhere * (1.0 + 1.01e-4)).status.has_solution());
    }
}
