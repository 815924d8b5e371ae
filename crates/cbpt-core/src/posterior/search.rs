//! The search for the most probable values: Gauss-Newton on whitened residuals and priors with exact slopes, damped where it
//! does not gain, with bounds by projection.

use nalgebra::DVector;

use super::misfit::{Misfit, Point, Seen};
use crate::error::InvalidInput;
use crate::predict::Predictor;
use crate::units::ARCSEC_PER_RAD;

/// Gain in misfit that ends the search; two units of misfit are one of log evidence. What is reported goes further, as the
/// caller sees to (`lab/inference/closing.py`).
const ENOUGH: f64 = 0.02;
/// The same of ends that are only ranked. Where play, friction and curves meet the misfit has kinks, and half of all predictions
/// go into the last half of log evidence.
const ROUGHLY: f64 = 0.5;
/// Share of what a step promises: one that gains less is followed by a shorter one.
const POOR: f64 = 0.25;
/// One that gains more may be followed by a longer one.
const GOOD: f64 = 0.75;

/// What predicts the readings.
pub trait Model {
    /// Why it cannot be asked.
    type Error;

    /// Prediction and slopes by the unknowns at these places; `None` where a reading has no solution.
    ///
    /// # Errors
    /// What keeps it from being asked.
    fn at(&mut self, values: Vec<f64>, unknown: &[usize]) -> Result<Option<Point>, Self::Error>;
}

/// In arcsec.
impl Model for Predictor {
    type Error = InvalidInput;

    fn at(&mut self, values: Vec<f64>, unknown: &[usize]) -> Result<Option<Point>, InvalidInput> {
        let found = self.predict(&values, unknown)?;
        let in_arcsec = |mut numbers: Vec<f64>| {
            for number in &mut numbers {
                *number *= ARCSEC_PER_RAD;
            }
            numbers.iter().all(|number| number.is_finite()).then_some(numbers)
        };
        let both = in_arcsec(found.angle_rad).zip(in_arcsec(found.sensitivities));
        Ok(both.map(|(predicted, slopes)| Point { values, predicted, slopes }))
    }
}

/// When a search ends, beside where no step promises to gain.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limits {
    /// After so many predictions.
    pub steps: usize,
    /// Where what the last step promises stays above this misfit.
    pub bound: f64,
    /// Whether the end is only ranked among others: a search then ends at a gain of 0.5, for a misfit of 1 a reading or
    /// less. A larger misfit counts for as much less: its noise is larger than the one given, as who fits it will find.
    pub ranked: bool,
}

/// Where a search has come to.
#[derive(Debug, Clone, PartialEq)]
pub struct Reached {
    /// The most probable point; `None` where that is the start.
    pub point: Option<Point>,
    /// Whether it is the end of the search.
    pub ended: bool,
}

/// Why a search has no outcome.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Failed<E> {
    /// The model cannot be asked.
    Model(E),
    /// Slopes by steps are not finite.
    NotFinite,
}

/// The most probable point from a start.
///
/// Where a step does not gain what it promises, the next ones are shorter, each unknown measured by the most that the readings
/// have seen of it (More 1978): of a ball that has lost touch they see nothing. Where balls touch at the minimum, long steps
/// promise what they do not bring, and the search ends with short ones.
///
/// # Errors
/// [`Failed`] says why there is none.
pub fn search<M: Model>(
    misfit: &Misfit,
    model: &mut M,
    start: &Point,
    limits: Limits,
) -> Result<Reached, Failed<M::Error>> {
    let mut seen = misfit.at(start);
    let mut point: Option<Point> = None;
    let mut radius = f64::INFINITY;
    let mut scale = DVector::zeros(seen.reach.len());
    for number in 0..limits.steps {
        let of_each = (seen.misfit / misfit.readings() as f64).max(1.0);
        let enough = if limits.ranked { ROUGHLY * of_each } else { ENOUGH };
        scale.zip_apply(&seen.reach, |scale, reach| *scale = reach.max(*scale));
        let measured = scale.map(|scale| if scale > 0.0 { scale } else { 1.0 });
        let (step, promised) = misfit.step(&seen, radius, measured).ok_or(Failed::NotFinite)?;
        let length = scale.component_mul(&step).norm();
        let whole = length < 0.99 * radius;
        if promised < enough {
            return Ok(Reached { point, ended: true });
        }
        if number > 1 && whole && seen.misfit - 2.0 * promised > limits.bound {
            return Ok(Reached { point, ended: false });
        }
        let values = misfit.moved(&point.as_ref().unwrap_or(start).values, &seen, &step);
        // With slopes: six steps of seven are taken, and then they are wanted.
        let there = model.at(values, &misfit.unknowns().index).map_err(Failed::Model)?;
        let there: Option<(Seen, Point)> = there.map(|there| (misfit.at(&there), there));
        let gained = there.as_ref().map_or(f64::NEG_INFINITY, |(there, _)| seen.misfit - there.misfit);
        if let Some((better, there)) = there.filter(|_| gained > 0.0) {
            (seen, point) = (better, Some(there));
            if gained < enough && whole {
                return Ok(Reached { point, ended: true });
            }
        }
        if gained < POOR * promised {
            radius = length / 4.0;
        } else if gained > GOOD * promised {
            radius = radius.max(2.0 * length);
        }
    }
    Ok(Reached { point, ended: false })
}

#[cfg(test)]
#[allow(clippy::panic)]
mod tests {
    use std::convert::Infallible;
    use std::sync::Arc;

