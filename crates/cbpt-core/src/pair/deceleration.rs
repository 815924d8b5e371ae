//! Meshing points of the deceleration pair.
//!
//! Ball i at phi_i = Phi + 2 pi i / Z2. Seen from a ball, each groove has a wall on the pitch point's side and one away
//! from it. With the hypocycloid plate as output the plus diagonal runs from the epicycloid wall on P's side to the
//! hypocycloid wall away from P; the minus diagonal is its mirror. With the epicycloid plate as output it is the other
//! way round.

use std::f64::consts::TAU;

use crate::drive::{Deceleration, OutputPlate, TrackCurvature};
use crate::geometry::trochoid::BallOnTracks;
use crate::geometry::wall::wall_contacts;
use crate::pair::{Diagonal, MeshingPoint, MeshingPoints};

/// The meshing points with the first ball at `phase_rad` (Phi) from the ray through the pitch point.
pub fn meshing_points(
    pair: &Deceleration,
    contact_modulus_Pa: f64,
    track: TrackCurvature,
    phase_rad: f64,
) -> MeshingPoints {
    let contact_direction @ [_, cos_beta] = [pair.contact_angle_rad.sin(), pair.contact_angle_rad.cos()];
    let mut points = Vec::with_capacity(2 * pair.ball_count as usize);
    for ball in 0..pair.ball_count {
        let phi_rad = phase_rad + TAU * f64::from(ball) / f64::from(pair.ball_count);
        let on_tracks = BallOnTracks::at(pair, phi_rad);
        let (epi, hypo) = (on_tracks.epicycloid_curvature_per_m, on_tracks.hypocycloid_curvature_per_m);
        // As the two walls of the diagonal see them: first the epicycloid's, then the hypocycloid's.
        let plus = match pair.output_plate {
            OutputPlate::Hypocycloid => [epi, -hypo],
            OutputPlate::Epicycloid => [-epi, hypo],
        };
        for (diagonal, curvatures) in [(Diagonal::Plus, plus), (Diagonal::Minus, plus.map(|seen| -seen))] {
            points.push(MeshingPoint::new(
                ball as usize,
                diagonal,
                on_tracks.arm_m,
                contact_direction,
                curvatures,
                on_tracks.to_pitch_point,
            ));
        }
    }
    let curvatures = points.iter().flat_map(|point| point.track_curvatures_per_m);
    let walls =
        wall_contacts(&pair.groove, curvatures.map(|seen| (seen, cos_beta)), contact_modulus_Pa, track);
    for (point, walls) in points.iter_mut().zip(walls.chunks_exact(2)) {
        point.set_walls([walls[0], walls[1]]);
    }
    MeshingPoints::new(points, pair.groove.ball_radius_m)
}
