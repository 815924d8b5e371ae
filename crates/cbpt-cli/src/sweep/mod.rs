//! Sweeps over any parameter of drive, load or effects: a plan is data, and each of its rows a function of the plan and
//! the row's number.
//!
//! - here: [`Plan`] and its [`Axis`]; [`design`]: where the rows lie; `read`: plans in TOML and tables of rows;
//! - [`rows`]: rows solved, those of one geometry together; `csv`: their text; [`tally`]: how they ended;
//! - [`output`]: a file that grows chunk by chunk; a sweep that was interrupted continues where it stopped;
//! - [`stream`]: a plan to its file.
//!
//! Results are made in blocks of [`BLOCK_ROWS`] rows, counted from the first row of the sweep, so they do not depend on who
//! computes which part of it.

// A mistake is told once; its size does not matter.
#![allow(clippy::result_large_err)]

mod csv;
pub mod design;
pub mod output;
pub mod read;
pub mod rows;
pub mod stream;
pub mod tally;

use std::collections::HashMap;
use std::ops::Range;
use std::path::PathBuf;

use cbpt_core::cost::Cost;
use serde_json::{Value, json};
use sha2::{Digest, Sha256};

use crate::case::Case;
use crate::case::error::Mistake;
use crate::case::parameter::{ActsOn, Parameter, Setting, Variants};
use crate::case::suggest::nearest;
use design::{Design, Draws};

/// Rows are solved in blocks of so many, whoever solves them.
pub const BLOCK_ROWS: u64 = 8192;
/// What a chunk has where nothing is said: a few megabytes, a fraction of a second.
pub const CHUNK_ROWS: u64 = 8 * BLOCK_ROWS;
/// More values than these are on no axis of a grid.
const MOST_VALUES: f64 = 1e8;
/// More rows than this would take years.
const MOST_ROWS: u64 = 1_000_000_000_000;

/// The values that an axis takes.
#[derive(Debug, Clone, PartialEq)]
pub enum Values {
    /// These numbers, in the unit of the axis.
    Numbers(Vec<f64>),
    /// Words, and for each value its place among them.
    Words(Vec<String>, Vec<usize>),
    /// Anything between two numbers, for rows that are drawn; on a logarithmic scale or not.
    Between {
        /// The least.
        from: f64,
        /// The greatest.
        to: f64,
        /// Uniform in the logarithm.
        log: bool,
    },
}

impl Values {
    /// These words, in their order.
    pub fn words(words: &[String]) -> Self {
        let mut known: Vec<String> = Vec::new();
        let mut place_of = HashMap::new();
        let place = |word| {
            *place_of.entry(word).or_insert_with(|| {
                known.push(String::clone(word));
                known.len() - 1
            })
        };
        let places = words.iter().map(place).collect();
        Self::Words(known, places)
    }

    /// How many, if they are counted.
    pub fn count(&self) -> Option<usize> {
        match self {
            Self::Numbers(numbers) => Some(numbers.len()),
            Self::Words(_, places) => Some(places.len()),
            Self::Between { .. } => None,
        }
    }
}

/// One parameter and its values.
#[derive(Debug, Clone)]
pub struct Axis {
    /// What is varied.
    pub parameter: Parameter,
    /// Over what.
    pub values: Values,
}

impl Axis {
    /// Finds the parameter of a case by its name.
    ///
    /// # Errors
    /// A name that the case does not have, or a value that the parameter never takes.
    pub fn new(case: &Case, name: &str, values: Values) -> Result<Self, Mistake> {
        let axis = Self { parameter: Parameter::find(case, name)?, values };
        axis.check()?;
        Ok(axis)
    }

    fn check(&self) -> Result<(), Mistake> {
        let wrong = |problem: &str, allowed: &str| Mistake {
            key: self.parameter.name.clone(),
            problem: problem.into(),
            allowed: allowed.into(),
            ..Mistake::default()
        };
        if self.values.count() == Some(0) {
            return Err(wrong("has no values", "give at least one"));
        }
        match &self.values {
            Values::Numbers(numbers) => {
                numbers.iter().try_for_each(|number| self.parameter.check_number(*number))
            }
            Values::Words(words, _) => words.iter().try_for_each(|word| self.parameter.check_word(word)),
            Values::Between { from, to, log } => {
                self.parameter.check_number(*from)?;
                self.parameter.check_number(*to)?;
                if from > to {
                    return Err(wrong(
                        &format!("from {from} to {to} runs backwards"),
                        "give the smaller first",
                    ));
                }
                if *log && *from <= 0.0 {
                    return Err(wrong(&format!("a logarithmic scale from {from}"), "must begin above 0"));
                }
                if *log && self.parameter.is_count() {
                    return Err(wrong("takes whole numbers", "they have no logarithmic scale"));
                }
                Ok(())
            }
        }
    }

