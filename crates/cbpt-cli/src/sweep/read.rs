//! Plans in TOML, and the tables of rows that they may name. Every mistake is told with its line and the remedy.
//!
//! ```toml
//! case = "drive.toml"            # beside the plan
//! design = "latin_hypercube"     # grid (the default), random, latin_hypercube; or table = "rows.csv"
//! rows = 100000                  # of a design that is drawn
//! seed = 1
//! columns = ["friction_torque_Nm", "efficiency"]   # further ones
//!
//! [axes]
//! load.torque_Nm = [1, 2, 5]
//! load.preload_N = { from = 200, to = 1000 }     # in a grid with count (or points, as in plans of runs) or step
//! ```

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use super::design::Design;
use super::{Axis, MOST_VALUES, Plan, Values};
use crate::case::document::{self, Content, Entry, Node};
use crate::case::error::{Mistake, Notes};
use crate::case::parameter::Parameter;
use crate::case::suggest::nearest;
use crate::case::{Case, CaseError};

/// The keys of a plan.
const KEYS: [&str; 7] = ["case", "design", "rows", "seed", "table", "columns", "axes"];
/// The keys of a range.
const RANGE: [&str; 6] = ["from", "to", "count", "points", "step", "scale"];
/// A list may be long, but a plan is no table.
const LARGEST: u64 = 1 << 26;

/// Whether the text of a file is that of a plan rather than of a case.
pub fn is_plan(text: &str) -> bool {
    let mut notes = Notes::of(text);
    let entries = document::from_toml(text.strip_prefix('\u{feff}').unwrap_or(text), &mut notes);
    entries.unwrap_or_default().iter().any(|entry| KEYS.contains(&&*entry.key))
}

impl Plan {
    /// Reads a plan, the case that it names and, where it names one, the table of its rows; both beside the plan.
    ///
    /// # Errors
    /// Every mistake of the plan with its line, or those of the case.
    pub fn read(path: &Path) -> Result<Self, CaseError> {
        let name = path.display().to_string();
        let text = text_of(path, "plan")?;
        let text = text.strip_prefix('\u{feff}').unwrap_or(&text);
        let mut notes = Notes::of(text);
        let entries = document::from_toml(text, &mut notes);
        let found = match &entries {
            Some(entries) => plan(entries, path, &mut notes)?,
            None => None,
        };
        notes.or(&name, found)
    }
}

fn text_of(path: &Path, what: &str) -> Result<String, CaseError> {
    let name = path.display().to_string();
    match std::fs::metadata(path) {
        Ok(data) if data.is_dir() => Err(CaseError::whole(&name, format!("is a directory, not a {what}"))),
        Ok(data) if data.len() > LARGEST && what == "plan" => Err(CaseError::whole(
            &name,
            "the file is larger than 64 MiB, too large for a plan; put the values into a table",
        )),
        _ => std::fs::read_to_string(path).map_err(|error| {
            let problem = match error.kind() {
                std::io::ErrorKind::NotFound => "file not found".into(),
                _ => format!("cannot be read: {error}"),
            };
            CaseError::whole(&name, problem)
        }),
    }
}

fn wrong(key: &str, node: &Node, allowed: impl Into<String>) -> Mistake {
    Mistake { key: key.into(), found: node.written.clone(), allowed: allowed.into(), ..Mistake::default() }
}

/// The file that a key names, looked for beside the plan.
fn beside(plan: &Path, node: &Node, key: &str, notes: &mut Notes<'_>) -> Option<PathBuf> {
    if let Content::Text(name) = &node.content {
        return Some(plan.parent().unwrap_or(Path::new("")).join(name));
    }
    notes.add(node.at, wrong(key, node, "expected the name of a file in quotes"));
    None
}

/// The words of a key that is a list of them; `None` where it is something else.
fn words(entry: Option<&Entry>, notes: &mut Notes<'_>) -> Option<Vec<String>> {
    let Some(Entry { key, node, .. }) = entry else { return Some(Vec::new()) };
    let word = |item: &Node| match &item.content {
        Content::Text(word) => Some(word.clone()),
        _ => None,
    };
    let found = match &node.content {
        Content::List(items) => items.iter().map(word).collect::<Option<Vec<String>>>(),
        _ => None,
    };
    if found.is_none() {
        notes.add(node.at, wrong(key, node, "expected a list of names in quotes"));
    }
    found
}

/// The whole number of a key.
fn whole(entry: Option<&Entry>, notes: &mut Notes<'_>) -> Option<u64> {
    let Entry { key, node, .. } = entry?;
    let number = match node.content {
        Content::Number(number) => format!("{number}").parse::<u64>().ok(),
        _ => None,
    };
    if number.is_none() {
        notes.add(node.at, wrong(key, node, "expected a whole number, not negative"));
    }
    number
}

