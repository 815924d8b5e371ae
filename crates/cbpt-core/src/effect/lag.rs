//! The temperature of a part that follows the measured one with a time constant.
//!
//! tau dT_p/dt = T - T_p, a first-order lag; the part has the first temperature at first, and the measured temperature goes
//! straight from reading to reading. Then the lag L = T - T_p follows in closed form: after a time h in which T rises by D,
//! L -> L e^(-x) + D (1 - e^(-x))/x with x = h/tau. Source: a lumped thermal mass, Incropera et al., Fundamentals of Heat and
//! Mass Transfer (2007), section 5.1.

use super::dual::Dual;
use super::port::Row;
use super::spec::Parameter;
use crate::units::Quantity;

/// The time constant, as a parameter of an effect; without one the part has the measured temperature.
pub const fn time_constant() -> Parameter {
    Parameter::shape(
        "time_constant",
        Quantity::Time,
        0.0,
        "time tau with which the part follows the measured temperature; 0: at once",
    )
    .within(0.0, 1e7)
    .likely(60.0, 1200.0)
    .log()
}

/// Temperature of the part less the first one (K), at each of these readings, which are in order of time.
pub fn part_temperatures(rows: &[Row], time_constant_s: &Dual) -> Vec<Dual> {
    let mut lag_K = Dual::constant(0.0);
    let mut before = rows.first();
    rows.iter()
        .map(|row| {
            let (time_s, rise_K) = before.replace(row).map_or((0.0, 0.0), |before| {
                (row.time_s - before.time_s, row.temperature_difference_K - before.temperature_difference_K)
            });
            lag_K = lagged(&lag_K, rise_K, time_s, time_constant_s);
            -lag_K + row.temperature_difference_K
        })
        .collect()
}

/// The lag after a time in which the temperature rises evenly.
fn lagged(before_K: &Dual, rise_K: f64, time_s: f64, time_constant_s: &Dual) -> Dual {
    if time_s == 0.0 {
        // Two temperatures at one time: the part takes part in the step only where it does not lag.
        return if time_constant_s.value == 0.0 { Dual::constant(0.0) } else { *before_K + rise_K };
    }
    let x = time_s / time_constant_s.value;
    let left = (-x).exp();
    let mean = -(-x).exp_m1() / x;
    // x is infinite where nothing lags; x e^(-x) is 0 there.
    let (first, second) = if left == 0.0 { (0.0, 0.0) } else { (x * left, x * x * left) };
    let mut lag_K = before_K.chain(before_K.value * left + rise_K * mean, left);
    let slope = before_K.value * second + rise_K * (1.0 - left - first);
    lag_K.add_slope(slope / time_s, time_constant_s);
    lag_K
}

#[cfg(test)]
#[allow(clippy::float_cmp)] // where nothing is rounded
mod tests {
    use super::*;
    use crate::effect::testing::ROW;

    fn rows(path: &[(f64, f64)]) -> Vec<Row> {
        let row = |&(time_s, temperature_difference_K)| Row { time_s, temperature_difference_K, ..ROW };
        path.iter().map(row).collect()
    }

    const PATH: [(f64, f64); 5] = [(0.0, 0.0), (40.0, 0.5), (100.0, 0.2), (100.0, 0.3), (900.0, 2.0)];

    /// Against the differential equation in small steps (the middle of each).
    #[test]
    fn it_follows_its_equation() {
        let tau = 300.0;
        let found = part_temperatures(&rows(&PATH), &Dual::constant(tau));
        let mut part = 0.0;
        for (pair, found) in PATH.windows(2).zip(&found[1..]) {
            let [(start, from), (end, to)] = [pair[0], pair[1]];
            let steps = 200_000;
            let h = (end - start) / f64::from(steps);
            for i in 0..steps {
                let measured = from + (to - from) * (f64::from(i) + 0.5) / f64::from(steps);
                let middle = part + 0.5 * h * (measured - part) / tau;
                part += h * (measured - middle) / tau;
            }
            assert!((found.value - part).abs() < 1e-8, "{} {part}", found.value);
        }
    }

    #[test]
    fn without_time_constant_it_is_the_measured_one() {
        for (found, (_, measured)) in part_temperatures(&rows(&PATH), &Dual::constant(0.0)).iter().zip(PATH) {
            assert_eq!(found.value, measured);
        }
    }

    #[test]
    fn its_derivative_is_exact() {
        let at = |tau: f64| part_temperatures(&rows(&PATH), &Dual::parameter(tau, 0));
        for tau in [30.0, 300.0, 1200.0] {
            let h = 1e-3;
            for ((exact, up), down) in at(tau).iter().zip(at(tau + h)).zip(at(tau - h)) {
                let difference = (up.value - down.value) / (2.0 * h);
                assert!((exact.partials[0] - difference).abs() < 1e-10, "{tau} {difference}");
            }
        }
        let (none, little) = (at(0.0), at(1e-6));
        for ((exact, little), (_, measured)) in none.iter().zip(little).zip(PATH).skip(1) {
            if measured != 0.3 {
                assert!((exact.partials[0] - (little.value - measured) / 1e-6).abs() < 1e-6);
            }
        }
    }
}
