//! An angle that is late: a damper beside the stiffness, or a slow angle sensor.
//!
//! The load that turns the reducer is tau dM/dt = M0 - M, with tau the damping over the stiffness (Kelvin and Voigt). What it
//! adds is m = M - M0. With the rates r of the torque as in [`super::torque_rate`], which go straight between readings, m is
//! q + (m1 - q1) exp(-dt/tau) after m1, with q = tau (tau dr/dt - r); -tau r for a short time. A run begins at rest, m = 0, or
//! moves, m = q; if its torque then ends as it began, it is a period of a repeated cycle, and begins with the m with which it ends.

use super::dual::Dual;
use super::port::{Action, Row};
use super::spec::{Class, Parameter, Port, Reducers, Spec};
use super::torque_lag::{STARTS_MOVING, rates_of};
use super::torque_rate::Rate;
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
        Parameter {
            meaning: "1 where runs begin while the torque changes, and a run whose torque ends as it began is a period of a repeated cycle; 0 where runs begin at rest",
            ..STARTS_MOVING
        },
    ],
    twins: &[],
    action: Action::Torques(act),
};

fn act(own: &[Dual], run: &[Row]) -> Vec<Dual> {
    let (tau_s, starts_moving) = (own[0], own[1].value);
    let rates = rates_of(run, starts_moving);
    let begins = if run.len() > 1 { steady(tau_s, run, &rates, 1)[1] * starts_moving } else { AT_REST };
    let added = from(begins, tau_s, run, &rates);
    let last = run.len() - 1;
    if starts_moving < 0.5 || !ends_as_it_begins(run, &rates) {
        return added;
    }
    // What it ends with, less what is left of where it began.
    let kept = kept(tau_s, run[last].run_time_s - run[0].run_time_s);
    from((added[last] - begins * kept) / (-kept + 1.0), tau_s, run, &rates)
}

const AT_REST: Dual = Dual::constant(0.0);

/// Whether torque and rate are those of the start again, to half of the largest step and a fifth of the largest rate: the rate of
/// the last step is half a step late. A run that begins with a hold begins at rest.
fn ends_as_it_begins(run: &[Row], rates: &[Rate]) -> bool {
    let last = run.len() - 1;
    if last < 3 || run[1].torque_Nm - run[0].torque_Nm == 0.0 {
        return false;
    }
    let off_Nm = run[last].torque_Nm - run[0].torque_Nm;
    let off_Nm_per_s = rates[last].arriving_Nm_per_s - rates[0].leaving_Nm_per_s;
    let most = rates.iter().fold(0.0_f64, |most, rate| most.max(rate.leaving_Nm_per_s.abs()));
    let step_Nm =
        run.windows(2).fold(0.0_f64, |most, pair| most.max((pair[1].torque_Nm - pair[0].torque_Nm).abs()));
    off_Nm.abs() < 0.5 * step_Nm && off_Nm_per_s.abs() < 0.2 * most
}

/// What is added at each reading from what is added at the first.
fn from(begins: Dual, tau_s: Dual, run: &[Row], rates: &[Rate]) -> Vec<Dual> {
    let mut added = vec![begins];
    for place in 1..run.len() {
        let before = added[place - 1];
        let passed_s = run[place].run_time_s - run[place - 1].run_time_s;
        if passed_s <= 0.0 {
            added.push(before);
            continue;
        }
        let [at_end, at_start] = steady(tau_s, run, rates, place);
        added.push(at_end + (before - at_start) * kept(tau_s, passed_s));
    }
    added
}

/// What is added after a long time at a rate that changes as it does over the step to a reading, at its end and at its start.
fn steady(tau_s: Dual, run: &[Row], rates: &[Rate], place: usize) -> [Dual; 2] {
    let passed_s = run[place].run_time_s - run[place - 1].run_time_s;
    if passed_s <= 0.0 {
        return [AT_REST; 2];
    }
    let (start, end) = (rates[place - 1].leaving_Nm_per_s, rates[place].arriving_Nm_per_s);
    let change = (end - start) / passed_s;
    [end, start].map(|rate| tau_s * (tau_s * change - Dual::constant(rate)))
}

/// What is kept after a time of what was before: nothing without damping.
fn kept(tau_s: Dual, passed_s: f64) -> Dual {
    if tau_s.value > 0.0 { left(tau_s, passed_s) } else { AT_REST }
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

    /// The same where the start alone does not tell: a period of a sine that is late by a third of a radian.
    #[test]
    fn a_run_that_ends_as_it_began_is_steady_however_late() {
        let tau_s: f64 = 0.35;
        let period: Vec<(f64, f64)> =
            (0..=40).map(|i| std::f64::consts::TAU * f64::from(i) / 40.0).map(|t| (t, t.sin())).collect();
        let (size, late_rad) = (1.0 / (1.0 + tau_s * tau_s).sqrt(), tau_s.atan());
        let most = |torques: &[Dual]| {
            let off = torques.iter().zip(&period).take(39);
            off.map(|(found, (t, torque))| (found.value - size * (t - late_rad).sin() + torque).abs())
                .fold(0.0, f64::max)
        };
        let tau = Dual::parameter(tau_s, 0);
        let of = |run: &[(f64, f64)]| torques(&SPEC, &[tau, Dual::constant(1.0)], run);
        assert!(most(&of(&period)) < 0.003);
        assert!(most(&of(&period[..30])) > 0.01);
        let (h, found) = (1e-6, torques(&SPEC, &[tau, Dual::constant(1.0)], &period));
        let at = |tau: f64| torques(&SPEC, &[Dual::constant(tau), Dual::constant(1.0)], &period);
        for (found, (up, down)) in found.iter().zip(at(tau_s + h).iter().zip(at(tau_s - h))) {
            assert!((found.partials[0] - (up.value - down.value) / (2.0 * h)).abs() < 1e-8, "{found:?}");
        }
    }

    #[test]
    fn a_run_that_begins_with_a_hold_begins_at_rest() {
        let run: Vec<(f64, f64)> =
            (0..8).map(f64::from).zip([0.0, 0.0, 0.0, 5.0, 10.0, 5.0, 0.0, 0.0]).collect();
        let found = torques(&SPEC, &[Dual::constant(2.0), Dual::constant(1.0)], &run);
        assert!(found[..2].iter().all(|added| added.value == 0.0), "{found:?}");
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
