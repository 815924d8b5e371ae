//! The readings' columns but for the angle, checked once, with what history makes of them.
//!
//! History goes by time: runs follow each other by their first times, wherever they stand in the table. Runs that overlap in
//! time have each a clock of its own, which starts again with the run; then their order is that of the table.
//!
//! Where a ramp turned back between its readings the turn is a row of its own, which nobody measured, and a reading that is a
//! mean over it has a row on either side (`turns`).
//!
//! A run goes on from where the one before it ended, and is not loaded from rest, if nothing between them says otherwise
//! (`Rows::histories`); or the clocks are no matter, and loops that nobody measured may stand before ([`History`]).

use std::collections::HashMap;

use crate::drive::Load;
use crate::effect::port::Row;
use crate::effect::torque_rate::{Rate, rates};
use crate::error::{InvalidInput, require, require_positive};

use super::turns::{Moment, TorqueTurns, Turn, moments, numbered, sampling, scatter_Nm, turns};

/// Columns of a table of readings, all of one length.
#[derive(Debug, Clone, Copy)]
pub struct Columns<'a> {
    /// Number of the run that a reading belongs to; the readings of a run need not be neighbours.
    pub run: &'a [i64],
    /// Time, s, in order within a run; equal times are allowed.
    pub time_s: &'a [f64],
    /// Torque M0 on the output, N m.
    pub torque_Nm: &'a [f64],
    /// Axial preload, N, above 0; a torsion spring may do without.
    pub preload_N: Option<&'a [f64]>,
    /// Angle of the input crank, rad.
    pub input_angle_rad: &'a [f64],
    /// Temperature, K or degrees Celsius (only differences count), where it was read.
    pub temperature_K: Option<&'a [f64]>,
    /// Number of the load cycle, where it was counted; its first value is the first cycle.
    pub cycle: Option<&'a [f64]>,
}

/// Whether a run that begins where the one before it ended goes on with what that has left.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum History {
    /// If both are timed by one clock: one that starts again says that the run was loaded from rest.
    #[default]
    ByClock,
    /// No: the friction has faded, or was released.
    Released,
    /// Yes, by whatever clocks. A run that no other leads to is no first one either, if it ends where it began: it goes on from
    /// a repetition of itself that nobody measured.
    Carried,
    /// The same, but a run that no other leads to goes on from a loop that nobody measured, to the table's largest torque either way,
    /// which came down to its first reading.
    CarriedFromAbove,
    /// The same of a loop that came up to it.
    CarriedFromBelow,
}

impl History {
    /// By the words of a case file.
    pub const WORDS: [(&str, Self); 5] = [
        ("by_clock", Self::ByClock),
        ("released", Self::Released),
        ("carried", Self::Carried),
        ("carried_from_above", Self::CarriedFromAbove),
        ("carried_from_below", Self::CarriedFromBelow),
    ];
}

/// Place in the table of a row that nobody measured.
const UNMEASURED: usize = usize::MAX;

/// Checked readings. Inside they stand run by run; what is given out is in the order of the table.
#[derive(Debug, Clone, PartialEq)]
pub struct Rows {
    rows: Vec<Row>,
    /// Place in the table of each of `rows`.
    places: Vec<usize>,
    /// Share of its reading that each of `rows` is.
    shares: Vec<f64>,
    /// How many readings.
    count: usize,
    /// Where each run begins in `rows`, and the end of the last.
    starts: Vec<usize>,
    /// Whether the runs follow each other in time, by one clock.
    one_clock: bool,
    history: History,
    has_temperature: bool,
    has_preload: bool,
}

impl Rows {
    /// Checks the columns.
    ///
    /// # Errors
    /// [`InvalidInput`] names the first column and row that cannot be, and what is required.
    pub fn new(columns: Columns<'_>) -> Result<Self, InvalidInput> {
        Self::with_turns(columns, TorqueTurns::default())
    }

