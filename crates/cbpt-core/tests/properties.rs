//! Laws of mechanics that hold for every drive, on random pairs and drives.
//!
//! - forces and resultants of one state; symmetries and scaling; monotony and stiffness; thresholds of the preload; the
//!   largest angle; effects; input that cannot be.
//!
//! Torques are drawn as a share of what the preload holds. Displacements are compared at the scale of the approach
//! under the preload alone, angles at that approach over the largest arm.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod common;

use std::f64::consts::TAU;

use cbpt_core::drive::{
    CrossSlide, CrossSlideForm, CrossSlideShare, Deceleration, EqualSpeed, OutputPlate, RingGroove,
};
use cbpt_core::equilibrium::report::{Contact, PairSolution, Role};
use cbpt_core::equilibrium::solve::{PairState, solve_pair};
use cbpt_core::pair::{Diagonal, MeshingPoint, MeshingPoints};
use cbpt_core::preload::pair_thresholds;
use cbpt_core::sweep::Progress;
use cbpt_core::{
    Angles, Drive, Elasticity, InvalidInput, Load, Material, PreloadThresholds, Status, TrackCurvature,
};
use common::{
    Effects, Pair, any_drive, any_pair, approach_scale_m, cross_slide_pair, deceleration_pair, effects,
    effects_up_to, is_loose, preload_N, ring_groove_pair, small_drive, solved, torque_Nm,
    unloaded_approach_m,
};
use proptest::prelude::*;
use proptest::test_runner::TestCaseError;

type Checked = Result<(), TestCaseError>;

/// A scaled residual within the solver's tolerance leaves this much of preload and holding torque unbalanced, with the
/// rounding of sums over 400 meshing points.
const BALANCE: f64 = 1e-10;

/// Agreement of two solutions that differ by rounding alone, away from the limit.
const SAME: f64 = 1e-9;

/// Share of the holding torque, either sign, away from the limit.
fn share() -> impl Strategy<Value = f64> {
    prop_oneof![9 => -0.95..0.95_f64, 1 => Just(0.0)]
}

/// Share of the holding torque, either sign, up to the limit.
fn share_to_the_limit() -> impl Strategy<Value = f64> {
    let close = (2.0..4.0_f64, any::<bool>()).prop_map(|(nines, negative)| {
        let share = 1.0 - 10_f64.powf(-nines);
        if negative { -share } else { share }
    });
    prop_oneof![-0.99..0.99_f64, close, Just(0.0)]
}

fn phase_rad() -> impl Strategy<Value = f64> {
    -7.0..7.0_f64
}

fn existing(points: &MeshingPoints) -> impl Iterator<Item = &MeshingPoint> {
    points.points.iter().filter(|point| point.exists())
}

/// What the solver's tolerance leaves open of an angle: little but for a plate that next to nothing turns back, rad.
fn open_rad(points: &MeshingPoints, preload_N: f64, state: &PairState) -> f64 {
    let holding = existing(points).map(|p| p.torque_per_preload_m().abs()).fold(0.0, f64::max);
    BALANCE * preload_N * holding / state.torsional_stiffness_Nm_per_rad
}

/// What an angle of a pair is compared by: its own size, or what the approach under the preload makes of an arm.
fn angle_scale(points: &MeshingPoints, preload_N: f64, angle_rad: f64) -> f64 {
    angle_rad.abs().max(approach_scale_m(points, preload_N) / points.largest_arm_m())
}

fn holds_both_ways(points: &MeshingPoints) -> bool {
    points.holding_arm_m(1.0) > 0.0 && points.holding_arm_m(-1.0) > 0.0
}

fn close(found: f64, expected: f64, allowed: f64, what: &str) -> Checked {
    prop_assert!(
        (found - expected).abs() <= allowed,
        "{what}: {found} against {expected}, {:e} off, {allowed:e} allowed",
        found - expected
    );
    Ok(())
}

// --- forces and resultants of one state ------------------------------------------------------

/// Every meshing point obeys its contact law, no contact pulls, and the forces balance preload and torque.
fn check_state(points: &MeshingPoints, torque_Nm: f64, preload_N: f64, solved: &PairState) -> Checked {
    prop_assert!(solved.residual <= 1e-11, "residual {}", solved.residual);
    let solution = PairSolution::new(points, torque_Nm, solved);
    let (mut axial, mut torque, mut sideways) = (0.0, 0.0, 0.0);
    let mut carrying = 0;
    let mut peak: f64 = 0.0;
    for (point, load) in points.points.iter().zip(&solution.points) {
        let delta = (solved.state.approach_m() + point.axial_offset_m) * point.sin_beta
            + point.normal_offset_m
            + point.diagonal.sign()
                * point.cos_beta
                * (point.arm_m * solved.state.rotation_rad
                    + point.in_plane_offset_m
                    + solved.state.sideways_m);
        let size = solved.state.approach_m().abs()
            + (points.largest_arm_m() * solved.state.rotation_rad).abs()
            + delta.abs();
        prop_assert!(load.deformation_m >= 0.0 && load.gap_m >= 0.0 && load.force_N >= 0.0);
        if point.exists() {
            close(load.deformation_m - load.gap_m, delta, 1e-12 * size, "deformation")?;
            let law = 1e-6_f64.powf(1.5 - points.exponent) * load.deformation_m.powf(points.exponent);
            close(load.force_N, point.stiffness * law, 1e-11 * load.force_N, "contact law")?;
            let apart = if load.force_N > 0.0 { load.gap_m } else { load.deformation_m };
            prop_assert!(apart <= 0.0, "either a force or a gap: {load:?}");
            let expected = if load.force_N > 0.0 { Contact::Loaded } else { Contact::Parted };
            prop_assert_eq!(load.contact, expected);
        } else {
            prop_assert!(load.force_N <= 0.0 && load.deformation_m <= 0.0);
            prop_assert_eq!(load.contact, Contact::WallMissing);
        }
        let lever = point.signed_arm_m() * torque_Nm;
        match load.role {
            Role::ForceTransmission => prop_assert!(lever > 0.0),
            Role::NonForceTransmission => prop_assert!(lever < 0.0),
            Role::Neutral => {
                prop_assert!(lever.abs() <= 1e-11 * points.largest_arm_m() * torque_Nm.abs());
            }
        }
        axial += load.force_N * point.sin_beta;
        torque += load.force_N * point.cos_beta * point.signed_arm_m();
        sideways += load.force_N * point.cos_beta * point.diagonal.sign();
        carrying += usize::from(load.force_N > 0.0);
        for wall in load.walls.iter().flatten() {
            peak = peak.max(wall.peak_pressure_Pa);
        }
    }
    let holding = existing(points).map(|p| p.torque_per_preload_m().abs()).fold(0.0, f64::max);
    let unloaded =
        if points.axial_spring_N_per_m > 0.0 { unloaded_approach_m(points, preload_N) } else { 0.0 };
    let travel = solved.state.approach_m() - unloaded;
    let at_points = preload_N - points.axial_spring_N_per_m * travel;
    // With a spring the forces may be far above the preload.
    let force =
        preload_N.max(axial) + points.axial_spring_N_per_m * (solved.state.approach_m().abs() + unloaded);
    close(axial, at_points, BALANCE * force, "axial balance")?;
    close(torque, torque_Nm, BALANCE * (force * holding + torque_Nm.abs()), "torque balance")?;
    if points.floats_sideways {
        close(sideways, 0.0, BALANCE * force * 3.0, "sideways balance")?;
    } else {
        prop_assert!(solved.state.sideways_m.abs() <= 0.0, "only a floating plate shifts sideways");
    }
    prop_assert_eq!(solution.carrying, carrying);
    prop_assert!((solution.peak_pressure_Pa - peak).abs() <= 0.0);
    Ok(())
}

