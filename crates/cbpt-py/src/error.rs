//! Each Rust error to one Python class, all defined in `cbpt.errors`.

use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use pyo3::types::PyType;

/// A number or an argument that cannot be: `cbpt.errors.InvalidInputError`.
pub fn invalid_input(py: Python<'_>, error: &cbpt_core::InvalidInput) -> PyErr {
    raise(py, "InvalidInputError", &error.to_string())
}

/// A mistake in a case file: `cbpt.errors.CaseError`.
pub fn case_error(py: Python<'_>, error: &cbpt_cli::case::CaseError) -> PyErr {
    raise(py, "CaseError", &error.to_string())
}

/// A value that has no place in a case: `cbpt.errors.CaseError`.
pub fn no_case_value(py: Python<'_>, place: &str, found: &str) -> PyErr {
    raise(
        py,
        "CaseError",
        &format!("{place}: found a value of type {found}, expected a number, a text or a section"),
    )
}

fn raise(py: Python<'_>, class: &str, message: &str) -> PyErr {
    let found = py.import("cbpt.errors").and_then(|module| module.getattr(class));
    match found.and_then(|class| Ok(class.cast_into::<PyType>()?)) {
        Ok(class) => PyErr::from_type(class, message.to_owned()),
        Err(_) => PyRuntimeError::new_err(message.to_owned()),
    }
}