    use nalgebra::DMatrix;

    use super::*;
    use crate::covariance::whitener::Whitener;
    use crate::posterior::misfit::Unknowns;

    /// A model of two numbers, and how often it was asked.
    struct Of<F>(F, usize);

    impl<F: Fn(f64, f64) -> Option<([f64; 3], [f64; 6])>> Model for Of<F> {
        type Error = Infallible;

        fn at(&mut self, values: Vec<f64>, _: &[usize]) -> Result<Option<Point>, Infallible> {
            self.1 += 1;
            let found = (self.0)(values[0], values[1]);
            Ok(found.map(|(predicted, slopes)| Point {
                values,
                predicted: predicted.to_vec(),
                slopes: slopes.to_vec(),
            }))
        }
    }

    /// Readings of 0 without offsets, of unknowns without priors.
    fn misfit(high: f64) -> Misfit {
        let unknowns = Unknowns {
            index: vec![0, 1],
            mean: vec![0.0; 2],
            unit: vec![1.0; 2],
            precision: vec![0.0; 2],
            log: vec![false; 2],
            low: vec![f64::NEG_INFINITY; 2],
            high: vec![high; 2],
        };
        let whitener = Whitener { inverse: vec![1.0; 3], ..Whitener::default() };
        Misfit::new(vec![0.0; 3], DMatrix::zeros(3, 0), Arc::new(whitener), unknowns)
    }

    fn reached<F: Fn(f64, f64) -> Option<([f64; 3], [f64; 6])>>(
        misfit: &Misfit,
        model: F,
        start: [f64; 2],
        limits: Limits,
    ) -> (Point, bool, usize) {
        let mut model = Of(model, 0);
        let Ok(Some(start)) = model.at(start.to_vec(), &[]) else { panic!("no start") };
        let Ok(Reached { point, ended }) = search(misfit, &mut model, &start, limits) else {
            panic!("no search")
        };
        (point.unwrap_or(start), ended, model.1 - 1)
    }

    const LIMITS: Limits = Limits { steps: 40, bound: f64::INFINITY, ranked: false };

    #[test]
    fn a_linear_problem_takes_one_step() {
        let line = |a: f64, b: f64| Some(([a - 3.0, 2.0 * b + 2.0, 0.0], [1.0, 0.0, 0.0, 2.0, 0.0, 0.0]));
        let (end, ended, asked) = reached(&misfit(f64::INFINITY), line, [0.0, 0.0], LIMITS);
        assert!((end.values[0] - 3.0).abs() < 1e-12 && (end.values[1] + 1.0).abs() < 1e-12);
        assert!(ended && asked == 1);
        let (end, ended, _) = reached(&misfit(2.0), line, [0.0, 0.0], LIMITS);
        assert!(end.values[0].to_bits() == 2.0_f64.to_bits() && ended);
    }

    #[test]
    fn where_a_step_does_not_gain_shorter_ones_do() {
        // Rosenbrock's valley, from beside it; the whole step leads up the other wall.
        let bent = |a: f64, b: f64| {
            Some(([10.0 * (b - a * a), 1.0 - a, 0.0], [-20.0 * a, 10.0, -1.0, 0.0, 0.0, 0.0]))
        };
        let (end, ended, asked) = reached(&misfit(f64::INFINITY), bent, [-1.2, 1.0], LIMITS);
        assert!((1.0 - end.values[0]).abs() < 0.15 && ended && asked > 2, "{end:?}");
        // No solution far from the start.
        let walled = |a: f64, b: f64| (a + 1.2).hypot(b - 1.0).lt(&0.5).then(|| bent(a, b)).flatten();
        let (end, ..) = reached(&misfit(f64::INFINITY), walled, [-1.2, 1.0], LIMITS);
        assert!(end.predicted[0].hypot(end.predicted[1]) < 2.2, "{end:?}");
    }

    #[test]
    fn an_end_that_is_ranked_comes_sooner_and_beside_a_misfit_far_above_the_noise_sooner_still() {
        let beside = |rest: f64| {
            move |a: f64, b: f64| {
                Some(([10.0 * (b - a * a), 1.0 - a, rest], [-20.0 * a, 10.0, -1.0, 0.0, 0.0, 0.0]))
            }
        };
        let asked = |rest, ranked| {
            let limits = Limits { ranked, ..LIMITS };
            let (_, ended, asked) = reached(&misfit(f64::INFINITY), beside(rest), [-1.2, 1.0], limits);
            assert!(ended);
            asked
        };
        assert!(asked(0.0, true) < asked(0.0, false));
        // A rest of 5 makes the misfit 8 a reading and more.
        assert!(asked(5.0, true) < asked(0.0, true));
        assert_eq!(asked(5.0, false), asked(0.0, false));
    }

    #[test]
    fn what_stays_above_the_bound_is_given_up() {
        let far = |a: f64, b: f64| Some(([a.powi(3), b, 10.0], [3.0 * a * a, 0.0, 0.0, 1.0, 0.0, 0.0]));
        let limits = Limits { bound: 10.0, ..LIMITS };
        let (_, ended, asked) = reached(&misfit(f64::INFINITY), far, [8.0, 1.0], limits);
        let (_, _, all) = reached(&misfit(f64::INFINITY), far, [8.0, 1.0], LIMITS);
        assert!(!ended && asked < all, "{asked} of {all}");
    }
}
