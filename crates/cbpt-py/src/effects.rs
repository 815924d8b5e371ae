//! The library of effects, and a drive with effects on a table of readings.

use std::sync::{Mutex, PoisonError};

use cbpt_core::effect::{self, Scale};
use cbpt_core::predict::{self, Columns, Effect, Number, Rows, TorqueTurns};
use pyo3::prelude::*;

use crate::arrays::{Column, Floats, Integers, Table};
use crate::case::{IdOrOwn, of_word};
use crate::drive::Drive;
use crate::error::invalid_input;
use crate::own::OwnEffect;
use crate::threads::detached;

/// A number of an effect. Values are SI; ``display_name`` and ``display_size`` give the unit that people read.
#[pyclass(frozen, get_all, module = "cbpt._core")]
#[derive(Clone)]
pub struct EffectParameter {
    /// Name with its SI unit, for example ``reference_deflection_m``.
    name: String,
    /// Name with the unit that people read, for example ``reference_deflection_um``.
    display_name: String,
    /// SI value of one unit of ``display_name``.
    display_size: f64,
    /// What it is.
    meaning: String,
    /// Value at which a size has no effect; for any other parameter its default.
    neutral: f64,
    /// Least value that has a meaning.
    lower: f64,
    /// Greatest value that has a meaning.
    upper: f64,
    /// Plausible values, as a prior: lowest and highest.
    range: (f64, f64),
    /// ``linear``, ``log``, or ``fixed`` for a whole number that is chosen, not fitted.
    scale: String,
    /// Whether it is a size: an effect vanishes if all its sizes are neutral.
    is_size: bool,
}

#[pymethods]
impl EffectParameter {
    fn __repr__(&self) -> String {
        format!("EffectParameter({}, {} to {}: {})", self.name, self.range.0, self.range.1, self.meaning)
    }
}

impl From<&Number> for EffectParameter {
    fn from(number: &Number) -> Self {
        let own = match number {
            Number::Library(parameter) => return Self::from(*parameter),
            Number::Own(own) => own,
        };
        let (lower, upper) = own.limits();
        Self {
            name: own.name.clone(),
            display_name: own.name.clone(),
            display_size: 1.0,
            meaning: format!("of the user's own, {}", own.unit),
            neutral: own.start,
            lower,
            upper,
            range: own.range(),
            scale: "linear".into(),
            is_size: false,
        }
    }
}

impl From<&effect::Parameter> for EffectParameter {
    fn from(parameter: &effect::Parameter) -> Self {
        Self {
            name: parameter.name(),
            display_name: parameter.display_name(),
            display_size: parameter.display().size(),
            meaning: parameter.meaning.into(),
            neutral: parameter.neutral,
            lower: parameter.lower,
            upper: parameter.upper,
            range: parameter.range,
            scale: match parameter.scale {
                Scale::Linear => "linear",
                Scale::Log => "log",
                Scale::Fixed => "fixed",
            }
            .into(),
            is_size: parameter.is_size,
        }
    }
}

/// An effect of the library.
#[pyclass(frozen, get_all, module = "cbpt._core")]
#[derive(Clone)]
pub struct EffectSpec {
    /// Its fixed id.
    id: String,
    /// ``parameter``, ``rig`` or ``effect``.
    kind: String,
    /// Where it acts: ``load``, ``gap``, ``contact``, ``series`` or ``reading``.
    port: String,
    /// Its equation.
    equation: String,
    /// Where the equation comes from.
    source: String,
    /// How it shows in readings.
    tell_tale: String,
    /// Its parameters.
    parameters: Vec<EffectParameter>,
    /// Ids of effects that no torque-angle data can tell from this one when the contact stiffness is fitted as well.
    twins: Vec<String>,
    /// Kinds of reducer that can have it: ``ball_drive``, ``torsion_spring``.
    reducers: Vec<String>,
}

#[pymethods]
impl EffectSpec {
    fn __repr__(&self) -> String {
        format!("EffectSpec({}, {} at the {} port: {})", self.id, self.kind, self.port, self.equation)
    }
}

/// Every effect of the library, in the order of all documents.
#[pyfunction]
pub fn effect_specs() -> Vec<EffectSpec> {
    let spec = |spec: &effect::Spec| EffectSpec {
        id: spec.id.into(),
        kind: spec.class.name().into(),
        port: spec.port.name().into(),
        equation: spec.equation.into(),
        source: spec.source.into(),
        tell_tale: spec.tell_tale.into(),
        parameters: spec.parameters.iter().map(EffectParameter::from).collect(),
        twins: spec.twins.iter().map(|&id| id.into()).collect(),
        reducers: [("ball_drive", spec.suits_ball_drives()), ("torsion_spring", spec.suits_springs(true))]
            .into_iter()
            .filter(|(_, suits)| *suits)
            .map(|(kind, _)| kind.into())
            .collect(),
    };
    effect::LIBRARY.into_iter().map(spec).collect()
}

