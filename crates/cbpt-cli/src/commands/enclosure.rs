//! What `cbpt solve --certify` adds: the interval in which the solution was proved to lie.

use cbpt_core::enclosure::Enclosure;
use cbpt_core::interval::Interval;
use cbpt_core::units::Unit;
use serde_json::{Value, json};

use crate::report::Report;

/// Adds the proof, or that there is none, to the text and to the JSON document; without a solution the status says it all.
pub fn add(report: &mut Report, found: Option<&Enclosure>, angle: &Unit, solved: bool, with_effects: bool) {
    let of = if with_effects { "the elastic angle of the meshing points" } else { "the elastic angle" };
    report.text += &match found.filter(|_| solved) {
        Some(found) => {
            let [lower, upper] = bounds(found.elastic_angle_rad, angle);
            format!(
                "\n\nProved: the equations have one solution and no other, and {of} lies between\n  {lower} and\n  {upper} {}",
                angle.symbol
            )
        }
        None if !solved => String::new(),
        None => {
            "\n\nNot proved: no box around the solution could be shown to hold one and only one".to_owned()
        }
    };
    if let Value::Object(entries) = &mut report.json {
        entries.insert("enclosure".to_owned(), found.map_or(Value::Null, |found| document(found, angle)));
    }
}

/// Bounds in a unit, rounded outwards.
fn bounds(angle_rad: Interval, unit: &Unit) -> [f64; 2] {
    let shown = angle_rad.times_rounded(unit.per_si());
    [shown.lower(), shown.upper()]
}

fn document(found: &Enclosure, angle: &Unit) -> Value {
    let parts = [
        ("elastic_angle", found.elastic_angle_rad),
        ("alpha_deceleration", found.deceleration_rad),
        ("alpha_equal_speed", found.equal_speed_rad),
    ];
    let entry = |(name, of)| (format!("{name}_{}", angle.symbol), json!(bounds(of, angle)));
    crate::report::object(parts.map(entry))
}
