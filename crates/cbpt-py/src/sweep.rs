//! Plans of sweeps, their rows and the files that these go to.

// A mistake is told once; its size does not matter.
#![allow(clippy::result_large_err)]

use std::ops::Range;
use std::path::PathBuf;
use std::sync::Arc;

use cbpt_cli::case::Case as RustCase;
use cbpt_cli::case::Mistake;
use cbpt_cli::commands::sweep_plan::is_plan;
use cbpt_cli::exit::{Failure, keep_input};
use cbpt_cli::sweep::design::Design;
use cbpt_cli::sweep::output::{CsvOutput, same_plan};
use cbpt_cli::sweep::rows::{Rows, STATUSES};
use cbpt_cli::sweep::stream::{chunks, on_threads};
use cbpt_cli::sweep::tally::Tally;
use cbpt_cli::sweep::{Axis, CHUNK_ROWS, Plan, Values};
use cbpt_core::findings::UNBUILDABLE;
use cbpt_core::sweep::Progress;
use pyo3::prelude::*;
use pyo3::types::PyBytes;

use crate::Reduced;
use crate::arrays::{Column, Floats};
use crate::case::Case;
use crate::error::{plan_error, sweep_failure};
use crate::interrupt::without_gil;

/// The values of an axis: a range (from, to, whether logarithmic), numbers, or words.
#[derive(FromPyObject)]
pub enum AxisValues<'py> {
    /// From, to, whether logarithmic.
    Between((f64, f64, bool)),
    /// Numbers.
    Numbers(Floats<'py>),
    /// Words.
    Words(Vec<String>),
}

impl From<AxisValues<'_>> for Values {
    fn from(values: AxisValues<'_>) -> Self {
        match values {
            AxisValues::Between((from, to, log)) => Self::Between { from, to, log },
            AxisValues::Numbers(numbers) => Self::Numbers(numbers.view().to_vec()),
            AxisValues::Words(words) => Self::words(&words),
        }
    }
}

/// The values of an axis on their way to Python.
#[derive(IntoPyObject)]
pub enum GivenValues<'py> {
    /// From, to, whether logarithmic.
    Between((f64, f64, bool)),
    /// Numbers.
    Numbers(Column<'py, f64>),
    /// Words.
    Words(Vec<String>),
}

/// What a plan is made of: case, axes, design, rows, seed, where a part of a table begins, further columns.
type State<'py> = (String, Vec<(String, GivenValues<'py>)>, String, u64, u64, u64, Vec<String>);

/// Columns of solved rows: of each axis, elastic angle, its two parts, residual, preload to hold, code of the finding,
/// place of the status, further columns.
type Columns<'py> = (
    Vec<Column<'py, f64>>,
    Column<'py, f64>,
    Column<'py, f64>,
    Column<'py, f64>,
    Column<'py, f64>,
    Column<'py, f64>,
    Column<'py, u8>,
    Column<'py, u8>,
    Vec<Column<'py, f64>>,
);

/// A sweep as data: a case, its axes, and the design of its rows. Each row depends only on the plan and on its number, so
/// any process can solve any part.
///
/// Axes are pairs of a name, which is a key of the case with its section, and values in the unit of that key. ``cbpt.sweep``
/// takes simpler forms of them.
#[pyclass(frozen, module = "cbpt._core")]
#[derive(Clone)]
pub struct SweepPlan {
    plan: Arc<Plan>,
}

impl SweepPlan {
    fn on_threads<T: Send>(
        py: Python<'_>,
        threads: Option<usize>,
        report: Option<&Bound<'_, PyAny>>,
        work: impl FnOnce(&Progress) -> Option<T> + Send,
    ) -> PyResult<T> {
        let found = without_gil(py, report, |progress| on_threads(threads, || work(progress)))?;
        // Only a signal cancels it, and that is raised above.
        found.ok_or_else(|| plan_error(py, "the threads of the sweep could not be started"))
    }

