//! Normal unknowns taken out of readings, from scalar products alone.
//!
//! With A = X'X + the precisions of the priors, the mode is A^-1 X'y, and what is left of |y|^2 is y'y - y'X A^-1 X'y, misfit
//! and priors together.

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

/// Unknowns at their most probable values.
#[derive(Debug, Clone)]
pub struct Solved {
    /// Of A.
    pub factor: Cholesky<f64, Dyn>,
    /// The most probable values.
    pub mode: DVector<f64>,
    /// Misfit and priors there.
    pub chi2: f64,
    /// Half the log determinant of the precisions, where there are any, less half that of A.
    pub log_volume: f64,
}

impl Solved {
    /// From X'X, X'y, y'y and the precision of each unknown, 0 where it is flat; `None` where A is not positive.
    pub fn of(
        mut gram: DMatrix<f64>,
        projection: &DVector<f64>,
        square: f64,
        precision: &[f64],
    ) -> Option<Self> {
        for (place, precision) in precision.iter().enumerate() {
            gram[(place, place)] += precision;
        }
        // A column that the table cannot see at all has no curvature; a hair of precision keeps A invertible.
        let hair = 1e-12 * gram.trace().max(1e-300) / precision.len().max(1) as f64;
        for place in 0..precision.len() {
            gram[(place, place)] += hair;
        }
        let factor = gram.cholesky()?;
        let mode = factor.solve(projection);
        let known: f64 = precision.iter().filter(|&&value| value > 0.0).map(|value| value.ln()).sum();
        let log_volume = 0.5 * known - factor.l_dirty().diagonal().map(f64::ln).sum();
        let chi2 = square - projection.dot(&mode);
        // `f64::max` would turn what is no number into 0.
        Some(Self { factor, mode, chi2: if chi2 < 0.0 { 0.0 } else { chi2 }, log_volume })
    }
}
