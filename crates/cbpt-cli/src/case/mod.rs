//! Case files: a reducer and what belongs to it, in TOML with the unit in every key. This is their one parser.
//!
//! - `keys` says what a section and a key are, `fields` is the table of them, `library` that of the built-in effects, made of
//!   the core's. All else follows them:
//! - `document` makes one tree of TOML text or a JSON value, `parse` reads the tree by the table, `effect` its effects,
//!   `build` turns values into a [`Case`] and back, `write` writes it, `edit` changes the effects of a file;
//! - `spread` is what a case says of how its numbers scatter;
//! - `reader` reads the keys of one section, `suggest` knows what a wrong key may have meant, `error` how mistakes are told;
//! - `tables` reads the files of the parts as they were made, `parts` turns their lists into what the core takes;
//! - [`parameter`]: what a sweep may vary, by the same keys;
//! - `reference` makes of the table the JSON Schema for editors and the page of all keys.

mod build;
pub(crate) mod document;
mod edit;
mod effect;
pub(crate) mod error;
mod fields;
mod keys;
mod library;
pub mod parameter;
mod parse;
mod parts;
mod reader;
mod reference;
mod spread;
pub(crate) mod suggest;
mod tables;
#[cfg(test)]
mod tests;
mod write;

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{ErrorKind, Read};
use std::path::Path;
use std::sync::Arc;

use cbpt_core::cost::{Cost, Rubbing};
use cbpt_core::effect::OwnEffect;
use cbpt_core::predict::Effect;
pub use cbpt_core::predict::{History, TorqueTurns};
use cbpt_core::{Drive, Reducer};

use crate::formula::Formula;

pub use error::{CaseError, Mistake};
pub use library::EFFECTS;
pub use reference::{json_schema, key_table};
pub use spread::{Spread, in_usual_unit, number_of_key};
pub use write::as_stated;

/// A reducer with its loads, its measurement, what is known of its numbers, and effects. SI units.
#[derive(Debug, Clone, PartialEq)]
pub struct Case {
    /// The reducer, checked.
    pub reducer: Reducer,
    /// The load where nothing else is said.
    pub load: LoadDefaults,
    /// How readings were taken.
    pub measurement: Measurement,
    /// What the maker states of the reducer.
    pub rating: Rating,
    /// Friction of the contacts.
    pub friction: Friction,
    /// How the drive is run, and what moves with it.
    pub operation: Operation,
    /// Standard uncertainties from outside the readings.
    pub uncertainty: Uncertainty,
    /// `[tolerance]`: limits, plus or minus, of numbers by their names in SI (`deceleration.ball_radius_m`).
    pub tolerance: BTreeMap<String, f64>,
    /// Effects in the order of the file.
    pub effects: Vec<EffectEntry>,
}

impl Case {
    /// What costs need beside drive and load.
    pub fn rubbing(&self) -> Rubbing {
        Rubbing {
            coefficient: self.friction.coefficient,
            output_inertia_kg_m2: self.operation.output_inertia_kg_m2,
        }
    }

    /// That the case has what costs need.
    ///
    /// # Errors
    /// What is missing, and the remedy.
    pub fn has_what_costs_need(&self, costs: &[Cost]) -> Result<(), String> {
        if let (Some(cost), None) = (costs.first(), self.drive()) {
            return Err(format!("{} is of a ball drive, and the case has a [torsion_spring]", cost.name()));
        }
        let stated = self.rubbing().stated();
        match costs.iter().find(|cost| !stated.contains(cost)) {
            Some(cost) => Err(format!("{} needs output_inertia under [operation] in the case", cost.name())),
            None => Ok(()),
        }
    }
}

/// `[load]`: each number may be absent.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct LoadDefaults {
    /// Resistance torque M0 on the output, N m.
    pub torque_Nm: Option<f64>,
    /// Axial preload, N.
    pub preload_N: Option<f64>,
    /// Angle of the input crank, rad.
    pub input_angle_rad: Option<f64>,
}

