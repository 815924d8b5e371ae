//! The misfit of readings with the priors of the unknowns, and its Gauss-Newton step.
//!
//! Readings and slopes are whitened, then what the offsets of the readings take is left out. Steps are counted in the unit of
//! each unknown; an unknown that is searched in logarithms has coordinates of its own.
//!
//! - [`Unknowns`]: what is unknown, and its priors; [`Point`]: a model at some values;
//! - [`Misfit`]: readings under a noise; [`Seen`]: what it sees of a point.

use std::sync::Arc;

use nalgebra::{DMatrix, DVector};

use crate::covariance::whitener::{Whitener, take};
use crate::solver::bounded::{Quadratic, step_within};

/// What is unknown. Of each, in its coordinate, which is a logarithm where it is searched in these.
#[derive(Debug, Clone, Default)]
pub struct Unknowns {
    /// Its place among the values of the model.
    pub index: Vec<usize>,
    /// Mean of its prior.
    pub mean: Vec<f64>,
    /// One step.
    pub unit: Vec<f64>,
    /// Of its prior, by steps; 0 where there is none.
    pub precision: Vec<f64>,
    /// Whether it is searched in logarithms.
    pub log: Vec<bool>,
    /// The least that it can be.
    pub low: Vec<f64>,
    /// The most that it can be.
    pub high: Vec<f64>,
}

/// A model at some values of its numbers.
#[derive(Debug, Clone, PartialEq)]
pub struct Point {
    /// All of its numbers.
    pub values: Vec<f64>,
    /// What it predicts, in the unit of the readings.
    pub predicted: Vec<f64>,
    /// How that answers to each unknown, reading by reading; none where only the misfit is asked for.
    pub slopes: Vec<f64>,
}

/// Readings under a noise.
#[derive(Debug, Clone)]
pub struct Misfit {
    readings: Vec<f64>,
    /// Orthonormal columns that span those of the offsets, whitened.
    basis: DMatrix<f64>,
    whitener: Arc<Whitener>,
    unknowns: Unknowns,
}

/// Readings less model in the first column, then slopes by one step of each unknown.
#[derive(Debug, Clone)]
pub struct Seen {
    /// Whitened.
    pub white: DMatrix<f64>,
    /// The same less what the offsets take.
    pub left: DMatrix<f64>,
    /// Of the unknowns.
    pub coordinates: DVector<f64>,
    /// Unknowns off the mean of their priors, in steps; 0 where there is no prior.
    pub off: DVector<f64>,
    /// Whitened misfit after the best offsets, and priors.
    pub misfit: f64,
    /// How far readings and priors see one step of each unknown, in standard deviations.
    pub reach: DVector<f64>,
}

impl Misfit {
    /// Of readings with columns of offsets, these whitened.
    pub fn new(
        readings: Vec<f64>,
        offsets: DMatrix<f64>,
        whitener: Arc<Whitener>,
        unknowns: Unknowns,
    ) -> Self {
        Self { readings, basis: offsets.qr().q(), whitener, unknowns }
    }

    /// How many readings there are.
    pub fn readings(&self) -> usize {
        self.readings.len()
    }

    /// What is unknown.
    pub fn unknowns(&self) -> &Unknowns {
        &self.unknowns
    }

    /// Of the unknowns at some values of the model.
    pub fn coordinates(&self, values: &[f64]) -> DVector<f64> {
        let places = self.unknowns.index.iter().zip(&self.unknowns.log);
        let of = places.map(|(index, log)| if *log { values[*index].ln() } else { values[*index] });
        DVector::from_iterator(self.unknowns.index.len(), of)
    }

    /// Some values with the unknowns at these coordinates.
    pub fn values_at(&self, values: &[f64], coordinates: &[f64]) -> Vec<f64> {
        let mut moved = values.to_vec();
        for ((index, log), x) in self.unknowns.index.iter().zip(&self.unknowns.log).zip(coordinates) {
            moved[*index] = if *log { x.exp() } else { *x };
        }
        moved
    }

