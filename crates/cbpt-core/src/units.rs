//! The one table of units. Effects, keys of case files, flags, columns of readings and the page all read it.
//!
//! - [`Quantity`]: what a number measures, with its units ([`Quantity::units`], SI first);
//! - [`Unit`]: a unit, how it is written, and its exact way to SI;
//! - [`all`]: every unit of every quantity;
//! - [`compound`]: units made of those of the table, as `arcsec/(N m)`;
//! - [`dimension`]: what a number is a product of, whatever its unit.
//!
//! Each unit is 10^d n/m pi^k times the SI unit with whole numbers n and m, so a conversion is rounded once:
//! 1.2 mm, 1200 um and 0.0012 m are one number. Sources: SI brochure (BIPM 2019), tables 4 to 8; pound-force and inch:
//! NIST SP 811 (2008), appendix B.8.

pub mod compound;
pub mod dimension;

use std::f64::consts::PI;

/// What a number measures.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[allow(missing_docs)] // the words say it
pub enum Quantity {
    Number,
    Length,
    Angle,
    Force,
    Torque,
    Stress,
    Time,
    Temperature,
    PerAngle,
    PerAngleSquared,
    PerTorque,
    PerTime,
    PerTemperature,
    AnglePerTime,
    AnglePerTemperature,
    AnglePerTorque,
    ForcePerLength,
    ForcePerTemperature,
    TorquePerAngle,
    TorquePerTime,
    Mass,
    Inertia,
}

/// A unit of a quantity: 10^`decimal` `numerator`/`denominator` pi^`pi` of the SI unit, and an offset.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Unit {
    /// What it measures.
    pub quantity: Quantity,
    /// Suffix of names, keys and columns, as in `torque_Nm`; empty for plain numbers.
    pub symbol: &'static str,
    /// How it is written in a sentence, as in `5 N m`.
    pub written: &'static str,
    /// Other spellings that are accepted, written here without blanks, dots and hyphens between their parts.
    pub spellings: &'static [&'static str],
    /// SI value of 0 in this unit; only the degree Celsius has one.
    pub offset: f64,
    decimal: i32,
    numerator: u64,
    denominator: u64,
    pi: i32,
}

/// How numbers in one unit become numbers in another: times `times`, divided by `over`, plus `plus`.
///
/// `times` and `over` are whole numbers without a common divisor where pi is no part of the conversion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Conversion {
    /// Factor.
    pub times: f64,
    /// Divisor; 1 where a factor alone does.
    pub over: f64,
    /// Summand, in the unit converted to.
    pub plus: f64,
}

impl Quantity {
    /// Every quantity, in the order of [`all`].
    pub const ALL: [Self; 22] = [
        Self::Number,
        Self::Length,
        Self::Angle,
        Self::Force,
        Self::Torque,
        Self::Stress,
        Self::Time,
        Self::Temperature,
        Self::PerAngle,
        Self::PerAngleSquared,
        Self::PerTorque,
        Self::PerTime,
        Self::PerTemperature,
        Self::AnglePerTime,
        Self::AnglePerTemperature,
        Self::AnglePerTorque,
        Self::ForcePerLength,
        Self::ForcePerTemperature,
        Self::TorquePerAngle,
        Self::TorquePerTime,
        Self::Mass,
        Self::Inertia,
    ];