    fn range(&self, py: Python<'_>, start: u64, stop: u64) -> PyResult<Range<u64>> {
        if start < stop && stop <= self.plan.rows() {
            return Ok(start..stop);
        }
        Err(plan_error(
            py,
            &format!("rows {start} to {stop} are not among the {} rows of the plan", self.plan.rows()),
        ))
    }
}

#[pymethods]
impl SweepPlan {
    /// Makes a plan.
    ///
    /// Parameters
    /// ----------
    /// case : Case
    ///     What stays the same.
    /// axes : list of tuple
    ///     Key and values of each axis: a range (start, stop, whether in logarithms), an array or words.
    /// design : str, optional
    ///     ``grid``, ``random``, ``latin_hypercube`` or ``table``.
    /// rows : int, optional
    ///     Number of rows of ``random`` and ``latin_hypercube``.
    /// seed : int, optional
    ///     Seed of their random numbers.
    ///
    /// columns : list of str, optional
    ///     Further columns, of the drive alone: ``friction_torque_Nm``, ``efficiency``, ``wear_Nm_per_turn``, ``static_safety``,
    ///     ``natural_frequency_Hz``.
    ///
    /// Raises
    /// ------
    /// PlanError
    ///     Names the axis, what was found and what is allowed.
    #[new]
    #[pyo3(signature = (case, axes: "list[tuple[str, tuple[float, float, bool] | NDArray[float64] | list[str]]]", design = "grid", rows = None, seed = 0, columns = Vec::new()))]
    #[expect(clippy::too_many_arguments, reason = "what a plan is made of, one by one")]
    fn new(
        py: Python<'_>,
        case: &Case,
        axes: Vec<(String, AxisValues<'_>)>,
        design: &str,
        rows: Option<u64>,
        seed: u64,
        columns: Vec<String>,
    ) -> PyResult<Self> {
        let names: Vec<&str> = Design::ALL.iter().map(|(name, _)| *name).collect();
        let Some((_, design)) = Design::ALL.iter().find(|(name, _)| *name == design) else {
            return Err(plan_error(
                py,
                &format!("design = {design:?}: expected one of {}", names.join(", ")),
            ));
        };
        let case = case.rust();
        let axes: Result<Vec<Axis>, Mistake> =
            axes.into_iter().map(|(name, values)| Axis::new(case, &name, values.into())).collect();
        axes.and_then(|axes| Plan::new(case.clone(), axes, *design, rows, seed))
            .and_then(|plan| plan.with_columns(&columns))
            .map(|plan| Self { plan: Arc::new(plan) })
            .map_err(|mistake| plan_error(py, &mistake.to_string()))
    }

    /// Reads a plan in TOML, with the case and the table that it names. Raises ``PlanError`` with file, line and key.
    #[staticmethod]
    fn from_file(py: Python<'_>, path: PathBuf) -> PyResult<Self> {
        let plan = py.detach(|| Plan::read(&path)).map_err(|error| plan_error(py, &error.to_string()))?;
        Ok(Self { plan: Arc::new(plan) })
    }

    /// Number of rows.
    #[getter]
    fn rows(&self) -> u64 {
        self.plan.rows()
    }

    /// ``grid``, ``random``, ``latin_hypercube`` or ``table``.
    #[getter]
    fn design(&self) -> &'static str {
        self.plan.design().name()
    }

    /// Seed of the random numbers of the designs ``random`` and ``latin_hypercube``.
    #[getter]
    fn seed(&self) -> u64 {
        self.plan.seed()
    }

    /// Names of the axes, in their order.
    #[getter]
    fn names(&self) -> Vec<String> {
        self.plan.axes().iter().map(|axis| axis.parameter.name.clone()).collect()
    }

    /// Unit of each axis as keys write it; empty for plain numbers and words.
    #[getter]
    fn units(&self) -> Vec<String> {
        self.plan.axes().iter().map(|axis| axis.parameter.unit.clone()).collect()
    }

    /// What each axis is, in words.
    #[getter]
    fn meanings(&self) -> Vec<String> {
        self.plan.axes().iter().map(|axis| axis.parameter.meaning.clone()).collect()
    }

