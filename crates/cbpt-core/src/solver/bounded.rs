//! The step of a linear problem within bounds.
//!
//! Each unknown is held where the way meets its bound, and let go where it pulls away from it again (an active set; Nocedal and
//! Wright 2006, chapter 16).
//!
//! - [`Linear`]: what a problem says of itself; [`step_within`]: its step;
//! - [`Quadratic`]: a misfit z'Az - 2 b'z, with a longest step (More 1978, section 5).

use std::convert::Infallible;

use nalgebra::{Cholesky, DMatrix, DVector, Dyn, SymmetricEigen};

/// A linear problem of p unknowns.
pub trait Linear {
    /// Why it cannot be asked.
    type Error;

    /// The step of those unknowns that are `free`, where the others have made theirs.
    ///
    /// # Errors
    /// What keeps it from being found.
    fn asked(&self, step: &DVector<f64>, free: &[bool]) -> Result<DVector<f64>, Self::Error>;

    /// Half the slope of the gain after a step.
    ///
    /// # Errors
    /// What keeps it from being found.
    fn pull(&self, step: &DVector<f64>) -> Result<DVector<f64>, Self::Error>;
}

/// The step that a problem asks for between bounds; where it begins, at 0, is within them but for the last digit.
///
/// # Errors
/// Of the problem.
pub fn step_within<L: Linear>(
    problem: &L,
    lower: &DVector<f64>,
    upper: &DVector<f64>,
) -> Result<DVector<f64>, L::Error> {
    let count = lower.len();
    let (low, high) = (lower.map(|bound| bound.min(0.0)), upper.map(|bound| bound.max(0.0)));
    let (mut step, mut free) = (DVector::zeros(count), vec![true; count]);
    for _ in 0..3 * count {
        let mut way = DVector::zeros(count);
        if free.contains(&true) {
            let asked = problem.asked(&step, &free)?;
            let places = (0..count).filter(|place| free[*place]);
            for (place, goal) in places.zip(&asked) {
                way[place] = goal - step[place];
            }
        }
        let end = |place: usize| (step[place] + way[place]).clamp(low[place], high[place]);
        let beyond = |place: usize| {
            free[place] && (step[place] + way[place] - end(place)).abs() > 1e-12 * way[place].abs()
        };
        let share = |place: usize| (end(place) - step[place]) / way[place];
        let out: Vec<(usize, f64)> =
            (0..count).filter(|place| beyond(*place)).map(|place| (place, share(place))).collect();
        let first = out.iter().map(|(_, share)| *share).fold(f64::INFINITY, f64::min);
        if out.is_empty() {
            step += &way;
            let slope = problem.pull(&step)?;
            let Some(away) = pulled_away(&step, &slope, &low, &high, &free) else { break };
            free[away] = true;
            continue;
        }
        let held: Vec<(usize, f64)> =
            out.iter().filter(|(_, share)| *share <= first).map(|&(place, _)| (place, end(place))).collect();
        step += first.max(0.0) * way;
        for (place, bound) in held {
            step[place] = bound;
            free[place] = false;
        }
    }
    Ok(step)
}

/// Of the unknowns that are held the one that pulls most away from its bound.
fn pulled_away(
    step: &DVector<f64>,
    slope: &DVector<f64>,
    low: &DVector<f64>,
    high: &DVector<f64>,
    free: &[bool],
) -> Option<usize> {
    let least = 1e-9 * slope.amax();
    let pulls = |place: &usize| {
        let place = *place;
        let inwards = if step[place] <= low[place] { slope[place] > 0.0 } else { slope[place] < 0.0 };
        !free[place] && inwards && low[place] < high[place] && slope[place].abs() > least
    };
    let mut best: Option<usize> = None;
    for place in (0..free.len()).filter(pulls) {
        if best.is_none_or(|best| slope[place].abs() > slope[best].abs()) {
            best = Some(place);
        }
    }
    best
}

/// A misfit z'Az - 2 b'z, and the longest step, each unknown measured by a scale.
#[derive(Debug, Clone)]
pub struct Quadratic {
    /// A, symmetric.
    pub curved: DMatrix<f64>,
    /// b.
    pub slope: DVector<f64>,
    /// Of each unknown, above 0.
    pub scale: DVector<f64>,
    /// The longest step; infinite for none.
    pub radius: f64,
}

impl Quadratic {
    /// Whether all of its numbers are.
    pub fn is_finite(&self) -> bool {
        self.curved.iter().chain(&self.slope).chain(&self.scale).copied().all(f64::is_finite)
    }

    /// What a step promises to gain.
    pub fn promised(&self, step: &DVector<f64>) -> f64 {
        2.0 * step.dot(&self.slope) - step.dot(&(&self.curved * step))
    }
}