    /// Its name: `angle`, `torque per angle`.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Number => "number",
            Self::Length => "length",
            Self::Angle => "angle",
            Self::Force => "force",
            Self::Torque => "torque",
            Self::Stress => "stress",
            Self::Time => "time",
            Self::Temperature => "temperature",
            Self::PerAngle => "per angle",
            Self::PerAngleSquared => "per angle squared",
            Self::PerTorque => "per torque",
            Self::PerTime => "per time",
            Self::PerTemperature => "per temperature",
            Self::AnglePerTime => "angle per time",
            Self::AnglePerTemperature => "angle per temperature",
            Self::AnglePerTorque => "angle per torque",
            Self::ForcePerLength => "force per length",
            Self::ForcePerTemperature => "force per temperature",
            Self::TorquePerAngle => "torque per angle",
            Self::TorquePerTime => "torque per time",
            Self::Mass => "mass",
            Self::Inertia => "moment of inertia",
        }
    }

    /// The units that are read, the SI unit first.
    pub const fn units(self) -> &'static [Unit] {
        match self {
            Self::Number => NUMBER,
            Self::Length => LENGTH,
            Self::Angle => ANGLE,
            Self::Force => FORCE,
            Self::Torque => TORQUE,
            Self::Stress => STRESS,
            Self::Time => TIME,
            Self::Temperature => TEMPERATURE,
            Self::PerAngle => PER_ANGLE,
            Self::PerAngleSquared => PER_ANGLE_SQUARED,
            Self::PerTorque => PER_TORQUE,
            Self::PerTime => PER_TIME,
            Self::PerTemperature => PER_TEMPERATURE,
            Self::AnglePerTime => ANGLE_PER_TIME,
            Self::AnglePerTemperature => ANGLE_PER_TEMPERATURE,
            Self::AnglePerTorque => ANGLE_PER_TORQUE,
            Self::ForcePerLength => FORCE_PER_LENGTH,
            Self::ForcePerTemperature => FORCE_PER_TEMPERATURE,
            Self::TorquePerAngle => TORQUE_PER_ANGLE,
            Self::TorquePerTime => TORQUE_PER_TIME,
            Self::Mass => MASS,
            Self::Inertia => INERTIA,
        }
    }

    /// The SI unit.
    pub const fn si(self) -> &'static Unit {
        &self.units()[0]
    }

    /// The unit of a symbol; `None` where the quantity has no such unit.
    pub fn unit(self, symbol: &str) -> Option<&'static Unit> {
        self.units().iter().find(|unit| unit.symbol == symbol)
    }

    /// The unit in which people read results and parameters of effects.
    pub fn usual(self) -> &'static Unit {
        let symbol = match self {
            Self::Length => "um",
            Self::Angle => "arcsec",
            Self::Stress => "GPa",
            Self::Temperature => "degC",
            Self::PerAngle => "per_arcsec",
            Self::PerAngleSquared => "per_arcsec2",
            Self::PerTime => "per_h",
            Self::AnglePerTime => "arcsec_per_h",
            Self::AnglePerTemperature => "arcsec_per_K",
            Self::AnglePerTorque => "arcsec_per_Nm",
            Self::ForcePerLength => "N_per_um",
            Self::TorquePerAngle => "Nm_per_arcmin",
            Self::TorquePerTime => "Nm_per_h",
            Self::Number
            | Self::Force
            | Self::Torque
            | Self::Time
            | Self::PerTorque
            | Self::PerTemperature
            | Self::ForcePerTemperature
            | Self::Mass
            | Self::Inertia => return self.si(),
        };
        self.unit(symbol).unwrap_or(self.si())
    }
}

/// Every unit, quantity by quantity.
pub fn all() -> impl Iterator<Item = &'static Unit> {
    Quantity::ALL.into_iter().flat_map(Quantity::units)
}

impl Unit {
    /// SI value of one unit, without the offset.
    pub const fn size(&self) -> f64 {
        let Conversion { times, over, .. } = ratio(self, self.quantity.si());
        times / over
    }

    /// Value in this unit of one SI unit, without the offset.
    pub const fn per_si(&self) -> f64 {
        let Conversion { times, over, .. } = ratio(self.quantity.si(), self);
        times / over
    }

    /// A number in this unit, in SI.
    pub fn to_si(&self, value: f64) -> f64 {
        let plain = shifted(value, self.decimal) * self.times() / self.over();
        self.moved(match self.pi {
            0 => plain,
            1 => plain * PI,
            -1 => plain / PI,
            power => plain * PI.powi(power),
        })
    }

    /// A number in SI, in this unit.
    pub fn of_si(&self, value: f64) -> f64 {
        let value = if self.offset == 0.0 { value } else { value - self.offset };
        let plain = match self.pi {
            0 => value,
            1 => value / PI,
            -1 => value * PI,
            power => value / PI.powi(power),
        };
        shifted(plain * self.over() / self.times(), -self.decimal)
    }

    /// The conversion to another unit; `None` where it measures another quantity.
    pub fn conversion(&self, to: &Self) -> Option<Conversion> {
        let plus = (self.offset - to.offset) * to.per_si();
        (self.quantity == to.quantity).then(|| Conversion { plus, ..ratio(self, to) })
    }

    /// A stem with this unit, as names, keys and columns have it: `torque_Nm`; the stem alone for a plain number.
    pub fn name(&self, stem: &str) -> String {
        if self.symbol.is_empty() { stem.to_owned() } else { format!("{stem}_{}", self.symbol) }
    }

