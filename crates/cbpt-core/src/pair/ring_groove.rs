//! Meshing points of the ring-groove equal-speed pair (RGES).
//!
//! Ball j stands at psi + 2 pi j / Zd on the circle of radius Rw. The rings of both plates have the radius e and their
//! centres lie on either side of the ball along the line of centres, so every normal is parallel to that line and the
//! arm is Rw sin(psi + 2 pi j / Zd). The plus diagonal is squeezed between the two outside walls, the minus diagonal
//! between the two inside walls.

use std::f64::consts::TAU;

use crate::drive::{RingGroove, TrackCurvature};
use crate::geometry::wall::wall_contacts;
use crate::pair::{Diagonal, MeshingPoint, MeshingPoints};

/// The meshing points with ring radius `eccentricity_m` (e) and planet angle `phase_rad` (psi).
pub fn meshing_points(
    pair: &RingGroove,
    eccentricity_m: f64,
    contact_modulus_Pa: f64,
    track: TrackCurvature,
    phase_rad: f64,
) -> MeshingPoints {
    let curvature = 1.0 / eccentricity_m;
    let direction = |contact_angle_rad: f64| [contact_angle_rad.sin(), contact_angle_rad.cos()];
    let outside_direction = direction(pair.outside_contact_angle_rad);
    let inside_direction = direction(pair.inside_contact_angle_rad);
    // The ring's centre lies on the side of the inside wall, which therefore sees the curvature as positive.
    let seen = [(-curvature, outside_direction[1]), (curvature, inside_direction[1])];
    let walls = wall_contacts(&pair.groove, seen.into_iter(), contact_modulus_Pa, track);
    let outside = (-curvature, walls[0]);
    let inside = (curvature, walls[1]);
    let mut points = Vec::with_capacity(2 * pair.ball_count as usize);
    for ball in 0..pair.ball_count {
        let angle = phase_rad + TAU * f64::from(ball) / f64::from(pair.ball_count);
        let arm = pair.pitch_radius_m * angle.sin();
        for (diagonal, (seen, wall), contact_direction) in
            [(Diagonal::Plus, outside, outside_direction), (Diagonal::Minus, inside, inside_direction)]
        {
            let point =
                MeshingPoint::new(ball as usize, diagonal, arm, contact_direction, [seen; 2], [1.0, 0.0]);
            points.push(point.with_walls([wall; 2]));
        }
    }
    MeshingPoints::new(points, pair.groove.ball_radius_m)
}
