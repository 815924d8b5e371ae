//! Effects of the user's own, as Python has them: an expression, or a function on whole arrays.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};

use cbpt_cli::case::{self, EffectEntry};
use cbpt_cli::formula::Formula;
use cbpt_core::InvalidInput;
use cbpt_core::effect::dual::Dual;
use cbpt_core::effect::own::{AddsTo, At, OwnEffect as Own, OwnParameter, VARIABLES, Variable};
use numpy::PyArray1;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use serde_json::{Map, Value, json};

use crate::Reduced;
use crate::arrays::Floats;
use crate::error::{case_error, invalid_input};
use crate::given::json_of;

/// Name, unit, start, least and greatest value of a parameter of an own effect.
type ParameterFields = (String, String, f64, Option<f64>, Option<f64>);

/// An effect that the user defines. Make one with :func:`cbpt.effects.expression` or :func:`cbpt.effects.own_effect`.
#[pyclass(frozen, module = "cbpt._core")]
#[derive(Clone)]
pub struct OwnEffect {
    kind: Kind,
}

#[derive(Clone)]
enum Kind {
    Formula(Arc<Formula>),
    Function(Arc<Function>),
}

impl OwnEffect {
    pub fn of(formula: &Arc<Formula>) -> Self {
        Self { kind: Kind::Formula(Arc::clone(formula)) }
    }

    fn own(&self) -> &dyn Own {
        match &self.kind {
            Kind::Formula(formula) => &**formula,
            Kind::Function(function) => &**function,
        }
    }

    /// As the core takes it.
    pub fn rust(&self) -> Arc<dyn Own> {
        match &self.kind {
            Kind::Formula(formula) => Arc::<Formula>::clone(formula),
            Kind::Function(function) => Arc::<Function>::clone(function),
        }
    }

    /// What the user's function raised since it was last asked for.
    pub fn raised(&self) -> Option<PyErr> {
        match &self.kind {
            Kind::Formula(_) => None,
            Kind::Function(function) => function.raised.lock().unwrap_or_else(PoisonError::into_inner).take(),
        }
    }

    /// The entry of a case file, with these values in place of the starts; `None` for a function.
    pub fn entry(&self, starts: &Map<String, Value>) -> Option<Value> {
        let Kind::Formula(formula) = &self.kind else { return None };
        let parameter = |parameter: &OwnParameter| {
            let start = starts.get(&parameter.name).cloned();
            // What is no finite number stays as text, so that the message names its place.
            let value = start.as_ref().map_or(Some(parameter.start), Value::as_f64);
            let moved = value.map(|start| OwnParameter { start, ..parameter.clone() });
            let stated = moved.as_ref().and_then(case::as_stated).or(moved);
            let parameter = stated.as_ref().unwrap_or(parameter);
            let start = if stated.is_some() { json!(parameter.start) } else { json!(start) };
            let mut fields = json!({"unit": parameter.unit, "start": start});
            for (name, bound) in [("min", parameter.min), ("max", parameter.max)] {
                if let Some(bound) = bound {
                    fields[name] = json!(bound);
                }
            }
            (parameter.name.clone(), fields)
        };
        let parameters: Map<String, Value> = formula.parameters().iter().map(parameter).collect();
        let mut entry = json!({
            "id": formula.id(),
            "port": formula.adds_to().port().name(),
            "expression": formula.text(),
            "parameters": parameters,
        });
        if matches!(formula.adds_to(), AddsTo::Torque | AddsTo::Preload) {
            entry["adds_to"] = json!(formula.adds_to().name());
        }
        Some(entry)
    }
}

#[pymethods]
impl OwnEffect {
    /// Makes an effect from the keys of an ``[[effect]]`` with an expression. Raises ``CaseError`` with key and place.
    #[staticmethod]
    #[pyo3(signature = (entry: "dict[str, Any]"))]
    fn from_entry(py: Python<'_>, entry: &Bound<'_, PyDict>) -> PyResult<Self> {
        let value = json_of(entry.as_any())?;
        let found = case::effects_of(&[value]).map_err(|error| case_error(py, &error))?;
        let formula = found.into_iter().find_map(|entry: EffectEntry| entry.own);
        let missing = || InvalidInput::new("expression", "nothing", "an own effect needs one");
        formula.map(|formula| Self::of(&formula)).ok_or_else(|| invalid_input(py, &missing()))
    }

