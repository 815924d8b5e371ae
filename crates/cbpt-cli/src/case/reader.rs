//! Reads the keys of a section by the table of keys: values in SI, and where each was given. Every mistake is noted and an
//! example put in its place, so that one reading finds them all.

use std::collections::BTreeMap;

use cbpt_core::units::Unit;

use super::build::Values;
use super::document::{Content, Entry, Node};
use super::error::{Mistake, Notes};
use super::keys::{Key, Kind, Need, Section, Value, dotted};
use super::suggest;

/// Where a value was given, and how.
pub(super) struct Source {
    pub(super) at: Option<usize>,
    /// Dotted key as it was written.
    pub(super) key: String,
    pub(super) written: String,
}

/// What has been read so far.
pub(super) struct Reader<'n, 't> {
    pub(super) notes: &'n mut Notes<'t>,
    pub(super) values: Values,
    pub(super) sources: BTreeMap<String, Source>,
}

impl<'n, 't> Reader<'n, 't> {
    pub(super) fn new(notes: &'n mut Notes<'t>) -> Self {
        Self { notes, values: Values::default(), sources: BTreeMap::new() }
    }

    /// Takes the keys of a section and returns the entries that are none.
    pub(super) fn take<'e>(
        &mut self,
        section: &Section,
        path: &str,
        entries: impl IntoIterator<Item = &'e Entry>,
    ) -> Vec<&'e Entry> {
        let mut others = Vec::new();
        for entry in entries {
            match section.find(&entry.key) {
                Some((key, unit)) => self.take_value(section, key, unit, path, entry),
                None => others.push(entry),
            }
        }
        others
    }

    fn take_value(&mut self, section: &Section, key: &Key, unit: &Unit, path: &str, entry: &Entry) {
        let name = section.si_name(key);
        let dotted = dotted(path, &entry.key);
        if let Some(first) = self.sources.get(&name) {
            let line = first.at.map(|at| format!(" on line {}", self.notes.line(at))).unwrap_or_default();
            let problem = format!("the same quantity is already given as {}{line}", first.key);
            let mistake =
                Mistake { key: dotted, problem, allowed: "keep one of them".into(), ..Mistake::default() };
            return self.notes.add(entry.at, mistake);
        }
        if let Some(value) = value(key, unit, &entry.node, !section.mechanics) {
            let (at, written) = (entry.node.at, entry.node.written.clone());
            self.values.set(name.clone(), value);
            self.sources.insert(name, Source { at, key: dotted, written });
        } else {
            let nearest = match (key.kind, &entry.node.content) {
                (Kind::Choice(words), Content::Text(word)) => suggest::nearest(word, words.iter().copied()),
                _ => None,
            };
            let (allowed, found) = (format!("expected {}", key.expected(unit)), entry.node.written.clone());
            self.values.set(name, key.example.clone());
            self.notes
                .add(entry.node.at, Mistake { key: dotted, found, allowed, nearest, ..Mistake::default() });
        }
    }

    /// A key that the section does not have.
    pub(super) fn unknown(&mut self, section: &Section, path: &str, entry: &Entry) {
        if self.notes.full() {
            return;
        }
        let suggest::Unknown { mistake, meant } =
            suggest::unknown_key(section, &entry.key, &entry.node.content);
        if let Some(key) = meant
            && !self.values.has(&section.si_name(key))
        {
            self.values.set(section.si_name(key), key.example.clone());
        }
        self.notes.add(entry.at, Mistake { key: dotted(path, &entry.key), ..mistake });
    }

    /// Where a section cannot be read at all.
    pub(super) fn put_examples(&mut self, section: &Section) {
        for key in section.keys.iter().filter(|key| !matches!(key.need, Need::Optional)) {
            self.values.set(section.si_name(key), key.example.clone());
        }
    }

    /// Fills in defaults and notes what is missing.
    pub(super) fn complete(&mut self, section: &Section, path: &str, at: Option<usize>) {
        for key in &section.keys {
            let name = section.si_name(key);
            let given = |stem: &&str| {
                section.keys.iter().any(|key| key.stem == *stem && self.values.has(&section.si_name(key)))
            };
            let alternatives = match &key.need {
                _ if self.values.has(&name) => continue,
                Need::Optional => continue,
                Need::Default(value) => {
                    self.values.set(name, value.clone());
                    continue;
                }
                Need::RequiredUnless(stems) if stems.iter().all(given) => continue,
                Need::RequiredUnless(stems) => format!(", or both {}", stems.join(" and ")),
                Need::Required => String::new(),
            };
            let allowed = match key.units() {
                [only] => format!("expected {}{alternatives}", key.expected(only)),
                _ => format!("write one of {}{alternatives}", key.names().collect::<Vec<_>>().join(", ")),
            };
            let problem = "missing".into();
            self.values.set(name, key.example.clone());
            self.notes
                .add(at, Mistake { key: dotted(path, &key.stem), problem, allowed, ..Mistake::default() });
        }
    }
}

/// The value of a key in SI, if it is what the key takes; the range only where asked.
fn value(key: &Key, unit: &Unit, node: &Node, check_range: bool) -> Option<Value> {
    match (key.kind, &node.content) {
        (Kind::Quantities(..), Content::List(items)) => {
            let number = |item: &Node| match item.content {
                Content::Number(number) => Some(unit.to_si(number)).filter(|value| value.is_finite()),
                _ => None,
            };
            items.iter().map(number).collect::<Option<Vec<f64>>>().map(Value::Reals)
        }
        (Kind::Quantity(..) | Kind::Number, Content::Number(number)) => {
            let value = unit.to_si(*number);
            let allowed = value.is_finite() && (!check_range || key.allows(value));
            allowed.then_some(Value::Real(value))
        }
        (Kind::Count, Content::Number(number)) => {
            let allowed = |count: &u32| !check_range || key.allows(f64::from(*count));
            whole(*number).filter(allowed).map(Value::Count)
        }
        (Kind::Choice(words), Content::Text(word)) => {
            words.contains(&&**word).then(|| Value::Text(word.clone()))
        }
        (Kind::Text, Content::Text(text)) => Some(Value::Text(text.clone())),
        _ => None,
    }
}

/// The number as a whole number, if it is one.
fn whole(number: f64) -> Option<u32> {
    format!("{number}").parse().ok()
}
