//! Case files and drives.

use std::collections::BTreeMap;
use std::sync::Arc;

use cbpt_cli::case::{Case as RustCase, Zero};
use cbpt_cli::formula::Formula;
use cbpt_core::design;
use cbpt_core::effect::OwnEffect as _;
use cbpt_core::sweep::Progress;
use cbpt_core::{InvalidInput, Load, Reducer, Severity, TorsionSpring};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyString};
use serde_json::{Map, Number, Value};

use crate::Reduced;
use crate::design::Sensitivities;
use crate::error::{about_ball_drives, case_error, drive_with_effect, half_a_load, invalid_input};
use crate::given::{CasePath, case_from_dict, case_from_toml};
use crate::interrupt::without_gil;
use crate::own::OwnEffect;
use crate::preload::{PreloadThresholds, Thresholds};
use crate::solution::{LargestAngle, Solution};

/// One finding about a design: its code, severity (note, warning, error), the pair, a message and the remedy.
#[pyclass(frozen, eq, get_all, module = "cbpt._core")]
#[derive(Clone, PartialEq)]
pub struct Finding {
    /// Stable name, for example ``undercut``.
    code: String,
    /// ``note``, ``warning`` or ``error``.
    severity: String,
    /// ``deceleration`` or ``equal_speed``.
    pair: String,
    /// What was found, with the numbers.
    message: String,
    /// What to change.
    remedy: String,
}

#[pymethods]
impl Finding {
    #[new]
    fn new(code: String, severity: String, pair: String, message: String, remedy: String) -> Self {
        Self { code, severity, pair, message, remedy }
    }

    fn __reduce__(slf: &Bound<'_, Self>) -> Reduced<(String, String, String, String, String)> {
        let f = slf.get();
        let fields =
            (f.code.clone(), f.severity.clone(), f.pair.clone(), f.message.clone(), f.remedy.clone());
        Ok((slf.get_type().into_any().unbind(), fields))
    }

    fn __repr__(&self) -> String {
        format!("{} in {}: {}. Remedy: {}.", self.severity, self.pair, self.message, self.remedy)
    }
}

impl From<&cbpt_core::Finding> for Finding {
    fn from(finding: &cbpt_core::Finding) -> Self {
        Self {
            code: finding.code.into(),
            severity: finding.severity.name().into(),
            pair: finding.pair.into(),
            message: finding.message.clone(),
            remedy: finding.remedy.clone(),
        }
    }
}

/// A cycloid ball planetary transmission, checked and frozen; or any other reducer as a torsion spring, which has
/// ``solve``, but no pairs, findings and thresholds of the preload.
///
/// Make one with :meth:`Drive.from_file`, :meth:`Drive.from_toml` or :meth:`Drive.from_dict`; the keys are those of a
/// case file.
#[pyclass(frozen, eq, module = "cbpt._core")]
#[derive(Clone, PartialEq)]
pub struct Drive {
    reducer: Reducer,
}

impl Drive {
    pub fn rust(&self) -> &Reducer {
        &self.reducer
    }

    /// The ball drive that a question is about.
    pub fn ball_drive(&self, py: Python<'_>, asked: &str) -> PyResult<&cbpt_core::Drive> {
        self.reducer.ball_drive().ok_or_else(|| about_ball_drives(py, asked))
    }

    /// The drive of a case that has nothing else to compute.
    fn new(py: Python<'_>, case: RustCase) -> PyResult<Self> {
        match case.effects.first() {
            None => Ok(Self { reducer: case.reducer }),
            Some(effect) => Err(drive_with_effect(py, &effect.id)),
        }
    }
}

#[pymethods]
impl Drive {
    /// Reads the drive of a case file.
    ///
    /// Raises ``CaseError`` with file, line, key, what was found and what is allowed.
    #[staticmethod]
    fn from_file(py: Python<'_>, path: CasePath) -> PyResult<Self> {
        Self::new(py, RustCase::read(&path.0).map_err(|error| case_error(py, &error))?)
    }