/// `[measurement]`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Measurement {
    /// What the angles are counted from.
    pub zero: Zero,
    /// Radius at which a displacement sensor reads, m.
    pub lever_arm_m: Option<f64>,
    /// What becomes of friction from one run to the next.
    pub friction_between_runs: History,
    /// Where the torque of a ramp turns back.
    pub torque_turns: TorqueTurns,
}

/// `[rating]`.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Rating {
    /// Rated torque of the output, N m.
    pub rated_torque_Nm: Option<f64>,
}

/// `[friction]`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Friction {
    /// Friction coefficient of every contact.
    pub coefficient: f64,
    /// Its standard uncertainty.
    pub coefficient_uncertainty: f64,
}

impl Default for Friction {
    fn default() -> Self {
        Self { coefficient: cbpt_core::friction::COEFFICIENT, coefficient_uncertainty: 0.03 }
    }
}

/// `[operation]`: each number but the safety may be absent.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Operation {
    /// Speed of the input, rad/s.
    pub input_speed_rad_per_s: Option<f64>,
    /// Moment of inertia at the output, kg m^2.
    pub output_inertia_kg_m2: Option<f64>,
    /// Mass of the planet, kg.
    pub planet_mass_kg: Option<f64>,
    /// Static safety that is required.
    pub static_safety: f64,
}

impl Default for Operation {
    fn default() -> Self {
        Self {
            input_speed_rad_per_s: None,
            output_inertia_kg_m2: None,
            planet_mass_kg: None,
            static_safety: 1.0,
        }
    }
}

/// What measured angles are counted from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Zero {
    /// One zero for all runs.
    Common,
    /// One zero for each run.
    PerRun,
}

/// `[uncertainty]`: standard uncertainties (k = 1).
#[derive(Debug, Clone, PartialEq)]
pub struct Uncertainty {
    /// Relative, of the contact stiffness.
    pub contact_stiffness_rel: f64,
    /// Of all contact angles together, rad.
    pub contact_angle_rad: f64,
    /// Relative, of the gain of the torque readings.
    pub torque_gain_rel: f64,
    /// Relative, of the gain of the preload readings.
    pub preload_gain_rel: f64,
    /// Relative, of the gain of the angle sensor.
    pub sensor_gain_rel: f64,
    /// Of single numbers of the drive by their names in SI (`deceleration.ball_radius_m`); exact where absent.
    pub of_drive: BTreeMap<String, f64>,
}

/// One `[[effect]]`.
#[derive(Debug, Clone, PartialEq)]
pub struct EffectEntry {
    /// One of [`EFFECTS`], or the name of an own effect.
    pub id: String,
    /// All numbers of a built-in effect in SI, in the order of the library, named with their units.
    pub numbers: Vec<(String, f64)>,
    /// The own effect itself; a built-in effect has none.
    pub own: Option<Arc<Formula>>,
}

impl EffectEntry {
    /// The effect as the core takes it.
    pub fn core(&self) -> Option<Effect> {
        let own = self.own.clone().map(|own| Effect::Own(own));
        own.or_else(|| cbpt_core::effect::find(&self.id).map(Effect::Library))
    }

    /// The values of its numbers in their order; those of an own effect are its starts.
    pub fn values(&self) -> Vec<f64> {
        match &self.own {
            Some(own) => own.parameters().iter().map(|parameter| parameter.start).collect(),
            None => self.numbers.iter().map(|(_, value)| *value).collect(),
        }
    }
}

/// Effects, each from a JSON object with the keys of a case file.
///
/// # Errors
/// As [`Case::from_json`].
pub fn effects_of(list: &[serde_json::Value]) -> Result<Vec<EffectEntry>, CaseError> {
    let mut notes = error::Notes::of("");
    let document = document::from_json(&serde_json::json!({ "effect": list }), &mut notes);
    let effects =
        document.map(|entries| entries.iter().flat_map(|entry| effect::read(entry, &mut notes)).collect());
    notes.or("", effects)
}

/// One effect as the text of a case file.
pub fn effect_toml(effect: &EffectEntry) -> String {
    write::effect(effect)
}

