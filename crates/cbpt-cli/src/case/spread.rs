//! How the numbers of a case scatter, and numbers of a design by the keys of a case.

use cbpt_core::design::{Design, DesignNumber, NUMBERS};
use cbpt_core::{Drive, InvalidInput, Load};

use super::error::Mistake;
use super::keys::dotted;
use super::parameter::Parameter;
use super::{Case, fields};

/// How a number scatters.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Spread {
    /// Normally, with a standard uncertainty, SI.
    Normal(f64),
    /// Evenly within limits, plus or minus, SI.
    Uniform(f64),
}

impl Spread {
    /// Standard uncertainty, SI.
    pub fn u(self) -> f64 {
        match self {
            Self::Normal(u) => u,
            Self::Uniform(limit) => limit / 3.0_f64.sqrt(),
        }
    }

    /// `normal` or `uniform`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Normal(_) => "normal",
            Self::Uniform(_) => "uniform",
        }
    }

    /// The standard uncertainty, or the limit.
    pub fn size(self) -> f64 {
        match self {
            Self::Normal(size) | Self::Uniform(size) => size,
        }
    }
}

impl Case {
    /// The case with other values of these numbers of its drive and load, SI.
    ///
    /// # Errors
    /// [`InvalidInput`] for a case of another reducer, and for a number or value that cannot be.
    pub fn with_numbers(&self, numbers: &[(&'static DesignNumber, f64)]) -> Result<Self, InvalidInput> {
        let rule = "must be a ball drive; a torsion spring has no such numbers";
        let drive = self.drive().ok_or_else(|| InvalidInput::new("case", "another reducer", rule))?;
        let mut load = self.load;
        let stated = Load::new(
            load.torque_Nm.unwrap_or(0.0),
            load.preload_N.unwrap_or(1.0),
            load.input_angle_rad.unwrap_or(0.0),
        )?;
        let mut design = Design::of(drive, &stated);
        for (number, value) in numbers {
            design.suits(number)?;
            design.set(number, *value);
            match number.name {
                "load.torque_Nm" => load.torque_Nm = Some(*value),
                "load.preload_N" => load.preload_N = Some(*value),
                "load.input_angle_rad" => load.input_angle_rad = Some(*value),
                _ => {}
            }
        }
        Ok(Self { reducer: design.build()?.0.into(), load, ..self.clone() })
    }

    /// The numbers that scatter: within `[tolerance]`, else by `[uncertainty]`; those of the instruments and of the contact
    /// law are not of the drawing.
    ///
    /// # Errors
    /// [`InvalidInput`] for a spread of a common number whose two numbers differ.
    pub fn spreads(
        &self,
        drive: &Drive,
        load: &Load,
    ) -> Result<Vec<(&'static DesignNumber, Spread)>, InvalidInput> {
        let design = Design::of(drive, load);
        let mut found = Vec::new();
        for number in &NUMBERS {
            let limit = self.tolerance.get(number.name).map(|limit| Spread::Uniform(*limit));
            let normal = || self.uncertainty.of_drive.get(number.name).map(|u| Spread::Normal(*u));
            let Some(spread) = limit.or_else(normal).filter(|spread| spread.size() > 0.0) else { continue };
            design.suits(number)?;
            if design.get(number).is_none() {
                let rule = "stands for two numbers that differ; give a spread for each of them";
                return Err(InvalidInput::new(number.name, "a spread", rule));
            }
            found.push((number, spread));
        }
        Ok(found)
    }
}

/// A number's key in its usual unit, and one SI unit in it: `deceleration.ball_radius_mm` and 1000.
pub fn in_usual_unit(number: &DesignNumber) -> (String, f64) {
    let all =
        fields::sections().iter().flat_map(|section| section.keys.iter().map(move |key| (section, key)));
    let mut found = all.filter(|(section, key)| section.si_name(key) == number.name);
    // Every number is a key of a case.
    found.next().map_or((number.name.to_owned(), 1.0), |(section, key)| {
        (dotted(section.name, &key.usual()), key.usual_unit().of_si(1.0))
    })
}

/// The number of a design that a case writes so (`deceleration.ball_radius_mm`), and these values of it in SI.
///
/// # Errors
/// What is wrong with the key, with the nearest right one, or which value it cannot have.
#[allow(clippy::result_large_err)] // a mistake is told once
pub fn number_of_key(
    case: &Case,
    written: &str,
    values: &[f64],
) -> Result<(&'static DesignNumber, Vec<f64>), Mistake> {
    let parameter = Parameter::find(case, written)?;
    let found = NUMBERS.iter().find(|number| parameter.si_name() == Some(number.name));
    let number = found.ok_or_else(|| {
        let allowed: Vec<String> = NUMBERS.iter().map(|number| in_usual_unit(number).0).collect();
        Mistake {
            key: written.into(),
            problem: "is no number of a design".into(),
            allowed: format!("expected one of {}", allowed.join(", ")),
            ..Mistake::default()
        }
    })?;
    let si = |value: &f64| parameter.check_number(*value).map(|()| parameter.to_si(*value));
    Ok((number, values.iter().map(si).collect::<Result<_, _>>()?))
}
