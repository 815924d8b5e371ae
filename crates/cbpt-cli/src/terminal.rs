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
    fn only_the_colours_are_added() {
        let text =
            "cbpt: c.toml:3: key: wrong\n  3 | key = 1\n    | ^\nNote: so\nHeading:\n┌──┐\n│ a │\nplain";
        let shown = painted(text);
        assert_eq!(anstream::adapter::strip_str(&shown).to_string(), text);
        assert!(shown.contains("\x1b[1;31m^\x1b[0m") && shown.ends_with("\nplain"));
    }
}
