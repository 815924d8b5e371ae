//! Case files.

use std::collections::BTreeMap;
use std::sync::Arc;

use cbpt_cli::case::{Case as RustCase, History, TorqueTurns, Zero};
use cbpt_cli::commands::friction::{self, Asked, Costs};
use cbpt_cli::formula::Formula;
use cbpt_core::design;
use cbpt_core::effect::OwnEffect as _;
use cbpt_core::{InvalidInput, Load, Reducer};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyString};
use serde_json::{Map, Number, Value};

use crate::Reduced;
use crate::drive::{Drive, hash};
use crate::error::{about_ball_drives, case_error, invalid_input};
use crate::given::{CasePath, case_from_dict, case_from_file, case_from_toml};
use crate::own::OwnEffect;

/// One entry of ``[[effect]]``: its id, port and expression (of an own effect only), and its numbers.
#[pyclass(frozen, eq, get_all, module = "cbpt._core")]
#[derive(Clone, PartialEq)]
pub struct Effect {
    /// Name of the effect.
    id: String,
    /// Where it acts, for an effect of the user's own.
    port: Option<String>,
    /// Its expression, for an effect of the user's own.
    expression: Option<String>,
    /// All numbers in SI: name (of an effect of the library with its unit), and value.
    values: Vec<(String, f64)>,
}

#[pymethods]
impl Effect {
    #[new]
    fn new(id: String, port: Option<String>, expression: Option<String>, values: Vec<(String, f64)>) -> Self {
        Self { id, port, expression, values }
    }

    #[allow(clippy::type_complexity)] // the fields, one by one
    fn __reduce__(
        slf: &Bound<'_, Self>,
    ) -> Reduced<(String, Option<String>, Option<String>, Vec<(String, f64)>)> {
        let e = slf.get();
        let fields = (e.id.clone(), e.port.clone(), e.expression.clone(), e.values.clone());
        Ok((slf.get_type().into_any().unbind(), fields))
    }

    fn __repr__(&self) -> String {
        format!("Effect({:?}, {:?})", self.id, self.values)
    }
}

/// A case file: the drive and, if given, load, measurement, uncertainties and effects.
#[pyclass(frozen, eq, module = "cbpt._core")]
#[derive(Clone, PartialEq)]
pub struct Case {
    case: RustCase,
}

impl Case {
    pub fn of(case: RustCase) -> Self {
        Self { case }
    }

    pub fn rust(&self) -> &RustCase {
        &self.case
    }
}

#[pymethods]
impl Case {
    /// Reads a case file. Raises ``CaseError`` with file, line, key, what was found and what is allowed.
    #[staticmethod]
    fn from_file(py: Python<'_>, path: CasePath) -> PyResult<Self> {
        Ok(Self { case: case_from_file(py, &path)? })
    }

    /// Reads a case from TOML text; ``name`` stands for the file in messages.
    #[staticmethod]
    #[pyo3(signature = (text, name = "<text>"))]
    fn from_toml(text: &Bound<'_, PyString>, name: &str) -> PyResult<Self> {
        Ok(Self { case: case_from_toml(text, name)? })
    }

    /// Makes a case from a dict with the sections and keys of a case file.
    #[staticmethod]
    #[pyo3(signature = (case: "dict[str, Any]"))]
    fn from_dict(py: Python<'_>, case: &Bound<'_, PyDict>) -> PyResult<Self> {
        Ok(Self { case: case_from_dict(py, case)? })
    }

    /// The case as a file in SI units; ``from_toml`` of it gives the same case to the last bit.
    ///
    /// ``like`` is the text of the file that the case was made of: its comments, order and units stay, and only effects that
    /// are new or have other numbers are written, in the unit that stands there or the usual one; that may cost such a number one
    /// unit in its last place. Raises ``CaseError`` where that text is no case.
    #[pyo3(signature = (like = None))]
    fn to_toml(&self, py: Python<'_>, like: Option<&str>) -> PyResult<String> {
        let text = like.map_or_else(|| Ok(self.case.to_toml()), |text| self.case.to_toml_like(text));
        text.map_err(|error| case_error(py, &error))
    }

    /// The drive without the effects of the case.
    #[getter]
    fn drive(&self) -> Drive {
        Drive { reducer: self.case.reducer.clone() }
    }

    /// Torque of ``[load]``, N m, or ``None``.
    #[getter]
    fn torque_Nm(&self) -> Option<f64> {
        self.case.load.torque_Nm
    }

    /// Preload of ``[load]``, N, or ``None``.
    #[getter]
    fn preload_N(&self) -> Option<f64> {
        self.case.load.preload_N
    }

    /// Input angle of ``[load]``, degrees, or ``None``.
    #[getter]
    fn input_angle_deg(&self) -> Option<f64> {
        self.case.load.input_angle_rad.map(f64::to_degrees)
    }