/// The plan of a file, if it can be made; mistakes of the plan are in the notes, those of its case are the error.
fn plan(entries: &[Entry], path: &Path, notes: &mut Notes<'_>) -> Result<Option<Plan>, CaseError> {
    for entry in entries.iter().filter(|entry| !KEYS.contains(&&*entry.key)) {
        if notes.full() {
            return Ok(None);
        }
        notes.add(entry.at, unknown(&entry.key, &entry.key, &KEYS));
    }
    let entry = |key: &str| entries.iter().find(|entry| entry.key == key);
    let Some(case) = entry("case") else {
        let allowed = "name the case file: case = \"drive.toml\"";
        notes.add(None, super::mistake("case", "missing", allowed));
        return Ok(None);
    };
    let Some(case_path) = beside(path, &case.node, "case", notes) else { return Ok(None) };
    let case = Case::read(&case_path)?;
    let (rows, seed) = (whole(entry("rows"), notes), whole(entry("seed"), notes).unwrap_or(0));
    let design = design(entry("design"), entry("table"), notes);
    let (given, table) = (entry("axes"), entry("table"));
    let mut sources = vec![path.to_owned(), case_path];
    let axes = match (table, given) {
        (Some(table), None) => match beside(path, &table.node, "table", notes) {
            Some(path) => {
                let axes = table_axes(&case, &path)?;
                sources.push(path);
                axes
            }
            None => Vec::new(),
        },
        (Some(_), Some(axes)) => {
            let allowed = "the columns of the table are the axes: leave [axes] out";
            notes.add(axes.at, super::mistake("axes", "the plan names a table as well", allowed));
            Vec::new()
        }
        (None, Some(axes)) => axes_of(&case, axes, design, notes),
        (None, None) => {
            let allowed = "name what varies: [axes] with load.torque_Nm = { from = 0, to = 10, count = 41 }";
            notes.add(None, super::mistake("axes", "missing", allowed));
            Vec::new()
        }
    };
    if !notes.is_empty() {
        return Ok(None);
    }
    let Some(columns) = words(entry("columns"), notes) else { return Ok(None) };
    let made = Plan::new(case, axes, design, rows, seed).and_then(|plan| plan.with_columns(&columns));
    match made {
        Ok(plan) => {
            let axes = leaves(given);
            let notes = axes.iter().filter_map(|(name, entry)| short_of_end(&plan, name, entry)).collect();
            Ok(Some(Plan { sources, notes, ..plan }))
        }
        Err(mistake) => {
            let axis = || leaves(given).into_iter().find(|(name, _)| *name == mistake.key);
            let at = entry(&mistake.key).or_else(|| axis().map(|(_, entry)| entry)).or(given);
            let at = at.and_then(|entry| entry.at);
            notes.add(at, mistake);
            Ok(None)
        }
    }
}

