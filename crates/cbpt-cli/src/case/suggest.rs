//! What a key that nobody knows may have meant.

use cbpt_core::units::{self, Unit};

use super::document::Content;
use super::error::{Mistake, shortened};
use super::fields;
use super::keys::{Key, Kind, Section};

/// A diagnosis, and the key that must have been meant, if that is clear.
pub(super) struct Unknown<'s> {
    pub(super) mistake: Mistake,
    pub(super) meant: Option<&'s Key>,
}

/// Says what is wrong with a key that the section does not have; `content` is what stands behind it.
pub(super) fn unknown_key<'s>(section: &'s Section, written: &str, content: &Content) -> Unknown<'s> {
    unit_forgotten(section, written)
        .or_else(|| unit_unknown(section, written))
        .or_else(|| elsewhere(section, written))
        .unwrap_or_else(|| misspelled(section, written, content))
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
    if knows(section, written) {
        return None;
    }
    let others = fields::sections().iter().filter(|other| other.name != section.name);
    let places: Vec<String> = others.filter(|other| knows(other, written)).map(Section::place).collect();
    if places.is_empty() {
        return None;
    }
    let problem = format!("the key belongs to {}", places.join(" or "));
    let allowed = format!("allowed here: {}", keys(section));
    Some(Unknown { mistake: Mistake { problem, allowed, ..Mistake::default() }, meant: None })
}

/// Whether a section has a key that is written so, or that people write so.
fn knows(section: &Section, written: &str) -> bool {
    section.keys.iter().flat_map(forms).any(|form| form.written == written)
}

/// A way to write a key, wrong ones among them.
struct Form<'s> {
    written: String,
    key: &'s Key,
    unit: &'static Unit,
    /// What the number that stands behind it has to be multiplied by.
    factor: f64,
}

/// Every way to write a key, and what people write in its place: `balls` for `ball_count`, diameters for radii.
fn forms(key: &Key) -> impl Iterator<Item = Form<'_>> {
    let mut stems = vec![(key.stem.to_string(), 1.0)];
    if let Some(one) = key.stem.strip_suffix("_count") {
        let other =
            [format!("{one}s"), format!("n_{one}s"), format!("number_of_{one}s"), format!("{one}_number")];
        stems.extend(other.map(|stem| (stem, 1.0)));
    }
    if key.stem.contains("radius") {
        stems.extend(["diameter", "dia"].map(|word| (key.stem.replace("radius", word), 0.5)));
    }
    stems.into_iter().flat_map(move |(stem, factor)| {
        let form = move |unit: &'static Unit| Form { written: unit.name(&stem), key, unit, factor };
        key.units().iter().map(form)
    })
}

fn misspelled<'s>(section: &'s Section, written: &str, content: &Content) -> Unknown<'s> {
    let forms: Vec<Form<'s>> = section.keys.iter().flat_map(forms).collect();
    let near = nearest(written, forms.iter().map(|form| &*form.written));
    let form = forms.into_iter().find(|form| Some(&form.written) == near.as_ref());
    let (mut problem, allowed) = ("unknown key".to_owned(), format!("allowed here: {}", keys(section)));
    let nearest = form.as_ref().map(|form| {
        // A unit that was not written is none that was meant.
        let stated = written.ends_with(&format!("_{}", form.unit.symbol));
        let name = if stated { form.key.with(form.unit) } else { form.key.usual() };
        if (form.factor - 1.0).abs() < f64::EPSILON {
            return name;
        }
        "a case states the radius, which is half of the diameter".clone_into(&mut problem);
        match content {
            Content::Number(number) if stated => format!("{name} = {}", number * form.factor),
            _ => name,
        }
    });
    let meant = form.map(|form| form.key);
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
