//! Many contacts at once.
//!
//! But for the scale, a contact is a function of the ratio r of its curvatures alone: kappa, and the compliance
//! k^(-2/3) = ((2 pi/3) E*)^(-2/3) ((c1 + c2)/2)^(1/3) K / (kappa^2 E)^(1/3).
//!
//! Both functions of r are interpolated from the parent's exact solution by polynomials, so fine that nothing beyond
//! rounding is lost: a piece spans an eighth of an octave, and the nearest singularity (r = 0) lies 17 half pieces away, so
//! that coefficients fall by 34 from one degree to the next. Ratios beyond the table go to [`HertzContact::new`].

use std::f64::consts::PI;
use std::sync::LazyLock;

use pulp::{Arch, Simd, WithSimd};

use super::{HertzContact, ellipticity};

/// Contacts in one go.
const BLOCK: usize = 16;
/// Ratios of curvatures in the table: 1 to 2^13.
const OCTAVES: u64 = 13;
/// A piece of the table is 1/8 of an octave.
const PIECE_BITS: u32 = 3;
/// Bits of 1.0 as a number of pieces.
const FIRST_PIECE: u64 = 1023 << PIECE_BITS;
const DEGREE: usize = 9;
/// Functions in the table: the compliance but for its scale, and the ratio of the semi-axes.
const PARTS: usize = 2;

/// Both functions at nodes, or the coefficients of their polynomials.
type Values = [[f64; PARTS]; DEGREE + 1];
/// Coefficients for powers of the square of the place in a piece, which runs from -1 to 1: for each function those of the even
/// and of the odd powers. Four short sums side by side are quicker than two long ones.
type Piece = [[f64; 2 * PARTS]; DEGREE.div_ceil(2)];

static TABLE: LazyLock<Vec<Piece>> = LazyLock::new(|| {
    (0..OCTAVES << PIECE_BITS).map(|number| by_parity(&polynomials(&exact_in(number)))).collect()
});

impl HertzContact {
    /// [`HertzContact::new`] of each of many curvatures with one other, in their order.
    pub fn many(curvatures_per_m: &[f64], other_per_m: f64, contact_modulus_Pa: f64) -> Vec<Option<Self>> {
        // Room for the cubes; what is no number must not come out as a contact.
        let ordinary = other_per_m > 1e-9 && other_per_m < 1e12;
        if ordinary && contact_modulus_Pa > 1e-3 && contact_modulus_Pa < 1e20 {
            let (table, mut contacts) = (TABLE.as_slice(), vec![None; curvatures_per_m.len()]);
            Arch::new().dispatch(FromTable {
                table,
                curvatures_per_m,
                other_per_m,
                contact_modulus_Pa,
                contacts: &mut contacts,
            });
            contacts
        } else {
            let alone = |&curvature: &f64| Self::new(curvature, other_per_m, contact_modulus_Pa);
            curvatures_per_m.iter().map(alone).collect()
        }
    }
}

/// Writes the contacts, from the table where it knows them.
struct FromTable<'a> {
    table: &'a [Piece],
    curvatures_per_m: &'a [f64],
    /// Above 0, neither tiny nor huge.
    other_per_m: f64,
    contact_modulus_Pa: f64,
    contacts: &'a mut [Option<HertzContact>],
}

impl WithSimd for FromTable<'_> {
    type Output = ();

    // Plain loops: closures of iterators would not be inlined into the function that knows the instruction set.
    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { table, curvatures_per_m, other_per_m, contact_modulus_Pa, contacts } = self;
        let scale = (4.0 * PI / 3.0 * contact_modulus_Pa / 2.0_f64.sqrt()).cbrt().powi(-2);
        for (curvatures, contacts) in curvatures_per_m.chunks(BLOCK).zip(contacts.chunks_mut(BLOCK)) {
            // Whole blocks, so that the loop runs in lanes.
            let mut block = [other_per_m; BLOCK];
            block[..curvatures.len()].copy_from_slice(curvatures);
            let (mut sums, mut scales, mut ratios) = ([1.0; BLOCK], [1.0; BLOCK], [1.0; BLOCK]);
            for i in 0..BLOCK {
                let curvature = block[i];
                let ordered = curvature > other_per_m;
                let (strong, weak) =
                    if ordered { (curvature, other_per_m) } else { (other_per_m, curvature) };
                sums[i] = curvature + other_per_m;
                ratios[i] = strong / weak;
                let root = inverse_cbrt(sums[i]);
                // s^(1/3) = s (s^(-1/3))^2
                scales[i] = scale * sums[i] * root * root;
            }
            for (i, contact) in contacts.iter_mut().enumerate() {
                // The ratio to an ordinary curvature is in the table only where its other side is one.
                let (number, at) = place(ratios[i]);
                *contact = if let Some(piece) = table.get(number) {
                    let [compliance, ellipticity] = interpolated(piece, at);
                    Some(HertzContact {
                        compliance: scales[i] * compliance,
                        ellipticity,
                        curvature_sum_per_m: sums[i],
                        contact_modulus_Pa,
                    })
                } else {
                    HertzContact::new(block[i], other_per_m, contact_modulus_Pa)
                };
            }
        }
    }
}

