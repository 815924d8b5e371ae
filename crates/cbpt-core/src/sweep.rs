//! Many loads on one drive, on all cores and in the lanes of each.
//!
//! - [`solve_all`], [`solve_into`]: one drive, many loads; [`solve_each`]: a drive for every load.
//!
//! Loads may come in any order: the sweep gathers those at one input angle, makes their meshing points once, and solves
//! them side by side ([`crate::equilibrium::lanes`]). A load without solution is a row with its status.

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use rayon::prelude::*;

use crate::drive::{Drive, Load};
use crate::equilibrium::lanes::{BATCH, FEW, LaneOutcome, LanePair, two_thirds_powers};
use crate::geometry::undercut::undercuts;
use crate::status::Status;
use crate::transmission::{Angles, DrivePoints};

/// Shared between a running sweep and whoever watches it.
#[derive(Debug, Default)]
pub struct Progress {
    done: AtomicUsize,
    cancelled: AtomicBool,
}

impl Progress {
    /// Loads solved so far.
    pub fn done(&self) -> usize {
        self.done.load(Ordering::Relaxed)
    }

    /// So many more are solved.
    pub fn add(&self, count: usize) {
        self.done.fetch_add(count, Ordering::Relaxed);
    }

    /// Asks the sweep to stop soon.
    pub fn cancel(&self) {
        self.cancelled.store(true, Ordering::Relaxed);
    }

    /// Whether it was asked to stop.
    pub fn is_cancelled(&self) -> bool {
        self.cancelled.load(Ordering::Relaxed)
    }
}

/// Loads that a thread looks through at a time.
const LOOKED_AT: usize = 1 << 14;

/// One load's outcome.
pub type Row = (Status, Option<Angles>);

/// Solves every load on all cores: one row for each load, in their order; `None` if the sweep was cancelled.
///
/// ```
/// use cbpt_core::sweep::{Progress, solve_all};
/// use cbpt_core::{Drive, Load};
///
/// let drive = Drive::paper_base_case();
/// let loads: Vec<Load> =
///     (0..100).map(|i| Load::new(0.1 * f64::from(i), 600.0, 0.0)).collect::<Result<_, _>>()?;
/// let progress = Progress::default(); // another thread may watch or cancel it
/// let rows = solve_all(&drive, &loads, &progress).expect("nobody cancels");
/// assert_eq!((rows.len(), progress.done()), (100, 100));
/// let angles = rows.iter().filter_map(|(_, angles)| angles.map(|angles| angles.elastic_angle_rad()));
/// assert!(angles.is_sorted()); // rad; the angle grows with the torque
/// # Ok::<(), cbpt_core::InvalidInput>(())
/// ```
pub fn solve_all(drive: &Drive, loads: &[Load], progress: &Progress) -> Option<Vec<Row>> {
    let mut rows = vec![(Status::Undercut, None); loads.len()];
    solve_into(drive, loads, &mut rows, progress).then_some(rows)
}

/// Solves each load into the row at its place; rows beyond the loads stay as they are. Whether it came to the end: `false`
/// if the sweep was cancelled, and then some rows are not solved.
pub fn solve_into(drive: &Drive, loads: &[Load], rows: &mut [Row], progress: &Progress) -> bool {
    if undercuts(drive) {
        rows.iter_mut().zip(loads).for_each(|(row, _)| *row = (Status::Undercut, None));
        return !progress.is_cancelled();
    }
    if sorted(loads) {
        solve_sorted(drive, loads, rows, progress);
    } else {
        let mut order: Vec<usize> = (0..loads.len().min(rows.len())).collect();
        order.sort_by_key(|&place| angle(&loads[place]));
        let sorted: Vec<Load> = order.iter().map(|&place| loads[place]).collect();
        let mut solved = vec![(Status::Undercut, None); sorted.len()];
        solve_sorted(drive, &sorted, &mut solved, progress);
        for (place, row) in order.into_iter().zip(solved) {
            rows[place] = row;
        }
    }
    !progress.is_cancelled()
}

