//! The effects of a case: built-in ones by their ids, the user's own by an expression.

use std::sync::Arc;

use cbpt_core::effect::own::{AddsTo, OwnParameter, Variable};
use cbpt_core::units::compound;

use crate::formula::value::Function;
use crate::formula::{Formula, Wrong};

use super::EffectEntry;
use super::document::{Content, Entry, Node};
use super::error::{Mistake, Notes, shortened};
use super::fields::{self, PARAMETERS};
use super::keys::{Key, Value, dotted};
use super::library::{self, EFFECTS};
use super::reader::Reader;
use super::suggest;

/// Reads all entries `[[effect]]`.
pub(super) fn read(entry: &Entry, notes: &mut Notes<'_>) -> Vec<EffectEntry> {
    let key = &entry.key;
    let mut effects = Vec::new();
    let items: &[Node] = if let Content::List(items) = &entry.node.content { items } else { &[] };
    for (index, item) in items.iter().enumerate() {
        if notes.full() {
            break;
        }
        match &item.content {
            Content::Table(entries) => {
                effects.extend(one(&format!("{key}[{index}]"), item.at, entries, notes));
            }
            _ => notes.add(item.at, no_effect(format!("{key}[{index}]"), item)),
        }
    }
    if !matches!(entry.node.content, Content::List(_)) {
        notes.add(entry.at, no_effect(key.clone(), &entry.node));
    }
    effects
}

fn no_effect(key: String, node: &Node) -> Mistake {
    let allowed = "expected an entry of its own for each effect, headed [[effect]]".into();
    Mistake { key, found: node.written.clone(), allowed, ..Mistake::default() }
}

fn one(path: &str, at: Option<usize>, entries: &[Entry], notes: &mut Notes<'_>) -> Option<EffectEntry> {
    let entry = |key: &str| entries.iter().find(|entry| entry.key == key);
    let id = entry("id").map(|entry| &entry.node);
    let found = match id.map(|id| &id.content) {
        Some(Content::Text(id)) if entry("expression").is_none() => library::find(id),
        _ => None,
    };
    let Some((spec, section)) = found else { return own(path, at, entries, notes) };
    let mut reader = Reader::new(notes);
    for other in reader.take(section, path, entries.iter().filter(|entry| entry.key != PARAMETERS)) {
        reader.unknown(section, path, other);
    }
    reader.complete(section, path, at);
    if let Some(entry) = entry(PARAMETERS) {
        let problem = "only own effects, which have an expression, have `parameters`".into();
        let allowed = "write the parameters of a built-in effect as keys of [[effect]]".into();
        let key = dotted(path, &entry.key);
        reader.notes.add(entry.at, Mistake { key, problem, allowed, ..Mistake::default() });
    }
    if let Some(port) = reader.values.text("effect.port").filter(|port| *port != spec.port.name()) {
        let found = format!("\"{port}\"");
        let allowed = format!("{} acts at the port {}; leave the line out", spec.id, spec.port.name());
        let at = entry("port").and_then(|entry| entry.node.at);
        reader.notes.add(at, Mistake { key: dotted(path, "port"), found, allowed, ..Mistake::default() });
    }
    let number = |key: &Key| {
        let value = match reader.values.get(&section.si_name(key))? {
            Value::Real(value) => *value,
            Value::Count(count) => f64::from(*count),
            Value::Text(_) | Value::Reals(_) => return None,
        };
        Some((key.si(), value))
    };
    let numbers = library::parameters(section).filter_map(number).collect();
    Some(EffectEntry { id: spec.id.into(), numbers, own: None })
}