/// Piece of the table in which a ratio of 1 or more lies, and its place there, from -1 to 1.
// The number of a piece is small.
#[allow(clippy::cast_possible_truncation)]
#[inline(always)]
fn place(ratio: f64) -> (usize, f64) {
    const FRACTION: u64 = (1 << 52) - 1;
    let bits = ratio.to_bits();
    // What follows the bits of the piece, as the fraction of a number from 1 to 2.
    let from_1_to_2 = f64::from_bits(((bits << PIECE_BITS) & FRACTION) | 1.0_f64.to_bits());
    ((bits >> (52 - PIECE_BITS)).wrapping_sub(FIRST_PIECE) as usize, 2.0 * from_1_to_2 - 3.0)
}

#[inline(always)]
fn interpolated(piece: &Piece, at: f64) -> [f64; PARTS] {
    let square = at * at;
    let mut sums = piece[piece.len() - 1];
    for row in (0..piece.len() - 1).rev() {
        for i in 0..2 * PARTS {
            sums[i] = sums[i] * square + piece[row][i];
        }
    }
    [sums[0] + at * sums[1], sums[2] + at * sums[3]]
}

fn by_parity(coefficients: &Values) -> Piece {
    std::array::from_fn(|row| std::array::from_fn(|i| coefficients[2 * row + i % 2][i / 2]))
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

/// The parts at the roots of the Chebyshev polynomial of degree `DEGREE` + 1 in a piece.
fn exact_in(piece: u64) -> Values {
    let end = |number: u64| f64::from_bits((FIRST_PIECE + number) << (52 - PIECE_BITS));
    let (first, last) = (end(piece), end(piece + 1));
    std::array::from_fn(|node| {
        let ratio = 0.5 * (first + last) + 0.5 * (last - first) * node_angle(node).cos();
        let (kappa, k, e) = ellipticity(ratio);
        [k / (kappa * kappa * e).cbrt(), kappa]
    })
}

fn node_angle(node: usize) -> f64 {
    PI * (node as f64 + 0.5) / (DEGREE + 1) as f64
}

/// The polynomials through values at the Chebyshev roots: first as a sum of Chebyshev polynomials, then of powers.
fn polynomials(values: &Values) -> Values {
    let mut powers = [[0.0; PARTS]; DEGREE + 1];
    // Coefficients of T_(n-1) and T_n.
    let mut before = [0.0; DEGREE + 1];
    let mut chebyshev = [0.0; DEGREE + 1];
    chebyshev[0] = 1.0;
    for degree in 0..=DEGREE {
        let share = if degree == 0 { 1.0 } else { 2.0 } / (DEGREE + 1) as f64;
        for part in 0..PARTS {
            let amount: f64 = (0..=DEGREE)
                .map(|node| share * values[node][part] * (degree as f64 * node_angle(node)).cos())
                .sum();
            for (power, coefficient) in powers.iter_mut().zip(chebyshev) {
                power[part] += amount * coefficient;
            }
        }
        // T_(n+1) = 2 x T_n - T_(n-1), but T_1 = x.
        let factor = if degree == 0 { 1.0 } else { 2.0 };
        let next = std::array::from_fn(|i| if i == 0 { 0.0 } else { factor * chebyshev[i - 1] } - before[i]);
        before = chebyshev;
        chebyshev = next;
    }
    powers
}