    /// The same of torques that are known to turn back at readings, or between them.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn with_turns(columns: Columns<'_>, turns: TorqueTurns) -> Result<Self, InvalidInput> {
        let count = columns.run.len();
        require(count > 0, "run", "no reading", "at least one reading is needed")?;
        let same = |name: &str, length: usize| {
            let rule = format!("must have as many entries as run, which has {count}");
            require(length == count, name, format!("{length} entries"), &rule)
        };
        let needed = [
            ("time_s", columns.time_s),
            ("torque_Nm", columns.torque_Nm),
            ("input_angle_rad", columns.input_angle_rad),
        ];
        let optional = [
            ("preload_N", columns.preload_N),
            ("temperature_K", columns.temperature_K),
            ("cycle", columns.cycle),
        ];
        let given = optional.into_iter().filter_map(|(name, values)| values.map(|values| (name, values)));
        for (name, values) in needed.into_iter().chain(given) {
            same(name, values.len())?;
            for (index, value) in values.iter().enumerate() {
                require(
                    value.is_finite(),
                    format_args!("{name}[{index}]"),
                    value,
                    "must be a finite number",
                )?;
            }
        }
        for (index, preload) in columns.preload_N.unwrap_or_default().iter().enumerate() {
            require_positive(format_args!("preload_N[{index}]"), *preload)?;
        }
        Self::in_runs(&columns, turns)
    }

    /// Single loads, each a table of its own: one reading at time 0, loaded from rest.
    pub fn of_loads(loads: &[Load]) -> Self {
        let row = |(place, load): (usize, &Load)| Row {
            place,
            torque_Nm: load.torque_Nm(),
            preload_N: load.preload_N(),
            input_angle_rad: load.input_angle_rad(),
            time_s: 0.0,
            run_time_s: 0.0,
            step_time_s: 0.0,
            rate_share: 1.0,
            temperature_difference_K: 0.0,
            largest_torque_share: if load.torque_Nm() == 0.0 { 0.0 } else { 1.0 },
            largest_torque_share_of_run: if load.torque_Nm() == 0.0 { 0.0 } else { 1.0 },
            cycles_done: 0.0,
            direction: 0.0,
        };
        Self {
            rows: loads.iter().enumerate().map(row).collect(),
            places: (0..loads.len()).collect(),
            shares: vec![1.0; loads.len()],
            count: loads.len(),
            starts: (0..=loads.len()).collect(),
            one_clock: false,
            history: History::ByClock,
            has_temperature: true,
            has_preload: loads.iter().all(|load| load.preload_N() > 0.0),
        }
    }

    fn in_runs(columns: &Columns<'_>, turns: TorqueTurns) -> Result<Self, InvalidInput> {
        let (runs, one_clock) = runs_of(columns)?;
        let (samples, starts) = samples(columns, &runs, turns);
        let mut in_order: Vec<usize> = (0..samples.len()).collect();
        if one_clock {
            in_order.sort_by(|&a, &b| samples[a].time_s.total_cmp(&samples[b].time_s));
        }
        let first = samples[in_order[0]];
        let torque_Nm: Vec<f64> = samples.iter().map(|sample| sample.torque_Nm).collect();
        let largest = torque_Nm.iter().fold(0.0, |a: f64, torque| a.max(torque.abs()));
        let largest_shares = largest_shares(&torque_Nm, &in_order, largest);
        let first_cycle = columns.cycle.map_or(0.0, |c| c.iter().copied().fold(f64::INFINITY, f64::min));
        let mut rows = Vec::with_capacity(samples.len());
        for (runs_done, bounds) in starts.windows(2).enumerate() {
            let run = &samples[bounds[0]..bounds[1]];
            let mut in_run: f64 = 0.0;
            for (number, (sample, rate_share)) in run.iter().zip(rate_shares(run)).enumerate() {
                in_run = in_run.max(sample.torque_Nm.abs());
                let at = |column: &[f64]| column[sample.reading];
                let temperature = columns.temperature_K.map_or(0.0, |t| at(t) - t[first.reading]);
                rows.push(Row {
                    place: rows.len(),
                    torque_Nm: sample.torque_Nm,
                    preload_N: columns.preload_N.map_or(0.0, at),
                    input_angle_rad: at(columns.input_angle_rad),
                    time_s: sample.time_s - first.time_s,
                    run_time_s: sample.time_s - run[0].time_s,
                    step_time_s: sample.time_s - run[number.saturating_sub(1)].time_s,
                    rate_share,
                    temperature_difference_K: temperature,
                    largest_torque_share: largest_shares[bounds[0] + number],
                    largest_torque_share_of_run: if largest > 0.0 { in_run / largest } else { 0.0 },
                    cycles_done: columns.cycle.map_or(runs_done as f64, |c| at(c) - first_cycle),
                    direction: direction(run, number),
                });
            }
        }
        Ok(Self {
            rows,
            places: samples
                .iter()
                .map(|sample| if sample.is_turn() { UNMEASURED } else { sample.reading })
                .collect(),
            shares: samples.iter().map(|sample| sample.share).collect(),
            count: columns.run.len(),
            starts,
            one_clock,
            history: History::ByClock,
            has_temperature: columns.temperature_K.is_some(),
            has_preload: columns.preload_N.is_some(),
        })
    }

    /// How many readings.
    pub fn len(&self) -> usize {
        self.count
    }

    /// Never: a table has at least one reading.
    pub fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }

    /// The same with another history.
    #[must_use]
    pub fn with_history(&self, history: History) -> Self {
        let mut this = Self {
            rows: Vec::new(),
            places: Vec::new(),
            shares: Vec::new(),
            starts: vec![0],
            history,
            ..self.clone()
        };
        for number in (0..self.runs()).filter(|number| self.places[self.starts[*number]] != UNMEASURED) {
            let (run, places) = (&self.rows[self.run(number)], &self.places[self.run(number)]);
            let shares = &self.shares[self.run(number)];
            let before = this.runs().checked_sub(1).map(|last| this.run(last));
            let led_to = before.is_some_and(|before| this.leads_to(&this.rows[before], run));
            if !led_to {
                let (past, shares) = self.past(run, shares, history);
                if !past.is_empty() {
                    this.push(&past, &vec![UNMEASURED; past.len()], &shares);
                }
            }
            this.push(run, places, shares);
        }
        this
    }

    /// What was done in no time before a run that no other leads to, and the share of each row; nothing where it begins at rest.
    fn past(&self, run: &[Row], shares: &[f64], history: History) -> (Vec<Row>, Vec<f64>) {
        let then = |row: &Row| Row {
            time_s: run[0].time_s,
            temperature_difference_K: run[0].temperature_difference_K,
            ..*row
        };
        let after_loop = |from: f64| {
            let largest_Nm = self.rows.iter().map(|row| row.torque_Nm.abs()).fold(0.0, f64::max);
            let legs = [(-from * largest_Nm, -from), (from * largest_Nm, from), (run[0].torque_Nm, -from)];
            let rows = legs.map(|(torque_Nm, direction)| Row { torque_Nm, direction, ..run[0] });
            (rows.to_vec(), vec![1.0; rows.len()])
        };
        match history {
            History::CarriedFromAbove => after_loop(1.0),
            History::CarriedFromBelow => after_loop(-1.0),
            History::Carried if run.len() > 2 && goes_on_from(run, run) => {
                (run.iter().map(then).collect(), shares.to_vec())
            }
            _ => (Vec::new(), Vec::new()),
        }
    }

    /// One run more.
    fn push(&mut self, run: &[Row], places: &[usize], shares: &[f64]) {
        let first = self.rows.len();
        self.rows.extend(run.iter().enumerate().map(|(i, row)| Row { place: first + i, ..*row }));
        self.places.extend(places);
        self.shares.extend(shares);
        self.starts.push(self.rows.len());
    }

    /// How many runs go on from where the one before them ended, without those that do from a past that nobody measured.
    pub fn runs_that_go_on(&self) -> usize {
        (0..self.runs()).filter(|run| self.goes_on(*run)).count() - self.runs_with_unmeasured_past()
    }

    /// How many runs go on from a repetition of themselves, or a loop, that nobody measured.
    pub fn runs_with_unmeasured_past(&self) -> usize {
        (0..self.runs()).filter(|run| self.places[self.starts[*run]] == UNMEASURED).count()
    }

    /// Of each turn of the torque between readings the place in the table of the reading before it, or of the one over it.
    pub fn turns_between_readings(&self) -> Vec<usize> {
        let measured = (0..self.runs()).map(|run| &self.places[self.run(run)]);
        let measured = measured.filter(|run| run.first() != Some(&UNMEASURED));
        let turns = measured.flat_map(|run| run.windows(2).filter(|pair| pair[1] == UNMEASURED));
        turns.map(|pair| pair[0]).collect()
    }

    /// Whether readings are means over the time from halfway to the one before to halfway to the next; the turns between them
    /// say so.
    pub fn are_means(&self) -> bool {
        self.shares.iter().any(|share| *share > 0.0 && *share < 1.0)
    }

    /// How many runs.
    pub fn runs(&self) -> usize {
        self.starts.len() - 1
    }

    /// Whether temperatures were read.
    pub fn has_temperature(&self) -> bool {
        self.has_temperature
    }

    /// Whether there is a preload at every reading.
    pub fn has_preload(&self) -> bool {
        self.has_preload
    }

    /// The readings, run by run.
    pub(super) fn by_run(&self) -> &[Row] {
        &self.rows
    }

    /// Readings of a run, as places in [`Self::by_run`].
    pub(super) fn run(&self, number: usize) -> std::ops::Range<usize> {
        self.starts[number]..self.starts[number + 1]
    }

    /// The readings cut where a run starts unloaded, as places in [`Self::by_run`]: one or more runs each.
    pub(super) fn histories(&self) -> Vec<std::ops::Range<usize>> {
        let mut found: Vec<std::ops::Range<usize>> = Vec::new();
        for number in 0..self.runs() {
            let run = self.run(number);
            match found.last_mut() {
                Some(history) if self.goes_on(number) => history.end = run.end,
                _ => found.push(run),
            }
        }
        found
    }

    /// Whether a run begins where the one before it ended, by one clock where that counts.
    fn goes_on(&self, number: usize) -> bool {
        // A past that nobody measured stands where no run leads to.
        let Some(before) = number.checked_sub(1).filter(|_| self.places[self.starts[number]] != UNMEASURED)
        else {
            return false;
        };
        self.leads_to(&self.rows[self.run(before)], &self.rows[self.run(number)])
    }

    /// Whether a run goes on from where another one ended. What friction holds does not fade in a pause.
    fn leads_to(&self, before: &[Row], run: &[Row]) -> bool {
        let timed = |run: &[Row]| run.last().is_some_and(|row| row.run_time_s > 0.0);
        let told = match self.history {
            History::Released => false,
            History::Carried | History::CarriedFromAbove | History::CarriedFromBelow => true,
            History::ByClock => self.one_clock && timed(before) && timed(run),
        };
        told && goes_on_from(before, run)
    }

    /// The readings cut where time starts again: all of them, or the runs.
    pub(super) fn by_clock(&self) -> Vec<&[Row]> {
        if self.one_clock {
            return vec![&self.rows];
        }
        (0..self.runs()).map(|run| &self.rows[self.run(run)]).collect()
    }

    /// From values run by run, `width` of each row, to those of the readings in the order of the table: the means of their parts.
    pub(super) fn means(&self, by_run: &[f64], width: usize) -> Vec<f64> {
        // Most tables are run by run already, and each reading is one row.
        if self.rows.len() == self.count && self.places.is_sorted() {
            return by_run.to_vec();
        }
        let mut means = vec![0.0; self.count * width];
        for (row, (&place, share)) in self.places.iter().zip(&self.shares).enumerate() {
            if place != UNMEASURED {
                for (mean, value) in means[place * width..].iter_mut().zip(&by_run[row * width..][..width]) {
                    *mean += share * value;
                }
            }
        }
        means
    }

    /// The row that stands for each reading where a mean would say nothing, in the order of the table: its only one, or of its
    /// parts the first, but for one that is `odd`.
    pub(super) fn row_of_each(&self, odd: impl Fn(usize) -> bool) -> Vec<usize> {
        let mut found: Vec<Option<usize>> = vec![None; self.count];
        for (row, &place) in self.places.iter().enumerate().filter(|(_, place)| **place != UNMEASURED) {
            if found[place].is_none_or(|before| odd(row) && !odd(before)) {
                found[place] = Some(row);
            }
        }
        found.into_iter().flatten().collect()
    }
}

