//! The covariance of readings, from scalar products of their columns: what a search for it does hundreds of times.
//!
//! - [`products`]: scalar products of columns seen through a noise, for any scale, correlation and offset of runs;
//! - [`solved`]: normal unknowns taken out of readings;
//! - [`search`]: the noise that makes readings most likely.
//!
//! A table is seen here by products alone, so a noise is weighed in time that does not grow with the readings. Which columns
//! these are, and in what unit, the caller knows: the Python package, which makes the products (`lab/covariance`).

pub mod products;
pub mod search;
pub mod solved;