    /// Makes an effect from a function of Python.
    ///
    /// Parameters
    /// ----------
    /// id : str
    ///     Name of the effect.
    /// port : str
    ///     ``load``, ``series`` or ``reading``.
    /// adds_to : str or None
    ///     At the port ``load``: ``torque_Nm`` or ``preload_N``.
    /// function : callable
    ///     Takes all columns (a dict of arrays) and the values of the parameters (a list), and returns an array with one number
    ///     for each row. Its attribute ``used`` is the set of columns that it reads.
    /// parameters : list of tuple
    ///     Name, unit, start, least and greatest value of each parameter, in that unit.
    ///
    /// Returns
    /// -------
    /// OwnEffect
    ///     The effect.
    ///
    /// Raises
    /// ------
    /// InvalidInputError, CaseError
    ///     For a name, a port or a parameter that is not allowed.
    #[staticmethod]
    fn from_function(
        py: Python<'_>,
        id: String,
        port: String,
        adds_to: Option<String>,
        function: Py<PyAny>,
        parameters: Vec<ParameterFields>,
    ) -> PyResult<Self> {
        let adds_to = AddsTo::of(&port, adds_to.as_deref()).map_err(|error| invalid_input(py, &error))?;
        // The names and bounds of a function's parameters are held to the rules of a case file.
        let names: Vec<String> = parameters.iter().map(|(name, ..)| name.clone()).collect();
        let constant = Formula::new(&id, adds_to, "0", parameters.into_iter().map(parameter_of).collect());
        let formula = constant.map_err(|wrong| {
            invalid_input(py, &InvalidInput::new("expression", names.join(", "), wrong.problem))
        })?;
        let checked = Self::of(&Arc::new(formula));
        let entry = checked.entry(&Map::new()).unwrap_or_default();
        let read = case::effects_of(&[entry]).map_err(|error| case_error(py, &error))?;
        // As a case file is read: numbers and units in SI.
        let formula = read.into_iter().find_map(|entry| entry.own);
        let parameters = formula.map(|formula| formula.parameters().to_vec()).unwrap_or_default();
        let function = Function { id, adds_to, parameters, function, raised: Mutex::new(None) };
        Ok(Self { kind: Kind::Function(Arc::new(function)) })
    }

    /// Its name.
    #[getter]
    pub fn id(&self) -> &str {
        self.own().id()
    }

    /// ``load``, ``series`` or ``reading``.
    #[getter]
    fn port(&self) -> &'static str {
        self.own().adds_to().port().name()
    }

    /// ``torque_Nm``, ``preload_N`` or ``angle_rad``.
    #[getter]
    fn adds_to(&self) -> &'static str {
        self.own().adds_to().name()
    }

    /// Its formula, or ``None`` for a function.
    #[getter]
    fn expression(&self) -> Option<&str> {
        match &self.kind {
            Kind::Formula(formula) => Some(formula.text()),
            Kind::Function(_) => None,
        }
    }

    /// Name, SI unit, start, least and greatest value of each parameter, in SI.
    #[getter]
    fn parameters(&self) -> Vec<ParameterFields> {
        let fields = |p: &OwnParameter| (p.name.clone(), p.unit.clone(), p.start, p.min, p.max);
        self.own().parameters().iter().map(fields).collect()
    }

    /// The unit in which each parameter was stated.
    #[getter]
    fn stated_units(&self) -> BTreeMap<String, String> {
        let stated = |p: &OwnParameter| if p.stated.is_empty() { p.unit.clone() } else { p.stated.clone() };
        self.own().parameters().iter().map(|p| (p.name.clone(), stated(p))).collect()
    }

    /// Whether it depends on a variable, for example ``time_s``; for a function, whether it has read that column.
    fn uses(&self, variable: &str) -> bool {
        match &self.kind {
            Kind::Formula(formula) => Variable::find(variable).is_some_and(|found| formula.uses(found)),
            Kind::Function(function) => function.has_used(variable),
        }
    }

    /// The ``[[effect]]`` of a case file as TOML text. Raises ``InvalidInputError`` for a function.
    fn to_toml(&self, py: Python<'_>) -> PyResult<String> {
        let Kind::Formula(formula) = &self.kind else {
            let rule = "is a function of Python, which a case file cannot hold; write it as an expression";
            return Err(invalid_input(py, &InvalidInput::new("effect", self.id(), rule)));
        };
        Ok(case::effect_toml(&EffectEntry {
            id: formula.id().into(),
            numbers: Vec::new(),
            own: Some(Arc::clone(formula)),
        }))
    }

    fn __reduce__(slf: &Bound<'_, Self>) -> Reduced<(Py<PyAny>,)> {
        let (py, class, effect) = (slf.py(), slf.get_type(), slf.get());
        match &effect.kind {
            Kind::Formula(_) => {
                let entry = effect.entry(&Map::new()).unwrap_or_default().to_string();
                let entry = py.import("json")?.call_method1("loads", (entry,))?;
                Ok((class.getattr("from_entry")?.unbind(), (entry.unbind(),)))
            }
            Kind::Function(function) => {
                let adds_to = (effect.port() == "load").then(|| effect.adds_to());
                let given = (class.getattr("from_function")?, effect.id(), effect.port(), adds_to);
                let partial = py.import("functools")?.getattr("partial")?;
                let maker = partial.call1(given)?;
                let maker = partial.call1((maker, function.function.clone_ref(py)))?;
                let parameters = effect.parameters().into_pyobject(py)?.into_any();
                Ok((maker.unbind(), (parameters.unbind(),)))
            }
        }
    }

    fn __repr__(&self) -> String {
        let what = self.expression().unwrap_or("a function");
        format!("OwnEffect({}, added to {} at the {} port: {what})", self.id(), self.adds_to(), self.port())
    }
}

