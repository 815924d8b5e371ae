//! What Python hands over as a case: a path, a text, or a dict, which becomes JSON for the parser of case files.

use std::path::PathBuf;

use cbpt_cli::case::Case;
use pyo3::exceptions::PyUnicodeError;
use pyo3::inspect::PyStaticExpr;
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict, PyFloat, PyInt, PyList, PyString, PyTuple};
use serde_json::{Number, Value};

use crate::error::{case_error, half_a_character, no_case_key, no_case_path, no_case_value, too_much};

/// The path of a case file; one that no file can have is a mistake in the case and no fault of the codec.
pub struct CasePath(pub PathBuf);

impl<'a, 'py> FromPyObject<'a, 'py> for CasePath {
    type Error = PyErr;

    const INPUT_TYPE: PyStaticExpr = <PathBuf as FromPyObject<'a, 'py>>::INPUT_TYPE;

    fn extract(object: Borrowed<'a, 'py, PyAny>) -> PyResult<Self> {
        let py = object.py();
        object.extract().map(Self).map_err(|error: PyErr| {
            if error.is_instance_of::<PyUnicodeError>(py) { no_case_path(&object) } else { error }
        })
    }
}

/// The case of a file.
pub fn case_from_file(py: Python<'_>, path: &CasePath) -> PyResult<Case> {
    py.detach(|| Case::read(&path.0)).map_err(|error| case_error(py, &error))
}

/// The case of a TOML text.
pub fn case_from_toml(text: &Bound<'_, PyString>, name: &str) -> PyResult<Case> {
    let py = text.py();
    // A text of Python may hold halves of characters, which no file in UTF-8 does.
    let whole = text.to_cow().map_err(|error| half_a_character(text, name, error))?;
    py.detach(|| Case::from_toml(&whole, name)).map_err(|error| case_error(py, &error))
}

/// The case of a dict with the sections and keys of a case file.
pub fn case_from_dict(py: Python<'_>, case: &Bound<'_, PyDict>) -> PyResult<Case> {
    let value = json_of(case.as_any())?;
    py.detach(|| Case::from_json(&value)).map_err(|error| case_error(py, &error))
}

/// A Python value as JSON, for the parser of case files.
pub fn json_of(value: &Bound<'_, PyAny>) -> PyResult<Value> {
    Reading { left: MOST_VALUES }.json(value, "", DEEPEST)
}

/// Dicts and lists deeper than this are in no case.
const DEEPEST: usize = 8;

/// More values than this are in no case; a list may hold one list many times over.
const MOST_VALUES: usize = 100_000;

/// A Python value on its way to JSON.
struct Reading {
    /// Values that may still come.
    left: usize,
}

impl Reading {
    /// A Python value as JSON; `place` is its dotted key, `depth` how much deeper it may go.
    fn json(&mut self, value: &Bound<'_, PyAny>, place: &str, depth: usize) -> PyResult<Value> {
        let py = value.py();
        let inside = |key: &str| if place.is_empty() { key.to_owned() } else { format!("{place}.{key}") };
        self.left = self.left.checked_sub(1).ok_or_else(|| too_much(py, place, "values", MOST_VALUES))?;
        let deeper = || depth.checked_sub(1).ok_or_else(|| too_much(py, place, "levels", DEEPEST));
        if value.is_none() {
            Ok(Value::Null)
        } else if let Some(plain) = plain_json(value) {
            Ok(plain)
        } else if let Ok(text) = value.cast::<PyString>() {
            Ok(Value::String(text.to_string_lossy().into_owned()))
        } else if let Ok(entries) = value.cast::<PyDict>() {
            let depth = deeper()?;
            let mut object = serde_json::Map::new();
            // Of a copy, which no code of the values can change.
            for (key, entry) in entries.copy()? {
                let Ok(key) = key.cast::<PyString>() else { return Err(no_case_key(place, &key)) };
                let key = key.to_string_lossy();
                object.insert(key.to_string(), self.json(&entry, &inside(&key), depth)?);
            }
            Ok(Value::Object(object))
        } else if let Some(items) = sequence(value) {
            let depth = deeper()?;
            let items = items.iter().enumerate();
            items.map(|(index, item)| self.json(&item, &inside(&index.to_string()), depth)).collect()
        } else {
            // A scalar of numpy holds one of these.
            let item = value.call_method0("item").ok();
            item.as_ref().and_then(plain_json).ok_or_else(|| no_case_value(place, value))
        }
    }
}

/// A list or a tuple as it is now.
fn sequence<'py>(value: &Bound<'py, PyAny>) -> Option<Bound<'py, PyTuple>> {
    let list = value.cast::<PyList>().map(PyListMethods::to_tuple);
    list.ok().or_else(|| value.cast::<PyTuple>().ok().cloned())
}

/// A truth value or a number as JSON. What is no finite number becomes a text, so that the case's own message names its
/// place.
fn plain_json(value: &Bound<'_, PyAny>) -> Option<Value> {
    if let Ok(flag) = value.cast::<PyBool>() {
        return Some(Value::Bool(flag.is_true()));
    }
    let whole = value.is_instance_of::<PyInt>();
    if !whole && !value.is_instance_of::<PyFloat>() {
        return None;
    }
    if let Some(number) = value.extract::<i64>().ok().filter(|_| whole) {
        return Some(Value::from(number));
    }
    // The text of a long integer may be refused by Python itself.
    let number = value.extract::<f64>();
    let text = number.as_ref().map_or("a number beyond all range".into(), f64::to_string);
    Some(number.ok().and_then(Number::from_f64).map_or(Value::String(text), Value::Number))
}
