//! The text of a case file with other effects in it; comments, order and units of all else stay as they are.

use toml_edit::{ArrayOfTables, DocumentMut, Item, Table, TableLike, Value as Toml, value};

use super::error::CaseError;
use super::fields::PARAMETERS;
use super::keys::{Key, Kind, Need, Section, Value};
use super::{Case, EffectEntry, library, write};
use cbpt_core::effect::own::OwnEffect;
use cbpt_core::units::Unit;

/// The file that `case` was made of, with the effects of `case`. What else differs makes it a file of its own.
pub(super) fn with_effects(text: &str, case: &Case) -> Result<String, CaseError> {
    let old = Case::from_toml(text, "")?;
    let (Ok(mut document), true) =
        (text.parse::<DocumentMut>(), old == Case { effects: old.effects.clone(), ..case.clone() })
    else {
        return Ok(case.to_toml());
    };
    let given = document.remove("effect").and_then(|item| item.into_array_of_tables().ok());
    let mut left: Vec<&EffectEntry> = case.effects.iter().collect();
    let mut tables = ArrayOfTables::new();
    for (mut table, was) in given.unwrap_or_default().into_iter().zip(&old.effects) {
        // In the order of the file; an effect that the case has no longer goes.
        let Some(place) = left.iter().position(|now| now.id == was.id) else { continue };
        change(&mut table, was, left.remove(place));
        tables.push(table);
    }
    for effect in left {
        tables.push(added(effect));
    }
    if !tables.is_empty() {
        document.insert("effect", Item::ArrayOfTables(tables));
    }
    Ok(document.to_string())
}

/// Writes what is new about an effect.
fn change(table: &mut Table, was: &EffectEntry, now: &EffectEntry) {
    if let Some(own) = &now.own {
        for (index, parameter) in own.parameters().iter().enumerate() {
            let before = was.own.as_ref().and_then(|own| own.parameters().get(index));
            let stated = write::as_stated(parameter);
            let start = stated.as_ref().unwrap_or(parameter).start;
            let written = table
                .get_mut(PARAMETERS)
                .and_then(Item::as_table_like_mut)
                .and_then(|all| all.get_mut(&parameter.name))
                .and_then(Item::as_table_like_mut);
            if let (Some(written), true) = (written, before != Some(parameter)) {
                set(written, "start", start.into());
                if stated.is_none() {
                    set(written, "unit", parameter.unit.clone().into());
                }
            }
        }
    } else if let Some((_, section)) = library::find(&now.id) {
        for (name, number) in &now.numbers {
            if !was.numbers.contains(&(name.clone(), *number)) {
                number_of(table, section, name, *number);
            }
        }
    }
}

/// Writes a number under the key that it has in the file, else in its usual unit.
fn number_of(table: &mut Table, section: &'static Section, si_name: &str, number: f64) {
    let Some(key) = section.keys.iter().find(|key| key.si() == si_name) else { return };
    let given =
        table.iter().find_map(|(written, _)| section.find(written).filter(|(k, _)| k.si() == si_name));
    let unit = given.map_or(key.usual_unit(), |(_, unit)| unit);
    set(table, &key.with(unit), literal(key, unit, number));
}

/// Puts a value in the place of another, whose comment stays.
fn set(table: &mut dyn TableLike, key: &str, new: Toml) {
    match table.get_mut(key).and_then(Item::as_value_mut) {
        Some(old) => {
            let decor = old.decor().clone();
            *old = new;
            *old.decor_mut() = decor;
        }
        None => {
            table.insert(key, value(new));
        }
    }
}

/// An effect that the file does not have: its numbers in their usual units, without those that are their defaults.
fn added(effect: &EffectEntry) -> Table {
    let table = |text: &str| {
        let document = text.parse::<DocumentMut>().ok()?;
        document.get("effect")?.as_array_of_tables()?.get(0).cloned()
    };
    let mut made = table(&write::effect(effect)).unwrap_or_default();
    if let Some((_, section)) = library::find(&effect.id).filter(|_| effect.own.is_none()) {
        for (name, number) in &effect.numbers {
            made.remove(name);
            let default = section.keys.iter().find(|key| key.si() == *name).map(|key| &key.need);
            let same = match default {
                Some(Need::Default(Value::Real(neutral))) => (neutral - number).abs() == 0.0,
                _ => false,
            };
            if !same {
                number_of(&mut made, section, name, *number);
            }
        }
    }
    made.decor_mut().set_prefix("\n");
    made.set_position(None);
    made
}

/// A number in a unit: the shortest that reads back the same. Where none does, because the unit has fewer numbers there than
/// SI has, the nearest: one unit in the last place off.
fn literal(key: &Key, unit: &Unit, number: f64) -> Toml {
    if matches!(key.kind, Kind::Count) {
        // A whole number of a table that was read.
        #[allow(clippy::cast_possible_truncation)]
        return (number as i64).into();
    }
    let exact = unit.of_si(number);
    let off = |value: f64| (unit.to_si(value) - number).abs();
    let rounded = (1..17).filter_map(|digits| format!("{exact:.digits$e}").parse().ok());
    rounded
        .into_iter()
        .find(|value: &f64| unit.to_si(*value).to_bits() == number.to_bits())
        .or_else(|| {
            [exact, exact.next_up(), exact.next_down()].into_iter().min_by(|a, b| off(*a).total_cmp(&off(*b)))
        })
        .unwrap_or(exact)
        .into()
}
