//! N_Z^(2/3) of many preloads: how a Hertz contact's approach grows with its load.

use pulp::Arch;

/// x^(2/3) of each preload into `powers`, to rounding; preloads are above 0.
pub fn two_thirds_powers(preload_N: &[f64], powers: &mut [f64]) {
    Arch::new().dispatch(
        #[inline(always)]
        || {
            for (power, &x) in powers.iter_mut().zip(preload_N) {
                *power = two_thirds_power(x);
            }
        },
    );
    // Cubes beyond the range of numbers: rare enough to be repaired afterwards.
    for (power, &x) in powers.iter_mut().zip(preload_N) {
        if !(1e-90..1e90).contains(&x) {
            *power = x.cbrt().powi(2);
        }
    }
}

/// x y with y = x^(-1/3), by y <- y (1 + h/3 + 2 h^2/9 + 14 h^3/81), h = 1 - x y^3, whose error goes with h^4.
// A constant far inside the range of its type.
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
#[inline(always)]
fn two_thirds_power(x: f64) -> f64 {
    // The bits of a number are nearly its logarithm: log2(x) + 1023 in units of 2^-52, the mantissa's bend averaged out.
    const UNIT: f64 = (1_u64 << 52) as f64;
    const ONE: u64 = ((1023.0 - 0.045) * 4.0 / 3.0 * UNIT) as u64;
    let mut y = f64::from_bits(ONE.wrapping_sub(x.to_bits() / 3));
    for _ in 0..2 {
        let h = 1.0 - x * y * y * y;
        y += y * h * (1.0 / 3.0 + h * (2.0 / 9.0 + h * (14.0 / 81.0)));
    }
    x * y
}
