//! Where the torque of a ramp turned back between its readings.
//!
//! A logger with a clock takes no reading at the turn itself. Friction, and all that remembers, turned back there all the
//! same: a model that turns back at the nearest reading has a narrower loop at once, and only a damper follows that.
//! Both ramps beside a turn are straight lines in time, which meet at it. The reading nearest to it lies on one of them, or,
//! where readings are means over the time from halfway to the reading before to halfway to the one behind, on neither: it then has
//! parts on both sides of the turn. Which of both is decided once for a table, as its readings are taken to be of one logger.
//!
//! Torques scatter, and so does where two lines meet. So readings are at the turns of a table unless it is 20 times as probable
//! that they are not, which leaves half of the squares or less; they are samples unless means are 20 times as probable. A turn
//! that is off by more than three standard deviations is not added. Where all turns at the top meet the clock alike, and all at
//! the bottom, as in a list of torques that are set again and again, nothing is added. Two equal torques at the top may be a
//! hold, or a turn halfway between them: they are what other turns of the table are. Where somebody says that it
//! turned back between readings, neither keeps a turn from being one. Times that are rounded are worse than the readings' numbers.

/// Where the torque of a ramp turned back that was read at times.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum TorqueTurns {
    /// Where the ramps on both sides meet, unless all turns meet the clock alike: in a list of torques that are set again and
    /// again each stands where it was.
    #[default]
    WhereRampsMeet,
    /// Where the ramps meet, however they meet the clock.
    BetweenReadings,
    /// At readings.
    AtReadings,
}

impl TorqueTurns {
    /// By the words of a case file.
    pub const WORDS: [(&str, Self); 3] = [
        ("where_ramps_meet", Self::WhereRampsMeet),
        ("between_readings", Self::BetweenReadings),
        ("at_readings", Self::AtReadings),
    ];
}

/// A turn beside a reading of a run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Turn {
    /// The nearest reading with two others on both sides, by its number in the run.
    pub at: usize,
    pub time_s: f64,
    pub torque_Nm: f64,
    /// From when to when the reading is a mean, if it is one.
    block_s: [f64; 2],
    /// Torque over time of the ramps before and after, N m/s.
    rates: [f64; 2],
    /// Time and torque of the reading.
    read_s: f64,
    read_Nm: f64,
    /// By how much of a step it is later than the reading.
    phase: f64,
    /// What the torque changes by from reading to reading, on the flatter side, N m.
    step_Nm: f64,
    /// Standard deviation by which a reading is off what lines through two readings each say, N m.
    u_Nm: f64,
    /// Whether a reading beside it has the same torque.
    may_be_hold: bool,
}

/// What the readings of a table are to the turns of its torque.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Sampling {
    /// They are at them, as far as they show.
    AtTurns,
    /// They are samples on both sides.
    Between,
    /// They are means over time, from halfway to the one before to halfway to the next.
    Means,
}

/// Standard deviation of where two lines meet less a reading between them, in that of a torque: at their middle, 2.5 of its
/// squares of the lines and one of the reading.
const OF_SCATTER: f64 = 1.9;
/// The same of one line, a step further, less a reading.
const OF_ONE_LINE: f64 = 2.45;
/// The same at least, of a step of the torque.
const AT_LEAST: f64 = 0.01;
/// Standard deviations that agree, and the most that count.
const AGREES: f64 = 3.0;
const COUNTS: f64 = 2.0;
/// Odds against what is usual.
const LEAST_ODDS: f64 = 20.0;
/// Standard deviation of the phase at which turns meet the clock, in shares of a step; where it is random, 0.29.
const ALIKE: f64 = 0.05;
/// Of a step, by which lines may meet beyond halfway to the next reading.
const BEYOND: f64 = 0.2;
/// How much less torques must scatter about ramps by the numbers of readings than by their times.
const STRAIGHTER: f64 = 2.0;
/// Mean of the smallest three fifths of distances from a line, in the standard deviation of normal numbers.
const MEAN_OF_SMALLEST: f64 = 0.3963;

