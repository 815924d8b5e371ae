//! Noise that no differences whiten, undone reading by reading.
//!
//! Beside the autoregression along a run, readings may scatter by themselves (a display that rounds, a torque column that
//! scatters) and share the error of a mean torque while it was held. What the readings so far say of the autoregression and of
//! that error is carried along the run (Kalman, J. Basic Eng. 82 (1960) 35); each reading less what it was expected to be, over
//! the standard deviation of that, is independent of those before it (Schweppe, IEEE Trans. Inf. Theory 11 (1965) 61).

use nalgebra::DVectorViewMut;

/// What readings scatter by, beside the autoregression.
#[derive(Debug, Clone, Copy, Default)]
pub struct Beside<'a> {
    /// Standard deviation by which each reading scatters by itself; empty where none does.
    pub own: &'a [f64],
    /// Standard deviation of each reading by what it shares with the others of its hold; empty where nothing is shared.
    pub shared: &'a [f64],
    /// The hold of each reading. Those of one hold follow each other in one run.
    pub hold: &'a [i64],
}

/// One reading after the other, run by run.
#[derive(Debug, Clone, Default)]
pub struct Filter {
    steps: Vec<Step>,
    /// Logarithm of the determinant of the covariance.
    pub log_det: f64,
}

/// How one reading is whitened.
#[derive(Debug, Clone, Copy)]
struct Step {
    reading: usize,
    /// By how much it moves with the autoregression and with the error of its hold, each of unit variance.
    seen: [f64; 2],
    /// What is left of the values of both at the reading before.
    carried: [f64; 2],
    /// By how much they follow what is not expected of the reading.
    gain: [f64; 2],
    /// One over the standard deviation of what is not expected.
    inverse: f64,
}

impl Filter {
    /// Readings with the standard deviation `sd` by an autoregression.
    ///
    /// `order`: readings run by run; `before`: the one before each in its run.
    pub fn new(
        sd: &[f64],
        correlation: f64,
        order: &[usize],
        before: &[Option<usize>],
        beside: Beside<'_>,
    ) -> Self {
        let of = |values: &[f64], reading: usize| values.get(reading).copied().unwrap_or(0.0);
        let mut filter = Self::default();
        // Variances of both values and their covariance, once the readings so far are known.
        let [mut along, mut held, mut both] = [0.0, 0.0, 0.0];
        for &reading in order {
            let last = before[reading];
            let same_hold = last.is_some_and(|last| beside.hold.get(last) == beside.hold.get(reading));
            let carried = [if last.is_some() { correlation } else { 0.0 }, f64::from(u8::from(same_hold))];
            along = carried[0] * carried[0] * along + (1.0 - carried[0] * carried[0]);
            held = if same_hold { held } else { 1.0 };
            both *= carried[0] * carried[1];
            let seen = [sd[reading], of(beside.shared, reading)];
            let moves = [along * seen[0] + both * seen[1], both * seen[0] + held * seen[1]];
            let variance = seen[0] * moves[0] + seen[1] * moves[1] + of(beside.own, reading).powi(2);
            let gain = moves.map(|part| part / variance);
            along -= gain[0] * moves[0];
            held -= gain[1] * moves[1];
            both -= gain[0] * moves[1];
            filter.log_det += variance.ln();
            filter.steps.push(Step { reading, seen, carried, gain, inverse: variance.sqrt().recip() });
        }
        filter
    }

    /// Whitens a column, in place.
    pub fn whiten(&self, column: &mut DVectorViewMut<'_, f64>) {
        let mut expected = [0.0, 0.0];
        for step in &self.steps {
            for (value, carried) in expected.iter_mut().zip(step.carried) {
                *value *= carried;
            }
            let off = column[step.reading] - step.seen[0] * expected[0] - step.seen[1] * expected[1];
            for (value, gain) in expected.iter_mut().zip(step.gain) {
                *value += gain * off;
            }
            column[step.reading] = off * step.inverse;
        }
    }
}
