//! Description of an effect and of its parameters. The case file, Python, the page and the documentation use it.

use super::port::Action;
use crate::units::{Quantity, Unit};

/// One effect of the library.
#[derive(Debug)]
pub struct Spec {
    /// Its fixed id.
    pub id: &'static str,
    /// What kind of cause it is.
    pub class: Class,
    /// Where it acts.
    pub port: Port,
    /// Which reducers can have it.
    pub reducers: Reducers,
    /// Its equation, in the symbols of the theory page.
    pub equation: &'static str,
    /// Where the equation comes from.
    pub source: &'static str,
    /// How it shows in readings.
    pub tell_tale: &'static str,
    /// Its parameters.
    pub parameters: &'static [Parameter],
    /// Ids of effects that no torque-angle data can tell from this one when the contact stiffness is fitted as well. Sizes
    /// that are [`Parameter::twinless`] are an exception.
    pub twins: &'static [&'static str],
    /// What it does.
    pub action: Action,
}

impl Spec {
    /// Whether a torsion spring has it, with a reference radius or without.
    pub fn suits_springs(&self, with_radius: bool) -> bool {
        match self.reducers {
            Reducers::All | Reducers::TorsionSprings => true,
            Reducers::AllByRadius => with_radius,
            Reducers::BallDrives => false,
        }
    }

    /// Whether a ball drive has it.
    pub fn suits_ball_drives(&self) -> bool {
        self.reducers != Reducers::TorsionSprings
    }
}

/// Which reducers can have an effect.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Reducers {
    /// Any: it needs neither balls nor what the preload does to them.
    All,
    /// Any with a radius: its sizes are lengths, which turn the output by the length over it.
    AllByRadius,
    /// Ball drives alone.
    BallDrives,
    /// Torsion springs alone: a ball drive's contacts take up their play by themselves.
    TorsionSprings,
}

/// What kind of cause an effect is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Class {
    /// A number of the drive differs from the stated one.
    Parameter,
    /// The rig or its instruments.
    Rig,
    /// Physics that the nominal model leaves out.
    Effect,
}

impl Class {
    /// `parameter`, `rig` or `effect`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Parameter => "parameter",
            Self::Rig => "rig",
            Self::Effect => "effect",
        }
    }
}

/// Where an effect acts, in the order in which they are switched on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Port {
    /// On the torque and preload that reach the meshing points.
    Load,
    /// On the gaps at the balls.
    Gap,
    /// On stiffness, angle or law of the contacts.
    Contact,
    /// An angle behind the meshing points.
    Series,
    /// What the instruments make of angle, torque and preload.
    Reading,
}

impl Port {
    /// `load`, `gap`, `contact`, `series` or `reading`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Load => "load",
            Self::Gap => "gap",
            Self::Contact => "contact",
            Self::Series => "series",
            Self::Reading => "reading",
        }
    }
}

/// How a parameter is spread over its range.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scale {
    /// Evenly.
    Linear,
    /// Evenly in its logarithm.
    Log,
    /// It is a whole number that is chosen, not fitted.
    Fixed,
}

/// A number of an effect, in SI.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Parameter {
    /// Name without its unit.
    pub stem: &'static str,
    /// What it measures.
    pub quantity: Quantity,
    /// Symbol of the unit that people read, where it is not the usual one of the quantity.
    pub(super) shown: Option<&'static str>,
    /// What it is.
    pub meaning: &'static str,
    /// Value at which a size has no effect; for any other parameter its default.
    pub neutral: f64,
    /// Least value that has a meaning.
    pub lower: f64,
    /// Greatest value that has a meaning.
    pub upper: f64,
    /// Plausible values, as a prior.
    pub range: (f64, f64),
    /// How it is spread over them.
    pub scale: Scale,
    /// Whether it is a size: an effect vanishes if all its sizes are neutral.
    pub is_size: bool,
    /// Whether it tells an effect from its twins wherever it is not neutral.
    pub twinless: bool,
}

impl Parameter {
    /// A size: the effect is gone where it is 0.
    pub(super) const fn size(stem: &'static str, quantity: Quantity, meaning: &'static str) -> Self {
        Self {
            stem,
            quantity,
            shown: None,
            meaning,
            neutral: 0.0,
            lower: f64::NEG_INFINITY,
            upper: f64::INFINITY,
            range: (f64::NEG_INFINITY, f64::INFINITY),
            scale: Scale::Linear,
            is_size: true,
            twinless: false,
        }
    }

    /// A gain: a size that is gone at 1, spread in its logarithm.
    pub(super) const fn gain(stem: &'static str, meaning: &'static str) -> Self {
        Self { neutral: 1.0, scale: Scale::Log, ..Self::size(stem, Quantity::Number, meaning) }
    }

    /// A shape: it says how the effect acts, not how much.
    pub(super) const fn shape(
        stem: &'static str,
        quantity: Quantity,
        default: f64,
        meaning: &'static str,
    ) -> Self {
        Self { neutral: default, is_size: false, ..Self::size(stem, quantity, meaning) }
    }

    /// A whole number that is chosen, not fitted.
    pub(super) const fn chosen(stem: &'static str, default: f64, meaning: &'static str) -> Self {
        Self { scale: Scale::Fixed, ..Self::shape(stem, Quantity::Number, default, meaning) }
    }

    /// Values that have a meaning.
    pub(super) const fn within(self, lower: f64, upper: f64) -> Self {
        Self { lower, upper, ..self }
    }

    /// Values that are plausible.
    pub(super) const fn likely(self, low: f64, high: f64) -> Self {
        Self { range: (low, high), ..self }
    }

    /// Spread in the logarithm.
    pub(super) const fn log(self) -> Self {
        Self { scale: Scale::Log, ..self }
    }

    /// A size that no other effect can stand in for, though the rest of its effect has twins.
    pub(super) const fn without_twin(self) -> Self {
        Self { twinless: true, ..self }
    }

    /// Shown in another unit of its quantity.
    pub(super) const fn shown(self, symbol: &'static str) -> Self {
        Self { shown: Some(symbol), ..self }
    }

    /// The unit that people read.
    pub fn display(&self) -> &'static Unit {
        self.shown.and_then(|symbol| self.quantity.unit(symbol)).unwrap_or(self.quantity.usual())
    }

    /// Name with the SI unit, as in `reference_deflection_m`.
    pub fn name(&self) -> String {
        self.quantity.si().name(self.stem)
    }

    /// Name with the unit that people read, as in `reference_deflection_um`.
    pub fn display_name(&self) -> String {
        self.display().name(self.stem)
    }
}
