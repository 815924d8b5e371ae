//! One file a verb: case and flags to a report.

pub mod check;
mod cost;
pub mod effects;
mod enclosure;
pub mod friction;
pub mod preload;
pub mod schema;
pub mod sensitivity;
pub mod solve;
pub mod sweep;
pub mod sweep_plan;

use std::path::Path;

use cbpt_core::predict::Effect;
use cbpt_core::predict::loads::Effects;
use cbpt_core::units::{Quantity, Unit};
use cbpt_core::{Drive, Load};

use crate::args::{LoadOptions, OutputOptions};
use crate::case::{Case, EffectEntry};
use crate::exit::Failure;
use crate::report::Report;

/// The chosen units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Units {
    /// Elastic angles.
    pub angle: &'static Unit,
    /// Forces.
    pub force: &'static Unit,
    /// Torques.
    pub torque: &'static Unit,
    /// Deformations and ellipses.
    pub length: &'static Unit,
    /// Pressures.
    pub pressure: &'static Unit,
}

impl From<&OutputOptions> for Units {
    fn from(options: &OutputOptions) -> Self {
        Self {
            angle: options.angle_unit,
            force: options.force_unit,
            torque: options.torque_unit,
            length: options.length_unit,
            pressure: options.pressure_unit,
        }
    }
}

impl Default for Units {
    /// Seconds of arc, newtons, newton metres, micrometres, gigapascals.
    fn default() -> Self {
        Self {
            angle: Quantity::Angle.usual(),
            force: Quantity::Force.usual(),
            torque: Quantity::Torque.usual(),
            length: Quantity::Length.usual(),
            pressure: Quantity::Stress.usual(),
        }
    }
}

/// The effects of a case, as the core takes them.
pub struct CaseEffects {
    effects: Vec<Effect>,
    values: Vec<f64>,
}

impl CaseEffects {
    /// `None` where the case has none.
    pub fn of(case: &Case) -> Option<Self> {
        let effects: Vec<Effect> = case.effects.iter().filter_map(EffectEntry::core).collect();
        let values = case.effects.iter().flat_map(EffectEntry::values).collect();
        (!effects.is_empty()).then_some(Self { effects, values })
    }

    /// As the core takes them.
    pub fn core(&self) -> Effects<'_> {
        Effects { effects: &self.effects, values: &self.values }
    }
}

/// Says of a verb's answer that it is that of the bare drive, where the case has effects.
fn note_bare_drive(report: &mut Report, case: &Case, what: &str) {
    if case.effects.is_empty() {
        return;
    }
    let ids: Vec<&str> = case.effects.iter().map(|effect| &*effect.id).collect();
    report.text += &format!(
        "\nNote: {what} computed for the drive alone, without the effects of the case: {}.",
        ids.join(", ")
    );
    if let serde_json::Value::Object(entries) = &mut report.json {
        entries.insert("effects_not_counted".to_owned(), serde_json::json!(ids));
    }
}

/// Says of a verb's answer that it is that of nominal parts, where the case has tables of them.
fn note_nominal_parts(report: &mut Report, case: &Case, what: &str) {
    if case.drive().is_some_and(|drive| drive.as_made().is_some()) {
        report.text += &format!("\nNote: {what} computed for nominal parts, without [as_made].");
        if let serde_json::Value::Object(entries) = &mut report.json {
            entries.insert("as_made_counted".to_owned(), false.into());
        }
    }
}

/// The ball drive that a verb is about.
fn ball_drive<'a>(case: &'a Case, path: &Path, what: &str) -> Result<&'a Drive, Failure> {
    case.drive().ok_or_else(|| {
        Failure::Usage(format!(
            "{}: {what} about the balls and grooves of a ball drive, and this case has a [torsion_spring]; use solve, sweep, \
             compare, diagnose or fit for it",
            path.display()
        ))
    })
}

/// The torque of the flags, else of the case.
fn torque_Nm(case: &Case, flag: Option<f64>) -> Result<f64, Failure> {
    flag.or(case.load.torque_Nm).ok_or_else(|| missing("--torque-Nm", "torque_Nm"))
}

/// The load of the flags, filled up from the case's `[load]`.
fn load(case: &Case, flags: &LoadOptions) -> Result<Load, Failure> {
    let torque = torque_Nm(case, flags.torque_Nm)?;
    let angle = input_angle_rad(case, flags.input_angle_deg);
    match flags.preload_N.or(case.load.preload_N) {
        Some(preload) => Ok(Load::new(torque, preload, angle)?),
        None if case.drive().is_none() => Ok(Load::without_preload(torque, angle)?),
        None => Err(missing("--preload-N", "preload_N")),
    }
}

fn input_angle_rad(case: &Case, flag_deg: Option<f64>) -> f64 {
    flag_deg.map(f64::to_radians).or(case.load.input_angle_rad).unwrap_or(0.0)
}

fn missing(flag: &str, key: &str) -> Failure {
    Failure::Usage(format!("{flag} is missing: give the flag, or `{key}` under [load] in the case file"))
}
