//! The most probable values of unknown numbers, of which readings and priors tell.
//!
//! - [`misfit`]: how far both are off at some values, and the step that brings them nearest;
//! - [`search`]: steps until none promises to gain.
//!
//! What is unknown and under which noise the caller knows: the Python package (`lab/inference`).

pub mod misfit;
pub mod search;