proptest! {
    #![proptest_config(common::config(1000))]

    /// Newton's third law at every ball and the balance of the plates; NFTMP deformation never below 0.
    #[test]
    fn forces_balance_and_no_contact_pulls(
        points in any_pair(),
        preload in preload_N(),
        share in share_to_the_limit(),
    ) {
        let torque = torque_Nm(&points, preload, share);
        check_state(&points, torque, preload, &solved(&points, torque, preload))?;
    }

    /// A ball is squeezed between two walls in series: their approaches add up to the deformation of the diagonal.
    #[test]
    fn the_two_contacts_of_a_ball_are_in_series(
        points in any_pair(),
        preload in preload_N(),
        share in share(),
    ) {
        let torque = torque_Nm(&points, preload, share);
        let solution = PairSolution::new(&points, torque, &solved(&points, torque, preload));
        for load in solution.points.iter().filter(|load| load.contact == Contact::Loaded) {
            let both: f64 = load.walls.iter().flatten().map(|wall| wall.approach_m).sum();
            close(both, load.deformation_m, 1e-12 * load.deformation_m, "series")?;
        }
    }

    /// Every normal of the deceleration pair passes through the pitch point, at Zo e from the centre of the output
    /// plate: the force across the line of centres is M0/(Zo e).
    #[test]
    fn the_eccentric_bearing_carries_the_torque_over_its_arm(
        pair in deceleration_pair(),
        phase in phase_rad(),
        preload in preload_N(),
        share in share(),
    ) {
        let points = Pair::Deceleration(pair).at(phase);
        prop_assume!(holds_both_ways(&points));
        let torque = torque_Nm(&points, preload, share);
        let solution = PairSolution::new(&points, torque, &solved(&points, torque, preload));
        let arm = f64::from(pair.output_lobes()) * pair.eccentricity_m();
        let force = preload / pair.contact_angle_rad.tan();
        close(solution.in_plane_force_N[1], torque / arm, BALANCE * force, "across")?;
        prop_assert!(solution.in_plane_force_N[0].abs() <= force * (1.0 + BALANCE));
    }

    /// Normals of ring grooves are parallel to the line of centres: no force across. Without inside walls the plates
    /// push each other aside with N_Z cot(beta) and tilt with M0 tan(beta).
    #[test]
    fn ring_grooves_push_along_the_line_of_centres(
        ring in ring_groove_pair(),
        e in 0.2e-3..6e-3_f64,
        phase in phase_rad(),
        preload in preload_N(),
        share in share(),
    ) {
        let points = Pair::RingGroove(ring, e).at(phase);
        let torque = torque_Nm(&points, preload, share);
        let solution = PairSolution::new(&points, torque, &solved(&points, torque, preload));
        prop_assert!(solution.in_plane_force_N[1].abs() <= 0.0);
        let inside_missing = e <= ring.groove.ball_radius_m * ring.inside_contact_angle_rad.cos();
        let outside = existing(&points).all(|point| point.diagonal == Diagonal::Plus);
        prop_assert_eq!(inside_missing, outside);
        let tan = ring.outside_contact_angle_rad.tan();
        if outside {
            close(solution.in_plane_force_N[0], -preload / tan, BALANCE * preload / tan, "along")?;
            let scale = preload * ring.pitch_radius_m;
            close(solution.tilt_couple_Nm, torque * tan, BALANCE * scale * tan.max(1.0), "tilt couple")?;
        }
    }

    /// A row of a cross-slide leaves no force in the plane: along its grooves nothing resists, across them the floating
    /// plate is in balance.
    #[test]
    fn a_cross_slide_is_in_balance_sideways(
        slide in cross_slide_pair(),
        preload in preload_N(),
        share in share_to_the_limit(),
    ) {
        let points = Pair::CrossSlide(slide).at(0.0);
        let torque = torque_Nm(&points, preload, share);
        let state = solved(&points, torque, preload);
        let solution = PairSolution::new(&points, torque, &state);
        let force = preload / slide.contact_angle_rad.tan();
        prop_assert!(solution.in_plane_force_N[0].abs() <= 0.0);
        close(solution.in_plane_force_N[1], 0.0, BALANCE * force, "across")?;
        if slide.ball_count % 2 == 0 {
            let size = (points.largest_arm_m() * state.state.rotation_rad).abs()
                + state.state.approach_m().abs();
            close(state.state.sideways_m, 0.0, 1e-7 * size, "an even number of balls needs no shift")?;
        }
    }
}

// --- symmetries and scaling --------------------------------------------------------------------

