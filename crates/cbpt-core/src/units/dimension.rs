//! Dimensions: what a number is a product of, whatever its unit.
//!
//! - [`Dimension`]: powers of metre, newton, second, kelvin and radian; products, quotients, powers, and how it is written;
//! - [`Quantity::dimension`]: the dimension of each quantity of the table.
//!
//! The newton stands in the place of the kilogram, because loads are forces here: 1 kg = 1 N s^2/m.

use std::fmt;

use super::Quantity;

/// Powers of metre, newton, second, kelvin and radian.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Dimension([f64; 5]);

/// Powers closer to each other than this are the same: a third, three times.
const ROUNDING: f64 = 1e-9;
/// The place of the radian.
const ANGLE: usize = 4;

impl Dimension {
    /// Of a plain number.
    pub const NUMBER: Self = Self([0.0; 5]);

    /// Of a product.
    #[must_use]
    pub fn times(self, other: Self) -> Self {
        self.joined(other, |one, other| one + other)
    }

    /// Of a quotient.
    #[must_use]
    pub fn over(self, other: Self) -> Self {
        self.joined(other, |one, other| one - other)
    }

    /// Of a power.
    #[must_use]
    pub fn power(self, power: f64) -> Self {
        Self(self.0.map(|one| one * power))
    }

    /// Whether a number of this dimension can stand where `wanted` is expected. As in SI an angle counts as a number, so
    /// `sin(angle)`, length over length and angle squared are angles too; an angle below the line, which nothing cancels, is none.
    pub fn fits(self, wanted: Self) -> bool {
        let same = (0..ANGLE).all(|base| (self.0[base] - wanted.0[base]).abs() < ROUNDING);
        same && self.0[ANGLE] > wanted.0[ANGLE].min(0.0) - ROUNDING
    }

    /// Whether it is that of a plain number.
    pub fn is_number(self) -> bool {
        self.is(Self::NUMBER)
    }

    /// What follows "it is" in a sentence: `in arcsec`, `a plain number`.
    pub fn in_words(self) -> String {
        if self.is_number() { self.to_string() } else { format!("in {self}") }
    }

    fn joined(self, other: Self, of: impl Fn(f64, f64) -> f64) -> Self {
        Self(std::array::from_fn(|base| of(self.0[base], other.0[base])))
    }

    fn is(self, other: Self) -> bool {
        self.0.iter().zip(other.0).all(|(one, other)| (one - other).abs() < ROUNDING)
    }
}

/// As a unit: the usual one of a quantity of the table, else SI with newton metres together.
impl fmt::Display for Dimension {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.is_number() {
            return f.write_str("a plain number");
        }
        if let Some(known) = Quantity::ALL.into_iter().find(|quantity| quantity.dimension().is(*self)) {
            let usual = known.usual();
            return f.write_str(if usual.offset == 0.0 { usual.written } else { known.si().written });
        }
        let [m, n, s, k, rad] = self.0;
        let (torque, m, n) = if (m - n).abs() < ROUNDING { (m, 0.0, 0.0) } else { (0.0, m, n) };
        // "N m" is read as the unit of torque and "m N" as the millinewton, so the one without a power stands last.
        let [first, last] =
            if (n.abs() - 1.0).abs() < ROUNDING { [("m", m), ("N", n)] } else { [("N", n), ("m", m)] };
        let powers = [("rad", rad), ("N m", torque), first, last, ("s", s), ("K", k)];
        let product = |sign: f64| -> Vec<String> {
            let here = powers.iter().filter(|(_, power)| power * sign > ROUNDING);
            here.map(|(unit, power)| raised(unit, power * sign)).collect()
        };
        let (above, below) = (product(1.0), product(-1.0));
        let above = if above.is_empty() { "1".into() } else { above.join(" ") };
        match below.as_slice() {
            [] => f.write_str(&above),
            [one] if one != "N m" => write!(f, "{above}/{one}"),
            several => write!(f, "{above}/({})", several.join(" ")),
        }
    }
}

fn raised(unit: &str, power: f64) -> String {
    let power = (power / ROUNDING).round() * ROUNDING;
    match unit {
        _ if (power - 1.0).abs() < ROUNDING => unit.into(),
        unit if unit.contains(' ') => format!("({unit})^{power}"),
        unit => format!("{unit}^{power}"),
    }
}