    fn moved(&self, value: f64) -> f64 {
        if self.offset == 0.0 { value } else { value + self.offset }
    }

    const fn times(&self) -> f64 {
        self.numerator as f64
    }

    const fn over(&self) -> f64 {
        self.denominator as f64
    }

    const fn written(self, written: &'static str) -> Self {
        Self { written, ..self }
    }

    const fn spelled(self, spellings: &'static [&'static str]) -> Self {
        Self { spellings, ..self }
    }
}

/// The value with its decimal point moved, rounded once.
fn shifted(value: f64, places: i32) -> f64 {
    if places == 0 { value } else { format!("{value}e{places}").parse().unwrap_or(f64::NAN) }
}

/// The ratio of two units without their offsets.
const fn ratio(from: &Unit, to: &Unit) -> Conversion {
    let mut times = from.numerator as u128 * to.denominator as u128;
    let mut over = from.denominator as u128 * to.numerator as u128;
    let places = from.decimal - to.decimal;
    if places >= 0 {
        times *= 10_u128.pow(places.unsigned_abs());
    } else {
        over *= 10_u128.pow(places.unsigned_abs());
    }
    let common = common_divisor(times, over);
    let (times, over) = ((times / common) as f64, (over / common) as f64);
    match from.pi - to.pi {
        0 => Conversion { times, over, plus: 0.0 },
        1 => Conversion { times: PI * times / over, over: 1.0, plus: 0.0 },
        2 => Conversion { times: PI * PI * times / over, over: 1.0, plus: 0.0 },
        -1 => Conversion { times: times / over / PI, over: 1.0, plus: 0.0 },
        _ => Conversion { times: times / over / (PI * PI), over: 1.0, plus: 0.0 },
    }
}

const fn common_divisor(mut a: u128, mut b: u128) -> u128 {
    while b > 0 {
        (a, b) = (b, a % b);
    }
    a
}

/// Builds the units of one quantity.
#[derive(Clone, Copy)]
struct Of(Quantity);

impl Of {
    /// 10^`decimal` of the SI unit.
    const fn tens(self, symbol: &'static str, decimal: i32) -> Unit {
        Unit {
            quantity: self.0,
            symbol,
            written: symbol,
            spellings: &[],
            offset: 0.0,
            decimal,
            numerator: 1,
            denominator: 1,
            pi: 0,
        }
    }

    /// `numerator`/`denominator` of the SI unit.
    const fn parts(self, symbol: &'static str, numerator: u64, denominator: u64) -> Unit {
        Unit { numerator, denominator, ..self.tens(symbol, 0) }
    }

    /// pi `numerator`/`denominator` of the SI unit.
    const fn turns(self, symbol: &'static str, numerator: u64, denominator: u64) -> Unit {
        Unit { pi: 1, ..self.parts(symbol, numerator, denominator) }
    }

    /// `parts`/pi of the SI unit, to a power.
    const fn per_turn(self, symbol: &'static str, parts: u64, power: i32) -> Unit {
        Unit { pi: -power, ..self.parts(symbol, parts, 1) }
    }
}

/// Seconds of arc in half a turn.
const ARCSECS: u64 = 648_000;

/// A pound-force (0.45359237 kg times 9.80665 m/s^2), in 1e-13 N.
const POUND_FORCE: u64 = 44_482_216_152_605;

/// A pound-force times 0.0254 m, in 1e-16 N m.
const POUND_FORCE_INCH: u64 = 1_129_848_290_276_167;

/// One degree, rad.
pub const DEGREE: f64 = PI / 180.0;

/// One second of arc, rad.
pub const ARCSEC: f64 = PI / ARCSECS as f64;

/// Seconds of arc in a radian.
pub const ARCSEC_PER_RAD: f64 = ARCSECS as f64 / PI;

const NUMBER: &[Unit] = &[Of(Quantity::Number).tens("", 0)];