    /// Whether all runs share one zero of the angle (``common``) or each has its own (``per_run``).
    #[getter]
    fn zero(&self) -> &'static str {
        match self.case.measurement.zero {
            Zero::Common => "common",
            Zero::PerRun => "per_run",
        }
    }

    /// Whether friction goes on where a run begins as the one before it ended: if both are timed by one clock
    /// (``by_clock``), at no run (``released``), or whatever the clocks (``carried``; ``carried_from_above`` and
    /// ``carried_from_below`` say from where the torque came before the first run).
    #[getter]
    fn friction_between_runs(&self) -> &'static str {
        word_of(&History::WORDS, self.case.measurement.friction_between_runs)
    }

    /// The case with another ``friction_between_runs``. Raises ``InvalidInputError`` for any other word.
    fn with_friction_between_runs(&self, py: Python<'_>, word: &str) -> PyResult<Self> {
        let between = of_word(py, "friction_between_runs", &History::WORDS, word)?;
        let mut case = self.case.clone();
        case.measurement.friction_between_runs = between;
        Ok(Self { case })
    }

    /// Where the torque of a table with times reverses: ``where_ramps_meet``, between readings unless every reversal meets the
    /// clock in the same place, ``between_readings`` also then, or ``at_readings``.
    #[getter]
    fn torque_turns(&self) -> &'static str {
        word_of(&TorqueTurns::WORDS, self.case.measurement.torque_turns)
    }

    /// The case with another ``torque_turns``. Raises ``InvalidInputError`` for any other word.
    fn with_torque_turns(&self, py: Python<'_>, word: &str) -> PyResult<Self> {
        let turns = of_word(py, "torque_turns", &TorqueTurns::WORDS, word)?;
        let mut case = self.case.clone();
        case.measurement.torque_turns = turns;
        Ok(Self { case })
    }

    /// Lever arm of a displacement sensor, mm, or ``None``.
    #[getter]
    fn lever_arm_mm(&self) -> Option<f64> {
        self.case.measurement.lever_arm_m.map(|m| m * 1e3)
    }

    /// Rated torque of ``[rating]``, N m, or ``None``.
    #[getter]
    fn rated_torque_Nm(&self) -> Option<f64> {
        self.case.rating.rated_torque_Nm
    }

    /// Friction coefficient of ``[friction]``.
    #[getter]
    fn friction_coefficient(&self) -> f64 {
        self.case.friction.coefficient
    }

    /// Moment of inertia at the output of ``[operation]``, kg m^2, or ``None``.
    #[getter]
    fn output_inertia_kg_m2(&self) -> Option<f64> {
        self.case.operation.output_inertia_kg_m2
    }

    /// What preload and stiffness cost under a load: text for a terminal, and the JSON document of ``cbpt friction``.
    #[pyo3(signature = (torque_Nm, preload_N, input_angle_deg = 0.0, coefficient = None, static_safety = None))]
    #[expect(clippy::too_many_arguments, reason = "a load, and what stands in place of the case's numbers")]
    fn costs(
        &self,
        py: Python<'_>,
        torque_Nm: f64,
        preload_N: f64,
        input_angle_deg: f64,
        coefficient: Option<f64>,
        static_safety: Option<f64>,
    ) -> PyResult<(String, String)> {
        let drive = self.case.drive().ok_or_else(|| about_ball_drives(py, "costs"))?;
        let mut asked = Asked::of(&self.case);
        asked.friction.coefficient = coefficient.unwrap_or(asked.friction.coefficient);
        asked.operation.static_safety = static_safety.unwrap_or(asked.operation.static_safety);
        let found = Load::new(torque_Nm, preload_N, input_angle_deg.to_radians())
            .and_then(|load| py.detach(|| Costs::of(drive, &load, asked)));
        let report = friction::answer(&found.map_err(|error| invalid_input(py, &error))?, &self.case);
        Ok((report.text, report.json.to_string()))
    }

    /// The case with these effects in place of its own: ids of the library, each with parameters named as in a case file
    /// (``{"reference_deflection_um": 2}``), a parameter that is not given has its default; or own effects, with the values of their
    /// parameters. The same id of the library may stand more than once.
    ///
    /// Raises ``CaseError`` with key, what was found and what is allowed, and ``InvalidInputError`` for a function of Python,
    /// which a case cannot hold.
    #[pyo3(signature = (effects: "list[tuple[str, dict[str, float]]] | list[tuple[str | OwnEffect, dict[str, float]]]"))]
    fn with_effects(&self, py: Python<'_>, effects: Vec<(IdOrOwn, BTreeMap<String, f64>)>) -> PyResult<Self> {
        let mut list = Vec::new();
        for (effect, numbers) in &effects {
            let numbers: Map<String, Value> =
                numbers.iter().map(|(name, value)| (name.clone(), json_number(*value))).collect();
            list.push(match effect {
                IdOrOwn::Id(id) => {
                    let id = ("id".to_owned(), Value::from(id.as_str()));
                    Value::Object(std::iter::once(id).chain(numbers).collect())
                }
                IdOrOwn::Own(own) => own.get().entry(&numbers).ok_or_else(|| {
                    let rule = "is a function of Python, which a case cannot hold; write it as an expression";
                    invalid_input(py, &InvalidInput::new("effect", own.get().id(), rule))
                })?,
            });
        }
        self.case.with_effects(&list).map(|case| Self { case }).map_err(|error| case_error(py, &error))
    }

    /// The case with other values of numbers of its drive and load, named in SI (``deceleration.ball_radius_m``).
    ///
    /// Raises ``InvalidInputError`` for an unknown name or an invalid value.
    #[pyo3(signature = (numbers: "dict[str, float]"))]
    fn with_numbers(&self, py: Python<'_>, numbers: BTreeMap<String, f64>) -> PyResult<Self> {
        let found: Result<Vec<_>, InvalidInput> =
            numbers.iter().map(|(name, value)| Ok((design::find(name)?, *value))).collect();
        let case = found.and_then(|numbers| self.case.with_numbers(&numbers));
        case.map(|case| Self { case }).map_err(|error| invalid_input(py, &error))
    }

    /// The same case with nominal parts.
    fn nominal(&self) -> Self {
        match &self.case.reducer {
            Reducer::BallDrive(drive) => {
                Self { case: RustCase { reducer: drive.nominal().into(), ..self.case.clone() } }
            }
            Reducer::TorsionSpring(_) => self.clone(),
        }
    }

    /// Spread of the numbers of a ball drive and its load, from ``[tolerance]`` or else ``[uncertainty]``: name in SI, ``uniform``
    /// or ``normal``, and the limit or standard uncertainty, SI.
    ///
    /// Raises ``InvalidInputError`` for a spread that stands for two numbers whose values differ.
    fn spreads(&self, py: Python<'_>) -> PyResult<Vec<(&'static str, &'static str, f64)>> {
        let load = self.case.load;
        let stated = Load::new(load.torque_Nm.unwrap_or(0.0), load.preload_N.unwrap_or(1.0), 0.0);
        let drive = self.case.drive().ok_or_else(|| about_ball_drives(py, "spreads"))?;
        let found = stated.and_then(|load| self.case.spreads(drive, &load));
        let found = found.map_err(|error| invalid_input(py, &error))?;
        Ok(found.iter().map(|(number, spread)| (number.name, spread.name(), spread.size())).collect())
    }

    /// The effects of the user's own among those of the case.
    #[getter]
    fn own_effects(&self) -> Vec<OwnEffect> {
        self.case.effects.iter().filter_map(|effect| effect.own.as_ref().map(OwnEffect::of)).collect()
    }

    /// Effects that the case adds to the drive.
    #[getter]
    fn effects(&self) -> Vec<Effect> {
        self.case
            .effects
            .iter()
            .map(|effect| {
                let own = effect.own.as_ref();
                let starts = |own: &Arc<Formula>| {
                    own.parameters().iter().map(|number| (number.name.clone(), number.start)).collect()
                };
                Effect {
                    id: effect.id.clone(),
                    port: own.map(|own| own.adds_to().port().name().to_owned()),
                    expression: own.map(|own| own.text().to_owned()),
                    values: own.map_or_else(|| effect.numbers.clone(), starts),
                }
            })
            .collect()
    }

    fn __reduce__(slf: &Bound<'_, Self>) -> Reduced<(String,)> {
        Ok((slf.get_type().getattr("from_toml")?.unbind(), (slf.get().case.to_toml(),)))
    }

    fn __hash__(&self) -> u64 {
        hash(&self.case.to_toml())
    }

    fn __repr__(&self) -> String {
        let effects: Vec<&str> = self.case.effects.iter().map(|effect| effect.id.as_str()).collect();
        let with =
            if effects.is_empty() { String::new() } else { format!(", effects {}", effects.join(", ")) };
        format!("Case({}{with})", Drive { reducer: self.case.reducer.clone() }.__repr__())
    }
}

/// An effect of the library by its id, or one of the user's own.
#[derive(FromPyObject)]
pub enum IdOrOwn {
    /// Of the library.
    Id(String),
    /// Of the user's own.
    Own(Py<OwnEffect>),
}

/// The word of a choice.
fn word_of<T: PartialEq>(words: &[(&'static str, T)], choice: T) -> &'static str {
    words.iter().find(|(_, known)| *known == choice).map_or("", |(word, _)| word)
}

/// The choice that a word of a field names.
pub fn of_word<T: Copy>(py: Python<'_>, field: &str, words: &[(&str, T)], word: &str) -> PyResult<T> {
    let found = words.iter().find(|(known, _)| *known == word);
    found.map(|(_, choice)| *choice).ok_or_else(|| {
        let known: Vec<&str> = words.iter().map(|(known, _)| *known).collect();
        invalid_input(py, &InvalidInput::new(field, word, format!("is none of {}", known.join(", "))))
    })
}

/// A number as JSON. What is no finite number stays as text, so that the message names its place.
fn json_number(value: f64) -> Value {
    Number::from_f64(value).map_or_else(|| value.to_string().into(), Into::into)
}