/// What a run did at a moment: a reading, a part of one, or a turn between readings.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Moment {
    /// The reading, or the one before or at the turn, by its number in the run.
    pub reading: usize,
    pub time_s: f64,
    pub torque_Nm: f64,
    /// Share of the reading that this is; 0 of a turn.
    pub share: f64,
}

impl Moment {
    /// Whether it is a turn, at which nothing was read.
    pub fn is_turn(&self) -> bool {
        self.share <= 0.0
    }
}

/// Standard deviation of the torques of all runs about straight lines between their neighbours, N m, by the smaller
/// distances: turns have the others.
pub fn scatter_Nm(runs: &[[Vec<f64>; 2]]) -> f64 {
    let off = |(time_s, torque_Nm): (&[f64], &[f64])| {
        let share = (time_s[1] - time_s[0]) / (time_s[2] - time_s[0]);
        let straight_Nm = torque_Nm[0] + share * (torque_Nm[2] - torque_Nm[0]);
        (torque_Nm[1] - straight_Nm).abs() / (1.0 + share.powi(2) + (1.0 - share).powi(2)).sqrt()
    };
    let triples = runs.iter().flat_map(|[time_s, torque_Nm]| time_s.windows(3).zip(torque_Nm.windows(3)));
    let mut all: Vec<f64> = triples.map(off).filter(|off| off.is_finite()).collect();
    all.sort_by(f64::total_cmp);
    all.truncate((3 * all.len()).div_ceil(5));
    all.iter().sum::<f64>() / (MEAN_OF_SMALLEST * all.len().max(1) as f64)
}

/// The runs with the numbers of their readings in place of times, where these make the ramps clearly straighter: a logger that is
/// steady is the better clock where its times are rounded, come late or are missing.
///
/// Without times readings are only counted where somebody says that the torque turned back between them.
pub fn numbered(runs: &[[Vec<f64>; 2]], torque: TorqueTurns) -> Option<Vec<[Vec<f64>; 2]>> {
    let number = |[time_s, torque_Nm]: &[Vec<f64>; 2]| {
        [(0..time_s.len()).map(|number| number as f64).collect(), torque_Nm.clone()]
    };
    let found: Vec<[Vec<f64>; 2]> = runs.iter().map(number).collect();
    let is_timed = runs.iter().any(|[time_s, _]| time_s.windows(2).any(|pair| pair[0] < pair[1]));
    let counts = if is_timed {
        STRAIGHTER * scatter_Nm(&found) < scatter_Nm(runs)
    } else {
        torque == TorqueTurns::BetweenReadings
    };
    counts.then_some(found)
}

/// Turns beside the readings of a run, given by its times (s) and torques (N m), and the scatter of these.
pub fn turns(time_s: &[f64], torque_Nm: &[f64], scatter_Nm: f64) -> Vec<Turn> {
    let last = time_s.len().saturating_sub(2);
    let mut found: Vec<Turn> = Vec::new();
    for at in 2..last {
        // Halfway between two readings it is found at both.
        if found.last().is_none_or(|before| before.at + 1 < at) {
            found.extend(turn_at(time_s, torque_Nm, scatter_Nm, at));
        }
    }
    found
}

