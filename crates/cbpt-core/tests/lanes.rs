//! Loads side by side in lanes against the scalar solver: same statuses, same angles.

use crate::common;
use crate::common::{any_pair, config, effects_up_to, preload_N};
use cbpt_core::equilibrium::lanes::nearby::SideBySide;
use cbpt_core::equilibrium::lanes::{BATCH, LaneOutcome, LanePair, two_thirds_powers};
use cbpt_core::equilibrium::ready::Changes;
use cbpt_core::equilibrium::response::{Asked, Response, respond};
use cbpt_core::equilibrium::solve::solve_pair;
use cbpt_core::equilibrium::{PairEquilibrium, ReadyPair};
use cbpt_core::pair::MeshingPoints;
use nalgebra::SVector;
use proptest::prelude::*;

/// Share of what the preload can hold, of either sign: 0 to 99.99 %, and beyond.
fn share_of_hold() -> impl Strategy<Value = f64> {
    let below = prop_oneof![
        4 => 0.0..0.99,
        4 => (2.0..4.0_f64).prop_map(|nines| 1.0 - 10_f64.powf(-nines)),
        1 => Just(0.0),
        1 => Just(0.9999),
        1 => 1.0..3.0,
    ];
    (below, any::<bool>()).prop_map(|(share, negative): (f64, bool)| if negative { -share } else { share })
}

fn loads(most: usize) -> impl Strategy<Value = Vec<(f64, f64)>> {
    proptest::collection::vec((share_of_hold(), preload_N()), 1..most)
}

/// Torques and preloads from shares of what holds.
fn columns(points: &MeshingPoints, loads: &[(f64, f64)]) -> (Vec<f64>, Vec<f64>) {
    loads.iter().map(|&(share, preload)| (common::torque_Nm(points, preload, share), preload)).unzip()
}

fn solve(pair: &LanePair, torque_Nm: &[f64], preload_N: &[f64]) -> Vec<LaneOutcome> {
    let mut outcomes = vec![LaneOutcome::NONE; torque_Nm.len()];
    let mut powers = [1.0; BATCH];
    for ((torque, preload), found) in
        torque_Nm.chunks(BATCH).zip(preload_N.chunks(BATCH)).zip(outcomes.chunks_mut(BATCH))
    {
        two_thirds_powers(preload, &mut powers);
        pair.solve(torque, preload, &powers, found);
    }
    outcomes
}

/// The same status, and the same rotation to 1e-10 of it or of what the approach would turn.
fn agree(points: &MeshingPoints, load: (f64, f64), found: &LaneOutcome) -> Result<(), TestCaseError> {
    let (status, alone) = solve_pair(points, load.0, load.1);
    prop_assert_eq!(found.status, status);
    let Some(alone) = alone else { return Ok(()) };
    let ready = ReadyPair::new(points);
    let equations = PairEquilibrium::new(&ready, load.0, load.1, None).unwrap();
    let scale = equations.state(&SVector::from([1.0, 1.0])).rotation_rad;
    let difference = (found.rotation_rad - alone.state.rotation_rad).abs();
    let allowed = 1e-10 * alone.state.rotation_rad.abs().max(scale);
    prop_assert!(difference <= allowed, "{} {}", found.rotation_rad, alone.state.rotation_rad);
    prop_assert!(found.residual <= 1e-11, "{}", found.residual);
    Ok(())
}

/// All that is said of a solved load, lengths and forces in the sizes of the problem, so that it may be compared.
fn answers(response: &Response, [turn_rad, preload_N, arm_m]: [f64; 3]) -> [f64; 6] {
    let slopes = &response.rotation;
    [
        slopes.torque * preload_N * arm_m / turn_rad,
        slopes.preload * preload_N / turn_rad,
        slopes.sideways * preload_N / turn_rad,
        slopes.log_stiffness / turn_rad,
        slopes.contact_angle / turn_rad,
        response.state.sideways_m / turn_rad / arm_m,
    ]
}

