//! How results answer to the numbers of a design.

use std::collections::BTreeMap;

use cbpt_cli::case::Spread;
use cbpt_cli::commands::Units;
use cbpt_cli::commands::sensitivity::Answers;
use cbpt_core::cost::Rubbing;
use cbpt_core::design::find;
use cbpt_core::{InvalidInput, Load};
use pyo3::prelude::*;

use crate::Reduced;

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
    /// ``deceleration_`` or ``equal_speed_`` before the name, over a period, ``None`` where no preload does it. With a friction
    /// coefficient also ``friction_torque_Nm``, ``efficiency``, ``wear_Nm_per_turn`` and ``static_safety``, and with an inertia
    /// ``natural_frequency_Hz``, all at the input angle and by central differences.
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
    /// `rubbing` asks for the costs too.
    pub fn solve(
        drive: &cbpt_core::Drive,
        load: &Load,
        also: &[String],
        rubbing: Option<&Rubbing>,
    ) -> Result<Self, InvalidInput> {
        let also: Result<Vec<_>, InvalidInput> =
            also.iter().map(|name| Ok((find(name)?, Spread::Normal(0.0)))).collect();
        let mut answers = Answers::new(drive, load, &also?)?;
        if let Some(rubbing) = rubbing {
            answers.add_costs(drive, rubbing)?;
        }
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
        for (cost, found) in answers.costs() {
            results.insert(cost.name().to_owned(), told(found));
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
