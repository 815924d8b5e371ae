//! TOML text or a JSON value as one plain tree that remembers where everything stood.

use std::collections::BTreeSet;
use std::ops::Range;

use serde_json::Value as Json;
use toml::de::{DeTable, DeValue};

use super::error::{Mistake, Notes, shortened};

/// A key and what stands behind it.
#[derive(Debug, Clone)]
pub(crate) struct Entry {
    pub(crate) key: String,
    /// Byte of the text where the key starts.
    pub(crate) at: Option<usize>,
    pub(crate) node: Node,
}

/// A value of the file.
#[derive(Debug, Clone)]
pub(crate) struct Node {
    pub(crate) at: Option<usize>,
    /// The value as it was written.
    pub(crate) written: String,
    pub(crate) content: Content,
}

/// What a value is.
#[derive(Debug, Clone)]
pub(crate) enum Content {
    Text(String),
    Number(f64),
    Table(Vec<Entry>),
    List(Vec<Node>),
    /// Nothing that any key takes: a date, a truth value, null, or nested too deep.
    Other,
}

/// Tables and arrays deeper than this are in no case file.
const DEEPEST: usize = 8;

/// Parses TOML; every line with a mistake of syntax is noted, by its first: the others mostly follow from it. Stops where the
/// notes are full.
pub(crate) fn from_toml(text: &str, notes: &mut Notes<'_>) -> Option<Vec<Entry>> {
    let (table, errors) = DeTable::parse_recoverable(text);
    let mut lines = BTreeSet::new();
    for error in &errors {
        let at = error.span().map_or(text.len(), |span| span.start);
        if notes.full() {
            break;
        }
        if !lines.insert(notes.line(at)) {
            continue;
        }
        let (before, after) = text.split_at_checked(at).unwrap_or((text, ""));
        let line = [before.lines().next_back().filter(|_| !before.ends_with('\n')), after.lines().next()];
        let line: String = line.into_iter().flatten().collect();
        let problem = format!("not valid TOML: {}, in `{}`", error.message(), shortened(line.trim()));
        let allowed = match error.message() {
            "duplicate key" => "write each key and each section once",
            _ if decimal_comma(before, after) => "write 1.5, not 1,5",
            _ => "",
        };
        notes.add(Some(at), Mistake { problem, allowed: allowed.into(), ..Mistake::default() });
    }
    errors.is_empty().then(|| toml_entries(text, table.get_ref(), DEEPEST))
}

/// Whether a comma stands between digits there.
fn decimal_comma(before: &str, after: &str) -> bool {
    let digit = |c: char| c.is_ascii_digit();
    before.ends_with(digit) && after.strip_prefix(',').is_some_and(|after| after.starts_with(digit))
}

/// The entries in the order of the file.
fn toml_entries(text: &str, table: &DeTable<'_>, depth: usize) -> Vec<Entry> {
    let mut entries: Vec<Entry> = table
        .iter()
        .map(|(key, value)| Entry {
            key: key.get_ref().to_string(),
            at: Some(key.span().start),
            node: toml_node(text, value.get_ref(), value.span(), depth),
        })
        .collect();
    entries.sort_by_key(|entry| entry.at);
    entries
}

fn toml_node(text: &str, value: &DeValue<'_>, span: Range<usize>, depth: usize) -> Node {
    let at = Some(span.start);
    let content = match value {
        DeValue::String(text) => Content::Text(text.to_string()),
        DeValue::Integer(number) => Content::Number(match number.radix() {
            10 => number.as_str().parse().unwrap_or(f64::NAN),
            radix => i64::from_str_radix(number.as_str(), radix).map_or(f64::NAN, |number| number as f64),
        }),
        DeValue::Float(number) => Content::Number(number.as_str().parse().unwrap_or(f64::NAN)),
        DeValue::Table(table) if depth > 0 => Content::Table(toml_entries(text, table, depth - 1)),
        DeValue::Array(array) if depth > 0 => Content::List(
            array.iter().map(|item| toml_node(text, item.get_ref(), item.span(), depth - 1)).collect(),
        ),
        _ => Content::Other,
    };
    let written = match value {
        DeValue::Table(_) => "a table".into(),
        DeValue::Array(_) => "an array".into(),
        _ => shortened(text.get(span).unwrap_or_default()),
    };
    Node { at, written, content }
}

/// The entries of a JSON object, if it is one.
pub(crate) fn from_json(value: &Json, notes: &mut Notes<'_>) -> Option<Vec<Entry>> {
    if let Content::Table(entries) = json_node(value, DEEPEST).content {
        Some(entries)
    } else {
        let problem = "a case is an object with the sections of a case file".into();
        notes.add(None, Mistake { problem, ..Mistake::default() });
        None
    }
}

fn json_node(value: &Json, depth: usize) -> Node {
    let (content, written) = match value {
        Json::String(text) => (Content::Text(text.clone()), shortened(&format!("{text:?}"))),
        Json::Number(number) => (Content::Number(number.as_f64().unwrap_or(f64::NAN)), number.to_string()),
        Json::Object(object) if depth > 0 => {
            let entry = |(key, value): (&String, &Json)| Entry {
                key: key.clone(),
                at: None,
                node: json_node(value, depth - 1),
            };
            (Content::Table(object.iter().map(entry).collect()), "a table".into())
        }
        Json::Array(array) if depth > 0 => {
            (Content::List(array.iter().map(|item| json_node(item, depth - 1)).collect()), "an array".into())
        }
        Json::Null => (Content::Other, "null".into()),
        Json::Bool(truth) => (Content::Other, truth.to_string()),
        Json::Object(_) | Json::Array(_) => (Content::Other, "a nested value".into()),
    };
    Node { at: None, written, content }
}
