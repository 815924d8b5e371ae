//! Numbers of a design, and many designs at once.

use std::collections::BTreeMap;

use cbpt_core::design::{DesignNumber, NUMBERS, find};
use cbpt_core::judge::{Judgement, Wanted, judge_each};
use cbpt_core::preload::Threshold;
use cbpt_core::{InvalidInput, Load};
use pyo3::prelude::*;

use crate::arrays::{Column, Floats, Table};
use crate::case::Case;
use crate::drive::Drive;
use crate::error::{invalid_input, raise};
use crate::interrupt::without_gil;

/// The design number with a key of case files (``deceleration.ball_radius_mm``): its name in SI, the values in SI,
/// and whether it is a whole number.
///
/// Raises ``InvalidInputError`` with the nearest key for an unknown one, or for an invalid value.
#[pyfunction]
pub fn design_number(
    py: Python<'_>,
    case: &Case,
    key: &str,
    values: Vec<f64>,
) -> PyResult<(&'static str, Vec<f64>, bool)> {
    let found = cbpt_cli::case::number_of_key(case.rust(), key, &values);
    let (number, values) = found.map_err(|mistake| raise(py, "InvalidInputError", (mistake.to_string(),)))?;
    Ok((number.name, values, number.whole))
}

/// Design numbers by their names in SI: the key in the usual unit, and the number of usual units in one SI unit.
#[pyfunction]
pub fn design_numbers() -> BTreeMap<&'static str, (String, f64)> {
    NUMBERS.iter().map(|number| (number.name, cbpt_cli::case::in_usual_unit(number))).collect()
}

/// Statuses, their places in the names that follow, the columns, and their names.
type Judged<'py> = (Column<'py, u8>, Vec<&'static str>, Table<'py, f64>, Vec<&'static str>);

const COLUMNS: [&str; 15] = [
    "elastic_angle_rad",
    "outer_radius_m",
    "undercut_margin",
    "inside_wall_margin",
    "deceleration_ball_clearance_m",
    "equal_speed_ball_clearance_m",
    "ring_clearance_m",
    "deceleration_pressure_Pa",
    "equal_speed_pressure_Pa",
    "needed_preload_N",
    "friction_torque_Nm",
    "efficiency",
    "wear_Nm_per_turn",
    "static_safety",
    "torsional_stiffness_Nm_per_rad",
];

/// Judges many designs under one load on all cores. Ctrl-C stops it.
///
/// Parameters
/// ----------
/// drive : Drive
///     The drive whose numbers are replaced.
/// torque_Nm, preload_N, input_angle_rad : float
///     The load: N m, N and rad.
/// numbers : list of str
///     Names, in SI, of the numbers that are replaced.
/// values : array
///     The values of ``numbers``, row after row.
/// pressures : bool
///     Whether to compute the peak pressures, and what comes with them: static safety and torsional stiffness.
/// threshold : str, optional
///     The preload to compute: ``hold``, ``continuous`` or ``zero_backlash``; none for any other word.
/// coefficient : float, optional
///     Friction coefficient with which friction torque, efficiency and wear are computed, at the angle of the load.
///
/// Returns
/// -------
/// tuple
///     The status of each row as an index into the names that follow (``no_drive`` where the numbers make no drive), these
///     names, a table with one row for each design, and the names of its columns. NaN where there is no solution or a column
///     is not wanted.
///
/// Raises
/// ------
/// InvalidInputError
///     For an unknown name.
#[pyfunction]
#[pyo3(signature = (drive, torque_Nm, preload_N, input_angle_rad, numbers, values, pressures, threshold = None, coefficient = None))]
#[expect(clippy::too_many_arguments, reason = "a load, and what is wanted")]
pub fn judge_designs<'py>(
    py: Python<'py>,
    drive: &Drive,
    torque_Nm: f64,
    preload_N: f64,
    input_angle_rad: f64,
    numbers: Vec<String>,
    values: Floats<'py>,
    pressures: bool,
    threshold: Option<String>,
    coefficient: Option<f64>,
) -> PyResult<Judged<'py>> {
    let drive = drive.ball_drive(py, "judge_designs")?;
    let load = Load::new(torque_Nm, preload_N, input_angle_rad).map_err(|error| invalid_input(py, &error))?;
    let found: Result<Vec<&DesignNumber>, InvalidInput> = numbers.iter().map(|name| find(name)).collect();
    let numbers = found.map_err(|error| invalid_input(py, &error))?;
    let values = values.view().to_vec();
    let named = |which: &Threshold| threshold.as_deref() == Some(which.name());
    let threshold = Threshold::ALL.into_iter().find(named);
    let wanted = Wanted { pressures, threshold, friction_coefficient: coefficient };
    let work = |progress: &_| judge_each(drive, &load, &numbers, &values, wanted, progress);
    let judged = without_gil(py, None, work)?.unwrap_or_default();
    let mut names: Vec<&'static str> = Vec::new();
    let mut codes: Vec<u8> = Vec::with_capacity(judged.len());
    for judgement in &judged {
        let name = judgement.status.map_or("no_drive", |status| status.name());
        let place = names.iter().position(|known| *known == name).unwrap_or(names.len());
        if place == names.len() {
            names.push(name);
        }
        // There are few statuses.
        #[allow(clippy::cast_possible_truncation)]
        codes.push(place as u8);
    }
    let rows: Vec<f64> = judged.iter().flat_map(row).collect();
    Ok((Column::new(py, codes), names, Table::of_rows(py, &rows, judged.len())?, COLUMNS.to_vec()))
}

fn row(judgement: &Judgement) -> [f64; COLUMNS.len()] {
    let none = f64::NAN;
    let sizes = judgement.sizes.as_ref();
    [
        judgement.elastic_angle_rad,
        sizes.map_or(none, |sizes| sizes.outer_radius_m),
        sizes.map_or(none, |sizes| sizes.undercut_margin),
        sizes.map_or(none, |sizes| sizes.inside_wall_margin),
        sizes.map_or(none, |sizes| sizes.ball_clearances_m[0]),
        sizes.map_or(none, |sizes| sizes.ball_clearances_m[1]),
        sizes.map_or(none, |sizes| sizes.ring_clearance_m),
        judgement.peak_pressures_Pa[0],
        judgement.peak_pressures_Pa[1],
        judgement.threshold_N,
        judgement.friction[0],
        judgement.friction[1],
        judgement.friction[2],
        judgement.static_safety,
        judgement.torsional_stiffness_Nm_per_rad,
    ]
}