    /// Slopes by one step of each unknown, in the unit of the readings; none where there are not so many.
    pub fn columns(&self, point: &Point) -> DMatrix<f64> {
        let Unknowns { index, log, unit, .. } = &self.unknowns;
        let asked = point.slopes.len() == self.readings.len() * unit.len();
        let width = if asked { unit.len() } else { 0 };
        DMatrix::from_fn(self.readings.len(), width, |row, place| {
            let by = if log[place] { point.values[index[place]] * unit[place] } else { unit[place] };
            point.slopes[row * width + place] * by
        })
    }

    /// What is seen at a point.
    pub fn at(&self, point: &Point) -> Seen {
        let residual = self.readings.iter().zip(&point.predicted).map(|(read, predicted)| read - predicted);
        let residual = DVector::from_iterator(self.readings.len(), residual);
        let mut white = self.columns(point).insert_column(0, 0.0);
        white.set_column(0, &residual);
        self.whitener.whiten(&mut white);
        let mut left = white.clone();
        for mut column in left.column_iter_mut() {
            take(&self.basis, |_, along| along, &mut column);
        }
        let Unknowns { mean, unit, precision, .. } = &self.unknowns;
        let coordinates = self.coordinates(&point.values);
        let off = DVector::from_fn(mean.len(), |place, _| {
            if precision[place] > 0.0 { (coordinates[place] - mean[place]) / unit[place] } else { 0.0 }
        });
        let priors: f64 = precision.iter().zip(&off).map(|(precision, off)| precision * off * off).sum();
        let lengths = white.column_iter().skip(1).zip(precision);
        let reach = lengths.map(|(column, precision)| (column.norm_squared() + precision).sqrt());
        let reach = DVector::from_iterator(white.ncols() - 1, reach);
        Seen { misfit: left.column(0).norm_squared() + priors, white, left, coordinates, off, reach }
    }

    /// The step that the linear problem asks for within the bounds, no longer than the radius, each unknown measured by its
    /// scale; and what it promises. `None` where the slopes are not finite.
    pub fn step(&self, seen: &Seen, radius: f64, scale: DVector<f64>) -> Option<(DVector<f64>, f64)> {
        let Unknowns { unit, precision, low, high, .. } = &self.unknowns;
        let Seen { left, coordinates, off, .. } = seen;
        let count = unit.len();
        let mut curved = DMatrix::zeros(count, count);
        for i in 0..count {
            for j in 0..=i {
                let product = left.column(i + 1).dot(&left.column(j + 1));
                (curved[(i, j)], curved[(j, i)]) = (product, product);
            }
            curved[(i, i)] += precision[i];
        }
        // The prior's own pull: its residual is where the unknown stands now.
        let pull = |place: usize| left.column(place + 1).dot(&left.column(0)) - precision[place] * off[place];
        let slope = DVector::from_fn(count, |place, _| pull(place));
        let to = |bounds: &[f64]| {
            DVector::from_fn(count, |place, _| (bounds[place] - coordinates[place]) / unit[place])
        };
        let problem = Quadratic { curved, slope, scale, radius };
        if !problem.is_finite() {
            return None;
        }
        let Ok(step) = step_within(&problem, &to(low), &to(high));
        let promised = problem.promised(&step);
        Some((step, promised))
    }

    /// Values after a step.
    pub fn moved(&self, values: &[f64], seen: &Seen, step: &DVector<f64>) -> Vec<f64> {
        let Unknowns { unit, low, high, .. } = &self.unknowns;
        let end = |place: usize| {
            let x = (seen.coordinates[place] + step[place] * unit[place]).max(low[place]).min(high[place]);
            // At a bound to the last digit, where a step ends there.
            let near = |bound: &f64| (x - bound).abs() <= 1e-12 * unit[place];
            [high[place], low[place]].into_iter().find(near).unwrap_or(x)
        };
        let coordinates: Vec<f64> = (0..unit.len()).map(end).collect();
        self.values_at(values, &coordinates)
    }
}