    /// The number (or the place of the word) at a place of the axis, counted, or from 0 to 1.
    fn at(&self, place: Place) -> f64 {
        match (&self.values, place) {
            (Values::Numbers(numbers), place) => numbers[place.among(numbers.len())],
            (Values::Words(_, places), place) => places[place.among(places.len())] as f64,
            (Values::Between { from, to, .. }, Place::Share(share)) if self.parameter.is_count() => {
                (from + share * (to - from + 1.0)).floor().min(*to)
            }
            (Values::Between { from, to, log: false }, Place::Share(share)) => {
                (from + share * (to - from)).min(*to)
            }
            (Values::Between { from, to, log: true }, Place::Share(share)) => {
                (from * (to / from).powf(share)).clamp(*from, *to)
            }
            // A plan refuses it.
            (Values::Between { from, .. }, Place::Value(_)) => *from,
        }
    }

    /// Such a number as a setting.
    fn setting(&self, number: f64) -> Setting<'_> {
        match &self.values {
            // Made of a place among the words.
            #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
            Values::Words(words, _) => Setting::Word(&words[number as usize]),
            _ => Setting::Number(self.parameter.to_si(number)),
        }
    }
}

#[derive(Debug, Clone, Copy)]
enum Place {
    Value(usize),
    Share(f64),
}

impl Place {
    /// As a place among so many values.
    // Not negative and below the count, which is that of a list.
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    fn among(self, count: usize) -> usize {
        match self {
            Self::Value(value) => value,
            Self::Share(share) => ((share * count as f64) as usize).min(count - 1),
        }
    }
}

/// A sweep as data.
#[derive(Debug, Clone)]
pub struct Plan {
    case: Case,
    axes: Vec<Axis>,
    design: Design,
    rows: u64,
    seed: u64,
    variants: Variants,
    /// Number of the row that is this plan's first: another than 0 in a part of a table.
    first: u64,
    /// For a grid, after how many rows the value of each axis changes.
    strides: Vec<u64>,
    /// Further columns.
    columns: Vec<Cost>,
    /// The files that it was read from.
    sources: Vec<PathBuf>,
    /// What its file says that may not be meant.
    notes: Vec<String>,
}

impl Plan {
    /// A plan over axes of a case; rows and seed are those of designs that are drawn.
    ///
    /// # Errors
    /// Axes that contradict each other, an incomplete load, and a number of rows that is missing or too large.
    pub fn new(
        case: Case,
        axes: Vec<Axis>,
        design: Design,
        rows: Option<u64>,
        seed: u64,
    ) -> Result<Self, Mistake> {
        let parameters = axes.iter().map(|axis| axis.parameter.clone()).collect();
        let variants = Variants::new(&case, parameters)?;
        load_is_complete(&case, &axes)?;
        for axis in axes.iter().filter(|_| !design.is_drawn()) {
            if axis.values.count().is_none() {
                let allowed = match design {
                    Design::Grid => "give the number of values, count = 41, or their distance, step = 0.5",
                    _ => "a table has one value for each row",
                };
                return Err(mistake(&axis.parameter.name, "is a range, not a list of values", allowed));
            }
        }
        let strides = strides(&axes);
        let rows = rows_of(design, &axes, rows, &strides)?;
        Ok(Self {
            case,
            axes,
            design,
            rows,
            seed,
            variants,
            first: 0,
            strides,
            columns: Vec::new(),
            sources: Vec::new(),
            notes: Vec::new(),
        })
    }

    /// The same plan with further columns, of the drive alone without the effects of the case.
    ///
    /// # Errors
    /// A name that is none, or twice, and a column that the case lacks a number for.
    pub fn with_columns(self, names: &[String]) -> Result<Self, Mistake> {
        let known = Cost::ALL.map(Cost::name);
        let mut columns = Vec::new();
        for name in names {
            let found = Cost::find(name).filter(|cost| !columns.contains(cost));
            columns.push(found.ok_or_else(|| Mistake {
                found: format!("{name:?}"),
                nearest: nearest(name, known.iter().copied()),
                ..mistake(
                    "columns",
                    "no further column",
                    &format!("expected some of {}, each once", known.join(", ")),
                )
            })?);
        }
        self.case.has_what_costs_need(&columns).map_err(|problem| mistake("columns", &problem, ""))?;
        Ok(Self { columns, ..self })
    }

