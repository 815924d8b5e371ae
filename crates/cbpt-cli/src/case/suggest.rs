//! What a key that nobody knows may have meant.

use cbpt_core::units;

use super::error::{Mistake, shortened};
use super::fields;
use super::keys::{Key, Kind, Section};

/// A diagnosis, and the key that must have been meant, if that is clear.
pub(super) struct Unknown<'s> {
    pub(super) mistake: Mistake,
    pub(super) meant: Option<&'s Key>,
}

/// Says what is wrong with a key that the section does not have.
pub(super) fn unknown_key<'s>(section: &'s Section, written: &str) -> Unknown<'s> {
    unit_forgotten(section, written)
        .or_else(|| unit_unknown(section, written))
        .or_else(|| elsewhere(section, written))
        .unwrap_or_else(|| misspelled(section, written))
}

/// The right key without the unit it needs.
fn unit_forgotten<'s>(section: &'s Section, written: &str) -> Option<Unknown<'s>> {
    let of_stem = || section.keys.iter().filter(|key| key.stem == written);
    let problem = "the key needs a unit".into();
    let allowed = format!("write one of {}", of_stem().flat_map(Key::names).collect::<Vec<_>>().join(", "));
    Some(Unknown {
        mistake: Mistake { problem, allowed, ..Mistake::default() },
        meant: Some(of_stem().next()?),
    })
}

/// The right key with a unit that it does not have.
fn unit_unknown<'s>(section: &'s Section, written: &str) -> Option<Unknown<'s>> {
    let suffix = |key: &'s Key| Some((key, written.strip_prefix(&*key.stem)?.strip_prefix('_')?.to_owned()));
    let (key, suffix) = section.keys.iter().filter_map(suffix).max_by_key(|(key, _)| key.stem.len())?;
    let mistake = match key.kind {
        Kind::Quantity(..) if !suffix.contains('_') || format!("_{suffix}").contains("_per_") => {
            let suffixes: Vec<&str> = key.units().iter().map(|unit| unit.symbol).collect();
            let same = key.units().iter().find(|known| known.symbol.eq_ignore_ascii_case(&suffix));
            Mistake {
                problem: format!("unit {} is not read", shortened(&suffix)),
                allowed: format!("use {}", suffixes.join(", ")),
                nearest: same.map(|unit| key.with(unit)),
                ..Mistake::default()
            }
        }
        Kind::Number | Kind::Count | Kind::Choice(_) if units::all().any(|unit| unit.symbol == suffix) => {
            Mistake {
                problem: "the key has no unit".into(),
                allowed: format!("write {}", key.stem),
                ..Mistake::default()
            }
        }
        _ => return None,
    };
    Some(Unknown { mistake, meant: Some(key) })
}

/// The right key in the wrong section.
fn elsewhere<'s>(section: &'s Section, written: &str) -> Option<Unknown<'s>> {
    let others = fields::sections().iter().filter(|other| other.name != section.name);
    let places: Vec<String> =
        others.filter(|other| other.find(written).is_some()).map(Section::place).collect();
    if places.is_empty() {
        return None;
    }
    let problem = format!("the key belongs to {}", places.join(" or "));
    let allowed = format!("allowed here: {}", keys(section));
    Some(Unknown { mistake: Mistake { problem, allowed, ..Mistake::default() }, meant: None })
}

fn misspelled<'s>(section: &'s Section, written: &str) -> Unknown<'s> {
    let names: Vec<(String, &Key)> =
        section.keys.iter().flat_map(|key| key.names().map(move |name| (name, key))).collect();
    let nearest = nearest(written, names.iter().map(|(name, _)| &**name));
    let meant = names.iter().find(|(name, _)| Some(name) == nearest.as_ref()).map(|(_, key)| *key);
    let problem = "unknown key".into();
    let allowed = format!("allowed here: {}", keys(section));
    Unknown { mistake: Mistake { problem, allowed, nearest, ..Mistake::default() }, meant }
}

/// Says what is wrong with a section that is none.
pub(super) fn unknown_section(written: &str) -> Mistake {
    let names = || fields::sections().iter().map(|section| section.name).filter(|name| !name.is_empty());
    Mistake {
        key: written.into(),
        problem: "unknown section".into(),
        allowed: format!("allowed: {}", names().collect::<Vec<_>>().join(", ")),
        nearest: nearest(written, names()),
        ..Mistake::default()
    }
}

/// The keys of a section in their usual units.
fn keys(section: &Section) -> String {
    section.keys.iter().map(Key::usual).collect::<Vec<_>>().join(", ")
}

/// The most similar name, if any is similar enough to have been meant.
pub(crate) fn nearest<'a>(written: &str, names: impl Iterator<Item = &'a str>) -> Option<String> {
    const LONGEST: usize = 64;
    const SIMILAR: f64 = 0.85;
    if written.len() > LONGEST {
        return None;
    }
    let written = written.to_ascii_lowercase();
    names
        .map(|name| (name, strsim::jaro_winkler(&written, &name.to_ascii_lowercase())))
        .filter(|(_, similarity)| *similarity > SIMILAR)
        .max_by(|(_, a), (_, b)| a.total_cmp(b))
        .map(|(name, _)| name.to_owned())
}
