//! Scalar products of columns seen through a noise: a scale s, a correlation rho from a reading to the next of its run, offsets
//! of runs, and columns that the readings share.
//!
//! With z the columns over the standard deviations, the autoregression whitens a reading that follows another to
//! (`z_t` - rho `z_(t-1)`) / sqrt(1 - rho^2) and all others to z (Cochrane and Orcutt 1949): products are a polynomial in rho.
//! An offset of standard deviation o in each run takes b b' (1 - 1/(1 + o^2 |b|^2)) / |b|^2 off them, b being the whitened
//! column of ones; shared columns U, of variance 1, take X'U (1 + U'U)^-1 U'X.

use nalgebra::DMatrix;

/// Products of columns, of which the last may be shared ones, before offsets of runs.
#[derive(Debug, Clone)]
pub struct Products {
    /// Of all columns with each other.
    pub gram: DMatrix<f64>,
    /// Of each run: those of the columns with a column of ones, and, last, that of the ones with themselves. Without rows where
    /// they were not asked for.
    pub by_run: DMatrix<f64>,
    /// Logarithm of the determinant of the covariance.
    pub log_det: f64,
}

impl Products {
    /// The same with offsets of runs of this standard deviation and with the last `shared` columns as a part of the noise;
    /// `None` where that is no covariance.
    pub fn beside(self, offset: f64, shared: usize) -> Option<(DMatrix<f64>, f64)> {
        let Self { mut gram, by_run, mut log_det } = self;
        if offset != 0.0 {
            let ones = by_run.ncols() - 1;
            for run in by_run.row_iter() {
                let size = run[ones];
                let grown = 1.0 + offset * offset * size;
                let weight = (1.0 - 1.0 / grown) / size;
                log_det += grown.ln();
                for j in 0..ones {
                    let taken = weight * run[j];
                    for i in 0..ones {
                        gram[(i, j)] -= run[i] * taken;
                    }
                }
            }
        }
        if shared == 0 {
            return Some((gram, log_det));
        }
        let kept = gram.nrows() - shared;
        let among = DMatrix::identity(shared, shared) + gram.view((kept, kept), (shared, shared));
        let factor = among.cholesky()?;
        log_det += 2.0 * factor.l_dirty().diagonal().map(f64::ln).sum();
        let across = gram.view((kept, 0), (shared, kept)).into_owned();
        let taken = across.transpose() * factor.solve(&across);
        Some((gram.view((0, 0), (kept, kept)) - taken, log_det))
    }
}

/// Products of columns through a noise of any scale and correlation.
pub trait Whitened {
    /// Why there are none.
    type Error;

    /// Through one noise; `by_run` where those of runs are wanted.
    ///
    /// # Errors
    /// What keeps the products from being made.
    fn products(&self, scale: f64, correlation: f64, by_run: bool) -> Result<Products, Self::Error>;

    /// Whether the whole noise grows with the scale; else a part of it has a size of its own.
    fn scales(&self) -> bool;
}

/// Products of readings that differences whiten: parts of polynomials in the correlation.
#[derive(Debug, Clone)]
pub struct Polynomials {
    /// Of first readings of runs, of followers, of followers with those before them (twice, negative), of those before.
    pub grams: [DMatrix<f64>; 4],
    /// The same by run, as [`Products::by_run`].
    pub by_run: [DMatrix<f64>; 4],
    /// Logarithm of the determinant at a scale of 1 without correlation.
    pub log_det: f64,
    /// How many readings there are, and how many of them follow another in their run.
    pub readings: [usize; 2],
}

impl Whitened for Polynomials {
    type Error = std::convert::Infallible;

    fn scales(&self) -> bool {
        true
    }

    fn products(&self, scale: f64, correlation: f64, by_run: bool) -> Result<Products, Self::Error> {
        let square = scale * scale;
        let left = 1.0 - correlation * correlation;
        let at = |[first, now, cross, then]: &[DMatrix<f64>; 4]| {
            let mut sum = first / square;
            let places = sum.as_mut_slice().iter_mut().zip(now.as_slice()).zip(cross.as_slice());
            for (((sum, now), cross), then) in places.zip(then.as_slice()) {
                *sum += (now + correlation * (cross + correlation * then)) / (left * square);
            }
            sum
        };
        let [readings, followers] = self.readings.map(|count| count as f64);
        Ok(Products {
            gram: at(&self.grams),
            by_run: if by_run { at(&self.by_run) } else { DMatrix::zeros(0, 0) },
            log_det: self.log_det + readings * square.ln() + followers * left.ln(),
        })
    }
}

#[cfg(test)]
#[allow(clippy::panic)]
mod tests {
    use super::*;

    /// Four readings in two runs of two, with two columns, the last of which is shared. Against the inverse of the covariance.
    #[test]
    fn products_are_those_of_the_dense_covariance() {
        let columns = DMatrix::from_row_slice(4, 2, &[1.0, 0.5, -2.0, 1.5, 0.3, -1.0, 0.7, 2.0]);
        let (scale, correlation, offset) = (1.3_f64, 0.4, 0.8);
        let sd: [f64; 4] = [0.5, 0.7, 0.9, 1.1];
        let together = |i: usize, j: usize| i / 2 == j / 2;
        let covariance = DMatrix::from_fn(4, 4, |i, j| {
            let rho = if i == j { 1.0 } else { correlation };
            let own =
                if together(i, j) { scale * scale * sd[i] * sd[j] * rho + offset * offset } else { 0.0 };
            own + columns[(i, 1)] * columns[(j, 1)]
        });
        let z = DMatrix::from_fn(4, 3, |i, j| if j == 2 { 1.0 } else { columns[(i, j)] } / sd[i]);
        let parts =
            |rows: [usize; 2], others: [usize; 2]| z.select_rows(&rows).transpose() * z.select_rows(&others);
        let of_run = |row: usize, other: usize| z.row(row).transpose() * z.row(other);
        let both = |m: DMatrix<f64>| -(&m + m.transpose());
        let (firsts, followers) = ([0, 2], [1, 3]);
        let grams = [
            parts(firsts, firsts),
            parts(followers, followers),
            both(parts(followers, firsts)),
            parts(firsts, firsts),
        ];
        let ones = |of: &dyn Fn(usize) -> DMatrix<f64>| DMatrix::from_fn(2, 3, |run, j| of(2 * run)[(j, 2)]);
        let polynomials = Polynomials {
            grams: grams.map(|gram| gram.view((0, 0), (2, 2)).into_owned()),
            by_run: [
                ones(&|first| of_run(first, first)),
                ones(&|first| of_run(first + 1, first + 1)),
                ones(&|first| both(of_run(first + 1, first))),
                ones(&|first| of_run(first, first)),
            ],
            log_det: 2.0 * sd.iter().map(|sd| sd.ln()).sum::<f64>(),
            readings: [4, 2],
        };
        let Ok(products) = polynomials.products(scale, correlation, true);
        let both_ways = (products.beside(offset, 1), covariance.cholesky());
        let (Some((gram, log_det)), Some(factor)) = both_ways else { panic!("no covariance") };
        let y = columns.column(0).into_owned();
        assert!((gram[(0, 0)] - y.dot(&factor.solve(&y))).abs() < 1e-12, "{gram}");
        assert!((log_det - 2.0 * factor.l().diagonal().map(f64::ln).sum()).abs() < 1e-12);
    }
}
