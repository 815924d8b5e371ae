//! Tables of the parts as they were made: CSV files beside the case file become lists.
//!
//! - [`TABLES`]: which file has which columns, and the lists that they become;
//! - [`read_tables`]: files to lists, each mistake with file and row;
//! - [`put_aside`]: what the mechanics refuse of them.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::Read;
use std::path::Path;

use cbpt_core::InvalidInput;
use cbpt_core::as_made::{Fault, Profile};
use cbpt_core::units::Quantity;

use super::error::Mistake;
use super::fields::{self, AS_MADE};
use super::keys::{Key, Value, dotted};
use super::parts::{BALLS, EPICYCLOID, FACING_RINGS, HYPOCYCLOID, PLANET_RINGS, by_ring, whole};
use super::reader::{Reader, Source};

/// A measured table is no larger.
const LARGEST: u64 = 16 << 20;
/// So many rows of all tables stay with the case; more tell no more of a groove.
const MOST_ROWS: usize = 12_000;

/// A file of the section and its columns.
struct Table {
    key: &'static str,
    columns: &'static [Column],
}

/// A column by the ways in which it may be given: header without unit, the list that it becomes, what it measures. A column
/// without list says which part a row is of.
struct Column(&'static [(&'static str, &'static str, Quantity)]);

static TABLES: [Table; 6] = [
    Table {
        key: "epicycloid_profile",
        columns: &[
            Column(&[
                ("groove_angle", EPICYCLOID[0], Quantity::Angle),
                ("polar_angle", EPICYCLOID[1], Quantity::Angle),
            ]),
            Column(&[("deviation", EPICYCLOID[2], Quantity::Length)]),
        ],
    },
    Table {
        key: "hypocycloid_profile",
        columns: &[
            Column(&[
                ("groove_angle", HYPOCYCLOID[0], Quantity::Angle),
                ("polar_angle", HYPOCYCLOID[1], Quantity::Angle),
            ]),
            Column(&[("deviation", HYPOCYCLOID[2], Quantity::Length)]),
        ],
    },
    Table {
        key: "planet_rings",
        columns: &[
            Column(&[("ring", PLANET_RINGS[0], Quantity::Number)]),
            Column(&[("ring_angle", PLANET_RINGS[1], Quantity::Angle)]),
            Column(&[("deviation", PLANET_RINGS[2], Quantity::Length)]),
        ],
    },
    Table {
        key: "facing_rings",
        columns: &[
            Column(&[("ring", FACING_RINGS[0], Quantity::Number)]),
            Column(&[("ring_angle", FACING_RINGS[1], Quantity::Angle)]),
            Column(&[("deviation", FACING_RINGS[2], Quantity::Length)]),
        ],
    },
    Table {
        key: "deceleration_balls",
        columns: &[
            Column(&[("ball", "", Quantity::Number)]),
            Column(&[("diameter", BALLS[0], Quantity::Length)]),
        ],
    },
    Table {
        key: "equal_speed_balls",
        columns: &[
            Column(&[("ball", "", Quantity::Number)]),
            Column(&[("diameter", BALLS[1], Quantity::Length)]),
        ],
    },
];

/// What is wrong with a file: the row as an editor counts it, if it is one row.
struct Bad {
    row: Option<usize>,
    problem: String,
    allowed: String,
}

impl Bad {
    fn file(problem: impl Into<String>, allowed: impl Into<String>) -> Self {
        Self { row: None, problem: problem.into(), allowed: allowed.into() }
    }

    fn row(row: usize, problem: impl Into<String>, allowed: impl Into<String>) -> Self {
        Self { row: Some(row), problem: problem.into(), allowed: allowed.into() }
    }
}

/// Columns of a file in SI, and the row of each as an editor counts it.
struct Rows {
    /// By list name; the numbers of the parts under no name.
    lists: BTreeMap<&'static str, Vec<f64>>,
    rows: Vec<usize>,
}

// --- files to lists -----------------------------------------------------------------------

/// Reads the files that the section names into its lists.
pub(super) fn read_tables(reader: &mut Reader<'_, '_>, folder: Option<&Path>) {
    let mut left = MOST_ROWS;
    for table in &TABLES {
        let name = dotted(AS_MADE, table.key);
        let Some(file) = reader.values.text(&name).map(str::to_owned) else { continue };
        reader.values.remove(&name);
        let Some(source) = reader.sources.remove(&name) else { continue };
        let lists = || table.columns.iter().flat_map(|column| column.0).filter(|way| !way.1.is_empty());
        let twice = lists().find_map(|way| reader.sources.get(&dotted(AS_MADE, way.1)));
        let read = match (twice, folder) {
            (Some(list), _) => {
                Err(Bad::file(format!("{} gives it as a list as well", list.key), "keep one of them"))
            }
            (None, None) => Err(Bad::file(
                "a case that is given as text has no folder to look for this file in",
                format!(
                    "read the case from its file, or give the lists {}",
                    lists().filter_map(|way| Some(key_of(way.1)?.usual())).collect::<Vec<_>>().join(", ")
                ),
            )),
            (None, Some(folder)) => read_file(&folder.join(&file), table, &mut left),
        };
        match read {
            Ok(read) => {
                for (list, values) in read.lists {
                    let name = dotted(AS_MADE, list);
                    let Source { at, key, written } = &source;
                    let source = Source { at: *at, key: key.clone(), written: written.clone() };
                    reader.values.set(name.clone(), Value::Reals(values));
                    reader.sources.insert(name, source);
                }
            }
            Err(Bad { row, problem, allowed }) => {
                let row = row.map_or_else(String::new, |row| format!(", row {row}"));
                let problem = format!("{file}{row}: {problem}");
                let key = source.key;
                reader.notes.add(source.at, Mistake { key, problem, allowed, ..Mistake::default() });
            }
        }
    }
}

/// The key of a list.
fn key_of(list: &str) -> Option<&'static Key> {
    fields::section(AS_MADE)?.keys.iter().find(|key| key.si() == list)
}

