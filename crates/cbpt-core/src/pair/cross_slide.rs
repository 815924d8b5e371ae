//! Meshing points of one row of the cross-slide equal-speed pair (CSGES).
//!
//! A floating plate lies between two rows of straight grooves at right angles. It is held by balls alone, so across the
//! grooves of a row the forces balance and the plate shifts by t until they do; the shift of the ball circle along the
//! grooves then drops out. Arms a = RS cos(2 pi n / ZS); both rows are equal and in series.
//!
//! The 2017 paper adds the shift e cos(phi) (second row: e sin(phi)) to every arm and has no balance across; that form
//! is kept only to compare with it.

use std::f64::consts::TAU;

use crate::drive::{CrossSlide, CrossSlideForm, TrackCurvature};
use crate::geometry::wall::wall_contacts;
use crate::pair::{Diagonal, MeshingPoint, MeshingPoints};

/// The meshing points of one row; `shift_m` is the paper's addition to the arms and is used by its form alone.
pub fn meshing_points(
    pair: &CrossSlide,
    contact_modulus_Pa: f64,
    track: TrackCurvature,
    shift_m: f64,
) -> MeshingPoints {
    let added = match pair.form {
        CrossSlideForm::Balanced => 0.0,
        CrossSlideForm::Paper => shift_m,
    };
    let (sin_beta, cos_beta) = pair.contact_angle_rad.sin_cos();
    let straight = std::iter::once((0.0, cos_beta));
    let wall = wall_contacts(&pair.groove, straight, contact_modulus_Pa, track)[0];
    let mut points = Vec::with_capacity(2 * pair.ball_count as usize);
    for ball in 0..pair.ball_count {
        let angle = TAU * f64::from(ball) / f64::from(pair.ball_count);
        let arm = pair.pitch_radius_m * angle.cos() + added;
        for diagonal in [Diagonal::Plus, Diagonal::Minus] {
            let point =
                MeshingPoint::new(ball as usize, diagonal, arm, [sin_beta, cos_beta], [0.0; 2], [0.0, -1.0]);
            points.push(point.with_walls([wall; 2]));
        }
    }
    MeshingPoints {
        floats_sideways: pair.form == CrossSlideForm::Balanced,
        rows: if pair.form == CrossSlideForm::Balanced { 2 } else { 1 },
        ..MeshingPoints::new(points, pair.groove.ball_radius_m)
    }
}
