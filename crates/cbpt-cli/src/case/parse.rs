//! From the tree of a file to a case: its sections one by one, what they must be together, then the checks of the mechanics.

use std::borrow::Cow;
use std::path::Path;

use cbpt_core::InvalidInput;

use super::build::{self, TRACK_CURVATURE};
use super::document::{Content, Entry};
use super::error::{Mistake, Notes};
use super::fields;
use super::keys::{Key, Kind, Need, Section, dotted};
use super::reader::{Reader, Source};
use super::{Case, effect, suggest, tables};

/// Reads the case; if there are mistakes they are in the notes.
pub(super) fn case(document: &[Entry], folder: Option<&Path>, notes: &mut Notes<'_>) -> Option<Case> {
    let mut reader = Reader::new(notes);
    let mut effects = Vec::new();
    let mut found = Vec::new();
    for entry in reader.take(fields::top(), "", document) {
        if reader.notes.full() {
            return None;
        }
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
    tables::read_tables(&mut reader, folder);
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

/// The entries of a section about numbers of others, named as a plan names its axes: `deceleration.ball_radius_um` stands for
/// `deceleration_ball_radius_um`.
fn flat(entries: &[Entry]) -> Cow<'_, [Entry]> {
    let mut found = Vec::new();
    for entry in entries {
        match &entry.node.content {
            Content::Table(inner) if fields::section(&entry.key).is_some() => {
                let named = |inner: &Entry| Entry {
                    key: fields::uncertainty_of(&dotted(&entry.key, &inner.key)),
                    ..inner.clone()
                };
                found.extend(inner.iter().map(named));
            }
            _ => found.push(entry.clone()),
        }
    }
    found.into()
}

impl Reader<'_, '_> {
    /// Reads one section.
    fn section(&mut self, section: &Section, entry: &Entry) {
        if let Content::Table(entries) = &entry.node.content {
            let entries = if section.of_numbers() { flat(entries) } else { Cow::Borrowed(&**entries) };
            for other in self.take(section, &entry.key, entries.iter()) {
                self.unknown(section, &entry.key, other);
            }
        } else {
            let (key, found) = (entry.key.clone(), entry.node.written.clone());
            let allowed = format!("expected one section {}", section.place());
            self.notes.add(entry.at, Mistake { key, found, allowed, ..Mistake::default() });
            self.put_examples(section);
        }
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
                    let problem = format!("only a pair with kind = \"{only}\" has this key");
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
            let problem = format!("{} gives the stiffness as well", table.key);
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
        if tables::is_about(&refused) {
            return tables::put_aside(self, refused);
        }
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
                let spring = fields::section(fields::SPRING)?;
                for key in spring.keys.iter().filter(lists) {
                    self.values.set(spring.si_name(key), key.example.clone());
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