/// The header of a column in its usual unit.
fn header_of((stem, list, _): &(&str, &str, Quantity)) -> String {
    key_of(list).map_or_else(|| (*stem).to_owned(), |key| key.usual_unit().name(stem))
}

fn read_file(path: &Path, table: &Table, left: &mut usize) -> Result<Rows, Bad> {
    let cannot = |error: std::io::Error| {
        let problem = match error.kind() {
            std::io::ErrorKind::NotFound => "file not found".to_owned(),
            _ => format!("cannot be read: {error}"),
        };
        Bad::file(problem, "the path is relative to the case file")
    };
    if path.is_dir() {
        return Err(Bad::file("is a directory", "name a CSV file"));
    }
    let mut bytes = Vec::new();
    File::open(path).map_err(cannot)?.take(LARGEST + 1).read_to_end(&mut bytes).map_err(cannot)?;
    if bytes.len() as u64 > LARGEST {
        return Err(Bad::file("is larger than 16 MiB", "a measured table is smaller; take every nth row"));
    }
    let text =
        std::str::from_utf8(&bytes).map_err(|_| Bad::file("is not UTF-8 text", "save it as CSV in UTF-8"))?;
    let rows = read_rows(text.strip_prefix('\u{feff}').unwrap_or(text), table)?;
    *left = left.checked_sub(rows.rows.len()).ok_or_else(|| {
        let problem = format!("the tables of the case have more than {MOST_ROWS} rows");
        Bad::file(problem, "take every nth row; twenty rows for each wave of a groove are enough")
    })?;
    checked(table, rows)
}

