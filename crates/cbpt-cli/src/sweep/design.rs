//! Where the rows of a sweep lie: each coordinate is a function of (seed, axis, row) alone, so any part of a sweep can be
//! made anywhere, in any order, and takes no memory for the rest.

/// How rows are laid over the axes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Design {
    /// Every value of every axis with every other.
    Grid,
    /// Independent and uniform on every axis.
    Random,
    /// As random, but each of as many equal parts of every axis as there are rows holds one of them (McKay, Beckman and
    /// Conover 1979, DOI 10.1080/00401706.1979.10489755).
    LatinHypercube,
    /// The rows of a table.
    Table,
}

impl Design {
    /// All of them with their names in plans.
    pub const ALL: [(&'static str, Self); 4] = [
        ("grid", Self::Grid),
        ("random", Self::Random),
        ("latin_hypercube", Self::LatinHypercube),
        ("table", Self::Table),
    ];

    /// Its name in plans.
    pub fn name(self) -> &'static str {
        Self::ALL.iter().find(|(_, design)| *design == self).map_or("", |(name, _)| name)
    }

    /// Whether rows are drawn by chance.
    pub fn is_drawn(self) -> bool {
        matches!(self, Self::Random | Self::LatinHypercube)
    }
}

/// Chance for one axis of a sweep.
#[derive(Debug, Clone, Copy)]
pub struct Draws {
    seed: u64,
    order: Permutation,
    rows: u64,
}

impl Draws {
    /// For one axis of a sweep of so many rows.
    pub fn new(seed: u64, axis: u64, rows: u64) -> Self {
        let own = split_mix(split_mix(seed, 0), axis);
        Self { seed: split_mix(own, 0), order: Permutation::new(split_mix(own, 1), rows), rows }
    }

    /// Uniform in [0, 1).
    pub fn random(&self, row: u64) -> f64 {
        // The upper 53 bits, as many as a number has.
        (split_mix(self.seed, row) >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Uniform within a part of [0, 1) of its own, one of as many as there are rows.
    pub fn latin_hypercube(&self, row: u64) -> f64 {
        let within = (self.order.of(row) as f64 + self.random(row)) / self.rows as f64;
        within.min(1.0 - f64::EPSILON / 2.0)
    }
}

/// The number at one place of the sequence that SplitMix64 makes of a seed (Steele, Lea and Flood 2014, DOI
/// 10.1145/2660193.2660195): its state only counts, so any place is reached at once.
fn split_mix(seed: u64, place: u64) -> u64 {
    const GOLDEN: u64 = 0x9E37_79B9_7F4A_7C15;
    let state = seed.wrapping_add(GOLDEN.wrapping_mul(place.wrapping_add(1)));
    let mixed = (state ^ (state >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    let mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    mixed ^ (mixed >> 31)
}

/// A permutation of 0..count that depends on a key and takes no memory: a Feistel network on the least even number of bits
/// that holds the count, walked on from numbers beyond it (Black and Rogaway 2002, DOI 10.1007/3-540-45760-7_9).
#[derive(Debug, Clone, Copy)]
struct Permutation {
    key: u64,
    count: u64,
    half_bits: u32,
}

/// Four make it as good as random; two more cost little.
const ROUNDS: u64 = 6;

impl Permutation {
    fn new(key: u64, count: u64) -> Self {
        let bits = u64::BITS - count.saturating_sub(1).leading_zeros();
        Self { key, count, half_bits: bits.div_ceil(2).max(1) }
    }

    /// Where a number below the count goes.
    fn of(&self, number: u64) -> u64 {
        let mask = (1_u64 << self.half_bits) - 1;
        let mut number = number;
        loop {
            let (mut left, mut right) = (number >> self.half_bits, number & mask);
            for round in 0..ROUNDS {
                (left, right) = (right, left ^ (split_mix(split_mix(self.key, round), right) & mask));
            }
            number = (left << self.half_bits) | right;
            if number < self.count {
                return number;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn the_sequence_is_that_of_split_mix() {
        // The first numbers from the seed 1234567, as other implementations print them.
        let first = [6_457_827_717_110_365_317, 3_203_168_211_198_807_973, 9_817_491_932_198_370_423];
        assert_eq!([0, 1, 2].map(|place| split_mix(1_234_567, place)), first);
    }

    proptest! {
        #[test]
        fn a_permutation_meets_every_number_once(key: u64, count in 1_u64..3000) {
            let permutation = Permutation::new(key, count);
            let mut met: Vec<u64> = (0..count).map(|number| permutation.of(number)).collect();
            met.sort_unstable();
            prop_assert!(met.into_iter().eq(0..count));
        }

        #[test]
        fn each_part_of_an_axis_holds_one_row(seed: u64, axis in 0_u64..9, rows in 1_u64..2000) {
            let draws = Draws::new(seed, axis, rows);
            let mut parts: Vec<u64> = (0..rows)
                .map(|row| {
                    let place = draws.latin_hypercube(row) * rows as f64;
                    assert!((0.0..rows as f64).contains(&place));
                    // Not negative, below the number of rows.
                    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
                    let part = place as u64;
                    part
                })
                .collect();
            parts.sort_unstable();
            parts.dedup();
            prop_assert!(parts.into_iter().eq(0..rows));
        }

        #[test]
        fn axes_are_not_alike(seed: u64) {
            let rows = 4000;
            let [one, other] = [0, 1].map(|axis| Draws::new(seed, axis, rows));
            for draw in [Draws::random, Draws::latin_hypercube] {
                let product: f64 =
                    (0..rows).map(|row| (draw(&one, row) - 0.5) * (draw(&other, row) - 0.5)).sum();
                // The correlation of independent draws has the standard deviation 1/sqrt(rows).
                prop_assert!((12.0 * product / rows as f64).abs() < 6.0 / (rows as f64).sqrt());
            }
        }
    }

    #[test]
    fn draws_are_uniform() {
        let rows = 100_000_u64;
        let draws = Draws::new(7, 0, rows);
        let mut counts = [0_u32; 10];
        for row in 0..rows {
            // Between 0 and 9.
            #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
            let tenth = (draws.random(row) * 10.0) as usize;
            counts[tenth] += 1;
        }
        let chi2: f64 = counts.iter().map(|&count| (f64::from(count) - 1e4).powi(2) / 1e4).sum();
        // 27.9 is exceeded once in a thousand; the seed is fixed.
        assert!(chi2 < 27.9, "{counts:?}");
    }
}