const LENGTH: &[Unit] = {
    const L: Of = Of(Quantity::Length);
    &[
        L.tens("m", 0).spelled(&["metre", "metres", "meter", "meters"]),
        L.tens("cm", -2).spelled(&["centimetre", "centimetres", "centimeter", "centimeters"]),
        L.tens("mm", -3).spelled(&["millimetre", "millimetres", "millimeter", "millimeters"]),
        L.tens("um", -6).spelled(&[
            "μm",
            "micron",
            "microns",
            "micrometre",
            "micrometres",
            "micrometer",
            "micrometers",
        ]),
        L.tens("nm", -9).spelled(&["nanometre", "nanometres", "nanometer", "nanometers"]),
    ]
};

const ANGLE: &[Unit] = {
    const A: Of = Of(Quantity::Angle);
    &[
        A.tens("rad", 0).spelled(&["rads", "radian", "radians"]),
        A.tens("mrad", -3).spelled(&["milliradian", "milliradians"]),
        A.tens("urad", -6).spelled(&["μrad", "microrad", "microradian", "microradians"]),
        A.turns("deg", 1, 180).spelled(&["degs", "degree", "degrees", "°"]),
        A.turns("arcmin", 1, 10_800).spelled(&["arcmins", "arcminute", "arcminutes", "amin", "′", "'"]),
        A.turns("arcsec", 1, ARCSECS).spelled(&[
            "arcsecs",
            "arcsecond",
            "arcseconds",
            "asec",
            "′′",
            "''",
            "\"",
        ]),
    ]
};

const FORCE: &[Unit] = {
    const F: Of = Of(Quantity::Force);
    &[
        F.tens("N", 0).spelled(&["newton", "newtons"]),
        F.tens("mN", -3).spelled(&["millinewton", "millinewtons"]),
        F.tens("kN", 3).spelled(&["kilonewton", "kilonewtons"]),
        Unit { decimal: -13, ..F.parts("lbf", POUND_FORCE, 1) }.spelled(&["lbs", "poundforce"]),
    ]
};

const TORQUE: &[Unit] = {
    const T: Of = Of(Quantity::Torque);
    &[
        T.tens("Nm", 0).written("N m").spelled(&[
            "newtonmetre",
            "newtonmetres",
            "newtonmeter",
            "newtonmeters",
        ]),
        T.tens("Ncm", -2).written("N cm").spelled(&["cNm"]),
        T.tens("Nmm", -3).written("N mm"),
        T.tens("mNm", -3).written("mN m"),
        T.tens("kNm", 3).written("kN m"),
        Unit { decimal: -16, ..T.parts("lbf_in", POUND_FORCE_INCH, 1) }
            .written("lbf in")
            .spelled(&["lbfin", "inlbf", "lbin", "inlb"]),
        Unit { decimal: -16, ..T.parts("lbf_ft", 12 * POUND_FORCE_INCH, 1) }
            .written("lbf ft")
            .spelled(&["lbfft", "ftlbf", "lbft", "ftlb"]),
    ]
};

const STRESS: &[Unit] = {
    const P: Of = Of(Quantity::Stress);
    &[P.tens("Pa", 0), P.tens("kPa", 3), P.tens("MPa", 6), P.tens("GPa", 9)]
};

const TIME: &[Unit] = {
    const T: Of = Of(Quantity::Time);
    &[
        T.tens("s", 0).spelled(&["sec", "secs", "second", "seconds"]),
        T.tens("ms", -3).spelled(&["msec", "millisecond", "milliseconds"]),
        T.parts("min", 60, 1).spelled(&["mins", "minute", "minutes"]),
        T.parts("h", 3600, 1).spelled(&["hr", "hrs", "hour", "hours"]),
    ]
};

const TEMPERATURE: &[Unit] = {
    const T: Of = Of(Quantity::Temperature);
    &[
        T.tens("K", 0).spelled(&["kelvin"]),
        Unit { offset: 273.15, ..T.tens("degC", 0).spelled(&["°C", "C", "celsius", "degcelsius"]) },
    ]
};

const PER_ANGLE: &[Unit] = {
    const R: Of = Of(Quantity::PerAngle);
    &[
        R.tens("per_rad", 0).written("1/rad"),
        R.tens("per_mrad", 3).written("1/mrad"),
        R.per_turn("per_arcsec", ARCSECS, 1).written("1/arcsec"),
    ]
};

const PER_ANGLE_SQUARED: &[Unit] = {
    const R: Of = Of(Quantity::PerAngleSquared);
    &[
        R.tens("per_rad2", 0).written("1/rad^2"),
        R.tens("per_mrad2", 6).written("1/mrad^2"),
        R.per_turn("per_arcsec2", ARCSECS * ARCSECS, 2).written("1/arcsec^2"),
    ]
};

