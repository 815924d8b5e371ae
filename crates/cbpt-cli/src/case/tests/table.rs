//! The table of keys agrees with itself and with the mechanics.

use std::ops::Bound::{Excluded, Included, Unbounded};

use serde_json::{Value as Json, json};

use super::super::fields;
use super::super::keys::{self, Kind, Value};
use super::super::{Case, json_schema, key_table};

/// The required keys with the examples of the table, of a torsion spring or of a ball drive.
fn examples(spring: bool) -> Json {
    let mut case = json!({});
    let needed =
        |section: &&keys::Section| if spring { section.name == fields::SPRING } else { section.required };
    for section in fields::sections().iter().filter(needed) {
        for key in &section.keys {
            if matches!(key.need, keys::Need::Required | keys::Need::RequiredUnless(_)) {
                case[section.name][key.si()] = match &key.example {
                    Value::Real(number) => json!(number),
                    Value::Count(count) => json!(count),
                    Value::Text(text) => json!(text),
                    Value::Reals(numbers) => json!(numbers),
                };
            }
        }
    }
    case
}

#[test]
fn no_two_keys_are_written_alike_and_examples_are_allowed() {
    for section in fields::sections() {
        for key in &section.keys {
            for name in key.names() {
                let same =
                    section.keys.iter().flat_map(keys::Key::names).filter(|other| *other == name).count();
                assert_eq!(same, 1, "{}.{name}", section.name);
            }
            if let Value::Real(example) = key.example {
                assert!(key.allows(example), "{}.{}", section.name, key.stem);
            }
        }
    }
    Case::from_json(&examples(false)).unwrap();
    Case::from_json(&examples(true)).unwrap();
}

/// The ranges that editors and the reference show are the ones that are checked.
#[test]
fn the_table_allows_what_the_mechanics_allow() {
    for section in fields::sections().iter().filter(|section| section.name != "effect") {
        for key in section
            .keys
            .iter()
            .filter(|key| matches!(key.kind, Kind::Quantity(..) | Kind::Number | Kind::Count))
        {
            let accepts = |value: f64| {
                let mut case = examples(section.name == fields::SPRING);
                case[section.name][key.si()] = json!(value);
                Case::from_json(&case).is_ok()
            };
            let count = matches!(key.kind, Kind::Count);
            let above = |value: f64| if count { value + 1.0 } else { value.next_up() };
            let below = |value: f64| if count { value - 1.0 } else { value.next_down() };
            let low = match key.range.0 {
                Excluded(low) => !accepts(low) && accepts(above(low)),
                Included(low) => !accepts(below(low)) && accepts(low),
                Unbounded => accepts(-1e9),
            };
            let high = match key.range.1 {
                Excluded(high) => !accepts(high) && accepts(below(high)),
                Included(high) => !accepts(above(high)) && accepts(high),
                Unbounded => accepts(1e9),
            };
            assert!(low && high, "{}.{}", section.name, key.stem);
        }
    }
}

#[test]
fn schema_and_reference_hold_every_key() {
    let schema = json_schema();
    let page = key_table();
    for section in fields::sections().iter().filter(|section| section.name != "effect") {
        let object = if section.name.is_empty() { &schema } else { &schema["properties"][section.name] };
        assert_eq!(object["additionalProperties"], json!(false));
        for key in &section.keys {
            assert!(page.contains(&format!("| `{}` |", key.usual())), "{}", key.usual());
            for name in key.names() {
                assert!(object["properties"][&name]["description"].is_string(), "{name}");
            }
        }
    }
    let radius = &schema["properties"]["deceleration"]["properties"]["contact_angle_deg"];
    assert_eq!((&radius["exclusiveMinimum"], &radius["exclusiveMaximum"]), (&json!(0.0), &json!(90.0)));
    assert_eq!(
        schema["properties"]["equal_speed"]["properties"]["kind"]["enum"],
        json!(["ring_groove", "cross_slide"])
    );
}