proptest! {
    #![proptest_config(common::config(700))]

    /// Mirrored in the line of centres, a load is the opposite load: alpha(-M0) at -phase is -alpha(M0) at phase.
    #[test]
    fn the_opposite_torque_at_the_opposite_phase_is_the_mirror_image(
        points in any_pair(),
        preload in preload_N(),
        share in share(),
    ) {
        let mirrored = points.pair.at(-points.phase_rad);
        let torque = torque_Nm(&points, preload, share);
        let (state, image) = (solved(&points, torque, preload), solved(&mirrored, -torque, preload));
        let angle = state.state.rotation_rad;
        let scale = angle_scale(&points, preload, angle);
        close(image.state.rotation_rad, -angle, SAME * scale, "angle")?;
        let size = scale * points.largest_arm_m();
        close(image.state.approach_m(), state.state.approach_m(), SAME * size, "approach")?;
        let stiffness = state.torsional_stiffness_Nm_per_rad;
        close(image.torsional_stiffness_Nm_per_rad, stiffness, 1e-7 * stiffness, "stiffness")?;
    }

    /// After the angle between two balls a pair stands as before.
    #[test]
    fn a_pair_repeats_with_its_balls(
        points in any_pair(),
        preload in preload_N(),
        share in share(),
        turns in -3..=3_i32,
    ) {
        let period = TAU / f64::from(points.pair.ball_count());
        let later = points.pair.at(points.phase_rad + f64::from(turns) * period);
        let torque = torque_Nm(&points, preload, share);
        let angle = solved(&points, torque, preload).state.rotation_rad;
        let again = solved(&later, torque, preload).state.rotation_rad;
        close(again, angle, SAME * angle_scale(&points, preload, angle), "angle")?;
    }

    /// alpha = k^(-1/n) N_Z^(1/n) f(M0/N_Z): only the ratio of load to stiffness counts; n = 3/2 by Hertz.
    #[test]
    fn the_angle_scales_with_load_over_stiffness(
        points in any_pair(),
        exponent in prop_oneof![Just(1.5), 1.2..3.0_f64],
        preload in preload_N(),
        share in share(),
        load in (-2.0..2.0_f64).prop_map(|log| 10_f64.powf(log)),
        stiffness in (-2.0..2.0_f64).prop_map(|log| 10_f64.powf(log)),
    ) {
        let points = MeshingPoints { exponent, ..points.points };
        let torque = torque_Nm(&points, preload, share);
        let state = solved(&points, torque, preload);
        let mut other = points.clone();
        for point in &mut other.points {
            point.stiffness *= stiffness;
        }
        let scaled = solved(&other, load * torque, load * preload);
        let factor = (load / stiffness).powf(1.0 / exponent);
        let scale = angle_scale(&points, preload, state.state.rotation_rad);
        close(scaled.state.rotation_rad / factor, state.state.rotation_rad, SAME * scale, "angle")?;
        let approach = scale * points.largest_arm_m();
        close(scaled.state.approach_m() / factor, state.state.approach_m(), SAME * approach, "approach")?;
    }

    /// A cross-slide does not see where along its grooves the circle of balls stands: with all arms shifted the floating
    /// plate follows by the same shift times the rotation, and the angle stays.
    #[test]
    fn a_cross_slide_is_blind_to_the_shift_of_its_balls(
        slide in cross_slide_pair(),
        preload in preload_N(),
        share in share(),
        shift in -5e-3..5e-3_f64,
    ) {
        let points = Pair::CrossSlide(slide).at(0.0);
        let mut shifted = points.clone();
        for point in &mut shifted.points {
            point.arm_m += shift;
        }
        let torque = torque_Nm(&points, preload, share);
        let (state, other) = (solved(&points, torque, preload), solved(&shifted, torque, preload));
        let angle = state.state.rotation_rad;
        let scale = angle_scale(&points, preload, angle);
        close(other.state.rotation_rad, angle, SAME * scale, "angle")?;
        let follows = state.state.sideways_m - shift * angle;
        close(other.state.sideways_m, follows, SAME * scale * points.largest_arm_m(), "shift")?;
        let found = pair_thresholds(&shifted, torque);
        let expected = pair_thresholds(&points, torque);
        close(found.hold_N, expected.hold_N, SAME * expected.hold_N, "hold")?;
        close(found.continuous_N, expected.continuous_N, SAME * expected.continuous_N, "continuous")?;
        close(found.zero_backlash_N, expected.zero_backlash_N, SAME * expected.zero_backlash_N, "zero")?;
    }
}

// --- monotony and stiffness ---------------------------------------------------------------------

proptest! {
    #![proptest_config(common::config(700))]

    /// More torque, more angle, in either direction: the energy is convex.
    #[test]
    fn the_angle_rises_with_the_torque(
        points in any_pair(),
        preload in preload_N(),
        first in share_to_the_limit(),
        second in share_to_the_limit(),
    ) {
        let (low, high) = (first.min(second), first.max(second));
        prop_assume!(high - low > 1e-6);
        let angle = |share: f64| {
            let torque = torque_Nm(&points, preload, share);
            solved(&points, torque, preload).state.rotation_rad
        };
        prop_assert!(angle(low) < angle(high));
    }

    /// The torsional stiffness is the slope of torque over angle at constant preload; with an axial spring, too.
    #[test]
    fn the_torsional_stiffness_is_the_slope(
        points in any_pair(),
        preload in preload_N(),
        share in -0.9..0.9_f64,
        spring in prop_oneof![Just(0.0), 0.01..100.0_f64],
    ) {
        let only_spring = Effects { axial: vec![0.0], normal: vec![0.0], in_plane: vec![0.0], exponent: 1.5, spring };
        let points = only_spring.on(&points, preload);
        let torque = torque_Nm(&points, preload, share);
        // Stiffness goes with the root of the deformation, so differences across a contact that parts are rough.
        let step = 1e-7 * preload * points.holding_arm_m(1.0).min(points.holding_arm_m(-1.0));
        let angle = |torque: f64| solved(&points, torque, preload).state.rotation_rad;
        let slope = 2.0 * step / (angle(torque + step) - angle(torque - step));
        let stiffness = solved(&points, torque, preload).torsional_stiffness_Nm_per_rad;
        close(stiffness, slope, 1e-3 * slope, "stiffness")?;
    }
}

// --- thresholds of the preload ------------------------------------------------------------------

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

// --- the whole drive ------------------------------------------------------------------------------

/// A drive, a preload, a crank angle and a torque that is a share of what holds there.
fn loaded_drive() -> impl Strategy<Value = (Drive, f64, f64, f64)> {
    (any_drive(), preload_N(), -7.0..7.0_f64, share()).prop_map(|(drive, preload, angle, share)| {
        let torque = share * preload * common::drive_holding_arm_m(&drive, angle, share.signum());
        (drive, torque, preload, angle)
    })
}

fn angles(drive: &Drive, torque_Nm: f64, preload_N: f64, angle_rad: f64) -> Angles {
    let (status, angles) = drive.angles(&Load::new(torque_Nm, preload_N, angle_rad).unwrap());
    angles.unwrap_or_else(|| panic!("{status}"))
}

/// What the approach under the preload alone makes of the smaller pair's arm, rad.
fn drive_angle_scale(drive: &Drive, preload_N: f64, angle_rad: f64) -> f64 {
    let points = drive.points(angle_rad);
    let of = |points: &MeshingPoints| approach_scale_m(points, preload_N) / points.largest_arm_m();
    points.equal_speed.iter().map(of).fold(of(&points.deceleration), f64::max)
}

