//! Numbers of a design: sensitivities, many designs at once.

use std::collections::BTreeMap;

use cbpt_cli::case::Spread;
use cbpt_cli::commands::Units;
use cbpt_cli::commands::sensitivity::Answers;
use cbpt_core::design::{DesignNumber, NUMBERS, find};
use cbpt_core::judge::{Judgement, Wanted, judge_each};
use cbpt_core::preload::Threshold;
use cbpt_core::{InvalidInput, Load};
use pyo3::prelude::*;

use crate::Reduced;
use crate::arrays::{Column, Floats, Table};
use crate::case::Drive;
use crate::error::{case_error, invalid_input};
use crate::interrupt::without_gil;

/// A result, and how it answers to each number; numbers by their names in SI (``deceleration.ball_radius_m``).
#[pyclass(frozen, eq, get_all, from_py_object, module = "cbpt._core")]
#[derive(Clone, PartialEq)]
pub struct Sensitivity {
    /// The result, SI.
    value: f64,
    /// Its derivative by each number, SI.
    slopes: BTreeMap<String, f64>,
    /// Percent of the result for a percent of each number; without those of a result of 0.
    relative: BTreeMap<String, f64>,
    /// Numbers to which contacts that decide alike answer differently: the derivative is to one side.
    one_sided: Vec<String>,
}

#[pymethods]
impl Sensitivity {
    #[new]
    fn new(
        value: f64,
        slopes: BTreeMap<String, f64>,
        relative: BTreeMap<String, f64>,
        one_sided: Vec<String>,
    ) -> Self {
        Self { value, slopes, relative, one_sided }
    }

    #[allow(clippy::type_complexity)] // the fields, one by one
    fn __reduce__(
        slf: &Bound<'_, Self>,
    ) -> Reduced<(f64, BTreeMap<String, f64>, BTreeMap<String, f64>, Vec<String>)> {
        let s = slf.get();
        let fields = (s.value, s.slopes.clone(), s.relative.clone(), s.one_sided.clone());
        Ok((slf.get_type().into_any().unbind(), fields))
    }

    fn __repr__(&self) -> String {
        format!("Sensitivity({}, by {} numbers)", self.value, self.slopes.len())
    }
}

/// How the results of a drive under a load answer to its design numbers.
#[pyclass(frozen, eq, get_all, module = "cbpt._core")]
#[derive(Clone, PartialEq)]
pub struct Sensitivities {
    /// How the load ended.
    status: String,
    /// The numbers and their values, SI.
    numbers: BTreeMap<String, f64>,
    /// Results by name: ``elastic_angle_rad`` and its parts ``deceleration_angle_rad`` and ``equal_speed_angle_rad``, ``None``
    /// without a solution; ``hold_N``, ``continuous_N`` and ``zero_backlash_N`` of the drive, and of each pair with
    /// ``deceleration_`` or ``equal_speed_`` before the name, over a period, ``None`` where no preload does it.
    results: BTreeMap<String, Option<Sensitivity>>,
    report: String,
}

#[pymethods]
impl Sensitivities {
    #[new]
    fn new(
        status: String,
        numbers: BTreeMap<String, f64>,
        results: BTreeMap<String, Option<Sensitivity>>,
        report: String,
    ) -> Self {
        Self { status, numbers, results, report }
    }

    /// The elastic angle at the output; ``None`` where there is no solution.
    #[getter]
    fn elastic_angle(&self) -> Option<Sensitivity> {
        self.results.get("elastic_angle_rad").cloned().flatten()
    }

    #[allow(clippy::type_complexity)] // the fields, one by one
    fn __reduce__(
        slf: &Bound<'_, Self>,
    ) -> Reduced<(String, BTreeMap<String, f64>, BTreeMap<String, Option<Sensitivity>>, String)> {
        let s = slf.get();
        let fields = (s.status.clone(), s.numbers.clone(), s.results.clone(), s.report.clone());
        Ok((slf.get_type().into_any().unbind(), fields))
    }

    fn __repr__(&self) -> String {
        self.report.clone()
    }
}

