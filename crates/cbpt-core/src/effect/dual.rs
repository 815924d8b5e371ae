//! Forward dual numbers: a value with its partial derivatives by up to [`WIDTH`] parameters at a time.
//!
//! Every operation is exact (Wengert 1964); what the operations mean is ordinary arithmetic on the value.

use std::ops::{Add, AddAssign, Div, Mul, MulAssign, Neg, Sub};

use crate::real::Real;

/// Parameters whose derivatives are carried along together.
pub const WIDTH: usize = 16;

/// A value and its partial derivatives.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Dual {
    /// The value.
    pub value: f64,
    /// Its derivative by each parameter of the block.
    pub partials: [f64; WIDTH],
}

impl Dual {
    /// A number that depends on no parameter.
    pub const fn constant(value: f64) -> Self {
        Self { value, partials: [0.0; WIDTH] }
    }

    /// The parameter number `slot` of the block itself.
    pub fn parameter(value: f64, slot: usize) -> Self {
        let mut this = Self::constant(value);
        this.partials[slot] = 1.0;
        this
    }

    /// f(x) by the chain rule, from f and df/dx at x.
    #[must_use]
    pub fn chain(&self, value: f64, slope: f64) -> Self {
        Self { value, partials: self.partials.map(|partial| slope * partial) }
    }

    /// Adds `slope` times what `of` depends on: one term of a total derivative; the value stays.
    pub fn add_slope(&mut self, slope: f64, of: &Self) {
        for (mine, theirs) in self.partials.iter_mut().zip(&of.partials) {
            *mine += slope * theirs;
        }
    }

    /// 1/x.
    #[must_use]
    pub fn recip(&self) -> Self {
        let inverse = 1.0 / self.value;
        self.chain(inverse, -inverse * inverse)
    }

    /// ln(1 + x).
    #[must_use]
    pub fn ln_1p(&self) -> Self {
        self.chain(self.value.ln_1p(), 1.0 / (1.0 + self.value))
    }

    /// |x|; at 0 that of a positive number.
    #[must_use]
    pub fn abs(&self) -> Self {
        if self.value < 0.0 { -*self } else { *self }
    }

    /// x^q for x >= 0 and q > 0; at x = 0 it stays 0 whatever the parameters do.
    #[must_use]
    pub fn powf(&self, exponent: &Self) -> Self {
        if self.value <= 0.0 {
            return Self::constant(0.0);
        }
        let value = self.value.powf(exponent.value);
        let mut power = self.chain(value, exponent.value * value / self.value);
        power.add_slope(value * self.value.ln(), exponent);
        power
    }
}

impl Add for Dual {
    type Output = Self;
    fn add(mut self, other: Self) -> Self {
        self += other;
        self
    }
}

impl AddAssign for Dual {
    fn add_assign(&mut self, other: Self) {
        self.value += other.value;
        self.add_slope(1.0, &other);
    }
}

impl Add<f64> for Dual {
    type Output = Self;
    fn add(mut self, other: f64) -> Self {
        self.value += other;
        self
    }
}

impl Sub for Dual {
    type Output = Self;
    fn sub(mut self, other: Self) -> Self {
        self.value -= other.value;
        self.add_slope(-1.0, &other);
        self
    }
}

impl Neg for Dual {
    type Output = Self;
    fn neg(self) -> Self {
        self.chain(-self.value, -1.0)
    }
}

impl Mul for Dual {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        let mut product = self.chain(self.value * other.value, other.value);
        product.add_slope(self.value, &other);
        product
    }
}

impl MulAssign for Dual {
    fn mul_assign(&mut self, other: Self) {
        *self = *self * other;
    }
}

impl Mul<f64> for Dual {
    type Output = Self;
    fn mul(self, other: f64) -> Self {
        self.chain(self.value * other, other)
    }
}

impl Div for Dual {
    type Output = Self;
    #[allow(clippy::suspicious_arithmetic_impl)] // a quotient is a product with the reciprocal
    fn div(self, other: Self) -> Self {
        self * other.recip()
    }
}

impl Real for Dual {
    fn of(value: f64) -> Self {
        Self::constant(value)
    }

    fn value(&self) -> f64 {
        self.value
    }

    fn chain(&self, value: f64, slope: f64) -> Self {
        Self::chain(self, value, slope)
    }
}
