//! Effects that the user defines: what they can read, what they add to, and the trait that all of them implement.
//!
//! An own effect adds one number for each reading at its port: a torque or a preload at the load port, an angle at the series and
//! the reading port. It acts after the library's effects of its port; own effects among themselves in the order given.
//! A formula in Rust implements [`OwnEffect`]; expressions of case files and functions of Python do the same:
//!
//! ```
//! use std::sync::Arc;
//!
//! use cbpt_core::effect::dual::Dual;
//! use cbpt_core::effect::own::{AddsTo, At, OwnEffect, OwnParameter, Variable};
//! use cbpt_core::predict::loads::{Effects, solve_load};
//! use cbpt_core::predict::Effect;
//! use cbpt_core::{Drive, InvalidInput, Load};
//!
//! /// alpha += a M0^3
//! #[derive(Debug)]
//! struct Hardening([OwnParameter; 1]);
//!
//! impl OwnEffect for Hardening {
//!     fn id(&self) -> &str {
//!         "hardening"
//!     }
//!     fn adds_to(&self) -> AddsTo {
//!         AddsTo::Series
//!     }
//!     fn parameters(&self) -> &[OwnParameter] {
//!         &self.0
//!     }
//!     fn uses(&self, variable: Variable) -> bool {
//!         variable == Variable::Torque
//!     }
//!     fn values(&self, own: &[Dual], rows: &[At<'_>]) -> Result<Vec<Dual>, InvalidInput> {
//!         let cubed = |at: &At<'_>| at.torque_Nm * at.torque_Nm * at.torque_Nm;
//!         Ok(rows.iter().map(|at| own[0] * cubed(at)).collect())
//!     }
//! }
//!
//! let a = OwnParameter { name: "a".into(), unit: "rad/(N m)^3".into(), stated: String::new(), start: 1e-8, min: None, max: None };
//! let effects = [Effect::Own(Arc::new(Hardening([a])))];
//! let effects = Effects { effects: &effects, values: &[1e-8] };
//! let found = solve_load(&Drive::paper_base_case(), effects, &Load::new(5.0, 600.0, 0.0)?)?;
//! assert_eq!(found.contributions[1].name, "hardening");
//! assert!((found.contributions[1].angle_rad[0] - 125e-8).abs() < 1e-15);
//! # Ok::<(), InvalidInput>(())
//! ```

use std::fmt;

use super::dual::Dual;
use super::port::{DriveNumbers, Row};
use super::spec::Port;
use crate::error::InvalidInput;
use crate::units::Quantity;

/// What an own effect adds to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum AddsTo {
    /// The torque that reaches the meshing points, N m (load port).
    Torque,
    /// The preload that reaches the meshing points, N (load port).
    Preload,
    /// The angle at the output, behind the meshing points, rad (series port).
    Series,
    /// The angle that the instrument shows, rad (reading port).
    Reading,
}

impl AddsTo {
    /// The port it belongs to.
    pub fn port(self) -> Port {
        match self {
            Self::Torque | Self::Preload => Port::Load,
            Self::Series => Port::Series,
            Self::Reading => Port::Reading,
        }
    }

    /// The quantity with its unit: `torque_Nm`, `preload_N` or `angle_rad`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Torque => "torque_Nm",
            Self::Preload => "preload_N",
            Self::Series | Self::Reading => "angle_rad",
        }
    }

    /// What is added.
    pub fn quantity(self) -> Quantity {
        match self {
            Self::Torque => Quantity::Torque,
            Self::Preload => Quantity::Force,
            Self::Series | Self::Reading => Quantity::Angle,
        }
    }

    /// From a port and a quantity.
    ///
    /// # Errors
    /// [`InvalidInput`] for a port where nothing can be added, and where the quantity is missing or another one.
    pub fn of(port: &str, quantity: Option<&str>) -> Result<Self, InvalidInput> {
        let found = match (port, quantity) {
            ("load", Some("torque_Nm")) => Self::Torque,
            ("load", Some("preload_N")) => Self::Preload,
            ("load", _) => {
                let rule = "must be \"torque_Nm\" or \"preload_N\" at the load port";
                return Err(InvalidInput::new("adds_to", quantity.unwrap_or("nothing"), rule));
            }
            ("series", None | Some("angle_rad")) => Self::Series,
            ("reading", None | Some("angle_rad")) => Self::Reading,
            ("series" | "reading", Some(other)) => {
                return Err(InvalidInput::new(
                    "adds_to",
                    other,
                    "is \"angle_rad\" at this port; leave it out",
                ));
            }
            _ => {
                let rule = "an own effect acts at \"load\", \"series\" or \"reading\"; gaps and contacts take the \
                            effects of the library only";
                return Err(InvalidInput::new("port", port, rule));
            }
        };
        Ok(found)
    }
}

/// A number of an own effect, in SI.
#[derive(Debug, Clone, PartialEq)]
pub struct OwnParameter {
    /// Its name.
    pub name: String,
    /// Its SI unit.
    pub unit: String,
    /// The unit in which it was stated, for reports and files; empty for the SI unit.
    pub stated: String,
    /// Its value; where a fit starts.
    pub start: f64,
    /// Least plausible value.
    pub min: Option<f64>,
    /// Greatest plausible value.
    pub max: Option<f64>,
}

impl OwnParameter {
    /// Values that are allowed: the plausible ones, and 0, which switches a term off.
    pub fn limits(&self) -> (f64, f64) {
        let (low, high) = self.range();
        (low.min(0.0), high.max(0.0))
    }