fn turn_at(time_s: &[f64], torque_Nm: &[f64], scatter_Nm: f64, at: usize) -> Option<Turn> {
    let rate = |i: usize, j: usize| (torque_Nm[j] - torque_Nm[i]) / (time_s[j] - time_s[i]);
    let rates = [rate(at - 2, at - 1), rate(at + 1, at + 2)];
    if !(rates[0] * rates[1] < 0.0 && rates.iter().all(|rate| rate.is_finite())) {
        return None;
    }
    let sense = rates[0].signum();
    // Time after the reading at which the lines meet.
    let (before_s, after_s) = (time_s[at] - time_s[at - 1], time_s[at + 1] - time_s[at]);
    let here = [torque_Nm[at - 1] + rates[0] * before_s, torque_Nm[at + 1] - rates[1] * after_s];
    let meets_s = (here[1] - here[0]) / (rates[0] - rates[1]);
    let top_Nm = here[0] + rates[0] * meets_s;
    let step_Nm = (rates[0] * before_s).abs().min((rates[1] * after_s).abs());
    let u_Nm = (OF_SCATTER * scatter_Nm).max(AT_LEAST * step_Nm);
    let highest_beside_Nm = (sense * torque_Nm[at - 1]).max(sense * torque_Nm[at + 1]);
    // Steps within their scatter are no ramp.
    if step_Nm.is_nan() || step_Nm <= COUNTS * u_Nm {
        return None;
    }
    let half = 0.5 + (u_Nm / step_Nm).min(BEYOND);
    // Next to the second reading of a run, and the last but one, a turn is found from the far side alone, if not at that reading.
    let off_s = |rate: f64| AGREES * u_Nm / rate.abs();
    let first_s = if at == 2 { -before_s + off_s(rates[0]) } else { 0.0 };
    let last_s = if at + 3 == time_s.len() { after_s - off_s(rates[1]) } else { 0.0 };
    let (from_s, to_s) = (first_s.min(-half * before_s), last_s.max(half * after_s));
    let is_near = meets_s.abs() <= half * if meets_s < 0.0 { before_s } else { after_s };
    let near_s = if is_near { meets_s.clamp(-0.5 * before_s, 0.5 * after_s) } else { meets_s };
    (meets_s >= from_s && meets_s <= to_s).then(|| Turn {
        at,
        time_s: time_s[at] + near_s,
        torque_Nm: top_Nm,
        block_s: [time_s[at] - 0.5 * before_s, time_s[at] + 0.5 * after_s],
        rates,
        read_s: time_s[at],
        read_Nm: torque_Nm[at],
        phase: near_s / (0.5 * (before_s + after_s)),
        step_Nm,
        u_Nm,
        may_be_hold: sense * torque_Nm[at] - highest_beside_Nm <= COUNTS * u_Nm,
    })
}

impl Turn {
    /// The parts of a mean before and after the turn: its share, and time and torque in its middle.
    fn parts(&self) -> [(f64, f64, f64); 2] {
        let [start_s, end_s] = self.block_s;
        [(start_s, self.time_s, self.rates[0]), (self.time_s, end_s, self.rates[1])].map(
            |(from_s, to_s, rate)| {
                let middle_s = 0.5 * (from_s + to_s);
                let share = (to_s - from_s) / (end_s - start_s);
                (share, middle_s, self.torque_Nm + rate * (middle_s - self.time_s))
            },
        )
    }

    fn is_in_block(&self) -> bool {
        self.block_s[0] <= self.time_s && self.time_s <= self.block_s[1]
    }

    fn mean_Nm(&self) -> f64 {
        self.parts().iter().map(|(share, _, torque_Nm)| share * torque_Nm).sum()
    }

    /// Of the ramp that the reading is on.
    fn on_ramp_Nm(&self) -> f64 {
        let after_s = self.read_s - self.time_s;
        self.torque_Nm + self.rates[usize::from(after_s > 0.0)] * after_s
    }

    /// By how much the reading is not what it would be, in standard deviations.
    fn off(&self, sampling: Sampling) -> f64 {
        let (would_be_Nm, times) = match sampling {
            Sampling::AtTurns => (self.torque_Nm, 1.0),
            Sampling::Means if self.is_in_block() => (self.mean_Nm(), 1.0),
            Sampling::Between | Sampling::Means => (self.on_ramp_Nm(), OF_ONE_LINE / OF_SCATTER),
        };
        (self.read_Nm - would_be_Nm).abs() / (times * self.u_Nm)
    }
}

/// What the readings of a table are whose runs have these turns.
pub fn sampling(of_runs: &[Vec<Turn>], torque: TorqueTurns) -> Sampling {
    let known = torque == TorqueTurns::BetweenReadings;
    let clear: Vec<&Turn> = of_runs.iter().flatten().filter(|turn| known || !turn.may_be_hold).collect();
    let squares = |sampling| clear.iter().map(|turn| turn.off(sampling).min(COUNTS).powi(2)).sum::<f64>();
    let [at_turns, between, means] = [Sampling::AtTurns, Sampling::Between, Sampling::Means].map(squares);
    let clearly = |more: f64, less: f64| 0.5 * (more - less) > LEAST_ODDS.ln();
    let (found, left) =
        if clearly(between, means) { (Sampling::Means, means) } else { (Sampling::Between, between) };
    let are_ramps = known || (torque == TorqueTurns::WhereRampsMeet && meet_the_clock_anywhere(&clear));
    if are_ramps && clearly(at_turns, left) && at_turns > 2.0 * left { found } else { Sampling::AtTurns }
}

