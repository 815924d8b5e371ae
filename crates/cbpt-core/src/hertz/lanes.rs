//! Many contacts at once, in the lanes of the processor's vector registers.
//!
//! The same exact solution as in the parent, with its derivatives. The semi-axes' ratio is a function of the curvatures'
//! ratio alone: a table of it gives a start good to 1e-7, from where one arithmetic-geometric mean and one Newton step,
//! which also takes the integrals along, reach rounding. Ratios near a circle and beyond the table go to
//! [`HertzContact::new`].

use std::f64::consts::PI;
use std::sync::LazyLock;

use pulp::{Arch, Simd, WithSimd};

use super::{HertzContact, curvature_mismatch, ellipticity};

/// Contacts in one go.
const BLOCK: usize = 64;
/// Ratios of curvatures for which the lanes are exact: nearer to a circle, differences of the integrals lose digits.
const LEAST_RATIO: f64 = 1.05;
const OCTAVES: u64 = 13;
const MOST_RATIO: f64 = (1_u64 << OCTAVES) as f64;
/// A piece of the table is 1/32 of an octave.
const PIECE_BITS: u32 = 5;
const FRACTION_BITS: u32 = 52 - PIECE_BITS;
/// Bits of 1.0 as a number of pieces.
const FIRST_PIECE: u64 = 1023 << PIECE_BITS;

impl HertzContact {
    /// [`HertzContact::new`] of each of many curvatures with one other, in their order.
    pub fn many(curvatures_per_m: &[f64], other_per_m: f64, contact_modulus_Pa: f64) -> Vec<Option<Self>> {
        let arch = Arch::new();
        let mut contacts = Vec::with_capacity(curvatures_per_m.len());
        for curvatures in curvatures_per_m.chunks(BLOCK) {
            let mut block = Block::new();
            for (place, &curvature) in curvatures.iter().enumerate() {
                block.set(place, curvature, other_per_m);
            }
            arch.dispatch(Shapes { block: &mut block, count: curvatures.len() });
            arch.dispatch(
                #[inline(always)]
                || block.scale(contact_modulus_Pa),
            );
            // Room for the cubes again; a modulus that is no number must not come out as a contact.
            let usable = contact_modulus_Pa > 1e-3 && contact_modulus_Pa < 1e20;
            contacts.extend(curvatures.iter().enumerate().map(|(place, &curvature)| {
                if usable && block.known[place] {
                    Some(block.contact(place))
                } else {
                    Self::new(curvature, other_per_m, contact_modulus_Pa)
                }
            }));
        }
        contacts
    }
}

/// x^(-1/3) of a number between 1e-90 and 1e90, by y <- y (1 + h/3 + 2 h^2/9 + 14 h^3/81), h = 1 - x y^3, whose error goes
/// with h^4. Made of what vector registers can do, so that loops over it run in lanes.
// A constant far inside the range of its type.
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
#[inline(always)]
pub(crate) fn inverse_cbrt(x: f64) -> f64 {
    // The upper half of a number's bits is nearly its logarithm, log2(x) + 1023 in units of 2^-20, with the bend of the
    // mantissa averaged out; a third of it is a product.
    const ONE: u64 = ((1023.0 - 0.045) * 4.0 / 3.0 * (1_u64 << 20) as f64) as u64;
    let third = ((x.to_bits() >> 32) * 0x5555_5556) >> 32;
    let mut y = f64::from_bits(ONE.wrapping_sub(third) << 32);
    for _ in 0..2 {
        let h = 1.0 - x * y * y * y;
        y += y * h * (1.0 / 3.0 + h * (2.0 / 9.0 + h * (14.0 / 81.0)));
    }
    y
}

/// Minor over major semi-axis against the ratio of the curvatures: cubics in the place inside each piece.
static SEMI_AXES: LazyLock<Vec<[f64; 4]>> = LazyLock::new(|| {
    let nodes: Vec<[f64; 3]> = (0..=OCTAVES << PIECE_BITS)
        .map(|piece| {
            let ratio = f64::from_bits((FIRST_PIECE + piece) << FRACTION_BITS);
            let kappa = ellipticity(ratio).0;
            let (_, ratio_per_log_kappa, ..) = curvature_mismatch(kappa.ln(), 0.0);
            [ratio, 1.0 / kappa, -1.0 / (kappa * ratio * ratio_per_log_kappa)]
        })
        .collect();
    let cubic = |ends: &[[f64; 3]]| {
        let ([r0, x0, s0], [r1, x1, s1]) = (ends[0], ends[1]);
        let (s0, s1, rise) = (s0 * (r1 - r0), s1 * (r1 - r0), x1 - x0);
        [x0, s0, 3.0 * rise - 2.0 * s0 - s1, s0 + s1 - 2.0 * rise]
    };
    nodes.windows(2).map(cubic).collect()
});

/// Contacts in lanes.
struct Block {
    known: [bool; BLOCK],
    ratio: [f64; BLOCK],
    sum_per_m: [f64; BLOCK],
    /// b/a in, as a start; a/b out.
    shape: [f64; BLOCK],
    k: [f64; BLOCK],
    e: [f64; BLOCK],
    stiffness: [f64; BLOCK],
    compliance: [f64; BLOCK],
    major_semi_axis_at_1N_m: [f64; BLOCK],
}

impl Block {
    fn new() -> Self {
        let ones = [1.0; BLOCK];
        Self {
            known: [false; BLOCK],
            ratio: [2.0; BLOCK],
            sum_per_m: ones,
            shape: [0.5; BLOCK],
            k: ones,
            e: ones,
            stiffness: ones,
            compliance: ones,
            major_semi_axis_at_1N_m: ones,
        }
    }