proptest! {
    #![proptest_config(common::config(300))]

    /// `alpha_d` = alpha1 + alpha2, `alpha_s` = alpha1(M0) + Z1/Z3 alpha3(M0 Z1/Z3): the parts are those of the pairs
    /// alone, they do the same work as the whole, and their compliances add.
    #[test]
    fn the_parts_add_up((drive, torque, preload, angle) in loaded_drive()) {
        let solution = drive.solve(&Load::new(torque, preload, angle).unwrap());
        let (Some(whole), Some(first), Some(second)) =
            (solution.angles, solution.deceleration, solution.equal_speed)
        else {
            panic!("{}", solution.status)
        };
        let share = match drive.equal_speed() {
            EqualSpeed::RingGroove(_) => 1.0,
            EqualSpeed::CrossSlide(_) => {
                let balls = f64::from(drive.deceleration().ball_count);
                (balls - 1.0) / (balls + 1.0)
            }
        };
        let phase = drive.deceleration_phase_rad(angle);
        let alone = solved(&drive.deceleration_points(phase), torque, preload);
        close(first.rotation_rad, alone.state.rotation_rad, 0.0, "deceleration alone")?;
        let row = &drive.equal_speed_points(drive.equal_speed_phase_rad(angle), angle)[0];
        let alone = solved(row, share * torque, preload);
        let rows = if share < 1.0 { 2.0 } else { 1.0 };
        close(second.rotation_rad, rows * alone.state.rotation_rad, 0.0, "equal-speed alone")?;
        close(second.torque_Nm, share * torque, 0.0, "torque of the equal-speed pair")?;
        let scale = drive_angle_scale(&drive, preload, angle).max(whole.elastic_angle_rad().abs());
        close(whole.deceleration_rad, first.rotation_rad, 0.0, "deceleration")?;
        close(whole.equal_speed_rad, share * second.rotation_rad, 1e-14 * scale, "equal-speed")?;
        close(whole.elastic_angle_rad(), whole.deceleration_rad + whole.equal_speed_rad, 0.0, "sum")?;
        let work = torque * first.rotation_rad + second.torque_Nm * second.rotation_rad;
        close(torque * whole.elastic_angle_rad(), work, 1e-13 * scale * torque.abs(), "work")?;
        let compliance = 1.0 / first.torsional_stiffness_Nm_per_rad
            + share * share / second.torsional_stiffness_Nm_per_rad;
        let stiffness = solution.torsional_stiffness_Nm_per_rad.unwrap();
        close(stiffness * compliance, 1.0, 1e-13, "compliance")?;
        close(whole.residual, first.residual.max(second.residual), 0.0, "residual")?;
    }

    /// The 2017 paper's cross-slide, kept to compare: the whole torque and the whole angle; and, in its form, arms shifted
    /// by e cos(theta) in one row and e sin(theta) in the other, with no balance across.
    #[test]
    fn the_papers_cross_slide_is_what_it_says((drive, torque, preload, angle) in loaded_drive()) {
        let EqualSpeed::CrossSlide(slide) = *drive.equal_speed() else { return Ok(()) };
        let other = |form, share| {
            let slide = EqualSpeed::CrossSlide(CrossSlide { form, share, ..slide });
            let pair = *drive.deceleration();
            Drive::new(*drive.material(), pair, slide, TrackCurvature::Exact).unwrap()
        };
        let load = Load::new(torque, preload, angle).unwrap();
        let row = drive.points(angle).equal_speed.remove(0);
        if let (_, Some(found)) = other(CrossSlideForm::Balanced, CrossSlideShare::Paper).angles(&load) {
            let alone = 2.0 * solved(&row, torque, preload).state.rotation_rad;
            close(found.equal_speed_rad, alone, 0.0, "share")?;
        }
        if let (_, Some(found)) = other(CrossSlideForm::Paper, CrossSlideShare::Carried).angles(&load) {
            let share = drive.equal_speed_share();
            let e = drive.deceleration().eccentricity_m();
            let shifted = |shift: f64| {
                let mut held = MeshingPoints { floats_sideways: false, rows: 1, ..row.clone() };
                held.points.iter_mut().for_each(|point| point.arm_m += shift);
                solved(&held, share * torque, preload).state.rotation_rad
            };
            let both = share * (shifted(e * angle.cos()) + shifted(e * angle.sin()));
            let scale = both.abs().max(drive_angle_scale(&drive, preload, angle));
            close(found.equal_speed_rad, both, 1e-13 * scale, "form")?;
        }
    }

    /// The stiffness of the drive is the slope of torque over its angle.
    #[test]
    fn the_stiffness_of_the_drive_is_the_slope((drive, torque, preload, angle) in loaded_drive()) {
        let limit = |sign| preload * common::drive_holding_arm_m(&drive, angle, sign);
        prop_assume!(torque.abs() < 0.9 * limit(torque.signum()));
        let step = 1e-7 * limit(1.0).min(limit(-1.0));
        let alpha = |torque| angles(&drive, torque, preload, angle).elastic_angle_rad();
        let slope = 2.0 * step / (alpha(torque + step) - alpha(torque - step));
        let solution = drive.solve(&Load::new(torque, preload, angle).unwrap());
        close(solution.torsional_stiffness_Nm_per_rad.unwrap(), slope, 1e-3 * slope, "stiffness")?;
    }

    /// Turned the other way, crank and torque, a drive gives the opposite angle; a cross-slide gives the same at every
    /// angle of the crank.
    #[test]
    fn the_drive_mirrors((drive, torque, preload, angle) in loaded_drive(), other in -7.0..7.0_f64) {
        let here = angles(&drive, torque, preload, angle);
        let image = angles(&drive, -torque, preload, -angle);
        let scale = drive_angle_scale(&drive, preload, angle).max(here.elastic_angle_rad().abs());
        close(image.deceleration_rad, -here.deceleration_rad, SAME * scale, "deceleration")?;
        close(image.equal_speed_rad, -here.equal_speed_rad, SAME * scale, "equal-speed")?;
        if matches!(drive.equal_speed(), EqualSpeed::CrossSlide(_)) {
            let (_, elsewhere) = drive.angles(&Load::new(torque, preload, other).unwrap());
            if let Some(elsewhere) = elsewhere {
                close(elsewhere.equal_speed_rad, here.equal_speed_rad, 0.0, "cross-slide")?;
            }
        }
    }

    /// Each pair repeats when the crank has moved its balls by one place: the deceleration pair after 2 pi/Z1 with the
    /// hypocycloid plate as output (2 pi/Z3 with the epicycloid plate), ring grooves after 2 pi Z3/(Z1 Zd)
    /// (2 pi Z1/(Z3 Zd)).
    #[test]
    fn the_pairs_repeat_with_the_crank((drive, torque, preload, angle) in loaded_drive()) {
        let here = angles(&drive, torque, preload, angle);
        let scale = drive_angle_scale(&drive, preload, angle).max(here.elastic_angle_rad().abs());
        let pair = drive.deceleration();
        let (z1, z3) = (f64::from(pair.ball_count) - 1.0, f64::from(pair.ball_count) + 1.0);
        let (own, other) = if drive.transmission_ratio() > 0.0 { (z1, z3) } else { (z3, z1) };
        // Ring grooves may not hold everywhere, so each pair is solved by itself.
        let first = drive.points(angle + TAU / own).deceleration;
        close(solved(&first, torque, preload).state.rotation_rad, here.deceleration_rad, SAME * scale, "first")?;
        if let EqualSpeed::RingGroove(ring) = drive.equal_speed() {
            let period = TAU * other / (own * f64::from(ring.ball_count));
            let second = &drive.points(angle - period).equal_speed[0];
            close(solved(second, torque, preload).state.rotation_rad, here.equal_speed_rad, SAME * scale, "second")?;
        }
    }

    /// Similar drives: alpha goes with E*^(-2/3) at the same loads, and with L^(-4/3) for all lengths L times as large
    /// at the same preload and L times the torque, so that the stresses fall and the state keeps its shape.
    #[test]
    fn similar_drives_scale(
        (drive, torque, preload, angle) in loaded_drive(),
        modulus in 0.05..20.0_f64,
        length in 0.05..20.0_f64,
    ) {
        let here = angles(&drive, torque, preload, angle);
        let scale = drive_angle_scale(&drive, preload, angle).max(here.elastic_angle_rad().abs());
        let material = Material {
            ball: Elasticity { youngs_modulus_Pa: 208e9 * modulus, ..Elasticity::BEARING_STEEL },
            plate: Elasticity { youngs_modulus_Pa: 208e9 * modulus, ..Elasticity::BEARING_STEEL },
            ..Material::default()
        };
        let other = Drive::new(material, *drive.deceleration(), *drive.equal_speed(), TrackCurvature::Exact);
        let other = angles(&other.unwrap(), torque, preload, angle);
        let factor = modulus.powf(2.0 / 3.0);
        close(other.deceleration_rad * factor, here.deceleration_rad, SAME * scale, "modulus, first")?;
        close(other.equal_speed_rad * factor, here.equal_speed_rad, SAME * scale, "modulus, second")?;

        let mut first = *drive.deceleration();
        first.rolling_circle_radius_m *= length;
        first.groove.ball_radius_m *= length;
        let second = match *drive.equal_speed() {
            EqualSpeed::RingGroove(mut ring) => {
                ring.pitch_radius_m *= length;
                ring.groove.ball_radius_m *= length;
                EqualSpeed::RingGroove(ring)
            }
            EqualSpeed::CrossSlide(mut slide) => {
                slide.pitch_radius_m *= length;
                slide.groove.ball_radius_m *= length;
                EqualSpeed::CrossSlide(slide)
            }
        };
        let other = Drive::new(Material::default(), first, second, TrackCurvature::Exact).unwrap();
        let other = angles(&other, torque * length, preload, angle);
        let factor = length.powf(4.0 / 3.0);
        close(other.deceleration_rad * factor, here.deceleration_rad, SAME * scale, "length, first")?;
        close(other.equal_speed_rad * factor, here.equal_speed_rad, SAME * scale, "length, second")?;
    }
}

