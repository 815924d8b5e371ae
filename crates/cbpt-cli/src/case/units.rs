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
    Time,
    PerTime,
    PerAngle,
    PerAngleSquared,
    AnglePerTime,
    AnglePerTemperature,
    AnglePerTorque,
    ForcePerLength,
    ForcePerTemperature,
    PerTorque,
    TorquePerAngle,
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
    /// One of the unit is so much in SI.
    Times(f64),
}

const fn shift(suffix: &'static str, places: i32) -> Unit {
    Unit { suffix, scale: Scale::Shift(places) }
}

const fn half_turn(suffix: &'static str, parts: f64) -> Unit {
    Unit { suffix, scale: Scale::HalfTurn(parts) }
}

const fn times(suffix: &'static str, si: f64) -> Unit {
    Unit { suffix, scale: Scale::Times(si) }
}

const ARCSEC: f64 = PI / 648_000.0;

/// The unit of keys that have none.
pub(super) const PLAIN: &[Unit] = &[shift("", 0)];
const LENGTH: &[Unit] = &[shift("m", 0), shift("cm", -2), shift("mm", -3), shift("um", -6), shift("nm", -9)];
const ANGLE: &[Unit] = &[
    shift("rad", 0),
    shift("mrad", -3),
    shift("urad", -6),
    half_turn("deg", 180.0),
    half_turn("arcmin", 10_800.0),
    half_turn("arcsec", 648_000.0),
];
const FORCE: &[Unit] = &[shift("N", 0), shift("mN", -3), shift("kN", 3)];
const TORQUE: &[Unit] = &[shift("Nm", 0), shift("Nmm", -3), shift("mNm", -3), shift("kNm", 3)];
const STRESS: &[Unit] = &[shift("Pa", 0), shift("kPa", 3), shift("MPa", 6), shift("GPa", 9)];
const TIME: &[Unit] = &[shift("s", 0), shift("ms", -3), times("min", 60.0), times("h", 3600.0)];
const PER_TIME: &[Unit] = &[shift("per_s", 0), times("per_min", 1.0 / 60.0), times("per_h", 1.0 / 3600.0)];
const PER_ANGLE: &[Unit] = &[shift("per_rad", 0), shift("per_mrad", 3), times("per_arcsec", 1.0 / ARCSEC)];
const PER_ANGLE_SQUARED: &[Unit] =
    &[shift("per_rad2", 0), shift("per_mrad2", 6), times("per_arcsec2", 1.0 / (ARCSEC * ARCSEC))];
const ANGLE_PER_TIME: &[Unit] = &[
    shift("rad_per_s", 0),
    shift("urad_per_s", -6),
    times("arcsec_per_s", ARCSEC),
    times("arcsec_per_min", ARCSEC / 60.0),
    times("arcsec_per_h", ARCSEC / 3600.0),
];
const ANGLE_PER_TEMPERATURE: &[Unit] =
    &[shift("rad_per_K", 0), shift("urad_per_K", -6), times("arcsec_per_K", ARCSEC)];
const ANGLE_PER_TORQUE: &[Unit] =
    &[shift("rad_per_Nm", 0), shift("urad_per_Nm", -6), times("arcsec_per_Nm", ARCSEC)];
const FORCE_PER_LENGTH: &[Unit] =
    &[shift("N_per_m", 0), shift("N_per_mm", 3), shift("N_per_um", 6), shift("kN_per_mm", 6)];
const FORCE_PER_TEMPERATURE: &[Unit] = &[shift("N_per_K", 0), shift("kN_per_K", 3)];
const PER_TORQUE: &[Unit] = &[shift("per_Nm", 0), shift("per_kNm", -3)];
const TORQUE_PER_ANGLE: &[Unit] = &[
    shift("Nm_per_rad", 0),
    shift("kNm_per_rad", 3),
    times("Nm_per_deg", 180.0 / PI),
    times("Nm_per_arcmin", 10_800.0 / PI),
    times("Nm_per_arcsec", 648_000.0 / PI),
];

impl Dimension {
    /// The units that are read, the SI unit first.
    pub(super) fn units(self) -> &'static [Unit] {
        match self {
            Self::Length => LENGTH,
            Self::Angle => ANGLE,
            Self::Force => FORCE,
            Self::Torque => TORQUE,
            Self::Stress => STRESS,
            Self::Time => TIME,
            Self::PerTime => PER_TIME,
            Self::PerAngle => PER_ANGLE,
            Self::PerAngleSquared => PER_ANGLE_SQUARED,
            Self::AnglePerTime => ANGLE_PER_TIME,
            Self::AnglePerTemperature => ANGLE_PER_TEMPERATURE,
            Self::AnglePerTorque => ANGLE_PER_TORQUE,
            Self::ForcePerLength => FORCE_PER_LENGTH,
            Self::ForcePerTemperature => FORCE_PER_TEMPERATURE,
            Self::PerTorque => PER_TORQUE,
            Self::TorquePerAngle => TORQUE_PER_ANGLE,
        }
    }
}

impl Unit {
    /// A number in this unit, in SI.
    pub(super) fn to_si(&self, value: f64) -> f64 {
        match self.scale {
            Scale::Shift(places) => shifted(value, places),
            Scale::HalfTurn(parts) => value / parts * PI,
            Scale::Times(si) => value * si,
        }
    }

    /// A number in SI, in this unit.
    pub(super) fn of_si(&self, value: f64) -> f64 {
        match self.scale {
            Scale::Shift(places) => shifted(value, -places),
            Scale::HalfTurn(parts) => value / PI * parts,
            Scale::Times(si) => value / si,
        }
    }
}

/// The value with its decimal point moved, rounded once.
fn shifted(value: f64, places: i32) -> f64 {
    if places == 0 { value } else { format!("{value}e{places}").parse().unwrap_or(f64::NAN) }
}

/// Whether any dimension has a unit that is written so.
pub(super) fn is_unit(suffix: &str) -> bool {
    let all = [
        LENGTH,
        ANGLE,
        FORCE,
        TORQUE,
        STRESS,
        TIME,
        PER_TIME,
        PER_ANGLE,
        PER_ANGLE_SQUARED,
        ANGLE_PER_TIME,
        ANGLE_PER_TEMPERATURE,
        ANGLE_PER_TORQUE,
        FORCE_PER_LENGTH,
        FORCE_PER_TEMPERATURE,
        PER_TORQUE,
        TORQUE_PER_ANGLE,
    ];
    all.into_iter().flatten().any(|unit| unit.suffix == suffix)
}