    /// The words of each axis; empty for an axis of numbers.
    #[getter]
    fn words(&self) -> Vec<Vec<String>> {
        let words = |axis: &Axis| match &axis.values {
            Values::Words(words, _) => words.clone(),
            _ => Vec::new(),
        };
        self.plan.axes().iter().map(words).collect()
    }

    /// The values of each axis as they were given.
    fn values<'py>(&self, py: Python<'py>) -> Vec<GivenValues<'py>> {
        self.plan.axes().iter().map(|axis| given(py, &axis.values)).collect()
    }

    /// Number of rows after which the value of each axis of a grid changes: the load changes fastest, the drive slowest.
    #[getter]
    fn strides(&self) -> Vec<u64> {
        self.plan.strides().to_vec()
    }

    /// Names of the further columns, in their order.
    #[getter]
    fn columns(&self) -> Vec<&'static str> {
        self.plan.columns().iter().map(|cost| cost.name()).collect()
    }

    /// Whether the rows are those of a ball drive, which has parts and a preload to hold.
    #[getter]
    fn has_pairs(&self) -> bool {
        self.plan.case().drive().is_some()
    }

    /// Whether the drive varies; each row then says whether its drive can be built.
    #[getter]
    fn has_findings(&self) -> bool {
        self.plan.has_findings()
    }

    /// Remarks before the sweep: a range whose steps do not reach its end, or a drive of all rows that cannot be built.
    #[getter]
    fn remarks(&self) -> Vec<String> {
        self.plan.remarks()
    }

    /// The plan as JSON, for the record beside its rows.
    #[getter]
    fn record(&self) -> String {
        format!("{:#}", self.plan.record())
    }

    /// Raises ``PlanError`` with the differences if ``record``, found at ``path``, is the record of another plan.
    fn check_record(&self, py: Python<'_>, path: PathBuf, record: &str) -> PyResult<()> {
        let there = serde_json::from_str(record).map_err(|error| {
            plan_error(py, &format!("{}: is not a record of a sweep: {error}", path.display()))
        })?;
        same_plan(&path, &there, &self.plan.record()).map_err(|failure| sweep_failure(py, &failure))
    }

    /// Raises ``PlanError`` if the plan was read from the file ``path``.
    fn check_output(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        keep_input(&path, self.plan.sources()).map_err(|failure| sweep_failure(py, &failure))
    }

    /// The parts (first row, row after the last) in which a sweep is solved after ``done`` rows: whole blocks of at least
    /// ``chunk_rows`` rows.
    #[pyo3(signature = (done = 0, chunk_rows = None))]
    fn chunks(&self, done: u64, chunk_rows: Option<u64>) -> Vec<(u64, u64)> {
        let chunks = chunks(done, self.plan.rows(), chunk_rows.unwrap_or(CHUNK_ROWS));
        chunks.map(|chunk| (chunk.start, chunk.end)).collect()
    }

    /// The plan reduced to what these rows need; a table keeps only their part.
    fn part(&self, py: Python<'_>, start: u64, stop: u64) -> PyResult<Self> {
        let rows = self.range(py, start, stop)?;
        Ok(Self { plan: Arc::new(self.plan.part(rows)) })
    }

    /// Solves rows of the plan. Ctrl-C stops it.
    ///
    /// Parameters
    /// ----------
    /// start, stop : int
    ///     First row, and the row after the last.
    /// threads : int, optional
    ///     Number of threads; all cores if not given.
    /// progress : callable, optional
    ///     Called from time to time with the number of rows done.
    ///
    /// Returns
    /// -------
    /// tuple
    ///     The columns of the axes (a list), then elastic angle, part of the deceleration pair and part of the equal-speed
    ///     pair (rad), scaled residual, preload to hold (N), index of the finding in ``sweep_findings()`` (empty unless
    ///     ``has_findings``) and index of the status in ``sweep_statuses()``, each of shape (stop - start,); and a list of the
    ///     further ``columns``.
    ///
    /// Raises
    /// ------
    /// PlanError
    ///     For rows that the plan does not have.
    #[pyo3(signature = (start, stop, threads = None, progress = None))]
    fn solve<'py>(
        &self,
        py: Python<'py>,
        start: u64,
        stop: u64,
        threads: Option<usize>,
        progress: Option<Bound<'py, PyAny>>,
    ) -> PyResult<Columns<'py>> {
        let rows = self.range(py, start, stop)?;
        let plan = Arc::clone(&self.plan);
        let work = |progress: &Progress| plan.solve(&rows, progress);
        let Rows {
            axes,
            elastic_angle_rad,
            alpha_deceleration_rad,
            alpha_equal_speed_rad,
            residual,
            hold_preload_N,
            costs,
            finding,
            status,
        } = Self::on_threads(py, threads, progress.as_ref(), work)?;
        Ok((
            axes.into_iter().map(|axis| Column::new(py, axis)).collect(),
            Column::new(py, elastic_angle_rad),
            Column::new(py, alpha_deceleration_rad),
            Column::new(py, alpha_equal_speed_rad),
            Column::new(py, residual),
            Column::new(py, hold_preload_N),
            Column::new(py, finding),
            Column::new(py, status),
            costs.into_iter().map(|cost| Column::new(py, cost)).collect(),
        ))
    }

    /// Why a row, counted from 0, has the status ``invalid_input``: the number that breaks a rule, its value in SI and the
    /// rule; ``None`` if the row has another status.
    fn reason(&self, py: Python<'_>, row: u64) -> PyResult<Option<String>> {
        self.range(py, row, row.saturating_add(1))?;
        Ok(py.detach(|| self.plan.reason(row)).map(|why| why.to_string()))
    }

    /// Why the drive of a row, counted from 0, cannot be built; ``None`` if it can.
    fn finding(&self, py: Python<'_>, row: u64) -> PyResult<Option<String>> {
        self.range(py, row, row.saturating_add(1))?;
        Ok(py.detach(|| self.plan.finding(row)).map(|finding| finding.message))
    }

    /// Solves rows of the plan as ``solve`` does, and writes them as lines of a CSV file. Ctrl-C stops it.
    ///
    /// Parameters
    /// ----------
    /// start, stop : int
    ///     First row, and the row after the last.
    /// threads : int, optional
    ///     Number of threads; all cores if not given.
    /// progress : callable, optional
    ///     Called from time to time with the number of rows done.
    ///
    /// Returns
    /// -------
    /// bytes
    ///     The lines, without the header.
    ///
    /// Raises
    /// ------
    /// PlanError
    ///     For rows that the plan does not have.
    #[pyo3(signature = (start, stop, threads = None, progress = None))]
    fn csv<'py>(
        &self,
        py: Python<'py>,
        start: u64,
        stop: u64,
        threads: Option<usize>,
        progress: Option<Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyBytes>> {
        let rows = self.range(py, start, stop)?;
        let plan = Arc::clone(&self.plan);
        let work = |progress: &Progress| plan.csv(&rows, progress);
        let (lines, _) = Self::on_threads(py, threads, progress.as_ref(), work)?;
        Ok(PyBytes::new(py, &lines))
    }

    /// Makes a plan from the state of ``__reduce__``.
    #[staticmethod]
    #[pyo3(signature = (case, axes: "list[tuple[str, tuple[float, float, bool] | NDArray[float64] | list[str]]]", design, rows, seed, first, columns))]
    #[expect(clippy::too_many_arguments, reason = "the state of a plan, one by one")]
    fn _of(
        py: Python<'_>,
        case: &str,
        axes: Vec<(String, AxisValues<'_>)>,
        design: &str,
        rows: u64,
        seed: u64,
        first: u64,
        columns: Vec<String>,
    ) -> PyResult<Self> {
        let case = RustCase::from_toml(case, "<plan>").map_err(|error| plan_error(py, &error.to_string()))?;
        let drawn = matches!(design, "random" | "latin_hypercube").then_some(rows);
        let whole = Self::new(py, &Case::of(case), axes, design, drawn, seed, columns)?;
        Ok(Self { plan: Arc::new(Arc::unwrap_or_clone(whole.plan).beginning_at(first, rows)) })
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> Reduced<State<'py>> {
        let (py, plan) = (slf.py(), &slf.get().plan);
        let axes = plan.axes().iter();
        let state = (
            plan.case().to_toml(),
            axes.map(|axis| (axis.parameter.name.clone(), given(py, &axis.values))).collect(),
            plan.design().name().to_owned(),
            plan.rows(),
            plan.seed(),
            plan.first(),
            plan.columns().iter().map(|cost| cost.name().to_owned()).collect(),
        );
        Ok((slf.get_type().getattr("_of")?.unbind(), state))
    }

    fn __repr__(&self) -> String {
        format!("SweepPlan({}, {} rows over {})", self.design(), self.rows(), self.names().join(", "))
    }
}

