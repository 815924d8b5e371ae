//! Python extension module `cbpt._core`: conversions only; a formula here is a defect.
//!
//! - `error`: each Rust error to one Python class; `threads`: work without the GIL, after a fork too; `interrupt`: the same
//!   for long calls that mind Ctrl-C;
//! - `arrays`: numpy arrays with their element type;
//! - `given`: what Python hands over as a case; `solution`: a solved load; `preload`: thresholds; `friction`: losses; `finding`: findings about a
//!   design; `sensitivity`: how results answer to its numbers; `drive`: what asks for these; `case`: case files;
//! - `angles`, `friction_loads`: many loads; `design`: many designs;
//! - `sweep`: plans of sweeps, their rows and files;
//! - `turn`: what each ball carries;
//! - `covariance`: the search for a noise; `posterior`: that for the most probable values under it; `bounded`: the step of a linear problem within bounds;
//! - `units`: the table of units;
//! - `effects`: the library of effects, and a drive with effects on a table of readings.

// The macros of pyo3 write the unsafe code that an extension module needs.
#![allow(unsafe_code)]
// pyo3 takes arguments by value and returns `PyResult` by its conventions.
#![allow(clippy::needless_pass_by_value, clippy::unnecessary_wraps)]

mod angles;
mod arrays;
mod bounded;
mod case;
mod covariance;
mod design;
mod drive;
mod effects;
mod error;
mod finding;
mod friction;
mod friction_loads;
mod given;
mod interrupt;
mod own;
mod posterior;
mod preload;
mod sensitivity;
mod solution;
mod sweep;
mod threads;
mod turn;
mod units;

use pyo3::prelude::*;
use serde_json::Value;

/// What `__reduce__` returns: a callable and its arguments.
type Reduced<T> = PyResult<(Py<PyAny>, T)>;

/// Mechanics of a cycloid ball planetary transmission, compiled.
#[pymodule]
mod _core {
    #[pymodule_export]
    use super::angles::solve_angles;
    #[pymodule_export]
    use super::bounded::{held_at_bounds, quadratic_step};
    #[pymodule_export]
    use super::case::{Case, Effect};
    #[pymodule_export]
    use super::covariance::{NoisePolynomials, log_scale_prior, noise_products, search_noise, take_out};
    #[pymodule_export]
    use super::design::{design_number, design_numbers, judge_designs};
    #[pymodule_export]
    use super::drive::Drive;
    #[pymodule_export]
    use super::effects::{EffectParameter, EffectSpec, Prediction, Predictor, effect_specs};
    #[pymodule_export]
    use super::finding::Finding;
    #[pymodule_export]
    use super::friction::{Friction, FrictionContact, PairFriction};
    #[pymodule_export]
    use super::friction_loads::friction_of_loads;
    #[pymodule_export]
    use super::own::{OwnEffect, own_effect_variables};
    #[pymodule_export]
    use super::posterior::{Misfit, NoiseFilter, Seen, Whitener};
    #[pymodule_export]
    use super::preload::{PreloadThresholds, Thresholds};
    #[pymodule_export]
    use super::sensitivity::{Sensitivities, Sensitivity};
    #[pymodule_export]
    use super::solution::{Enclosure, LargestAngle, PairSolution, Solution};
    #[pymodule_export]
    use super::sweep::{SweepCsv, SweepPlan, SweepTally, is_sweep_plan, sweep_findings, sweep_statuses};
    #[pymodule_export]
    use super::turn::ball_loads;
    #[pymodule_export]
    use super::units::{Unit, all_units, unit_size};
    #[pymodule_export]
    use super::{example_case, painted, run_command_line, terminal_colour, terminal_width, text_table};
}

/// The example case file: the base case of the 2017 paper, as TOML text.
#[pyfunction]
fn example_case() -> &'static str {
    cbpt_cli::commands::schema::EXAMPLE
}

/// Runs the Rust verbs of the command line (program name first) and returns the exit code.
#[pyfunction]
fn run_command_line(py: Python<'_>, arguments: Vec<String>) -> PyResult<u8> {
    threads::detached(py, || cbpt_cli::run(arguments.into_iter().map(Into::into)))
}

/// A cell of a text table; ``None`` is drawn as a dash.
#[derive(FromPyObject)]
enum Cell {
    Flag(bool),
    Whole(i64),
    Real(f64),
    Text(String),
}

/// A text table as the command line draws it.
///
/// ``columns`` are the column names; each row has a cell for each column. Numbers are shown to six significant digits;
/// ``None`` and numbers that are not finite are shown as ``-``.
/// The table is as wide as the terminal at most, 100 characters in a file; ``width`` says otherwise.
#[pyfunction]
#[pyo3(signature = (columns, rows, width = None))]
fn text_table(columns: Vec<String>, rows: Vec<Vec<Option<Cell>>>, width: Option<u16>) -> String {
    let value = |cell: Option<Cell>| match cell {
        None => Value::Null,
        Some(Cell::Flag(flag)) => flag.into(),
        Some(Cell::Whole(number)) => number.into(),
        Some(Cell::Real(number)) => number.into(),
        Some(Cell::Text(text)) => text.into(),
    };
    let rows = rows.into_iter().map(|row| row.into_iter().map(value).collect()).collect();
    let width = width.unwrap_or_else(cbpt_cli::terminal::width);
    cbpt_cli::report::Table { columns, rows }.text_within(width)
}

/// Columns that text on standard output may take.
#[pyfunction]
fn terminal_width() -> u16 {
    cbpt_cli::terminal::width()
}

/// Whether standard output, or standard error, shows colours: a terminal that can, and ``NO_COLOR`` is not set.
#[pyfunction]
fn terminal_colour(error: bool) -> bool {
    cbpt_cli::terminal::colour(error)
}

/// A text with the colours of the command line.
#[pyfunction]
fn painted(text: &str) -> String {
    cbpt_cli::terminal::painted(text)
}