    /// Plausible values.
    pub fn range(&self) -> (f64, f64) {
        (self.min.unwrap_or(f64::NEG_INFINITY), self.max.unwrap_or(f64::INFINITY))
    }
}

/// What an own effect may depend on beside its parameters. [`VARIABLES`] lists all of it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[allow(missing_docs)] // the table says it
pub enum Variable {
    Torque,
    Preload,
    InputAngle,
    Time,
    RunTime,
    TemperatureDifference,
    CyclesDone,
    Direction,
    Angle,
    PitchArm,
    PlanetTurn,
}

/// Every variable: its name in expressions and in tables of Python, and what it is.
pub const VARIABLES: [(Variable, &str, &str); 11] = [
    (
        Variable::Torque,
        "torque_Nm",
        "torque on the output; at the load port after the effects before this one",
    ),
    (Variable::Preload, "preload_N", "axial preload; at the load port after the effects before this one"),
    (Variable::InputAngle, "input_angle_rad", "angle of the input crank"),
    (Variable::Time, "time_s", "time since the table's first reading"),
    (Variable::RunTime, "run_time_s", "time since the run's first reading"),
    (
        Variable::TemperatureDifference,
        "temperature_difference_K",
        "temperature minus the temperature of the table's first reading",
    ),
    (Variable::CyclesDone, "cycles_done", "load cycles completed before the reading"),
    (
        Variable::Direction,
        "direction",
        "1 if the torque rises in the run, -1 if it falls, 0 if it stays the same",
    ),
    (
        Variable::Angle,
        "alpha_rad",
        "the elastic angle after the effects before this one; not available at the load port",
    ),
    (
        Variable::PitchArm,
        "pitch_arm_m",
        "distance of the drive's pitch point from the centre of the output plate (Zo e)",
    ),
    (Variable::PlanetTurn, "planet_turn", "turns of the drive's planet groove for one turn of the crank"),
];

impl Variable {
    /// What it measures.
    pub fn quantity(self) -> Quantity {
        match self {
            Self::Torque => Quantity::Torque,
            Self::Preload => Quantity::Force,
            Self::InputAngle | Self::Angle => Quantity::Angle,
            Self::Time | Self::RunTime => Quantity::Time,
            Self::TemperatureDifference => Quantity::Temperature,
            Self::PitchArm => Quantity::Length,
            Self::CyclesDone | Self::Direction | Self::PlanetTurn => Quantity::Number,
        }
    }

    /// The variable of a name.
    pub fn find(name: &str) -> Option<Self> {
        VARIABLES.iter().find(|(_, known, _)| *known == name).map(|(variable, ..)| *variable)
    }
}

/// A reading as an own effect sees it at its port.
#[derive(Debug, Clone, Copy)]
pub struct At<'a> {
    /// The reading.
    pub row: &'a Row,
    /// The drive.
    pub drive: &'a DriveNumbers,
    /// Torque at the port, N m.
    pub torque_Nm: Dual,
    /// Preload at the port, N.
    pub preload_N: Dual,
    /// The elastic angle so far, rad; NaN at the load port and where there is no solution.
    pub alpha_rad: Dual,
}

impl At<'_> {
    /// The value of a variable.
    pub fn get(&self, variable: Variable) -> Dual {
        Dual::constant(match variable {
            Variable::Torque => return self.torque_Nm,
            Variable::Preload => return self.preload_N,
            Variable::Angle => return self.alpha_rad,
            Variable::InputAngle => self.row.input_angle_rad,
            Variable::Time => self.row.time_s,
            Variable::RunTime => self.row.run_time_s,
            Variable::TemperatureDifference => self.row.temperature_difference_K,
            Variable::CyclesDone => self.row.cycles_done,
            Variable::Direction => self.row.direction,
            Variable::PitchArm => self.drive.pitch_arm_m,
            Variable::PlanetTurn => self.drive.planet_turn,
        })
    }
}

/// An effect of the user's own.
pub trait OwnEffect: fmt::Debug + Send + Sync {
    /// Its name; none of the library's ids.
    fn id(&self) -> &str;

    /// What it adds to, which says its port.
    fn adds_to(&self) -> AddsTo;

    /// Its parameters.
    fn parameters(&self) -> &[OwnParameter];

    /// Whether it depends on a variable.
    ///
    /// An effect at the series port that depends on the angle is added behind the rotation that friction counts; one
    /// that does not is part of that rotation, as the library's are.
    fn uses(&self, variable: Variable) -> bool;

    /// What it adds at every row, SI, given its parameters in their order. Rows stand run by run, in the order of time.
    /// A value that is not finite is told as the status of its row.
    ///
    /// # Errors
    /// [`InvalidInput`] where nothing can be computed at all.
    fn values(&self, own: &[Dual], rows: &[At<'_>]) -> Result<Vec<Dual>, InvalidInput>;
}

#[cfg(test)]
#[allow(clippy::float_cmp)] // where nothing is rounded
mod tests {
    use super::*;

    /// 0 switches a term off, so it is allowed beside what is plausible.
    #[test]
    fn a_number_may_be_0_beside_what_is_plausible() {
        let number = |min, max| OwnParameter {
            name: "a".to_owned(),
            unit: String::new(),
            stated: String::new(),
            start: 2.0,
            min: Some(min),
            max: Some(max),
        };
        assert_eq!(number(1.0, 3.0).limits(), (0.0, 3.0));
        assert_eq!(number(-3.0, -1.0).limits(), (-3.0, 0.0));
    }
}
