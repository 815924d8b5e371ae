//! Proved solutions: interval arithmetic, solutions that are known exactly, random drives.
//!
//! `cargo test --release -p cbpt-core --test mechanics -- --ignored --nocapture` proves 100,000 drives and tells widths and times.

use crate::common;
use crate::common::{any_drive, any_pair, config, drive_holding_arm_m, effects_up_to, preload_N};
use cbpt_core::Load;
use cbpt_core::equilibrium::proof::enclose_pair;
use cbpt_core::equilibrium::solve::solve_pair;
use cbpt_core::interval::Interval;
use cbpt_core::pair::{Diagonal, MeshingPoint, MeshingPoints};
use proptest::prelude::*;
use proptest::strategy::ValueTree;
use proptest::test_runner::TestRunner;
use std::time::Instant;

/// A number of any size and sign.
fn number() -> impl Strategy<Value = f64> {
    prop_oneof![
        (-1.0..1.0_f64, -40..40_i32).prop_map(|(value, power)| value * 10_f64.powi(power)),
        Just(0.0),
        Just(1.0),
        Just(f64::MAX),
        Just(f64::MIN_POSITIVE),
    ]
}

fn interval() -> impl Strategy<Value = Interval> {
    (number(), number()).prop_map(|(a, b)| Interval::new(a.min(b), a.max(b)))
}

/// A number of an interval, at a share of its width.
fn inside(interval: Interval, share: f64) -> f64 {
    (interval.lower() + share * (interval.upper() - interval.lower()))
        .clamp(interval.lower(), interval.upper())
}

proptest! {
    #![proptest_config(config(20_000))]

    /// The rounding error of a sum (Knuth's two-sum) and of a product (by a fused multiply-add) is itself a number, so
    /// whether the exact result lies between the bounds can be asked exactly.
    #[test]
    fn bounds_enclose_exact_results(a in number(), b in number()) {
        let sum = Interval::from(a) + Interval::from(b);
        let rounded = a + b;
        if rounded.is_finite() {
            let virtual_b = rounded - a;
            let error = (a - (rounded - virtual_b)) + (b - virtual_b);
            // Lower - rounded is a unit or none, so these differences are exact.
            prop_assert!(sum.lower() - rounded <= error && error <= sum.upper() - rounded);
            prop_assert!(sum.lower() < sum.upper());
        }
        let product = Interval::from(a) * Interval::from(b);
        let rounded = a * b;
        if rounded.is_finite() && rounded.abs() > 1e-280 {
            let error = a.mul_add(b, -rounded);
            prop_assert!(product.lower() - rounded <= error && error <= product.upper() - rounded);
        }
        let root = Interval::from(a.abs()).sqrt();
        if a.abs() > 1e-280 && a.abs() < 1e300 {
            prop_assert!(root.lower().mul_add(root.lower(), -a.abs()) <= 0.0);
            prop_assert!(root.upper().mul_add(root.upper(), -a.abs()) >= 0.0);
        }
    }

    /// Operations enclose what they give for every number of their operands.
    #[test]
    fn operations_hold_all_results(
        (x, y) in (interval(), interval()), (s, t) in (0.0..=1.0_f64, 0.0..=1.0_f64), n in 0.2..3.0_f64,
    ) {
        let (a, b) = (inside(x, s), inside(y, t));
        for (found, value) in [(x + y, a + b), (x - y, a - b), (x * y, a * b), (-x, -a)] {
            prop_assert!(found.contains(value) || (!value.is_finite() && !found.is_finite()), "{found:?} {value}");
        }
        let (positive, c) = (x.at_least_0(), a.max(0.0));
        prop_assert!(positive.contains(c) && positive.sqrt().contains(c.sqrt()));
        let power = positive.powf(n);
        prop_assert!(power.contains(c.powf(n)) || !power.is_finite());
        prop_assert!(x.with_0().contains(0.0) && x.with_0().contains(a));
        if let Some(common) = x.common(y) {
            prop_assert!(!common.contains(a) || (x.contains(a) && y.contains(a)));
        } else {
            prop_assert!(!y.contains(a) && !x.contains(b));
        }
        prop_assert!(!x.is_inside(x));
    }
}

