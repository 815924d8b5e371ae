//! A drive over the turns of the crank after which all of it stands as before: what repeats when, and what each ball carries.
//!
//! Against the line of centres the fixed groove comes round once in a turn of the crank, the planet and with it the rings
//! Z1/Z3 times (Z3/Z1 with the epicycloid plate as output), the deceleration balls Z1/Z2 (Z3/Z2) times. Grooves alone let
//! every ball take the place of the next; only where balls differ must each come back to its own.

use rayon::prelude::*;

use crate::as_made::Plate;
use crate::drive::{Drive, EqualSpeed, Load, OutputPlate};
use crate::equilibrium::report::PairSolution;
use crate::status::Status;
use crate::sweep::Progress;

/// What the balls carry under one load.
#[derive(Debug, Clone, PartialEq)]
pub struct BallLoads {
    /// Of the deceleration pair, ball by ball.
    pub deceleration: Vec<BallLoad>,
    /// Of the equal-speed pair (of a cross-slide its first row).
    pub equal_speed: Vec<BallLoad>,
}

/// What a ball carries.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct BallLoad {
    /// Of the preload, N: the axial force of both its diagonals.
    pub axial_N: f64,
    /// Of the torque of its pair, N m.
    pub torque_Nm: f64,
    /// The larger of the normal forces of its diagonals, N.
    pub normal_N: f64,
}

impl Drive {
    /// Turns of the crank for one turn of each part against the line of centres: of the planet and of the ball ring, each
    /// as turns of the part in so many turns of the crank.
    pub fn turns_of_parts(&self) -> [[u32; 2]; 2] {
        let pair = self.deceleration();
        let (z1, z2, z3) = (pair.epicycloid_lobes(), pair.ball_count, pair.hypocycloid_lobes());
        let [planet, balls] = match pair.output_plate {
            OutputPlate::Hypocycloid => [[z1, z3], [z1, z2]],
            OutputPlate::Epicycloid => [[z3, z1], [z3, z2]],
        };
        [planet, balls].map(|[turns, of_crank]| {
            let common = greatest_common_divisor(turns, of_crank);
            [turns / common, of_crank / common]
        })
    }

    /// Turns of the crank after which the drive, its parts as they were made, stands as before.
    pub fn repetition_turns(&self) -> u32 {
        let [[_, planet], [_, balls]] = self.turns_of_parts();
        let made = self.as_made();
        let turns_with_planet = matches!(self.equal_speed(), EqualSpeed::RingGroove(_))
            || made.is_some_and(|made| match self.deceleration().output_plate {
                OutputPlate::Hypocycloid => {
                    made.hypocycloid.is_some() || made.hypocycloid_plate != Plate::default()
                }
                OutputPlate::Epicycloid => {
                    made.epicycloid.is_some() || made.epicycloid_plate != Plate::default()
                }
            });
        let by_ball = made.is_some_and(|made| !made.deceleration_balls_m.is_empty());
        let of_planet = if turns_with_planet { planet } else { 1 };
        let of_balls = if by_ball { balls } else { 1 };
        of_planet / greatest_common_divisor(of_planet, of_balls) * of_balls
    }

    /// What every ball carries under each load, on all cores; `None` where a load has no solution, and where it was
    /// cancelled.
    pub fn ball_loads(&self, loads: &[Load], progress: &Progress) -> Vec<(Status, Option<BallLoads>)> {
        let of = |load: &Load| {
            if progress.is_cancelled() {
                return (Status::Indeterminate, None);
            }
            let solution = self.solve(load);
            progress.add(1);
            let carried = solution.deceleration.as_ref().zip(solution.equal_speed.as_ref());
            let found = carried.map(|(deceleration, equal_speed)| {
                let points = self.points(load.input_angle_rad());
                BallLoads {
                    deceleration: carried_by(deceleration, &points.deceleration),
                    equal_speed: points
                        .equal_speed
                        .first()
                        .map_or_else(Vec::new, |row| carried_by(equal_speed, row)),
                }
            });
            (solution.status, found)
        };
        loads.par_iter().map(of).collect()
    }
}

fn carried_by(solved: &PairSolution, points: &crate::pair::MeshingPoints) -> Vec<BallLoad> {
    let balls = points.points.iter().map(|point| point.ball + 1).max().unwrap_or(0);
    let mut carried = vec![BallLoad::default(); balls];
    for (point, load) in points.points.iter().zip(&solved.points) {
        let ball = &mut carried[point.ball];
        ball.axial_N += load.force_N * point.sin_beta;
        ball.torque_Nm += load.force_N * point.cos_beta * point.signed_arm_m();
        ball.normal_N = ball.normal_N.max(load.force_N);
    }
    carried
}

fn greatest_common_divisor(a: u32, b: u32) -> u32 {
    if b == 0 { a } else { greatest_common_divisor(b, a % b) }
}