    // The piece lies in the table because the ratio does, and 2^47 is a number.
    #[allow(clippy::cast_possible_truncation)]
    fn set(&mut self, place: usize, a_per_m: f64, b_per_m: f64) {
        let ratio = if a_per_m > b_per_m { a_per_m / b_per_m } else { b_per_m / a_per_m };
        // Curvatures of that size leave room for the cubes; anything else, no number among it, is not known here.
        let ordinary = |curvature: f64| curvature > 1e-9 && curvature < 1e12;
        if !(ordinary(a_per_m) && ordinary(b_per_m) && ratio > LEAST_RATIO && ratio < MOST_RATIO) {
            return;
        }
        let bits = ratio.to_bits();
        let piece = ((bits >> FRACTION_BITS) - FIRST_PIECE) as usize;
        let scale = 1.0 / (1_u64 << FRACTION_BITS) as f64;
        let s = (bits & ((1 << FRACTION_BITS) - 1)) as f64 * scale;
        let c = &SEMI_AXES[piece];
        self.known[place] = true;
        self.ratio[place] = ratio;
        self.sum_per_m[place] = a_per_m + b_per_m;
        self.shape[place] = c[0] + s * (c[1] + s * (c[2] + s * c[3]));
    }

    /// From shapes to contacts: with z = (2 pi/3 E* kappa)^2 2 E/(c1 + c2), k^(-2/3) = K z^(-1/3).
    #[inline(always)]
    fn scale(&mut self, contact_modulus_Pa: f64) {
        let factor = 2.0 * PI / 3.0 * contact_modulus_Pa;
        for i in 0..BLOCK {
            let (kappa, e) = (self.shape[i], self.e[i]);
            let both = factor * kappa;
            let compliance = self.k[i] * inverse_cbrt(both * both * 2.0 * e / self.sum_per_m[i]);
            let cubed = 3.0 * kappa * kappa * e / (PI * contact_modulus_Pa * self.sum_per_m[i]);
            let inverse = inverse_cbrt(cubed);
            self.compliance[i] = compliance;
            self.stiffness[i] = 1.0 / (compliance * compliance.sqrt());
            self.major_semi_axis_at_1N_m[i] = cubed * inverse * inverse;
        }
    }

    fn contact(&self, place: usize) -> HertzContact {
        HertzContact {
            stiffness: self.stiffness[place],
            compliance: self.compliance[place],
            ellipticity: self.shape[place],
            major_semi_axis_at_1N_m: self.major_semi_axis_at_1N_m[place],
        }
    }
}

/// Finds the shapes of the first `count` contacts of a block.
struct Shapes<'a> {
    block: &'a mut Block,
    count: usize,
}

impl WithSimd for Shapes<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let ratios = S::as_simd_f64s(&self.block.ratio).0;
        let shapes = S::as_mut_simd_f64s(&mut self.block.shape).0;
        let ks = S::as_mut_simd_f64s(&mut self.block.k).0;
        let es = S::as_mut_simd_f64s(&mut self.block.e).0;
        for v in 0..self.count.div_ceil(S::F64_LANES) {
            (shapes[v], ks[v], es[v]) = shape(simd, ratios[v], shapes[v]);
        }
    }
}

/// a/b, K and E from a ratio of curvatures and a start for b/a.
///
/// b/a is sqrt(1 - m), where the arithmetic-geometric mean starts. Newton is on ln kappa as in the parent; dK/dln kappa = B/m
/// and dE/dln kappa = -(1 - m) D/m with B = E - (1 - m) K, D = K - E.
#[inline(always)]
fn shape<S: Simd>(simd: S, ratio: S::f64s, start: S::f64s) -> (S::f64s, S::f64s, S::f64s) {
    let number = |value: f64| simd.splat_f64s(value);
    let (mul, add, sub, div) = (
        |a, b| simd.mul_f64s(a, b),
        |a, b| simd.add_f64s(a, b),
        |a, b| simd.sub_f64s(a, b),
        |a, b| simd.div_f64s(a, b),
    );
    let (one, half) = (number(1.0), number(0.5));
    let complement = mul(start, start);
    let m = sub(one, complement);
    let (mut a, mut g) = (one, start);
    let mut sum = number(0.0);
    let mut weight = one;
    for _ in 0..8 {
        let c = mul(half, sub(a, g));
        let root = simd.sqrt_f64s(mul(a, g));
        (a, g) = (mul(half, add(a, g)), root);
        sum = simd.mul_add_e_f64s(mul(weight, c), c, sum);
        weight = add(weight, weight);
        // The next c is c^2/(4 a), and its square counts.
        if simd.reduce_max_f64s(c) < 1e-6 {
            break;
        }
    }
    let a = mul(half, add(a, g));
    let k = div(number(PI / 2.0), a);
    let half_m = mul(half, m);
    let missing = add(half_m, sum);
    let e = mul(k, sub(one, missing));
    let (b, d) = (mul(k, sub(half_m, sum)), mul(k, missing));

    let found = div(b, mul(complement, d));
    let off = sub(div(found, ratio), one);
    let slope = add(number(2.0), sub(div(mul(complement, k), b), div(e, d)));
    let log = mul(off, simd.negate_mul_add_e_f64s(half, off, one));
    let step = div(log, slope);
    let per_m = div(step, m);
    let kappa = mul(div(one, start), sub(one, mul(step, simd.negate_mul_add_e_f64s(half, step, one))));
    (kappa, simd.negate_mul_add_e_f64s(b, per_m, k), simd.mul_add_e_f64s(mul(complement, d), per_m, e))
}
