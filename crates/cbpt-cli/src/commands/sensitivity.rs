//! `cbpt sensitivity`: derivatives of elastic angle and preload thresholds with respect to every design number.

use cbpt_core::cost::{Cost, Rubbing};
use cbpt_core::design::{Design, DesignNumber, NUMBERS, numbers_of};
use cbpt_core::sensitivity::{DriveSensitivities, Sensitivity};
use cbpt_core::{Drive, InvalidInput, Load};
use serde_json::{Value, json};

use super::{Units, ball_drive, load, note_bare_drive, note_nominal_parts};
use crate::args;
use crate::case::{Case, Spread, in_usual_unit};
use crate::exit::{Exit, Failure};
use crate::report::{Report, Table, number, object, six_digits};

/// Runs the verb.
pub fn run(verb: &args::Sensitivity) -> Result<Exit, Failure> {
    let args::Sensitivity { of: verb, friction } = verb;
    verb.output.check(&verb.case.path)?;
    let case = Case::read(&verb.case.path)?;
    let drive = ball_drive(&case, &verb.case.path, "sensitivities are")?;
    let load = load(&case, &verb.load)?;
    let mut answers = Answers::new(drive, &load, &case.spreads(drive, &load)?)?;
    if *friction {
        answers.add_costs(drive, &case.rubbing())?;
    }
    let mut report = answers.report(&Units::from(&verb.output));
    note_bare_drive(&mut report, &case, "these are sensitivities");
    note_nominal_parts(&mut report, &case, "these are sensitivities");
    report.deliver(&verb.output)?;
    Ok(if answers.found.status.has_solution() { Exit::Success } else { Exit::NoSolution })
}

/// One number: its value and how it scatters, where that is stated.
struct Asked {
    number: &'static DesignNumber,
    value: f64,
    spread: Option<Spread>,
}

/// The numbers of a drive, and the derivatives of its results with respect to them.
pub struct Answers {
    load: Load,
    asked: Vec<Asked>,
    found: DriveSensitivities,
    /// Costs, where they were asked for.
    costs: Vec<(Cost, Option<Sensitivity>)>,
}

/// Names of the thresholds.
const THRESHOLDS: [&str; 3] = ["hold", "continuous", "zero_backlash"];

