//! Values that cannot be: each message names the number and what is allowed.

use super::Predictor;
use crate::effect::spec::{Dimension, Scale};
use crate::effect::{self, Spec};
use crate::error::{InvalidInput, require};
use crate::reducer::Reducer;

/// The effect of an id, if the reducer can have it.
pub fn known(reducer: &Reducer, place: usize, id: &str) -> Result<&'static Spec, InvalidInput> {
    let field = format!("effects[{place}]");
    let spec = effect::find(id).ok_or_else(|| {
        let ids: Vec<&str> = effect::LIBRARY.iter().map(|spec| spec.id).collect();
        InvalidInput::new(&field, id, format!("must be one of {}", ids.join(", ")))
    })?;
    match reducer.unsuited(spec) {
        None => Ok(spec),
        Some(why) => Err(InvalidInput::new(field, id, why)),
    }
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
            if let Some(drive) = self.reducer.ball_drive().filter(|_| parameter.stem == "ball") {
                let balls = drive.deceleration().ball_count;
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
            if parameter.stem == "friction_radius" && !self.rows.has_preload() {
                require(
                    *value == 0.0,
                    field(),
                    value,
                    "must be 0 where no preload was read; friction_torque_Nm does without",
                )?;
            }
            if parameter.stem.starts_with("planet_") && self.reducer.torsion_spring().is_some() {
                require(
                    *value == 0.0,
                    field(),
                    value,
                    "must be 0: a torsion spring has no planet that is known",
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
