//! Forces and resultants of one state.

use cbpt_core::equilibrium::report::{Contact, PairSolution, Role};
use cbpt_core::equilibrium::solve::PairState;
use cbpt_core::pair::{Diagonal, MeshingPoints};
use proptest::prelude::*;

use crate::common::{
    Pair, any_pair, cross_slide_pair, deceleration_pair, preload_N, ring_groove_pair, solved, torque_Nm,
    unloaded_approach_m,
};
use crate::{
    BALANCE, Checked, close, common, existing, holds_both_ways, phase_rad, share, share_to_the_limit,
};

/// Every meshing point obeys its contact law, no contact pulls, and the forces balance preload and torque.
#[expect(
    clippy::too_many_lines,
    reason = "all that holds for one state, sums over its points and then balances"
)]
pub fn check_state(points: &MeshingPoints, torque_Nm: f64, preload_N: f64, solved: &PairState) -> Checked {
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
