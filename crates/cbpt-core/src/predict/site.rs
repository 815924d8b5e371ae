//! What carries a load at one input angle: the pairs of a ball drive, or a torsion spring in their place.

use crate::status::Status;

use super::mesh::{Mesh, Pairs, Wanted, Warm};
use super::spring::Spring;

/// What carries a load at one input angle.
#[derive(Debug, Clone)]
pub enum Site<'a> {
    /// The pairs of a ball drive.
    Pairs(Pairs<'a>),
    /// A torsion spring, the same at every angle.
    Spring(Spring<'a>),
}

impl Site<'_> {
    /// Solves it under a torque (N m) and a preload (N); see [`Pairs::solve`].
    ///
    /// # Errors
    /// The status, where there is no solution.
    pub fn solve(&self, load: [f64; 2], wanted: Option<Wanted>, warm: &mut Warm) -> Result<Mesh, Status> {
        match self {
            Self::Pairs(pairs) => pairs.solve(load, wanted, warm),
            Self::Spring(spring) => Ok(spring.solve(load[0])),
        }
    }
}
