//! The mechanics against numbers from elsewhere, closed forms and finite differences. One program: it is linked once, and what
//! its parts share is compiled once.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::float_cmp)]

mod common;
mod convergence;
mod friction;
mod golden;
mod hertz;
mod jacobian;
mod lanes;
mod proof;
mod reference;
mod sensitivity;
mod strength;
mod torsion_spring;
