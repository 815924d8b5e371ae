//! The table of keys as a JSON Schema for editors and as a page to read.

use std::fmt::Write;
use std::ops::Bound::{Excluded, Included, Unbounded};

use cbpt_core::effect::Spec;
use serde_json::{Map, Value as Json, json};

use cbpt_core::units::Unit;

use super::fields::{self, PARAMETERS};
use super::keys::{Key, Kind, Need, Section, Value};
use super::library::{self, EFFECTS};

/// JSON Schema (draft 2020-12) of case files.
pub fn json_schema() -> Json {
    let mut properties = properties(fields::top());
    for section in fields::sections().iter().filter(|section| !section.name.is_empty()) {
        let schema = match section.name {
            "effect" => json!({"type": "array", "description": section.meaning, "items": effect(section)}),
            _ => table(section),
        };
        properties.insert(section.name.into(), schema);
    }
    let required: Vec<&str> =
        fields::sections().iter().filter(|section| section.required).map(|section| section.name).collect();
    let foreign: Map<String, Json> = fields::DRIVE
        .into_iter()
        .chain(["track_curvature"])
        .map(|name| (name.into(), false.into()))
        .collect();
    json!({
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "Case file of a cycloid ball planetary transmission, or of another reducer that is described as a torsion spring",
        "type": "object",
        "properties": properties,
        "if": {"required": [fields::SPRING]},
        "then": {"properties": foreign},
        "else": {"required": required},
        "additionalProperties": false,
    })
}

fn table(section: &'static Section) -> Json {
    let plain =
        section.keys.iter().filter(|key| matches!(key.need, Need::Required) && key.units().len() == 1);
    let required: Vec<&str> = plain.map(|key| &*key.stem).collect();
    let mut rules: Vec<Json> = section.keys.iter().filter_map(|key| rule(section, key)).collect();
    rules.extend(foreign(section, "ring_groove"));
    rules.extend(foreign(section, "cross_slide"));
    let mut properties = properties(section);
    if section.of_numbers() {
        properties.extend(by_section(section));
    }
    let mut schema = json!({
        "type": "object",
        "description": section.meaning,
        "properties": properties,
        "required": required,
        "additionalProperties": false,
    });
    if !rules.is_empty() {
        schema["allOf"] = rules.into();
    }
    schema
}

/// The keys about numbers of other sections as tables of those: `deceleration.ball_radius_um`.
fn by_section(section: &'static Section) -> Map<String, Json> {
    let all = properties(section);
    let of = |name: &'static str| {
        let short = |(key, schema): (&String, &Json)| {
            let short = key.strip_prefix(name)?.strip_prefix('_')?;
            Some((short.to_owned(), schema.clone()))
        };
        let keys: Map<String, Json> = all.iter().filter_map(short).collect();
        let table = json!({"type": "object", "properties": keys, "additionalProperties": false});
        (!keys.is_empty()).then(|| (name.to_owned(), table))
    };
    fields::DRIVE.into_iter().chain(["load"]).filter_map(of).collect()
}

/// Built-in effects take the numbers of their ids, own effects what the table says.
fn effect(section: &'static Section) -> Json {
    let mut own = properties(section);
    own.insert(
        PARAMETERS.into(),
        json!({
            "type": "object",
            "propertyNames": {"pattern": "^[A-Za-z_][A-Za-z0-9_]*$"},
            "additionalProperties": table(fields::parameter()),
        }),
    );
    own["id"]["not"] = json!({"enum": *EFFECTS});
    let of_id = |(spec, section): (&Spec, &'static Section)| {
        let mut keys = table(section);
        keys["properties"]["id"] = json!({"const": spec.id});
        keys["properties"]["port"] = json!({"const": spec.port.name()});
        json!({"if": {"properties": {"id": {"const": spec.id}}}, "then": keys})
    };
    let built_in: Vec<Json> = library::built_in().map(of_id).collect();
    json!({
        "type": "object",
        "required": ["id"],
        "if": {"required": ["expression"]},
        "then": {"properties": own, "required": ["port"], "additionalProperties": false},
        "else": {
            "properties": {"id": {"description": "id of a built-in effect", "enum": *EFFECTS}},
            "allOf": built_in,
        },
    })
}

/// Every way to write every key.
fn properties(section: &'static Section) -> Map<String, Json> {
    let ways = |key: &'static Key| key.units().iter().map(move |unit| (key.with(unit), property(key, unit)));
    section.keys.iter().flat_map(ways).collect()
}

