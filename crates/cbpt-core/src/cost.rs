//! What a drive costs under one load, at its angle of the crank: numbers that every verb calls by the same names.
//!
//! - [`Cost`]: their names; [`Rubbing`]: what they need beside drive and load; [`Drive::costs`];
//! - [`Drive::cost_sensitivities`]: how they answer to design numbers, by central differences. Least dissipation has kinks, where other contacts
//!   slip, and so has the highest of many pressures; there the slopes to both sides differ, and the answer says so.

use crate::design::{Design, DesignNumber};
use crate::drive::{Drive, Load};
use crate::error::{InvalidInput, require};
use crate::friction::check_coefficient;
use crate::sensitivity::Sensitivity;
use crate::strength::{natural_frequency_Hz, static_safety};

/// A number that stands for what a drive costs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Cost {
    /// Friction torque at the input.
    FrictionTorque,
    /// Power at the output over power at the input.
    Efficiency,
    /// Archard's index for a turn of the input.
    Wear,
    /// Static safety s0 of the worst contact.
    StaticSafety,
    /// Torsional natural frequency, the input held.
    NaturalFrequency,
}

impl Cost {
    /// All of them.
    pub const ALL: [Self; 5] =
        [Self::FrictionTorque, Self::Efficiency, Self::Wear, Self::StaticSafety, Self::NaturalFrequency];

    /// Its name with its unit, which is that of SI.
    pub fn name(self) -> &'static str {
        match self {
            Self::FrictionTorque => "friction_torque_Nm",
            Self::Efficiency => "efficiency",
            Self::Wear => "wear_Nm_per_turn",
            Self::StaticSafety => "static_safety",
            Self::NaturalFrequency => "natural_frequency_Hz",
        }
    }

    /// By its name.
    pub fn find(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|cost| cost.name() == name)
    }

    fn is_of_friction(self) -> bool {
        matches!(self, Self::FrictionTorque | Self::Efficiency | Self::Wear)
    }
}

/// What costs need beside drive and load.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rubbing {
    /// Friction coefficient mu of every contact.
    pub coefficient: f64,
    /// Moment of inertia at the output, kg m^2; `None` where none is stated.
    pub output_inertia_kg_m2: Option<f64>,
}

impl Rubbing {
    /// The costs that it has what they need for.
    pub fn stated(&self) -> Vec<Cost> {
        let known = |cost: &Cost| *cost != Cost::NaturalFrequency || self.output_inertia_kg_m2.is_some();
        Cost::ALL.into_iter().filter(known).collect()
    }
}

/// Step of a difference, as a share of the number, or as such where the number is 0.
const STEP: f64 = 1e-5;
/// Slopes to both sides that differ by more than this share are those of a kink.
const KINK: f64 = 1e-2;
/// So does a difference of slopes of which a change of the number by itself would make more than this share of the result.
const NOTICED: f64 = 1e-4;

impl Drive {
    /// The costs that are wanted, in their order; NaN where the load has no solution or a number is not stated.
    ///
    /// # Errors
    /// [`InvalidInput`] for a coefficient or an inertia that cannot be.
    pub fn costs(&self, load: &Load, rubbing: &Rubbing, wanted: &[Cost]) -> Result<Vec<f64>, InvalidInput> {
        check_coefficient(rubbing.coefficient)?;
        if let Some(inertia) = rubbing.output_inertia_kg_m2 {
            let rule = "must be a finite number greater than 0";
            require(inertia.is_finite() && inertia > 0.0, "operation.output_inertia", inertia, rule)?;
        }
        let rubs = wanted.iter().any(|cost| cost.is_of_friction());
        let friction = rubs.then(|| self.friction(load, rubbing.coefficient)).transpose()?;
        let solution = wanted.iter().any(|cost| !cost.is_of_friction()).then(|| self.solve(load));
        let of = |cost: &Cost| match cost {
            Cost::FrictionTorque => friction.as_ref()?.torque_Nm(),
            Cost::Efficiency => friction.as_ref()?.efficiency(),
            Cost::Wear => friction.as_ref()?.wear_Nm_per_turn(),
            Cost::StaticSafety => {
                let pairs = solution.as_ref().map(|found| (&found.deceleration, &found.equal_speed))?;
                let highest = pairs.0.as_ref()?.peak_pressure_Pa.max(pairs.1.as_ref()?.peak_pressure_Pa);
                Some(static_safety(self.material().pressure_limit_Pa, highest))
            }
            Cost::NaturalFrequency => {
                let stiffness = solution.as_ref()?.torsional_stiffness_Nm_per_rad?;
                Some(natural_frequency_Hz(stiffness, rubbing.output_inertia_kg_m2?))
            }
        };
        Ok(wanted.iter().map(|cost| of(cost).unwrap_or(f64::NAN)).collect())
    }