impl Quantity {
    /// What a number of this quantity is a product of.
    pub const fn dimension(self) -> Dimension {
        Dimension(match self {
            //                           m     N     s    K    rad
            Self::Number => [0.0, 0.0, 0.0, 0.0, 0.0],
            Self::Length => [1.0, 0.0, 0.0, 0.0, 0.0],
            Self::Angle => [0.0, 0.0, 0.0, 0.0, 1.0],
            Self::Force => [0.0, 1.0, 0.0, 0.0, 0.0],
            Self::Torque => [1.0, 1.0, 0.0, 0.0, 0.0],
            Self::Stress => [-2.0, 1.0, 0.0, 0.0, 0.0],
            Self::Time => [0.0, 0.0, 1.0, 0.0, 0.0],
            Self::Temperature => [0.0, 0.0, 0.0, 1.0, 0.0],
            Self::PerAngle => [0.0, 0.0, 0.0, 0.0, -1.0],
            Self::PerAngleSquared => [0.0, 0.0, 0.0, 0.0, -2.0],
            Self::PerTorque => [-1.0, -1.0, 0.0, 0.0, 0.0],
            Self::PerTime => [0.0, 0.0, -1.0, 0.0, 0.0],
            Self::PerTemperature => [0.0, 0.0, 0.0, -1.0, 0.0],
            Self::AnglePerTime => [0.0, 0.0, -1.0, 0.0, 1.0],
            Self::AnglePerTemperature => [0.0, 0.0, 0.0, -1.0, 1.0],
            Self::AnglePerTorque => [-1.0, -1.0, 0.0, 0.0, 1.0],
            Self::ForcePerLength => [-1.0, 1.0, 0.0, 0.0, 0.0],
            Self::ForcePerTemperature => [0.0, 1.0, 0.0, -1.0, 0.0],
            Self::TorquePerAngle => [1.0, 1.0, 0.0, 0.0, -1.0],
            Self::TorquePerTime => [1.0, 1.0, -1.0, 0.0, 0.0],
            Self::Mass => [-1.0, 1.0, 2.0, 0.0, 0.0],
            Self::Inertia => [1.0, 1.0, 2.0, 0.0, 0.0],
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::units::compound;

    /// The SI unit of a quantity is written as the product that its dimension says: `N m/rad`, `kg m^2`.
    #[test]
    fn the_dimension_of_a_quantity_is_that_of_its_unit_as_it_is_written() {
        let power = |text: &str| {
            let (base, power) = text.split_once('^').unwrap_or((text, "1"));
            let base = match base {
                "m" => Quantity::Length,
                "N" => Quantity::Force,
                "s" => Quantity::Time,
                "K" => Quantity::Temperature,
                "rad" => Quantity::Angle,
                "kg" => Quantity::Mass,
                _ => Quantity::Number,
            };
            base.dimension().power(power.parse().unwrap_or(f64::NAN))
        };
        let product = |text: &str| text.split(' ').map(power).fold(Dimension::NUMBER, Dimension::times);
        for quantity in Quantity::ALL {
            let written = quantity.si().written.replace("Pa", "N/m^2").replace(['(', ')'], "");
            let (above, below) = written.split_once('/').unwrap_or((&written, "1"));
            assert!(quantity.dimension().is(product(above).over(product(below))), "{quantity:?}");
        }
        assert!(Quantity::Mass.dimension().is(Dimension([-1.0, 1.0, 2.0, 0.0, 0.0])));
    }

    /// As a unit that is read back with the same dimension.
    #[test]
    fn a_dimension_is_written_as_a_unit() {
        for (unit, written) in [
            ("1", "a plain number"),
            ("rad", "arcsec"),
            ("arcsec/(N m)", "arcsec/(N m)"),
            ("rad/(N m)^2", "rad/(N m)^2"),
            ("N/um N m", "N^2"),
            ("degC/s", "K/s"),
            ("K", "K"),
            ("1/(N m s)", "1/(N m s)"),
            ("rad/(N m)/K", "rad/(N m K)"),
            ("rad/(N m)^2/K", "rad/((N m)^2 K)"),
            ("N^0.5", "N^0.5"),
            ("N (N m)", "N^2 m"),
            ("(N m)/m^0.5", "m^0.5 N"),
            ("m/K", "m/K"),
        ] {
            let found = compound::read(unit).map_or(Dimension::NUMBER, |unit| unit.dimension);
            assert_eq!(found.to_string(), written, "{unit}");
            if unit != "1" {
                assert!(compound::read(written).is_ok_and(|back| back.dimension.is(found)), "{written}");
            }
        }
    }

    #[test]
    fn an_angle_counts_as_a_number_but_not_below_the_line() {
        let of = |unit| compound::read(unit).map_or(Dimension::NUMBER, |unit| unit.dimension);
        for (unit, wanted, fits) in [
            ("1", "rad", true),
            ("um/m", "arcsec", true),
            ("rad^2", "rad", true),
            ("1/arcsec", "rad", false),
            ("N m/arcmin", "N m", false),
            ("N m", "N m/rad", true),
            ("1/rad", "1/arcsec", true),
            ("N", "rad", false),
        ] {
            assert_eq!(of(unit).fits(of(wanted)), fits, "{unit} as {wanted}");
        }
    }
}