/// The delimiter of a header: a semicolon or tab where there is one, so that commas may be decimal.
fn delimiter(text: &str) -> u8 {
    let header =
        text.lines().find(|line| !line.trim().is_empty() && !line.starts_with('#')).unwrap_or_default();
    [b';', b'\t'].into_iter().find(|mark| header.as_bytes().contains(mark)).unwrap_or(b',')
}

fn read_rows(text: &str, table: &Table) -> Result<Rows, Bad> {
    let delimiter = delimiter(text);
    let mut csv = csv::ReaderBuilder::new()
        .delimiter(delimiter)
        .comment(Some(b'#'))
        .flexible(true)
        .trim(csv::Trim::All)
        .from_reader(text.as_bytes());
    let header = csv.headers().map_err(|error| Bad::file(error.to_string(), "save it as CSV"))?.clone();
    let columns: Vec<_> =
        table.columns.iter().map(|column| find_column(column, &header)).collect::<Result<_, _>>()?;
    let mut lists: BTreeMap<&'static str, Vec<f64>> = BTreeMap::new();
    let mut rows = Vec::new();
    for record in csv.records() {
        let record = record.map_err(|error| Bad::file(error.to_string(), "save it as CSV"))?;
        let row = record.position().map_or(0, |position| usize::try_from(position.line()).unwrap_or(0));
        if record.iter().all(str::is_empty) {
            continue;
        }
        for (place, list, unit) in &columns {
            let cell = record.get(*place).unwrap_or_default();
            let plain = if delimiter == b',' { cell.to_owned() } else { cell.replace(',', ".") };
            let number =
                plain.parse().ok().map(|number: f64| unit.to_si(number)).filter(|value| value.is_finite());
            let Some(number) = number else {
                let column = header.get(*place).unwrap_or_default();
                let what = if cell.is_empty() { "is empty".into() } else { format!("= \"{cell}\"") };
                let allowed = "expected a finite number; leave out a row that was not measured";
                return Err(Bad::row(row, format!("{column} {what}"), allowed));
            };
            lists.entry(list).or_default().push(number);
        }
        rows.push(row);
    }
    if rows.is_empty() {
        return Err(Bad::file("has a header and no rows", "write one row for each place that was measured"));
    }
    Ok(Rows { lists, rows })
}

type Found = (usize, &'static str, &'static cbpt_core::units::Unit);

/// Where a column stands, the list that it becomes and its unit.
fn find_column(column: &Column, header: &csv::StringRecord) -> Result<Found, Bad> {
    for (stem, list, quantity) in column.0 {
        for unit in quantity.units() {
            let name = unit.name(stem);
            if let Some(place) = header.iter().position(|written| written == name) {
                return Ok((place, list, unit));
            }
        }
    }
    let ways: Vec<String> = column.0.iter().map(header_of).collect();
    let bare = column.0.iter().find(|(stem, ..)| header.iter().any(|written| written.starts_with(stem)));
    let problem = match bare {
        Some((stem, ..)) => {
            let written = header.iter().find(|written| written.starts_with(stem)).unwrap_or_default();
            format!("column {written} has no unit that is known")
        }
        None => format!("no column {}", ways.join(" or ")),
    };
    let found: Vec<&str> = header.iter().collect();
    let allowed = format!("write {} in the header, which is: {}", ways.join(" or "), found.join(", "));
    Err(Bad { row: Some(1), problem, allowed })
}

// --- what rows must be --------------------------------------------------------------------

