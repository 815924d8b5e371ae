//! What a sweep may vary: one number or word of a case, found by its key, and the case with others in their places.
//!
//! Names are those of the table of keys with their section: `deceleration.ball_radius_mm`, `load.torque_Nm`; of an effect
//! in the case with its id, `effect.creep.time_constant_s`, the second of its kind as `effect.creep#2.time_constant_s`.

// A mistake is told once; its size does not matter.
#![allow(clippy::result_large_err)]

use cbpt_core::effect::{OwnEffect, OwnParameter};
use cbpt_core::units::Unit;
use cbpt_core::{InvalidInput, Reducer};

use super::build::{self, Values};
use super::document::Content;
use super::error::Mistake;
use super::fields;
use super::keys::{self, Key, Kind, Section, Value, dotted};
use super::{Case, EffectEntry, library, suggest};

/// One number or word of a case.
#[derive(Debug, Clone)]
pub struct Parameter {
    /// As it was written, with its unit.
    pub name: String,
    /// What it is, in words.
    pub meaning: String,
    /// Unit of its numbers, as keys write it; an own effect's is its author's; empty for plain numbers and words.
    pub unit: String,
    /// Where it acts.
    pub acts_on: ActsOn,
    key: Option<(Key, &'static Unit)>,
    own: Option<OwnParameter>,
    place: Place,
}

/// What has to be made anew where the parameter is another.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum ActsOn {
    /// The reducer: everything.
    Reducer,
    /// The numbers of effects.
    Effects,
    /// The input angle: the meshing points.
    InputAngle,
    /// The preload.
    Preload,
    /// The torque.
    Torque,
}

#[derive(Debug, Clone, PartialEq)]
enum Place {
    /// The value of this name in SI.
    Value(String),
    /// Place among the numbers of all effects.
    Number(usize),
}

impl Parameter {
    /// The parameter of a case that is written so.
    ///
    /// # Errors
    /// What is wrong with the name, and the nearest right one.
    pub fn find(case: &Case, name: &str) -> Result<Self, Mistake> {
        match name.split_once('.') {
            Some(("effect", rest)) => of_effect(case, name, rest),
            Some((section, key)) => of_section(case, name, section, key),
            None if fields::top().find(name).is_some() => of_section(case, name, "", name),
            None => Err(without_section(case, name)),
        }
    }

    /// The words it takes, if it takes words.
    pub fn words(&self) -> Option<&'static [&'static str]> {
        match self.key.as_ref()?.0.kind {
            Kind::Choice(words) => Some(words),
            _ => None,
        }
    }

    /// Whether it takes whole numbers only.
    pub fn is_count(&self) -> bool {
        self.key.as_ref().is_some_and(|(key, _)| matches!(key.kind, Kind::Count))
    }

    /// A number in its unit, in SI.
    pub fn to_si(&self, number: f64) -> f64 {
        self.key.as_ref().map_or(number, |(_, unit)| unit.to_si(number))
    }

    /// Refuses a number that it never takes.
    ///
    /// # Errors
    /// The number and what is allowed.
    pub fn check_number(&self, number: f64) -> Result<(), Mistake> {
        let si = self.to_si(number);
        let (allowed, expected) = match (&self.key, &self.own) {
            (Some((key, unit)), _) => {
                let count = !self.is_count() || (number.fract() == 0.0 && number >= 0.0);
                (self.words().is_none() && key.allows(si) && count, key.expected(unit))
            }
            (None, Some(OwnParameter { min, max, .. })) => {
                let (low, high) = (min.unwrap_or(f64::NEG_INFINITY), max.unwrap_or(f64::INFINITY));
                ((low..=high).contains(&si), format!("a finite number from {low} to {high}"))
            }
            (None, None) => (true, String::new()),
        };
        if allowed && si.is_finite() {
            return Ok(());
        }
        Err(self.refused(number.to_string(), &expected))
    }

    /// Refuses a word that it does not take.
    ///
    /// # Errors
    /// The word and those that are allowed.
    pub fn check_word(&self, word: &str) -> Result<(), Mistake> {
        let words = self.words().unwrap_or_default();
        if words.contains(&word) {
            return Ok(());
        }
        let expected = self.key.as_ref().map_or("a number".into(), |(key, unit)| key.expected(unit));
        let nearest = suggest::nearest(word, words.iter().copied());
        Err(Mistake { nearest, ..self.refused(format!("{word:?}"), &expected) })
    }

    fn refused(&self, found: String, expected: &str) -> Mistake {
        Mistake {
            key: self.name.clone(),
            found,
            allowed: format!("expected {expected}"),
            ..Mistake::default()
        }
    }

    /// Name in SI of a number of the case itself (`deceleration.ball_radius_m`); those of effects have none.
    pub fn si_name(&self) -> Option<&str> {
        match &self.place {
            Place::Value(name) => Some(name),
            Place::Number(_) => None,
        }
    }

    /// Whether both set the same value.
    pub fn is_same(&self, other: &Self) -> bool {
        self.place == other.place
    }
}