/// What an ideal instrument would show, row by row.
#[pyclass(frozen, module = "cbpt._core")]
pub struct Prediction {
    prediction: predict::Prediction,
}

#[pymethods]
impl Prediction {
    /// Elastic angle as the instrument shows it, rad, shape (n,); NaN where there is no solution.
    #[getter]
    fn angle_rad<'py>(&self, py: Python<'py>) -> Column<'py, f64> {
        Column::new(py, self.prediction.angle_rad.iter().copied())
    }

    /// Derivative of the angle by each of the wanted parameters, rad per SI unit, shape (n, len(wanted)); NaN where there
    /// is no solution.
    #[getter]
    fn sensitivities<'py>(&self, py: Python<'py>) -> PyResult<Table<'py, f64>> {
        Table::of_rows(py, &self.prediction.sensitivities, self.prediction.angle_rad.len())
    }

    /// Status of each row: ``ok``, ``outside_small_displacements``, ``outside_table``, ``beyond_hold``, ``undercut``,
    /// ``indeterminate`` or ``not_converged``.
    #[getter]
    fn status(&self) -> Vec<&'static str> {
        self.prediction.status.iter().map(cbpt_core::Status::name).collect()
    }

    /// Parts of the meshing points, rad, shape (n, 2): of the deceleration pair, and what of the equal-speed pair reaches the
    /// output; NaN where there is no solution.
    #[getter]
    fn parts_rad<'py>(&self, py: Python<'py>) -> PyResult<Table<'py, f64>> {
        let parts = self.prediction.parts_rad.as_flattened();
        Table::of_rows(py, parts, self.prediction.parts_rad.len())
    }

    /// Largest scaled residual of each row, shape (n,); NaN where there is no solution.
    #[getter]
    fn residual<'py>(&self, py: Python<'py>) -> Column<'py, f64> {
        Column::new(py, self.prediction.residual.iter().copied())
    }

    /// Preload at which each torque would just slip, N, shape (n,), where the status is ``beyond_hold``; else NaN.
    #[getter]
    fn hold_preload_N<'py>(&self, py: Python<'py>) -> Column<'py, f64> {
        let hold = |status: &cbpt_core::Status| match status {
            cbpt_core::Status::BeyondHold { hold_preload_N } => *hold_preload_N,
            _ => f64::NAN,
        };
        Column::new(py, self.prediction.status.iter().map(hold))
    }

    /// Whether each row has a solution, 1 or 0, shape (n,).
    #[getter]
    fn solved<'py>(&self, py: Python<'py>) -> Column<'py, u8> {
        Column::new(py, self.prediction.status.iter().map(|status| u8::from(status.has_solution())))
    }

    /// Diagonals that carry in one row of the deceleration and of the equal-speed pair, shape (n, 2).
    #[getter]
    fn carrying<'py>(&self, py: Python<'py>) -> PyResult<Table<'py, u32>> {
        let narrow = |count: &usize| u32::try_from(*count).unwrap_or(u32::MAX);
        let counts: Vec<u32> = self.prediction.carrying.as_flattened().iter().map(narrow).collect();
        Table::of_rows(py, &counts, self.prediction.carrying.len())
    }

    /// Which contacts carry, shape (n,): 0 all that exist, 1 some have parted, 2 below continuous transmission (d <= 0 in
    /// a pair), 255 no solution or a torsion spring.
    #[getter]
    fn regime<'py>(&self, py: Python<'py>) -> Column<'py, u8> {
        Column::new(py, self.prediction.regime.iter().map(|regime| regime.map_or(255, |regime| regime as u8)))
    }

    fn __repr__(&self) -> String {
        let solved = self.prediction.status.iter().filter(|status| status.has_solution()).count();
        format!("Prediction({solved} of {} rows solved)", self.prediction.status.len())
    }
}