proptest! {
    #![proptest_config(config(100))]

    /// Loads one after the other, each from the one before: what is solved in lanes answers as the scalar solver has it.
    #[test]
    fn lanes_answer_as_the_scalar_solver(points in any_pair(), loads in loads(12), scale in 0.3..3.0_f64) {
        let turned: Vec<f64> = (0..points.points.points.len()).map(|place| (place as f64).sin()).collect();
        let plain = ReadyPair::new(&points);
        let contacts = SideBySide::new(&plain, &turned);
        let pair = plain.changed(&Changes {
            stiffness_scale: scale, exponent: 1.5, axial_spring_N_per_m: 0.0, gaps: &[],
        });
        let by_contact = pair.by_contact(&turned);
        let asked = Asked { stiffness_slopes_per_rad: Some(&by_contact), stiffness: true, ..Asked::default() };
        let lanes = contacts.of(&pair);
        let mut near = None;
        for (torque, preload) in std::iter::zip(columns(&points, &loads).0, columns(&points, &loads).1) {
            let exact = respond(&pair, [torque, preload], [None; 2], asked);
            let found = lanes.as_ref().and_then(|lanes| lanes.respond(&pair, [torque, preload], near.as_ref(), true));
            // The scalar solver takes what is left; that must be little.
            let easy = torque.abs() < 0.9 * preload * pair.holding_arm_m(torque) && exact.is_ok();
            prop_assert!(found.is_some() || !easy, "{torque} N m, {preload} N: {exact:?}");
            let Some((found, place)) = found else { continue };
            let exact = exact.expect("solved in lanes");
            prop_assert_eq!(found.status, exact.status);
            prop_assert!(found.residual <= 1e-11, "{}", found.residual);
            let equations = PairEquilibrium::new(&pair, torque, preload, None).unwrap();
            let turn_rad = equations.state(&SVector::from([1.0, 1.0])).rotation_rad;
            let allowed = 1e-10 * exact.state.rotation_rad.abs().max(turn_rad);
            let difference = (found.state.rotation_rad - exact.state.rotation_rad).abs();
            prop_assert!(difference <= allowed, "{} {}", found.state.rotation_rad, exact.state.rotation_rad);
            let sizes = [turn_rad, preload, pair.holding_arm_m(1.0)];
            for (found, exact) in answers(&found, sizes).iter().zip(answers(&exact, sizes)) {
                prop_assert!((found - exact).abs() <= 1e-7 * exact.abs().max(1.0), "{found} {exact}");
            }
            prop_assert_eq!((found.carrying, found.parted), (exact.carrying, exact.parted));
            let again = lanes.as_ref().and_then(|lanes| lanes.respond(&pair, [torque, preload], Some(&place), false));
            let again = again.expect("solved from its solution").0.state.rotation_rad;
            if easy {
                prop_assert_eq!(again.to_bits(), found.state.rotation_rad.to_bits());
            }
            near = Some(place);
        }
    }

    /// What is not homogeneous is left to the scalar solver.
    #[test]
    fn only_homogeneous_pairs_answer_in_lanes(points in any_pair(), effects in effects_up_to(0.3, 1.0)) {
        let ready = ReadyPair::new(&effects.on(&points, 100.0));
        let nominal = effects.on(&points, 100.0) == *points;
        prop_assert_eq!(SideBySide::new(&ready, &[]).of(&ready).is_some(), nominal);
    }

    /// Few loads start cold, many on the curve, a single one has contacts in the lanes; all end where the scalar solver does.
    #[test]
    fn lanes_agree_with_the_scalar_solver(points in any_pair(), loads in loads(20), kind in 0..3) {
        let (torque, preload) = columns(&points, &loads);
        let pair = match kind {
            0 => LanePair::for_one(&points),
            1 => LanePair::new(&points, loads.len()),
            _ => LanePair::new(&points, 100_000),
        };
        for (found, load) in solve(&pair, &torque, &preload).iter().zip(torque.into_iter().zip(preload)) {
            agree(&points, load, found)?;
        }
    }

    /// To the last bit: a load alone, and the same load anywhere among others.
    #[test]
    fn a_load_does_not_see_its_neighbours(points in any_pair(), loads in loads(300), many in any::<bool>()) {
        let (torque, preload) = columns(&points, &loads);
        let pair = LanePair::new(&points, if many { 5_000 } else { 1 });
        let together = solve(&pair, &torque, &preload);
        for ((torque, preload), found) in torque.iter().zip(&preload).zip(&together) {
            let alone = solve(&pair, &[*torque], &[*preload])[0];
            prop_assert_eq!(alone.status, found.status);
            prop_assert_eq!(alone.rotation_rad.to_bits(), found.rotation_rad.to_bits());
            prop_assert_eq!((alone.steps, alone.residual.to_bits()), (found.steps, found.residual.to_bits()));
        }
    }

    /// Offsets, springs and other exponents are not homogeneous; they are solved all the same.
    #[test]
    fn what_is_not_homogeneous_is_solved_too(
        points in any_pair(), effects in effects_up_to(0.3, 1.0), loads in loads(6), preload in preload_N(),
    ) {
        let changed = effects.on(&points, preload);
        let loads: Vec<_> = loads.into_iter().map(|(share, _)| (share.clamp(-0.5, 0.5), preload)).collect();
        let (torque, preload) = columns(&points, &loads);
        for pair in [LanePair::new(&changed, loads.len()), LanePair::for_one(&changed)] {
        for (found, (&torque, &preload)) in solve(&pair, &torque, &preload).iter().zip(torque.iter().zip(&preload)) {
            agree(&changed, (torque, preload), found)?;
        }
        }
    }

    #[test]
    fn powers_are_those_of_the_library(log in -300.0..300.0_f64) {
        let x = 10_f64.powf(log);
        let mut power = [0.0];
        two_thirds_powers(&[x], &mut power);
        let expected = x.cbrt().powi(2);
        prop_assert!((power[0] / expected - 1.0).abs() <= 1e-15, "{} {expected}", power[0]);
    }
}