fn parameter_of((name, unit, start, min, max): ParameterFields) -> OwnParameter {
    OwnParameter { name, unit, stated: String::new(), start, min, max }
}

/// Variables that an own effect may depend on: name and meaning.
#[pyfunction]
pub fn own_effect_variables() -> Vec<(&'static str, &'static str)> {
    VARIABLES.iter().map(|(_, name, meaning)| (*name, *meaning)).collect()
}

/// A function of Python on whole arrays; its slopes are differences.
#[derive(Debug)]
struct Function {
    id: String,
    adds_to: AddsTo,
    parameters: Vec<OwnParameter>,
    function: Py<PyAny>,
    /// What it raised, to be raised again where its caller is back in Python.
    raised: Mutex<Option<PyErr>>,
}

/// Share of a number by which it is moved for a difference: near the cube root of the rounding error.
const STEP: f64 = 6e-6;

impl Function {
    fn has_used(&self, variable: &str) -> bool {
        Python::attach(|py| {
            let used = self.function.getattr(py, "used");
            used.and_then(|used| used.bind(py).contains(variable)).unwrap_or(false)
        })
    }

    /// Its values and, for each number that has a slope, the differences by it.
    fn differentiated(&self, py: Python<'_>, own: &[Dual], rows: &[At<'_>]) -> PyResult<Vec<Dual>> {
        let values: Vec<f64> = own.iter().map(|number| number.value).collect();
        let at = |values: &[f64], moved: Option<(Variable, &[f64])>| self.call(py, values, rows, moved);
        let mut found: Vec<Dual> = at(&values, None)?.into_iter().map(Dual::constant).collect();
        for (place, number) in own.iter().enumerate().filter(|(_, number)| has_slope(number)) {
            let (low, high) = self.parameters[place].limits();
            let size = if values[place] == 0.0 {
                self.parameters[place].start.abs().max(1e-9)
            } else {
                values[place].abs()
            };
            let [mut below, mut above] = [values.clone(), values.clone()];
            below[place] = (values[place] - STEP * size).max(low);
            above[place] = (values[place] + STEP * size).min(high);
            let width = above[place] - below[place];
            let change = at(&above, None)?.into_iter().zip(at(&below, None)?);
            for (row, (above, below)) in found.iter_mut().zip(change) {
                row.add_slope((above - below) / width, number);
            }
        }
        // What the numbers of other effects make of the load and the angle before this one.
        for variable in [Variable::Torque, Variable::Preload, Variable::Angle] {
            let column: Vec<Dual> = rows.iter().map(|at| at.get(variable)).collect();
            let known = variable != Variable::Angle || self.adds_to == AddsTo::Reading;
            if !known || !column.iter().any(has_slope) {
                continue;
            }
            let size =
                column.iter().map(|x| x.value.abs()).filter(|x| x.is_finite()).fold(0.0, f64::max).max(1e-12);
            let moved = |by: f64| -> Vec<f64> { column.iter().map(|x| x.value + by * STEP * size).collect() };
            let change = at(&values, Some((variable, &moved(1.0))))?
                .into_iter()
                .zip(at(&values, Some((variable, &moved(-1.0))))?);
            for ((row, number), (above, below)) in found.iter_mut().zip(&column).zip(change) {
                row.add_slope((above - below) / (2.0 * STEP * size), number);
            }
        }
        Ok(found)
    }

    fn call(
        &self,
        py: Python<'_>,
        values: &[f64],
        rows: &[At<'_>],
        moved: Option<(Variable, &[f64])>,
    ) -> PyResult<Vec<f64>> {
        let columns = PyDict::new(py);
        for (variable, name, _) in VARIABLES {
            if variable == Variable::Angle && self.adds_to != AddsTo::Reading {
                continue;
            }
            let array = match moved {
                Some((which, column)) if which == variable => PyArray1::from_slice(py, column),
                _ => PyArray1::from_iter(py, rows.iter().map(|at| at.get(variable).value)),
            };
            columns.set_item(name, array)?;
        }
        let found = self.function.call1(py, (columns, values.to_vec()))?;
        Ok(found.extract::<Floats<'_>>(py)?.view().to_vec())
    }
}

fn has_slope(number: &Dual) -> bool {
    number.partials.iter().any(|partial| *partial != 0.0 && partial.is_finite())
}

impl Own for Function {
    fn id(&self) -> &str {
        &self.id
    }

    fn adds_to(&self) -> AddsTo {
        self.adds_to
    }

    fn parameters(&self) -> &[OwnParameter] {
        &self.parameters
    }

    /// At the series port it is asked before the drive is solved, so that friction counts it.
    fn uses(&self, variable: Variable) -> bool {
        variable == Variable::Angle && self.adds_to == AddsTo::Reading
    }

    fn values(&self, own: &[Dual], rows: &[At<'_>]) -> Result<Vec<Dual>, InvalidInput> {
        Python::attach(|py| self.differentiated(py, own, rows)).map_err(|error| {
            let told = InvalidInput::new("effect", &self.id, format!("its function raised {error}"));
            *self.raised.lock().unwrap_or_else(PoisonError::into_inner) = Some(error);
            told
        })
    }
}
