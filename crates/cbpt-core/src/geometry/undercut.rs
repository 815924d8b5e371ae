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

/// Largest curvature of either sign of both tracks, anywhere round the groove, 1/m: that of the hypocycloid where it comes
/// nearest to the centre of its plate.
///
/// Both tracks have |r'| = R |1 - K w| and |r''| = R |1 +- Z2 K w| with |w| = 1, and no curve is bent more than |r''|/|r'|^2:
/// here (1 + Z2 K)/(R (1 - K)^2) at most, which the hypocycloid (the upper sign) has at w = 1.
pub fn largest_curvature_per_m(pair: &Deceleration) -> f64 {
    let k = pair.short_amplitude_coefficient;
    (1.0 + f64::from(pair.ball_count) * k) / (pair.pitch_radius_m() * (1.0 - k).powi(2))
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;
    use crate::geometry::trochoid::BallOnTracks;

    /// Against both tracks at many places, the one of the closed form among them.
    #[test]
    fn no_place_is_bent_more() {
        for (ball_count, k) in [(3, 0.05), (3, 0.4), (3, 0.95), (12, 0.1), (12, 0.6), (12, 0.9), (60, 0.5)] {
            let pair = Deceleration {
                ball_count,
                short_amplitude_coefficient: k,
                ..*Drive::paper_base_case().deceleration()
            };
            let curvature_per_m = |step: u32| {
                let ball = BallOnTracks::at(&pair, PI * f64::from(step) / 1000.0);
                ball.epicycloid_curvature_per_m.abs().max(ball.hypocycloid_curvature_per_m.abs())
            };
            let expected = (0..=1000).map(curvature_per_m).fold(0.0, f64::max);
            let found = largest_curvature_per_m(&pair);
            assert!((found / expected - 1.0).abs() < 1e-12, "{ball_count} {k}: {found} {expected}");
        }
    }
}
