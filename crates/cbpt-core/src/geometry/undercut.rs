//! Undercut: where a deceleration groove has cut part of its own wall away, anywhere round the groove.

use super::wall::remaining_room;
use crate::drive::{Deceleration, Drive, TrackCurvature};

/// Whether a wall of the deceleration pair is missing anywhere round its grooves, and the model counts curvature.
pub fn undercuts(drive: &Drive) -> bool {
    drive.track_curvature() == TrackCurvature::Exact && smallest_room(drive.deceleration()) <= 0.0
}

/// Smallest 1 - kappa r cos(beta) of any wall anywhere round both grooves; 0 or less: part of a wall is missing.
pub fn smallest_room(pair: &Deceleration) -> f64 {
    remaining_room(&pair.groove, largest_curvature_per_m(pair), pair.contact_angle_rad)
}

/// Largest curvature of either sign of both tracks, anywhere round the groove, 1/m.
///
/// kappa = (A + B c)/(R (1 + K^2 - 2 K c)^1.5) with c = cos(phi) has its extremes at c = -1, c = 1 and where its
/// derivative vanishes: c = -(B (1 + K^2) + 3 K A)/(K B).
pub fn largest_curvature_per_m(pair: &Deceleration) -> f64 {
    let k = pair.short_amplitude_coefficient;
    let z2 = f64::from(pair.ball_count);
    let mut largest: f64 = 0.0;
    for (a, b) in [(1.0 + z2 * k * k, -(1.0 + z2) * k), (1.0 - z2 * k * k, (z2 - 1.0) * k)] {
        let stationary = -(b * (1.0 + k * k) + 3.0 * k * a) / (k * b);
        for c in [-1.0, 1.0, stationary.clamp(-1.0, 1.0)] {
            let d: f64 = 1.0 + k * k - 2.0 * k * c;
            largest = largest.max(((a + b * c) / (d * d.sqrt())).abs());
        }
    }
    largest / pair.pitch_radius_m()
}
