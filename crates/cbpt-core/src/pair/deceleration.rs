//! Meshing points of the deceleration pair.
//!
//! Ball i at phi_i = Phi + 2 pi i / Z2. Seen from a ball, each groove has a wall on the pitch point's side and one away
//! from it. With the hypocycloid plate as output the plus diagonal runs from the epicycloid wall on P's side to the
//! hypocycloid wall away from P; the minus diagonal is its mirror. With the epicycloid plate as output it is the other
//! way round.

use std::f64::consts::TAU;

use crate::drive::{Deceleration, OutputPlate, TrackCurvature};
use crate::geometry::trochoid::BallOnTracks;
use crate::geometry::wall::wall_contact;
use crate::pair::{Diagonal, MeshingPoint, MeshingPoints};

/// The meshing points with the first ball at `phase_rad` (Phi) from the ray through the pitch point.
pub fn meshing_points(
    pair: &Deceleration,
    contact_modulus_Pa: f64,
    track: TrackCurvature,
    phase_rad: f64,
) -> MeshingPoints {
    let mut points = Vec::with_capacity(2 * pair.ball_count as usize);
    for ball in 0..pair.ball_count {
        let phi = phase_rad + TAU * f64::from(ball) / f64::from(pair.ball_count);
        let on_tracks = BallOnTracks::at(pair, phi);
        let wall = |curvature_towards_wall: f64| {
            wall_contact(
                &pair.groove,
                curvature_towards_wall,
                pair.contact_angle_rad,
                contact_modulus_Pa,
                track,
            )
        };
        let (epi, hypo) = (on_tracks.epicycloid_curvature_per_m, on_tracks.hypocycloid_curvature_per_m);
        let epi_near_hypo_far = [epi, -hypo];
        let epi_far_hypo_near = [-epi, hypo];
        let (plus, minus) = match pair.output_plate {
            OutputPlate::Hypocycloid => (epi_near_hypo_far, epi_far_hypo_near),
            OutputPlate::Epicycloid => (epi_far_hypo_near, epi_near_hypo_far),
        };
        for (diagonal, curvatures) in [(Diagonal::Plus, plus), (Diagonal::Minus, minus)] {
            points.push(MeshingPoint::new(
                ball as usize,
                diagonal,
                on_tracks.arm_m,
                pair.contact_angle_rad,
                curvatures.map(wall),
                curvatures,
                on_tracks.to_pitch_point,
            ));
        }
    }
    MeshingPoints::new(points, pair.groove.ball_radius_m)
}