/// An effect of the user's own, or one that is not in the library.
fn own(path: &str, at: Option<usize>, entries: &[Entry], notes: &mut Notes<'_>) -> Option<EffectEntry> {
    let section = fields::effect();
    let before = notes.count();
    let mut reader = Reader::new(notes);
    let others = reader.take(section, path, entries.iter().filter(|entry| entry.key != PARAMETERS));
    reader.complete(section, path, at);
    let text = |name| reader.values.text(name).map(str::to_owned);
    let (id, port) = (text("effect.id")?, text("effect.port"));
    let (adds_to, expression) = (text("effect.adds_to"), text("effect.expression"));
    let node = |key: &str| entries.iter().find(|entry| entry.key == key).map(|entry| &entry.node);
    let Some(expression) = expression else {
        // Its other keys cannot be judged before its id is right.
        not_built_in(&id, path, node("id"), reader.notes);
        return None;
    };
    for other in others {
        reader.unknown(section, path, other);
    }
    check_id(&id, path, node("id"), reader.notes);
    let parameters = entries.iter().find(|entry| entry.key == PARAMETERS);
    let parameters = parameters.map(|entry| own_parameters(path, entry, reader.notes)).unwrap_or_default();
    let Some(port) = port else {
        let problem = "missing; an own effect needs the port where it acts".into();
        let allowed = "expected \"load\", \"series\" or \"reading\"".into();
        let key = dotted(path, "port");
        reader.notes.add(at, Mistake { key, problem, allowed, ..Mistake::default() });
        return None;
    };
    if reader.notes.count() > before {
        // What is told already would be told again.
        return None;
    }
    let adds_to = match AddsTo::of(&port, adds_to.as_deref()) {
        Ok(adds_to) => adds_to,
        Err(wrong) => {
            let (at, key) = (node(&wrong.field).and_then(|node| node.at).or(at), dotted(path, &wrong.field));
            let (found, allowed) = (wrong.found, wrong.required);
            reader.notes.add(at, Mistake { key, found, allowed, ..Mistake::default() });
            return None;
        }
    };
    match Formula::new(&id, adds_to, &expression, parameters) {
        Ok(own) => Some(EffectEntry { id, numbers: Vec::new(), own: Some(Arc::new(own)) }),
        Err(Wrong { character, problem, name, known }) => {
            let nearest = suggest::nearest(&name, known.iter().map(String::as_str));
            let allowed =
                if known.is_empty() { String::new() } else { format!("known are {}", known.join(", ")) };
            let found = shortened(&format!("{expression:?}"));
            let key = dotted(path, "expression");
            let at = node("expression").and_then(|node| node.at);
            let character = Some(character);
            let mistake = Mistake { key, found, character, problem, allowed, nearest, ..Mistake::default() };
            reader.notes.add(at, mistake);
            None
        }
    }
}

/// Names that the answers give to something else.
const TAKEN: [&str; 2] = ["model", "unknown"];

fn check_id(id: &str, path: &str, node: Option<&Node>, notes: &mut Notes<'_>) {
    let (problem, allowed) = if EFFECTS.contains(&id) {
        ("a built-in effect has this id", "give the own effect another id, or leave out its expression")
    } else if TAKEN.contains(&id) {
        ("this id has another meaning in answers", "give the own effect another id")
    } else if !is_identifier(id) {
        ("the id of an own effect is a name: letters, digits and _, no digit first", "")
    } else {
        return;
    };
    let (problem, allowed) = (problem.to_owned(), allowed.to_owned());
    let found = node.map(|id| id.written.clone()).unwrap_or_default();
    let key = dotted(path, "id");
    notes.add(node.and_then(|id| id.at), Mistake { key, found, problem, allowed, ..Mistake::default() });
}

/// What a key of an effect takes.
fn expected(key: &str) -> String {
    let found = fields::effect().find(key);
    found.map(|(key, unit)| format!("expected {}", key.expected(unit))).unwrap_or_default()
}

