//! Intervals of real numbers with outward rounding: what a formula gives lies between its bounds for certain.
//!
//! IEEE 754 rounds +, -, x and the square root to the nearest number, so the exact result lies between the neighbours of the
//! rounded one; a bound is that neighbour. That holds on every machine without touching its rounding mode. (inari, the kept
//! crate, sets the rounding mode instead and compiles only with `-C target-cpu=haswell`, which the wheels could then not
//! run without.) What overflows or is not a number becomes [`Interval::ENTIRE`], of which nothing is proved.

use std::ops::{Add, Mul, Neg, Sub};

/// All numbers from `lower` to `upper`, both included.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Interval {
    lower: f64,
    upper: f64,
}

impl Interval {
    /// Every number.
    pub const ENTIRE: Self = Self { lower: f64::NEG_INFINITY, upper: f64::INFINITY };
    /// 0 alone.
    pub const ZERO: Self = Self { lower: 0.0, upper: 0.0 };

    /// From bound to bound; [`Self::ENTIRE`] where they are not two finite numbers in order.
    pub fn new(lower: f64, upper: f64) -> Self {
        if lower.is_finite() && upper.is_finite() && lower <= upper {
            Self { lower, upper }
        } else {
            Self::ENTIRE
        }
    }

    /// One step outwards from bounds that were rounded to the nearest number.
    fn rounded(lower: f64, upper: f64) -> Self {
        Self::new(lower.next_down(), upper.next_up())
    }

    /// The lower bound.
    pub fn lower(self) -> f64 {
        self.lower
    }

    /// The upper bound.
    pub fn upper(self) -> f64 {
        self.upper
    }

    /// A number between the bounds, about halfway.
    pub fn middle(self) -> f64 {
        self.lower + 0.5 * (self.upper - self.lower)
    }

    /// Upper minus lower bound, never too small.
    pub fn width(self) -> f64 {
        (self.upper - self.lower).next_up()
    }

    /// The largest size of its numbers.
    pub fn magnitude(self) -> f64 {
        self.lower.abs().max(self.upper.abs())
    }

    /// Whether both bounds are numbers.
    pub fn is_finite(self) -> bool {
        self.lower.is_finite() && self.upper.is_finite()
    }

    /// Whether a number lies within.
    pub fn contains(self, value: f64) -> bool {
        self.lower <= value && value <= self.upper
    }

    /// Whether it lies within `other` and touches no bound of it.
    pub fn is_inside(self, other: Self) -> bool {
        other.lower < self.lower && self.upper < other.upper
    }

    /// What both have in common; `None` where that is nothing.
    pub fn common(self, other: Self) -> Option<Self> {
        let (lower, upper) = (self.lower.max(other.lower), self.upper.min(other.upper));
        (lower <= upper).then_some(Self { lower, upper })
    }

    /// Its numbers and 0, and all between.
    #[must_use]
    pub fn with_0(self) -> Self {
        Self { lower: self.lower.min(0.0), upper: self.upper.max(0.0) }
    }

    /// Of its numbers what is not below 0, and 0 for those that are.
    #[must_use]
    pub fn at_least_0(self) -> Self {
        Self { lower: self.lower.max(0.0), upper: self.upper.max(0.0) }
    }

    /// Times a factor that is itself rounded to the nearest number, such as seconds of arc per radian.
    #[must_use]
    pub fn times_rounded(self, factor: f64) -> Self {
        self * Self::rounded(factor, factor)
    }

    /// The square root, of numbers from 0 on.
    #[must_use]
    pub fn sqrt(self) -> Self {
        let within = Self::rounded(self.lower.sqrt(), self.upper.sqrt());
        if within.is_finite() { within.at_least_0() } else { within }
    }

    /// A power of a number from 0 on.
    ///
    /// No standard rounds powers; the bounds hold where the platform's are within 4 units in the last place. (Those of glibc,
    /// musl, macOS and Windows are within 1.)
    pub fn power(base: f64, exponent: f64) -> Self {
        Self::from(base.powf(exponent)) * Self::new(1.0 - 4.0 * f64::EPSILON, 1.0 + 4.0 * f64::EPSILON)
    }

    /// A power with an exponent above 0, of numbers from 0 on.
    #[must_use]
    pub fn powf(self, exponent: f64) -> Self {
        let (least, most) = (Self::power(self.lower, exponent), Self::power(self.upper, exponent));
        let within = Self::new(least.lower, most.upper);
        if within.is_finite() { within.at_least_0() } else { within }
    }
}

impl From<f64> for Interval {
    fn from(value: f64) -> Self {
        Self::new(value, value)
    }
}

impl Neg for Interval {
    type Output = Self;

    fn neg(self) -> Self {
        Self { lower: -self.upper, upper: -self.lower }
    }
}

impl Add for Interval {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self::rounded(self.lower + other.lower, self.upper + other.upper)
    }
}

impl Sub for Interval {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

impl Mul for Interval {
    type Output = Self;

    fn mul(self, other: Self) -> Self {
        // 0 x infinity is not a number, which `min` and `max` pass over.
        if !(self.is_finite() && other.is_finite()) {
            return Self::ENTIRE;
        }
        let products = [
            self.lower * other.lower,
            self.lower * other.upper,
            self.upper * other.lower,
            self.upper * other.upper,
        ];
        let [a, b, c, d] = products;
        Self::rounded(a.min(b).min(c.min(d)), a.max(b).max(c.max(d)))
    }
}

impl std::iter::Sum for Interval {
    fn sum<I: Iterator<Item = Self>>(terms: I) -> Self {
        terms.fold(Self::ZERO, |sum, term| sum + term)
    }
}