/// The built-in effect that a wrong id must have meant, if that is clear.
pub fn nearest_effect(id: &str) -> Option<String> {
    suggest::nearest(id, EFFECTS.iter().copied())
}

/// A case file is a few kilobytes; what is larger is another file.
const LARGEST: usize = 1 << 20;

impl Case {
    /// Reads the text of a case file; `name` is the file's name in messages.
    ///
    /// # Errors
    /// [`CaseError`] lists every mistake of the text with its line and what is allowed instead.
    pub fn from_toml(text: &str, name: &str) -> Result<Self, CaseError> {
        Self::from_toml_in(text, name, None)
    }

    /// The same where the files that it names stand beside a folder's case file.
    fn from_toml_in(text: &str, name: &str, folder: Option<&Path>) -> Result<Self, CaseError> {
        if text.len() > LARGEST {
            return Err(CaseError::whole(name, "the file is larger than 1 MiB, too large for a case file"));
        }
        let text = text.strip_prefix('\u{feff}').unwrap_or(text);
        let mut notes = error::Notes::of(text);
        let case = document::from_toml(text, &mut notes)
            .and_then(|document| parse::case(&document, folder, &mut notes));
        notes.or(name, case)
    }

    /// Reads a case file.
    ///
    /// # Errors
    /// As [`Case::from_toml`], and where the file cannot be read as text.
    pub fn read(path: &Path) -> Result<Self, CaseError> {
        let name = path.display().to_string();
        let bytes = bytes(path).map_err(|problem| CaseError::whole(&name, problem))?;
        match std::str::from_utf8(&bytes) {
            Ok(text) => Self::from_toml_in(text, &name, Some(path.parent().unwrap_or(Path::new("")))),
            Err(error) => Err(CaseError::not_utf8(&name, &bytes[..error.valid_up_to()])),
        }
    }

    /// Reads a case from a JSON object with the keys of a case file.
    ///
    /// # Errors
    /// As [`Case::from_toml`], without lines.
    pub fn from_json(value: &serde_json::Value) -> Result<Self, CaseError> {
        let mut notes = error::Notes::of("");
        let case = document::from_json(value, &mut notes)
            .and_then(|document| parse::case(&document, None, &mut notes));
        notes.or("", case)
    }

    /// The case with these effects in place of its own, each a JSON object with the keys of a case file.
    ///
    /// # Errors
    /// As [`Case::from_json`].
    pub fn with_effects(&self, list: &[serde_json::Value]) -> Result<Self, CaseError> {
        effects_of(list).map(|effects| Self { effects, ..self.clone() })
    }

    /// The case as the text of a case file in SI units. Reading it gives the very same case.
    pub fn to_toml(&self) -> String {
        write::toml(self)
    }

    /// The text of the file that this case was made of, with the effects of this case: comments, order and units stay. Where
    /// anything else differs, the same as [`Case::to_toml`]. Not every number of SI has one in another unit that reads back the
    /// same: a number of an effect may then be off by one unit in the last place.
    ///
    /// # Errors
    /// As [`Case::from_toml`], for the text.
    pub fn to_toml_like(&self, text: &str) -> Result<String, CaseError> {
        edit::with_effects(text, self)
    }

    /// The ball drive, if the case has one.
    pub fn drive(&self) -> Option<&Drive> {
        self.reducer.ball_drive()
    }

    /// A reducer as the text of a case file in SI units. Reading it gives the very same reducer.
    pub fn reducer_to_toml(reducer: &Reducer) -> String {
        write::reducer_toml(reducer)
    }
}

/// The bytes of a file, never many more than a case file may have.
fn bytes(path: &Path) -> Result<Vec<u8>, String> {
    if path.is_dir() {
        return Err("is a directory, not a case file".into());
    }
    let cannot = |error: std::io::Error| match error.kind() {
        ErrorKind::NotFound => "file not found".to_owned(),
        _ => format!("cannot be read: {error}"),
    };
    let mut bytes = Vec::new();
    let file = File::open(path).map_err(cannot)?;
    file.take(LARGEST as u64 + 1).read_to_end(&mut bytes).map_err(cannot)?;
    Ok(bytes)
}