#[test]
fn what_overflows_or_is_no_number_proves_nothing() {
    let most = Interval::from(f64::MAX);
    for entire in [most + most, most * most, Interval::from(f64::NAN), Interval::new(1.0, 0.0)] {
        assert_eq!(entire, Interval::ENTIRE);
        assert_eq!(entire * Interval::ZERO, Interval::ENTIRE);
        assert_eq!(entire + Interval::ZERO, Interval::ENTIRE);
        assert_eq!(entire.sqrt(), Interval::ENTIRE);
        assert!(!entire.is_inside(Interval::ENTIRE));
    }
}

/// A diagonal with sine and cosine 1/2, which are exact in binary, arm and stiffness.
fn point(diagonal: Diagonal, arm_m: f64, stiffness: f64) -> MeshingPoint {
    MeshingPoint { stiffness, ..MeshingPoint::new(0, diagonal, arm_m, [0.5, 0.5], [0.0; 2], [0.0, 1.0]) }
}

proptest! {
    #![proptest_config(config(2000))]

    /// Deformations that are squares of whole numbers press with cubes, so loads made of them have a solution that is
    /// known without rounding. The enclosures must hold it.
    #[test]
    fn solutions_that_are_known_exactly_are_enclosed(
        roots in (1_u8..40, 1_u8..40), arms in (1_u8..9, 1_u8..9), parted in any::<bool>(),
    ) {
        let [p, q] = [roots.0, roots.1].map(f64::from);
        let [a, b] = [arms.0, arms.1].map(f64::from);
        // 0.5 d + 0.5 a alpha = p^2 and 0.5 d - 0.5 b alpha = q^2.
        let rotation = 2.0 * (p * p - q * q) / (a + b);
        let approach = 2.0 * p * p - a * rotation;
        prop_assume!((rotation * 1024.0).fract() == 0.0);
        let mut points = vec![point(Diagonal::Plus, a, 1.0), point(Diagonal::Minus, b, 1.0)];
        // A third diagonal whose offset keeps it off by 1, or no third.
        if parted {
            let mut third = point(Diagonal::Plus, 0.5, 3.0);
            third.normal_offset_m = -(0.5 * approach + 0.25 * rotation) - 1.0;
            points.push(third);
        }
        let points = MeshingPoints::new(points, 1e9);
        let (preload, torque) = (0.5 * (p.powi(3) + q.powi(3)), 0.5 * (a * p.powi(3) - b * q.powi(3)));
        let found = enclose_pair(&points, Interval::from(torque), preload).unwrap();
        prop_assert!(found.rotation_rad.contains(rotation), "{rotation} is not in {:?}", found.rotation_rad);
        prop_assert!(found.approach_m.contains(approach), "{approach} is not in {:?}", found.approach_m);
        prop_assert!(found.rotation_rad.width() <= 1e-12 * (rotation.abs() + approach));
    }

    #[test]
    fn pairs_with_effects_are_enclosed(
        points in any_pair(), preload in preload_N(), share in -0.99..0.99_f64, effects in effects_up_to(0.5, 10.0),
    ) {
        let points = effects.on(&points, preload);
        let torque = common::torque_Nm(&points, preload, share);
        let (_, Some(solved)) = solve_pair(&points, torque, preload) else { return Ok(()) };
        // Gaps may leave a contact that only just touches, where the slope is that of a root at 0: then there may be no proof.
        let Some(found) = enclose_pair(&points, Interval::from(torque), preload) else { return Ok(()) };
        let close = 1e-8 * found.rotation_rad.magnitude() + 1e-6 * found.approach_m.magnitude() / 0.01;
        prop_assert!((found.rotation_rad.middle() - solved.state.rotation_rad).abs() <= close);
        let close_m = 0.01 * close + 1e-8 * found.sideways_m.magnitude();
        prop_assert!((found.sideways_m.middle() - solved.state.sideways_m).abs() <= close_m);
    }

    /// A load beyond the limit has no solution, so nothing may be proved.
    #[test]
    fn nothing_is_proved_beyond_the_limit(points in any_pair(), preload in preload_N(), beyond in 1.0..3.0_f64) {
        let torque = (beyond * preload * points.holding_arm_m(1.0)).next_up();
        prop_assert_eq!(enclose_pair(&points, Interval::from(torque), preload), None);
    }
}

