//! What a verb has to say, once: as text with tables, as one JSON object, as CSV.

use std::io::{self, Write};
use std::path::Path;

use comfy_table::presets::UTF8_FULL_CONDENSED;
use comfy_table::{CellAlignment, ColumnConstraint, ContentArrangement, Table as Drawn, Width};
use serde_json::{Map, Value, json};

use crate::args::OutputOptions;
use crate::exit::{Failure, keep_input};
use crate::{terminal, whole};

/// A table: headers and cells as JSON values, so that CSV keeps every digit and text rounds.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Table {
    /// Column names, with units.
    pub columns: Vec<String>,
    /// Cells, row by row.
    pub rows: Vec<Vec<Value>>,
}

impl Table {
    /// A table with these columns and no row yet.
    pub fn new(columns: impl IntoIterator<Item = impl Into<String>>) -> Self {
        Self { columns: columns.into_iter().map(Into::into).collect(), rows: Vec::new() }
    }

    /// The same with those columns only that `keep` wants.
    #[must_use]
    pub fn narrowed(&self, keep: impl Fn(&str) -> bool) -> Self {
        let kept: Vec<usize> = (0..self.columns.len()).filter(|&i| keep(&self.columns[i])).collect();
        let pick = |row: &Vec<Value>| kept.iter().filter_map(|&i| row.get(i).cloned()).collect();
        Self {
            columns: kept.iter().map(|&i| self.columns[i].clone()).collect(),
            rows: self.rows.iter().map(pick).collect(),
        }
    }

    /// As text, as wide as the terminal; numbers to six significant digits.
    pub fn text(&self) -> String {
        self.text_within(terminal::width())
    }

    /// The same, at most so many characters wide where words and names can run over several lines; numbers stay whole,
    /// and a few rows of many numbers become columns.
    pub fn text_within(&self, width: u16) -> String {
        let least = |table: &Self| table.least_widths(usize::from(width)).iter().map(|least| least + 3).sum();
        let fits = |table: &Self| -> bool { usize::from(width) > least(table) };
        if fits(self) {
            return self.drawn(width);
        }
        let folded = |table: &Self| WORDS.rev().map(|most| table.with_words(most)).find(fits);
        let turned = || (self.rows.len() <= MOST_TURNED).then(|| self.turned());
        folded(self)
            .or_else(|| folded(&turned()?))
            .unwrap_or_else(|| self.with_words(WORDS.start))
            .drawn(width)
    }

    /// Rows as columns, with the first cells as headings.
    fn turned(&self) -> Self {
        let mut columns = self.columns.iter().enumerate();
        let corner = columns.next().map(|(_, name)| name.clone()).unwrap_or_default();
        let heads = self.rows.iter().filter_map(|row| row.first().map(cell_text));
        let mut table = Self::new(std::iter::once(corner).chain(heads));
        for (index, name) in columns {
            let cells = self.rows.iter().map(|row| row.get(index).cloned().unwrap_or(Value::Null));
            table.rows.push(std::iter::once(json!(name)).chain(cells).collect());
        }
        table
    }

    /// The same with names in its cells broken where they are longer than so many characters.
    fn with_words(&self, most: usize) -> Self {
        let folded = |cell: &Value| match cell {
            Value::String(text) => json!(folded_words(text, most)),
            other => other.clone(),
        };
        let rows = self.rows.iter().map(|row| row.iter().map(folded).collect()).collect();
        Self { columns: self.columns.clone(), rows }
    }