fn unknown(key: &str, written: &str, known: &[&'static str]) -> Mistake {
    Mistake {
        nearest: nearest(written, known.iter().copied()),
        ..super::mistake(key, "unknown key", &format!("allowed here: {}", known.join(", ")))
    }
}

fn design(entry: Option<&Entry>, table: Option<&Entry>, notes: &mut Notes<'_>) -> Design {
    let fallback = if table.is_some() { Design::Table } else { Design::Grid };
    let Some(Entry { node, .. }) = entry else { return fallback };
    let words: Vec<&str> = Design::ALL.iter().map(|(name, _)| *name).collect();
    let written = if let Content::Text(text) = &node.content { text.as_str() } else { "" };
    match Design::ALL.iter().find(|(name, _)| *name == written) {
        Some((_, design)) if (*design == Design::Table) == table.is_some() => *design,
        Some(_) => {
            let allowed = "design = \"table\" goes with table = \"rows.csv\", and only with it";
            notes.add(node.at, wrong("design", node, allowed));
            fallback
        }
        None => {
            let nearest = nearest(written, words.iter().copied());
            let allowed = format!("expected one of {}", words.join(", "));
            notes.add(node.at, Mistake { nearest, ..wrong("design", node, allowed) });
            fallback
        }
    }
}

/// The axes, whose names may be written as tables within tables.
fn axes_of(case: &Case, axes: &Entry, design: Design, notes: &mut Notes<'_>) -> Vec<Axis> {
    let mut found = Vec::new();
    let Content::Table(entries) = &axes.node.content else {
        notes.add(axes.at, wrong("axes", &axes.node, "expected a section, [axes]"));
        return found;
    };
    if entries.is_empty() {
        notes.add(axes.at, super::mistake("axes", "no axis", "give at least one"));
    }
    for (name, entry) in leaves(Some(axes)) {
        if notes.full() {
            break;
        }
        // What is wrong with the values is told by then.
        let Some(values) = values(&name, &entry.node, design, notes) else { continue };
        match Axis::new(case, &name, values) {
            Ok(axis) => found.push(axis),
            Err(mistake) => notes.add(entry.at, mistake),
        }
    }
    found
}

/// The entries that are an axis each, with their whole names.
fn leaves(axes: Option<&Entry>) -> Vec<(String, &Entry)> {
    let Some(Content::Table(entries)) = axes.map(|axes| &axes.node.content) else { return Vec::new() };
    let mut left: Vec<(String, &Entry)> =
        entries.iter().rev().map(|entry| (entry.key.clone(), entry)).collect();
    let mut found = Vec::new();
    while let Some((name, entry)) = left.pop() {
        match &entry.node.content {
            Content::Table(inner) if !inner.iter().any(|entry| RANGE.contains(&&*entry.key)) => {
                left.extend(inner.iter().rev().map(|inner| (format!("{name}.{}", inner.key), inner)));
            }
            _ => found.push((name, entry)),
        }
    }
    found
}

fn values(name: &str, node: &Node, design: Design, notes: &mut Notes<'_>) -> Option<Values> {
    match &node.content {
        Content::Number(number) => Some(Values::Numbers(vec![*number])),
        Content::Text(word) => Some(Values::words(std::slice::from_ref(word))),
        Content::List(items) => list(name, node, items, notes),
        Content::Table(entries) => range(name, node, entries, design, notes),
        Content::Other => {
            let allowed = "expected a number, a list, or a range { from = 0, to = 10, count = 41 }";
            notes.add(node.at, wrong(name, node, allowed));
            None
        }
    }
}

fn list(name: &str, node: &Node, items: &[Node], notes: &mut Notes<'_>) -> Option<Values> {
    let numbers =
        items.iter().map(|item| if let Content::Number(number) = item.content { Some(number) } else { None });
    let words = items
        .iter()
        .map(|item| if let Content::Text(text) = &item.content { Some(text.clone()) } else { None });
    if let Some(numbers) = numbers.collect::<Option<Vec<f64>>>() {
        return Some(Values::Numbers(numbers));
    }
    if let Some(words) = words.collect::<Option<Vec<String>>>() {
        return Some(Values::words(&words));
    }
    let allowed = "expected a list of numbers only, or of words only";
    notes.add(node.at, wrong(name, node, allowed));
    None
}

fn range(
    name: &str,
    node: &Node,
    entries: &[Entry],
    design: Design,
    notes: &mut Notes<'_>,
) -> Option<Values> {
    let before = notes.count();
    let mut numbers = BTreeMap::new();
    let mut log = false;
    for entry in entries {
        let key = format!("{name}.{}", entry.key);
        match (&*entry.key, &entry.node.content) {
            ("scale", Content::Text(scale)) if scale == "log" => log = true,
            ("scale", Content::Text(scale)) if scale == "linear" => {}
            ("scale", _) => notes.add(entry.at, wrong(&key, &entry.node, "expected \"linear\" or \"log\"")),
            (known, Content::Number(number)) if RANGE.contains(&known) && number.is_finite() => {
                numbers.insert(known, *number);
            }
            (known, _) if RANGE.contains(&known) => {
                notes.add(entry.at, wrong(&key, &entry.node, "expected a finite number"));
            }
            (other, _) => notes.add(entry.at, unknown(&key, other, &RANGE)),
        }
    }
    let number = |key: &str| numbers.get(key).copied();
    let (from, to) = (number("from"), number("to"));
    if notes.count() > before {
        return None;
    }
    let (Some(from), Some(to)) = (from, to) else {
        let allowed = "a range needs both from and to";
        notes.add(node.at, super::mistake(name, "an end is missing", allowed));
        return None;
    };
    if number("count").is_some() && number("points").is_some() {
        let allowed = "count and points are the same; give one of them";
        notes.add(node.at, super::mistake(name, "no range", allowed));
        return None;
    }
    let (count, step) = (number("count").or(number("points")), number("step"));
    let values = match (count, step) {
        (None, None) if design.is_drawn() => Ok(Values::Between { from, to, log }),
        (None, None) => Err("give the number of values, count = 41, or their distance, step = 0.5"),
        (Some(_), Some(_)) => Err("give count or step, not both"),
        (None, Some(_)) if log => Err("a logarithmic scale needs count, not step"),
        (None, Some(step)) => stepped(from, to, step).map(Values::Numbers),
        (Some(count), None) => counted(from, to, count, log).map(Values::Numbers),
    };
    values.map_err(|allowed| notes.add(node.at, super::mistake(name, "no range", allowed))).ok()
}

/// That the steps of an axis do not lead to its end.
fn short_of_end(plan: &Plan, name: &str, entry: &Entry) -> Option<String> {
    let Content::Table(range) = &entry.node.content else { return None };
    let number = |key: &str| match range.iter().find(|entry| entry.key == key)?.node.content {
        Content::Number(number) => Some(number),
        _ => None,
    };
    let (step, to) = (number("step")?, number("to")?);
    let axis = plan.axes().iter().find(|axis| axis.parameter.name == name)?;
    let Values::Numbers(numbers) = &axis.values else { return None };
    let last = *numbers.last()?;
    ((to - last).abs() > 1e-6 * step.abs())
        .then(|| format!("{name}: the last value is {last}, not {to}, because {to} is not a whole number of steps of {step} away"))
}

/// From one number to the other in steps, as far as they lead.
fn stepped(from: f64, to: f64, step: f64) -> Result<Vec<f64>, &'static str> {
    let count = ((to - from) / step + 1e-9).floor();
    if step == 0.0 || !(0.0..MOST_VALUES).contains(&count) {
        return Err("the step must lead from one end to the other, in at most a hundred million steps");
    }
    // Checked just above.
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    let count = count as u32;
    Ok((0..=count).map(|i| from + f64::from(i) * step).collect())
}

