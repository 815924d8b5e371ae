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

/// What a plan is made of: case, axes, design, rows, seed, where a part of a table begins.
type State<'py> = (String, Vec<(String, GivenValues<'py>)>, String, u64, u64, u64);

/// Columns of solved rows: of each axis, elastic angle, its two parts, residual, preload to hold, code of the finding,
/// place of the status.
type Columns<'py> = (
    Vec<Column<'py, f64>>,
    Column<'py, f64>,
    Column<'py, f64>,
    Column<'py, f64>,
    Column<'py, f64>,
    Column<'py, f64>,
    Column<'py, u8>,
    Column<'py, u8>,
);

/// A sweep as data: a case, its axes, and how rows are laid over them. Each row is a function of the plan and its number, so
/// any part can be solved anywhere.
///
/// Axes are pairs of a name, which is a key of the case with its section, and values in the unit of that key. ``cbpt.sweep``
/// takes them in a friendlier form.
#[pyclass(frozen, module = "cbpt._core")]
#[derive(Clone)]
pub struct SweepPlan {
    plan: Arc<Plan>,
}

fn told(py: Python<'_>, mistake: &Mistake) -> PyErr {
    plan_error(py, &mistake.to_string())
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
            &format!("rows {start} to {stop} are not among the {} of the plan", self.plan.rows()),
        ))
    }
}

#[pymethods]
impl SweepPlan {
    /// Raises ``PlanError`` that names the axis, what was found and what is allowed.
    #[new]
    #[pyo3(signature = (case, axes: "list[tuple[str, tuple[float, float, bool] | NDArray[float64] | list[str]]]", design = "grid", rows = None, seed = 0))]
    fn new(
        py: Python<'_>,
        case: &Case,
        axes: Vec<(String, AxisValues<'_>)>,
        design: &str,
        rows: Option<u64>,
        seed: u64,
    ) -> PyResult<Self> {
        let plan = make(py, case.rust(), axes, design, rows, seed)?;
        Ok(Self { plan: Arc::new(plan) })
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

    /// What drawn rows are drawn from.
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

    /// The words of each axis; none for one of numbers.
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

    /// After how many rows the value of each axis of a grid changes: the load changes fastest, the drive slowest.
    #[getter]
    fn strides(&self) -> Vec<u64> {
        self.plan.strides().to_vec()
    }

    /// Whether the rows are those of a ball drive, which has parts and a preload to hold.
    #[getter]
    fn has_pairs(&self) -> bool {
        self.plan.case().drive().is_some()
    }

    /// Whether the drive varies, so that each row tells whether its own can be built.
    #[getter]
    fn has_findings(&self) -> bool {
        self.plan.has_findings()
    }

    /// What to know before: a range whose steps do not meet its end, or that the one drive of all rows cannot be built.
    #[getter]
    fn remarks(&self) -> Vec<String> {
        self.plan.remarks()
    }

    /// What the plan is, as JSON, to be kept beside its rows.
    #[getter]
    fn record(&self) -> String {
        format!("{:#}", self.plan.record())
    }

    /// Raises ``PlanError`` that says what differs where a record found at ``path`` is that of another plan.
    fn check_record(&self, py: Python<'_>, path: PathBuf, record: &str) -> PyResult<()> {
        let there = serde_json::from_str(record)
            .map_err(|error| plan_error(py, &format!("{}: no record of a sweep: {error}", path.display())))?;
        same_plan(&path, &there, &self.plan.record()).map_err(|failure| sweep_failure(py, &failure))
    }

    /// Raises ``PlanError`` where a file is one that the plan was read from.
    fn check_output(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        keep_input(&path, self.plan.sources()).map_err(|failure| sweep_failure(py, &failure))
    }

    /// The parts, from a row on, in which a sweep is solved: whole blocks, at least so many rows each.
    #[pyo3(signature = (done = 0, chunk_rows = None))]
    fn chunks(&self, done: u64, chunk_rows: Option<u64>) -> Vec<(u64, u64)> {
        let chunks = chunks(done, self.plan.rows(), chunk_rows.unwrap_or(CHUNK_ROWS));
        chunks.map(|chunk| (chunk.start, chunk.end)).collect()
    }

    /// The plan as far as these rows need it: of a table only their part.
    fn part(&self, py: Python<'_>, start: u64, stop: u64) -> PyResult<Self> {
        let rows = self.range(py, start, stop)?;
        Ok(Self { plan: Arc::new(self.plan.part(rows)) })
    }

    /// Solves rows, on all cores or on so many threads of their own: the columns of the axes, then elastic angle, part of the
    /// deceleration pair, part of the equal-speed pair (rad), residual, preload to hold (N), the place of the finding in
    /// ``sweep_findings()`` (empty unless ``has_findings``) and that of the status in ``sweep_statuses()``. Ctrl-C stops it; ``progress``, where given, is called now and then with the rows done.
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
        ))
    }

    /// Why the numbers of a row, counted from 0, cannot be together (``invalid_input``): the one that cannot be, its value in
    /// SI and the rule; ``None`` where they can.
    fn reason(&self, py: Python<'_>, row: u64) -> PyResult<Option<String>> {
        self.range(py, row, row.saturating_add(1))?;
        Ok(py.detach(|| self.plan.reason(row)).map(|why| why.to_string()))
    }

    /// Why the drive of a row, counted from 0, cannot be built; ``None`` where it can.
    fn finding(&self, py: Python<'_>, row: u64) -> PyResult<Option<String>> {
        self.range(py, row, row.saturating_add(1))?;
        Ok(py.detach(|| self.plan.finding(row)).map(|finding| finding.message))
    }

    /// Solves rows as ``solve`` does and returns them as lines of a CSV file.
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

    /// Makes a plan of what ``__reduce__`` keeps.
    #[staticmethod]
    #[pyo3(signature = (case, axes: "list[tuple[str, tuple[float, float, bool] | NDArray[float64] | list[str]]]", design, rows, seed, first))]
    fn _of(
        py: Python<'_>,
        case: &str,
        axes: Vec<(String, AxisValues<'_>)>,
        design: &str,
        rows: u64,
        seed: u64,
        first: u64,
    ) -> PyResult<Self> {
        let case = RustCase::from_toml(case, "<plan>").map_err(|error| plan_error(py, &error.to_string()))?;
        let drawn = matches!(design, "random" | "latin_hypercube").then_some(rows);
        let plan = make(py, &case, axes, design, drawn, seed)?;
        Ok(Self { plan: Arc::new(plan.beginning_at(first, rows)) })
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
        );
        Ok((slf.get_type().getattr("_of")?.unbind(), state))
    }

    fn __repr__(&self) -> String {
        format!("SweepPlan({}, {} rows over {})", self.design(), self.rows(), self.names().join(", "))
    }
}