    fn drawn(&self, width: u16) -> String {
        let cells: Vec<Vec<String>> =
            self.rows.iter().map(|row| row.iter().map(cell_text).collect()).collect();
        let widest = |index: usize| {
            let lines = cells.iter().filter_map(|row| row.get(index)).flat_map(|cell| cell.lines());
            lines.map(|line| line.chars().count()).max().unwrap_or(0)
        };
        // Headings run over several lines where the table would be too wide, and no more than they have to.
        let headed = |most: usize| -> Vec<String> {
            self.columns.iter().enumerate().map(|(i, name)| broken(name, widest(i).max(most))).collect()
        };
        let fits = |heads: &[String]| {
            let longest = |head: &String| head.lines().map(|line| line.chars().count()).max().unwrap_or(0);
            let columns = heads.iter().enumerate().map(|(i, head)| longest(head).max(widest(i)) + 3);
            columns.sum::<usize>() < usize::from(width)
        };
        let heads = (0..=40).rev().map(headed).find(|heads| fits(heads));
        let narrow = heads.is_none();
        let mut drawn = Drawn::new();
        drawn.load_style(UTF8_FULL_CONDENSED).set_content_arrangement(ContentArrangement::Disabled);
        if narrow {
            drawn.set_content_arrangement(ContentArrangement::Dynamic).set_width(width);
        }
        drawn.set_header(heads.unwrap_or_else(|| headed(0)));
        for row in cells {
            drawn.add_row(row);
        }
        let least = if narrow { self.least_widths(usize::from(width)) } else { Vec::new() };
        for (index, column) in drawn.column_iter_mut().enumerate() {
            if self.rows.iter().any(|row| row.get(index).is_some_and(Value::is_number)) {
                column.set_cell_alignment(CellAlignment::Right);
            }
            if let Some(least) = least.get(index).filter(|least| **least < 30) {
                let least = u16::try_from(least + 2).unwrap_or(u16::MAX);
                column.set_constraint(ColumnConstraint::LowerBoundary(Width::Fixed(least)));
            }
        }
        drawn.trim_fmt()
    }

    /// What each column needs so that no number and no name is broken, nor a part of a heading if there is room for that.
    fn least_widths(&self, width: usize) -> Vec<usize> {
        let longest =
            |text: &str| text.split(char::is_whitespace).map(|word| word.chars().count()).max().unwrap_or(0);
        let cells = |index: usize| {
            let cells = self.rows.iter().filter_map(move |row| row.get(index));
            cells.map(|cell| longest(&cell_text(cell))).max().unwrap_or(1)
        };
        let head = |name: &String| name.split_inclusive(BREAKS).map(longest).max().unwrap_or(0);
        let bare: Vec<usize> = (0..self.columns.len()).map(cells).collect();
        let with: Vec<usize> =
            self.columns.iter().zip(&bare).map(|(name, cells)| head(name).max(*cells)).collect();
        if with.iter().map(|least| least + 3).sum::<usize>() < width { with } else { bare }
    }

    /// As an HTML table, for a notebook.
    pub fn html(&self) -> String {
        let line = |tag: &str, cells: &mut dyn Iterator<Item = String>| {
            let cells = cells.map(|cell| format!("<{tag}>{}</{tag}>", escaped(&cell)));
            format!("<tr>{}</tr>", cells.collect::<String>())
        };
        let head = line("th", &mut self.columns.iter().cloned());
        let rows = self.rows.iter().map(|row| line("td", &mut row.iter().map(cell_text)));
        format!("<table><thead>{head}</thead><tbody>{}</tbody></table>", rows.collect::<String>())
    }

    /// As CSV; numbers to their last digit, an empty cell where there is none.
    pub fn csv(&self) -> Result<Vec<u8>, io::Error> {
        let mut writer = csv::Writer::from_writer(Vec::new());
        writer.write_record(&self.columns)?;
        for row in &self.rows {
            writer.write_record(row.iter().map(|cell| match cell {
                Value::Null => String::new(),
                Value::String(text) => text.clone(),
                other => other.to_string(),
            }))?;
        }
        writer.into_inner().map_err(|error| io::Error::other(error.to_string()))
    }
}

/// The whole of a verb's answer.
#[derive(Debug, Clone, PartialEq)]
pub struct Report {
    /// For people.
    pub text: String,
    /// For programs.
    pub json: Value,
    /// What goes to a CSV file.
    pub table: Table,
}

impl Report {
    /// Prints the answer and writes the file that was asked for.
    pub fn deliver(&self, options: &OutputOptions) -> Result<(), Failure> {
        if let Some(path) = &options.out {
            let contents = if extension(path).as_deref() == Some("csv") {
                self.table.csv().map_err(|error| Failure::Write { path: path.clone(), error })?
            } else {
                pretty(&self.json).into_bytes()
            };
            write_file(path, &contents)?;
        }
        self.print(options.json)
    }

