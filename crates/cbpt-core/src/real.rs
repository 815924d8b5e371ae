//! Numbers that formulas can be written in once, whether or not derivatives are carried along.
//!
//! `f64` here; [`crate::effect::dual::Dual`] carries partial derivatives. A formula written for a [`Real`] costs an `f64`
//! nothing: what only derivatives need is never computed.

use std::ops::{Add, Div, Mul, Neg, Sub};

/// A real number, perhaps with its derivatives.
pub trait Real:
    Copy
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + Add<f64, Output = Self>
    + Mul<f64, Output = Self>
{
    /// A number that depends on nothing.
    fn of(value: f64) -> Self;

    /// The value alone.
    fn value(&self) -> f64;

    /// f(x) by the chain rule, from f and df/dx at x.
    #[must_use]
    fn chain(&self, value: f64, slope: f64) -> Self;

    /// Square root of a number above 0.
    #[must_use]
    fn sqrt(&self) -> Self {
        let root = self.value().sqrt();
        self.chain(root, 0.5 / root)
    }

    /// Sine and cosine.
    #[must_use]
    fn sin_cos(&self) -> (Self, Self) {
        let (sin, cos) = self.value().sin_cos();
        (self.chain(sin, cos), self.chain(cos, -sin))
    }

    /// x^n where x > 0, and 0 below: the law of a contact that may part; n above 1.
    #[must_use]
    fn pressed(&self, exponent: f64) -> Self {
        let x = self.value();
        if x <= 0.0 {
            return Self::of(0.0);
        }
        let below = x.powf(exponent - 1.0);
        self.chain(below * x, exponent * below)
    }
}

impl Real for f64 {
    #[inline]
    fn of(value: f64) -> Self {
        value
    }

    #[inline]
    fn value(&self) -> f64 {
        *self
    }

    #[inline]
    fn chain(&self, value: f64, _: f64) -> Self {
        value
    }
}
