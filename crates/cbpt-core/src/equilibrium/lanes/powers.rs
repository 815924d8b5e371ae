//! N_Z^(2/3) of many preloads: how a Hertz contact's approach grows with its load.

use pulp::Arch;

use crate::hertz::lanes::inverse_cbrt;

/// x^(2/3) of each preload into `powers`, to rounding; preloads are above 0.
pub fn two_thirds_powers(preload_N: &[f64], powers: &mut [f64]) {
    Arch::new().dispatch(
        #[inline(always)]
        || {
            for (power, &x) in powers.iter_mut().zip(preload_N) {
                *power = x * inverse_cbrt(x);
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
