//! N_Z^(2/3) of many preloads: how a Hertz contact's approach grows with its load.

use pulp::{Arch, Simd, WithSimd};

use crate::hertz::lanes::inverse_cbrt;

/// x^(2/3) of each preload into `powers`, to rounding; preloads are above 0.
pub fn two_thirds_powers(preload_N: &[f64], powers: &mut [f64]) {
    Arch::new().dispatch(Powers { preload_N, powers });
    // Cubes beyond the range of numbers: rare enough to be repaired afterwards.
    for (power, &x) in powers.iter_mut().zip(preload_N) {
        if !(1e-90..1e90).contains(&x) {
            *power = x.cbrt().powi(2);
        }
    }
}

/// The same of one preload.
pub fn two_thirds_power(preload_N: f64) -> f64 {
    let mut power = [0.0];
    two_thirds_powers(&[preload_N], &mut power);
    power[0]
}

struct Powers<'a> {
    preload_N: &'a [f64],
    powers: &'a mut [f64],
}

impl WithSimd for Powers<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        for (power, &x) in self.powers.iter_mut().zip(self.preload_N) {
            *power = x * inverse_cbrt(x);
        }
    }
}
