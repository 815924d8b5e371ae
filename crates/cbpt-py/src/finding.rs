//! Findings about a design.

use pyo3::prelude::*;

use crate::Reduced;

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