proptest! {
    #![proptest_config(common::config(60))]

    /// The largest elastic angle is reached at the angle that is named, no angle exceeds it, and the drive repeats after
    /// its period.
    #[test]
    fn the_largest_angle_is_the_largest(
        drive in small_drive(),
        preload in preload_N(),
        share in prop_oneof![0.02..0.95_f64, -0.95..-0.02_f64],
        places in proptest::collection::vec(0.0..1.0_f64, 30),
    ) {
        let hold = drive.preload_thresholds(share.signum()).drive().hold_N;
        let torque = share * preload / hold;
        let (status, largest) = drive.largest_elastic_angle(torque, preload).unwrap();
        let Some(largest) = largest else { panic!("{status}") };
        let alpha = |angle| angles(&drive, torque, preload, angle).elastic_angle_rad();
        let most = largest.elastic_angle_rad * torque.signum();
        prop_assert!(most > 0.0);
        close(alpha(largest.input_angle_rad), largest.elastic_angle_rad, SAME * most, "where it is")?;
        prop_assert!((0.0..largest.period_rad).contains(&largest.input_angle_rad));
        let mut least = most;
        for place in places {
            let angle = place * largest.period_rad;
            let here = alpha(angle) * torque.signum();
            prop_assert!(here <= most + 1e-3 * largest.amplitude_rad + SAME * most, "{here} at {angle}, {most}");
            close(alpha(angle + largest.period_rad) * torque.signum(), here, SAME * most, "period")?;
            least = least.min(here);
        }
        prop_assert!(most - least <= 1.01 * largest.amplitude_rad + SAME * most);
    }

    /// The largest elastic angle of the drive rises with the torque and falls with the preload. (Not for a torque next to
    /// nothing: the preload alone turns a plate whose few balls stand on unlike walls by a trace, and more with more.)
    #[test]
    fn the_largest_angle_falls_with_the_preload_and_rises_with_the_torque(
        drive in small_drive(),
        preload in preload_N(),
        share in prop_oneof![0.25..0.95_f64, -0.95..-0.25_f64],
        more in 1.001..20.0_f64,
    ) {
        let hold = drive.preload_thresholds(share.signum()).drive().hold_N;
        let torque = share * preload / hold;
        let largest = |torque: f64, preload: f64| {
            let (status, largest) = drive.largest_elastic_angle(torque, preload).unwrap();
            largest.unwrap_or_else(|| panic!("{status}")).elastic_angle_rad.abs()
        };
        let here = largest(torque, preload);
        prop_assert!(largest(torque, preload * more) < here);
        prop_assert!(largest(torque / more, preload) < here);
    }
}

/// Refining the place of the maximum ends however small the step is against the place itself: with 100 and 61 balls the
/// drive repeats after 6161 places of its balls, and the largest angle lies far out.
#[test]
fn the_largest_angle_of_many_balls_is_found() {
    let mut numbers = Numbers::of_the_base_case();
    numbers.deceleration.ball_count = 100;
    numbers.ring.ball_count = 61;
    numbers.ring.pitch_radius_m = 0.2;
    let [drive, _] = numbers.drives();
    let (sender, receiver) = std::sync::mpsc::channel();
    std::thread::spawn(move || sender.send(drive.unwrap().largest_elastic_angle(1.0, 600.0)));
    let found = receiver.recv_timeout(std::time::Duration::from_secs(60)).expect("the search ends");
    let (status, largest) = found.unwrap();
    assert_eq!(status, Status::Solved);
    assert!(largest.unwrap().elastic_angle_rad > 0.0);
}