fn of_section(case: &Case, name: &str, section_name: &str, key_name: &str) -> Result<Parameter, Mistake> {
    let found = if section_name.is_empty() { Some(fields::top()) } else { fields::section(section_name) };
    let Some(section) = found else {
        return Err(Mistake { key: name.into(), ..suggest::unknown_section(section_name) });
    };
    let wrong = |problem: &str, allowed: &str| Mistake {
        key: name.into(),
        problem: problem.into(),
        allowed: allowed.into(),
        ..Mistake::default()
    };
    if !section.mechanics {
        let problem = "does not change the elastic angle";
        return Err(wrong(problem, "sweep a number of the drive, of [load] or of an effect"));
    }
    let Some((key, unit)) = section.find(key_name) else {
        let mistake = suggest::unknown_key(section, key_name, &Content::Other).mistake;
        let nearest = mistake.nearest.map(|nearest| dotted(section.name, &nearest));
        return Err(Mistake { key: name.into(), nearest, ..mistake });
    };
    if matches!(key.kind, Kind::Quantities(..) | Kind::Text | Kind::Parameters) {
        return Err(wrong("is not a single number or word", "such a key cannot be an axis"));
    }
    let of_spring = section.name == fields::SPRING;
    match &case.reducer {
        Reducer::BallDrive(_) if of_spring => {
            return Err(wrong("is about a torsion spring", "this case has a ball drive"));
        }
        Reducer::TorsionSpring(spring)
            if &*key.stem == "torsional_stiffness" && !spring.points().is_empty() =>
        {
            return Err(wrong(
                "the case gives a table of torque and angle instead",
                "give the case one stiffness",
            ));
        }
        Reducer::TorsionSpring(_) if section.name != "load" && !of_spring => {
            return Err(wrong("is about a ball drive", "this case has a [torsion_spring]"));
        }
        _ => {}
    }
    let acts_on = match (section.name, &*key.stem) {
        ("load", "torque") => ActsOn::Torque,
        ("load", "preload") => ActsOn::Preload,
        ("load", _) => ActsOn::InputAngle,
        _ => ActsOn::Reducer,
    };
    Ok(Parameter {
        name: name.into(),
        meaning: key.meaning.to_string(),
        unit: unit.symbol.into(),
        acts_on,
        key: Some((key.clone(), unit)),
        own: None,
        place: Place::Value(section.si_name(key)),
    })
}