    /// Prints the answer as JSON, or as text for the terminal.
    pub fn print(&self, json: bool) -> Result<(), Failure> {
        let text = || terminal::for_terminal(&terminal::folded(&self.text), false);
        print(&if json { pretty(&self.json) } else { text() })
    }
}

impl OutputOptions {
    /// Refuses a file name whose ending is not known, or that is the verb's own input, before any work is done.
    pub fn check(&self, input: &Path) -> Result<(), Failure> {
        let Some(path) = self.out.as_deref() else { return Ok(()) };
        if !matches!(extension(path).as_deref(), Some("csv" | "json")) {
            let problem = format!("--out {}: the name must end in .csv or .json", path.display());
            return Err(Failure::Usage(problem));
        }
        keep_input(path, &[input])
    }
}

impl OutputOptions {
    /// Refuses units of choice where a verb does not have them.
    pub fn only_usual_units(&self, what: &str) -> Result<(), Failure> {
        let given = [
            ("--angle-unit", self.angle_unit),
            ("--force-unit", self.force_unit),
            ("--torque-unit", self.torque_unit),
            ("--length-unit", self.length_unit),
            ("--pressure-unit", self.pressure_unit),
        ];
        match given.iter().find(|(_, unit)| *unit != unit.quantity.usual()) {
            Some((flag, unit)) => {
                Err(Failure::Usage(format!("{flag} {} is not available for {what}", unit.symbol)))
            }
            None => Ok(()),
        }
    }
}

/// Prints to standard output, with a line end.
pub fn print(text: &str) -> Result<(), Failure> {
    let mut out = io::stdout().lock();
    let printed = out
        .write_all(text.as_bytes())
        .and_then(|()| if text.ends_with('\n') { Ok(()) } else { out.write_all(b"\n") });
    printed.and_then(|()| out.flush()).map_err(|error| match error.kind() {
        io::ErrorKind::BrokenPipe => Failure::Closed,
        _ => Failure::Write { path: "standard output".into(), error },
    })
}

/// Writes a file whole or not at all.
pub fn write_file(path: &Path, contents: &[u8]) -> Result<(), Failure> {
    whole::write(path, contents).map_err(|error| Failure::Write { path: path.to_owned(), error })
}

/// JSON as people and programs both read it.
pub fn pretty(value: &Value) -> String {
    format!("{value:#}")
}

/// A number as JSON, null where there is none or it is not finite.
pub fn number(value: Option<f64>) -> Value {
    value.filter(|v| v.is_finite()).map_or(Value::Null, |v| json!(v))
}

/// An object from key and value pairs, in their order.
pub fn object(entries: impl IntoIterator<Item = (String, Value)>) -> Value {
    Value::Object(entries.into_iter().collect::<Map<_, _>>())
}

