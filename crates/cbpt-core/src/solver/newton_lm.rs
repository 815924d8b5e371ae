//! Newton's method with Levenberg-Marquardt globalisation for the gradient of a convex energy.
//!
//! Problem: find x with r(x) = grad E(x) = 0, E convex, r once but not twice differentiable (contacts part).
//! Step: (J + lambda I) s = -r with J = grad r (Levenberg 1944, Marquardt 1963; here on the Hessian itself, which is
//! symmetric, not on J^T J, which would square its condition). The step is a descent direction of E for every
//! lambda >= 0, so a larger lambda always rescues a step that overshoots; near the solution lambda is 0 and the step
//! is Newton's.

use nalgebra::{SMatrix, SVector};

use super::problem::{Evaluation, Problem};

/// When to stop.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Options {
    /// Largest component of the scaled residual that counts as solved.
    pub tolerance: f64,
    /// At this residual the last digits are there and no further step is tried.
    pub floor: f64,
    /// Most steps to try, accepted or not.
    pub most_steps: u32,
}

impl Default for Options {
    fn default() -> Self {
        Self { tolerance: 1e-11, floor: 0.0, most_steps: 500 }
    }
}

/// Where the iteration stopped.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stop<const N: usize> {
    /// Scaled unknowns.
    pub x: SVector<f64, N>,
    /// Energy, residual and Jacobian there.
    pub at: Evaluation<N>,
    /// Largest component of the scaled residual.
    pub residual: f64,
    /// Steps tried.
    pub steps: u32,
    /// Whether the residual is within the tolerance.
    pub converged: bool,
}

/// Below this share of the energy its change is rounding, and the residual decides instead.
const ENERGY_RESOLUTION: f64 = 1e-13;
/// Damping after the first refused step, as a share of the largest curvature.
const FIRST_DAMPING: f64 = 1e-9;

/// Iterates from `start` until the residual is at the tolerance and no longer falls.
pub fn solve<const N: usize>(problem: &impl Problem<N>, start: SVector<f64, N>, options: Options) -> Stop<N> {
    let mut x = start;
    let mut at = problem.evaluate(&x);
    let mut damping = 0.0;
    let mut steps = 0;
    let mut refusals = 0;
    while steps < options.most_steps && at.residual.amax() > options.floor {
        let converged = at.residual.amax() <= options.tolerance;
        steps += 1;
        let Some(step) = damped_step(&at, damping) else {
            if converged {
                break;
            }
            damping = raised(damping, refusals);
            refusals += 1;
            continue;
        };
        let candidate_x = x + step;
        let candidate = problem.evaluate(&candidate_x);
        // Once converged, take further steps only while each still halves the residual: the last digits are free.
        let worthwhile = candidate.residual.amax() < 0.5 * at.residual.amax();
        if converged && !worthwhile {
            break;
        }
        if improves(&at, &candidate, &step) {
            (x, at) = (candidate_x, candidate);
            damping = lowered(damping);
            refusals = 0;
        } else {
            damping = raised(damping, refusals);
            refusals += 1;
        }
    }
    let residual = at.residual.amax();
    Stop { x, at, residual, steps, converged: residual <= options.tolerance }
}

/// s = -(J + lambda I)^-1 r, or `None` where the matrix is not positive definite to rounding.
fn damped_step<const N: usize>(at: &Evaluation<N>, damping: f64) -> Option<SVector<f64, N>> {
    let size = at.jacobian.diagonal().amax();
    if size.is_nan() || size.is_infinite() {
        return None;
    }
    let scale = if size > 0.0 { size } else { 1.0 };
    let damped = at.jacobian + SMatrix::<f64, N, N>::identity() * (damping * scale);
    let step = -solve_symmetric(damped, at.residual)?;
    step.iter().all(|s| s.is_finite()).then_some(step)
}

/// Cholesky of a small symmetric matrix, scaled to a unit diagonal so that its pivots tell near-singularity; `None`
/// where it is not positive definite to rounding.
pub fn solve_symmetric<const N: usize>(
    matrix: SMatrix<f64, N, N>,
    right: SVector<f64, N>,
) -> Option<SVector<f64, N>> {
    let scale = matrix.diagonal().map(|d| if d > 0.0 { d.sqrt().recip() } else { 0.0 });
    let scaled = SMatrix::<f64, N, N>::from_fn(|i, j| matrix[(i, j)] * scale[i] * scale[j]);
    let solution = scaled.cholesky()?.solve(&right.component_mul(&scale));
    Some(solution.component_mul(&scale))
}

/// Sufficient decrease of the energy, or of the residual once the energy no longer resolves the step.
fn improves<const N: usize>(at: &Evaluation<N>, candidate: &Evaluation<N>, step: &SVector<f64, N>) -> bool {
    let promised = at.residual.dot(step);
    let gained = candidate.energy - at.energy;
    if !candidate.energy.is_finite() {
        return false;
    }
    if promised.abs() > ENERGY_RESOLUTION * (at.energy.abs() + candidate.energy.abs()) {
        gained <= 1e-4 * promised
    } else {
        candidate.residual.amax() < at.residual.amax()
    }
}

/// After a step that overshot: by a factor that doubles with every refusal in a row (Nielsen 1999), from far below what
/// any state needs, because the smallest curvature of a state with few contacts is many orders below its largest.
fn raised(damping: f64, refusals: i32) -> f64 {
    if damping == 0.0 { FIRST_DAMPING } else { damping * 2_f64.powi(1 + refusals.min(20)) }
}

/// After a good step: quickly back to Newton's.
fn lowered(damping: f64) -> f64 {
    if damping <= FIRST_DAMPING { 0.0 } else { damping / 16.0 }
}
