//! Creep under torque.
//!
//! alpha += c M0 ln(1 + t/tau) + sum of (M_j - M_(j-1)) (c_s ln(1 + (t - t_j)/tau) + c_p ((t - t_j)/tau)^q), t since the run
//! began.
//!
//! The first term is the creep after one step of torque, whatever the torque does later: that of runs that stay at one
//! torque. The others sum the creep after every step of torque (Boltzmann): creep that a torque started continues when the
//! torque is gone, as in a linear viscoelastic material. A run begins unloaded, and a torque is held from its reading to the next; so
//! where a run has one torque, the first two terms are the same. The logarithm suits metals at room temperature, a power of
//! time polymers and metals that are warm (q = 1/3: Andrade).

use super::dual::Dual;
use super::port::{Action, Row};
use super::spec::{Class, Parameter, Port, Reducers, Spec};
use crate::units::Quantity;

/// The effect.
pub static SPEC: Spec = Spec {
    id: "creep",
    class: Class::Effect,
    port: Port::Series,
    reducers: Reducers::All,
    equation: "alpha += c M0 ln(1 + t/tau) + sum of dM_j (c_s ln(1 + (t - t_j)/tau) + c_p ((t - t_j)/tau)^q), where t is the time since the run began and the torque changed by dM_j at t_j",
    source: "logarithmic creep: Phillips, Phil. Mag. 9 (1905) 513; a power of time: Andrade, Proc. R. Soc. Lond. A 84 (1910) 1; superposition: Boltzmann, Ann. Phys. Erg. 7 (1876) 624",
    tell_tale: "the angle grows with time at constant torque",
    parameters: &[
        compliance("compliance", "growth c of the compliance since the run began"),
        Parameter::shape(
            "time_constant",
            Quantity::Time,
            20.0,
            "time tau after which the growth slows, and by which c_p is reached",
        )
        .within(1e-3, 1e7)
        .likely(1.0, 1e4)
        .log(),
        compliance("superposed_compliance", "growth c_s of the compliance since each step of torque"),
        compliance(
            "power_compliance",
            "growth c_p of the compliance by the time tau after each step of torque",
        ),
        Parameter::shape(
            "growth_exponent",
            Quantity::Number,
            1.0 / 3.0,
            "power q of the time since a step of torque",
        )
        .within(1e-3, 1.0)
        .likely(0.15, 0.6),
    ],
    twins: &[],
    action: Action::History(act),
};

const fn compliance(stem: &'static str, meaning: &'static str) -> Parameter {
    Parameter::size(stem, Quantity::AnglePerTorque, meaning).within(0.0, 1.0).likely(1e-9, 1e-5).log()
}

fn act(own: &[Dual], rows: &[Row], torque_Nm: &[Dual]) -> Vec<Dual> {
    let rate = own[1].recip();
    let [by_logarithm, by_power] = [own[2], own[3]].map(|size| size != Dual::constant(0.0));
    let mut steps: Vec<(f64, Dual)> = Vec::new();
    let mut before = Dual::constant(0.0);
    let mut angles = Vec::with_capacity(rows.len());
    for (row, &torque) in rows.iter().zip(torque_Nm) {
        let now = row.run_time_s;
        let mut angle = own[0] * torque * (rate * now).ln_1p();
        if by_logarithm {
            angle += own[2] * superposed(&steps, now, &rate);
        }
        if by_power {
            angle += own[3] * superposed_power(&steps, now, &rate, &own[4]);
        }
        if (by_logarithm || by_power) && torque != before {
            steps.push((now, torque - before));
        }
        before = torque;
        angles.push(angle);
    }
    angles
}

/// Sum of step ln(1 + rate (now - then)) over steps (then, s; step, N m). Every reading has all steps before it, so partials
/// are formed once a sum where they can be.
fn superposed(steps: &[(f64, Dual)], now: f64, rate: &Dual) -> Dual {
    let mut sum = Dual::constant(0.0);
    let mut by_rate = 0.0;
    for (then, step) in steps {
        let time = now - then;
        let grown = (rate.value * time).ln_1p();
        sum.value += step.value * grown;
        by_rate += step.value * time / (1.0 + rate.value * time);
        if step.partials.iter().any(|partial| *partial != 0.0) {
            sum.add_slope(grown, step);
        }
    }
    sum.add_slope(by_rate, rate);
    sum
}