fn angle(load: &Load) -> u64 {
    load.input_angle_rad().to_bits()
}

/// Whether loads come by their input angle. On all cores: to look at a load takes a tenth of what its solution takes.
fn sorted(loads: &[Load]) -> bool {
    let parts = loads.len().div_ceil(LOOKED_AT);
    (0..parts).into_par_iter().all(|part| {
        let first = part * LOOKED_AT;
        // And the first of the next part.
        let end = (first + LOOKED_AT + 1).min(loads.len());
        loads[first..end].windows(2).all(|two| angle(&two[0]) <= angle(&two[1]))
    })
}

/// Solves sorted loads.
fn solve_sorted(drive: &Drive, loads: &[Load], rows: &mut [Row], progress: &Progress) {
    // Of sorted loads whose ends are at one angle all are there.
    let at: Vec<&[Load]> = match loads {
        [] => Vec::new(),
        [first, .., last] if angle(first) == angle(last) => vec![loads],
        _ => loads.chunk_by(|a, b| angle(a) == angle(b)).collect(),
    };
    let mut rest = rows;
    let mut runs = Vec::with_capacity(at.len());
    for run in at {
        let (own, others) = rest.split_at_mut(run.len().min(rest.len()));
        rest = others;
        runs.push((run, own));
    }
    runs.into_par_iter().for_each(|(run, rows)| {
        if progress.is_cancelled() {
            return;
        }
        let lanes = DriveLanes::new(&drive.points(run[0].input_angle_rad()), run.len());
        run.par_chunks(BATCH).zip(rows.par_chunks_mut(BATCH)).for_each(|(loads, rows)| {
            if !progress.is_cancelled() {
                lanes.solve(loads, rows);
                progress.add(loads.len());
            }
        });
    });
}

/// Solves each drive under the load at its place into the row at its place, where every drive may be another one. Whether
/// it came to the end, as [`solve_into`].
pub fn solve_each(drives: &[Drive], loads: &[Load], rows: &mut [Row], progress: &Progress) -> bool {
    let parts = drives.par_chunks(BATCH).zip(loads.par_chunks(BATCH)).zip(rows.par_chunks_mut(BATCH));
    parts.for_each(|((drives, loads), rows)| {
        if progress.is_cancelled() {
            return;
        }
        for ((drive, load), row) in drives.iter().zip(loads).zip(rows) {
            if undercuts(drive) {
                *row = (Status::Undercut, None);
            } else {
                let points = drive.points(load.input_angle_rad());
                DriveLanes::for_one(&points).solve(&[*load], std::slice::from_mut(row));
            }
        }
        progress.add(drives.len().min(loads.len()));
    });
    !progress.is_cancelled()
}

/// The pairs of a drive at one input angle, ready for many loads.
#[derive(Debug)]
pub struct DriveLanes {
    deceleration: LanePair,
    equal_speed: Vec<LanePair>,
    equal_speed_share: f64,
}

impl DriveLanes {
    /// Ready for about `loads` loads: many are worth more preparation.
    pub fn new(points: &DrivePoints, loads: usize) -> Self {
        Self {
            deceleration: LanePair::new(&points.deceleration, loads),
            equal_speed: points.equal_speed.iter().map(|row| LanePair::new(row, loads)).collect(),
            equal_speed_share: points.equal_speed_share,
        }
    }

    /// Ready for a single load.
    pub fn for_one(points: &DrivePoints) -> Self {
        Self {
            deceleration: LanePair::for_one(&points.deceleration),
            equal_speed: points.equal_speed.iter().map(LanePair::for_one).collect(),
            equal_speed_share: points.equal_speed_share,
        }
    }

    /// Solves each load into the row at its place, whatever its input angle says.
    pub fn solve(&self, loads: &[Load], rows: &mut [Row]) {
        for (loads, rows) in loads.chunks(BATCH).zip(rows.chunks_mut(BATCH)) {
            if loads.len() <= FEW {
                self.solve_batch::<FEW>(loads, rows);
            } else {
                self.solve_batch::<BATCH>(loads, rows);
            }
        }
    }