/// Cancelled, the search is over at once, however many balls there are.
#[test]
fn the_search_for_the_largest_angle_can_be_cancelled() {
    let mut numbers = Numbers::of_the_base_case();
    (numbers.deceleration.ball_count, numbers.ring.ball_count) = (1000, 999);
    numbers.ring.pitch_radius_m = 3.0;
    let [drive, _] = numbers.drives();
    let drive = drive.unwrap();
    let progress = Progress::default();
    let found = std::thread::scope(|scope| {
        let search = scope.spawn(|| drive.largest_elastic_angle_watched(1.0, 600.0, &progress));
        std::thread::sleep(std::time::Duration::from_millis(20));
        progress.cancel();
        search.join().unwrap()
    });
    assert_eq!(found.unwrap().1, None);
}

// --- effects on a pair ------------------------------------------------------------------------------

/// Offsets, exponent and spring that do nothing.
fn nothing() -> Effects {
    Effects { axial: vec![0.0], normal: vec![0.0], in_plane: vec![0.0], exponent: 1.5, spring: 0.0 }
}

/// Solves a pair under effects at a share of what its preload holds and checks the balance.
fn check_under_effects(points: &MeshingPoints, effects: &Effects, preload_N: f64, share: f64) -> Checked {
    let points = effects.on(points, preload_N);
    prop_assume!(!is_loose(&points, preload_N));
    let torque = torque_Nm(&points, preload_N, share);
    let (status, state) = solve_pair(&points, torque, preload_N);
    prop_assert!(status.has_solution(), "{status}");
    check_state(&points, torque, preload_N, &state.unwrap())
}

proptest! {
    #![proptest_config(common::config(1500))]

    /// With any offsets, exponent and axial spring the forces balance what reaches the points, N_Z - k_c (d - d0).
    #[test]
    fn effects_leave_a_pair_in_balance(
        points in any_pair(),
        effects in effects(),
        preload in preload_N(),
        share in prop_oneof![9 => -0.99..0.99_f64, 1 => Just(0.0)],
    ) {
        check_under_effects(&points, &effects, preload, share)?;
    }

    /// A spring presses harder as the plates part, so a torque beyond what the preload holds finds its balance, too.
    #[test]
    fn a_spring_holds_beyond_the_limit(
        points in any_pair(),
        effects in effects(),
        spring in 0.01..100.0_f64,
        preload in preload_N(),
        share in prop_oneof![0.99..3.0_f64, -3.0..-0.99_f64],
    ) {
        check_under_effects(&points, &Effects { spring, ..effects }, preload, share)?;
    }

    /// The same to the last 0.01 % below the limit, up to 50 times the limit with a spring, and with offsets of any size.
    #[test]
    fn large_effects_leave_a_pair_in_balance(
        points in any_pair(),
        effects in effects_up_to(30.0, 100.0),
        preload in preload_N(),
        share in share_to_the_limit(),
        beyond in prop_oneof![Just(1.0), 1.0..50.0_f64],
    ) {
        let beyond = if effects.spring > 0.0 { beyond } else { 1.0 };
        check_under_effects(&points, &effects, preload, beyond * share)?;
    }
}

proptest! {
    #![proptest_config(common::config(400))]

    /// Effects of size nothing change nothing, to the last bit.
    #[test]
    fn neutral_effects_change_nothing(points in any_pair(), preload in preload_N(), share in share_to_the_limit()) {
        let torque = torque_Nm(&points, preload, share);
        let changed = nothing().on(&points, preload);
        prop_assert_eq!(solve_pair(&changed, torque, preload), solve_pair(&points, torque, preload));
        prop_assert_eq!(pair_thresholds(&changed, torque), pair_thresholds(&points, torque));
    }

    /// Small effects change little, and half the effect changes half as much.
    #[test]
    fn small_effects_change_little(
        points in any_pair(),
        effects in effects(),
        preload in preload_N(),
        share in -0.9..0.9_f64,
    ) {
        let torque = torque_Nm(&points, preload, share);
        let angle = |points: &MeshingPoints| solved(points, torque, preload).state.rotation_rad;
        let before = angle(&points);
        let scale = angle_scale(&points, preload, before);
        let offsets = Effects { exponent: 1.5, spring: 0.0, ..effects };
        for size in [1e-6, 1e-8] {
            let after = angle(&offsets.scaled(size).on(&points, preload));
            close(after, before, 1e3 * size * scale, "offsets")?;
            let other = angle(&Effects { exponent: 1.5 + size, ..nothing() }.on(&points, preload));
            // The unit of deformation in N = k delta_0^1.5 (delta/delta_0)^n is 1 um.
            let decades = 1.0 + (approach_scale_m(&points, preload) / 1e-6).ln().abs();
            close(other, before, 1e2 * size * decades * scale, "exponent")?;
            let other = angle(&Effects { spring: size, ..nothing() }.on(&points, preload));
            close(other, before, 1e3 * size * scale, "spring")?;
        }
    }

    /// Offsets that amount to a motion of the whole plate are taken up by that motion: an axial one by the approach, one
    /// along the normals of equal angle likewise, one in the plane by the rotation or the sideways shift.
    #[test]
    fn offsets_alike_at_every_ball_are_a_motion_of_the_plate(
        points in any_pair(),
        preload in preload_N(),
        share in share(),
        size in -3.0..3.0_f64,
    ) {
        let torque = torque_Nm(&points, preload, share);
        let state = solved(&points, torque, preload).state;
        let approach = approach_scale_m(&points, preload);
        let scale = angle_scale(&points, preload, state.rotation_rad);
        let length = scale * points.largest_arm_m();
        let moved = |set: &dyn Fn(&mut MeshingPoint)| {
            let mut other = points.points.clone();
            other.points.iter_mut().for_each(set);
            solved(&other, torque, preload).state
        };
        let check = |found: [f64; 3], expected: [f64; 3]| -> Checked {
            close(found[0], expected[0], SAME * length, "approach")?;
            close(found[1], expected[1], SAME * scale, "angle")?;
            close(found[2], expected[2], SAME * length, "sideways")
        };
        let offset = size * approach;
        let sideways = state.sideways_m;
        let (d, alpha) = (state.approach_m(), state.rotation_rad);
        let axial = moved(&|point| point.axial_offset_m = offset);
        check([axial.approach_m(), axial.rotation_rad, axial.sideways_m], [d - offset, alpha, sideways])?;
        let normal = moved(&|point| point.normal_offset_m = offset * point.sin_beta);
        check([normal.approach_m(), normal.rotation_rad, normal.sideways_m], [d - offset, alpha, sideways])?;
        let turn = offset / points.largest_arm_m();
        let turned = moved(&|point| point.in_plane_offset_m = turn * point.arm_m);
        check([turned.approach_m(), turned.rotation_rad, turned.sideways_m], [d, alpha - turn, sideways])?;
        if points.floats_sideways {
            let shifted = moved(&|point| point.in_plane_offset_m = offset);
            check([shifted.approach_m(), shifted.rotation_rad, shifted.sideways_m], [d, alpha, sideways - offset])?;
        }
    }

    /// Offsets do not change what a preload holds: at the limit one contact carries all, wherever it stands.
    #[test]
    fn offsets_do_not_change_the_limit(points in any_pair(), effects in effects(), preload in preload_N()) {
        let changed = Effects { spring: 0.0, ..effects }.on(&points, preload);
        for sign in [-1.0, 1.0] {
            let limit = sign * preload * points.holding_arm_m(sign);
            prop_assert!(solve_pair(&changed, limit * (1.0 + 1e-12), preload).1.is_none());
            let status = solve_pair(&changed, limit * 0.999, preload).0;
            prop_assert!(status.has_solution(), "{status}");
        }
    }

    /// A pair held by a spring stands as one without at the preload N_Z - k_c (d - d0) that the spring leaves; without a
    /// torque it leaves all of it.
    #[test]
    fn a_spring_changes_the_preload_and_nothing_else(
        points in any_pair(),
        effects in effects(),
        preload in preload_N(),
        share in share(),
    ) {
        let sprung = effects.on(&points, preload);
        prop_assume!(sprung.axial_spring_N_per_m > 0.0 && !is_loose(&sprung, preload));
        let plain = MeshingPoints { axial_spring_N_per_m: 0.0, ..sprung.clone() };
        let free = solved(&plain, 0.0, preload);
        let idle = free.state;
        let scale = angle_scale(&plain, preload, idle.rotation_rad);
        let allowed = SAME * scale + open_rad(&plain, preload, &free);
        close(solved(&sprung, 0.0, preload).state.rotation_rad, idle.rotation_rad, allowed, "no torque")?;
        let torque = torque_Nm(&points, preload, share);
        let state = solved(&sprung, torque, preload).state;
        let left = preload - sprung.axial_spring_N_per_m * (state.approach_m() - idle.approach_m());
        // Preload and torque at the points are known to rounding of the larger of preload and spring force.
        let force = preload + sprung.axial_spring_N_per_m * (state.approach_m().abs() + idle.approach_m().abs());
        prop_assume!(left > 1e-3 * force && torque.abs() < 0.95 * left * plain.holding_arm_m(torque.signum()));
        let alone = solved(&plain, torque, left);
        let scale = scale.max(state.rotation_rad.abs());
        let allowed = 1e-7 * scale + open_rad(&plain, force, &alone);
        close(alone.state.rotation_rad, state.rotation_rad, allowed, "angle")?;
        let length = allowed * plain.largest_arm_m() + 1e-7 * idle.approach_m().abs();
        close(alone.state.approach_m(), state.approach_m(), length, "approach")?;
    }
}

