//! What a load costs, as a block of another verb's answer.

use cbpt_core::cost::{Cost, Rubbing};
use cbpt_core::{Drive, InvalidInput, Load};
use serde_json::{Value, json};

use crate::report::{Report, number, object, six_digits};

/// Adds friction, safety and vibration at the load's angle; numbers are null where the load has no solution.
///
/// # Errors
/// [`InvalidInput`] for a coefficient or an inertia that cannot be.
pub fn add(report: &mut Report, drive: &Drive, load: &Load, rubbing: &Rubbing) -> Result<(), InvalidInput> {
    let wanted = rubbing.stated();
    let found = drive.costs(load, rubbing, &wanted)?;
    let told: Vec<String> = wanted.iter().zip(&found).map(|(cost, value)| told(*cost, *value)).collect();
    report.text += &format!(
        "\n\nFriction at this input angle, coefficient {} (`cbpt friction` has a period): {}",
        six_digits(rubbing.coefficient),
        told.join(", ")
    );
    let numbers =
        wanted.iter().zip(&found).map(|(cost, value)| (cost.name().to_owned(), number(Some(*value))));
    let block =
        object(std::iter::once(("coefficient".to_owned(), json!(rubbing.coefficient))).chain(numbers));
    if let Value::Object(entries) = &mut report.json {
        entries.insert("friction".to_owned(), block);
    }
    Ok(())
}

fn told(cost: Cost, value: f64) -> String {
    let (name, unit) = match cost {
        Cost::FrictionTorque => ("friction torque at the input", " N m"),
        Cost::Efficiency => ("efficiency", ""),
        Cost::Wear => ("wear", " N m per turn of the input"),
        Cost::StaticSafety => ("static safety", ""),
        Cost::NaturalFrequency => ("natural frequency", " Hz"),
    };
    if value.is_finite() {
        format!("{name} {}{unit}", six_digits(value))
    } else {
        format!("{name}: no solution")
    }
}
