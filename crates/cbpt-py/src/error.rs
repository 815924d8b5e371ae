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

/// A case with effects, asked for what its drive alone would do: `cbpt.errors.CaseError`.
pub fn effect_not_computed(py: Python<'_>, id: &str) -> PyErr {
    let message = format!(
        "the case has the effect `{id}`, which this version reads but cannot compute yet; remove its [[effect]] to compute \
         the bare drive"
    );
    raise(py, "CaseError", &message)
}

/// A torque without a preload or the reverse: `cbpt.errors.InvalidInputError`.
pub fn half_a_load(py: Python<'_>) -> PyErr {
    raise(py, "InvalidInputError", "a load to check needs both torque_Nm and preload_N")
}

fn raise(py: Python<'_>, class: &str, message: &str) -> PyErr {
    let found = py.import("cbpt.errors").and_then(|module| module.getattr(class));
    match found.and_then(|class| Ok(class.cast_into::<PyType>()?)) {
        Ok(class) => PyErr::from_type(class, message.to_owned()),
        Err(_) => PyRuntimeError::new_err(message.to_owned()),
    }
}
