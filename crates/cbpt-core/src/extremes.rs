//! Largest elastic angle of a drive over a period (the paper's `alpha_dmax`).
//!
//! The two pairs repeat with different periods of the crank, 2 pi/Z1 and 2 pi Z3/(Z1 Zd) with the hypocycloid plate as
//! output (2 pi/Z3 and 2 pi Z1/(Z3 Zd) with the epicycloid plate), so the drive repeats only after many of each. On a
//! grid that both periods divide, each pair needs few solutions and the sum is a look-up; the best grid point is then
//! refined on the drive itself.

use std::f64::consts::TAU;

use crate::drive::{Deceleration, Drive, EqualSpeed, Load, OutputPlate};
use crate::equilibrium::solve::solve_pair;
use crate::error::InvalidInput;
use crate::geometry::undercut::undercuts;
use crate::pair::MeshingPoints;
use crate::period;
use crate::status::Status;
use crate::sweep::Progress;

/// Place and size of the largest elastic angle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LargestAngle {
    /// Elastic angle with the sign of the torque, rad.
    pub elastic_angle_rad: f64,
    /// Crank angle where it occurs, rad.
    pub input_angle_rad: f64,
    /// Largest minus smallest size of the elastic angle over the period, rad.
    pub amplitude_rad: f64,
    /// Crank angle after which the drive repeats, rad.
    pub period_rad: f64,
}

/// Samples of one period of a pair for each period of the other in the drive's.
const SAMPLES: u32 = 24;
/// Far more than any drive asks for; with hundreds of balls the samples become fewer instead (and the amplitude is nothing).
const MOST_SOLUTIONS: u32 = 4000;

/// Samples for each ball and turn of a drive with its parts as made, and how many at most: a prime number, so that no wave of
/// the grooves comes back to the same samples.
const SAMPLES_AS_MADE: u32 = 8;
const MOST_AS_MADE: u32 = 509;

/// The crank angles at which a period of the drive is sampled. The periods of both pairs divide it.
#[derive(Debug)]
pub(crate) struct Grid {
    /// Period of the drive, rad.
    pub period_rad: f64,
    /// Samples in it.
    pub count: usize,
    /// Samples in a period of the deceleration pair.
    pub per_deceleration: usize,
    /// Samples in a period of the equal-speed pair.
    pub per_equal_speed: usize,
    /// Crank angle from one sample to the next, rad.
    pub step_rad: f64,
}

impl Grid {
    /// For elastic angles.
    fn of(drive: &Drive) -> Self {
        Self::with_slide(drive, (1, 1))
    }

    /// For friction: the motion of a cross-slide repeats every quarter turn of the crank. Parts as made are looked at over all
    /// turns after which they repeat.
    pub fn of_losses(drive: &Drive) -> Self {
        if drive.as_made().is_some() {
            return Self::of_turns(drive.repetition_turns(), drive.deceleration().ball_count);
        }
        let own_lobes = own_lobes(drive.deceleration());
        let common = greatest_common_divisor(own_lobes, 4);
        Self::with_slide(drive, (own_lobes / common, 4 / common))
    }

    /// Of so many turns of the crank, one period for both pairs.
    fn of_turns(turns: u32, balls: u32) -> Self {
        let count = turns.saturating_mul(SAMPLES_AS_MADE * balls).min(MOST_AS_MADE);
        let period_rad = TAU * f64::from(turns);
        Self {
            period_rad,
            count: count as usize,
            per_deceleration: count as usize,
            per_equal_speed: count as usize,
            step_rad: period_rad / f64::from(count),
        }
    }

    /// With the deceleration periods and equal-speed periods in one period of a drive with a balanced cross-slide.
    fn with_slide(drive: &Drive, slide: (u32, u32)) -> Self {
        let pair = drive.deceleration();
        let own_lobes = own_lobes(pair);
        // Deceleration periods (q) and equal-speed periods (w) in one period of the drive.
        let (q, w) = match drive.equal_speed() {
            EqualSpeed::RingGroove(ring) => {
                let other_lobes = 2 * pair.ball_count - own_lobes;
                let common = greatest_common_divisor(other_lobes, ring.ball_count);
                (other_lobes / common, ring.ball_count / common)
            }
            EqualSpeed::CrossSlide(_) if drive.equal_speed_period_rad().is_none() => slide,
            EqualSpeed::CrossSlide(_) => (own_lobes, 1),
        };
        let samples = (MOST_SOLUTIONS / (q + w)).clamp(1, SAMPLES);
        let period_rad = TAU / f64::from(own_lobes) * f64::from(q);
        Self {
            period_rad,
            count: (q * w * samples) as usize,
            per_deceleration: (w * samples) as usize,
            per_equal_speed: (q * samples) as usize,
            step_rad: period_rad / f64::from(q * w * samples),
        }
    }
}

