//! An angle that is late: a damper beside the stiffness, or a slow angle sensor.
//!
//! The load that turns the reducer is tau dM/dt = M0 - M, with tau the damping over the stiffness (Kelvin and Voigt). What it
//! adds is m = M - M0. With the rates r of the torque as in [`super::torque_rate`], which go straight between readings, m is
//! q + (m1 - q1) exp(-dt/tau) after m1, with q = tau (tau dr/dt - r); -tau r for a short time. A run begins at rest, m = 0, or
//! moves, m = q.

use super::dual::Dual;
use super::port::{Action, Row};
use super::spec::{Class, Parameter, Port, Reducers, Spec};
use super::torque_lag::{STARTS_MOVING, rates_of};
use crate::units::Quantity;

/// The effect.
pub static SPEC: Spec = Spec {
    id: "damping",
    class: Class::Effect,
    port: Port::Load,
    reducers: Reducers::All,
    equation: "tau dM/dt = M0 - M",
    source: "spring and damper side by side (Kelvin-Voigt): Lakes, Viscoelastic Materials (2009), section 2.6",
    tell_tale: "loading and unloading form a loop that is wider where the torque changes faster, and the angle comes on while the torque holds",
    parameters: &[
        Parameter::size(
            "time_constant",
            Quantity::Time,
            "time tau by which the angle is late: damping over stiffness",
        )
        .within(0.0, 1e6)
        .likely(0.0, 10.0),
        STARTS_MOVING,
    ],
    twins: &[],
    action: Action::Torques(act),
};

fn act(own: &[Dual], run: &[Row]) -> Vec<Dual> {
    let (tau_s, starts_moving) = (own[0], own[1].value);
    let rates = rates_of(run, starts_moving);
    let passed_s = |place: usize| run[place].run_time_s - run[place - 1].run_time_s;
    // What is added after a long time at a rate that changes as it does over the step to a reading, at its end and at its start.
    let steady = |place: usize| {
        let (start, end) = (rates[place - 1].leaving_Nm_per_s, rates[place].arriving_Nm_per_s);
        let change = (end - start) / passed_s(place);
        [end, start].map(|rate| tau_s * (tau_s * change - Dual::constant(rate)))
    };
    let moves = run.len() > 1 && passed_s(1) > 0.0;
    let mut added = vec![if moves { steady(1)[1] * starts_moving } else { Dual::constant(0.0) }];
    for place in 1..run.len() {
        let before = added[place - 1];
        if passed_s(place) <= 0.0 {
            added.push(before);
            continue;
        }
        // Without damping nothing is left of what was before.
        let [at_end, at_start] = steady(place);
        let start = before - at_start;
        let kept = if tau_s.value > 0.0 { start * left(tau_s, passed_s(place)) } else { Dual::constant(0.0) };
        added.push(at_end + kept);
    }
    added
}

/// What is left after a time, exp(-dt/tau).
fn left(tau_s: Dual, passed_s: f64) -> Dual {
    let left = (-(passed_s / tau_s.value)).exp();
    tau_s.chain(left, left * passed_s / (tau_s.value * tau_s.value))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effect::testing::{RAMP, added_late, sine, torques, vanishes};

    #[test]
    fn an_angle_that_is_hardly_late_is_the_rate() {
        let rates = [0.0, 0.5, 0.75, 0.75, -0.25, -1.0];
        for (late, rate) in added_late(&SPEC, 1e-6).iter().zip(rates) {
            assert!((late + 1e-6 * rate).abs() < 1e-11, "{late} {rate}");
        }
    }

    /// The differential equation of what is added, dm/dt = -r - m/tau, in small steps of the midpoint rule.
    #[test]
    fn it_follows_its_equation() {
        let tau_s = 0.7;
        let rates = [0.5, 0.5, 0.75, 0.75, -0.25, -1.0];
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
        for (found, expected) in added_late(&SPEC, tau_s).iter().zip(&expected) {
            assert!((found - expected).abs() < 1e-7, "{found} {expected}");
        }
    }

    /// From rest, up and back: the closed form of each leg.
    #[test]
    fn a_triangle_is_followed_exactly() {
        let (tau_s, rate) = (5.0, 0.8);
        let run: Vec<(f64, f64)> =
            (0..21).map(|i| (f64::from(i), rate * f64::from(10 - (i - 10_i32).abs()))).collect();
        let found = torques(&SPEC, &[Dual::constant(tau_s), Dual::constant(0.0)], &run);
        let turn = -tau_s * rate * (1.0 - (-10.0 / tau_s).exp());
        for (found, (time_s, _)) in found.iter().zip(&run) {
            let expected = if *time_s <= 10.0 {
                -tau_s * rate * (1.0 - (-time_s / tau_s).exp())
            } else {
                tau_s * rate + (turn - tau_s * rate) * (-(time_s - 10.0) / tau_s).exp()
            };
            assert!((found.value - expected).abs() < 1e-12, "{time_s}: {} {expected}", found.value);
        }
    }

    /// A sine that began long before: M is late by its phase.
    #[test]
    fn a_run_that_starts_moving_is_steady_at_once() {
        let sine = sine();
        let found = torques(&SPEC, &[Dual::constant(0.1), Dual::constant(1.0)], &sine);
        let (size, late_rad) = (1.0 / 1.01_f64.sqrt(), 0.1_f64.atan());
        for (found, (time_s, torque_Nm)) in found.iter().zip(&sine).take(59) {
            let expected = size * (time_s - late_rad).sin() - torque_Nm;
            assert!((found.value - expected).abs() < 0.003, "{time_s}: {} {expected}", found.value);
        }
    }

    #[test]
    fn its_derivative_is_exact() {
        let (tau_s, h) = (0.4, 1e-6);
        let found = torques(&SPEC, &[Dual::parameter(tau_s, 0), Dual::constant(0.0)], &RAMP);
        for (found, (up, down)) in
            found.iter().zip(added_late(&SPEC, tau_s + h).iter().zip(added_late(&SPEC, tau_s - h)))
        {
            assert!((found.partials[0] - (up - down) / (2.0 * h)).abs() < 1e-8, "{found:?}");
        }
    }

    #[test]
    fn it_vanishes() {
        vanishes(&SPEC);
    }
}