impl Answers {
    /// For every number of the drive, and those whose spread is stated.
    ///
    /// # Errors
    /// [`InvalidInput`] for a number that the drive does not have.
    pub fn new(
        drive: &Drive,
        load: &Load,
        spreads: &[(&'static DesignNumber, Spread)],
    ) -> Result<Self, InvalidInput> {
        let design = Design::of(drive, load);
        let usual = numbers_of(drive, load);
        let wanted = |number: &&DesignNumber| {
            usual.iter().any(|known| known.name == number.name)
                || spreads.iter().any(|(known, _)| known.name == number.name)
        };
        let asked: Vec<Asked> = NUMBERS
            .iter()
            .filter(wanted)
            .filter_map(|number| {
                let spread = spreads.iter().find(|(known, _)| known.name == number.name);
                Some(Asked { number, value: design.get(number)?, spread: spread.map(|(_, spread)| *spread) })
            })
            .collect();
        let numbers: Vec<&DesignNumber> = asked.iter().map(|asked| asked.number).collect();
        let found = drive.sensitivities(load, &numbers)?;
        Ok(Self { load: *load, asked, found, costs: Vec::new() })
    }

    /// Adds what friction, safety and vibration answer to the same numbers, by differences.
    ///
    /// # Errors
    /// [`InvalidInput`] for a coefficient or an inertia that cannot be.
    pub fn add_costs(&mut self, drive: &Drive, rubbing: &Rubbing) -> Result<(), InvalidInput> {
        let wanted = rubbing.stated();
        let numbers: Vec<&DesignNumber> = self.asked.iter().map(|asked| asked.number).collect();
        let found = drive.cost_sensitivities(&self.load, rubbing, &wanted, &numbers)?;
        self.costs = wanted.into_iter().zip(found).collect();
        Ok(())
    }

    /// Those that were added.
    pub fn costs(&self) -> &[(Cost, Option<Sensitivity>)] {
        &self.costs
    }

    /// The derivatives, in the order of [`Self::numbers`].
    pub fn found(&self) -> &DriveSensitivities {
        &self.found
    }

    /// Each number's name in SI and its value.
    pub fn numbers(&self) -> impl Iterator<Item = (&'static str, f64)> {
        self.asked.iter().map(|asked| (asked.number.name, asked.value))
    }

    /// Standard uncertainty of the elastic angle that each number's spread makes, rad.
    fn parts_rad(&self) -> Vec<Option<f64>> {
        let slopes = self.found.elastic_angle.as_ref().map(|angle| &angle.slopes);
        let part = |(place, asked): (usize, &Asked)| Some((slopes?[place] * asked.spread?.u()).abs());
        self.asked.iter().enumerate().map(part).collect()
    }

    /// Results with their names: the angle, and the thresholds of the drive and of its pairs.
    fn results(&self, units: &Units) -> Vec<Answer<'_>> {
        let angle = (
            format!("elastic_angle_{}", units.angle.symbol),
            self.found.elastic_angle.as_ref(),
            units.angle.per_si(),
        );
        let pairs = [
            ("", &self.found.drive),
            ("deceleration_", &self.found.deceleration),
            ("equal_speed_", &self.found.equal_speed),
        ];
        let thresholds = pairs.into_iter().flat_map(|(pair, of_pair)| {
            THRESHOLDS.iter().zip(of_pair).map(move |(name, threshold)| {
                let name = format!("{pair}{name}_{}", units.force.symbol);
                (name, threshold.as_ref(), units.force.per_si())
            })
        });
        let costs = self.costs.iter().map(|(cost, found)| (cost.name().to_owned(), found.as_ref(), 1.0));
        std::iter::once(angle).chain(thresholds).chain(costs).collect()
    }

    /// What they have to say.
    pub fn report(&self, units: &Units) -> Report {
        let results = self.results(units);
        let parts = self.parts_rad();
        let total: f64 = parts.iter().flatten().map(|part| part * part).sum();
        let share = |part: Option<f64>| part.filter(|_| total > 0.0).map(|part| part * part / total);
        let suffix = units.angle.symbol;
        let heads = [
            "number".to_owned(),
            "value".to_owned(),
            format!("angle_{suffix}_per_unit"),
            "angle_%/%".to_owned(),
            "hold_%/%".to_owned(),
            "continuous_%/%".to_owned(),
            "zero_backlash_%/%".to_owned(),
            "u".to_owned(),
            "share_of_variance_%".to_owned(),
        ];
        let of_costs = self.costs.iter().map(|(cost, _)| head_of(*cost));
        let mut table = Table::new(heads.into_iter().chain(of_costs));
        let (mut documents, mut tied) = (Vec::new(), Vec::new());
        for (place, asked) in self.asked.iter().enumerate() {
            let number = OfNumber { asked, place, results: &results, share: share(parts[place]) };
            table.rows.push(number.row());
            let one_sided = number.one_sided();
            if !one_sided.is_empty() {
                tied.push(format!("{} by {}", one_sided.join(", "), in_usual_unit(asked.number).0));
            }
            documents.push(number.document());
        }
        let angle = self.found.elastic_angle.as_ref().map(|angle| angle.value * units.angle.per_si());
        let u_angle = (total > 0.0).then(|| total.sqrt() * units.angle.per_si());
        let mut document = vec![
            ("torque_Nm".to_owned(), json!(self.load.torque_Nm())),
            ("preload_N".to_owned(), json!(self.load.preload_N())),
            ("input_angle_deg".to_owned(), json!(self.load.input_angle_rad().to_degrees())),
            ("status".to_owned(), json!(self.found.status.name())),
        ];
        let values = results
            .iter()
            .map(|(name, found, size)| (name.clone(), number(found.map(|found| found.value * size))));
        document.extend(values);
        document.push((format!("u_elastic_angle_{suffix}"), number(u_angle)));
        document.push(("numbers".to_owned(), Value::Array(documents)));
        document.push(("whole_numbers".to_owned(), json!(whole_numbers())));
        Report { text: self.text(&table, [angle, u_angle], &tied, units), json: object(document), table }
    }

    fn text(
        &self,
        table: &Table,
        [angle, u_angle]: [Option<f64>; 2],
        tied: &[String],
        units: &Units,
    ) -> String {
        let suffix = units.angle.symbol;
        let mut text = format!(
            "Load: {} N m, preload {} N, input angle {} deg\n",
            six_digits(self.load.torque_Nm()),
            six_digits(self.load.preload_N()),
            six_digits(self.load.input_angle_rad().to_degrees()),
        );
        text += &match (angle, u_angle) {
            (Some(angle), Some(u)) => format!(
                "Elastic angle: {} {suffix}, standard uncertainty {} {suffix} from the stated spreads\n",
                six_digits(angle),
                six_digits(u)
            ),
            (Some(angle), None) => format!("Elastic angle: {} {suffix}\n", six_digits(angle)),
            (None, _) => format!("Elastic angle: {}\n", self.found.status),
        };
        let thresholds = THRESHOLDS.iter().zip(&self.found.drive).map(|(name, found)| match found {
            Some(found) => {
                format!("{name} {} {}", six_digits(found.value * units.force.per_si()), units.force.symbol)
            }
            None => format!("{name}: no preload is enough"),
        });
        let of_angle = shown(table, &ANGLE, |row| row[1..].iter().any(|cell| !cell.is_null()));
        let of_thresholds = shown(table, &OF_THRESHOLDS, |row| {
            row[1..].iter().any(|cell| cell.as_f64().is_some_and(|x| x != 0.0))
        });
        text += &of_angle.text();
        text += &format!(
            "\nangle/unit: change of the angle in {suffix} if the number changes by one of its units.\n\
             %/%: change of the result in percent if the number changes by one percent.\n\
             No derivative with respect to whole numbers: {}.\n",
            whole_numbers().join(", "),
        );
        text += &format!(
            "Thresholds of the drive over a period:\n  {}",
            thresholds.collect::<Vec<_>>().join(", ")
        );
        if !of_thresholds.rows.is_empty() {
            text += &format!("\n{}\nThey do not depend on any other number.", of_thresholds.text());
        }
        text += &self.text_of_costs(table);
        if !tied.is_empty() {
            text += &format!(
                "\nOne-sided derivatives, because two contacts are critical at once and respond differently:\n  {}.",
                tied.join(";\n  ")
            );
        }
        text
    }
}

impl Answers {
    /// The costs and their table; nothing where none were asked for.
    fn text_of_costs(&self, table: &Table) -> String {
        if self.costs.is_empty() {
            return String::new();
        }
        let values: Vec<String> = self
            .costs
            .iter()
            .filter_map(|(cost, found)| {
                Some(format!("{} {}", cost.name(), six_digits(found.as_ref()?.value)))
            })
            .collect();
        let heads: Vec<String> = self.costs.iter().map(|(cost, _)| head_of(*cost)).collect();
        let columns: Vec<Shown<'_>> = std::iter::once(NUMBER)
            .chain(heads.iter().enumerate().map(|(place, head)| Shown(BEHIND_ANGLE + place, head, 4)))
            .collect();
        let shown =
            shown(table, &columns, |row| row[1..].iter().any(|cell| cell.as_f64().is_some_and(|x| x != 0.0)));
        format!(
            "\nFriction, safety and vibration at the input angle: {}\n{}\nThese derivatives are by central differences: where other \
             contacts slip or decide, the slopes to both sides differ.",
            values.join(", "),
            shown.text()
        )
    }
}

/// Names of the numbers that are whole, so that nothing has a derivative with respect to them.
fn whole_numbers() -> Vec<&'static str> {
    NUMBERS.iter().filter(|number| number.whole).map(|number| number.name).collect()
}

