//! Many loads on one drive, on all cores.
//!
//! A load without solution is a row with its status. Loads that follow each other at the same input angle share one
//! set of meshing points, so sort by angle where that is cheap.

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use rayon::prelude::*;

use crate::drive::{Drive, Load};
use crate::geometry::undercut::undercuts;
use crate::status::Status;
use crate::transmission::{Angles, DrivePoints};

/// Loads a thread takes at a time.
const CHUNK: usize = 128;

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
    pub(crate) fn add(&self, count: usize) {
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

/// One load's outcome.
pub type Row = (Status, Option<Angles>);

/// Solves every load, in their order; `None` if the sweep was cancelled.
pub fn solve_all(drive: &Drive, loads: &[Load], progress: &Progress) -> Option<Vec<Row>> {
    if undercuts(drive) {
        return Some(vec![(Status::Undercut, None); loads.len()]);
    }
    let chunks: Vec<Vec<Row>> = loads
        .par_chunks(CHUNK)
        .map(|chunk| {
            if progress.is_cancelled() {
                return Vec::new();
            }
            let rows = solve_chunk(drive, chunk);
            progress.add(rows.len());
            rows
        })
        .collect();
    (!progress.is_cancelled()).then(|| chunks.concat())
}

fn solve_chunk(drive: &Drive, loads: &[Load]) -> Vec<Row> {
    let mut at_angle: Option<(f64, DrivePoints)> = None;
    let mut rows = Vec::with_capacity(loads.len());
    for load in loads {
        let angle = load.input_angle_rad();
        let fresh = at_angle.as_ref().is_none_or(|(known, _)| known.to_bits() != angle.to_bits());
        if fresh {
            at_angle = Some((angle, drive.points(angle)));
        }
        if let Some((_, points)) = &at_angle {
            rows.push(points.angles(load.torque_Nm(), load.preload_N()));
        }
    }
    rows
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
        let rows = solve_all(&drive, &loads, &Progress::default());
        let single: Vec<Row> = loads.iter().map(|load| drive.angles(load)).collect();
        assert_eq!(rows, Some(single.clone()));
        assert!(single.iter().any(|(status, _)| !status.has_solution()));
    }

    #[test]
    fn a_cancelled_sweep_returns_nothing() -> Result<(), crate::InvalidInput> {
        let progress = Progress::default();
        progress.cancel();
        assert_eq!(solve_all(&Drive::paper_base_case(), &[Load::new(1.0, 600.0, 0.0)?], &progress), None);
        Ok(())
    }
}