const PER_TORQUE: &[Unit] = {
    const R: Of = Of(Quantity::PerTorque);
    &[R.tens("per_Nm", 0).written("1/(N m)"), R.tens("per_kNm", -3).written("1/(kN m)")]
};

const PER_TIME: &[Unit] = {
    const R: Of = Of(Quantity::PerTime);
    &[
        R.tens("per_s", 0).written("1/s"),
        R.parts("per_min", 1, 60).written("1/min"),
        R.parts("per_h", 1, 3600).written("1/h"),
    ]
};

const PER_TEMPERATURE: &[Unit] = {
    const R: Of = Of(Quantity::PerTemperature);
    &[R.tens("per_K", 0).written("1/K")]
};

const ANGLE_PER_TIME: &[Unit] = {
    const R: Of = Of(Quantity::AnglePerTime);
    &[
        R.tens("rad_per_s", 0).written("rad/s"),
        R.tens("urad_per_s", -6).written("urad/s"),
        R.turns("arcsec_per_s", 1, ARCSECS).written("arcsec/s"),
        R.turns("arcsec_per_min", 1, ARCSECS * 60).written("arcsec/min"),
        R.turns("arcsec_per_h", 1, ARCSECS * 3600).written("arcsec/h"),
        R.turns("rpm", 1, 30).spelled(&["rev/min", "r/min"]),
    ]
};

const ANGLE_PER_TEMPERATURE: &[Unit] = {
    const R: Of = Of(Quantity::AnglePerTemperature);
    &[
        R.tens("rad_per_K", 0).written("rad/K"),
        R.tens("urad_per_K", -6).written("urad/K"),
        R.turns("arcsec_per_K", 1, ARCSECS).written("arcsec/K"),
    ]
};

const ANGLE_PER_TORQUE: &[Unit] = {
    const R: Of = Of(Quantity::AnglePerTorque);
    &[
        R.tens("rad_per_Nm", 0).written("rad/(N m)"),
        R.tens("urad_per_Nm", -6).written("urad/(N m)"),
        R.turns("arcsec_per_Nm", 1, ARCSECS).written("arcsec/(N m)"),
    ]
};

const FORCE_PER_LENGTH: &[Unit] = {
    const R: Of = Of(Quantity::ForcePerLength);
    &[
        R.tens("N_per_m", 0).written("N/m"),
        R.tens("N_per_mm", 3).written("N/mm"),
        R.tens("N_per_um", 6).written("N/um"),
        R.tens("kN_per_mm", 6).written("kN/mm"),
    ]
};

const FORCE_PER_TEMPERATURE: &[Unit] = {
    const R: Of = Of(Quantity::ForcePerTemperature);
    &[R.tens("N_per_K", 0).written("N/K"), R.tens("kN_per_K", 3).written("kN/K")]
};

const TORQUE_PER_ANGLE: &[Unit] = {
    const R: Of = Of(Quantity::TorquePerAngle);
    &[
        R.tens("Nm_per_rad", 0).written("N m/rad"),
        R.tens("kNm_per_rad", 3).written("kN m/rad"),
        R.per_turn("Nm_per_deg", 180, 1).written("N m/deg"),
        R.per_turn("Nm_per_arcmin", 10_800, 1).written("N m/arcmin"),
        R.per_turn("Nm_per_arcsec", ARCSECS, 1).written("N m/arcsec"),
    ]
};

const TORQUE_PER_TIME: &[Unit] = {
    const R: Of = Of(Quantity::TorquePerTime);
    &[
        R.tens("Nm_per_s", 0).written("N m/s"),
        R.parts("Nm_per_min", 1, 60).written("N m/min"),
        R.parts("Nm_per_h", 1, 3600).written("N m/h"),
    ]
};

const MASS: &[Unit] = {
    const M: Of = Of(Quantity::Mass);
    &[M.tens("kg", 0), M.tens("g", -3)]
};

const INERTIA: &[Unit] = {
    const J: Of = Of(Quantity::Inertia);
    &[
        J.tens("kg_m2", 0).written("kg m^2"),
        J.tens("kg_cm2", -4).written("kg cm^2"),
        J.tens("g_cm2", -7).written("g cm^2"),
    ]
};

#[cfg(test)]
mod tests;