    /// Further columns, in their order.
    pub fn columns(&self) -> &[Cost] {
        &self.columns
    }

    /// The files that it was read from: plan, case and table; none where it was made in a program.
    pub fn sources(&self) -> &[PathBuf] {
        &self.sources
    }

    /// The case that is varied.
    pub fn case(&self) -> &Case {
        &self.case
    }

    /// The axes as they were given.
    pub fn axes(&self) -> &[Axis] {
        &self.axes
    }

    /// How rows are laid over them.
    pub fn design(&self) -> Design {
        self.design
    }

    /// How many rows it has.
    pub fn rows(&self) -> u64 {
        self.rows
    }

    /// From which rows are drawn.
    pub fn seed(&self) -> u64 {
        self.seed
    }

    /// After how many rows of a grid the value of each axis changes.
    pub fn strides(&self) -> &[u64] {
        &self.strides
    }

    /// The same plan; of a table only what these rows need, which must be whole blocks.
    #[must_use]
    pub fn part(&self, rows: Range<u64>) -> Self {
        let mut part = self.clone();
        if self.design == Design::Table {
            let range = usize::try_from(rows.start - self.first).unwrap_or(usize::MAX)
                ..usize::try_from(rows.end - self.first).unwrap_or(usize::MAX);
            part.first = rows.start;
            for axis in &mut part.axes {
                match &mut axis.values {
                    Values::Numbers(all) if all.len() > 1 => {
                        *all = all.get(range.clone()).unwrap_or_default().to_vec();
                    }
                    Values::Words(_, all) if all.len() > 1 => {
                        *all = all.get(range.clone()).unwrap_or_default().to_vec();
                    }
                    _ => {}
                }
            }
        }
        part
    }

    /// Where a part of a table begins.
    pub fn first(&self) -> u64 {
        self.first
    }

    /// The same plan as a part of a table that begins there.
    #[must_use]
    pub fn beginning_at(self, first: u64, rows: u64) -> Self {
        Self { rows, first, ..self }
    }

    /// The numbers of one axis at these rows, in the unit of the axis; of words their places.
    fn column(&self, axis: usize, rows: Range<u64>) -> Vec<f64> {
        let own = &self.axes[axis];
        let count = own.values.count().unwrap_or(1);
        // Below the length of a list.
        #[allow(clippy::cast_possible_truncation)]
        match self.design {
            Design::Grid => rows
                .map(|row| own.at(Place::Value((row / self.strides[axis] % count as u64) as usize)))
                .collect(),
            Design::Table if count == 1 => rows.map(|_| own.at(Place::Value(0))).collect(),
            Design::Table => rows.map(|row| own.at(Place::Value((row - self.first) as usize))).collect(),
            Design::Random | Design::LatinHypercube => {
                let draws = Draws::new(self.seed, axis as u64, self.rows);
                let share =
                    if self.design == Design::Random { Draws::random } else { Draws::latin_hypercube };
                rows.map(|row| own.at(Place::Share(share(&draws, row)))).collect()
            }
        }
    }

    /// What the plan is, for people and for a comparison with what is on disk.
    pub fn record(&self) -> Value {
        let axes = self.axes.iter().map(|axis| {
            let name = &axis.parameter.name;
            match &axis.values {
                Values::Between { from, to, log } => json!({
                    "name": name, "from": from, "to": to, "scale": if *log { "log" } else { "linear" }
                }),
                Values::Words(words, places) if places.len() <= SHOWN_VALUES => {
                    let words: Vec<&String> = places.iter().map(|&place| &words[place]).collect();
                    json!({ "name": name, "values": words })
                }
                Values::Numbers(numbers) if numbers.len() <= SHOWN_VALUES => {
                    json!({ "name": name, "values": numbers })
                }
                Values::Numbers(numbers) => {
                    let bytes = numbers.iter().flat_map(|number| number.to_bits().to_le_bytes());
                    json!({ "name": name, "count": numbers.len(), "sha256": sha256(bytes) })
                }
                Values::Words(words, places) => {
                    let bytes = places.iter().flat_map(|&place| words[place].bytes().chain([0]));
                    json!({ "name": name, "count": places.len(), "sha256": sha256(bytes) })
                }
            }
        });
        let mut record = json!({
            "format": 3,
            "cbpt": env!("CARGO_PKG_VERSION"),
            "design": self.design.name(),
            "rows": self.rows,
            "seed": if self.design.is_drawn() { json!(self.seed) } else { Value::Null },
            "axes": axes.collect::<Vec<Value>>(),
            "case": self.case.to_toml(),
        });
        // A plan without them has the record that it had before there were any.
        if !self.columns.is_empty() {
            record["columns"] = self.columns.iter().map(|cost| cost.name()).collect();
        }
        record
    }
}

