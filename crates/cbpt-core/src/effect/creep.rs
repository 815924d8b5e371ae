//! Creep under torque.
//!
//! alpha += c M0 ln(1 + t/tau) + c_s sum of (M_j - M_(j-1)) ln(1 + (t - t_j)/tau), t since the run began.
//!
//! The first term is the creep after one step of torque, whatever the torque does later: that of runs that stay at one
//! torque. The second sums the creep after every step of torque (Boltzmann): creep that a torque started continues when the
//! torque is gone, as in a linear viscoelastic material. A run begins unloaded, and a torque is held from its reading to the next; so
//! where a run has one torque, the two terms are the same.

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
    equation: "alpha += c M0 ln(1 + t/tau) + c_s sum of dM_j ln(1 + (t - t_j)/tau), where t is the time since the run began and the torque changed by dM_j at t_j",
    source: "logarithmic creep: Phillips, Phil. Mag. 9 (1905) 513; superposition: Boltzmann, Ann. Phys. Erg. 7 (1876) 624",
    tell_tale: "the angle grows with time at constant torque",
    parameters: &[
        compliance("compliance", "growth c of the compliance since the run began"),
        Parameter::shape("time_constant", Quantity::Time, 20.0, "time tau after which the growth slows")
            .within(1e-3, 1e7)
            .likely(1.0, 1e4)
            .log(),
        compliance("superposed_compliance", "growth c_s of the compliance since each step of torque"),
    ],
    twins: &[],
    action: Action::History(act),
};

const fn compliance(stem: &'static str, meaning: &'static str) -> Parameter {
    Parameter::size(stem, Quantity::AnglePerTorque, meaning).within(0.0, 1.0).likely(1e-9, 1e-5).log()
}

fn act(own: &[Dual], rows: &[Row], torque_Nm: &[Dual]) -> Vec<Dual> {
    let rate = own[1].recip();
    let superposes = own[2] != Dual::constant(0.0);
    let mut steps: Vec<(f64, Dual)> = Vec::new();
    let mut before = Dual::constant(0.0);
    let mut angles = Vec::with_capacity(rows.len());
    for (row, &torque) in rows.iter().zip(torque_Nm) {
        let now = row.run_time_s;
        let mut angle = own[0] * torque * (rate * now).ln_1p();
        if superposes {
            angle += own[2] * superposed(&steps, now, &rate);
            if torque != before {
                steps.push((now, torque - before));
            }
            before = torque;
        }
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

#[cfg(test)]
#[allow(clippy::float_cmp)] // where nothing is rounded
mod tests {
    use super::*;
    use crate::effect::testing::{assert_close, history, vanishes};

    /// At a run time of 60 s, ln(1 + 60/20) = ln 4.
    #[test]
    fn it_grows_with_the_logarithm_of_time() {
        let found = history(&SPEC, &[1e-6, 20.0, 0.0], &[(0.0, 2.0), (60.0, 5.0)]);
        assert_close(found[1], 5e-6 * 4_f64.ln());
    }

    /// 2 N m from the start, 3 N m more after 20 s: at 60 s 2 ln(1 + 60/20) + 3 ln(1 + 40/20). Unloaded then, it goes on.
    #[test]
    fn it_superposes_from_every_step() {
        let run = [(0.0, 2.0), (20.0, 5.0), (60.0, 0.0), (100.0, 0.0)];
        let found = history(&SPEC, &[0.0, 20.0, 1e-6], &run);
        assert_eq!(found[0], 0.0);
        assert_close(found[1], 1e-6 * 2.0 * 2_f64.ln());
        assert_close(found[2], 1e-6 * (2.0 * 4_f64.ln() + 3.0 * 3_f64.ln()));
        assert_close(found[3], 1e-6 * (2.0 * 6_f64.ln() + 3.0 * 5_f64.ln() - 5.0 * 3_f64.ln()));
    }

    #[test]
    fn under_one_torque_both_forms_are_the_same() {
        let run = [(0.0, 4.0), (7.0, 4.0), (30.0, 4.0), (500.0, 4.0)];
        let since_start = history(&SPEC, &[1e-6, 20.0, 0.0], &run);
        for (one, other) in since_start.iter().zip(history(&SPEC, &[0.0, 20.0, 1e-6], &run)) {
            assert_close(other, *one);
        }
    }

    #[test]
    fn it_vanishes() {
        vanishes(&SPEC);
    }
}
