//! Bad input, and nothing else: which field, what was found, what is required.
//!
//! A load that no preload state can carry is not bad input; it is a [`crate::Status`] of a solution.

use std::fmt::Display;

/// A number of the drive or of the load that cannot be: names the field, the value and the rule.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{field} = {found}: {required}")]
pub struct InvalidInput {
    /// Name of the field with its unit, for example `deceleration.ball_radius_m`.
    pub field: String,
    /// The value that was found, as text.
    pub found: String,
    /// What is required, in a sentence.
    pub required: String,
}

impl InvalidInput {
    /// Names the field, the value found and what is required instead.
    pub fn new(field: impl Into<String>, found: impl Display, required: impl Into<String>) -> Self {
        Self { field: field.into(), found: found.to_string(), required: required.into() }
    }
}

/// A number must be finite and greater than zero.
pub(crate) fn require_positive(field: impl Display, value: f64) -> Result<(), InvalidInput> {
    require(value.is_finite() && value > 0.0, field, value, "must be a finite number greater than 0")
}

/// States a rule for one field, whose name is put together only where it is broken.
pub(crate) fn require(
    holds: bool,
    field: impl Display,
    value: impl Display,
    rule: &str,
) -> Result<(), InvalidInput> {
    if holds { Ok(()) } else { Err(InvalidInput::new(field.to_string(), value, rule)) }
}