    /// Reads the drive of a case given as TOML text.
    ///
    /// Raises ``CaseError`` with line, key, what was found and what is allowed.
    #[staticmethod]
    fn from_toml(py: Python<'_>, text: &Bound<'_, PyString>) -> PyResult<Self> {
        Self::new(py, case_from_toml(text, "<text>")?)
    }

    /// Makes a drive from a dict with the sections and keys of a case file, for example
    /// ``{"deceleration": {"ball_count": 20, "rolling_circle_radius_mm": 4, ...}, "equal_speed": {...}}``.
    ///
    /// Raises ``CaseError`` with key, what was found and what is allowed.
    #[staticmethod]
    #[pyo3(signature = (case: "dict[str, Any]"))]
    fn from_dict(py: Python<'_>, case: &Bound<'_, PyDict>) -> PyResult<Self> {
        Self::new(py, case_from_dict(py, case)?)
    }

    /// The drive as a case file in SI units; ``from_toml`` of it gives the same drive to the last bit.
    fn to_toml(&self) -> String {
        RustCase::reducer_to_toml(&self.reducer)
    }

    /// ``ball_drive`` or ``torsion_spring``.
    #[getter]
    fn kind(&self) -> &'static str {
        match self.reducer {
            Reducer::BallDrive(_) => "ball_drive",
            Reducer::TorsionSpring(_) => "torsion_spring",
        }
    }

    /// Input turns for one turn of the output, below 0 where they turn against each other.
    #[getter]
    fn transmission_ratio(&self, py: Python<'_>) -> PyResult<f64> {
        Ok(self.ball_drive(py, "transmission_ratio")?.transmission_ratio())
    }

    /// Eccentricity e = K r0, m.
    #[getter]
    fn eccentricity_m(&self, py: Python<'_>) -> PyResult<f64> {
        Ok(self.ball_drive(py, "eccentricity_m")?.deceleration().eccentricity_m())
    }

    /// Number of deceleration balls.
    #[getter]
    fn deceleration_ball_count(&self, py: Python<'_>) -> PyResult<u32> {
        Ok(self.ball_drive(py, "deceleration_ball_count")?.deceleration().ball_count)
    }

    /// Number of equal-speed balls (of one row of a cross-slide).
    #[getter]
    fn equal_speed_ball_count(&self, py: Python<'_>) -> PyResult<u32> {
        Ok(self.ball_drive(py, "equal_speed_ball_count")?.equal_speed().ball_count())
    }

    /// Solves the drive under one load.
    ///
    /// ``torque_Nm``: resistance torque on the output, either sign; ``preload_N``: axial preload, above 0, which a torsion
    /// spring does without;
    /// ``input_angle_deg``: angle of the input crank from the line of centres. Returns a :class:`Solution`, whose
    /// ``status`` says whether there is one; its angles are ``None`` where there is not. Raises ``InvalidInputError``
    /// for a number that cannot be.
    #[pyo3(signature = (torque_Nm, preload_N = None, input_angle_deg = 0.0))]
    fn solve(
        &self,
        py: Python<'_>,
        torque_Nm: f64,
        preload_N: Option<f64>,
        input_angle_deg: f64,
    ) -> PyResult<Solution> {
        let load = match preload_N {
            Some(preload_N) => Load::new(torque_Nm, preload_N, input_angle_deg.to_radians()),
            None => Load::without_preload(torque_Nm, input_angle_deg.to_radians()),
        };
        load.and_then(|load| py.detach(|| Solution::solve(self.clone(), &load, input_angle_deg)))
            .map_err(|error| invalid_input(py, &error))
    }

    /// Preload that a torque (N m) needs: to hold, for continuous transmission, for zero backlash, of each pair and of
    /// the drive; maxima over a period, or at ``input_angle_deg`` where it is given.
    #[pyo3(signature = (torque_Nm, input_angle_deg = None))]
    fn preload(
        &self,
        py: Python<'_>,
        torque_Nm: f64,
        input_angle_deg: Option<f64>,
    ) -> PyResult<PreloadThresholds> {
        Load::new(torque_Nm, 1.0, input_angle_deg.unwrap_or(0.0))
            .map_err(|error| invalid_input(py, &error))?;
        let drive = self.ball_drive(py, "preload")?;
        let found = py.detach(|| match input_angle_deg {
            Some(angle) => drive.preload_thresholds_at(torque_Nm, angle.to_radians()),
            None => drive.preload_thresholds(torque_Nm),
        });
        Ok(PreloadThresholds::new(
            torque_Nm,
            input_angle_deg,
            Thresholds::from(found.deceleration),
            Thresholds::from(found.equal_speed),
        ))
    }

    /// How the elastic angle under a load, and the preload thresholds at its torque over a period, answer to every design
    /// number: exact derivatives. ``also``: names of one of two numbers that are the same and otherwise told as one, such as
    /// ``material.ball_youngs_modulus_Pa``.
    #[pyo3(signature = (torque_Nm, preload_N, input_angle_deg = 0.0, also = Vec::new()))]
    fn sensitivities(
        &self,
        py: Python<'_>,
        torque_Nm: f64,
        preload_N: f64,
        input_angle_deg: f64,
        also: Vec<String>,
    ) -> PyResult<Sensitivities> {
        let drive = self.ball_drive(py, "sensitivities")?;
        let found = Load::new(torque_Nm, preload_N, input_angle_deg.to_radians())
            .and_then(|load| py.detach(|| Sensitivities::solve(drive, &load, &also)));
        found.map_err(|error| invalid_input(py, &error))
    }

    /// Largest elastic angle over a period of the drive at a torque (N m) and preload (N); ``None`` where some angle of
    /// the crank has no solution. Ctrl-C stops it.
    fn largest_elastic_angle(
        &self,
        py: Python<'_>,
        torque_Nm: f64,
        preload_N: f64,
    ) -> PyResult<Option<LargestAngle>> {
        let drive = self.ball_drive(py, "largest_elastic_angle")?;
        let work = |progress: &Progress| drive.largest_elastic_angle_watched(torque_Nm, preload_N, progress);
        let found = without_gil(py, None, work)?;
        Ok(found.map_err(|error| invalid_input(py, &error))?.1.map(LargestAngle::from))
    }

    /// Design findings, the worst first; with a torque and a preload also those of the contacts under load.
    #[pyo3(signature = (torque_Nm = None, preload_N = None, input_angle_deg = 0.0))]
    fn findings(
        &self,
        py: Python<'_>,
        torque_Nm: Option<f64>,
        preload_N: Option<f64>,
        input_angle_deg: f64,
    ) -> PyResult<Vec<Finding>> {
        let load = match (torque_Nm, preload_N) {
            (Some(torque), Some(preload)) => Some(
                Load::new(torque, preload, input_angle_deg.to_radians())
                    .map_err(|error| invalid_input(py, &error))?,
            ),
            (None, None) => None,
            _ => return Err(half_a_load(py)),
        };
        Ok(self.ball_drive(py, "findings")?.findings(load.as_ref()).iter().map(Finding::from).collect())
    }

    fn __reduce__(slf: &Bound<'_, Self>) -> Reduced<(String,)> {
        Ok((slf.get_type().getattr("from_toml")?.unbind(), (slf.get().to_toml(),)))
    }

    fn __hash__(&self) -> u64 {
        hash(&self.to_toml())
    }

    fn __repr__(&self) -> String {
        let drive = match &self.reducer {
            Reducer::BallDrive(drive) => drive,
            Reducer::TorsionSpring(spring) => return repr_of_spring(spring),
        };
        let (pair, equal) = (drive.deceleration(), drive.equal_speed());
        let kind = match equal {
            cbpt_core::EqualSpeed::RingGroove(_) => "ring grooves",
            cbpt_core::EqualSpeed::CrossSlide(_) => "cross-slide",
        };
        let findings = drive.findings(None);
        let worst = findings.iter().map(|f| f.severity).max().filter(|s| *s > Severity::Note);
        format!(
            "Drive(ratio {}, {} deceleration balls of radius {:.4} mm, eccentricity {:.4} mm; {kind} with {} balls on {:.4} mm{})",
            drive.transmission_ratio(),
            pair.ball_count,
            pair.groove.ball_radius_m * 1e3,
            pair.eccentricity_m() * 1e3,
            equal.ball_count(),
            equal.pitch_radius_m() * 1e3,
            worst.map_or(String::new(), |s| format!("; {} finding: see findings()", s.name())),
        )
    }
}