/// Whether a run begins under the load under which another one ended, the torque as near as neighbours of either run are.
#[allow(clippy::float_cmp)] // set, not measured: the same to the last bit, or moved
fn goes_on_from(before: &[Row], run: &[Row]) -> bool {
    let ([.., last], [first, ..]) = (before, run) else { return false };
    first.input_angle_rad == last.input_angle_rad
        && first.preload_N == last.preload_N
        && (first.torque_Nm - last.torque_Nm).abs() <= largest_step_Nm(before).max(largest_step_Nm(run))
}

/// Largest change of the torque from one reading of a run to the next.
fn largest_step_Nm(run: &[Row]) -> f64 {
    let step = |pair: &[Row]| (pair[1].torque_Nm - pair[0].torque_Nm).abs();
    run.windows(2).map(step).fold(0.0, f64::max)
}

/// Largest torque either way so far, over the largest of all, at each reading.
fn largest_shares(torque_Nm: &[f64], in_order: &[usize], largest_Nm: f64) -> Vec<f64> {
    let mut so_far: f64 = 0.0;
    let mut shares = vec![0.0; torque_Nm.len()];
    for &place in in_order {
        so_far = so_far.max(torque_Nm[place].abs());
        shares[place] = if largest_Nm > 0.0 { so_far / largest_Nm } else { 0.0 };
    }
    shares
}