impl Sensitivities {
    pub fn solve(drive: &cbpt_core::Drive, load: &Load, also: &[String]) -> Result<Self, InvalidInput> {
        let also: Result<Vec<_>, InvalidInput> =
            also.iter().map(|name| Ok((find(name)?, Spread::Normal(0.0)))).collect();
        let answers = Answers::new(drive, load, &also?)?;
        let numbers: Vec<(String, f64)> =
            answers.numbers().map(|(name, value)| (name.to_owned(), value)).collect();
        let told = |found: &Option<cbpt_core::sensitivity::Sensitivity>| {
            let found = found.as_ref()?;
            let by = |of: &dyn Fn(usize) -> f64| {
                numbers.iter().enumerate().map(|(place, (name, _))| (name.clone(), of(place))).collect()
            };
            let relative = |place: usize| found.slopes[place] * numbers[place].1 / found.value;
            let one_sided = numbers.iter().zip(&found.tied).filter(|(_, tied)| **tied);
            Some(Sensitivity {
                value: found.value,
                slopes: by(&|place| found.slopes[place]),
                relative: if found.value == 0.0 { BTreeMap::new() } else { by(&relative) },
                one_sided: one_sided.map(|((name, _), _)| name.clone()).collect(),
            })
        };
        let found = answers.found();
        let mut results = BTreeMap::from([
            ("elastic_angle_rad".to_owned(), told(&found.elastic_angle)),
            ("deceleration_angle_rad".to_owned(), told(&found.deceleration_angle)),
            ("equal_speed_angle_rad".to_owned(), told(&found.equal_speed_angle)),
        ]);
        for (pair, of_pair) in
            [("", &found.drive), ("deceleration_", &found.deceleration), ("equal_speed_", &found.equal_speed)]
        {
            for (kind, threshold) in ["hold_N", "continuous_N", "zero_backlash_N"].into_iter().zip(of_pair) {
                results.insert(format!("{pair}{kind}"), told(threshold));
            }
        }
        let report = answers.report(&Units::default()).text;
        Ok(Self {
            status: found.status.name().to_owned(),
            numbers: numbers.iter().cloned().collect(),
            results,
            report,
        })
    }
}

/// The number of a key as a case writes it (``deceleration.ball_radius_mm``): its name in SI, these values of it in SI,
/// and whether it is whole.
///
/// Raises ``CaseError`` with the nearest right key, or for a value that cannot be.
#[pyfunction]
pub fn design_number(
    py: Python<'_>,
    key: &str,
    values: Vec<f64>,
) -> PyResult<(&'static str, Vec<f64>, bool)> {
    let (number, values) =
        cbpt_cli::case::number_of_key(key, &values).map_err(|error| case_error(py, &error))?;
    Ok((number.name, values, number.whole))
}

/// Numbers of designs by their names in SI: for each its key in the usual unit, and one SI unit in that.
#[pyfunction]
pub fn design_numbers() -> BTreeMap<&'static str, (String, f64)> {
    NUMBERS.iter().map(|number| (number.name, cbpt_cli::case::in_usual_unit(number))).collect()
}

/// Statuses, their places in the names that follow, the columns, and their names.
type Judged<'py> = (Column<'py, u8>, Vec<&'static str>, Table<'py, f64>, Vec<&'static str>);

const COLUMNS: [&str; 10] = [
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
];

/// Judges many designs under a load (N m, N, rad) on all cores: ``values`` (n rows of the values of ``numbers``, named in
/// SI, one after the other) take the place of the drive's own.
///
/// ``threshold``: which one to tell as the needed preload, ``hold``, ``continuous`` or ``zero_backlash``; none where it is
/// none of these.
///
/// Returns the status of each row as a place in the names that follow (``no_drive`` where the numbers make none), a table
/// and the names of its columns; NaN where there is no solution or a column is not wanted. Raises ``InvalidInputError`` for a
/// name that is none; Ctrl-C stops it.
#[pyfunction]
#[allow(clippy::too_many_arguments)] // a load, and what is wanted
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
) -> PyResult<Judged<'py>> {
    let drive = drive.ball_drive(py, "judge_designs")?;
    let load = Load::new(torque_Nm, preload_N, input_angle_rad).map_err(|error| invalid_input(py, &error))?;
    let found: Result<Vec<&DesignNumber>, InvalidInput> = numbers.iter().map(|name| find(name)).collect();
    let numbers = found.map_err(|error| invalid_input(py, &error))?;
    let values = values.view().to_vec();
    let named = |which: &Threshold| threshold.as_deref() == Some(which.name());
    let wanted = Wanted { pressures, threshold: Threshold::ALL.into_iter().find(named) };
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
    ]
}
