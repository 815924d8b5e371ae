//! Friction over a period of the drive: mean, ripple, wear; what drives it backwards; maps over loads.
//!
//! The pairs repeat with different periods of the crank (see [`crate::extremes`]; a cross-slide's losses repeat every quarter
//! turn). Each is sampled over its own period on a grid that both divide, so the sum over the drive's period is a look-up. A drive
//! with its parts as made repeats only after many turns of the crank; it is sampled at places spread evenly over all of them.

use rayon::prelude::*;

use crate::drive::{Drive, EqualSpeed, Load};
use crate::error::InvalidInput;
use crate::extremes::Grid;
use crate::geometry::undercut::undercuts;
use crate::status::Status;
use crate::sweep::Progress;

use super::row::{PairRows, RowFriction, deceleration_rows, equal_speed_rows};
use super::{check_coefficient, efficiency};

/// A torque over a period, N m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OverPeriod {
    /// Its mean.
    pub mean_Nm: f64,
    /// Its least value.
    pub least_Nm: f64,
    /// Its largest value.
    pub largest_Nm: f64,
}

impl OverPeriod {
    fn of(values: impl Iterator<Item = f64> + Clone) -> Self {
        let count = values.clone().count() as f64;
        Self {
            mean_Nm: values.clone().sum::<f64>() / count,
            least_Nm: values.clone().fold(f64::INFINITY, f64::min),
            largest_Nm: values.fold(f64::NEG_INFINITY, f64::max),
        }
    }

    /// Largest minus least value, N m.
    pub fn ripple_Nm(&self) -> f64 {
        self.largest_Nm - self.least_Nm
    }
}

/// Friction of a pair over its period.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PairOverPeriod {
    /// Its part of the friction torque at the input.
    pub torque: OverPeriod,
    /// Archard's index for a turn of the input, N m.
    pub wear_Nm_per_turn: f64,
    /// Largest index for a length of track and a turn of the input, of either plate's grooves, N.
    pub track_wear_N: [f64; 2],
}

impl PairOverPeriod {
    fn of(samples: &[RowFriction], coefficient: f64) -> Self {
        let torque = OverPeriod::of(samples.iter().map(|sample| coefficient * sample.loss_Nm));
        let mean = samples.iter().map(|sample| sample.loss_Nm).sum::<f64>() / samples.len() as f64;
        let largest =
            |side: usize| samples.iter().map(|sample| sample.track_wear_N[side]).fold(0.0, f64::max);
        Self {
            torque,
            wear_Nm_per_turn: std::f64::consts::TAU * mean,
            track_wear_N: [largest(0), largest(1)],
        }
    }
}

/// Friction of a drive over its period under one torque and preload.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DriveOverPeriod {
    /// Torque M0 (N m) and preload (N); the angle is 0.
    pub load: Load,
    /// Friction coefficient mu.
    pub coefficient: f64,
    /// Transmission ratio i.
    pub transmission_ratio: f64,
    /// Friction torque at the input.
    pub torque: OverPeriod,
    /// The deceleration pair.
    pub deceleration: PairOverPeriod,
    /// The equal-speed pair.
    pub equal_speed: PairOverPeriod,
    /// Angle of the crank after which the losses repeat, rad.
    pub period_rad: f64,
}

impl DriveOverPeriod {
    /// Work at the output over work at the input; 0 without torque.
    pub fn efficiency(&self) -> f64 {
        efficiency(&self.load, self.transmission_ratio, self.torque.mean_Nm)
    }

    /// Torque that the input needs on average, with the sign of the input's turn, N m.
    pub fn input_torque_Nm(&self) -> f64 {
        (self.load.torque_Nm() / self.transmission_ratio).abs() + self.torque.mean_Nm
    }

    /// Archard's index of both pairs for a turn of the input, N m.
    pub fn wear_Nm_per_turn(&self) -> f64 {
        self.deceleration.wear_Nm_per_turn + self.equal_speed.wear_Nm_per_turn
    }
}

/// What happens when the output drives and the input is free.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Backdriving {
    /// It turns from this torque at the output on, at every angle, N m.
    From {
        /// Torque at the output, N m.
        torque_Nm: f64,
    },
    /// It locks up to the torque that its preload holds, N m.
    Locks {
        /// Torque at the output at which the balls slip out, N m.
        hold_torque_Nm: f64,
    },
}

/// A drive ready at every sample of its period, for many loads.
#[derive(Debug)]
pub struct FrictionPeriod<'a> {
    drive: &'a Drive,
    grid: Grid,
    deceleration: Vec<PairRows>,
    equal_speed: Vec<PairRows>,
}

/// One load's outcome.
pub type PeriodRow = (Status, Option<DriveOverPeriod>);

impl<'a> FrictionPeriod<'a> {
    /// The samples of a drive.
    pub fn new(drive: &'a Drive) -> Self {
        let grid = Grid::of_losses(drive);
        let crank = |sample: usize| sample as f64 * grid.step_rad;
        let (deceleration, equal_speed) = if undercuts(drive) {
            (Vec::new(), Vec::new())
        } else {
            let first = |i| deceleration_rows(drive, crank(i));
            let second = |i| equal_speed_rows(drive, crank(i));
            ((0..grid.per_deceleration).map(first).collect(), (0..grid.per_equal_speed).map(second).collect())
        };
        Self { drive, grid, deceleration, equal_speed }
    }