/// Sum of step (rate (now - then))^q.
fn superposed_power(steps: &[(f64, Dual)], now: f64, rate: &Dual, exponent: &Dual) -> Dual {
    let mut sum = Dual::constant(0.0);
    let mut by_exponent = 0.0;
    for (then, step) in steps {
        let time = rate.value * (now - then);
        // Two readings at one moment: nothing has crept yet.
        if time > 0.0 {
            let grown = time.powf(exponent.value);
            sum.value += step.value * grown;
            by_exponent += step.value * grown * time.ln();
            if step.partials.iter().any(|partial| *partial != 0.0) {
                sum.add_slope(grown, step);
            }
        }
    }
    let by_rate = exponent.value * sum.value / rate.value;
    sum.add_slope(by_rate, rate);
    sum.add_slope(by_exponent, exponent);
    sum
}

#[cfg(test)]
#[allow(clippy::float_cmp)] // where nothing is rounded
mod tests {
    use super::*;
    use crate::effect::testing::{assert_close, history, vanishes};

    /// At a run time of 60 s, ln(1 + 60/20) = ln 4.
    #[test]
    fn it_grows_with_the_logarithm_of_time() {
        let found = history(&SPEC, &[1e-6, 20.0, 0.0, 0.0, 0.3], &[(0.0, 2.0), (60.0, 5.0)]);
        assert_close(found[1], 5e-6 * 4_f64.ln());
    }

    /// 2 N m from the start, 3 N m more after 20 s: at 60 s 2 ln(1 + 60/20) + 3 ln(1 + 40/20). Unloaded then, it goes on.
    #[test]
    fn it_superposes_from_every_step() {
        let run = [(0.0, 2.0), (20.0, 5.0), (60.0, 0.0), (100.0, 0.0)];
        let found = history(&SPEC, &[0.0, 20.0, 1e-6, 0.0, 0.3], &run);
        assert_eq!(found[0], 0.0);
        assert_close(found[1], 1e-6 * 2.0 * 2_f64.ln());
        assert_close(found[2], 1e-6 * (2.0 * 4_f64.ln() + 3.0 * 3_f64.ln()));
        assert_close(found[3], 1e-6 * (2.0 * 6_f64.ln() + 3.0 * 5_f64.ln() - 5.0 * 3_f64.ln()));
    }

    /// 2 N m from the start, 3 N m more after 20 s: at 100 s 2 (100/20)^q + 3 (80/20)^q; unloaded then, it goes on.
    #[test]
    fn it_grows_with_a_power_of_time() {
        let run = [(0.0, 2.0), (20.0, 5.0), (100.0, 0.0), (100.0, 0.0), (180.0, 0.0)];
        let found = history(&SPEC, &[0.0, 20.0, 0.0, 1e-6, 0.5], &run);
        let at_once = 1e-6 * (2.0 * 5_f64.sqrt() + 3.0 * 2.0);
        assert_eq!(found[0], 0.0);
        assert_close(found[1], 2e-6);
        assert_close(found[2], at_once);
        assert_close(found[3], at_once);
        assert_close(found[4], 1e-6 * (2.0 * 3.0 + 3.0 * 8_f64.sqrt() - 5.0 * 2.0));
    }

    #[test]
    fn under_one_torque_both_forms_are_the_same() {
        let run = [(0.0, 4.0), (7.0, 4.0), (30.0, 4.0), (500.0, 4.0)];
        let since_start = history(&SPEC, &[1e-6, 20.0, 0.0, 0.0, 0.3], &run);
        for (one, other) in since_start.iter().zip(history(&SPEC, &[0.0, 20.0, 1e-6, 0.0, 0.3], &run)) {
            assert_close(other, *one);
        }
    }

    #[test]
    fn it_vanishes() {
        vanishes(&SPEC);
    }
}