/// The readings of each run, in the order of time, and whether the runs follow each other by one clock.
fn runs_of(columns: &Columns<'_>) -> Result<(Vec<Vec<usize>>, bool), InvalidInput> {
    let mut number_of: HashMap<i64, usize> = HashMap::new();
    let mut runs: Vec<Vec<usize>> = Vec::new();
    for (place, run) in columns.run.iter().enumerate() {
        let number = *number_of.entry(*run).or_insert(runs.len());
        if number == runs.len() {
            runs.push(Vec::new());
        }
        if let Some(&before) = runs[number].last() {
            require(
                columns.time_s[place] >= columns.time_s[before],
                format_args!("time_s[{place}]"),
                columns.time_s[place],
                "must not be earlier than the reading before it in the same run",
            )?;
        }
        runs[number].push(place);
    }
    let one_clock = by_time(&mut runs, columns.time_s);
    Ok((runs, one_clock))
}

/// Puts runs in the order of their first times and returns true, unless they overlap in time: then each has a clock of its
/// own, and their order stays.
fn by_time(runs: &mut [Vec<usize>], time_s: &[f64]) -> bool {
    let first = |run: &[usize]| run.first().map_or(0.0, |place| time_s[*place]);
    let last = |run: &[usize]| run.last().map_or(0.0, |place| time_s[*place]);
    let mut sorted: Vec<usize> = (0..runs.len()).collect();
    sorted.sort_by(|&a, &b| first(&runs[a]).total_cmp(&first(&runs[b])));
    if sorted.windows(2).any(|pair| first(&runs[pair[1]]) < last(&runs[pair[0]])) {
        return false;
    }
    runs.sort_by(|a, b| first(a).total_cmp(&first(b)));
    true
}