/// A key without the section that it needs.
fn without_section(case: &Case, name: &str) -> Mistake {
    let of_spring = case.drive().is_none();
    let sections = || {
        fields::sections().iter().filter(move |section| {
            let other = if of_spring {
                fields::DRIVE.contains(&section.name)
            } else {
                section.name == fields::SPRING
            };
            section.mechanics && !section.name.is_empty() && !other
        })
    };
    let there = sections().find(|section| section.find(name).is_some());
    let near = || {
        let names: Vec<String> = sections().flat_map(names).collect();
        suggest::nearest(name, names.iter().map(String::as_str))
    };
    Mistake {
        key: name.into(),
        problem: "an axis is a key of the case together with its section".into(),
        allowed: "for example load.torque_Nm or deceleration.ball_radius_mm; `cbpt schema --keys` lists them"
            .into(),
        nearest: there.map(|section| dotted(section.name, name)).or_else(near),
        ..Mistake::default()
    }
}

fn names(section: &'static Section) -> impl Iterator<Item = String> {
    section.keys.iter().map(|key| dotted(section.name, &key.usual()))
}

fn of_effect(case: &Case, name: &str, rest: &str) -> Result<Parameter, Mistake> {
    let (id, key_name) = rest.split_once('.').unwrap_or((rest, ""));
    let (entry, first) = effect_named(case, name, id)?;
    let parameter = |key: Option<(Key, &'static Unit)>, own: Option<OwnParameter>, slot: usize| Parameter {
        name: name.into(),
        meaning: match &key {
            Some((key, _)) => format!("{}: {}", entry.id, key.meaning),
            None => format!("parameter of the own effect {}", entry.id),
        },
        unit: key.as_ref().map_or_else(
            || own.as_ref().map(|own| own.unit.clone()).unwrap_or_default(),
            |(_, unit)| unit.symbol.to_owned(),
        ),
        acts_on: ActsOn::Effects,
        key,
        own,
        place: Place::Number(first + slot),
    };
    if let Some(own) = &entry.own {
        let found = own.parameters().iter().position(|own| own.name == key_name);
        let names = || own.parameters().iter().map(|own| &*own.name);
        return found.map(|slot| parameter(None, Some(own.parameters()[slot].clone()), slot)).ok_or_else(
            || Mistake {
                key: name.into(),
                problem: "unknown parameter".into(),
                allowed: format!("{} has {}", entry.id, names().collect::<Vec<_>>().join(", ")),
                nearest: suggest::nearest(key_name, names()).map(|near| format!("effect.{id}.{near}")),
                ..Mistake::default()
            },
        );
    }
    let Some((_, section)) = library::find(&entry.id) else { return Err(without_section(case, name)) };
    let slot = |key: &Key| library::parameters(section).position(|own| own.stem == key.stem);
    if let Some((key, unit)) = section.find(key_name)
        && let Some(slot) = slot(key)
    {
        return Ok(parameter(Some((key.clone(), unit)), None, slot));
    }
    let mistake = suggest::unknown_key(section, key_name, &Content::Other).mistake;
    let nearest = mistake.nearest.map(|near| format!("effect.{id}.{near}"));
    let numbers: Vec<String> = library::parameters(section).map(Key::usual).collect();
    let allowed = format!("{} has {}", entry.id, numbers.join(", "));
    Err(Mistake { key: name.into(), nearest, allowed, ..mistake })
}

/// The effect of the case that is named so, and the place of its first number among those of all.
fn effect_named<'c>(case: &'c Case, name: &str, id: &str) -> Result<(&'c EffectEntry, usize), Mistake> {
    let mut first = 0;
    let mut names: Vec<String> = Vec::new();
    for entry in &case.effects {
        let earlier = case.effects.iter().take(names.len()).filter(|other| other.id == entry.id).count();
        names.push(if earlier == 0 { entry.id.clone() } else { format!("{}#{}", entry.id, earlier + 1) });
        if names.last().is_some_and(|known| known == id) {
            return Ok((entry, first));
        }
        first += entry.values().len();
    }
    let allowed = match (names.is_empty(), library::find(id)) {
        (_, Some(_)) => format!("add it to the case: [[effect]] with id = \"{id}\""),
        (true, None) => "the case has no effects: add one, [[effect]] with its id".into(),
        (false, None) => format!("the case has {}", names.join(", ")),
    };
    Err(Mistake {
        key: name.into(),
        problem: format!("the case has no effect {id:?}"),
        allowed,
        nearest: suggest::nearest(id, names.iter().map(String::as_str)).map(|near| format!("effect.{near}")),
        ..Mistake::default()
    })
}

