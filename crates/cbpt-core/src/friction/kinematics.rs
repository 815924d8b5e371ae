//! How balls and plates move for one radian of the input. Rigid and exact.
//!
//! In the crank's frame plate k turns about its own centre, `Omega_1` : `Omega_2` : `Omega_3` = 1/Z1 : 1/Z2 : 1/Z3 (the pitch circles
//! Zk e roll on each other at P); the plate that does not turn against the housing has Omega = -1.
//! - Deceleration: the centre of a ball moves against plate k about P, at (`Omega_2` - `Omega_k`) rho with rho = R sqrt(D).
//! - Ring grooves: planet and output turn at one Omega; the ball stands on the circle of balls between them, e from the
//!   centre of each ring, and moves against them at +- e Omega.
//! - Cross-slide: no plate turns. The planet's circle of radius 2 e has one component along each row, half of it on either
//!   side of the balls: +- e cos(theta), +- e sin(theta). Neglected: the turn of the floating plate within its elastic
//!   shift, its inertia, and what happens where the balls turn round.

use crate::drive::{Drive, EqualSpeed, OutputPlate};
use crate::pair::{MeshingPoint, MeshingPoints};

use super::spin::Touch;

/// The motion of a ball against the two plates that it lies between, the driving (epicycloid, planet) plate first.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BallMotion {
    /// Speed of its centre against each plate along the track t, m for each radian of the input.
    pub track_speeds_m: [f64; 2],
    /// Turn of each plate in the frame of the crank.
    pub plate_turns: [f64; 2],
}

/// The motion of a row of balls.
#[derive(Debug, Clone, PartialEq)]
pub struct RowMotion {
    /// Ball by ball.
    pub balls: Vec<BallMotion>,
    /// Which of the two plates the row drives, or 1.
    pub output_side: usize,
    /// How often a ball passes a place of each plate's grooves in a turn of the input.
    pub passes: [f64; 2],
}

impl RowMotion {
    /// A contact of a diagonal: its end at one of the two plates.
    pub fn touch(&self, point: &MeshingPoint, side: usize, force_N: f64, pivoting_arm_m: f64) -> Touch {
        // The output plate pushes the ball along n on the plus diagonal, so its wall lies on the other side of the ball.
        let towards = if side == self.output_side { -1.0 } else { 1.0 };
        let axial = if side == 0 { 1.0 } else { -1.0 };
        let ball = &self.balls[point.ball];
        Touch {
            normal: [point.diagonal.sign() * towards * point.cos_beta, axial * point.sin_beta],
            track_speed_m: ball.track_speeds_m[side],
            plate_turn: ball.plate_turns[side],
            force_N,
            pivoting_arm_m,
        }
    }
}

/// Turn of plate k in the frame of the crank for one radian of the input: epicycloid, balls, hypocycloid.
pub fn plate_turns(drive: &Drive) -> [f64; 3] {
    let pair = drive.deceleration();
    let lobes = [pair.epicycloid_lobes(), pair.ball_count, pair.hypocycloid_lobes()].map(f64::from);
    let fixed = match pair.output_plate {
        OutputPlate::Hypocycloid => lobes[0],
        OutputPlate::Epicycloid => lobes[2],
    };
    lobes.map(|lobes| -fixed / lobes)
}

/// Motion of the deceleration balls at their phase Phi (rad).
pub fn deceleration(drive: &Drive, phase_rad: f64) -> RowMotion {
    let pair = drive.deceleration();
    let [epicycloid, balls, hypocycloid] = plate_turns(drive);
    let (turns, k) = ([epicycloid, hypocycloid], pair.short_amplitude_coefficient);
    let count = f64::from(pair.ball_count);
    let motion = |ball: u32| {
        let phi = phase_rad + std::f64::consts::TAU * f64::from(ball) / count;
        // D = (1 - K)^2 + 4 K sin^2(phi/2) keeps its digits.
        let d = (1.0 - k) * (1.0 - k) + 4.0 * k * (0.5 * phi).sin().powi(2);
        let from_pitch_point_m = pair.pitch_radius_m() * d.sqrt();
        BallMotion {
            track_speeds_m: turns.map(|turn| (balls - turn) * from_pitch_point_m),
            plate_turns: turns,
        }
    };
    RowMotion {
        balls: (0..pair.ball_count).map(motion).collect(),
        output_side: match pair.output_plate {
            OutputPlate::Hypocycloid => 1,
            OutputPlate::Epicycloid => 0,
        },
        passes: turns.map(|turn| count * (balls - turn).abs()),
    }
}

/// Motion of the rows of the equal-speed pair at a crank angle (rad), as many as it has.
pub fn equal_speed(drive: &Drive, input_angle_rad: f64) -> Vec<RowMotion> {
    let e = drive.deceleration().eccentricity_m();
    let count = drive.equal_speed().ball_count() as usize;
    let row = |speed_m: f64, turn: f64, passes: f64| RowMotion {
        balls: vec![BallMotion { track_speeds_m: [speed_m, -speed_m], plate_turns: [turn; 2] }; count],
        output_side: 1,
        passes: [passes; 2],
    };
    match drive.equal_speed() {
        EqualSpeed::RingGroove(_) => {
            let [epicycloid, _, hypocycloid] = plate_turns(drive);
            let turn = match drive.deceleration().output_plate {
                OutputPlate::Hypocycloid => hypocycloid,
                OutputPlate::Epicycloid => epicycloid,
            };
            vec![row(e * turn, turn, turn.abs())]
        }
        EqualSpeed::CrossSlide(_) => {
            let (sin, cos) = input_angle_rad.sin_cos();
            vec![row(e * cos, 0.0, 2.0), row(e * sin, 0.0, 2.0)]
        }
    }
}

/// kappa = (3/8) a E(m) of both walls of every point under 1 N, m; 0 where a wall is missing.
pub fn pivoting_arms_at_1N_m(points: &MeshingPoints) -> Vec<[f64; 2]> {
    let arm = |wall: Option<crate::hertz::HertzContact>| wall.map_or(0.0, |c| c.pivoting_arm_at_1N_m());
    points.points.iter().map(|point| point.walls.map(arm)).collect()
}