impl Drive {
    /// Largest elastic angle over a period of the drive, its parts nominal, at torque M0 (N m) and preload N_Z (N).
    ///
    /// Without a solution at some angle there is no maximum: the second element is `None` and the status says why.
    ///
    /// # Errors
    /// [`InvalidInput`] for a torque or preload that cannot be.
    pub fn largest_elastic_angle(
        &self,
        torque_Nm: f64,
        preload_N: f64,
    ) -> Result<(Status, Option<LargestAngle>), InvalidInput> {
        self.largest_elastic_angle_watched(torque_Nm, preload_N, &Progress::default())
    }

    /// [`Drive::largest_elastic_angle`] for whoever may not want to wait: with a thousand balls it takes seconds.
    /// Cancelled, it ends soon and without an angle; the status is then that of what was solved.
    ///
    /// # Errors
    /// As there.
    pub fn largest_elastic_angle_watched(
        &self,
        torque_Nm: f64,
        preload_N: f64,
        progress: &Progress,
    ) -> Result<(Status, Option<LargestAngle>), InvalidInput> {
        Load::new(torque_Nm, preload_N, 0.0)?;
        let sign = if torque_Nm < 0.0 { -1.0 } else { 1.0 };
        let Grid { period_rad, count, per_deceleration, per_equal_speed, step_rad: step } = Grid::of(self);
        if undercuts(self) {
            return Ok((Status::Undercut, None));
        }
        let mut status = Status::Solved;
        let mut rotation = |points: &MeshingPoints, torque_Nm: f64| {
            let (here, state) = solve_pair(points, torque_Nm, preload_N);
            status = status.worse(here);
            state.map_or(f64::NAN, |state| sign * f64::from(points.rows) * state.state.rotation_rad)
        };
        let crank = |i: usize| i as f64 * step;
        let wanted = |_: &usize| !progress.is_cancelled();
        let decelerating: Vec<f64> = (0..per_deceleration)
            .take_while(wanted)
            .map(|i| rotation(&self.deceleration_points(self.deceleration_phase_rad(crank(i))), torque_Nm))
            .collect();
        let share = self.equal_speed_share();
        let equal: Vec<f64> = (0..per_equal_speed)
            .take_while(wanted)
            .map(|i| {
                let rows = self.equal_speed_points(self.equal_speed_phase_rad(crank(i)), crank(i));
                share * rows.iter().map(|row| rotation(row, torque_Nm * share)).sum::<f64>()
            })
            .collect();
        if !status.has_solution() || progress.is_cancelled() {
            return Ok((status, None));
        }
        let total = |i: usize| decelerating[i % per_deceleration] + equal[i % per_equal_speed];
        let (mut best, mut least) = (0, 0);
        for i in 0..count {
            if total(i) > total(best) {
                best = i;
            }
            if total(i) < total(least) {
                least = i;
            }
        }
        // The place and size of the extreme next to a grid point, the largest for `way` = 1, the smallest for -1.
        let refined = |i: usize, way: f64| {
            let middle = i as f64 * step;
            let mut size = |angle: f64| {
                if progress.is_cancelled() {
                    return f64::NEG_INFINITY;
                }
                let (_, angles) = self.nominal().points(angle).angles(torque_Nm, preload_N);
                angles.map_or(f64::NEG_INFINITY, |a| way * sign * a.elastic_angle_rad())
            };
            let (at, value) = period::golden_section(middle - step, middle + step, &mut size);
            if value > way * total(i) { (at, way * value) } else { (middle, total(i)) }
        };
        let (at, value) = refined(best, 1.0);
        let (_, smallest) = refined(least, -1.0);
        let found = LargestAngle {
            elastic_angle_rad: sign * value,
            input_angle_rad: at.rem_euclid(period_rad),
            amplitude_rad: value - smallest,
            period_rad,
        };
        Ok((status, (!progress.is_cancelled()).then_some(found)))
    }
}

/// Lobes of the groove whose plate does not turn.
fn own_lobes(pair: &Deceleration) -> u32 {
    match pair.output_plate {
        OutputPlate::Hypocycloid => pair.epicycloid_lobes(),
        OutputPlate::Epicycloid => pair.hypocycloid_lobes(),
    }
}

fn greatest_common_divisor(a: u32, b: u32) -> u32 {
    if b == 0 { a } else { greatest_common_divisor(b, a % b) }
}