fn given<'py>(py: Python<'py>, values: &Values) -> GivenValues<'py> {
    match values {
        Values::Between { from, to, log } => GivenValues::Between((*from, *to, *log)),
        Values::Numbers(numbers) => GivenValues::Numbers(Column::new(py, numbers.iter().copied())),
        Values::Words(words, places) => {
            GivenValues::Words(places.iter().map(|&place| words[place].clone()).collect())
        }
    }
}

/// Whether a file is a plan of a sweep and not a case; false for a file that cannot be read.
#[pyfunction]
pub fn is_sweep_plan(path: PathBuf) -> bool {
    is_plan(&path)
}

/// Counts how the rows of a sweep ended, with the reasons of those that have the status ``invalid_input``.
#[pyclass(module = "cbpt._core")]
pub struct SweepTally {
    plan: Arc<Plan>,
    tally: Tally,
}

#[pymethods]
impl SweepTally {
    #[new]
    fn new(plan: &SweepPlan) -> Self {
        Self { plan: Arc::clone(&plan.plan), tally: Tally::default() }
    }

    /// Counts rows from row ``start`` on, by the indices of their statuses and findings.
    fn add(&mut self, py: Python<'_>, start: u64, status: Vec<u8>, finding: Vec<u8>) {
        py.detach(|| self.tally.add(&self.plan, start, &status, &finding));
    }