/// What all runs did, one after the other, and where each begins and the last ends.
fn samples(columns: &Columns<'_>, runs: &[Vec<usize>], of: TorqueTurns) -> (Vec<Moment>, Vec<usize>) {
    let read: Vec<[Vec<f64>; 2]> = runs
        .iter()
        .map(|run| {
            [columns.time_s, columns.torque_Nm].map(|column| run.iter().map(|place| column[*place]).collect())
        })
        .collect();
    let numbered = numbered(&read, of);
    let clocked = numbered.as_ref().unwrap_or(&read);
    let scatter_Nm = scatter_Nm(clocked);
    let turns: Vec<Vec<Turn>> =
        clocked.iter().map(|[clock, torque_Nm]| turns(clock, torque_Nm, scatter_Nm)).collect();
    let sampling = sampling(&turns, of);
    let (mut samples, mut starts) = (Vec::with_capacity(columns.run.len()), vec![0]);
    for (((run, [clock, torque_Nm]), [time_s, _]), turns) in runs.iter().zip(clocked).zip(&read).zip(&turns) {
        let by_clock = moments(clock, torque_Nm, turns, sampling);
        samples.extend(by_clock.into_iter().map(|moment| Moment {
            reading: run[moment.reading],
            time_s: if numbered.is_some() { time_at(time_s, &moment) } else { moment.time_s },
            ..moment
        }));
        starts.push(samples.len());
    }
    (samples, starts)
}

/// Time of a moment whose clock counts the readings, s.
fn time_at(time_s: &[f64], counted: &Moment) -> f64 {
    let at = counted.reading;
    let later = counted.time_s - at as f64;
    let beside = if later < 0.0 { at.saturating_sub(1) } else { (at + 1).min(time_s.len() - 1) };
    time_s[at] + later.abs() * (time_s[beside] - time_s[at])
}

/// [`Row::rate_share`] at all moments of a run.
fn rate_shares(run: &[Moment]) -> Vec<f64> {
    let time_s: Vec<f64> = run.iter().map(|moment| moment.time_s).collect();
    let torque_Nm: Vec<f64> = run.iter().map(|moment| moment.torque_Nm).collect();
    let share = |(number, rate): (usize, Rate)| {
        if number == 0 || number + 1 == run.len() {
            return 1.0;
        }
        let mean = (torque_Nm[number] - torque_Nm[number - 1]) / (time_s[number] - time_s[number - 1]);
        let share = rate.arriving_Nm_per_s / mean;
        if share.is_finite() { share.clamp(0.0, 2.0) } else { 1.0 }
    };
    rates(&time_s, &torque_Nm).into_iter().enumerate().map(share).collect()
}

/// Sense of the torque's last change before a moment of a run; the first takes the value of the next.
fn direction(run: &[Moment], number: usize) -> f64 {
    let after = number.max(1);
    let (Some(before), Some(now)) = (run.get(after - 1), run.get(after)) else { return 0.0 };
    let step = now.torque_Nm - before.torque_Nm;
    if step == 0.0 { 0.0 } else { step.signum() }
}
