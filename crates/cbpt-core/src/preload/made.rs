//! Thresholds of a pair whose parts are as they were made.
//!
//! With offsets the defining states are no rays any more, so each threshold is the preload at which a margin of the solved
//! state is 0:
//! 1. hold: where one contact carries all it is pressed in so far that offsets do not matter: the nominal threshold;
//! 2. continuous transmission: no ball is loose, (d + zeta) sin(beta) + g >= 0 at every ball: with nominal parts d = 0;
//! 3. zero backlash: no diagonal parts.
//!
//! Without torque the last two are not 0: they are what seats every ball, and every diagonal.

use super::{PreloadThresholds, pair_thresholds};
use crate::equilibrium::State;
use crate::equilibrium::solve::solve_pair;
use crate::pair::{MeshingPoint, MeshingPoints};

/// Doublings and halvings that look for a bracket: from 1 N to what no machine has.
const MOST_DOUBLINGS: usize = 60;
/// Steps that narrow it.
const MOST_STEPS: usize = 60;
/// Relative width at which a threshold is found.
const WIDTH: f64 = 1e-11;

/// Thresholds of a pair with offsets at torque M0 (N m).
pub fn made_thresholds(points: &MeshingPoints, torque_Nm: f64) -> PreloadThresholds {
    let nominal = pair_thresholds(points, torque_Nm);
    if !nominal.hold_N.is_finite() {
        return nominal;
    }
    let loose = |state: &State, point: &MeshingPoint| {
        (state.approach_m() + point.axial_offset_m) * point.sin_beta + point.normal_offset_m
    };
    let parted = |state: &State, point: &MeshingPoint| state.deformation_m(point);
    PreloadThresholds {
        continuous_N: least_preload_N(points, torque_Nm, nominal.continuous_N, loose),
        zero_backlash_N: least_preload_N(points, torque_Nm, nominal.zero_backlash_N, parted),
        ..nominal
    }
}

/// The preload from which on a margin (m) of every diagonal is not below 0; infinite where there is none.
fn least_preload_N(
    points: &MeshingPoints,
    torque_Nm: f64,
    nominal_N: f64,
    margin_m: impl Fn(&State, &MeshingPoint) -> f64,
) -> f64 {
    let smallest = |preload_N: f64| -> Option<f64> {
        let state = solve_pair(points, torque_Nm, preload_N).1?.state;
        let existing = points.points.iter().filter(|point| point.exists());
        Some(existing.map(|point| margin_m(&state, point)).fold(f64::INFINITY, f64::min))
    };
    let met = |margin: Option<f64>| margin.is_some_and(|margin| margin >= 0.0);
    if points.points.iter().all(MeshingPoint::has_no_offset) {
        return nominal_N;
    }
    let mut high = if nominal_N.is_finite() && nominal_N > 0.0 { nominal_N } else { 1.0 };
    let mut at_high = smallest(high);
    for _ in 0..MOST_DOUBLINGS {
        if met(at_high) {
            break;
        }
        high *= 2.0;
        at_high = smallest(high);
    }
    if !met(at_high) {
        return f64::INFINITY;
    }
    let mut low = 0.5 * high;
    let mut at_low = smallest(low);
    for _ in 0..MOST_DOUBLINGS {
        if !met(at_low) {
            break;
        }
        (high, at_high) = (low, at_low);
        low *= 0.5;
        at_low = smallest(low);
    }
    if met(at_low) {
        return 0.0;
    }
    narrowed([low, high], [at_low, at_high], smallest)
}

/// False position by the Illinois rule in N^(2/3), in which deformations are nearly straight; bisection where there is no
/// solution to interpolate from.
fn narrowed(
    [mut low, mut high]: [f64; 2],
    [mut at_low, mut at_high]: [Option<f64>; 2],
    smallest: impl Fn(f64) -> Option<f64>,
) -> f64 {
    let mut side = 0;
    for step in 0..MOST_STEPS {
        if high - low <= WIDTH * high {
            break;
        }
        let middle = match (at_low, at_high) {
            (Some(a), Some(b)) if b > a && step % 4 != 3 => {
                let (x, y) = (low.powf(2.0 / 3.0), high.powf(2.0 / 3.0));
                let guess = (y - b * (y - x) / (b - a)).powf(1.5);
                guess.clamp(low + 1e-3 * WIDTH * high, high - 1e-3 * WIDTH * high)
            }
            _ => 0.5 * (low + high),
        };
        let here = smallest(middle);
        if here.is_some_and(|margin| margin >= 0.0) {
            (high, at_high) = (middle, here);
            at_low = if side == 1 { at_low.map(|margin| 0.5 * margin) } else { at_low };
            side = 1;
        } else {
            (low, at_low) = (middle, here);
            at_high = if side == -1 { at_high.map(|margin| 0.5 * margin) } else { at_high };
            side = -1;
        }
    }
    high
}
