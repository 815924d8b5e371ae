//! What is wrong with a case file: all of it at once, each mistake with its line, its key and what to write instead.

use std::fmt;

/// A case file that cannot be read, with every mistake in it.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{}", report(.name, .mistakes, false))]
pub struct CaseError {
    /// Name of the file; empty where the case did not come from a file.
    pub name: String,
    /// The mistakes in the order of the file, at most [`CaseError::MOST`].
    pub mistakes: Vec<Mistake>,
}

impl CaseError {
    /// The error with the line of the file under each mistake, and a caret under its place: for a terminal.
    pub fn shown(&self) -> String {
        report(&self.name, &self.mistakes, true)
    }

    /// Reading stops after so many mistakes.
    pub const MOST: usize = 100;
    /// So many of them are told.
    pub const TOLD: usize = 20;

    /// The file as a whole cannot be read.
    pub(crate) fn whole(name: &str, problem: impl Into<String>) -> Self {
        Self { name: name.into(), mistakes: vec![Mistake { problem: problem.into(), ..Mistake::default() }] }
    }

    /// A file that stops being UTF-8 after these bytes.
    pub(crate) fn not_utf8(name: &str, valid: &[u8]) -> Self {
        let mut notes = Notes::of(std::str::from_utf8(valid).unwrap_or_default());
        let problem = "not UTF-8 text".into();
        let allowed = "save the file as UTF-8".into();
        notes.add(Some(valid.len()), Mistake { problem, allowed, ..Mistake::default() });
        Self { name: name.into(), mistakes: notes.mistakes }
    }
}

/// One mistake. Its text is one line without the name of the file.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Mistake {
    /// Line, from 1; none for a case that did not come from a file, and for what the file lacks.
    pub line: Option<usize>,
    /// Column in characters, from 1.
    pub column: Option<usize>,
    /// That line as it was written, as much of it as a terminal shows, with a caret below.
    pub excerpt: Option<String>,
    /// Dotted key as it was written; empty where the whole file is meant.
    pub key: String,
    /// The value as it was written; empty where the key itself is the mistake.
    pub found: String,
    /// Place in an expression that was found, in characters from 1.
    pub character: Option<usize>,
    /// What is wrong; empty where `allowed` says it all.
    pub problem: String,
    /// What is allowed instead.
    pub allowed: String,
    /// The nearest right key or word.
    pub nearest: Option<String>,
}

impl Mistake {
    /// What is wrong and what to write instead, without the key and the value.
    pub fn words(&self) -> String {
        let mut words = self.problem.clone();
        if let Some(nearest) = &self.nearest {
            let lead = if words.is_empty() { "" } else { "; " };
            words += &format!("{lead}did you mean {nearest}?");
        }
        let mut allowed = self.allowed.chars();
        match allowed.next() {
            Some(first) if self.nearest.is_some() => {
                words += &format!(" {}{}", first.to_uppercase(), allowed.as_str());
            }
            Some(_) if !words.is_empty() => words += &format!("; {}", self.allowed),
            _ => words += &self.allowed,
        }
        words
    }
}

impl fmt::Display for Mistake {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.key)?;
        if !self.found.is_empty() {
            write!(f, " = {}", self.found)?;
        }
        if let Some(character) = self.character {
            write!(f, ", character {character}")?;
        }
        let words = self.words();
        let lead = if self.key.is_empty() || words.is_empty() { "" } else { ": " };
        write!(f, "{lead}{words}")
    }
}

fn report(name: &str, mistakes: &[Mistake], excerpts: bool) -> String {
    let mut lines = Vec::new();
    for mistake in mistakes.iter().take(CaseError::TOLD) {
        lines.push(match (name, mistake.line) {
            ("", _) => mistake.to_string(),
            (_, None) => format!("{name}: {mistake}"),
            (_, Some(line)) => format!("{name}:{line}: {mistake}"),
        });
        lines.extend(mistake.excerpt.clone().filter(|_| excerpts));
    }
    if mistakes.len() > CaseError::TOLD {
        let at_least = if mistakes.len() < CaseError::MOST { "" } else { "at least " };
        lines.push(format!("and {at_least}{} more", mistakes.len() - CaseError::TOLD));
    }
    lines.join("\n")
}