    /// The summary as text; ``None`` if every row has a solution and a drive that can be built.
    fn text(&self) -> Option<String> {
        self.tally.text()
    }
}

/// Names of the statuses of a row, by their codes.
#[pyfunction]
pub fn sweep_statuses() -> Vec<&'static str> {
    STATUSES.to_vec()
}

/// Reasons why the drive of a row cannot be built, by their codes; the first, empty, means that it can.
#[pyfunction]
pub fn sweep_findings() -> Vec<&'static str> {
    [""].into_iter().chain(UNBUILDABLE).collect()
}

/// A CSV file that grows chunk by chunk. A sweep that was interrupted continues where it stopped.
///
/// Raises ``PlanError`` if the file belongs to another plan, if another process writes it or if it was changed since, and
/// ``OSError`` if it cannot be written.
#[pyclass(module = "cbpt._core")]
pub struct SweepCsv {
    output: CsvOutput,
}

#[pymethods]
impl SweepCsv {
    #[new]
    #[pyo3(signature = (plan, path, fresh = false))]
    fn new(py: Python<'_>, plan: &SweepPlan, path: PathBuf, fresh: bool) -> PyResult<Self> {
        let opened = py.detach(|| CsvOutput::open(&plan.plan, &path, fresh));
        opened.map(|output| Self { output }).map_err(|failure| sweep_failure(py, &failure))
    }

    /// Rows that are on disk.
    #[getter]
    fn done(&self) -> u64 {
        self.output.done()
    }

    /// Adds the lines of the next rows, and returns when they are on disk.
    fn append(&mut self, py: Python<'_>, lines: &[u8], rows: u64) -> PyResult<()> {
        let output = &mut self.output;
        let written: Result<(), Failure> = py.detach(|| output.append(lines, rows));
        written.map_err(|failure| sweep_failure(py, &failure))
    }
}
