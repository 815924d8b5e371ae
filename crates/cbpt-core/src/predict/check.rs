//! Values that cannot be: each message names the number and what is allowed.

use super::{Effect, Number, Predictor, Rows, Slot};
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
        if values.len() != count {
            let rule = format!("must have {count} entries, one for each parameter");
            return Err(InvalidInput::new("values", format!("{} entries", values.len()), rule));
        }
        for (place, (value, slot)) in values.iter().zip(&self.slots).enumerate() {
            // Words only where one is wrong: a fit asks for a prediction of some hundred numbers again and again.
            if let Some(rule) = self.broken_rule(*value, slot) {
                let field =
                    format!("values[{place}], {} of {}", slot.parameter.name(), self.name(slot.effect));
                return Err(InvalidInput::new(field, value, rule));
            }
        }
        Ok(())
    }

    /// What a value of a number must be and is not.
    fn broken_rule(&self, value: f64, slot: &Slot) -> Option<String> {
        let (lower, upper) = slot.parameter.limits();
        if !(value.is_finite() && value >= lower && value <= upper) {
            return Some(format!("must lie between {lower} and {upper}"));
        }
        let Number::Library(parameter) = slot.parameter else { return None };
        if parameter.scale == Scale::Fixed && value.fract() != 0.0 {
            return Some("must be a whole number".to_owned());
        }
        if let Some(drive) = self.reducer.ball_drive().filter(|_| parameter.stem == "ball") {
            let balls = drive.deceleration().ball_count;
            if value >= f64::from(balls) {
                return Some(format!("must be below the number of deceleration balls, {balls}"));
            }
        }
        if value == 0.0 {
            return None;
        }
        let thermal = matches!(
            parameter.quantity,
            Quantity::AnglePerTemperature | Quantity::ForcePerTemperature | Quantity::PerTemperature
        );
        if thermal && !self.rows.has_temperature() {
            return Some("must be 0, because the readings have no temperature".to_owned());
        }
        if parameter.stem == "friction_radius" && !self.rows.has_preload() {
            let rule = "must be 0, because the readings have no preload; friction_torque_Nm needs none";
            return Some(rule.to_owned());
        }
        if parameter.stem == "preload_exponent" && !self.rows.has_preload() {
            return Some("must be 0, because the readings have no preload".to_owned());
        }
        if parameter.stem.starts_with("planet_") && self.reducer.torsion_spring().is_some() {
            return Some("must be 0: the model of a torsion spring has no planet".to_owned());
        }
        None
    }

    pub(super) fn check_wanted(&self, wanted: &[usize]) -> Result<(), InvalidInput> {
        for (place, &slot) in wanted.iter().enumerate() {
            let wrong = |rule: String| Err(InvalidInput::new(format!("wanted[{place}]"), slot, rule));
            if slot >= self.slots.len() {
                return wrong(format!("must be below the number of parameters, {}", self.slots.len()));
            }
            if self.slots[slot].parameter.scale() == Scale::Fixed {
                return wrong("is a whole number, so there is no derivative with respect to it".to_owned());
            }
        }
        Ok(())
    }
}