impl Linear for Quadratic {
    type Error = Infallible;

    fn asked(&self, step: &DVector<f64>, free: &[bool]) -> Result<DVector<f64>, Infallible> {
        let places: Vec<usize> = (0..free.len()).filter(|place| free[*place]).collect();
        let held = DVector::from_fn(step.len(), |place, _| if free[place] { 0.0 } else { step[place] });
        let left = &self.slope - &self.curved * held;
        let scale = self.scale.select_rows(&places);
        let curved = DMatrix::from_fn(places.len(), places.len(), |i, j| {
            self.curved[(places[i], places[j])] / (scale[i] * scale[j])
        });
        let slope = left.select_rows(&places).component_div(&scale);
        Ok(within(curved, &slope, self.radius).component_div(&scale))
    }

    fn pull(&self, step: &DVector<f64>) -> Result<DVector<f64>, Infallible> {
        Ok(&self.slope - &self.curved * step)
    }
}

/// The z of the least z'Az - 2 b'z with |z| at most the radius (More 1978, section 5).
fn within(curved: DMatrix<f64>, slope: &DVector<f64>, radius: f64) -> DVector<f64> {
    let mut damping = 0.0;
    for _ in 0..50 {
        let mut damped = curved.clone();
        for place in 0..damped.nrows() {
            damped[(place, place)] += damping;
        }
        let Some(factors) = Cholesky::new(damped).filter(well_determined) else { break };
        let z = factors.solve(slope);
        let length = z.norm();
        if length <= 1.01 * radius {
            return z;
        }
        let Some(half) = factors.l_dirty().solve_lower_triangular(&z) else { break };
        damping += (length / radius) * (length - radius) / (half.norm_squared() / length);
    }
    within_by_axes(curved, slope, radius)
}

/// Whether rounding changes a solution little.
fn well_determined(factors: &Cholesky<f64, Dyn>) -> bool {
    let pivots = factors.l_dirty().diagonal();
    pivots.min().powi(2) > 1e-9 * pivots.max().powi(2)
}

/// The same where A is singular, or nearly: along its axes.
fn within_by_axes(curved: DMatrix<f64>, slope: &DVector<f64>, radius: f64) -> DVector<f64> {
    let SymmetricEigen { eigenvectors, eigenvalues } = curved.symmetric_eigen();
    let least = 1e-12 * eigenvalues.max().max(1e-300);
    let size = eigenvalues.map(|value| value.max(least));
    let along = eigenvectors.tr_mul(slope);
    let mut damping = 0.0;
    let mut z = along.component_div(&size);
    for _ in 0..50 {
        let length = z.norm();
        if length <= 1.01 * radius {
            break;
        }
        let squares = z.zip_map(&size, |z, size| z * z / (size + damping));
        damping += (length / radius) * (length - radius) / (squares.sum() / length);
        z = along.zip_map(&size, |along, size| along / (size + damping));
    }
    eigenvectors * z
}

#[cfg(test)]
mod tests {
    use super::*;

    /// B'B + shift of numbers that are spread out, p by p, and a slope.
    fn problem(count: usize, shift: f64) -> (DMatrix<f64>, DVector<f64>) {
        let number = |i: usize, j: usize| ((3 * i + 7 * j * j + 1) as f64).sin();
        let b = DMatrix::from_fn(count - 1, count, number);
        let curved = b.tr_mul(&b) + DMatrix::from_diagonal_element(count, count, shift);
        (curved, DVector::from_fn(count, |i, _| number(i, 2)))
    }

    #[test]
    fn factors_and_axes_lead_to_one_step() {
        let (curved, slope) = problem(12, 0.3);
        assert!(Cholesky::new(curved.clone()).is_some_and(|factors| well_determined(&factors)));
        for radius in [f64::INFINITY, 10.0, 0.5, 0.01] {
            let by_factors = within(curved.clone(), &slope, radius);
            let by_axes = within_by_axes(curved.clone(), &slope, radius);
            assert!((&by_factors - &by_axes).norm() < 1e-9 * by_axes.norm(), "{radius}");
            assert!(by_factors.norm() <= 1.01 * radius);
        }
    }

    #[test]
    fn a_direction_that_nothing_curves_is_left_to_the_axes() {
        let (curved, slope) = problem(6, 0.0);
        assert!(!Cholesky::new(curved.clone()).is_some_and(|factors| well_determined(&factors)));
        let z = within(curved.clone(), &slope, 2.0);
        assert!((z.norm() - 2.0).abs() < 0.03);
        let free = within(curved.clone(), &slope, f64::INFINITY);
        assert!((&free - within_by_axes(curved, &slope, f64::INFINITY)).norm() < 1e-12 * free.norm());
    }
}
