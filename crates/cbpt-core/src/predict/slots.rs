//! Effects of both kinds, those of the library and the user's own, and the numbers that they have.

use std::sync::Arc;

use crate::effect::own::{OwnEffect, OwnParameter};
use crate::effect::port::Action;
use crate::effect::{self, Parameter, Port, Scale, Spec};
use crate::error::InvalidInput;

/// An effect of a predictor.
#[derive(Debug, Clone)]
pub enum Effect {
    /// One of the library.
    Library(&'static Spec),
    /// One of the user's own.
    Own(Arc<dyn OwnEffect>),
}

impl Effect {
    /// Its id.
    pub fn id(&self) -> &str {
        match self {
            Self::Library(spec) => spec.id,
            Self::Own(own) => own.id(),
        }
    }

    pub(super) fn port(&self) -> Port {
        match self {
            Self::Library(spec) => spec.port,
            Self::Own(own) => own.adds_to().port(),
        }
    }

    pub(super) fn action(&self) -> Option<Action> {
        match self {
            Self::Library(spec) => Some(spec.action),
            Self::Own(_) => None,
        }
    }

    pub(super) fn numbers(&self) -> Vec<Number> {
        match self {
            Self::Library(spec) => spec.parameters.iter().map(Number::Library).collect(),
            Self::Own(own) => own.parameters().iter().cloned().map(Number::Own).collect(),
        }
    }
}

/// A parameter of an effect.
#[derive(Debug, Clone)]
pub enum Number {
    /// Of an effect of the library.
    Library(&'static Parameter),
    /// Of an effect of the user's own.
    Own(OwnParameter),
}

impl Number {
    /// Its name; in the library's with the SI unit.
    pub fn name(&self) -> String {
        match self {
            Self::Library(parameter) => parameter.name(),
            Self::Own(parameter) => parameter.name.clone(),
        }
    }

    /// Where a size of the library vanishes, and the default of another parameter; an own one has its start.
    pub fn neutral(&self) -> f64 {
        match self {
            Self::Library(parameter) => parameter.neutral,
            Self::Own(parameter) => parameter.start,
        }
    }

    /// Least and greatest value that is allowed.
    pub fn limits(&self) -> (f64, f64) {
        match self {
            Self::Library(parameter) => (parameter.lower, parameter.upper),
            Self::Own(parameter) => parameter.limits(),
        }
    }

    /// Whether it is a size of an effect of the library: the effect vanishes where all of them are neutral.
    pub fn is_size(&self) -> bool {
        matches!(self, Self::Library(parameter) if parameter.is_size)
    }

    /// How it is spread over its range.
    pub fn scale(&self) -> Scale {
        match self {
            Self::Library(parameter) => parameter.scale,
            Self::Own(_) => Scale::Linear,
        }
    }
}

/// A number of one effect of a predictor.
#[derive(Debug, Clone)]
pub struct Slot {
    /// Which of the predictor's effects.
    pub effect: usize,
    /// The parameter.
    pub parameter: Number,
}

/// The effect of the library of an id, the one at a place of a list.
///
/// # Errors
/// [`InvalidInput`] lists the ids that there are.
pub fn known(place: usize, id: &str) -> Result<&'static Spec, InvalidInput> {
    effect::find(id).ok_or_else(|| {
        let ids: Vec<&str> = effect::LIBRARY.iter().map(|spec| spec.id).collect();
        InvalidInput::new(format!("effects[{place}]"), id, format!("must be one of {}", ids.join(", ")))
    })
}
