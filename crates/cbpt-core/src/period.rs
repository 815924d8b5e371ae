//! Maxima of periodic functions that are smooth but for kinks: a scan of one period, then golden section.

/// Samples of a period's scan; the quantities here have one or two maxima a period.
const SAMPLES: usize = 96;

/// Place and value of the largest value of each component of `f` over `period`, starting at 0; one scan serves all.
///
/// `f` may be infinite (nothing holds there), which is then the maximum.
pub(crate) fn maxima<const N: usize>(period: f64, f: impl Fn(f64) -> [f64; N]) -> [(f64, f64); N] {
    let step = period / SAMPLES as f64;
    let samples: Vec<[f64; N]> = (0..SAMPLES).map(|i| f(i as f64 * step)).collect();
    std::array::from_fn(|n| {
        let values: Vec<f64> = samples.iter().map(|values| values[n]).collect();
        maximum(period, &values, |at| f(at)[n])
    })
}

/// Place and value of the largest value of `f`, of which `values` are samples.
fn maximum(period: f64, values: &[f64], mut f: impl FnMut(f64) -> f64) -> (f64, f64) {
    let step = period / SAMPLES as f64;
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
        let smooth = |x: f64| (std::f64::consts::TAU * (x - 0.37)).cos();
        let kinked = |x: f64| 3.0 - (x - 0.123_456_7).abs();
        let infinite = |x: f64| if x > 0.5 { f64::INFINITY } else { 0.0 };
        let [(at, value), (at_kink, at_most), (_, never)] =
            maxima(1.0, |x| [smooth(x), kinked(x), infinite(x)]);
        assert!((at - 0.37).abs() < 1e-7 && (value - 1.0).abs() < 1e-14);
        assert!((at_kink - 0.123_456_7).abs() < 1e-10 && (at_most - 3.0).abs() < 1e-10);
        assert!(never.is_infinite());
    }

    #[test]
    fn one_scan_serves_all() {
        let calls = std::cell::Cell::new(0);
        let constant = |_: f64| {
            calls.set(calls.get() + 1);
            [f64::INFINITY; 3]
        };
        assert!(maxima(1.0, constant).iter().all(|(_, value)| value.is_infinite()));
        assert_eq!(calls.get(), SAMPLES);
    }
}