    fn solve_batch<const B: usize>(&self, loads: &[Load], rows: &mut [Row]) {
        let count = loads.len();
        let (mut torque, mut preload, mut powers) = ([0.0; B], [1.0; B], [1.0; B]);
        for (load, (torque, preload)) in loads.iter().zip(torque.iter_mut().zip(&mut preload)) {
            (*torque, *preload) = (load.torque_Nm(), load.preload_N());
        }
        two_thirds_powers(&preload[..count], &mut powers);
        let mut outcomes = [LaneOutcome::NONE; B];
        self.deceleration.solve(&torque[..count], &preload, &powers, &mut outcomes);
        for (row, outcome) in rows.iter_mut().zip(&outcomes[..count]) {
            let angles = outcome.status.has_solution().then_some(Angles {
                deceleration_rad: outcome.rotation_rad,
                equal_speed_rad: 0.0,
                residual: outcome.residual,
                steps: outcome.steps,
            });
            *row = (outcome.status, angles);
        }
        for torque in &mut torque {
            *torque *= self.equal_speed_share;
        }
        for pair in &self.equal_speed {
            pair.solve(&torque[..count], &preload, &powers, &mut outcomes);
            let share = self.equal_speed_share * f64::from(pair.rows());
            for (row, outcome) in rows.iter_mut().zip(&outcomes[..count]) {
                row.0 = row.0.worse(outcome.status);
                row.1 = row.1.filter(|_| outcome.status.has_solution()).map(|angles| Angles {
                    equal_speed_rad: angles.equal_speed_rad + share * outcome.rotation_rad,
                    residual: angles.residual.max(outcome.residual),
                    steps: angles.steps + outcome.steps,
                    ..angles
                });
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_those_of_single_solves_in_order() {
        let drive = Drive::paper_base_case();
        let loads: Vec<Load> = (0..300)
            .filter_map(|i| Load::new(f64::from(i) * 0.03, 200.0, f64::from(i / 50) * 0.01).ok())
            .collect();
        let rows = solve_all(&drive, &loads, &Progress::default()).unwrap_or_default();
        let single: Vec<Row> = loads.iter().map(|load| drive.angles(load)).collect();
        assert_eq!(rows.len(), single.len());
        for (row, alone) in rows.iter().zip(&single) {
            assert_eq!(row.0, alone.0);
            assert_eq!(row.1.is_some(), alone.1.is_some());
            if let (Some(row), Some(alone)) = (row.1, alone.1) {
                assert!((row.elastic_angle_rad() - alone.elastic_angle_rad()).abs() <= 1e-15);
            }
        }
        assert!(single.iter().any(|(status, _)| !status.has_solution()));
    }

    #[test]
    fn no_loads_are_no_rows() {
        assert_eq!(solve_all(&Drive::paper_base_case(), &[], &Progress::default()), Some(Vec::new()));
    }

    /// One that is out of its order lies where two parts of the look through meet.
    #[test]
    fn order_is_looked_at_across_parts() -> Result<(), crate::InvalidInput> {
        let mut loads = vec![Load::new(1.0, 600.0, 0.1)?; 3 * LOOKED_AT];
        assert!(sorted(&loads) && sorted(&loads[..1]) && sorted(&[]));
        for place in [1, LOOKED_AT - 1, LOOKED_AT, LOOKED_AT + 1, loads.len() - 1] {
            loads[place] = Load::new(1.0, 600.0, 0.0)?;
            assert!(!sorted(&loads), "{place}");
            loads[place] = Load::new(1.0, 600.0, 0.1)?;
        }
        Ok(())
    }

    #[test]
    fn a_cancelled_sweep_returns_nothing() -> Result<(), crate::InvalidInput> {
        let progress = Progress::default();
        progress.cancel();
        assert_eq!(solve_all(&Drive::paper_base_case(), &[Load::new(1.0, 600.0, 0.0)?], &progress), None);
        Ok(())
    }
}
