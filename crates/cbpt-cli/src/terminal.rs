//! The terminal: how wide text may be, and whether and how it is coloured. Both command lines follow it.

use std::io;

use anstream::{AutoStream, ColorChoice};
use terminal_size::{Width, terminal_size_of};

/// Columns of text that goes to a file or to a program.
const WIDTH: u16 = 100;
/// Tables are not pressed into less.
const LEAST: u16 = 60;

/// Columns that text on standard output may take.
pub fn width() -> u16 {
    terminal_size_of(io::stdout()).map_or(WIDTH, |(Width(columns), _)| columns.max(LEAST))
}

/// Whether standard output, or standard error, shows colours: a terminal that can, and `NO_COLOR` is not set.
pub fn colour(error: bool) -> bool {
    let choice = if error { AutoStream::choice(&io::stderr()) } else { AutoStream::choice(&io::stdout()) };
    choice != ColorChoice::Never
}

/// A text as the terminal takes it.
pub(crate) fn for_terminal(text: &str, error: bool) -> String {
    if colour(error) { painted(text) } else { text.to_owned() }
}

/// A text whose lines of prose run on below where the terminal ends; in a file a line stays one.
pub(crate) fn folded(text: &str) -> String {
    match terminal_size_of(io::stdout()) {
        Some((Width(columns), _)) => folded_within(text, usize::from(columns.max(LEAST))),
        None => text.to_owned(),
    }
}

fn folded_within(text: &str, width: usize) -> String {
    let folded = |line: &str| {
        let prose = line.chars().count() > width && !line.starts_with(FRAMES);
        if prose { folded_line(line, width) } else { line.to_owned() }
    };
    text.split('\n').map(folded).collect::<Vec<_>>().join("\n")
}

fn folded_line(line: &str, width: usize) -> String {
    let indent = &line[..line.len() - line.trim_start().len()];
    let mut lines = vec![indent.to_owned()];
    let mut filled = indent.len();
    for word in line.split_whitespace() {
        let length = word.chars().count();
        if filled > indent.len() && filled + 1 + length > width {
            lines.push(indent.to_owned());
            filled = indent.len();
        }
        if let Some(last) = lines.last_mut() {
            if filled > indent.len() {
                last.push(' ');
                filled += 1;
            }
            last.push_str(word);
            filled += length;
        }
    }
    lines.join("\n")
}

/// What a line of a table starts with.
const FRAMES: [char; 5] = ['┌', '│', '╞', '├', '└'];

const BOLD: &str = "\x1b[1m";
const DIM: &str = "\x1b[2m";
const RED: &str = "\x1b[1;31m";
const YELLOW: &str = "\x1b[33m";
const END: &str = "\x1b[0m";

/// The text with colours: whose message it is, carets, headings, notes; the frames of tables are dim.
pub fn painted(text: &str) -> String {
    text.split('\n').map(painted_line).collect::<Vec<_>>().join("\n")
}

fn painted_line(line: &str) -> String {
    if let Some(rest) = line.strip_prefix("cbpt: ") {
        return format!("{RED}cbpt:{END} {rest}");
    }
    if let Some(carets) = line.strip_suffix('^').filter(|before| before.trim_start().starts_with('|')) {
        return format!("{DIM}{carets}{END}{RED}^{END}");
    }
    if line.starts_with("Note: ") || line.starts_with("warning: ") {
        return format!("{YELLOW}{line}{END}");
    }
    if line.starts_with("error: ") {
        return format!("{RED}{line}{END}");
    }
    if line.starts_with(['┌', '╞', '└', '├']) {
        return format!("{DIM}{line}{END}");
    }
    let heading = line.ends_with(':') && line.starts_with(|c: char| c.is_uppercase());
    if heading { format!("{BOLD}{line}{END}") } else { line.to_owned() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn prose_is_folded_between_words_and_tables_are_not() {
        let long = format!("│{}│", "─".repeat(80));
        let text = format!("  one two three four\n{long}\nshort");
        assert_eq!(folded_within(&text, 12), format!("  one two\n  three four\n{long}\nshort"));
    }

    #[test]
    fn only_the_colours_are_added() {
        let text =
            "cbpt: c.toml:3: key: wrong\n  3 | key = 1\n    | ^\nNote: so\nHeading:\n┌──┐\n│ a │\nplain";
        let shown = painted(text);
        assert_eq!(anstream::adapter::strip_str(&shown).to_string(), text);
        assert!(shown.contains("\x1b[1;31m^\x1b[0m") && shown.ends_with("\nplain"));
    }
}
