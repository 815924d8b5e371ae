//! Many designs at once, on all cores: the elastic angle under a load, and what else a design is judged by.
//!
//! Each row is a drive with other values of some numbers. A row that is no drive, or has no solution, is a row with its
//! status.

use rayon::prelude::*;

use crate::design::{Design, DesignNumber, Sizes};
use crate::drive::{Drive, Load};
use crate::preload::Threshold;
use crate::status::Status;
use crate::strength::static_safety;
use crate::sweep::{Progress, Row, solve_each};

/// What is wanted beside angle and sizes.
#[derive(Debug, Clone, Copy, Default)]
pub struct Wanted {
    /// Peak pressures, which need every meshing point.
    pub pressures: bool,
    /// A threshold over a period, which takes far longer than all else.
    pub threshold: Option<Threshold>,
    /// Friction with this coefficient, at the load's angle.
    pub friction_coefficient: Option<f64>,
}

/// One design.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Judgement {
    /// How the load ended; `None` where the numbers make no drive.
    pub status: Option<Status>,
    /// Elastic angle, rad; NaN where there is no solution.
    pub elastic_angle_rad: f64,
    /// Sizes and margins; `None` where the numbers make no drive.
    pub sizes: Option<Sizes>,
    /// Highest peak pressure in the deceleration and in the equal-speed pair, Pa; NaN where there is none or it was not
    /// wanted.
    pub peak_pressures_Pa: [f64; 2],
    /// The threshold of the drive for the load's torque over a period, N; NaN where none was wanted.
    pub threshold_N: f64,
    /// Friction torque at the input (N m), efficiency, and Archard's index for a turn of the input (N m); NaN where there is
    /// no solution or they were not wanted.
    pub friction: [f64; 3],
    /// Static safety s0 at the load's angle; NaN as the pressures.
    pub static_safety: f64,
    /// Torsional stiffness, N m/rad; NaN as the pressures.
    pub torsional_stiffness_Nm_per_rad: f64,
}

impl Judgement {
    const NONE: Self = Self {
        status: None,
        elastic_angle_rad: f64::NAN,
        sizes: None,
        peak_pressures_Pa: [f64::NAN; 2],
        threshold_N: f64::NAN,
        friction: [f64::NAN; 3],
        static_safety: f64::NAN,
        torsional_stiffness_Nm_per_rad: f64::NAN,
    };
}

/// Designs that are judged together.
const BATCH: usize = 512;

/// Judges designs: `values` holds those of `numbers`, row after row. `None` if it was cancelled. Their parts are nominal where
/// numbers of the drive change, as what was measured of one drive's parts says nothing of another's.
pub fn judge_each(
    drive: &Drive,
    load: &Load,
    numbers: &[&DesignNumber],
    values: &[f64],
    wanted: Wanted,
    progress: &Progress,
) -> Option<Vec<Judgement>> {
    let of_load = numbers.iter().all(|number| number.name.starts_with("load."));
    let start = if of_load { Design::of(drive, load) } else { Design::of(&drive.nominal(), load) };
    let mut found = Vec::new();
    for rows in values.chunks(numbers.len().max(1) * BATCH) {
        let built: Vec<Option<(Drive, Load)>> = rows
            .par_chunks(numbers.len().max(1))
            .map(|row| {
                let mut design = start.clone();
                for (number, value) in numbers.iter().zip(row) {
                    design.set(number, *value);
                }
                design.build().ok()
            })
            .collect();
        found.extend(if wanted.pressures { one_by_one(&built) } else { side_by_side(&built, progress) });
        if let Some(which) = wanted.threshold {
            let judged = found.len() - built.len();
            found[judged..].par_iter_mut().zip(&built).for_each(|(judgement, built)| {
                if let Some((drive, load)) = built.as_ref().filter(|_| !progress.is_cancelled()) {
                    judgement.threshold_N = drive.preload_threshold_N(load.torque_Nm(), which);
                }
            });
        }
        if let Some(coefficient) = wanted.friction_coefficient {
            let judged = found.len() - built.len();
            found[judged..].par_iter_mut().zip(&built).for_each(|(judgement, built)| {
                if let Some((drive, load)) = built.as_ref().filter(|_| !progress.is_cancelled()) {
                    judgement.friction = friction(drive, load, coefficient);
                }
            });
        }
        if progress.is_cancelled() {
            return None;
        }
    }
    Some(found)
}

/// Friction torque, efficiency and wear of a design; NaN without solution.
fn friction(drive: &Drive, load: &Load, coefficient: f64) -> [f64; 3] {
    let found = drive.friction(load, coefficient).ok();
    let numbers =
        found.and_then(|found| Some([found.torque_Nm()?, found.efficiency()?, found.wear_Nm_per_turn()?]));
    numbers.unwrap_or([f64::NAN; 3])
}

/// Angles alone, in the lanes of each core.
fn side_by_side(built: &[Option<(Drive, Load)>], progress: &Progress) -> Vec<Judgement> {
    let (drives, loads): (Vec<Drive>, Vec<Load>) = built.iter().flatten().cloned().unzip();
    let mut rows: Vec<Row> = vec![(Status::Indeterminate, None); drives.len()];
    solve_each(&drives, &loads, &mut rows, progress);
    let mut rows = rows.into_iter();
    let judge = |built: &Option<(Drive, Load)>| {
        let (Some((drive, _)), Some((status, angles))) = (built, built.as_ref().and_then(|_| rows.next()))
        else {
            return Judgement::NONE;
        };
        Judgement {
            status: Some(status),
            elastic_angle_rad: angles.map_or(f64::NAN, |angles| angles.elastic_angle_rad()),
            sizes: Some(Sizes::of(drive)),
            ..Judgement::NONE
        }
    };
    built.iter().map(judge).collect()
}

/// With every meshing point.
fn one_by_one(built: &[Option<(Drive, Load)>]) -> Vec<Judgement> {
    let judge = |built: &Option<(Drive, Load)>| {
        let Some((drive, load)) = built else { return Judgement::NONE };
        let solution = drive.solve(load);
        let pressure = |pair: &Option<crate::equilibrium::report::PairSolution>| {
            pair.as_ref().map_or(f64::NAN, |pair| pair.peak_pressure_Pa)
        };
        let peak_pressures_Pa = [pressure(&solution.deceleration), pressure(&solution.equal_speed)];
        let highest = peak_pressures_Pa[0].max(peak_pressures_Pa[1]);
        Judgement {
            status: Some(solution.status),
            elastic_angle_rad: solution.elastic_angle_rad().unwrap_or(f64::NAN),
            sizes: Some(Sizes::of(drive)),
            peak_pressures_Pa,
            static_safety: static_safety(drive.material().pressure_limit_Pa, highest),
            torsional_stiffness_Nm_per_rad: solution.torsional_stiffness_Nm_per_rad.unwrap_or(f64::NAN),
            ..Judgement::NONE
        }
    };
    built.par_iter().map(judge).collect()
}