/// Longer lists stand in a record by their sum.
const SHOWN_VALUES: usize = 1000;

/// The sum of some bytes, in hexadecimal digits.
fn sha256(bytes: impl IntoIterator<Item = u8>) -> String {
    let bytes: Vec<u8> = bytes.into_iter().collect();
    format!("{:x}", Sha256::digest(bytes))
}

fn mistake(key: &str, problem: &str, allowed: &str) -> Mistake {
    Mistake { key: key.into(), problem: problem.into(), allowed: allowed.into(), ..Mistake::default() }
}

/// A torque, and for a ball drive a preload, from the case or from an axis.
fn load_is_complete(case: &Case, axes: &[Axis]) -> Result<(), Mistake> {
    let varied = |acts_on| axes.iter().any(|axis| axis.parameter.acts_on == acts_on);
    let missing = |name: &str| {
        let key = name.split_once('.').map_or(name, |(_, key)| key);
        let allowed = format!(
            "make it an axis, of a single value for example, or give `{key}` under [load] in the case"
        );
        Err(mistake(name, "missing", &allowed))
    };
    if case.load.torque_Nm.is_none() && !varied(ActsOn::Torque) {
        return missing("load.torque_Nm");
    }
    if case.load.preload_N.is_none() && !varied(ActsOn::Preload) && case.drive().is_some() {
        return missing("load.preload_N");
    }
    Ok(())
}

/// After how many rows of a grid the value of each axis changes. The load changes fastest, the reducer slowest, whatever
/// the order of the axes, so that rows of one geometry are neighbours; else the last axis is the fastest.
fn strides(axes: &[Axis]) -> Vec<u64> {
    let mut slowest_first: Vec<usize> = (0..axes.len()).collect();
    slowest_first.sort_by_key(|&axis| axes[axis].parameter.acts_on);
    let mut strides = vec![1; axes.len()];
    let mut stride = 1_u64;
    for axis in slowest_first.into_iter().rev() {
        strides[axis] = stride;
        stride = stride.saturating_mul(axes[axis].values.count().unwrap_or(1) as u64);
    }
    strides
}

fn rows_of(design: Design, axes: &[Axis], rows: Option<u64>, strides: &[u64]) -> Result<u64, Mistake> {
    let counts = || axes.iter().filter_map(|axis| axis.values.count());
    let found = match (design, rows) {
        (Design::Grid | Design::Table, Some(_)) => {
            let allowed = "leave it out: rows is for the designs random and latin_hypercube";
            return Err(mistake(
                "rows",
                &format!("the axes of a {} fix the number of rows", design.name()),
                allowed,
            ));
        }
        (Design::Grid, None) => axes.iter().zip(strides).fold(1, |most, (axis, stride)| {
            most.max(stride.saturating_mul(axis.values.count().unwrap_or(1) as u64))
        }),
        (Design::Table, None) => {
            let longest = counts().max().unwrap_or(1);
            if let Some(axis) =
                axes.iter().find(|axis| ![Some(1), Some(longest)].contains(&axis.values.count()))
            {
                let found = axis.values.count().unwrap_or(0);
                let problem = format!("has {found} values, another axis has {longest}");
                return Err(mistake(
                    &axis.parameter.name,
                    &problem,
                    "every axis of a table needs one value for each row",
                ));
            }
            longest as u64
        }
        (_, Some(rows)) => rows,
        (_, None) => {
            let allowed = "give the number of rows: rows = 100000";
            return Err(mistake("rows", &format!("missing; a design {} needs it", design.name()), allowed));
        }
    };
    if (1..=MOST_ROWS).contains(&found) {
        Ok(found)
    } else {
        Err(mistake("rows", &format!("the plan has {found}"), &format!("expected 1 to {MOST_ROWS}")))
    }
}
