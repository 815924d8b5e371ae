//! A groove wall as a contact.
//!
//! A wall is an arc of radius g = beta* r swept along the track; the ball touches it at r cos(beta) beside the path
//! of its centre. Relative curvatures of ball and wall:
//! - across the track: 1/r - 1/g;
//! - along the track, for the wall on the side of the track's centre of curvature (kappa > 0 as seen from that wall):
//!   1/r + kappa cos(beta) / (1 - kappa r cos(beta)) (Meusnier's theorem); the other wall sees -kappa.
//!
//! Where 1 - kappa r cos(beta) <= 0 the groove has cut that wall away: it does not exist.

use crate::drive::{GrooveSection, TrackCurvature};
use crate::hertz::HertzContact;
use crate::real::Real;

/// The contact of a ball with each of many walls: `walls` gives the track's curvature as the wall sees it (1/m, above 0 with
/// the centre of curvature on the wall's side) and the cosine of the contact angle. `None` where the wall is missing.
pub fn wall_contacts(
    groove: &GrooveSection,
    walls: impl Iterator<Item = (f64, f64)>,
    contact_modulus_Pa: f64,
    track: TrackCurvature,
) -> Vec<Option<HertzContact>> {
    // No number where the wall is missing, and no contact of it then.
    let along = |(curvature, cos_beta)| along_per_m(groove, curvature, cos_beta, track).unwrap_or(f64::NAN);
    let along: Vec<f64> = walls.map(along).collect();
    HertzContact::many(&along, across_per_m(groove), contact_modulus_Pa)
}

/// Relative curvature along the track; `None` where the wall is missing.
fn along_per_m(
    groove: &GrooveSection,
    curvature_per_m: f64,
    cos_beta: f64,
    track: TrackCurvature,
) -> Option<f64> {
    if track == TrackCurvature::Neglect {
        return Some(1.0 / groove.ball_radius_m);
    }
    let room = room_at(groove.ball_radius_m, curvature_per_m, cos_beta);
    (room > 0.0).then(|| meusnier_per_m(groove.ball_radius_m, curvature_per_m, cos_beta))
}

/// 1/r + kappa cos(beta) / (1 - kappa r cos(beta)): relative curvature along the track of a wall that exists.
pub fn meusnier_per_m<T: Real>(ball_radius_m: T, curvature_per_m: T, cos_beta: T) -> T {
    let room = room_at(ball_radius_m, curvature_per_m, cos_beta);
    T::of(1.0) / ball_radius_m + curvature_per_m * cos_beta / room
}

/// d ln k / d beta of a wall's `contact`, made by [`wall_contacts`] of the same numbers, 1/rad: along the track the
/// curvature has the derivative -kappa sin(beta) / (1 - kappa r cos(beta))^2, across it none.
pub fn stiffness_slope_per_rad(
    groove: &GrooveSection,
    curvature_per_m: f64,
    contact_angle_rad: f64,
    contact: &HertzContact,
    track: TrackCurvature,
) -> f64 {
    if track == TrackCurvature::Neglect {
        return 0.0;
    }
    let room = remaining_room(groove, curvature_per_m, contact_angle_rad);
    let along = meusnier_per_m(groove.ball_radius_m, curvature_per_m, contact_angle_rad.cos());
    let slope = -curvature_per_m * contact_angle_rad.sin() / (room * room);
    contact.stiffness_slope(along, across_per_m(groove)) * slope / along
}

/// Relative curvature across the track, 1/r - 1/g.
fn across_per_m(groove: &GrooveSection) -> f64 {
    across_of_per_m(groove.ball_radius_m, groove.groove_conformity)
}

/// The same from ball radius and conformity.
pub fn across_of_per_m<T: Real>(ball_radius_m: T, groove_conformity: T) -> T {
    (-(T::of(1.0) / groove_conformity) + 1.0) / ball_radius_m
}

/// 1 - kappa r cos(beta): what the track's curvature leaves of a wall; 0 or less means that the wall is missing.
pub fn remaining_room(groove: &GrooveSection, curvature_per_m: f64, contact_angle_rad: f64) -> f64 {
    room_at(groove.ball_radius_m, curvature_per_m, contact_angle_rad.cos())
}

fn room_at<T: Real>(ball_radius_m: T, curvature_per_m: T, cos_beta: T) -> T {
    -(curvature_per_m * ball_radius_m * cos_beta) + 1.0
}