fn not_built_in(written: &str, path: &str, id: Option<&Node>, notes: &mut Notes<'_>) {
    let Some(id) = id else { return };
    if !matches!(id.content, Content::Text(_)) {
        return;
    }
    let problem = "no built-in effect has this id".into();
    let allowed = format!("an own effect needs an expression; built-in are {}", EFFECTS.join(", "));
    let nearest = suggest::nearest(written, EFFECTS.iter().copied());
    let (key, found) = (dotted(path, "id"), id.written.clone());
    notes.add(id.at, Mistake { key, found, problem, allowed, nearest, ..Mistake::default() });
}

fn own_parameters(path: &str, entry: &Entry, notes: &mut Notes<'_>) -> Vec<OwnParameter> {
    let path = dotted(path, &entry.key);
    if let Content::Table(entries) = &entry.node.content {
        let read =
            entries.iter().map_while(|entry| (!notes.full()).then(|| own_parameter(&path, entry, notes)));
        read.flatten().collect()
    } else {
        let (allowed, found) = (expected(PARAMETERS), entry.node.written.clone());
        notes.add(entry.node.at, Mistake { key: path, found, allowed, ..Mistake::default() });
        Vec::new()
    }
}

fn own_parameter(path: &str, entry: &Entry, notes: &mut Notes<'_>) -> Option<OwnParameter> {
    let section = fields::parameter();
    let (path, name) = (dotted(path, &entry.key), entry.key.clone());
    if !is_identifier(&name) {
        let problem =
            "a parameter is named as in the expression: letters, digits and _, no digit first".into();
        notes.add(entry.at, Mistake { key: path.clone(), problem, ..Mistake::default() });
    } else if name == "pi" || Variable::find(&name).is_some() || Function::find(&name).is_some() {
        let problem = "this name has another meaning in expressions".into();
        let allowed = "give the parameter another name".into();
        notes.add(entry.at, Mistake { key: path.clone(), problem, allowed, ..Mistake::default() });
    }
    let Content::Table(entries) = &entry.node.content else {
        let allowed =
            "expected a table such as { unit = \"rad\", start = 1e-6, min = 0.0, max = 1e-3 }".into();
        let found = entry.node.written.clone();
        notes.add(entry.node.at, Mistake { key: path, found, allowed, ..Mistake::default() });
        return None;
    };
    let mut reader = Reader::new(notes);
    for other in reader.take(section, &path, entries) {
        reader.unknown(section, &path, other);
    }
    reader.complete(section, &path, entry.at);
    let values = reader.values;
    let (min, max) = (values.real("effect.parameters.min"), values.real("effect.parameters.max"));
    let unit = values.text("effect.parameters.unit")?.to_owned();
    let start = values.real("effect.parameters.start")?;
    let stated = unit;
    let unit = match compound::read(&stated) {
        Ok(unit) => unit,
        Err(problem) => {
            let at = entries.iter().find(|entry| entry.key == "unit").and_then(|entry| entry.node.at);
            let (key, found) = (dotted(&path, "unit"), shortened(&format!("{stated:?}")));
            let allowed =
                "expected a unit such as \"rad/(N m)\", \"arcsec\" or \"s\", \"\" for a number".into();
            notes.add(at, Mistake { key, found, problem, allowed, ..Mistake::default() });
            return None;
        }
    };
    if min.is_some_and(|min| min > start) || max.is_some_and(|max| max < start) {
        let allowed = "min, start and max must be in this order".into();
        notes.add(entry.at, Mistake { key: path, allowed, ..Mistake::default() });
    }
    // The formula is in SI, so its numbers are from here on.
    let [start, min, max] = [Some(start), min, max].map(|number| number.map(|number| number * unit.size));
    let stated = if stated == unit.si { String::new() } else { stated };
    Some(OwnParameter { name, unit: unit.si, stated, start: start?, min, max })
}

/// Whether an expression can hold the name.
fn is_identifier(name: &str) -> bool {
    let letter = |c: char| c.is_ascii_alphabetic() || c == '_';
    name.starts_with(letter) && name.chars().all(|c| letter(c) || c.is_ascii_digit())
}