/// A spring is relaxed from the approach under the preload alone, even where that leaves the plate free to turn: here on
/// one ball on the axis, until a torque brings the others to bear.
#[test]
fn a_spring_needs_no_stiffness_of_the_unloaded_plate() {
    let mut points = Drive::paper_base_case().points(0.0).equal_speed.remove(0);
    for point in &mut points.points {
        if point.ball == 0 {
            point.arm_m = 0.0;
        } else {
            point.normal_offset_m = -20e-6;
        }
    }
    let (preload, torque) = (60.0, 1.0);
    assert_eq!(solve_pair(&points, 0.0, preload), (Status::Indeterminate, None));
    points.axial_spring_N_per_m = 1e6;
    assert_eq!(solve_pair(&points, 0.0, preload), (Status::Indeterminate, None));
    let on_the_axis = points.points.iter().filter(|point| point.ball == 0);
    let stiffness: f64 = on_the_axis.map(|point| point.stiffness * point.sin_beta.powf(2.5)).sum();
    let unloaded = (preload / stiffness).powf(1.0 / 1.5);
    let (status, state) = solve_pair(&points, torque, preload);
    let state = state.unwrap_or_else(|| panic!("{status}")).state;
    let forces = |lever: &dyn Fn(&MeshingPoint) -> f64| -> f64 {
        let force = |point: &MeshingPoint| point.stiffness * state.deformation_m(point).max(0.0).powf(1.5);
        points.points.iter().map(|point| force(point) * lever(point)).sum()
    };
    let left = preload - points.axial_spring_N_per_m * (state.approach_m() - unloaded);
    assert!((forces(&|point| point.sin_beta) - left).abs() <= 1e-9 * preload);
    assert!((forces(&|point| point.signed_arm_m() * point.cos_beta) - torque).abs() <= 1e-9 * torque);
    assert!((left - preload).abs() > 1e-3 * preload, "the spring has a part in it");
}

// --- input that cannot be -------------------------------------------------------------------------

/// The numbers of a drive, to be changed one by one.
struct Numbers {
    material: Material,
    deceleration: Deceleration,
    ring: RingGroove,
    slide: CrossSlide,
}

impl Numbers {
    fn of_the_base_case() -> Self {
        let drive = Drive::paper_base_case();
        let EqualSpeed::RingGroove(ring) = *drive.equal_speed() else { panic!("ring grooves") };
        Self {
            material: *drive.material(),
            deceleration: *drive.deceleration(),
            ring,
            slide: CrossSlide {
                ball_count: 16,
                pitch_radius_m: ring.pitch_radius_m,
                contact_angle_rad: ring.inside_contact_angle_rad,
                groove: ring.groove,
                form: CrossSlideForm::Balanced,
                share: CrossSlideShare::Carried,
            },
        }
    }

    fn drive(&self, equal: EqualSpeed) -> Result<Drive, InvalidInput> {
        Drive::new(self.material, self.deceleration, equal, TrackCurvature::Exact)
    }

    fn drives(&self) -> [Result<Drive, InvalidInput>; 2] {
        [EqualSpeed::RingGroove(self.ring), EqualSpeed::CrossSlide(self.slide)].map(|equal| self.drive(equal))
    }
}

type Field = fn(&mut Numbers) -> &mut f64;

