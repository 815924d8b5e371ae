//! What a section and a key of a case file are: their kinds, units and ranges, how they are written and named in messages.

use std::borrow::Cow;
use std::ops::Bound::{self, Excluded, Included, Unbounded};
use std::ops::RangeBounds;

use cbpt_core::units::{Quantity, Unit};

/// A table of the file. The keys above the first section stand in the section without a name.
pub(super) struct Section {
    pub(super) name: &'static str,
    pub(super) required: bool,
    /// Whether the mechanics check its numbers; the parser checks those of the other sections.
    pub(super) mechanics: bool,
    pub(super) meaning: &'static str,
    pub(super) keys: Vec<Key>,
}

/// A key of a section.
#[derive(Debug, Clone)]
pub(super) struct Key {
    /// The key without its unit.
    pub(super) stem: Cow<'static, str>,
    pub(super) kind: Kind,
    pub(super) need: Need,
    /// Numbers that are allowed, in SI.
    pub(super) range: Range,
    /// A value that stands in where the one in the file cannot be used, so that the rest is still checked.
    pub(super) example: Value,
    pub(super) meaning: Cow<'static, str>,
    /// The kind of equal-speed pair that has this key, if not every kind has it.
    pub(super) only: Option<&'static str>,
}

/// What a key takes.
#[derive(Debug, Clone, Copy)]
pub(super) enum Kind {
    /// A number with a unit; beside the quantity the unit that is usual.
    Quantity(Quantity, &'static str),
    /// A list of numbers with a unit; beside the quantity the unit that is usual.
    Quantities(Quantity, &'static str),
    /// A number without a unit.
    Number,
    /// A whole number.
    Count,
    /// One of these words.
    Choice(&'static [&'static str]),
    /// Any text.
    Text,
    /// The table of the parameters of an own effect.
    Parameters,
}

/// Whether a key may be left out.
#[derive(Debug, Clone)]
pub(super) enum Need {
    Required,
    /// Required unless these keys of the same section are all given.
    RequiredUnless(&'static [&'static str]),
    Optional,
    Default(Value),
}

/// The value of a key, in SI.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Value {
    Real(f64),
    Count(u32),
    Text(String),
    Reals(Vec<f64>),
}

pub(super) type Range = (Bound<f64>, Bound<f64>);
pub(super) const ANY: Range = (Unbounded, Unbounded);
const POSITIVE: Range = (Excluded(0.0), Unbounded);
const BALLS: Range = (Included(3.0), Included(1000.0));

/// Where effects act.
pub(super) const PORTS: &[&str] = &["load", "gap", "contact", "series", "reading"];

impl Key {
    pub(super) fn new(stem: &'static str, kind: Kind, example: Value, meaning: &'static str) -> Self {
        Self {
            stem: stem.into(),
            kind,
            need: Need::Required,
            range: ANY,
            example,
            meaning: meaning.into(),
            only: None,
        }
    }

    /// A number greater than 0 with a unit.
    pub(super) fn quantity(
        stem: &'static str,
        quantity: Quantity,
        usual: &'static str,
        example: f64,
        meaning: &'static str,
    ) -> Self {
        Self::new(stem, Kind::Quantity(quantity, usual), Value::Real(example), meaning).within(POSITIVE)
    }

    pub(super) fn number(stem: &'static str, example: f64, meaning: &'static str) -> Self {
        Self::new(stem, Kind::Number, Value::Real(example), meaning)
    }

    /// Number of balls of a row.
    pub(super) fn balls(example: u32, meaning: &'static str) -> Self {
        Self::new("ball_count", Kind::Count, Value::Count(example), meaning).within(BALLS)
    }

    /// The first word is the example.
    pub(super) fn choice(stem: &'static str, words: &'static [&'static str], meaning: &'static str) -> Self {
        Self::new(stem, Kind::Choice(words), Value::Text(words[0].into()), meaning)
    }

    pub(super) fn text(stem: &'static str, example: &str, meaning: &'static str) -> Self {
        Self::new(stem, Kind::Text, Value::Text(example.into()), meaning)
    }

    pub(super) fn within(self, range: Range) -> Self {
        Self { range, ..self }
    }

    pub(super) fn optional(self) -> Self {
        Self { need: Need::Optional, ..self }
    }

    pub(super) fn unless(self, given: &'static [&'static str]) -> Self {
        Self { need: Need::RequiredUnless(given), ..self }
    }