/// One entry of ``[[effect]]``: an id, its port and expression where it is the user's own, and its numbers.
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

/// A case file: the drive and, where they are given, load, measurement, uncertainties and effects.
#[pyclass(frozen, eq, module = "cbpt._core")]
#[derive(Clone, PartialEq)]
pub struct Case {
    case: RustCase,
}

impl Case {
    pub fn rust(&self) -> &RustCase {
        &self.case
    }
}

#[pymethods]
impl Case {
    /// Reads a case file. Raises ``CaseError`` with file, line, key, what was found and what is allowed.
    #[staticmethod]
    fn from_file(py: Python<'_>, path: CasePath) -> PyResult<Self> {
        RustCase::read(&path.0).map(|case| Self { case }).map_err(|error| case_error(py, &error))
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
    fn to_toml(&self) -> String {
        self.case.to_toml()
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

    /// Lever arm of a displacement sensor, mm, or ``None``.
    #[getter]
    fn lever_arm_mm(&self) -> Option<f64> {
        self.case.measurement.lever_arm_m.map(|m| m * 1e3)
    }

    /// The case with these effects in place of its own: ids of the library, each with numbers named as in a case file
    /// (``{"reference_deflection_um": 2}``), what is not given has its default; or own effects, with the values of their
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
    /// Raises ``InvalidInputError`` for a name or a value that cannot be.
    #[pyo3(signature = (numbers: "dict[str, float]"))]
    fn with_numbers(&self, py: Python<'_>, numbers: BTreeMap<String, f64>) -> PyResult<Self> {
        let found: Result<Vec<_>, InvalidInput> =
            numbers.iter().map(|(name, value)| Ok((design::find(name)?, *value))).collect();
        let case = found.and_then(|numbers| self.case.with_numbers(&numbers));
        case.map(|case| Self { case }).map_err(|error| invalid_input(py, &error))
    }

    /// How numbers of a ball drive under a load scatter, by ``[tolerance]`` or else ``[uncertainty]``: name in SI, ``uniform``
    /// or ``normal``, and the limit or standard uncertainty, SI.
    ///
    /// Raises ``InvalidInputError`` for a spread of a common number whose two numbers differ.
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
        Ok((slf.get_type().getattr("from_toml")?.unbind(), (slf.get().to_toml(),)))
    }

    fn __hash__(&self) -> u64 {
        hash(&self.to_toml())
    }

    fn __repr__(&self) -> String {
        let effects: Vec<&str> = self.case.effects.iter().map(|effect| effect.id.as_str()).collect();
        let with =
            if effects.is_empty() { String::new() } else { format!(", effects {}", effects.join(", ")) };
        format!("Case({}{with})", Drive { reducer: self.case.reducer.clone() }.__repr__())
    }
}

fn repr_of_spring(spring: &TorsionSpring) -> String {
    match (spring.torsional_stiffness_Nm_per_rad(), spring.points()) {
        (Some(stiffness), _) => format!("Drive(torsion spring of {stiffness} N m/rad)"),
        (None, points) => {
            let [first, .., last] = points else { return "Drive(torsion spring)".into() };
            format!("Drive(torsion spring, {} points from {} to {} N m)", points.len(), first[0], last[0])
        }
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

/// A number as JSON. What is no finite number stays as text, so that the message names its place.
fn json_number(value: f64) -> Value {
    Number::from_f64(value).map_or_else(|| value.to_string().into(), Into::into)
}

fn hash(text: &str) -> u64 {
    use std::hash::{DefaultHasher, Hash, Hasher};
    let mut hasher = DefaultHasher::new();
    text.hash(&mut hasher);
    hasher.finish()
}
