//! Units that keys may carry as a suffix, and their way to SI.

use std::f64::consts::PI;

/// What a number measures.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Dimension {
    Length,
    Angle,
    Force,
    Torque,
    Stress,
}

/// One unit as keys write it: the `mm` of `ball_radius_mm`; empty for a plain number.
#[derive(Debug)]
pub(super) struct Unit {
    pub(super) suffix: &'static str,
    scale: Scale,
}

/// How a number in a unit becomes SI.
#[derive(Debug)]
enum Scale {
    /// Shift the decimal point by so many places; exact, so that 1.2 mm, 1200 um and 0.0012 m are one number.
    Shift(i32),
    /// So many of the unit make half a turn.
    HalfTurn(f64),
}

const fn shift(suffix: &'static str, places: i32) -> Unit {
    Unit { suffix, scale: Scale::Shift(places) }
}

const fn half_turn(suffix: &'static str, parts: f64) -> Unit {
    Unit { suffix, scale: Scale::HalfTurn(parts) }
}

/// The unit of keys that have none.
pub(super) const PLAIN: &[Unit] = &[shift("", 0)];
const LENGTH: &[Unit] = &[shift("m", 0), shift("cm", -2), shift("mm", -3), shift("um", -6), shift("nm", -9)];
const ANGLE: &[Unit] = &[
    shift("rad", 0),
    shift("mrad", -3),
    half_turn("deg", 180.0),
    half_turn("arcmin", 10_800.0),
    half_turn("arcsec", 648_000.0),
];
const FORCE: &[Unit] = &[shift("N", 0), shift("mN", -3), shift("kN", 3)];
const TORQUE: &[Unit] = &[shift("Nm", 0), shift("Nmm", -3), shift("mNm", -3), shift("kNm", 3)];
const STRESS: &[Unit] = &[shift("Pa", 0), shift("kPa", 3), shift("MPa", 6), shift("GPa", 9)];

impl Dimension {
    /// The units that are read, the SI unit first.
    pub(super) fn units(self) -> &'static [Unit] {
        match self {
            Self::Length => LENGTH,
            Self::Angle => ANGLE,
            Self::Force => FORCE,
            Self::Torque => TORQUE,
            Self::Stress => STRESS,
        }
    }
}

impl Unit {
    /// A number in this unit, in SI.
    pub(super) fn to_si(&self, value: f64) -> f64 {
        match self.scale {
            Scale::Shift(places) => shifted(value, places),
            Scale::HalfTurn(parts) => value / parts * PI,
        }
    }

    /// A number in SI, in this unit.
    pub(super) fn of_si(&self, value: f64) -> f64 {
        match self.scale {
            Scale::Shift(places) => shifted(value, -places),
            Scale::HalfTurn(parts) => value / PI * parts,
        }
    }
}

/// The value with its decimal point moved, rounded once.
fn shifted(value: f64, places: i32) -> f64 {
    if places == 0 { value } else { format!("{value}e{places}").parse().unwrap_or(f64::NAN) }
}

/// Whether any dimension has a unit that is written so.
pub(super) fn is_unit(suffix: &str) -> bool {
    [LENGTH, ANGLE, FORCE, TORQUE, STRESS].into_iter().flatten().any(|unit| unit.suffix == suffix)
}