/// A drive with effects on a table of readings.
///
/// Meshing points and solutions are kept from call to call, so a fit pays for changes only; an answer does not depend on earlier
/// calls beyond the tolerance of the equations, and not at all after ``cold``. Calls from several threads wait for each other.
///
/// Parameters
/// ----------
/// drive : Drive
///     A ball drive or a torsion spring.
/// effects : list of str or OwnEffect
///     Ids of the library, one as often as wanted, and own effects.
/// run : array of int, shape (n,)
///     The run of each reading.
/// time_s : array, shape (n,)
///     In order within a run.
/// torque_Nm : array, shape (n,)
///     Of either sign.
/// preload_N : array, shape (n,), or None
///     Above 0; ``None`` for a torsion spring without a preload.
/// input_angle_rad : array, shape (n,)
///     Angle of the input crank.
/// temperature_K : array, shape (n,), optional
///     Where it was read; degrees Celsius will do, as only differences count.
/// cycle : array, shape (n,), optional
///     Load cycle of each reading, where it was counted.
///
/// Raises
/// ------
/// InvalidInputError
///     Names column, row and rule.
#[pyclass(frozen, module = "cbpt._core")]
pub struct Predictor {
    predictor: Mutex<predict::Predictor>,
    drive: Drive,
    own: Vec<Py<OwnEffect>>,
}

impl Predictor {
    fn with<T: Send>(
        &self,
        py: Python<'_>,
        work: impl FnOnce(&mut predict::Predictor) -> Result<T, cbpt_core::InvalidInput> + Send,
    ) -> PyResult<T> {
        self.locked(py, work)?.map_err(|error| self.told(py, &error))
    }

    /// Has the predictor at work, without the GIL.
    pub fn locked<T: Send>(
        &self,
        py: Python<'_>,
        work: impl FnOnce(&mut predict::Predictor) -> T + Send,
    ) -> PyResult<T> {
        // What a panic would leave behind are only starts of iterations.
        detached(py, || work(&mut self.predictor.lock().unwrap_or_else(PoisonError::into_inner)))
    }

    /// What a function of Python raised is the user's to see, not how it was told on the way.
    pub fn told(&self, py: Python<'_>, error: &cbpt_core::InvalidInput) -> PyErr {
        let raised = self.own.iter().find_map(|own| own.get().raised());
        raised.unwrap_or_else(|| invalid_input(py, error))
    }

    /// Looks at the predictor without holding Python back: a function of Python may be at work in it.
    fn look<T: Send>(&self, py: Python<'_>, of: impl FnOnce(&predict::Predictor) -> T + Send) -> T {
        py.detach(|| of(&self.predictor.lock().unwrap_or_else(PoisonError::into_inner)))
    }
}

#[pymethods]
impl Predictor {
    #[new]
    #[pyo3(signature = (drive, effects, run, time_s, torque_Nm, preload_N, input_angle_rad, temperature_K = None, cycle = None, torque_turns = "where_ramps_meet"))]
    #[expect(clippy::too_many_arguments, reason = "the columns of a table")]
    fn new(
        py: Python<'_>,
        drive: &Drive,
        effects: Vec<IdOrOwn>,
        run: Integers<'_>,
        time_s: Floats<'_>,
        torque_Nm: Floats<'_>,
        preload_N: Option<Floats<'_>>,
        input_angle_rad: Floats<'_>,
        temperature_K: Option<Floats<'_>>,
        cycle: Option<Floats<'_>>,
        torque_turns: &str,
    ) -> PyResult<Self> {
        let column = |values: &Floats<'_>| values.view().to_vec();
        let (time, torque) = (column(&time_s), column(&torque_Nm));
        let preload = preload_N.as_ref().map(column);
        let (angle, temperature) = (column(&input_angle_rad), temperature_K.as_ref().map(column));
        let cycle = cycle.as_ref().map(column);
        let turns = of_word(py, "torque_turns", &TorqueTurns::WORDS, torque_turns)?;
        let columns = Columns {
            run: &run.view().to_vec(),
            time_s: &time,
            torque_Nm: &torque,
            preload_N: preload.as_deref(),
            input_angle_rad: &angle,
            temperature_K: temperature.as_deref(),
            cycle: cycle.as_deref(),
        };
        let rows = Rows::with_turns(columns, turns);
        let mut own = Vec::new();
        let mut found = Vec::new();
        for (place, effect) in effects.into_iter().enumerate() {
            found.push(match effect {
                IdOrOwn::Id(id) => predict::slots::known(place, &id).map(Effect::Library),
                IdOrOwn::Own(effect) => {
                    own.push(effect.clone_ref(py));
                    Ok(Effect::Own(effect.get().rust()))
                }
            });
        }
        let predictor = rows.and_then(|rows| {
            let effects = found.into_iter().collect::<Result<_, _>>()?;
            predict::Predictor::of(drive.rust(), effects, rows)
        });
        let predictor = predictor.map_err(|error| invalid_input(py, &error))?;
        Ok(Self { predictor: Mutex::new(predictor), drive: drive.clone(), own })
    }

    /// The drive without effects.
    #[getter]
    fn drive(&self) -> Drive {
        self.drive.clone()
    }

    /// Ids of the effects, in the order given.
    #[getter]
    fn effects(&self, py: Python<'_>) -> Vec<String> {
        self.look(py, |predictor| predictor.effects().iter().map(|effect| effect.id().to_owned()).collect())
    }

