//! Parts as made to the offsets of the meshing points: zeta, g and p of every ball at a crank angle.
//!
//! - in the plane, deceleration: every in-plane normal points from the ball to the pitch point, which is always inwards, so a
//!   deviation n outwards is one away from the pitch point on both grooves. It lets go of the plus diagonal on the plate that
//!   drives the output and presses on it on the other: p = n(other plate) - n(output plate);
//! - in the plane, ring grooves: the plus diagonal lies between the two outside walls: p = -(n(planet) + n(facing));
//! - a plate's offset v is the deviation v . n of all its grooves, n the outward normal;
//! - along the normal: g = diameter - 2 r;
//! - axial: zeta = R (c cos t + s sin t) of each plate, with the sign turned on the planet's other face.
//!
//! A cross-slide's floating plate takes up offsets by itself, so only the diameters of its balls count.

use std::f64::consts::{PI, TAU};

use crate::as_made::{AsMade, Plate, Profile};
use crate::drive::{Deceleration, Drive, EqualSpeed, OutputPlate};
use crate::geometry::trochoid::BallOnTracks;
use crate::pair::MeshingPoints;

/// Puts the offsets of the parts as made on the deceleration pair at the phase Phi (rad), whose line of centres stands at
/// these angles (rad) in the epicycloid and in the hypocycloid plate.
pub fn on_deceleration(drive: &Drive, points: &mut MeshingPoints, phase_rad: f64, line_rad: [f64; 2]) {
    let Some(made) = drive.as_made() else { return };
    let pair = drive.deceleration();
    for ball in 0..pair.ball_count {
        let from_line_rad = phase_rad + TAU * f64::from(ball) / f64::from(pair.ball_count);
        let (epicycloid, hypocycloid) = deviations(made, pair, from_line_rad, line_rad);
        let in_plane = match pair.output_plate {
            OutputPlate::Hypocycloid => epicycloid - hypocycloid,
            OutputPlate::Epicycloid => hypocycloid - epicycloid,
        };
        let plates = [&made.epicycloid_plate, &made.hypocycloid_plate];
        let lifts = [0, 1].map(|plate| lift(plates[plate], from_line_rad + line_rad[plate]));
        let oversize = oversize(&made.deceleration_balls_m, ball as usize, pair.groove.ball_radius_m);
        add(points, ball as usize, [pair.pitch_radius_m() * (lifts[0] + lifts[1]), oversize, in_plane]);
    }
}

/// Puts them on the equal-speed pair at the planet's angle psi (rad); a cross-slide whose balls were measured becomes two
/// rows.
pub fn on_equal_speed(drive: &Drive, rows: &mut Vec<MeshingPoints>, phase_rad: f64) {
    let Some(made) = drive.as_made() else { return };
    match drive.equal_speed() {
        EqualSpeed::RingGroove(ring) => {
            let (planet_plate, outward) = match drive.deceleration().output_plate {
                OutputPlate::Hypocycloid => (&made.hypocycloid_plate, 0.0),
                OutputPlate::Epicycloid => (&made.epicycloid_plate, PI),
            };
            // From the ring's centre to its ball, seen from the plates, which turn alike.
            let [planet_rad, facing_rad] = [outward - phase_rad, outward + PI - phase_rad];
            for ball in 0..ring.ball_count {
                let place = ball as usize;
                let on_plate_rad = TAU * f64::from(ball) / f64::from(ring.ball_count);
                let outwards = deviation(made.planet_rings.get(place), planet_rad)
                    + shift(planet_plate, planet_rad)
                    + deviation(made.facing_rings.get(place), facing_rad)
                    + shift(&made.ring_plate, facing_rad);
                let lifted = lift(&made.ring_plate, on_plate_rad) - lift(planet_plate, on_plate_rad);
                let oversize = oversize(&made.equal_speed_balls_m, place, ring.groove.ball_radius_m);
                for row in &mut *rows {
                    add(row, place, [ring.pitch_radius_m * lifted, oversize, -outwards]);
                }
            }
        }
        EqualSpeed::CrossSlide(slide) if !made.equal_speed_balls_m.is_empty() => {
            if let [both] = rows.as_slice() {
                let one = MeshingPoints { rows: 1, ..both.clone() };
                *rows = vec![one.clone(), one];
            }
            let balls = slide.ball_count as usize;
            for (number, row) in rows.iter_mut().enumerate() {
                for ball in 0..balls {
                    let place = number * balls + ball;
                    let oversize = oversize(&made.equal_speed_balls_m, place, slide.groove.ball_radius_m);
                    add(row, ball, [0.0, oversize, 0.0]);
                }
            }
        }
        EqualSpeed::CrossSlide(_) => {}
    }
}

/// How far the epicycloid and the hypocycloid groove lie further out at a ball, m.
fn deviations(made: &AsMade, pair: &Deceleration, from_line_rad: f64, line_rad: [f64; 2]) -> (f64, f64) {
    let [inward_along, inward_across] = BallOnTracks::at(pair, from_line_rad).to_pitch_point;
    let outward_rad = (-inward_across).atan2(-inward_along);
    let of = |plate: &Plate, profile: &Option<Profile>, line_rad: f64| {
        deviation(profile.as_ref(), from_line_rad + line_rad) + shift(plate, outward_rad + line_rad)
    };
    (
        of(&made.epicycloid_plate, &made.epicycloid, line_rad[0]),
        of(&made.hypocycloid_plate, &made.hypocycloid, line_rad[1]),
    )
}

fn deviation(profile: Option<&Profile>, angle_rad: f64) -> f64 {
    profile.map_or(0.0, |profile| profile.at_m(angle_rad))
}

/// A plate's offset in a direction of the plate, m.
fn shift(plate: &Plate, direction_rad: f64) -> f64 {
    plate.offset_m[0] * direction_rad.cos() + plate.offset_m[1] * direction_rad.sin()
}

/// How far a tilted plate is lifted at an angle of the plate, m at a radius of 1 m.
fn lift(plate: &Plate, angle_rad: f64) -> f64 {
    plate.tilt_rad[0] * angle_rad.cos() + plate.tilt_rad[1] * angle_rad.sin()
}

fn oversize(diameters_m: &[f64], ball: usize, nominal_radius_m: f64) -> f64 {
    diameters_m.get(ball).map_or(0.0, |diameter| diameter - 2.0 * nominal_radius_m)
}

fn add(points: &mut MeshingPoints, ball: usize, [axial, normal, in_plane]: [f64; 3]) {
    for point in points.points.iter_mut().filter(|point| point.ball == ball) {
        point.axial_offset_m += axial;
        point.normal_offset_m += normal;
        point.in_plane_offset_m += in_plane;
    }
}
