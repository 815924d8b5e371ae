//! Maximum of a periodic function that is smooth but for kinks: a scan of one period, then golden section.

/// Samples of a period's scan; the quantities here have one or two maxima a period.
const SAMPLES: usize = 96;

/// Place and value of the largest value of `f` over `period`, starting at 0.
///
/// `f` may be infinite (nothing holds there), which is then the maximum.
pub(crate) fn maximum(period: f64, mut f: impl FnMut(f64) -> f64) -> (f64, f64) {
    let step = period / SAMPLES as f64;
    let values: Vec<f64> = (0..SAMPLES).map(|i| f(i as f64 * step)).collect();
    let mut best = (0.0, f64::NEG_INFINITY);
    for (i, &value) in values.iter().enumerate() {
        let before = values[(i + SAMPLES - 1) % SAMPLES];
        let after = values[(i + 1) % SAMPLES];
        if value > best.1 {
            best = (i as f64 * step, value);
        }
        if value >= before && value >= after && value.is_finite() {
            let refined = golden_section((i as f64 - 1.0) * step, (i as f64 + 1.0) * step, &mut f);
            if refined.1 > best.1 {
                best = refined;
            }
        }
    }
    (best.0.rem_euclid(period), best.1)
}

/// Halvings by the golden ratio that narrow a bracket to 1e-11 of its width.
const NARROWINGS: usize = 53;

/// Largest value of `f` between `low` and `high`, where it has one maximum (Kiefer 1953).
///
/// A fixed number of steps: far from 0 a bracket cannot become narrower than rounding, however long one tries.
pub(crate) fn golden_section(mut low: f64, mut high: f64, f: &mut impl FnMut(f64) -> f64) -> (f64, f64) {
    let ratio = 0.5 * (5.0_f64.sqrt() - 1.0);
    let (mut a, mut b) = (high - ratio * (high - low), low + ratio * (high - low));
    let (mut fa, mut fb) = (f(a), f(b));
    for _ in 0..NARROWINGS {
        if fa >= fb {
            (high, b, fb) = (b, a, fa);
            a = high - ratio * (high - low);
            fa = f(a);
        } else {
            (low, a, fa) = (a, b, fb);
            b = low + ratio * (high - low);
            fb = f(b);
        }
    }
    if fa >= fb { (a, fa) } else { (b, fb) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn finds_smooth_and_kinked_maxima() {
        let (at, value) = maximum(2.0, |x| (std::f64::consts::PI * (x - 0.37)).cos());
        assert!((at - 0.37).abs() < 1e-7 && (value - 1.0).abs() < 1e-14);
        let (at, value) = maximum(1.0, |x| 3.0 - (x - 0.123_456_7).abs());
        assert!((at - 0.123_456_7).abs() < 1e-10 && (value - 3.0).abs() < 1e-10);
        assert!(maximum(1.0, |x| if x > 0.5 { f64::INFINITY } else { 0.0 }).1.is_infinite());
    }
}
