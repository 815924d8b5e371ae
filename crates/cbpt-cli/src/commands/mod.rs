//! One file a verb: case and flags to a report.

pub mod check;
pub mod preload;
pub mod schema;
pub mod solve;
pub mod sweep;

use std::path::Path;

use cbpt_core::Load;

use crate::args::{LoadOptions, OutputOptions};
use crate::case::Case;
use crate::exit::Failure;
use crate::units::Unit;

/// The chosen units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Units {
    /// Elastic angles.
    pub angle: Unit,
    /// Forces.
    pub force: Unit,
    /// Torques.
    pub torque: Unit,
    /// Deformations and ellipses.
    pub length: Unit,
    /// Pressures.
    pub pressure: Unit,
}

impl From<&OutputOptions> for Units {
    fn from(options: &OutputOptions) -> Self {
        Self {
            angle: options.angle_unit.unit(),
            force: options.force_unit.unit(),
            torque: options.torque_unit.unit(),
            length: options.length_unit.unit(),
            pressure: options.pressure_unit.unit(),
        }
    }
}

impl Default for Units {
    /// Seconds of arc, newtons, newton metres, micrometres, gigapascals.
    fn default() -> Self {
        Self {
            angle: crate::units::AngleUnit::Arcsec.unit(),
            force: crate::units::ForceUnit::N.unit(),
            torque: crate::units::TorqueUnit::Nm.unit(),
            length: crate::units::LengthUnit::Um.unit(),
            pressure: crate::units::PressureUnit::GPa.unit(),
        }
    }
}

/// Reads a case whose drive is to be computed as it stands.
///
/// Effects are part of the case format but not yet of the model; leaving them out in silence would be a wrong number.
fn read_case(path: &Path) -> Result<Case, Failure> {
    let case = Case::read(path)?;
    match case.effects.first() {
        None => Ok(case),
        Some(effect) => Err(Failure::Usage(format!(
            "{}: the case has the effect `{}`, which this version reads but cannot compute yet; remove its [[effect]] to \
             compute the bare drive",
            path.display(),
            effect.id
        ))),
    }
}

/// The torque of the flags, else of the case.
fn torque_Nm(case: &Case, flag: Option<f64>) -> Result<f64, Failure> {
    flag.or(case.load.torque_Nm).ok_or_else(|| missing("--torque-Nm", "torque_Nm"))
}

/// The load of the flags, filled up from the case's `[load]`.
fn load(case: &Case, flags: &LoadOptions) -> Result<Load, Failure> {
    let torque = torque_Nm(case, flags.torque_Nm)?;
    let preload =
        flags.preload_N.or(case.load.preload_N).ok_or_else(|| missing("--preload-N", "preload_N"))?;
    Ok(Load::new(torque, preload, input_angle_rad(case, flags.input_angle_deg))?)
}

fn input_angle_rad(case: &Case, flag_deg: Option<f64>) -> f64 {
    flag_deg.map(f64::to_radians).or(case.load.input_angle_rad).unwrap_or(0.0)
}

fn missing(flag: &str, key: &str) -> Failure {
    Failure::Usage(format!("{flag} is missing: give the flag, or `{key}` under [load] in the case file"))
}