/// Rows in the order of the parts, each profile checked.
fn checked(table: &Table, mut rows: Rows) -> Result<Rows, Bad> {
    let fault = |fault: Fault, places: &[usize]| Bad {
        row: places.get(fault.row).or(places.last()).copied(),
        problem: fault.found,
        allowed: fault.required,
    };
    if let Some(numbers) = rows.lists.remove("") {
        let order = in_order(&numbers, &rows.rows)?;
        for list in rows.lists.values_mut() {
            *list = order.iter().map(|place| list[*place]).collect();
        }
        return Ok(rows);
    }
    let list = |name: &str| rows.lists.get(name).map_or(&[][..], Vec::as_slice);
    let deviation = table.columns.last().map_or("", |column| column.0[0].1);
    let angle = table.columns.iter().flat_map(|column| column.0);
    let angle =
        angle.map(|way| way.1).find(|name| name.ends_with("angle_rad") && rows.lists.contains_key(name));
    let (angles, deviations) = (list(angle.unwrap_or_default()), list(deviation));
    let ring = table.columns[0].0[0].1;
    if !ring.ends_with("ring") {
        Profile::new(angles, deviations).map_err(|found| fault(found, &rows.rows))?;
        return Ok(rows);
    }
    for (number, places) in by_ring(list(ring)).map_err(|found| fault(found, &rows.rows))? {
        let pick = |list: &[f64]| places.iter().map(|place| list[*place]).collect::<Vec<_>>();
        let own: Vec<usize> = places.iter().map(|place| rows.rows[*place]).collect();
        Profile::new(&pick(angles), &pick(deviations)).map_err(|found| {
            let Bad { row, problem, allowed } = fault(found, &own);
            Bad { row, problem: format!("ring {number}: {problem}"), allowed }
        })?;
    }
    Ok(rows)
}

/// Places of the balls 0, 1, 2, ... among the rows.
fn in_order(numbers: &[f64], rows: &[usize]) -> Result<Vec<usize>, Bad> {
    let mut place_of: BTreeMap<usize, usize> = BTreeMap::new();
    for (place, number) in numbers.iter().enumerate() {
        let Some(ball) = whole(*number) else {
            return Err(Bad::row(
                rows[place],
                format!("ball = {number}"),
                "expected the number of a ball, from 0",
            ));
        };
        if let Some(first) = place_of.insert(ball, place) {
            let problem = format!("ball {ball} stands on row {} already", rows[first]);
            return Err(Bad::row(rows[place], problem, "write each ball once, numbered from 0"));
        }
    }
    match (0..numbers.len()).find(|ball| !place_of.contains_key(ball)) {
        Some(missing) => {
            Err(Bad::file(format!("ball {missing} is missing"), "number the balls from 0, without gaps"))
        }
        None => Ok(place_of.into_values().collect()),
    }
}

// --- what the mechanics refuse ------------------------------------------------------------

/// Whether a refused number is one of the parts as made.
pub(super) fn is_about(refused: &InvalidInput) -> bool {
    refused.field.strip_prefix(AS_MADE).is_some_and(|rest| rest.starts_with('.'))
}

/// Notes it and goes on with nominal parts.
pub(super) fn put_aside(reader: &mut Reader<'_, '_>, refused: InvalidInput) -> Option<()> {
    let InvalidInput { field, found, required: allowed } = refused;
    let name = field.split('[').next().unwrap_or_default();
    let place = &field[name.len()..];
    let mistake = match reader.sources.get(name) {
        // The list of a file: its numbers count from 0 as balls and rings do.
        Some(Source { key, written, .. }) if written.starts_with(['"', '\'']) => {
            let file = written.trim_matches(['"', '\'']);
            let part = place.trim_matches(['[', ']']);
            let part = if part.is_empty() { String::new() } else { format!(", ball {part}") };
            Mistake {
                key: key.clone(),
                problem: format!("{file}{part}: {found}"),
                allowed,
                ..Mistake::default()
            }
        }
        Some(Source { key, .. }) => {
            Mistake { key: format!("{key}{place}"), found, allowed, ..Mistake::default() }
        }
        None => Mistake { key: field.clone(), found, allowed, ..Mistake::default() },
    };
    let at = reader.sources.get(name).and_then(|source| source.at);
    reader.notes.add(at, mistake);
    let section = fields::section(AS_MADE)?;
    for key in &section.keys {
        reader.values.remove(&section.si_name(key));
    }
    Some(())
}
