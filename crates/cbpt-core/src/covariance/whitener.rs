//! Readings made independent and of unit variance.
//!
//! The covariance is that of an autoregression along each run beside offsets of runs and columns that many readings share. The
//! autoregression is undone by differences (Cochrane and Orcutt 1949), the offset of a run by a step of rank one, shared columns
//! by one of their rank. Where no differences whiten, a [`Filter`] does.

use nalgebra::{DMatrix, DVector, DVectorView, DVectorViewMut};

use super::filter::Filter;

/// A root of the inverse of a covariance; see the fields for its parts, which act in their order.
#[derive(Debug, Clone, Default)]
pub struct Whitener {
    /// One over the standard deviation of each reading.
    pub inverse: Vec<f64>,
    /// What whitens in place of standard deviations and differences.
    pub filter: Option<Filter>,
    /// From a reading to the next of its run.
    pub correlation: f64,
    /// The reading before each one in its run.
    pub before: Vec<Option<usize>>,
    /// Offsets of runs.
    pub offsets: Option<Offsets>,
    /// What moves many readings at once.
    pub shared: Vec<Shared>,
}

/// An offset in each run, seen through what comes before it.
#[derive(Debug, Clone)]
pub struct Offsets {
    /// The run of each reading, counted from 0.
    pub run: Vec<usize>,
    /// A column of ones, whitened.
    pub ones: Vec<f64>,
    /// Of each run: (1 - 1/sqrt(1 + o^2 |b|^2)) / |b|^2, with b its ones and o the standard deviation of the offset.
    pub shrink: Vec<f64>,
}

/// Columns that readings share, seen through what comes before them.
#[derive(Debug, Clone)]
pub struct Shared {
    /// Orthonormal axes.
    pub axes: DMatrix<f64>,
    /// By how much each is shortened.
    pub shorter: DVector<f64>,
}

impl Whitener {
    /// Whitens columns, in place.
    pub fn whiten(&self, columns: &mut DMatrix<f64>) {
        let mut past = vec![0.0; columns.nrows()];
        let left = (1.0 - self.correlation * self.correlation).sqrt();
        for mut column in columns.column_iter_mut() {
            if let Some(filter) = &self.filter {
                filter.whiten(&mut column);
            } else {
                column.iter_mut().zip(&self.inverse).for_each(|(value, inverse)| *value *= inverse);
                if self.correlation != 0.0 {
                    past.iter_mut().zip(&column).for_each(|(past, value)| *past = *value);
                    for (value, before) in column.iter_mut().zip(&self.before) {
                        if let Some(before) = before {
                            *value = (*value - self.correlation * past[*before]) / left;
                        }
                    }
                }
            }
            if let Some(offsets) = &self.offsets {
                offsets.whiten(&mut column);
            }
            for Shared { axes, shorter } in &self.shared {
                take(axes, |axis, along| shorter[axis] * along, &mut column);
            }
        }
    }
}

impl Offsets {
    /// v - b (b'v) (1 - 1/sqrt(1 + o^2 |b|^2)) / |b|^2 makes I + o^2 b b' the identity.
    fn whiten(&self, column: &mut DVectorViewMut<'_, f64>) {
        let mut sums = vec![0.0; self.shrink.len()];
        for ((value, one), run) in column.iter().zip(&self.ones).zip(&self.run) {
            sums[*run] += value * one;
        }
        sums.iter_mut().zip(&self.shrink).for_each(|(sum, shrink)| *sum *= shrink);
        for ((value, one), run) in column.iter_mut().zip(&self.ones).zip(&self.run) {
            *value -= one * sums[*run];
        }
    }
}

/// Takes off a column, along each of some orthonormal axes, a part of what lies along it.
pub(crate) fn take(
    axes: &DMatrix<f64>,
    part: impl Fn(usize, f64) -> f64,
    column: &mut DVectorViewMut<'_, f64>,
) {
    let along = |axis: DVectorView<'_, f64>| axis.dot(column);
    let along: Vec<f64> = axes.column_iter().map(along).collect();
    for (place, (axis, along)) in axes.column_iter().zip(along).enumerate() {
        column.axpy(-part(place, along), &axis, 1.0);
    }
}