/// Every number of a drive by its name; those of the first list must be above 0, those of the others lie between limits.
const POSITIVE: [(&str, Field); 10] = [
    ("material.ball_youngs_modulus_Pa", |n| &mut n.material.ball.youngs_modulus_Pa),
    ("material.plate_youngs_modulus_Pa", |n| &mut n.material.plate.youngs_modulus_Pa),
    ("material.pressure_limit_Pa", |n| &mut n.material.pressure_limit_Pa),
    ("deceleration.rolling_circle_radius_m", |n| &mut n.deceleration.rolling_circle_radius_m),
    ("deceleration.ball_radius_m", |n| &mut n.deceleration.groove.ball_radius_m),
    ("deceleration.groove_depth_m", |n| n.deceleration.groove.groove_depth_m.get_or_insert(1e-3)),
    ("equal_speed.pitch_radius_m", |n| &mut n.ring.pitch_radius_m),
    ("equal_speed.ball_radius_m", |n| &mut n.ring.groove.ball_radius_m),
    ("equal_speed.groove_depth_m", |n| n.ring.groove.groove_depth_m.get_or_insert(1e-3)),
    ("equal_speed.pitch_radius_m", |n| &mut n.slide.pitch_radius_m),
];
const POISSONS_RATIOS: [(&str, Field); 2] = [
    ("material.ball_poissons_ratio", |n| &mut n.material.ball.poissons_ratio),
    ("material.plate_poissons_ratio", |n| &mut n.material.plate.poissons_ratio),
];
const CONTACT_ANGLES: [(&str, Field); 4] = [
    ("deceleration.contact_angle_rad", |n| &mut n.deceleration.contact_angle_rad),
    ("equal_speed.outside_contact_angle_rad", |n| &mut n.ring.outside_contact_angle_rad),
    ("equal_speed.inside_contact_angle_rad", |n| &mut n.ring.inside_contact_angle_rad),
    ("equal_speed.contact_angle_rad", |n| &mut n.slide.contact_angle_rad),
];
const CONFORMITIES: [(&str, Field); 2] = [
    ("deceleration.groove_conformity", |n| &mut n.deceleration.groove.groove_conformity),
    ("equal_speed.groove_conformity", |n| &mut n.ring.groove.groove_conformity),
];
const SHORT_AMPLITUDE: [(&str, Field); 1] =
    [("deceleration.short_amplitude_coefficient", |n| &mut n.deceleration.short_amplitude_coefficient)];

/// A number that cannot be is refused by its name, with what was found and what is required.
#[test]
fn each_number_that_cannot_be_is_refused_by_name() {
    let never = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY];
    let check = |fields: &[(&str, Field)], bad: &[f64]| {
        for (name, field) in fields {
            for value in bad.iter().chain(&never) {
                let mut numbers = Numbers::of_the_base_case();
                *field(&mut numbers) = *value;
                let refused = numbers.drives().into_iter().find_map(Result::err);
                let refused = refused.unwrap_or_else(|| panic!("{name} = {value} was accepted"));
                assert_eq!(refused.field, *name);
                assert_eq!(refused.found, value.to_string());
                assert!(refused.required.starts_with("must"), "{}", refused.required);
            }
        }
    };
    check(&POSITIVE, &[0.0, -0.0, -1e-3]);
    check(&POISSONS_RATIOS, &[0.5, -1.0, 0.7]);
    check(&CONTACT_ANGLES, &[0.0, -0.1, std::f64::consts::FRAC_PI_2, 45.0]);
    check(&CONFORMITIES, &[1.0, 0.9, 0.0, -1.08]);
    check(&SHORT_AMPLITUDE, &[0.0, 1.0, -0.5, 1.5]);
    for count in [0, 1, 2, 1001, u32::MAX] {
        let mut numbers = Numbers::of_the_base_case();
        numbers.deceleration.ball_count = count;
        assert_eq!(numbers.drives()[0].clone().unwrap_err().field, "deceleration.ball_count");
        let mut numbers = Numbers::of_the_base_case();
        (numbers.ring.ball_count, numbers.slide.ball_count) = (count, count);
        for refused in numbers.drives() {
            assert_eq!(refused.unwrap_err().field, "equal_speed.ball_count");
        }
    }
    assert!(Numbers::of_the_base_case().drives().iter().all(Result::is_ok));
}

/// A cross-slide holds the planet, so it goes with the hypocycloid plate as output alone.
#[test]
fn a_cross_slide_needs_the_hypocycloid_plate_as_output() {
    let mut numbers = Numbers::of_the_base_case();
    numbers.deceleration.output_plate = OutputPlate::Epicycloid;
    let [ring, slide] = numbers.drives();
    assert!(ring.is_ok());
    assert_eq!(slide.unwrap_err().field, "deceleration.output_plate");
}

#[test]
fn a_load_that_cannot_be_is_refused_by_name() {
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        assert_eq!(Load::new(bad, 600.0, 0.0).unwrap_err().field, "torque_Nm");
        assert_eq!(Load::new(5.0, 600.0, bad).unwrap_err().field, "input_angle_rad");
        let drive = Drive::paper_base_case();
        assert_eq!(drive.largest_elastic_angle(bad, 600.0).unwrap_err().field, "torque_Nm");
        assert_eq!(drive.largest_elastic_angle(5.0, bad).unwrap_err().field, "preload_N");
    }
    for bad in [0.0, -0.0, -600.0, f64::NAN, f64::INFINITY] {
        let refused = Load::new(5.0, bad, 0.0).unwrap_err();
        assert_eq!((refused.field.as_str(), refused.found), ("preload_N", bad.to_string()));
    }
}

/// Any number at all, and more often than by chance one that passes.
fn any_number() -> impl Strategy<Value = f64> {
    prop_oneof![
        1 => prop::num::f64::ANY,
        3 => (-300.0..300.0_f64).prop_map(|exponent| 10_f64.powf(exponent)),
        6 => 0.01..1.5_f64,
        6 => 1e-4..1e-2_f64,
    ]
}

proptest! {
    #![proptest_config(common::config(3000))]

    /// Whatever the numbers, there is no panic: the drive is refused, or a load has a status, or its numbers are finite.
    #[test]
    fn no_number_makes_a_panic(
        changes in proptest::collection::vec((0..19_usize, any_number()), 0..4),
        balls in (3..12_u32, 3..9_u32),
        crossed in any::<bool>(),
        load in (any_number(), any_number(), any_number()),
    ) {
        let mut numbers = Numbers::of_the_base_case();
        (numbers.deceleration.ball_count, numbers.ring.ball_count) = balls;
        let fields = POSITIVE.iter().chain(&POISSONS_RATIOS).chain(&CONTACT_ANGLES);
        let fields: Vec<_> = fields.chain(&CONFORMITIES).chain(&SHORT_AMPLITUDE).collect();
        for (which, value) in changes {
            *fields[which].1(&mut numbers) = value;
        }
        let [ring, slide] = numbers.drives();
        let Ok(drive) = (if crossed { slide } else { ring }) else { return Ok(()) };
        drive.findings(None);
        let Ok(load) = Load::new(load.0, load.1, load.2) else { return Ok(()) };
        drive.findings(Some(&load));
        drive.preload_thresholds_at(load.torque_Nm(), load.input_angle_rad());
        let solution = drive.solve(&load);
        prop_assert_eq!(solution.angles.is_some(), solution.status.has_solution());
        if let (Some(angles), Some(stiffness)) = (solution.angles, solution.torsional_stiffness_Nm_per_rad) {
            prop_assert!(angles.elastic_angle_rad().is_finite() && stiffness > 0.0, "{solution:?}");
            prop_assert!(angles.residual <= 1e-11);
        }
    }
}