    /// Friction over the period at torque M0 (N m) and preload (N); a status where some angle has no solution.
    ///
    /// # Errors
    /// [`InvalidInput`] for a load or a coefficient that cannot be.
    pub fn at(&self, torque_Nm: f64, preload_N: f64, coefficient: f64) -> Result<PeriodRow, InvalidInput> {
        check_coefficient(coefficient)?;
        let load = Load::new(torque_Nm, preload_N, 0.0)?;
        if self.deceleration.is_empty() {
            return Ok((Status::Undercut, None));
        }
        let (first, deceleration) = samples(&self.deceleration, &load);
        let (second, equal_speed) = if of_balanced_slide(self.drive) {
            self.slide_samples(&load)
        } else {
            samples(&self.equal_speed, &load)
        };
        let status = first.worse(second);
        let (Some(deceleration), Some(equal_speed)) = (deceleration, equal_speed) else {
            return Ok((status, None));
        };
        let sum = |i: usize| {
            let one = &deceleration[i % deceleration.len()];
            let other = &equal_speed[i % equal_speed.len()];
            coefficient * (one.loss_Nm + other.loss_Nm)
        };
        let found = DriveOverPeriod {
            load,
            coefficient,
            transmission_ratio: self.drive.transmission_ratio(),
            torque: OverPeriod::of((0..self.grid.count).map(sum)),
            deceleration: PairOverPeriod::of(&deceleration, coefficient),
            equal_speed: PairOverPeriod::of(&equal_speed, coefficient),
            period_rad: self.grid.period_rad,
        };
        Ok((status, Some(found)))
    }

    /// A balanced cross-slide at all samples: its forces are the same at every angle and no plate turns, so the loss of a row
    /// is in proportion to its speed, |cos| and |sin| of the crank; with the crank at 0 the first has all of it.
    fn slide_samples(&self, load: &Load) -> (Status, Option<Vec<RowFriction>>) {
        let (status, found) = samples(&self.equal_speed[..1], load);
        let sample = |at_0: &RowFriction, i: usize| {
            let (sin, cos) = (i as f64 * self.grid.step_rad).sin_cos();
            RowFriction { loss_Nm: at_0.loss_Nm * (sin.abs() + cos.abs()), ..at_0.clone() }
        };
        let all =
            |found: Vec<RowFriction>| (0..self.grid.per_equal_speed).map(|i| sample(&found[0], i)).collect();
        (status, found.map(all))
    }

    /// The same for many loads, torque (N m) and preload (N), on all cores and in their order; `None` if it was cancelled.
    ///
    /// # Errors
    /// As [`FrictionPeriod::at`].
    pub fn map(
        &self,
        loads: &[[f64; 2]],
        coefficient: f64,
        progress: &Progress,
    ) -> Result<Option<Vec<PeriodRow>>, InvalidInput> {
        let row = |[torque_Nm, preload_N]: &[f64; 2]| {
            if progress.is_cancelled() {
                return Ok((Status::Indeterminate, None));
            }
            let row = self.at(*torque_Nm, *preload_N, coefficient);
            progress.add(1);
            row
        };
        let rows: Result<Vec<PeriodRow>, InvalidInput> = loads.par_iter().map(row).collect();
        Ok(Some(rows?).filter(|_| !progress.is_cancelled()))
    }

    /// Torque at the output that drives a free input at every angle, or that there is none below what the preload holds.
    ///
    /// The least M with |M/i| = T(M), T the largest friction torque over the period under M.
    ///
    /// # Errors
    /// As [`FrictionPeriod::at`].
    pub fn backdriving(&self, preload_N: f64, coefficient: f64) -> Result<Backdriving, InvalidInput> {
        // Parts as made hold what nominal ones do.
        let per_torque = self.drive.nominal().preload_thresholds(1.0).drive().hold_N;
        let hold_torque_Nm = preload_N / per_torque;
        let ratio = self.drive.transmission_ratio().abs();
        let needed = |torque_Nm: f64| -> Result<Option<f64>, InvalidInput> {
            let (_, found) = self.at(torque_Nm, preload_N, coefficient)?;
            Ok(found.map(|found| ratio * found.torque.largest_Nm))
        };
        // Friction hardly depends on the torque, so M -> i T(M) comes nearer at every step and from below.
        let mut torque_Nm = 0.0;
        for _ in 0..MOST_STEPS {
            match needed(torque_Nm)? {
                Some(next) if next < hold_torque_Nm => {
                    let step = (next - torque_Nm).abs();
                    torque_Nm = next;
                    if step <= 1e-12 * next {
                        break;
                    }
                }
                _ => return Ok(Backdriving::Locks { hold_torque_Nm }),
            }
        }
        Ok(Backdriving::From { torque_Nm })
    }
}

/// Whether the equal-speed pair is a cross-slide whose forces do not depend on the angle, the same in both rows.
fn of_balanced_slide(drive: &Drive) -> bool {
    drive.as_made().is_none()
        && matches!(drive.equal_speed(), EqualSpeed::CrossSlide(_))
        && drive.equal_speed_period_rad().is_none()
}

/// Steps towards the torque that drives backwards; each takes off a factor of the rest.
const MOST_STEPS: u32 = 100;

/// A pair at all samples; `None` where one has no solution.
fn samples(rows: &[PairRows], load: &Load) -> (Status, Option<Vec<RowFriction>>) {
    let mut status = Status::Solved;
    let mut found = Vec::with_capacity(rows.len());
    for row in rows {
        let (here, friction) = row.at(load.torque_Nm(), load.preload_N(), false);
        status = status.worse(here);
        found.extend(friction);
    }
    let whole = found.len() == rows.len();
    (status, whole.then_some(found))
}