    /// The example is the default.
    pub(super) fn by_default(self) -> Self {
        Self { need: Need::Default(self.example.clone()), ..self }
    }

    pub(super) fn only(self, kind: &'static str) -> Self {
        Self { only: Some(kind), ..self }
    }

    /// The units the key may carry, the SI unit first; one without a name for a key without unit.
    pub(super) fn units(&self) -> &'static [Unit] {
        match self.kind {
            Kind::Quantity(quantity, _) | Kind::Quantities(quantity, _) => quantity.units(),
            _ => Quantity::Number.units(),
        }
    }

    /// The unit people use.
    pub(super) fn usual_unit(&self) -> &'static Unit {
        let units = self.units();
        match self.kind {
            Kind::Quantity(_, usual) | Kind::Quantities(_, usual) => {
                units.iter().find(|unit| unit.symbol == usual).unwrap_or(&units[0])
            }
            _ => &units[0],
        }
    }

    /// The key as it is written with a unit.
    pub(super) fn with(&self, unit: &Unit) -> String {
        unit.name(&self.stem)
    }

    /// Every way to write the key.
    pub(super) fn names(&self) -> impl Iterator<Item = String> {
        self.units().iter().map(|unit| self.with(unit))
    }

    /// The key in its usual unit.
    pub(super) fn usual(&self) -> String {
        self.with(self.usual_unit())
    }

    /// The key in SI.
    pub(super) fn si(&self) -> String {
        self.with(&self.units()[0])
    }

    /// The unit of a written key, if it is this key.
    fn unit_of(&self, written: &str) -> Option<&'static Unit> {
        written.strip_prefix(&*self.stem)?;
        self.units().iter().find(|unit| self.with(unit) == written)
    }

    /// Whether the range of the key has the number, in SI.
    pub(super) fn allows(&self, value: f64) -> bool {
        self.range.contains(&value)
    }

    /// What the key takes, in words, its numbers in the unit that is written.
    pub(super) fn expected(&self, unit: &Unit) -> String {
        let what = match self.kind {
            Kind::Quantity(..) => format!("a finite number in {}", unit.symbol),
            Kind::Quantities(..) => format!("a list of finite numbers in {}", unit.symbol),
            Kind::Number => "a finite number".into(),
            Kind::Count => "a whole number".into(),
            Kind::Choice(words) => {
                words.iter().map(|word| format!("\"{word}\"")).collect::<Vec<_>>().join(" or ")
            }
            Kind::Text => "a text in quotes".into(),
            Kind::Parameters => "a table of parameters, each { unit, start, min, max }".into(),
        };
        let low = match self.range.0 {
            Excluded(low) => format!(" greater than {}", unit.of_si(low)),
            Included(low) => format!(" not less than {}", unit.of_si(low)),
            Unbounded => String::new(),
        };
        let high = match self.range.1 {
            Excluded(high) => format!(" less than {}", unit.of_si(high)),
            Included(high) => format!(" not more than {}", unit.of_si(high)),
            Unbounded => String::new(),
        };
        let and = if low.is_empty() || high.is_empty() { "" } else { " and" };
        format!("{what}{low}{and}{high}")
    }
}

impl Section {
    /// The value's name in SI, as the mechanics name it: `deceleration.ball_radius_m`.
    pub(super) fn si_name(&self, key: &Key) -> String {
        dotted(self.name, &key.si())
    }

    /// The key that is written so, and its unit.
    pub(super) fn find(&self, written: &str) -> Option<(&Key, &'static Unit)> {
        self.keys.iter().find_map(|key| key.unit_of(written).map(|unit| (key, unit)))
    }

    /// Whether its keys are about numbers of other sections.
    pub(super) fn of_numbers(&self) -> bool {
        ["uncertainty", "tolerance"].contains(&self.name)
    }

    /// The section in a sentence.
    pub(super) fn place(&self) -> String {
        match self.name {
            "" => "the lines above the first section".into(),
            "effect" => "[[effect]]".into(),
            name => format!("[{name}]"),
        }
    }
}

/// A key with the path of its section.
pub(super) fn dotted(path: &str, key: &str) -> String {
    if path.is_empty() { key.to_owned() } else { format!("{path}.{key}") }
}
