//! A system of N equations that is the gradient of a convex energy.

use nalgebra::{SMatrix, SVector};

/// Energy, its gradient and its Hessian at one point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Evaluation<const N: usize> {
    /// Convex energy; its stationary point is the solution.
    pub energy: f64,
    /// Gradient of the energy: the equations, scaled so that 1 is the size of the load.
    pub residual: SVector<f64, N>,
    /// Hessian of the energy: symmetric, never indefinite.
    pub jacobian: SMatrix<f64, N, N>,
}

/// N scaled equations in N scaled unknowns.
pub trait Problem<const N: usize> {
    /// Energy, residual and Jacobian at `x`.
    fn evaluate(&self, x: &SVector<f64, N>) -> Evaluation<N>;
}