/// So many numbers, both ends among them.
fn counted(from: f64, to: f64, count: f64, log: bool) -> Result<Vec<f64>, &'static str> {
    if count.fract() != 0.0 || !(1.0..MOST_VALUES).contains(&count) {
        return Err("count must be a whole number from 1 to a hundred million");
    }
    if count < 2.0 && (from - to).abs() > 0.0 {
        return Err("count must be 2 or more, so that both ends are among the values");
    }
    if log && (from <= 0.0 || to <= 0.0) {
        return Err("a logarithmic scale must lie above 0");
    }
    // Checked just above.
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    let last = count as u32 - 1;
    let at = |i: u32| {
        let share = f64::from(i) / f64::from(last.max(1));
        if i == last {
            to
        } else if log {
            from * (to / from).powf(share)
        } else {
            from + share * (to - from)
        }
    };
    Ok((0..=last).map(at).collect())
}

/// The axes of a table: a column each, headed by the name of the axis.
fn table_axes(case: &Case, path: &Path) -> Result<Vec<Axis>, CaseError> {
    let name = path.display().to_string();
    let bytes = text_of(path, "table")?;
    let text = bytes.strip_prefix('\u{feff}').unwrap_or(&bytes);
    let mut reader = ::csv::ReaderBuilder::new().trim(::csv::Trim::All).from_reader(text.as_bytes());
    let broken =
        |error: ::csv::Error| CaseError::whole(&name, format!("the file is not a table in CSV: {error}"));
    let names: Vec<String> = reader.headers().map_err(broken)?.iter().map(str::to_owned).collect();
    if let Some(separator) =
        [';', '\t'].into_iter().find(|&other| names.len() == 1 && names[0].contains(other))
    {
        let problem = format!(
            "the columns are separated by {separator:?}; separate them by commas, and write decimals with a point"
        );
        return Err(CaseError::whole(&name, problem));
    }
    let parameters: Vec<Result<Parameter, Mistake>> =
        names.iter().map(|name| Parameter::find(case, name)).collect();
    let unknown = parameters.iter().filter_map(|found| found.as_ref().err());
    let mut mistakes: Vec<Mistake> =
        unknown.map(|mistake| Mistake { line: Some(1), ..mistake.clone() }).collect();
    let mut words: Vec<Vec<String>> = vec![Vec::new(); names.len()];
    let mut numbers: Vec<Vec<f64>> = vec![Vec::new(); names.len()];
    let mut rows = 0;
    for record in reader.records() {
        let record = record.map_err(broken)?;
        rows += 1;
        for (column, (cell, parameter)) in record.iter().zip(&parameters).enumerate() {
            let Ok(parameter) = parameter else { continue };
            let checked = if parameter.words().is_some() {
                words[column].push(cell.to_owned());
                parameter.check_word(cell)
            } else {
                let number = cell.parse().unwrap_or(f64::NAN);
                numbers[column].push(number);
                parameter
                    .check_number(number)
                    .map_err(|mistake| Mistake { found: format!("{cell:?}"), ..mistake })
            };
            if let (Err(mistake), true) = (checked, mistakes.len() < CaseError::MOST) {
                let line = record.position().and_then(|position| usize::try_from(position.line()).ok());
                mistakes.push(Mistake { line, ..mistake });
            }
        }
    }
    if !mistakes.is_empty() {
        return Err(CaseError { name, mistakes });
    }
    if rows == 0 {
        return Err(CaseError::whole(&name, "has no rows"));
    }
    let axes = parameters.into_iter().flatten().zip(words).zip(numbers);
    Ok(axes
        .map(|((parameter, words), numbers)| {
            let values = if words.is_empty() { Values::Numbers(numbers) } else { Values::words(&words) };
            Axis { parameter, values }
        })
        .collect())
}