/// Whether the phases of turns at the top, and of those at the bottom, differ by more than one phase of each would scatter.
/// Of where two lines meet that is 0.83 of what the reading is off there.
fn meet_the_clock_anywhere(turns: &[&Turn]) -> bool {
    let (mut spread, mut scatter, mut free) = (0.0, 0.0, 0.0);
    for rises in [true, false] {
        let own: Vec<&&Turn> = turns.iter().filter(|turn| (turn.rates[0] > 0.0) == rises).collect();
        let count = own.len() as f64;
        let mean = own.iter().map(|turn| turn.phase).sum::<f64>() / count.max(1.0);
        spread += own.iter().map(|turn| (turn.phase - mean).powi(2)).sum::<f64>();
        scatter += own.iter().map(|turn| (turn.u_Nm / turn.step_Nm).powi(2)).sum::<f64>();
        free += (count - 1.0).max(0.0);
    }
    spread > free * (ALIKE.powi(2) + scatter / turns.len() as f64)
}

/// What a run did, with its turns where a reading is what it would be beside them.
pub fn moments(time_s: &[f64], torque_Nm: &[f64], turns: &[Turn], sampling: Sampling) -> Vec<Moment> {
    let mut found = Vec::with_capacity(time_s.len() + 2 * turns.len());
    let is_beside = |turn: &&Turn| match sampling {
        Sampling::AtTurns => false,
        // A mean over a turn further away is that of another reading, on no line.
        Sampling::Means => turn.is_in_block() && turn.off(sampling) <= AGREES,
        Sampling::Between => turn.off(sampling) <= AGREES,
    };
    let mut turns = turns.iter().filter(is_beside).peekable();
    for (reading, (&time_s, &torque_Nm)) in time_s.iter().zip(torque_Nm).enumerate() {
        let read = Moment { reading, time_s, torque_Nm, share: 1.0 };
        let Some(turn) = turns.next_if(|turn| turn.at == reading) else {
            found.push(read);
            continue;
        };
        let top = Moment { time_s: turn.time_s, torque_Nm: turn.torque_Nm, share: 0.0, ..read };
        if sampling == Sampling::Means {
            // What the logger read is what all of it is on the mean.
            let off_Nm = torque_Nm - turn.mean_Nm();
            let parts = turn.parts().map(|(share, time_s, torque_Nm)| {
                let torque_Nm = torque_Nm + off_Nm;
                Moment { reading, time_s, torque_Nm, share }
            });
            let [before, after] = parts.map(|part| (part.share > f64::EPSILON.sqrt()).then_some(part));
            let top = Moment { torque_Nm: top.torque_Nm + off_Nm, ..top };
            found.extend(before.into_iter().chain([top]).chain(after));
        } else {
            found.extend(if turn.time_s < time_s { [top, read] } else { [read, top] });
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A triangular torque of +-10 N m and a period of 80 s.
    fn triangle(time_s: f64) -> f64 {
        let phase = (time_s / 80.0).rem_euclid(1.0);
        if phase < 0.25 {
            40.0 * phase
        } else if phase < 0.75 {
            20.0 - 40.0 * phase
        } else {
            40.0 * phase - 40.0
        }
    }

    /// It turns at every seventh reading.
    fn at_readings(time_s: f64) -> f64 {
        triangle(time_s * 80.0 / 84.0)
    }

    fn sampled(offset_s: f64, of: impl Fn(f64) -> f64) -> (Vec<f64>, Vec<f64>) {
        (0..60).map(|i| 3.0 * f64::from(i) + offset_s).map(|time_s| (time_s, of(time_s))).unzip()
    }

    fn mean(time_s: f64) -> f64 {
        let part = |i: i32| triangle(time_s - 1.5 + 3.0 * (f64::from(i) + 0.5) / 300.0);
        (0..300).map(part).sum::<f64>() / 300.0
    }

    fn of(offset_s: f64, read: impl Fn(f64) -> f64) -> (Sampling, Vec<Moment>) {
        let (time_s, torque_Nm) = sampled(offset_s, read);
        of_columns(time_s, torque_Nm, TorqueTurns::WhereRampsMeet)
    }

    fn of_columns(time_s: Vec<f64>, torque_Nm: Vec<f64>, torque: TorqueTurns) -> (Sampling, Vec<Moment>) {
        let runs = [[time_s, torque_Nm]];
        let [[time_s, torque_Nm]] = &runs;
        let turns = vec![turns(time_s, torque_Nm, scatter_Nm(&runs))];
        let sampling = sampling(&turns, torque);
        (sampling, moments(time_s, torque_Nm, &turns[0], sampling))
    }

    #[test]
    fn a_turn_between_samples_is_where_both_ramps_meet() {
        for offset_s in [0.4, 1.1, 1.9, 2.8] {
            let (sampling, moments) = of(offset_s, triangle);
            assert_eq!(sampling, Sampling::Between);
            let tops: Vec<&Moment> = moments.iter().filter(|moment| moment.share < 1.0).collect();
            assert_eq!(tops.len(), 4, "{offset_s}");
            for (top, (time_s, torque_Nm)) in
                tops.iter().zip([(20.0, 10.0), (60.0, -10.0), (100.0, 10.0), (140.0, -10.0)])
            {
                assert!((top.time_s - time_s).abs() < 1e-9 && (top.torque_Nm - torque_Nm).abs() < 1e-9);
            }
            assert!(moments.windows(2).all(|pair| pair[0].time_s < pair[1].time_s));
        }
    }

    /// 50 readings of a loop from 0 over 10 and -10 N m back to 0, in every loop alike; of 51 the two at the top are alike.
    #[test]
    fn turns_that_meet_the_clock_alike_are_where_ramps_meet_if_somebody_says_so() {
        for count in [50, 51] {
            let (time_s, torque_Nm): (Vec<f64>, Vec<f64>) = (0..count)
                .map(|i| 80.0 * f64::from(i) / f64::from(count - 1))
                .map(|t| (t, triangle(t)))
                .unzip();
            let tops = |torque| {
                let (_, moments) = of_columns(time_s.clone(), torque_Nm.clone(), torque);
                moments.into_iter().filter(Moment::is_turn).map(|top| top.torque_Nm).collect::<Vec<f64>>()
            };
            let found = tops(TorqueTurns::BetweenReadings);
            assert_eq!(found.len(), 2, "{count}");
            assert!(found.iter().all(|top_Nm| (top_Nm.abs() - 10.0).abs() < 1e-9), "{found:?}");
            assert!(tops(TorqueTurns::WhereRampsMeet).is_empty() && tops(TorqueTurns::AtReadings).is_empty());
        }
    }

    /// Times in whole seconds of readings 1.37 s apart, and no times at all.
    #[test]
    fn readings_are_counted_where_that_is_the_better_clock() {
        let read = |i: u32| 1.37 * f64::from(i);
        let torque_Nm: Vec<f64> = (0..120).map(|i| triangle(read(i))).collect();
        let by = |clock: &dyn Fn(f64) -> f64, torque| {
            numbered(&[[(0..120).map(|i| clock(read(i))).collect(), torque_Nm.clone()]], torque)
        };
        let [usual, said] = [TorqueTurns::WhereRampsMeet, TorqueTurns::BetweenReadings];
        assert!(by(&|time_s| time_s, said).is_none() && by(&|_| 0.0, usual).is_none());
        for clock in [by(&f64::round, usual), by(&|_| 0.0, said)] {
            let found = clock.unwrap_or_default();
            assert_eq!(found.len(), 1);
            let [number, torque_Nm] = &found[0];
            let (_, moments) = of_columns(number.clone(), torque_Nm.clone(), TorqueTurns::BetweenReadings);
            let tops: Vec<f64> = moments.iter().filter(|m| m.is_turn()).map(|m| m.torque_Nm).collect();
            assert_eq!(tops.len(), 4);
            assert!(tops.iter().all(|top_Nm| (top_Nm.abs() - 10.0).abs() < 1e-9), "{tops:?}");
        }
    }

    #[test]
    fn a_mean_over_a_turn_has_a_part_on_either_side() {
        let (sampling, moments) = of(0.9, mean);
        assert_eq!(sampling, Sampling::Means);
        assert_eq!(moments.len(), 68);
        for reading in 0..60 {
            let parts = moments.iter().filter(|moment| moment.reading == reading);
            let shares: f64 = parts.clone().map(|part| part.share).sum();
            assert!((shares - 1.0).abs() < 1e-9);
            let together: f64 = parts.map(|part| part.share * part.torque_Nm).sum();
            assert!((together - mean(0.9 + 3.0 * reading as f64)).abs() < 1e-3);
        }
    }

    #[test]
    fn nothing_is_added_at_a_reading_of_the_turn_beyond_a_hold_or_on_a_sine() {
        let sine = |time_s: f64| (std::f64::consts::TAU * time_s / 80.0).sin();
        let holds = |time_s: f64| triangle(time_s).clamp(-8.0, 8.0);
        for offset_s in [0.3, 0.8, 1.2, 1.7, 2.2, 2.9] {
            assert_eq!(of(offset_s, sine).0, Sampling::AtTurns, "{offset_s}");
            assert_eq!(of(offset_s, holds).1.len(), 60, "{offset_s}");
        }
        assert_eq!(of(0.0, at_readings).0, Sampling::AtTurns);
        // Torques that are set in steps of 2 N m, but for the last one below the top.
        let list = [0.0, 2.0, 4.0, 6.0, 8.0, 9.5, 8.0, 6.0, 4.0, 2.0];
        let torque_Nm = (0..60).map(|i| if i / 10 % 2 == 0 { list[i % 10] } else { -list[i % 10] });
        let time_s = (0..60).map(|i| 4.0 * f64::from(i)).collect();
        assert_eq!(of_columns(time_s, torque_Nm.collect(), TorqueTurns::WhereRampsMeet).0, Sampling::AtTurns);
    }

    #[test]
    fn scatter_of_a_fortieth_of_a_step_hides_no_turns_and_makes_none() {
        let noisy =
            |time_s: f64, torque_Nm: f64| torque_Nm + 0.06 * ((12.9898 * time_s).sin() * 43758.5453).fract();
        for read in [triangle, mean] {
            assert_ne!(of(0.9, |time_s| noisy(time_s, read(time_s))).0, Sampling::AtTurns);
        }
        for seed_s in [1.0, 13.0, 37.0] {
            let read = |time_s: f64| noisy(time_s + seed_s, at_readings(time_s));
            assert_eq!(of(0.0, read).0, Sampling::AtTurns);
        }
    }

    /// Three readings of 3 s after the last turn, and two: of these the first is nearer to the turn than the one before it.
    #[test]
    fn the_last_turn_of_a_run_is_found_with_two_readings_behind_it() {
        for (count, offset_s) in [(22, 0.6), (22, 1.2), (23, 0.6), (23, 1.2)] {
            let (time_s, torque_Nm): (Vec<f64>, Vec<f64>) = (0..count)
                .map(|i| 3.0 * f64::from(i) + offset_s)
                .map(|time_s| (time_s, triangle(time_s)))
                .unzip();
            let (_, moments) = of_columns(time_s, torque_Nm, TorqueTurns::BetweenReadings);
            let tops: Vec<f64> = moments.iter().filter(|m| m.is_turn()).map(|m| m.torque_Nm).collect();
            assert_eq!(tops.len(), 2, "{count}, {offset_s}");
            assert!((tops[1] + 10.0).abs() < 1e-9);
        }
    }

    #[test]
    fn short_runs_and_readings_at_one_time_have_none() {
        assert_eq!(turns(&[], &[], 0.0), []);
        assert_eq!(turns(&[0.0; 9], &[0.0, 1.0, 2.0, 3.0, 3.5, 3.0, 2.0, 1.0, 0.0], 0.0), []);
        assert_eq!(turns(&[0.0, 1.0, 2.0], &[0.0, 1.0, 0.5], 0.0), []);
    }
}
