//! The canonical text of a case: every key of the table that has a value, in SI.

use super::build::Values;
use super::fields;
use super::keys::{Key, Section, Value};
use super::{Case, EffectEntry, build};
use cbpt_core::Reducer;
use cbpt_core::effect::own::{AddsTo, OwnEffect, OwnParameter};
use cbpt_core::units::compound;

/// TOML that reads back as the very same case.
pub(super) fn toml(case: &Case) -> String {
    let sections = sections(&build::values(case));
    sections.into_iter().chain(case.effects.iter().map(effect)).collect::<Vec<_>>().join("\n")
}

/// TOML of a case that has this reducer and nothing else.
pub(super) fn reducer_toml(reducer: &Reducer) -> String {
    sections(&build::reducer_values(reducer)).join("\n")
}

fn sections(values: &Values) -> Vec<String> {
    let section = |section: &Section| {
        let line = |key: &Key| Some((key.si(), literal(values.get(&section.si_name(key))?)));
        let lines: Vec<_> = section.keys.iter().filter_map(line).collect();
        let head = if section.name.is_empty() { String::new() } else { format!("[{}]\n", section.name) };
        (!lines.is_empty()).then(|| block(head, lines))
    };
    fields::sections().iter().filter_map(section).collect()
}

/// One `[[effect]]`.
pub(super) fn effect(entry: &EffectEntry) -> String {
    let EffectEntry { id, numbers, own } = entry;
    let mut lines = vec![("id".into(), quoted(id))];
    lines.extend(numbers.iter().map(|(name, number)| (bare(name), format!("{number:?}"))));
    if let Some(own) = own {
        let adds_to = own.adds_to();
        lines.push(("port".into(), quoted(adds_to.port().name())));
        if matches!(adds_to, AddsTo::Torque | AddsTo::Preload) {
            lines.push(("adds_to".into(), quoted(adds_to.name())));
        }
        lines.push(("expression".into(), quoted(own.text())));
        if !own.parameters().is_empty() {
            let parameters: Vec<String> = own.parameters().iter().map(parameter).collect();
            lines.push((fields::PARAMETERS.into(), format!("{{ {} }}", parameters.join(", "))));
        }
    }
    block("[[effect]]\n".into(), lines)
}

fn block(head: String, lines: Vec<(String, String)>) -> String {
    lines.into_iter().fold(head, |text, (key, value)| text + &key + " = " + &value + "\n")
}

fn parameter(parameter: &OwnParameter) -> String {
    let stated = as_stated(parameter);
    let OwnParameter { name, unit, start, min, max, .. } = stated.as_ref().unwrap_or(parameter);
    let bound =
        |name, bound: &Option<f64>| bound.map(|bound| format!(", {name} = {bound:?}")).unwrap_or_default();
    let (min, max) = (bound("min", min), bound("max", max));
    format!("{} = {{ unit = {}, start = {start:?}{min}{max} }}", bare(name), quoted(unit))
}

/// The parameter in the unit in which it was stated; `None` where it would not read back the same.
pub fn as_stated(parameter: &OwnParameter) -> Option<OwnParameter> {
    let OwnParameter { name, unit, stated, start, min, max } = parameter;
    let size = compound::read(stated).ok().filter(|_| !stated.is_empty())?.size;
    let back = |number: f64| {
        let rounded = format!("{:.14e}", number / size).parse().unwrap_or(f64::NAN);
        [rounded, number / size].into_iter().find(|value: &f64| (value * size).to_bits() == number.to_bits())
    };
    let bound = |bound: &Option<f64>| bound.map_or(Some(None), |number| back(number).map(Some));
    Some(OwnParameter {
        name: name.clone(),
        unit: stated.clone(),
        stated: unit.clone(),
        start: back(*start)?,
        min: bound(min)?,
        max: bound(max)?,
    })
}

/// A value as TOML; the shortest number that reads back the same.
fn literal(value: &Value) -> String {
    match value {
        Value::Real(number) => format!("{number:?}"),
        Value::Count(count) => count.to_string(),
        Value::Text(text) => quoted(text),
        Value::Reals(numbers) => format!("{numbers:?}"),
    }
}

/// A key, in quotes where it needs them.
fn bare(key: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
    if !key.is_empty() && key.chars().all(plain) { key.to_owned() } else { quoted(key) }
}

fn quoted(text: &str) -> String {
    let escaped = |c: char| match c {
        '"' | '\\' => format!("\\{c}"),
        c if c.is_control() => format!("\\u{:04X}", u32::from(c)),
        c => c.to_string(),
    };
    format!("\"{}\"", text.chars().map(escaped).collect::<String>())
}
