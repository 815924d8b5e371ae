//! Symmetries and scaling, monotony and stiffness of a pair.

use std::f64::consts::TAU;

use cbpt_core::pair::MeshingPoints;
use cbpt_core::preload::pair_thresholds;
use proptest::prelude::*;

use crate::common::{Effects, Pair, any_pair, cross_slide_pair, preload_N, solved, torque_Nm};
use crate::{SAME, angle_scale, close, common, share, share_to_the_limit};

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
