//! Laws of mechanics that hold for every drive, on random pairs and drives.
//!
//! - `state`: forces and resultants of one state; `symmetry`: symmetries, scaling, monotony and stiffness; `thresholds`:
//!   of the preload; `drive`: the whole drive and its largest angle; `effects` on a pair; `input` that cannot be.
//!
//! Torques are drawn as a share of what the preload holds. Displacements are compared at the scale of the approach
//! under the preload alone, angles at that approach over the largest arm.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

#[path = "../common/mod.rs"]
mod common;
mod drive;
mod effects;
mod input;
mod state;
mod symmetry;
mod thresholds;

use cbpt_core::equilibrium::solve::PairState;
use cbpt_core::pair::{MeshingPoint, MeshingPoints};
use common::approach_scale_m;
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