fn property(key: &Key, unit: &Unit) -> Json {
    let mut schema = json!({"description": key.meaning});
    match key.kind {
        Kind::Quantity(..) | Kind::Number => schema["type"] = "number".into(),
        Kind::Quantities(..) => {
            schema["type"] = "array".into();
            schema["items"] = json!({"type": "number"});
        }
        Kind::Count => schema["type"] = "integer".into(),
        Kind::Choice(words) => schema["enum"] = words.into(),
        Kind::Text => schema["type"] = "string".into(),
        Kind::Parameters => schema["type"] = "object".into(),
    }
    match key.range.0 {
        Excluded(low) => schema["exclusiveMinimum"] = unit.of_si(low).into(),
        Included(low) => schema["minimum"] = unit.of_si(low).into(),
        Unbounded => {}
    }
    match key.range.1 {
        Excluded(high) => schema["exclusiveMaximum"] = unit.of_si(high).into(),
        Included(high) => schema["maximum"] = unit.of_si(high).into(),
        Unbounded => {}
    }
    if let Need::Default(value) = &key.need {
        schema["default"] = match value {
            Value::Real(value) => unit.of_si(*value).into(),
            Value::Count(count) => (*count).into(),
            Value::Text(text) => text.as_str().into(),
            Value::Reals(values) => values.iter().map(|value| unit.of_si(*value)).collect(),
        };
    }
    schema
}

/// Of the units of a key one at most may stand in its section, and one must where the key is required.
fn rule(section: &Section, key: &Key) -> Option<Json> {
    if key.units().len() == 1 {
        return None;
    }
    let ways = once(key);
    let mut none = json!({"not": {"anyOf": ways}});
    if let Need::RequiredUnless(stems) = &key.need {
        let others = section.keys.iter().filter(|key| stems.contains(&&*key.stem));
        none["allOf"] = others.map(|key| json!({"anyOf": once(key)})).collect();
    }
    let none = (!matches!(key.need, Need::Required)).then_some(none);
    Some(json!({"oneOf": ways.into_iter().chain(none).collect::<Vec<_>>()}))
}

/// One condition for each way to write the key.
fn once(key: &Key) -> Vec<Json> {
    key.names().map(|name| json!({"required": [name]})).collect()
}

/// The keys that a pair of this kind does not have.
fn foreign(section: &Section, kind: &str) -> Option<Json> {
    section.keys.iter().find(|key| key.stem == "kind")?;
    let foreign = section.keys.iter().filter(|key| key.only.is_some_and(|only| only != kind));
    let none: Map<String, Json> = foreign.flat_map(Key::names).map(|name| (name, false.into())).collect();
    Some(json!({"if": {"properties": {"kind": {"const": kind}}}, "then": {"properties": none}}))
}

/// Reference of all keys in Markdown.
pub fn key_table() -> String {
    let mut page = String::new();
    for section in fields::sections().iter().chain([fields::parameter()]) {
        let title = match section.name {
            "" => "Above the first section".into(),
            "effect.parameters" => "`parameters` of an `[[effect]]`".into(),
            _ => format!("`{}`", section.place()),
        };
        let required = if section.required { " Required unless there is a `[torsion_spring]`." } else { "" };
        // Writing to a string cannot fail.
        let _ = write!(page, "## {title}\n\n{}{required}\n\n", section.meaning);
        page.push_str("| key | units | takes | default | meaning |\n|---|---|---|---|---|\n");
        for key in &section.keys {
            page += &line(key);
        }
        page.push('\n');
    }
    page += "## Numbers of the built-in effects\n\nWhat each effect is: [effects](effects.md).\n\n\
             | id | key | units | takes | default | meaning |\n|---|---|---|---|---|---|\n";
    for (spec, section) in library::built_in() {
        for key in library::parameters(section) {
            let _ = write!(page, "| `{}` {}", spec.id, line(key));
        }
    }
    page
}

/// A key's line of a table.
fn line(key: &Key) -> String {
    let units: Vec<&str> = key.units().iter().map(|unit| unit.symbol).collect();
    let only = key.only.map(|kind| format!("; `kind = \"{kind}\"` only")).unwrap_or_default();
    let expected = key.expected(key.usual_unit());
    let (name, units, need, meaning) = (key.usual(), units.join(", "), need(key), &key.meaning);
    format!("| `{name}` | {units} | {expected} | {need} | {meaning}{only} |\n")
}

/// Default of a key in its usual unit, or whether it is required.
fn need(key: &Key) -> String {
    let unit = key.usual_unit();
    match &key.need {
        Need::Required => "required".into(),
        Need::RequiredUnless(stems) => format!("required unless {} are given", stems.join(" and ")),
        Need::Optional => String::new(),
        Need::Default(Value::Real(value)) => {
            format!("{} {}", unit.of_si(*value), unit.symbol).trim_end().into()
        }
        Need::Default(Value::Count(count)) => count.to_string(),
        Need::Default(Value::Text(text)) => format!("\"{text}\""),
        Need::Default(Value::Reals(values)) => format!("{values:?}"),
    }
}
