//! Units that results are said in. Each is chosen by its suffix, the same that keys and columns end in.

use clap::ValueEnum;

/// Unit of small angles (elastic angles).
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum AngleUnit {
    /// Second of arc, pi/648000 rad.
    Arcsec,
    /// Minute of arc.
    Arcmin,
    /// Degree.
    Deg,
    /// Microradian.
    Urad,
    /// Milliradian.
    Mrad,
    /// Radian.
    Rad,
}

/// Unit of forces.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum ForceUnit {
    /// Newton.
    #[value(name = "N")]
    N,
    /// Kilonewton.
    #[value(name = "kN")]
    KiloN,
}

/// Unit of torques.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum TorqueUnit {
    /// Newton metre.
    #[value(name = "Nm")]
    Nm,
    /// Newton millimetre.
    #[value(name = "Nmm")]
    Nmm,
    /// Millinewton metre.
    #[value(name = "mNm")]
    MilliNm,
    /// Kilonewton metre.
    #[value(name = "kNm")]
    KiloNm,
}

/// Unit of deformations and contact ellipses.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum LengthUnit {
    /// Micrometre.
    Um,
    /// Nanometre.
    Nm,
    /// Millimetre.
    Mm,
    /// Metre.
    M,
}

/// Unit of pressures.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum PressureUnit {
    /// Gigapascal.
    #[value(name = "GPa")]
    GPa,
    /// Megapascal.
    #[value(name = "MPa")]
    MPa,
    /// Pascal.
    #[value(name = "Pa")]
    Pa,
}

/// A quantity in one of its units: its suffix and what one SI unit is in it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Unit {
    /// Suffix of keys and columns, for example `Nm`.
    pub suffix: &'static str,
    /// As it is written in a sentence, for example `N m`.
    pub name: &'static str,
    /// Value in this unit of one SI unit.
    pub per_si: f64,
}

impl Unit {
    const fn new(suffix: &'static str, per_si: f64) -> Self {
        Self { suffix, name: suffix, per_si }
    }

    const fn written(self, name: &'static str) -> Self {
        Self { name, ..self }
    }
}

/// Seconds of arc in a radian.
pub const ARCSEC_PER_RAD: f64 = 648_000.0 / std::f64::consts::PI;

impl AngleUnit {
    /// Suffix and factor.
    pub fn unit(self) -> Unit {
        match self {
            Self::Arcsec => Unit::new("arcsec", ARCSEC_PER_RAD),
            Self::Arcmin => Unit::new("arcmin", ARCSEC_PER_RAD / 60.0),
            Self::Deg => Unit::new("deg", ARCSEC_PER_RAD / 3600.0),
            Self::Urad => Unit::new("urad", 1e6),
            Self::Mrad => Unit::new("mrad", 1e3),
            Self::Rad => Unit::new("rad", 1.0),
        }
    }
}

impl ForceUnit {
    /// Suffix and factor.
    pub fn unit(self) -> Unit {
        match self {
            Self::N => Unit::new("N", 1.0),
            Self::KiloN => Unit::new("kN", 1e-3),
        }
    }
}

impl TorqueUnit {
    /// Suffix and factor.
    pub fn unit(self) -> Unit {
        match self {
            Self::Nm => Unit::new("Nm", 1.0).written("N m"),
            Self::Nmm => Unit::new("Nmm", 1e3).written("N mm"),
            Self::MilliNm => Unit::new("mNm", 1e3).written("mN m"),
            Self::KiloNm => Unit::new("kNm", 1e-3).written("kN m"),
        }
    }
}

impl LengthUnit {
    /// Suffix and factor.
    pub fn unit(self) -> Unit {
        match self {
            Self::Um => Unit::new("um", 1e6),
            Self::Nm => Unit::new("nm", 1e9),
            Self::Mm => Unit::new("mm", 1e3),
            Self::M => Unit::new("m", 1.0),
        }
    }
}

impl PressureUnit {
    /// Suffix and factor.
    pub fn unit(self) -> Unit {
        match self {
            Self::GPa => Unit::new("GPa", 1e-9),
            Self::MPa => Unit::new("MPa", 1e-6),
            Self::Pa => Unit::new("Pa", 1.0),
        }
    }
}