/// A number in SI or a word.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Setting<'a> {
    /// A number, in SI.
    Number(f64),
    /// A word.
    Word(&'a str),
}

/// A case whose parameters are set anew again and again.
#[derive(Debug, Clone)]
pub struct Variants {
    values: Values,
    numbers: Vec<f64>,
    parameters: Vec<Parameter>,
}

impl Variants {
    /// Of a case with these parameters, each of which sets another value.
    ///
    /// # Errors
    /// Two that set the same value, or one that a value of the case hides.
    pub fn new(case: &Case, parameters: Vec<Parameter>) -> Result<Self, Mistake> {
        let mut values = build::values(case);
        for (at, parameter) in parameters.iter().enumerate() {
            let Place::Value(name) = &parameter.place else { continue };
            let others =
                || parameters.iter().enumerate().filter(|(other, _)| *other != at).map(|(_, other)| other);
            let hiding = build::special_of(name).find(|special| {
                values.has(special) || others().any(|other| other.place == Place::Value((*special).into()))
            });
            if let Some(special) = hiding {
                return Err(Mistake {
                    key: parameter.name.clone(),
                    problem: format!("{special} is given as well and takes precedence"),
                    allowed: "sweep the two separate parameters instead".into(),
                    ..Mistake::default()
                });
            }
        }
        for (at, parameter) in parameters.iter().enumerate() {
            if let Some(first) = parameters[..at].iter().find(|first| first.is_same(parameter)) {
                return Err(Mistake {
                    key: parameter.name.clone(),
                    problem: format!("sets the same value as {}", first.name),
                    allowed: "keep one of them".into(),
                    ..Mistake::default()
                });
            }
        }
        let kinds = Place::Value("equal_speed.kind".into());
        if parameters.iter().any(|parameter| parameter.place == kinds) {
            // What one kind alone has by default must be there when its turn comes.
            for section in fields::sections() {
                for key in section.keys.iter().filter(|key| key.only.is_some()) {
                    if let keys::Need::Default(value) = &key.need
                        && !values.has(&section.si_name(key))
                    {
                        values.set(section.si_name(key), value.clone());
                    }
                }
            }
        }
        let numbers = case.effects.iter().flat_map(EffectEntry::values).collect();
        Ok(Self { values, numbers, parameters })
    }

    /// The parameters, in their order.
    pub fn parameters(&self) -> &[Parameter] {
        &self.parameters
    }

    /// The reducer with these settings, one for each parameter; those of effects and loads do not touch it.
    ///
    /// # Errors
    /// What the mechanics refuse.
    pub fn reducer(&self, settings: &[Setting<'_>]) -> Result<Reducer, InvalidInput> {
        let mut values = self.values.clone();
        for (parameter, setting) in self.parameters.iter().zip(settings) {
            let (ActsOn::Reducer, Place::Value(name)) = (parameter.acts_on, &parameter.place) else {
                continue;
            };
            values.set(
                name.as_str(),
                match setting {
                    Setting::Word(word) => Value::Text((*word).to_owned()),
                    // Checked to be a whole number within the range of the key.
                    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
                    Setting::Number(number) if parameter.is_count() => Value::Count(*number as u32),
                    Setting::Number(number) => Value::Real(*number),
                },
            );
        }
        build::reducer(&values)
    }

    /// The numbers of all effects with these settings.
    pub fn numbers(&self, settings: &[Setting<'_>]) -> Vec<f64> {
        let mut numbers = self.numbers.clone();
        for (parameter, setting) in self.parameters.iter().zip(settings) {
            if let (Place::Number(slot), Setting::Number(number)) = (&parameter.place, setting) {
                numbers[*slot] = *number;
            }
        }
        numbers
    }
}