    /// The numbers of all effects, in the order of ``values``: index of the effect, its id, the number.
    #[getter]
    fn parameters(&self, py: Python<'_>) -> Vec<(usize, String, EffectParameter)> {
        self.look(py, |predictor| {
            let id = |slot: &predict::Slot| predictor.effects()[slot.effect].id().to_owned();
            let of = |slot: &predict::Slot| (slot.effect, id(slot), EffectParameter::from(&slot.parameter));
            predictor.parameters().iter().map(of).collect()
        })
    }

    /// Values at which every effect of the library vanishes, shape (p,); what is no size has its default, and own effects
    /// have their starts.
    fn neutral<'py>(&self, py: Python<'py>) -> Column<'py, f64> {
        Column::new(py, self.look(py, predict::Predictor::neutral))
    }

    /// Another one like it, for a thread of its own.
    fn __copy__(&self, py: Python<'_>) -> Self {
        let predictor = self.look(py, predict::Predictor::clone);
        let own = self.own.iter().map(|own| own.clone_ref(py)).collect();
        Self { predictor: Mutex::new(predictor), drive: self.drive.clone(), own }
    }

    /// Forgets the solutions of earlier calls, from which the next one would start: what follows is to the last bit what a
    /// new predictor would say. Meshing points are kept.
    fn cold(&self, py: Python<'_>) {
        py.detach(|| self.predictor.lock().unwrap_or_else(PoisonError::into_inner).cold());
    }

    /// How many runs go on from where the one before them ended, with the friction that it has left.
    #[getter]
    fn runs_that_go_on(&self, py: Python<'_>) -> usize {
        self.look(py, |predictor| predictor.rows().runs_that_go_on())
    }

    /// How many runs go on from a repetition of themselves, or a loop, that nobody measured.
    #[getter]
    fn runs_with_unmeasured_past(&self, py: Python<'_>) -> usize {
        self.look(py, |predictor| predictor.rows().runs_with_unmeasured_past())
    }

    /// Rows of the readings before each turn of the torque between readings, or over it, as both ramps beside it say.
    #[getter]
    fn turns_between_readings(&self, py: Python<'_>) -> Vec<usize> {
        self.look(py, |predictor| predictor.rows().turns_between_readings())
    }

    /// Whether the readings are means over time, from halfway to the one before to halfway to the next, as those over turns say.
    #[getter]
    fn readings_are_means(&self, py: Python<'_>) -> bool {
        self.look(py, |predictor| predictor.rows().are_means())
    }

    /// From now on the friction of runs goes on, or not, as a case says by its word for `friction_between_runs`. Raises
    /// ``InvalidInputError`` for any other word.
    fn take_history(&self, py: Python<'_>, word: &str) -> PyResult<()> {
        let history = of_word(py, "friction_between_runs", &predict::History::WORDS, word)?;
        py.detach(|| {
            self.predictor.lock().unwrap_or_else(PoisonError::into_inner).take_history(history);
        });
        Ok(())
    }

    /// Predicts all rows at ``values`` (p,), and the exact derivatives by the parameters whose indices are ``wanted``.
    ///
    /// Raises ``InvalidInputError`` for a value out of its bounds and for a wanted parameter that is chosen, not fitted. A
    /// row without solution has its status, NaN angle and NaN derivatives.
    #[pyo3(signature = (values, wanted = None))]
    fn predict(
        &self,
        py: Python<'_>,
        values: Floats<'_>,
        wanted: Option<Vec<usize>>,
    ) -> PyResult<Prediction> {
        let (values, wanted) = (values.view().to_vec(), wanted.unwrap_or_default());
        let prediction = self.with(py, |predictor| predictor.predict(&values, &wanted))?;
        Ok(Prediction { prediction })
    }

    /// Named parts of the angle at ``values`` (p,): ``model`` without effects, then what each effect adds as they are
    /// switched on in the order of the ports; each rad, shape (n,). They add up to the angle.
    fn contributions<'py>(
        &self,
        py: Python<'py>,
        values: Floats<'py>,
    ) -> PyResult<Vec<(String, Column<'py, f64>)>> {
        let values = values.view().to_vec();
        let parts = self.with(py, |predictor| predictor.contributions(&values))?;
        Ok(parts.into_iter().map(|part| (part.name, Column::new(py, part.angle_rad))).collect())
    }

    fn __repr__(&self, py: Python<'_>) -> String {
        self.look(py, |predictor| {
            let ids: Vec<&str> = predictor.effects().iter().map(Effect::id).collect();
            format!("Predictor({} rows, effects: {})", predictor.rows().len(), ids.join(", "))
        })
    }
}
