#![doc = include_str!("../README.md")]
//!
//! # Map
//! Data runs one way: drive -> meshing points -> equilibrium -> angles.
//! - [`drive`]: the drive and the load as data, checked once; [`as_made`]: its parts as they were made;
//! - [`torsion_spring`]: any other reducer; [`reducer`]: either kind;
//! - [`geometry`]: tracks, walls, undercut; [`hertz`]: curvatures to stiffness and pressure;
//! - [`pair`]: each kind of pair to its meshing points;
//! - [`equilibrium`]: meshing points and load to equations, their solution and what it means point by point;
//! - [`solver`]: Newton with Levenberg-Marquardt for convex problems; knows no ball and no groove;
//! - [`status`]: how a solve ended, with the reason;
//! - [`transmission`]: the whole drive; [`extremes`]: its largest elastic angle over a period; [`enclosure`]: where its angle
//!   lies for certain, in numbers that are [`interval`]s;
//! - [`design`]: the numbers that a designer chooses; [`sensitivity`]: how angle and thresholds answer to them, in numbers
//!   that carry derivatives ([`real`]);
//! - [`findings`]: what a designer should know before building; [`preload`]: the three thresholds; [`sweep`]: many loads on all cores;
//! - [`turn`]: when all of a drive stands as before, and what each ball carries;
//! - [`friction`]: losses at the contacts, efficiency, wear; [`strength`]: static safety, preload window, vibration;
//! - [`cost`]: friction, safety and vibration by name, and how they answer to design numbers; [`judge`]: many designs;
//! - [`effect`]: the library of effects; [`predict`]: a drive with effects on a table of readings; [`fit`]: that against
//!   measured angles; [`covariance`]: how readings scatter together; [`posterior`]: the most probable numbers under that scatter;
//! - [`units`]: the one table of units;
//! - [`error`]: bad input. A load that cannot be carried is a [`Status`], not an error.
//!
//! SI units and radians inside; every public name carries its unit.

pub mod as_made;
pub mod cost;
pub mod covariance;
pub mod design;
pub mod drive;
pub mod effect;
pub mod enclosure;
pub mod equilibrium;
pub mod error;
pub mod extremes;
pub mod findings;
pub mod fit;
pub mod friction;
pub mod geometry;
pub mod hertz;
pub mod interval;
pub mod judge;
pub mod pair;
mod period;
pub mod posterior;
pub mod predict;
pub mod preload;
pub mod real;
pub mod reducer;
pub mod sensitivity;
pub mod solver;
pub mod status;
pub mod strength;
pub mod sweep;
pub mod torsion_spring;
pub mod transmission;
pub mod turn;
pub mod units;

pub use as_made::AsMade;
pub use drive::{
    CrossSlide, CrossSlideForm, CrossSlideShare, Deceleration, Drive, Elasticity, EqualSpeed, GrooveSection,
    Load, Material, OutputPlate, RingGroove, TrackCurvature,
};
pub use enclosure::Enclosure;
pub use error::InvalidInput;
pub use findings::{Finding, Severity};
pub use preload::{DriveThresholds, PreloadThresholds};
pub use reducer::Reducer;
pub use status::Status;
pub use torsion_spring::TorsionSpring;
pub use transmission::{Angles, Solution};
