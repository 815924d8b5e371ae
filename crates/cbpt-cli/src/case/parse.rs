//! From the tree of a file to a case, by the table of keys. Every mistake is noted and an example put in its place,
//! so that one reading finds them all.

use std::collections::BTreeMap;

use cbpt_core::InvalidInput;

use super::build::{self, TRACK_CURVATURE, Values};
use super::document::{Content, Entry, Node};
use super::error::{Mistake, Notes};
use super::fields;
use super::keys::{Key, Kind, Need, Section, Value, dotted};
use super::units::Unit;
use super::{Case, effect, suggest};

/// Where a value was given, and how.
struct Source {
    at: Option<usize>,
    /// Dotted key as it was written.
    key: String,
    written: String,
}

/// What has been read so far.
pub(super) struct Reader<'n, 't> {
    pub(super) notes: &'n mut Notes<'t>,
    pub(super) values: Values,
    sources: BTreeMap<String, Source>,
}

/// Reads the case; if there are mistakes they are in the notes.
pub(super) fn case(document: &[Entry], notes: &mut Notes<'_>) -> Option<Case> {
    let mut reader = Reader::new(notes);
    let mut effects = Vec::new();
    let mut found = Vec::new();
    for entry in reader.take(fields::top(), "", document) {
        let Some(section) = reader.which_section(document, entry) else { continue };
        found.push((section.name, entry));
        if section.name == fields::effect().name {
            effects = effect::read(entry, reader.notes);
        } else {
            reader.section(section, entry);
        }
    }
    reader.one_kind();
    reader.one_track_curvature();
    let spring = found.iter().any(|(name, _)| *name == fields::SPRING);
    reader.one_reducer(&found);
    for section in fields::sections().iter().filter(|section| section.name != fields::effect().name) {
        let of_ball_drive = section.name.is_empty() || fields::DRIVE.contains(&section.name);
        if (spring && of_ball_drive) || (!spring && section.name == fields::SPRING) {
            continue;
        }
        match found.iter().find(|(name, _)| *name == section.name) {
            Some((_, entry)) => reader.complete(section, &entry.key, entry.at),
            None if section.required => reader.missing_section(section),
            None => reader.complete(section, section.name, None),
        }
    }
    let case = reader.build().map(|case| Case { effects, ..case })?;
    for (index, entry) in case.effects.iter().enumerate() {
        let why = cbpt_core::effect::find(&entry.id).and_then(|spec| case.reducer.unsuited(spec));
        if let Some(why) = why {
            let (key, found) = (format!("effect[{index}].id"), format!("\"{}\"", entry.id));
            notes.add(None, Mistake { key, found, allowed: why.into(), ..Mistake::default() });
        }
    }
    Some(case)
}

impl<'n, 't> Reader<'n, 't> {
    pub(super) fn new(notes: &'n mut Notes<'t>) -> Self {
        Self { notes, values: Values::default(), sources: BTreeMap::new() }
    }

    /// Reads one section.
    fn section(&mut self, section: &Section, entry: &Entry) {
        if let Content::Table(entries) = &entry.node.content {
            for other in self.take(section, &entry.key, entries) {
                self.unknown(section, &entry.key, other);
            }
        } else {
            let (key, found) = (entry.key.clone(), entry.node.written.clone());
            let allowed = format!("expected one section {}", section.place());
            self.notes.add(entry.at, Mistake { key, found, allowed, ..Mistake::default() });
            self.put_examples(section);
        }
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
        let suggest::Unknown { mistake, meant } = suggest::unknown_key(section, &entry.key);
        if let Some(key) = meant
            && !self.values.has(&section.si_name(key))
        {
            self.values.set(section.si_name(key), key.example.clone());
        }
        self.notes.add(entry.at, Mistake { key: dotted(path, &entry.key), ..mistake });
    }