#[cfg(test)]
mod tests {
    use super::super::filter::Beside;
    use super::*;

    const SD: [f64; 5] = [0.5, 0.7, 0.9, 1.1, 0.6];
    /// Two runs that are interleaved.
    const RUN: [usize; 5] = [0, 1, 0, 1, 0];
    const BEFORE: [Option<usize>; 5] = [None, None, Some(0), Some(1), Some(2)];
    const RHO: f64 = 0.4;

    /// The autoregression along runs.
    fn along_runs() -> DMatrix<f64> {
        let place = [0, 0, 1, 1, 2];
        DMatrix::from_fn(5, 5, |i, j| {
            let apart = i32::abs(place[i] - place[j]);
            if RUN[i] == RUN[j] { SD[i] * SD[j] * RHO.powi(apart) } else { 0.0 }
        })
    }

    fn differences() -> Whitener {
        let inverse = SD.iter().map(|sd| 1.0 / sd).collect();
        Whitener { inverse, correlation: RHO, before: BEFORE.to_vec(), ..Whitener::default() }
    }

    fn whitens(whitener: &Whitener, covariance: &DMatrix<f64>) {
        let mut root = DMatrix::identity(5, 5);
        whitener.whiten(&mut root);
        let white = &root * covariance * root.transpose();
        assert!((white - DMatrix::identity(5, 5)).amax() < 1e-13, "{root}");
    }

    #[test]
    fn differences_whiten_an_autoregression() {
        whitens(&differences(), &along_runs());
    }

    #[test]
    fn offsets_and_shared_columns_are_whitened_beside_it() {
        let mut whitener = differences();
        let offset: f64 = 0.8;
        let mut ones = DMatrix::from_element(5, 1, 1.0);
        whitener.whiten(&mut ones);
        let size = |run: usize| -> f64 {
            let own = ones.iter().zip(RUN).filter(|(_, of)| *of == run);
            own.map(|(one, _)| one * one).sum()
        };
        let shrink = [0, 1].map(|run| (1.0 - 1.0 / (1.0 + offset * offset * size(run)).sqrt()) / size(run));
        let ones = ones.as_slice().to_vec();
        whitener.offsets = Some(Offsets { run: RUN.to_vec(), ones, shrink: shrink.to_vec() });
        let together = DMatrix::from_fn(5, 5, |i, j| if RUN[i] == RUN[j] { offset * offset } else { 0.0 });
        let covariance = along_runs() + together;
        whitens(&whitener, &covariance);

        let column = DMatrix::from_row_slice(5, 1, &[0.3, -1.0, 0.7, 2.0, 0.1]);
        let mut seen = column.clone();
        whitener.whiten(&mut seen);
        let length = seen.norm();
        let shorter = DVector::from_element(1, 1.0 - 1.0 / (1.0 + length * length).sqrt());
        whitener.shared.push(Shared { axes: seen / length, shorter });
        whitens(&whitener, &(covariance + &column * column.transpose()));
    }

    #[test]
    fn a_filter_whitens_what_scatters_beside_it() {
        let (order, own, shared) = ([0, 2, 4, 1, 3], [0.2, 0.0, 0.5, 0.3, 0.1], [0.4, 0.7, 0.3, 0.7, 0.6]);
        // Two holds in the first run, one in the second.
        let hold = [0, 2, 0, 2, 1];
        for (own, shared) in [(&own[..], &shared[..]), (&own, &[]), (&[], &shared), (&[], &[])] {
            let filter = Filter::new(&SD, RHO, &order, &BEFORE, Beside { own, shared, hold: &hold });
            let mut covariance = along_runs();
            for i in 0..5 {
                covariance[(i, i)] += own.get(i).map_or(0.0, |sd| sd * sd);
                for j in (0..5).filter(|j| hold[i] == hold[*j] && !shared.is_empty()) {
                    covariance[(i, j)] += shared[i] * shared[j];
                }
            }
            assert!((filter.log_det - covariance.determinant().ln()).abs() < 1e-12);
            whitens(&Whitener { filter: Some(filter), ..Whitener::default() }, &covariance);
        }
    }
}
