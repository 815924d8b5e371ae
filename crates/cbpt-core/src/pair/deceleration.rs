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
    let balls: Vec<BallOnTracks> = (0..pair.ball_count)
        .map(|ball| BallOnTracks::at(pair, phase_rad + TAU * f64::from(ball) / f64::from(pair.ball_count)))
        .collect();
    // The two walls of each of the two diagonals: first the epicycloid's, then the hypocycloid's.
    let curvatures: Vec<f64> = balls
        .iter()
        .flat_map(|on_tracks| {
            let (epi, hypo) = (on_tracks.epicycloid_curvature_per_m, on_tracks.hypocycloid_curvature_per_m);
            match pair.output_plate {
                OutputPlate::Hypocycloid => [epi, -hypo, -epi, hypo],
                OutputPlate::Epicycloid => [-epi, hypo, epi, -hypo],
            }
        })
        .collect();
    let walls = wall_contacts(&pair.groove, &curvatures, pair.contact_angle_rad, contact_modulus_Pa, track);
    let (sin_beta, cos_beta) = pair.contact_angle_rad.sin_cos();
    let mut points = Vec::with_capacity(2 * balls.len());
    let ends = curvatures.chunks_exact(2).zip(walls.chunks_exact(2));
    for (number, (curvatures, walls)) in ends.enumerate() {
        let on_tracks = &balls[number / 2];
        points.push(MeshingPoint::new(
            number / 2,
            if number % 2 == 0 { Diagonal::Plus } else { Diagonal::Minus },
            on_tracks.arm_m,
            [sin_beta, cos_beta],
            [walls[0], walls[1]],
            [curvatures[0], curvatures[1]],
            on_tracks.to_pitch_point,
        ));
    }
    MeshingPoints::new(points, pair.groove.ball_radius_m)
}
