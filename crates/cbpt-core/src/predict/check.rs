//! Values that cannot be: each message names the number and what is allowed.

use super::{Effect, Number, Predictor, Rows};
use crate::effect;
use crate::effect::own::Variable;
use crate::effect::spec::Scale;
use crate::error::{InvalidInput, require};
use crate::reducer::Reducer;
use crate::units::Quantity;

/// The reducer can have an effect; one of the user's own has an id of its own and what it depends on.
pub fn suited(reducer: &Reducer, place: usize, effect: &Effect, rows: &Rows) -> Result<(), InvalidInput> {
    let own = match effect {
        Effect::Library(spec) => {
            let why = reducer.unsuited(spec);
            return why
                .map_or(Ok(()), |why| Err(InvalidInput::new(format!("effects[{place}]"), spec.id, why)));
        }
        Effect::Own(own) => own,
    };
    let rule = "is the id of an effect of the library; give the own effect another id";
    require(effect::find(own.id()).is_none(), "effect", own.id(), rule)?;
    let thermal = own.uses(Variable::TemperatureDifference);
    let rule = "depends on temperature_difference_K, but the readings have no temperature";
    require(!thermal || rows.has_temperature(), "effect", own.id(), rule)
}

impl Predictor {
    pub(super) fn check_values(&self, values: &[f64]) -> Result<(), InvalidInput> {
        let count = self.slots.len();
        let rule = format!("must have {count} entries, one for each parameter");
        require(values.len() == count, "values", format!("{} entries", values.len()), &rule)?;
        for (place, (value, slot)) in values.iter().zip(&self.slots).enumerate() {
            let field =
                || format!("values[{place}], {} of {}", slot.parameter.name(), self.name(slot.effect));
            let (lower, upper) = slot.parameter.limits();
            let within = *value >= lower && *value <= upper;
            let rule = format!("must lie between {lower} and {upper}");
            require(value.is_finite() && within, field(), value, &rule)?;
            let Number::Library(parameter) = slot.parameter else { continue };
            if parameter.scale == Scale::Fixed {
                require(value.fract() == 0.0, field(), value, "must be a whole number")?;
            }
            if let Some(drive) = self.reducer.ball_drive().filter(|_| parameter.stem == "ball") {
                let balls = drive.deceleration().ball_count;
                let rule = format!("must be below the number of deceleration balls, {balls}");
                require(*value < f64::from(balls), field(), value, &rule)?;
            }
            let thermal = matches!(
                parameter.quantity,
                Quantity::AnglePerTemperature | Quantity::ForcePerTemperature | Quantity::PerTemperature
            );
            if thermal && !self.rows.has_temperature() {
                require(
                    *value == 0.0,
                    field(),
                    value,
                    "must be 0, because the readings have no temperature",
                )?;
            }
            if parameter.stem == "friction_radius" && !self.rows.has_preload() {
                require(
                    *value == 0.0,
                    field(),
                    value,
                    "must be 0, because the readings have no preload; friction_torque_Nm needs none",
                )?;
            }
            if parameter.stem == "preload_exponent" && !self.rows.has_preload() {
                require(*value == 0.0, field(), value, "must be 0, because the readings have no preload")?;
            }
            if parameter.stem.starts_with("planet_") && self.reducer.torsion_spring().is_some() {
                require(
                    *value == 0.0,
                    field(),
                    value,
                    "must be 0: the model of a torsion spring has no planet",
                )?;
            }
        }
        Ok(())
    }

    pub(super) fn check_wanted(&self, wanted: &[usize]) -> Result<(), InvalidInput> {
        for (place, &slot) in wanted.iter().enumerate() {
            let field = format!("wanted[{place}]");
            let rule = format!("must be below the number of parameters, {}", self.slots.len());
            require(slot < self.slots.len(), &field, slot, &rule)?;
            let fitted = self.slots[slot].parameter.scale() != Scale::Fixed;
            require(fitted, &field, slot, "is a whole number, so there is no derivative with respect to it")?;
        }
        Ok(())
    }
}
