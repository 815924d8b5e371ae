//! The noise that makes readings y = X p + noise most likely: scale, correlation along a run and offsets of runs, as far as they
//! pay their price.
//!
//! The scale follows from the misfit and from what is stated, whose prior is that of so many repeats; correlation and offsets
//! are sought on a coarse grid, on a finer one where that gains, and then in smaller steps.

use nalgebra::DVector;

use super::products::Whitened;
use super::solved::Solved;

/// Where a search looks first, and where it looks closer.
const CORRELATIONS: [f64; 2] = [0.25, 0.6];
const FINE_CORRELATIONS: [f64; 4] = [0.12, 0.4, 0.75, 0.88];
/// In typical uncertainties of a reading.
const OFFSETS: [f64; 2] = [0.5, 2.0];
const FINE_OFFSETS: [f64; 5] = [0.25, 1.0, 4.0, 10.0, 30.0];

/// Log prior of a scale, 0 where it is 1: a stated uncertainty is worth so many repeats.
pub fn log_scale_prior(scale: f64, stated_dof: f64) -> f64 {
    -0.5 * stated_dof * (2.0 * scale.ln() + 1.0 / (scale * scale) - 1.0)
}

/// A noise, and its log likelihood less its price.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Found {
    /// True over stated uncertainty.
    pub scale: f64,
    /// From a reading to the next of its run.
    pub correlation: f64,
    /// Standard deviation of the offsets of runs, in the unit of the readings.
    pub offset: f64,
    /// Log likelihood up to a constant that all noises share, with the prior of the scale, less the price.
    pub value: f64,
}

/// Why a search has no outcome.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Failed<E> {
    /// There are no products of columns.
    Products(E),
    /// The covariance or the linear problem of white noise is not positive.
    NotPositive,
}

/// What a noise is sought for.
#[derive(Debug, Clone)]
pub struct Task<'a, W> {
    /// Products of y, of the columns of X, and of those that are shared.
    pub whitened: &'a W,
    /// How many columns are shared ones.
    pub shared: usize,
    /// Of the prior of each unknown, 0 where it is flat: that counts as a degree of freedom used up.
    pub precision: &'a [f64],
    /// How many readings there are.
    pub readings: usize,
    /// How many runs.
    pub runs: usize,
    /// Uncertainty of a typical reading.
    pub typical: f64,
    /// Repeats that what is stated is worth.
    pub stated_dof: f64,
    /// The least scale.
    pub least_scale: f64,
    /// The largest correlation.
    pub most_correlation: f64,
    /// Log likelihood that a correlation and that offsets have to gain, each.
    pub price: f64,
}

impl<W: Whitened> Task<'_, W> {
    /// The best noise, from scale, correlation and offset of one to begin with; without `structures` only the scale is sought.
    ///
    /// # Errors
    /// [`Failed`] says why there is none.
    pub fn solve(&self, start: [f64; 3], structures: bool) -> Rated<W::Error> {
        let [scale, correlation, offset] = start;
        let search = Search { task: self, start_scale: scale };
        let white = search.tried(0.0, 0.0)?;
        if !structures || self.runs >= self.readings {
            return Ok(white);
        }
        let mut best = search.searched(white)?;
        if correlation != 0.0 || offset != 0.0 {
            best = better(best, search.rated(correlation, offset / scale)?);
        }
        search.refined(best)
    }
}

struct Search<'a, W> {
    task: &'a Task<'a, W>,
    start_scale: f64,
}

/// A noise, or why there is none.
type Rated<E> = Result<Found, Failed<E>>;