/// The count of steps is what the speed hangs on, and the same on every machine: one pass where many loads share a pair,
/// five from the cold start; hardly more up to 99.9 % of what holds.
#[test]
fn steps_stay_few() {
    let points = cbpt_core::Drive::paper_base_case().points(0.1).deceleration;
    let hold = points.holding_arm_m(1.0);
    let count = 10_000;
    let along = |from: f64, to: f64, i: usize| from + (to - from) * (i as f64 / count as f64);
    for (many, from, to, mean, most) in
        [(true, 0.0, 0.35, 1.01, 2), (true, 0.4, 0.999, 1.7, 6), (false, 0.0, 0.35, 5.0, 5)]
    {
        let preload: Vec<f64> = (0..count).map(|i| 300.0 + (i % 600) as f64).collect();
        let torque: Vec<f64> = (0..count).map(|i| along(from, to, i) * hold * preload[i]).collect();
        let pair = LanePair::new(&points, if many { 100_000 } else { 1 });
        let found = solve(&pair, &torque, &preload);
        assert!(found.iter().all(|outcome| outcome.status.has_solution()));
        let steps: Vec<u32> = found.iter().map(|outcome| outcome.steps).collect();
        let sum: u32 = steps.iter().sum();
        assert!(f64::from(sum) <= mean * count as f64, "{from} to {to}: {sum} steps");
        assert!(steps.iter().all(|&steps| steps <= most), "{from} to {to}: {:?}", steps.iter().max());
    }
}

/// Walls missing on one side, all of them, no load at all, and numbers that are none: a status, never a panic.
#[test]
fn odd_input_ends_in_a_status() {
    let mut points = cbpt_core::Drive::paper_base_case().points(0.1).deceleration;
    let torque = [0.0, -0.0, 1.0, -1.0, f64::NAN, f64::INFINITY, 1.0, 1e-30];
    let preload = [600.0, 600.0, 600.0, 600.0, 600.0, 600.0, f64::INFINITY, 1e-20];
    for missing in 0..3 {
        for point in &mut points.points {
            let sign = point.signed_arm_m();
            if (missing == 1 && sign > 0.0) || missing == 2 {
                point.stiffness = 0.0;
            }
        }
        for pair in [LanePair::for_one(&points), LanePair::new(&points, 1), LanePair::new(&points, 100_000)] {
            let found = solve(&pair, &torque, &preload);
            for (i, outcome) in found.iter().enumerate() {
                let (status, _) = solve_pair(&points, torque[i], preload[i]);
                assert_eq!(outcome.status.name(), status.name(), "{} N m, {} N", torque[i], preload[i]);
                assert_eq!(outcome.rotation_rad.is_finite(), status.has_solution());
            }
        }
    }
    assert!(solve(&LanePair::new(&points, 0), &[], &[]).is_empty());
}