/// Results of the angle and of the thresholds, behind which the costs stand.
const OF_ANGLE: usize = 10;

/// The head of a cost's column: without its unit, as the numbers are percent for a percent.
fn head_of(cost: Cost) -> String {
    let name = cost.name();
    let stem = ["_Nm_per_turn", "_Nm", "_Hz"].iter().find_map(|unit| name.strip_suffix(unit));
    format!("{}_%/%", stem.unwrap_or(name))
}

/// A result: its name, what was found of it, and how many of its units make one in SI.
type Answer<'a> = (String, Option<&'a Sensitivity>, f64);

/// The derivatives of all results with respect to one number.
struct OfNumber<'a> {
    asked: &'a Asked,
    /// Place of the number among those that were asked for.
    place: usize,
    results: &'a [Answer<'a>],
    /// Its share of the variance of the elastic angle.
    share: Option<f64>,
}

impl OfNumber<'_> {
    fn slope(&self, found: Option<&Sensitivity>) -> Option<f64> {
        found.map(|found| found.slopes[self.place])
    }

    /// Change of the result for a change of the number, both as shares. None for a result that is nothing but rounding: no
    /// angle or force has that size.
    fn relative(&self, found: Option<&Sensitivity>) -> Option<f64> {
        let found = found.filter(|found| found.value.abs() > 1e-14)?;
        Some(found.slopes[self.place] * self.asked.value / found.value)
    }

    /// Names of the results whose derivative is one-sided.
    fn one_sided(&self) -> Vec<&str> {
        let tied = |found: Option<&Sensitivity>| found.is_some_and(|found| found.tied[self.place]);
        self.results.iter().filter(|(_, found, _)| tied(*found)).map(|(name, ..)| &**name).collect()
    }

    fn row(&self) -> Vec<Value> {
        let (key, per_si) = in_usual_unit(self.asked.number);
        let mut row = vec![json!(key), json!(self.asked.value * per_si)];
        let (_, angle, size) = &self.results[0];
        row.push(number(self.slope(*angle).map(|slope| slope * size / per_si)));
        // What rounding leaves of nothing is nothing to a reader.
        let shown = |found| self.relative(found).map(|share| if share.abs() < 1e-12 { 0.0 } else { share });
        row.extend(self.results[..4].iter().map(|(_, found, _)| number(shown(*found))));
        row.push(number(self.asked.spread.map(|spread| spread.u() * per_si)));
        row.push(number(self.share.map(|share| 100.0 * share)));
        row.extend(self.results[OF_ANGLE..].iter().map(|(_, found, _)| number(shown(*found))));
        row
    }

    fn document(&self) -> Value {
        let (key, per_si) = in_usual_unit(self.asked.number);
        let by_result = |value: &dyn Fn(Option<&Sensitivity>, f64) -> Option<f64>| {
            object(
                self.results.iter().map(|(name, found, size)| (name.clone(), number(value(*found, *size)))),
            )
        };
        json!({
            "number": key,
            "value": self.asked.value * per_si,
            "per_unit": by_result(&|found, size| self.slope(found).map(|slope| slope * size / per_si)),
            "relative": by_result(&|found, _| self.relative(found)),
            "one_sided": self.one_sided(),
            "distribution": self.asked.spread.map(Spread::name),
            "u": self.asked.spread.map(|spread| spread.u() * per_si),
            "share_of_variance": self.share,
        })
    }
}