impl<W: Whitened> Search<'_, W> {
    /// A correlation and offsets, these for a scale of 1, at the scale that suits them. Where they leave no more of the columns
    /// than rounding, as of columns that are the same all along each run beside large offsets, the readings say nothing of them:
    /// the likelihood is 0.
    fn rated(&self, correlation: f64, offset: f64) -> Rated<W::Error> {
        match self.tried(correlation, offset) {
            Err(Failed::NotPositive) => {
                let scale = self.start_scale;
                Ok(Found { scale, correlation, offset: offset * scale, value: f64::NEG_INFINITY })
            }
            found => found,
        }
    }

    /// The same, or that the linear problem is not positive.
    fn tried(&self, correlation: f64, offset: f64) -> Rated<W::Error> {
        let correlation = correlation.min(self.task.most_correlation);
        let (first, balanced) = self.at(self.start_scale, correlation, offset)?;
        let near = (balanced / self.start_scale - 1.0).abs() < 1e-3;
        let found = if near { first } else { self.at(balanced, correlation, offset)?.0 };
        // Where a part of the noise has a size of its own, misfit and scale do not go together.
        let whole = self.task.whitened.scales() && self.task.shared == 0;
        if whole { Ok(found) } else { self.climbed(better(first, found), [correlation, offset]) }
    }

    /// A noise uphill from one, by the scale: Newton steps in its logarithm, whose derivatives are differences.
    fn climbed(&self, mut best: Found, [correlation, offset]: [f64; 2]) -> Rated<W::Error> {
        const APART: f64 = 0.05;
        const LONGEST: f64 = 0.7;
        for _ in 0..8 {
            let before = best;
            let value = |log_step: f64| {
                let scale = (before.scale * log_step.exp()).max(self.task.least_scale);
                self.at(scale, correlation, offset)
            };
            let (below, above) = (value(-APART)?.0, value(APART)?.0);
            let slope = (above.value - below.value) / (2.0 * APART);
            let curvature = (above.value - 2.0 * before.value + below.value) / (APART * APART);
            let newton = if curvature < 0.0 { -slope / curvature } else { slope.signum() * LONGEST };
            let step = newton.clamp(-LONGEST, LONGEST);
            best = [below, above].into_iter().fold(best, better);
            best = better(best, value(step)?.0);
            if step.abs() < APART || best.value <= before.value {
                break;
            }
        }
        Ok(best)
    }

    /// A noise, its offsets for a scale of 1, and the scale at which its misfit and what is stated agree.
    fn at(&self, scale: f64, correlation: f64, offset: f64) -> Result<(Found, f64), Failed<W::Error>> {
        let task = self.task;
        let flat = task.precision.iter().filter(|&&precision| precision == 0.0).count();
        let dof = task.readings as f64 - flat as f64;
        let structures = u8::from(correlation != 0.0) + u8::from(offset != 0.0);
        // The runs' offsets scale with the readings' noise while the latter is being found.
        let offset = offset * scale;
        let products = task.whitened.products(scale, correlation, offset != 0.0).map_err(Failed::Products)?;
        let (gram, log_det) = products.beside(offset, task.shared).ok_or(Failed::NotPositive)?;
        let unknowns = task.precision.len();
        let inner = gram.view((1, 1), (unknowns, unknowns)).into_owned();
        let projection = DVector::from_iterator(unknowns, gram.column(0).iter().skip(1).copied());
        let solved = Solved::of(inner, &projection, gram[(0, 0)], task.precision);
        let solved = solved.ok_or(Failed::NotPositive)?;
        let value =
            -0.5 * (solved.chi2 + log_det) + solved.log_volume + log_scale_prior(scale, task.stated_dof)
                - task.price * f64::from(structures);
        // What the priors are pulled by says nothing of the noise.
        let pulled: f64 =
            task.precision.iter().zip(&solved.mode).map(|(precision, size)| precision * size * size).sum();
        let balanced = self.balanced(scale, solved.chi2 - pulled, dof);
        Ok((Found { scale, correlation, offset, value }, balanced))
    }

    /// The scale at which misfit and what is stated agree; `chi2` was found with `scale`. Never far below what is stated:
    /// readings that agree better than they can are no proof of more.
    fn balanced(&self, scale: f64, chi2: f64, dof: f64) -> f64 {
        let (stated, least) = (self.task.stated_dof, self.task.least_scale);
        let found = ((chi2 * scale * scale + stated) / (dof + stated)).sqrt();
        if found < least { least } else { found }
    }

    /// The best of one noise and a few others, of which correlation and offsets are given.
    fn best_of(&self, mut best: Found, others: &[[f64; 2]]) -> Rated<W::Error> {
        for [correlation, offset] in others {
            best = better(best, self.rated(*correlation, *offset)?);
        }
        Ok(best)
    }

    /// The best noise of every structure; the fine grid of one only where the coarse one gains.
    fn searched(&self, white: Found) -> Rated<W::Error> {
        let typical = self.task.typical;
        let [first, second] = CORRELATIONS;
        let mut alone = self.best_of(self.rated(first, 0.0)?, &[[second, 0.0]])?;
        if alone.value > white.value {
            alone = self.best_of(alone, &FINE_CORRELATIONS.map(|c| [c, 0.0]))?;
        }
        if self.task.runs < 2 {
            return Ok(better(white, alone));
        }
        let [first, second] = OFFSETS.map(|offset| offset * typical);
        let mut offsets = self.best_of(self.rated(0.0, first)?, &[[0.0, second]])?;
        if offsets.value > white.value - self.task.price {
            offsets = self.best_of(offsets, &FINE_OFFSETS.map(|offset| [0.0, offset * typical]))?;
        }
        let either = better(alone, offsets);
        if either.value < white.value {
            return Ok(white);
        }
        let best = better(white, either);
        let c = either.correlation;
        if c == 0.0 {
            let offset = either.offset / either.scale;
            return self.best_of(best, &[0.2, 0.5, 0.75].map(|c| [c, offset]));
        }
        // Offsets that are not there yet look like a correlation larger than it is.
        let best = self.best_of(best, &[0.7, 2.0, 5.0].map(|offset| [c, offset * typical]))?;
        self.best_of(best, &[0.7, 2.0, 5.0].map(|offset| [0.5 * c, offset * typical]))
    }

    /// Two rounds of smaller steps on whatever the noise has.
    fn refined(&self, mut best: Found) -> Rated<W::Error> {
        for share in [0.3, 0.12] {
            let (c, o) = (best.correlation, best.offset / best.scale);
            if c != 0.0 {
                let step = share * c.min(1.0 - c);
                best = self.best_of(best, &[[c - step, o], [c + step, o]])?;
            }
            if o != 0.0 {
                best = self.best_of(best, &[[c, o * (1.0 - share)], [c, o * (1.0 + share)]])?;
            }
        }
        Ok(best)
    }
}

/// The better of two noises; the first where they are equally good.
fn better(one: Found, other: Found) -> Found {
    if other.value > one.value { other } else { one }
}
