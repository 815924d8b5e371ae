//! Root of a convex energy's gradient, by Newton with Levenberg-Marquardt globalisation.
//!
//! - [`problem`]: what the solver is given: residual, Jacobian, energy, all scaled to order one;
//! - [`newton_lm`]: the iteration and where it stopped.
//!
//! Knows no ball and no groove.

pub mod newton_lm;
pub mod problem;