/// A column on a terminal: its place among all, its head, and with how many digits; files have them all.
struct Shown<'a>(usize, &'a str, usize);

const NUMBER: Shown<'static> = Shown(0, "number", 0);
const ANGLE: [Shown<'static>; 6] = [
    NUMBER,
    Shown(1, "value", 6),
    Shown(2, "angle/unit", 4),
    Shown(3, "%/%", 4),
    Shown(7, "u", 3),
    Shown(8, "share_%", 3),
];
/// Columns of the table before those of the costs.
const BEHIND_ANGLE: usize = 9;
const OF_THRESHOLDS: [Shown<'static>; 4] =
    [NUMBER, Shown(4, "hold_%/%", 4), Shown(5, "continuous_%/%", 4), Shown(6, "zero_backlash_%/%", 4)];

/// Some columns and rows for a terminal, without the columns that are empty.
fn shown(table: &Table, columns: &[Shown<'_>], keep: impl Fn(&[Value]) -> bool) -> Table {
    let pick = |row: &Vec<Value>| -> Vec<Value> {
        let cell = |Shown(place, _, digits): &Shown<'_>| match row[*place].as_f64() {
            Some(number) => json!(rounded(number, *digits)),
            None => row[*place].clone(),
        };
        columns.iter().map(cell).collect()
    };
    let mut picked = Table::new(columns.iter().map(|Shown(_, head, _)| *head));
    picked.rows = table.rows.iter().map(pick).filter(|row| keep(row)).collect();
    let empty = |place: usize| picked.rows.iter().all(|row| row[place].is_null());
    let filled: Vec<&str> =
        (0..columns.len()).filter(|&place| !empty(place)).map(|place| columns[place].1).collect();
    picked.narrowed(|column| filled.contains(&column))
}

fn rounded(number: f64, digits: usize) -> f64 {
    format!("{number:.*e}", digits.saturating_sub(1)).parse().unwrap_or(number)
}
