//! Forward dual numbers: a value with its partial derivatives by up to [`WIDTH`] parameters at a time.
//!
//! Every operation is exact (Wengert 1964); what the operations mean is ordinary arithmetic on the value.

use std::ops::{Add, AddAssign, Div, Mul, MulAssign, Neg, Sub};

use crate::real::Real;

/// Parameters whose derivatives are carried along together. With its value a number takes 120 bytes: copies of more than 128
/// are calls, where no wider registers can be taken for granted.
pub const WIDTH: usize = 14;

/// A value and its partial derivatives.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Dual {
    /// The value.
    pub value: f64,
    /// Its derivative by each parameter of the block.
    pub partials: [f64; WIDTH],
}

/// The values of an effect's numbers.
pub fn values<const N: usize>(own: &[Dual; N]) -> [f64; N] {
    own.map(|number| number.value)
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

    /// Whether it depends on any of the parameters.
    pub fn depends(&self) -> bool {
        self.partials.iter().any(|partial| *partial != 0.0)
    }

    /// f(x) by the chain rule, from f and df/dx at x.
    #[must_use]
    #[inline]
    pub fn chain(&self, value: f64, slope: f64) -> Self {
        Self { value, partials: self.partials.map(|partial| slope * partial) }
    }

    /// f(x) by the chain rule where df/dx may not be finite: what x does not depend on stays without a slope.
    #[must_use]
    pub fn chain_where_any(&self, value: f64, slope: f64) -> Self {
        let by = |partial: f64| if partial == 0.0 { 0.0 } else { slope * partial };
        Self { value, partials: self.partials.map(by) }
    }

    /// x/y rounded once, at any y: what does not depend on a parameter has no slope, even where y is 0.
    #[must_use]
    pub fn quotient(&self, divisor: &Self) -> Self {
        let mut quotient = self.chain_where_any(self.value / divisor.value, 1.0 / divisor.value);
        let slope = -self.value / (divisor.value * divisor.value);
        quotient.add_slope(1.0, &divisor.chain_where_any(0.0, slope));
        quotient
    }

    /// x^q at any x and q: d = q x^(q-1) dx + ln(x) x^q dq, each term only where something depends on it.
    #[must_use]
    pub fn power(&self, exponent: &Self) -> Self {
        let (x, q) = (self.value, exponent.value);
        let value = x.powf(q);
        // 0^q stays 0 whatever q > 0 is.
        let by_exponent = if x == 0.0 && q > 0.0 { 0.0 } else { value * x.ln() };
        let mut power = self.chain_where_any(value, q * x.powf(q - 1.0));
        power.add_slope(1.0, &exponent.chain_where_any(0.0, by_exponent));
        power
    }

    /// 1 - exp(-x/self): how far what settles over this scale has come after x.
    #[must_use]
    pub fn settled(&self, x: f64) -> Self {
        let share = x / self.value;
        self.chain(-(-share).exp_m1(), -share * (-share).exp() / self.value)
    }

    /// Adds `slope` times what `of` depends on: one term of a total derivative; the value stays.
    #[inline]
    pub fn add_slope(&mut self, slope: f64, of: &Self) {
        for (mine, theirs) in self.partials.iter_mut().zip(&of.partials) {
            *mine += slope * theirs;
        }
    }

    /// Adds `factor` times `one` times `other`.
    #[inline]
    pub fn add_product(&mut self, factor: f64, one: &Self, other: &Self) {
        self.value += factor * one.value * other.value;
        self.add_slope(factor * other.value, one);
        self.add_slope(factor * one.value, other);
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

    /// x^q for x > 0 and q > 0, and 0 for any other x, whatever the parameters do.
    #[must_use]
    pub fn powf(&self, exponent: &Self) -> Self {
        if self.value > 0.0 { self.power(exponent) } else { Self::constant(0.0) }
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
