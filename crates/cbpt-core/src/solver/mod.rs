//! Solvers that know no ball and no groove.
//!
//! - [`newton_lm`]: root of a convex energy's gradient, by Newton with Levenberg-Marquardt globalisation: the iteration and
//!   where it stopped; [`problem`]: what it is given: residual, Jacobian, energy, all scaled to order one;
//! - [`bounded`]: the step of a linear problem within bounds.

pub mod bounded;
pub mod newton_lm;
pub mod problem;
