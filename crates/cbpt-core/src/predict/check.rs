//! Values that cannot be: each message names the number and what is allowed.

use super::Predictor;
use crate::effect::spec::{Dimension, Scale};
use crate::effect::{self, Spec};
use crate::error::{InvalidInput, require};

/// The effect of an id.
pub fn known(place: usize, id: &str) -> Result<&'static Spec, InvalidInput> {
    effect::find(id).ok_or_else(|| {
        let ids: Vec<&str> = effect::LIBRARY.iter().map(|spec| spec.id).collect();
        InvalidInput::new(format!("effects[{place}]"), id, format!("must be one of {}", ids.join(", ")))
    })
}

impl Predictor {
    pub(super) fn check_values(&self, values: &[f64]) -> Result<(), InvalidInput> {
        let count = self.slots.len();
        let rule = format!("must have {count} entries, one for each parameter");
        require(values.len() == count, "values", format!("{} entries", values.len()), &rule)?;
        for (place, (value, slot)) in values.iter().zip(&self.slots).enumerate() {
            let parameter = slot.parameter;
            let field = || format!("values[{place}], {} of {}", parameter.name(), self.name(slot.effect));
            let within = *value >= parameter.lower && *value <= parameter.upper;
            let rule = format!("must lie between {} and {}", parameter.lower, parameter.upper);
            require(value.is_finite() && within, field(), value, &rule)?;
            if parameter.scale == Scale::Fixed {
                require(value.fract() == 0.0, field(), value, "must be a whole number")?;
            }
            if parameter.stem == "ball" {
                let balls = self.drive.deceleration().ball_count;
                let rule = format!("must be below the number of deceleration balls, {balls}");
                require(*value < f64::from(balls), field(), value, &rule)?;
            }
            let thermal = matches!(
                parameter.dimension,
                Dimension::AnglePerTemperature | Dimension::ForcePerTemperature
            );
            if thermal && !self.rows.has_temperature() {
                require(*value == 0.0, field(), value, "must be 0 where no temperature was read")?;
            }
        }
        Ok(())
    }

    pub(super) fn check_wanted(&self, wanted: &[usize]) -> Result<(), InvalidInput> {
        for (place, &slot) in wanted.iter().enumerate() {
            let field = format!("wanted[{place}]");
            let rule = format!("must be below the number of parameters, {}", self.slots.len());
            require(slot < self.slots.len(), &field, slot, &rule)?;
            let fitted = self.slots[slot].parameter.scale != Scale::Fixed;
            require(
                fitted,
                &field,
                slot,
                "is a whole number that is chosen, so the angle has no derivative by it",
            )?;
        }
        Ok(())
    }
}