/// Shares of the limit: up to 0.999, half of them in the last tenth.
fn share() -> impl Strategy<Value = f64> {
    prop_oneof![0.0..0.9, (1.0..3.0_f64).prop_map(|nines| 1.0 - 10_f64.powf(-nines)), Just(0.999)]
}

proptest! {
    #![proptest_config(config(500))]

    #[test]
    fn every_drive_is_enclosed(
        drive in any_drive(), preload in preload_N(), share in share(), negative in any::<bool>(), angle in -7.0..7.0_f64,
    ) {
        let sign = if negative { -1.0 } else { 1.0 };
        let torque = sign * share * preload * drive_holding_arm_m(&drive, angle, sign);
        let load = Load::new(torque, preload, angle).unwrap();
        let solved = drive.solve(&load).elastic_angle_rad().unwrap();
        let found = drive.enclosure(&load);
        prop_assert!(found.is_some(), "not proved at share {share}");
        let found = found.unwrap().elastic_angle_rad;
        let off = (solved - found.middle()).abs();
        prop_assert!(off <= 1e-8 * found.magnitude() + found.width(), "{solved} is not near {found:?}");
        prop_assert!(found.width() <= 1e-7 * found.magnitude().max(1e-12), "{found:?} at share {share}");
    }
}

/// What `benches/enclosures.py` puts into the documentation: how many drives are enclosed, how tightly, how fast.
#[test]
#[ignore = "100,000 drives: some minutes in release"]
#[allow(clippy::print_stdout)]
fn a_hundred_thousand_drives_are_enclosed() {
    const BELOW: [f64; 4] = [0.5, 0.9, 0.99, 0.999_000_1];
    let count: usize = std::env::var("DRIVES").map_or(100_000, |count| count.parse().unwrap());
    // Every drive that is drawn and has an undercut is a reject.
    let mut runner = TestRunner::new(ProptestConfig { max_local_rejects: u32::MAX, ..config(1) });
    let given = (any_drive(), preload_N(), share(), any::<bool>(), -7.0..7.0_f64);
    let mut groups: [Vec<[f64; 3]>; 4] = Default::default();
    for _ in 0..count {
        let (drive, preload, share, negative, angle) = given.new_tree(&mut runner).unwrap().current();
        let sign = if negative { -1.0 } else { 1.0 };
        let torque = sign * share * preload * drive_holding_arm_m(&drive, angle, sign);
        let load = Load::new(torque, preload, angle).unwrap();
        let began = Instant::now();
        let solved = drive.solve(&load);
        let solve_s = began.elapsed().as_secs_f64();
        let began = Instant::now();
        let found = drive.enclosure(&load).unwrap_or_else(|| panic!("not proved: {drive:?} {load:?}"));
        let proof_s = began.elapsed().as_secs_f64();
        let angle = found.elastic_angle_rad;
        assert!((solved.elastic_angle_rad().unwrap() - angle.middle()).abs() <= 1e-8 * angle.magnitude());
        let group = BELOW.iter().position(|below| share < *below).unwrap();
        groups[group].push([angle.width() / angle.magnitude(), proof_s, solve_s]);
    }
    let mut from = 0.0;
    for (group, below) in groups.iter().zip(BELOW) {
        let sorted = |i: usize| {
            let mut values: Vec<f64> = group.iter().map(|row| row[i]).collect();
            values.sort_by(f64::total_cmp);
            values
        };
        let (width, proof, solve) = (sorted(0), sorted(1), sorted(2));
        let (drives, middle) = (group.len(), group.len() / 2);
        let (usual, widest) = (width[middle], width[drives - 1]);
        let [proof_us, solve_us] = [proof[middle], solve[middle]].map(|seconds| 1e6 * seconds);
        // All of them: the first that is not proved ends the test.
        println!(
            "| {from:.0} to {:.1} % | {drives} | {drives} | {usual:.0e} | {widest:.0e} | {proof_us:.0} | {solve_us:.0} |",
            100.0 * below
        );
        from = 100.0 * below;
    }
}