    /// The section of an entry of the file; a misspelled name is noted, and read as what it must mean.
    fn which_section(&mut self, document: &[Entry], entry: &Entry) -> Option<&'static Section> {
        if let Some(section) = fields::section(&entry.key) {
            return Some(section);
        }
        if !matches!(entry.node.content, Content::Table(_) | Content::List(_)) {
            self.unknown(fields::top(), "", entry);
            return None;
        }
        let mistake = suggest::unknown_section(&entry.key);
        let meant = mistake.nearest.as_deref().and_then(fields::section);
        self.notes.add(entry.at, mistake);
        meant.filter(|meant| document.iter().all(|entry| entry.key != meant.name))
    }

    /// Keys that the kind of equal-speed pair does not have.
    fn one_kind(&mut self) {
        let name = "equal_speed.kind";
        let Some(kind) = self.values.text(name).filter(|_| self.sources.contains_key(name)) else { return };
        let kind = kind.to_owned();
        for section in fields::sections() {
            for key in &section.keys {
                let Some(only) = key.only.filter(|only| *only != kind) else { continue };
                let name = section.si_name(key);
                self.values.remove(&name);
                if let Some(Source { at, key, .. }) = self.sources.remove(&name) {
                    let problem = format!("only a pair with kind = \"{only}\" has it");
                    let allowed = format!("this pair has kind = \"{kind}\"");
                    self.notes.add(at, Mistake { key, problem, allowed, ..Mistake::default() });
                }
            }
        }
    }

    /// A ball drive or a torsion spring, and of the spring one stiffness or a table.
    fn one_reducer(&mut self, found: &[(&str, &Entry)]) {
        if found.iter().all(|(name, _)| *name != fields::SPRING) {
            return;
        }
        for (name, entry) in found.iter().filter(|(name, _)| fields::DRIVE.contains(name)) {
            let problem = "is about a ball drive, and this case has a [torsion_spring]".into();
            let allowed = "keep one of them".into();
            let key = format!("[{name}]");
            self.notes.add(entry.at, Mistake { key, problem, allowed, ..Mistake::default() });
        }
        let source = |stem: &str| {
            let of = |(name, _): &(&String, &Source)| name.starts_with(&format!("{}.{stem}", fields::SPRING));
            self.sources.iter().find(of).map(|(_, source)| source)
        };
        if let (Some(stiffness), Some(table)) =
            (source("torsional_stiffness"), source("torque").or(source("elastic_angle")))
        {
            let (at, key) = (stiffness.at, stiffness.key.clone());
            let problem = format!("{} says the stiffness as well", table.key);
            let allowed = "keep one of them".into();
            self.notes.add(at, Mistake { key, problem, allowed, ..Mistake::default() });
        }
    }

    /// One setting for the drive, wherever it stands.
    fn one_track_curvature(&mut self) {
        let given = TRACK_CURVATURE.map(|name| (self.values.text(name), self.sources.get(name)));
        let mut given: Vec<_> =
            given.into_iter().filter_map(|(word, source)| Some((word?, source?))).collect();
        given.sort_by_key(|(_, source)| source.at);
        let Some(((word, first), others)) = given.split_first() else { return };
        for (_, source) in others.iter().filter(|(other, _)| other != word) {
            let problem = format!("contradicts {} = \"{word}\"", first.key);
            let allowed = "it is one setting of the whole drive; keep one of them".into();
            let (key, found) = (source.key.clone(), source.written.clone());
            self.notes.add(source.at, Mistake { key, found, problem, allowed, ..Mistake::default() });
        }
    }

    /// One mistake for a section that is missing, in place of one for each of its keys.
    fn missing_section(&mut self, section: &Section) {
        let required = |key: &&Key| matches!(key.need, Need::Required | Need::RequiredUnless(_));
        let keys: Vec<String> = section.keys.iter().filter(required).map(Key::usual).collect();
        let allowed = format!("it needs {}; any other reducer has a [{}]", keys.join(", "), fields::SPRING);
        let problem = "the section is missing".into();
        self.notes.add(None, Mistake { key: section.name.into(), problem, allowed, ..Mistake::default() });
        self.put_examples(section);
    }

    /// Where a section cannot be read at all.
    fn put_examples(&mut self, section: &Section) {
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

    /// Lets the mechanics check the numbers, again after each that they refuse.
    fn build(mut self) -> Option<Case> {
        loop {
            match build::case(&self.values) {
                Ok(case) => return Some(case),
                Err(refused) => self.put_aside(refused)?,
            }
        }
    }

    /// Notes a number that the mechanics refuse and puts an example in its place; `None` where the file has none.
    fn put_aside(&mut self, refused: InvalidInput) -> Option<()> {
        let name = self.values.given_as(&refused.field).to_owned();
        let keys =
            |section: &'static Section| section.keys.iter().map(move |key| (section.si_name(key), key));
        let key = fields::sections().iter().flat_map(keys).find(|(si_name, _)| *si_name == name);
        let InvalidInput { field, found, required: allowed } = refused;
        if let (Some((_, key)), Some(Source { at, key: written, written: found })) =
            (key, self.sources.remove(&name))
        {
            self.notes.add(at, Mistake { key: written, found, allowed, ..Mistake::default() });
            self.values.set(name, key.example.clone());
            if matches!(key.kind, Kind::Quantities(..)) {
                // Lists go together.
                let lists = |key: &&Key| matches!(key.kind, Kind::Quantities(..));
                for section in fields::sections() {
                    for key in section.keys.iter().filter(lists) {
                        self.values.set(section.si_name(key), key.example.clone());
                    }
                }
            }
            return Some(());
        }
        if self.notes.is_empty() {
            self.notes.add(None, Mistake { key: field, found, allowed, ..Mistake::default() });
        }
        None
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
