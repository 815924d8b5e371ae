//! Each Rust error to one Python class, all defined in `cbpt.errors`.

use cbpt_cli::case::Mistake;
use cbpt_cli::exit::Failure;
use pyo3::call::PyCallArgs;
use pyo3::exceptions::PyOSError;
use pyo3::prelude::*;
use pyo3::types::{PyString, PyTuple};

/// A number or an argument that cannot be: `cbpt.errors.InvalidInputError`.
pub fn invalid_input(py: Python<'_>, error: &cbpt_core::InvalidInput) -> PyErr {
    let fields = (error.to_string(), &error.field, &error.found, &error.required);
    raise(py, "InvalidInputError", fields)
}

/// A matrix that has to be positive and is not: `numpy.linalg.LinAlgError`.
pub fn not_positive(py: Python<'_>) -> PyErr {
    let class = py.import("numpy.linalg").and_then(|module| module.getattr("LinAlgError"));
    match class.and_then(|class| class.call1(("the matrix is not positive",))) {
        Ok(error) => PyErr::from_value(error),
        Err(error) => error,
    }
}

/// A mistake in a case file: `cbpt.errors.CaseError`.
pub fn case_error(py: Python<'_>, error: &cbpt_cli::case::CaseError) -> PyErr {
    case_mistakes(py, [error.to_string(), error.shown()], &error.mistakes)
}

/// The mistakes as `cbpt.errors.CaseMistake`, the message in words, and the same with the lines of the file.
fn case_mistakes(py: Python<'_>, [message, shown]: [String; 2], mistakes: &[Mistake]) -> PyErr {
    let handed = || {
        let class = py.import("cbpt.errors")?.getattr("CaseMistake")?;
        let hand = |m: &Mistake| {
            let place = (m.line, m.column, m.character);
            class.call1((&m.key, &m.found, &m.problem, &m.allowed, &m.nearest, place, m.words()))
        };
        PyTuple::new(py, mistakes.iter().map(hand).collect::<PyResult<Vec<_>>>()?)
    };
    match handed() {
        Ok(mistakes) => raise(py, "CaseError", (message, mistakes, shown)),
        Err(error) => error,
    }
}

/// One mistake in what is not a file.
fn case_mistake(py: Python<'_>, key: &str, problem: String) -> PyErr {
    let mistake = Mistake { key: key.into(), problem, ..Mistake::default() };
    case_mistakes(py, [mistake.to_string(), String::new()], &[mistake])
}

/// A value that has no place in a case: `cbpt.errors.CaseError`.
pub fn no_case_value(place: &str, value: &Bound<'_, PyAny>) -> PyErr {
    let found = type_name(value);
    let problem = format!("found a value of type {found}, expected a number, a text or a section");
    case_mistake(value.py(), place, problem)
}

/// A key that has no place in a case: `cbpt.errors.CaseError`.
pub fn no_case_key(place: &str, key: &Bound<'_, PyAny>) -> PyErr {
    let (section, found) = (if place.is_empty() { "the case" } else { place }, type_name(key));
    case_mistake(key.py(), section, format!("found a key of type {found}, expected a text"))
}

/// A path with a lone surrogate in it: `cbpt.errors.CaseError`.
pub fn no_case_path(path: &Bound<'_, PyAny>) -> PyErr {
    let shown = path.repr().map_or_else(|_| "the path".into(), |text| text.to_string_lossy().into_owned());
    case_mistake(path.py(), &shown, "no file can have this name; check the path".into())
}

/// A value that is in itself, or as good as: `cbpt.errors.CaseError`.
pub fn too_much(py: Python<'_>, place: &str, what: &str, most: usize) -> PyErr {
    let problem = format!("found more than {most} {what}, expected the sections and keys of a case file");
    case_mistake(py, place, problem)
}

/// A case as text with a lone surrogate in it: `cbpt.errors.CaseError`.
pub fn half_a_character(text: &Bound<'_, PyString>, name: &str, error: PyErr) -> PyErr {
    let py = text.py();
    let lines_before = |at| text.call_method1("count", ("\n", 0, at))?.extract::<usize>();
    let line = error.value(py).getattr("start").and_then(lines_before);
    let place = line.map_or(name.to_owned(), |before| format!("{name}:{}", before + 1));
    case_mistake(py, &place, "found a lone surrogate, half a character; remove it".into())
}

fn type_name(value: &Bound<'_, PyAny>) -> String {
    value.get_type().name().map_or_else(|_| "unknown".into(), |name| name.to_string_lossy().into_owned())
}

/// A case with effects where a drive alone is asked for: `cbpt.errors.CaseError`.
pub fn drive_with_effect(py: Python<'_>, id: &str) -> PyErr {
    let message = format!(
        "the case has the effect `{id}`, which a Drive cannot hold; read it as a Case, whose .drive is the drive without effects"
    );
    raise(py, "CaseError", (message,))
}

/// A question about balls and grooves put to a torsion spring: `cbpt.errors.InvalidInputError`.
pub fn about_ball_drives(py: Python<'_>, asked: &str) -> PyErr {
    let message =
        format!("{asked} is about the balls and grooves of a ball drive; this one is a torsion spring");
    raise(py, "InvalidInputError", (message,))
}

/// A torque without a preload or the reverse: `cbpt.errors.InvalidInputError`.
pub fn half_a_load(py: Python<'_>) -> PyErr {
    raise(py, "InvalidInputError", ("a load to check needs both torque_Nm and preload_N",))
}

/// A plan that cannot be read or carried out: `cbpt.errors.PlanError`.
pub fn plan_error(py: Python<'_>, message: &str) -> PyErr {
    raise(py, "PlanError", (message.to_owned(),))
}

/// What stops a sweep: a file that cannot be written is an `OSError`, all else a `PlanError`.
pub fn sweep_failure(py: Python<'_>, failure: &Failure) -> PyErr {
    match failure {
        Failure::Write { path, error } => {
            // What the system has no number for is an error of input and output to Python (EIO).
            let (number, reason) = (error.raw_os_error().unwrap_or(5), error.to_string());
            let reason = reason.split(" (os error").next().unwrap_or_default().to_owned();
            PyOSError::new_err((number, reason, path.clone().into_os_string()))
        }
        other => plan_error(py, &other.to_string()),
    }
}

/// An error of `cbpt.errors` by the name of its class and the arguments of its constructor: first the message.
pub fn raise<'py>(py: Python<'py>, class: &str, arguments: impl PyCallArgs<'py>) -> PyErr {
    let class = py.import("cbpt.errors").and_then(|module| module.getattr(class));
    class.and_then(|class| class.call1(arguments)).map_or_else(|error| error, PyErr::from_value)
}
