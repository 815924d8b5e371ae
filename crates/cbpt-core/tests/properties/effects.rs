//! Effects on a pair.

use cbpt_core::equilibrium::solve::solve_pair;
use cbpt_core::pair::{MeshingPoint, MeshingPoints};
use cbpt_core::preload::pair_thresholds;
use cbpt_core::{Drive, Status};
use proptest::prelude::*;

use crate::common::{
    Effects, any_pair, approach_scale_m, effects, effects_up_to, is_loose, preload_N, solved, torque_Nm,
};
use crate::state::check_state;
use crate::{Checked, SAME, angle_scale, close, common, open_rad, share, share_to_the_limit};

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