/// A line of a file with its number, and a caret under a column; both from 1.
fn excerpt(line: usize, text: &str, column: usize) -> String {
    const MOST: usize = 90;
    // A long line is shown from a little before the place; nothing in it may steer the terminal.
    let from = if column > MOST { column - MOST / 2 } else { 1 };
    let shown = text.trim_end().chars().skip(from - 1).take(MOST);
    let shown: String =
        shown.map(|c| if c.is_control() && c != '\t' { char::REPLACEMENT_CHARACTER } else { c }).collect();
    let before = shown.chars().take(column - from);
    let indent: String = before.map(|c| if c == '\t' { c } else { ' ' }).collect();
    let number = line.to_string();
    format!("  {number} | {shown}\n  {} | {indent}^", " ".repeat(number.len()))
}

/// Collects mistakes while a case is read, and finds their lines.
pub(crate) struct Notes<'t> {
    text: &'t str,
    /// Bytes where a line begins. A text is searched for them once, however many mistakes it has.
    lines: Vec<usize>,
    mistakes: Vec<Mistake>,
}

impl<'t> Notes<'t> {
    /// For the text that the offsets of the mistakes refer to.
    pub(crate) fn of(text: &'t str) -> Self {
        let after = text.match_indices('\n').map(|(newline, _)| newline + 1);
        Self { text, lines: std::iter::once(0).chain(after).collect(), mistakes: Vec::new() }
    }

    /// Notes a mistake at a byte of the text.
    pub(crate) fn add(&mut self, at: Option<usize>, mistake: Mistake) {
        if !self.full() {
            let place = at.map(|at| self.position(at));
            let excerpt = place.map(|(line, column)| excerpt(line, self.line_text(line), column));
            let ((line, column), key) = (place.unzip(), shortened(&mistake.key));
            self.mistakes.push(Mistake { line, column, excerpt, key, ..mistake });
        }
    }

    /// Line of a byte of the text.
    pub(crate) fn line(&self, at: usize) -> usize {
        self.lines.partition_point(|start| *start <= at)
    }

    /// Line and column of a byte, from 1.
    fn position(&self, at: usize) -> (usize, usize) {
        let line = self.line(at);
        let start = self.lines[line - 1];
        let before = self.text.get(start..at).or(self.text.get(start..)).unwrap_or_default();
        (line, before.chars().count() + 1)
    }

    /// The text of a line, from 1.
    fn line_text(&self, line: usize) -> &'t str {
        let end = self.lines.get(line).copied().unwrap_or(self.text.len());
        self.text.get(self.lines[line - 1]..end).unwrap_or_default()
    }

    /// How many mistakes were noted.
    pub(crate) fn count(&self) -> usize {
        self.mistakes.len()
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.mistakes.is_empty()
    }

    /// Whether no more mistakes are noted.
    pub(crate) fn full(&self) -> bool {
        self.mistakes.len() >= CaseError::MOST
    }

    /// The error, or `whole` where there is no mistake.
    pub(crate) fn or<T>(mut self, name: &str, whole: Option<T>) -> Result<T, CaseError> {
        match whole {
            Some(whole) if self.mistakes.is_empty() => Ok(whole),
            _ => {
                self.mistakes.sort_by_key(|mistake| (mistake.line.is_none(), mistake.line, mistake.column));
                Err(CaseError { name: name.into(), mistakes: self.mistakes })
            }
        }
    }
}

/// The first line, so far as a message can hold it.
pub(crate) fn shortened(written: &str) -> String {
    const LONGEST: usize = 80;
    let line = written.lines().next().unwrap_or_default();
    let mut short: String = line.chars().take(LONGEST).collect();
    if short.len() < written.len() {
        short.push_str("...");
    }
    short
}
