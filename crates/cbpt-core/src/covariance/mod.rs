//! The covariance of readings: what a search for it and a fit under it do hundreds of times.
//!
//! - [`whitener`]: readings made independent and of unit variance; [`filter`]: where no differences whiten;
//! - [`products`]: scalar products of columns seen through a noise, for any scale, correlation and offset of runs;
//! - [`solved`]: normal unknowns taken out of readings;
//! - [`search`]: the noise that makes readings most likely.
//!
//! A search sees a table by products alone, so a noise is weighed in time that does not grow with the readings. Which columns
//! these are, and in what unit, the caller knows: the Python package, which makes the products (`lab/covariance`).

pub mod filter;
pub mod products;
pub mod search;
pub mod solved;
pub mod whitener;