/// Six significant digits, without an exponent where a plain number is shorter.
pub fn six_digits(value: f64) -> String {
    if value == 0.0 {
        return "0".into();
    }
    let magnitude = value.abs();
    if !(1e-4..1e7).contains(&magnitude) {
        let text = format!("{value:.5e}");
        return text.split_once('e').map_or(text.clone(), |(digits, power)| {
            format!("{}e{power}", digits.trim_end_matches('0').trim_end_matches('.'))
        });
    }
    // The magnitude lies between 1e-4 and 1e7, so its logarithm fits any integer.
    #[allow(clippy::cast_possible_truncation)]
    let digits = (5 - magnitude.log10().floor() as i32).clamp(0, 9);
    let text = format!("{value:.*}", usize::try_from(digits).unwrap_or(0));
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

/// Text that is no markup.
pub fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

/// Rows that may stand side by side.
const MOST_TURNED: usize = 4;
/// Characters of the parts into which names in cells are broken; the longer the better.
const WORDS: std::ops::Range<usize> = 12..30;

/// A text whose words of more than `most` characters are broken as headings are.
fn folded_words(text: &str, most: usize) -> String {
    let word = |word: &str| if word.chars().count() > most { broken(word, most) } else { word.to_owned() };
    text.split(' ').map(word).collect::<Vec<_>>().join(" ")
}

/// What a line of a heading may end with.
const BREAKS: [char; 4] = ['_', ' ', '/', ':'];

/// A name over several lines, broken after what separates its words: no wider than the cells below, where that can be.
fn broken(name: &str, cells: usize) -> String {
    let parts: Vec<&str> = name.split_inclusive(BREAKS).collect();
    let longest = parts.iter().map(|part| part.chars().count()).max().unwrap_or(0);
    let mut lines = vec![String::new()];
    for part in parts {
        let line = lines.last().map_or(0, |line| line.chars().count());
        if line > 0 && line + part.chars().count() > cells.max(longest) {
            lines.push(String::new());
        }
        if let Some(line) = lines.last_mut() {
            line.push_str(part);
        }
    }
    lines.join("\n")
}

fn cell_text(cell: &Value) -> String {
    match cell {
        Value::Null => "-".into(),
        Value::String(text) => text.clone(),
        Value::Number(value) => match (value.as_i64(), value.as_f64()) {
            (Some(whole), _) => whole.to_string(),
            (None, Some(real)) => six_digits(real),
            _ => value.to_string(),
        },
        other => other.to_string(),
    }
}

fn extension(path: &Path) -> Option<String> {
    path.extension().map(|extension| extension.to_string_lossy().to_ascii_lowercase())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wide_table_is_folded_between_words_and_no_number_is_broken() {
        let mut table =
            Table::new(["alpha_deceleration_arcsec", "scaled_residual_of_it", "what it separates"]);
        table.rows.push(vec![
            json!(1.025_11),
            json!(5.793_1e-16),
            json!("one effect + another effect + a third"),
        ]);
        let text = table.text_within(60);
        assert!(text.lines().all(|line| line.chars().count() <= 60), "{text}");
        assert!(text.contains("1.02511") && text.contains("5.7931e-16") && text.contains("alpha_"), "{text}");
        let mut table = Table::new(["", "readings", "share of\nmisfit", "largest\ndeg", "chi2/dof"]);
        table.rows.push(vec![
            json!("input_angle_deg 250"),
            json!(132),
            json!("33%"),
            json!(-1.282e-3),
            json!(68.7),
        ]);
        let text = table.text_within(62);
        assert!(text.contains("chi2/") && text.contains("misfit") && !text.contains("do \u{2502}"), "{text}");
        let mut table = Table::new(["alpha_deceleration_arcsec", "b", "c"]);
        table.rows.push(vec![json!(1.025_11), json!(2), json!(3)]);
        assert!(table.text_within(200).lines().count() == 5);
        assert!(table.html().contains("<td>1.02511</td>"));
        assert_eq!(escaped("<b> & \"c\""), "&lt;b&gt; &amp; &quot;c&quot;");
    }

    #[test]
    fn where_words_are_too_wide_names_are_broken_and_few_rows_become_columns() {
        let name = "in:circumferential_contact_angle_shift_deg";
        let mut table = Table::new(["effect", "parameter", "50% detected", "most similar effect"]);
        table.rows.push(vec![json!(name), json!(name), json!(4.571_23), json!(format!("{name} (0.997)"))]);
        let text = table.text_within(60);
        assert!(text.lines().all(|line| line.chars().count() <= 60), "{text}");
        assert!(
            text.contains("4.57123") && text.contains("contact_") && text.contains("shift_deg"),
            "{text}"
        );
        let mut table = Table::new(["pair"].into_iter().chain(["friction_torque_Nm"; 6]));
        table.rows.push([vec![json!("deceleration")], vec![json!(0.068_397_8); 6]].concat());
        let text = table.text_within(60);
        assert!(text.lines().all(|line| line.chars().count() <= 60), "{text}");
        assert!(text.matches("\u{2502} friction_torque_Nm").count() == 6, "{text}");
    }

    #[test]
    fn six_digits_are_short_and_right() {
        for (value, text) in [
            (0.0, "0"),
            (12.460_454_9, "12.4605"),
            (-600.0, "-600"),
            (0.000_123_456_78, "0.000123457"),
            (1e-9, "1e-9"),
            (-3.095e-6, "-3.095e-6"),
            (1.234_567_8e10, "1.23457e10"),
            (123_456.7, "123457"),
        ] {
            assert_eq!(six_digits(value), text);
        }
    }
}