fn make(
    py: Python<'_>,
    case: &RustCase,
    axes: Vec<(String, AxisValues<'_>)>,
    design: &str,
    rows: Option<u64>,
    seed: u64,
) -> PyResult<Plan> {
    let names: Vec<&str> = Design::ALL.iter().map(|(name, _)| *name).collect();
    let Some((_, design)) = Design::ALL.iter().find(|(name, _)| *name == design) else {
        return Err(plan_error(py, &format!("design = {design:?}: expected one of {}", names.join(", "))));
    };
    let axes: Result<Vec<Axis>, Mistake> =
        axes.into_iter().map(|(name, values)| Axis::new(case, &name, values.into())).collect();
    axes.and_then(|axes| Plan::new(case.clone(), axes, *design, rows, seed))
        .map_err(|mistake| told(py, &mistake))
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

/// Whether a file is a plan of a sweep rather than a case; one that cannot be read is none.
#[pyfunction]
pub fn is_sweep_plan(path: PathBuf) -> bool {
    is_plan(&path)
}

/// How rows of a sweep ended, counted, with the reasons of those whose numbers cannot be together.
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

    /// Counts rows, the first of which is ``start``, by the places of their statuses and findings.
    fn add(&mut self, py: Python<'_>, start: u64, status: Vec<u8>, finding: Vec<u8>) {
        py.detach(|| self.tally.add(&self.plan, start, &status, &finding));
    }

    /// Some lines of text; ``None`` where every row has its numbers and a drive that can be built.
    fn text(&self) -> Option<String> {
        self.tally.text()
    }
}

/// Names of how a row can end, by their codes.
#[pyfunction]
pub fn sweep_statuses() -> Vec<&'static str> {
    STATUSES.to_vec()
}

/// Why the drive of a row cannot be built, by its code; the first, empty, says that it can.
#[pyfunction]
pub fn sweep_findings() -> Vec<&'static str> {
    [""].into_iter().chain(UNBUILDABLE).collect()
}

/// A CSV file that grows chunk by chunk and is taken up again after a kill at any moment.
///
/// Raises ``PlanError`` for an output of another plan, one that another process writes or that was changed since, and
/// ``OSError`` where it cannot be written.
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