    /// How costs answer to design numbers, the parts nominal, by central differences; `None` for a cost that the load does
    /// not have. Tied is a number at which the slopes to both sides differ.
    ///
    /// # Errors
    /// [`InvalidInput`] as [`Drive::costs`], and for a number that the drive does not have.
    pub fn cost_sensitivities(
        &self,
        load: &Load,
        rubbing: &Rubbing,
        wanted: &[Cost],
        numbers: &[&DesignNumber],
    ) -> Result<Vec<Option<Sensitivity>>, InvalidInput> {
        let nominal = self.nominal();
        let values = nominal.costs(load, rubbing, wanted)?;
        let mut found: Vec<Sensitivity> = values.iter().map(|value| Sensitivity::constant(*value)).collect();
        for number in numbers {
            let (step, [down, up]) = nominal.beside(load, rubbing, wanted, number)?;
            for (place, of_cost) in found.iter_mut().enumerate() {
                let (left, right) =
                    ((values[place] - down[place]) / step, (up[place] - values[place]) / step);
                let apart = (right - left).abs();
                let kink = apart > KINK * left.abs().max(right.abs())
                    && apart * step / STEP > NOTICED * values[place].abs();
                of_cost.slopes.push(0.5 * (left + right));
                of_cost.tied.push(kink);
            }
        }
        Ok(found.into_iter().map(|found| Some(found).filter(|found| found.value.is_finite())).collect())
    }

    /// The step of a number, and the costs a step below and above it.
    fn beside(
        &self,
        load: &Load,
        rubbing: &Rubbing,
        wanted: &[Cost],
        number: &DesignNumber,
    ) -> Result<(f64, [Vec<f64>; 2]), InvalidInput> {
        let design = Design::of(self, load);
        design.suits(number)?;
        let rule = "stands for two numbers that differ; name one of them";
        let value = design.get(number).ok_or_else(|| InvalidInput::new("number", number.name, rule))?;
        let step = if value == 0.0 { STEP } else { STEP * value.abs() };
        let at = |value: f64| {
            let mut other = design.clone();
            other.set(number, value);
            let (drive, load) = other.build()?;
            drive.costs(&load, rubbing, wanted)
        };
        Ok((step, [at(value - step)?, at(value + step)?]))
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::design::{find, numbers_of};

    const RUBBING: Rubbing = Rubbing { coefficient: 0.1, output_inertia_kg_m2: Some(1e-2) };

    fn slopes(cost: Cost, load: &Load, name: &str) -> Sensitivity {
        let drive = Drive::paper_base_case();
        let numbers = [find(name).unwrap()];
        let found = drive.cost_sensitivities(load, &RUBBING, &[cost], &numbers).unwrap();
        found.into_iter().next().flatten().unwrap()
    }

    #[test]
    fn the_natural_frequency_answers_as_the_root_of_the_stiffness() {
        let drive = Drive::paper_base_case();
        let load = Load::new(5.0, 600.0, 0.2).unwrap();
        for number in numbers_of(&drive, &load) {
            let found = slopes(Cost::NaturalFrequency, &load, number.name);
            let design = Design::of(&drive, &load);
            let value = design.get(number).unwrap();
            let stiffness = |share: f64| {
                let mut other = design.clone();
                other.set(number, value * share);
                let (drive, load) = other.build().unwrap();
                drive.solve(&load).torsional_stiffness_Nm_per_rad.unwrap()
            };
            let expected = (stiffness(1.001) / stiffness(0.999)).ln() / (1.001_f64 / 0.999).ln() / 2.0;
            let relative = found.slopes[0] * value / found.value;
            assert!((relative - expected).abs() < 1e-4, "{}: {relative} {expected}", number.name);
            assert!(!found.tied[0], "{}", number.name);
        }
    }

    #[test]
    fn a_kink_is_told() {
        // Static safety is even in the torque: without one its slopes have opposite signs.
        let load = Load::new(0.0, 600.0, 0.2).unwrap();
        assert!(slopes(Cost::StaticSafety, &load, "load.torque_Nm").tied[0]);
        assert!(!slopes(Cost::StaticSafety, &load, "load.preload_N").tied[0]);
    }

    #[test]
    fn what_is_not_stated_is_none() {
        let load = Load::new(5.0, 5.0, 0.0).unwrap();
        let drive = Drive::paper_base_case();
        assert!(drive.costs(&load, &RUBBING, &Cost::ALL).unwrap().iter().all(|cost| cost.is_nan()));
        let no_inertia = Rubbing { output_inertia_kg_m2: None, ..RUBBING };
        let load = Load::new(5.0, 600.0, 0.0).unwrap();
        let found = drive.costs(&load, &no_inertia, &Cost::ALL).unwrap();
        assert!(found[..4].iter().all(|cost| cost.is_finite()) && found[4].is_nan());
        let none = Rubbing { output_inertia_kg_m2: Some(0.0), ..RUBBING };
        assert!(drive.costs(&load, &none, &Cost::ALL).is_err());
    }
}