#[cfg(test)]
#[allow(clippy::panic)]
mod tests {
    use super::*;

    /// Four readings of 2 a + 3 e^b + zero, whitened by standard deviations; b has a prior.
    fn case() -> (Misfit, Point) {
        let unknowns = Unknowns {
            index: vec![2, 0],
            mean: vec![0.0, 0.1],
            unit: vec![0.5, 0.25],
            precision: vec![0.0, 4.0],
            log: vec![false, true],
            low: vec![-100.0, -100.0],
            high: vec![100.0, 100.0],
        };
        let whitener = Whitener { inverse: vec![1.0, 2.0, 0.5, 1.0], ..Whitener::default() };
        let mut offsets = DMatrix::from_element(4, 1, 1.0);
        whitener.whiten(&mut offsets);
        let misfit = Misfit::new(vec![1.0, -2.0, 0.5, 3.0], offsets, Arc::new(whitener), unknowns);
        let point = Point {
            values: vec![1.2, 7.0, 0.3],
            predicted: vec![0.5, -1.0, 0.0, 2.0],
            slopes: vec![1.0, 0.3, -1.0, 0.2, 2.0, -0.4, 0.5, 1.0],
        };
        (misfit, point)
    }

    #[test]
    fn the_misfit_is_that_of_the_best_offset_and_the_priors() {
        let (misfit, point) = case();
        let seen = misfit.at(&point);
        let sd = [1.0, 0.5, 2.0, 1.0];
        let left: [f64; 4] = [0.5, -1.0, 0.5, 1.0];
        let weight = sd.map(|sd: f64| 1.0 / (sd * sd));
        let mean = left.iter().zip(weight).map(|(r, w)| r * w).sum::<f64>() / weight.iter().sum::<f64>();
        let chi2: f64 = left.iter().zip(weight).map(|(r, w)| w * (r - mean) * (r - mean)).sum();
        let off = (1.2_f64.ln() - 0.1) / 0.25;
        assert!((seen.misfit - chi2 - 4.0 * off * off).abs() < 1e-12);
        let slope_sd = [1.0, -1.0, 2.0, 0.5].iter().zip(weight).map(|(s, w)| 0.25 * s * s * w).sum::<f64>();
        assert!((seen.reach[0] - slope_sd.sqrt()).abs() < 1e-12);
    }

    #[test]
    fn the_step_leads_to_the_least_misfit_of_the_linear_problem() {
        let (misfit, point) = case();
        let seen = misfit.at(&point);
        let Some((step, promised)) = misfit.step(&seen, f64::INFINITY, DVector::from_element(2, 1.0)) else {
            panic!("no step")
        };
        // The linear problem itself moves by the columns, its prior by the step.
        let after = |step: &DVector<f64>| {
            let left = seen.left.column(0) - seen.left.columns(1, 2) * step;
            left.norm_squared() + 4.0 * (seen.off[1] + step[1]).powi(2)
        };
        assert!((seen.misfit - promised - after(&step)).abs() < 1e-10);
        for aside in [[1e-3, 0.0], [0.0, 1e-3], [-1e-3, 1e-3]] {
            assert!(after(&(&step + DVector::from_row_slice(&aside))) > after(&step));
        }
        let moved = misfit.moved(&point.values, &seen, &step);
        assert!((moved[2] - 0.3 - 0.5 * step[0]).abs() < 1e-12);
        assert!(((moved[0] / 1.2).ln() - 0.25 * step[1]).abs() < 1e-12);
        assert!(moved[1].to_bits() == 7.0_f64.to_bits());
    }

    #[test]
    fn a_step_to_a_bound_ends_there_to_the_last_digit() {
        let (mut misfit, point) = case();
        misfit.unknowns.high[0] = 0.3 + 1e-15;
        let seen = misfit.at(&point);
        let moved = misfit.moved(&point.values, &seen, &DVector::from_row_slice(&[3e-14, 0.0]));
        assert!(moved[2].to_bits() == misfit.unknowns.high[0].to_bits());
    }
}
