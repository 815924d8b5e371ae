//! The rows of balls of a pair, ready at one place: a load to forces, spins and losses. Losses here are over mu.

use crate::drive::Drive;
use crate::equilibrium::ContactLaw;
use crate::equilibrium::solve::solve_pair;
use crate::pair::{Diagonal, MeshingPoint, MeshingPoints};
use crate::status::Status;

use super::LARGEST_GAP;
use super::kinematics::{self, RowMotion, pivoting_arms_at_1N_m};
use super::spin::{MOST_TOUCHES, Spin, Touch, least_dissipation};

/// One contact of a ball with a groove.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContactFriction {
    /// Row of the pair, from 0; only a cross-slide has two.
    pub row: usize,
    /// Number of the ball in it, from 0.
    pub ball: usize,
    /// Diagonal of the ball.
    pub diagonal: Diagonal,
    /// Which plate: 0 the driving (epicycloid, planet) plate, 1 the one opposite.
    pub side: usize,
    /// Normal force, N.
    pub force_N: f64,
    /// Slip along the track for each radian of the input, m.
    pub slip_m: f64,
    /// Turn of the ball about the contact normal against the plate, for each radian of the input.
    pub pivoting: f64,
    /// Its part of the friction torque at the input, N m.
    pub torque_Nm: f64,
}

impl ContactFriction {
    /// The contact with its torque times mu.
    pub(super) fn with(self, coefficient: f64) -> Self {
        Self { torque_Nm: coefficient * self.torque_Nm, ..self }
    }
}

/// What rows lose under a load, over mu.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct RowFriction {
    /// Loss for each radian of the input, N m.
    pub loss_Nm: f64,
    /// Largest loss for a length of track and a turn of the input, of either plate's grooves, N.
    pub track_wear_N: [f64; 2],
    /// Largest relative distance of a ball's loss from its proved lower bound.
    pub gap: f64,
    /// The loaded contacts, where they are wanted.
    pub contacts: Vec<ContactFriction>,
}

/// The rows of a pair at one place.
#[derive(Debug, Clone)]
pub(super) struct PairRows {
    /// Meshing points with their pivoting arms under 1 N; one for all rows where these are equal.
    points: Vec<(MeshingPoints, Vec<[f64; 2]>)>,
    motions: Vec<RowMotion>,
    /// Torque of the pair over M0.
    share: f64,
}

/// The deceleration pair at an angle of the crank (rad), with the parts as they were made.
pub(super) fn deceleration_rows(drive: &Drive, input_angle_rad: f64) -> PairRows {
    let motion = kinematics::deceleration(drive, drive.deceleration_phase_rad(input_angle_rad));
    PairRows::new(vec![drive.deceleration_as_made(input_angle_rad)], vec![motion], 1.0)
}

/// The equal-speed pair at an angle of the crank (rad), with the parts as they were made.
pub(super) fn equal_speed_rows(drive: &Drive, input_angle_rad: f64) -> PairRows {
    let motions = kinematics::equal_speed(drive, input_angle_rad);
    PairRows::new(drive.equal_speed_as_made(input_angle_rad), motions, drive.equal_speed_share())
}

impl PairRows {
    fn new(points: Vec<MeshingPoints>, motions: Vec<RowMotion>, share: f64) -> Self {
        let with_arms = |points: MeshingPoints| {
            let arms = pivoting_arms_at_1N_m(&points);
            (points, arms)
        };
        Self { points: points.into_iter().map(with_arms).collect(), motions, share }
    }

    /// Under torque M0 of the drive (N m) and preload (N); with every contact if `listed`.
    pub fn at(&self, torque_Nm: f64, preload_N: f64, listed: bool) -> (Status, Option<RowFriction>) {
        let mut status = Status::Solved;
        let mut forces = Vec::with_capacity(self.points.len());
        for (points, _) in &self.points {
            let (here, solved) = solve_pair(points, torque_Nm * self.share, preload_N);
            status = status.worse(here);
            let Some(solved) = solved else { return (status, None) };
            let law = ContactLaw::new(points.exponent);
            let force = |point: &MeshingPoint| {
                if point.exists() {
                    law.force_N(point.stiffness, solved.state.deformation_m(point))
                } else {
                    0.0
                }
            };
            forces.push(points.points.iter().map(force).collect::<Vec<f64>>());
        }
        let mut found = RowFriction::default();
        for (row, motion) in self.motions.iter().enumerate() {
            let place = row.min(self.points.len() - 1);
            let (points, arms) = &self.points[place];
            let mut sum = RowSum { row, motion, arms, found: &mut found, listed };
            for (ball, two) in points.points.chunks(2).enumerate() {
                sum.add(points.ball_radius_m, 2 * ball, two, &forces[place]);
            }
        }
        if found.gap > LARGEST_GAP {
            return (status.worse(Status::NotConverged { residual: found.gap }), None);
        }
        (status, Some(found))
    }
}

/// A row that is summed up ball by ball.
struct RowSum<'a> {
    row: usize,
    motion: &'a RowMotion,
    arms: &'a [[f64; 2]],
    found: &'a mut RowFriction,
    listed: bool,
}

impl RowSum<'_> {
    /// The ball with these diagonals, the first of them at place `first` of the row.
    fn add(&mut self, ball_radius_m: f64, first: usize, diagonals: &[MeshingPoint], forces_N: &[f64]) {
        let mut touches = [None; MOST_TOUCHES];
        let mut count = 0;
        for (offset, point) in diagonals.iter().enumerate() {
            let force_N = forces_N[first + offset];
            for (side, arm) in self.arms[first + offset].iter().enumerate() {
                if force_N > 0.0 {
                    let touch = self.motion.touch(point, side, force_N, arm * force_N.cbrt());
                    touches[count] = Some((offset, side, touch));
                    count += 1;
                }
            }
        }
        let loaded: Vec<Touch> = touches.iter().flatten().map(|(_, _, touch)| *touch).collect();
        let Spin { spin, loss_Nm, gap } = least_dissipation(ball_radius_m, &loaded);
        self.found.loss_Nm += loss_Nm;
        self.found.gap = self.found.gap.max(gap);
        let mut of_side = [0.0; 2];
        for (offset, side, touch) in touches.iter().flatten() {
            let motion = touch.motion(ball_radius_m, spin);
            let torque_Nm = touch.loss_Nm(motion);
            of_side[*side] += torque_Nm;
            if self.listed {
                self.found.contacts.push(ContactFriction {
                    row: self.row,
                    ball: diagonals[*offset].ball,
                    diagonal: diagonals[*offset].diagonal,
                    side: *side,
                    force_N: touch.force_N,
                    slip_m: motion[0],
                    pivoting: motion[1],
                    torque_Nm,
                });
            }
        }
        let Some(point) = diagonals.first() else { return };
        let speeds = self.motion.balls[point.ball].track_speeds_m;
        for side in 0..2 {
            let speed = speeds[side].abs();
            if speed > 0.0 {
                let wear = self.motion.passes[side] * of_side[side] / speed;
                self.found.track_wear_N[side] = self.found.track_wear_N[side].max(wear);
            }
        }
    }
}
