//! Torque and angle that do not belong to one instant.
//!
//! tau > 0: a sensor or filter of first order shows the torque late, M0 = M_read + tau r with r = dM_read/dt. tau < 0: the load
//! behind the sensor, or the angle, is late, |tau| dM0/dt = M_read - M0.
//!
//! A run begins at rest, r = 0. Else r at a reading is the rate from the reading before to the one behind, so that the noise of a
//! torque reading has no share in what is added to it; at the last that from the one before. Between readings r goes straight,
//! so what a late load adds is m = q + (m1 - q1) exp(-dt/|tau|) after m1, with q = |tau| (|tau| dr/dt - r); both are -|tau| r
//! for a short lag. Where no time passes nothing is added.

use super::dual::Dual;
use super::port::{Action, Row};
use super::spec::{Class, Parameter, Port, Reducers, Spec};
use crate::units::Quantity;

/// The effect.
pub static SPEC: Spec = Spec {
    id: "torque_lag",
    class: Class::Rig,
    port: Port::Reading,
    reducers: Reducers::All,
    equation: "tau > 0: M0 = M_read + tau dM_read/dt; tau < 0: |tau| dM0/dt = M_read - M0",
    source: "first-order measuring system: Doebelin, Measurement Systems (2004), section 3.3",
    tell_tale: "loading and unloading form a loop that is wider where the torque changes faster, and vanishes where it holds",
    parameters: &[Parameter::size(
        "lag",
        Quantity::Time,
        "time tau by which the torque readings are late; negative: by which the load or the angle is late",
    )
    .within(-1e6, 1e6)
    .likely(-10.0, 10.0)],
    twins: &[],
    action: Action::Torques(act),
};

fn act(own: &[Dual], run: &[Row]) -> Vec<Dual> {
    let rates = rates_Nm_per_s(run);
    if own[0].value < 0.0 {
        late_load(-own[0], run, &rates)
    } else {
        rates.into_iter().map(|rate| own[0] * rate).collect()
    }
}

fn rates_Nm_per_s(run: &[Row]) -> Vec<f64> {
    let last = run.len() - 1;
    let rate = |place: usize| {
        let (before, behind) = (&run[place - 1], &run[last.min(place + 1)]);
        let passed_s = behind.run_time_s - before.run_time_s;
        if passed_s > 0.0 { (behind.torque_Nm - before.torque_Nm) / passed_s } else { 0.0 }
    };
    (0..=last).map(|place| if place == 0 { 0.0 } else { rate(place) }).collect()
}

fn late_load(tau_s: Dual, run: &[Row], rates: &[f64]) -> Vec<Dual> {
    let mut added = vec![Dual::constant(0.0)];
    for place in 1..run.len() {
        let before = added[place - 1];
        let passed_s = run[place].run_time_s - run[place - 1].run_time_s;
        if passed_s <= 0.0 {
            added.push(before);
            continue;
        }
        let change = tau_s * ((rates[place] - rates[place - 1]) / passed_s);
        let steady = |rate: f64| tau_s * (change - Dual::constant(rate));
        let left = (-(passed_s / tau_s.value)).exp();
        let left = tau_s.chain(left, left * passed_s / (tau_s.value * tau_s.value));
        added.push(steady(rates[place]) + (before - steady(rates[place - 1])) * left);
    }
    added
}

#[cfg(test)]
#[allow(clippy::float_cmp)] // where nothing is rounded
mod tests {
    use super::*;
    use crate::effect::testing::{torques, vanishes};

    const RAMP: [(f64, f64); 6] = [(0.0, 0.0), (2.0, 1.0), (4.0, 2.0), (4.0, 2.5), (6.0, 3.5), (8.0, 1.5)];

    fn added(tau_s: f64) -> Vec<f64> {
        torques(&SPEC, &[Dual::constant(tau_s)], &RAMP).iter().map(|torque| torque.value).collect()
    }

    #[test]
    fn a_late_sensor_shows_what_was_before() {
        assert_eq!(added(0.5), [0.0, 0.25, 0.375, 0.375, -0.125, -0.5]);
    }

    #[test]
    fn a_load_that_is_hardly_late_is_the_same_the_other_way() {
        for (late, early) in added(-1e-6).iter().zip(added(1e-6)) {
            assert!((late + early).abs() < 1e-11, "{late} {early}");
        }
    }

    /// The differential equation of what is added, dm/dt = -r - m/|tau|, in small steps of the midpoint rule.
    #[test]
    fn a_late_load_follows_its_equation() {
        let tau_s = 0.7;
        let rates = added(1.0);
        let mut expected = vec![0.0];
        let mut m: f64 = 0.0;
        for (place, pair) in RAMP.windows(2).enumerate() {
            let steps = 20_000;
            let step_s = (pair[1].0 - pair[0].0) / f64::from(steps);
            for step in 0..steps {
                let share = (f64::from(step) + 0.5) / f64::from(steps);
                let rate = rates[place] * (1.0 - share) + rates[place + 1] * share;
                let half = m + 0.5 * step_s * (-rate - m / tau_s);
                m += step_s * (-rate - half / tau_s);
            }
            expected.push(m);
        }
        for (found, expected) in added(-tau_s).iter().zip(&expected) {
            assert!((found - expected).abs() < 1e-7, "{found} {expected}");
        }
    }

    #[test]
    fn its_derivative_is_exact() {
        for tau_s in [0.4, -0.4] {
            let found = torques(&SPEC, &[Dual::parameter(tau_s, 0)], &RAMP);
            let h = 1e-6;
            for (found, (up, down)) in found.iter().zip(added(tau_s + h).iter().zip(added(tau_s - h))) {
                assert!((found.partials[0] - (up - down) / (2.0 * h)).abs() < 1e-8, "{found:?}");
            }
        }
    }

    #[test]
    fn it_vanishes() {
        vanishes(&SPEC);
    }
}
