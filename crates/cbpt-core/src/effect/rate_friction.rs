//! Friction that depends on the rate of the rotation.
//!
//! Tf = Tf0 sgn(w) (1 - exp(-|w|/w0)) with w the rate of the total angle at the reading: viscous, Tf0 w/w0, far below
//! the rate w0, and at most the torque at which the lubricant shears off. It has no memory. Beside `friction_hysteresis` it is what
//! a faster ramp adds to the loop: a loop of the swing A at the rate w takes 2 Tf A more. w is the mean rate since the reading before
//! times what is left of the torque's rate at the reading ([`Row::rate_share`]): nothing where it turns slowly. Without time
//! since the reading before, as at the first of a run, it adds nothing.

use super::dual::Dual;
use super::friction_hysteresis::dahl;
use super::friction_limit;
use super::port::{Action, Friction, Load, Row};
use super::spec::{Class, Parameter, Port, Reducers, Spec};
use crate::units::{ARCSEC, Quantity};

/// The effect.
pub static SPEC: Spec = Spec {
    id: "rate_friction",
    class: Class::Effect,
    port: Port::Load,
    reducers: Reducers::All,
    equation: "M_mesh = M0 - Tf, Tf = (mu_T N_Z + T0) sgn(w) (1 - exp(-|w|/w0)), w the rate of the total angle",
    source: "limiting shear stress of a lubricant: Bair and Winer, J. Lubrication Technology 101 (1979) 258",
    tell_tale: "loading and unloading form a loop that is wider where the torque changes faster, and vanishes where it changes slowly",
    parameters: &[
        friction_limit::RADIUS,
        Parameter::shape(
            "reference_rate",
            Quantity::AnglePerTime,
            ARCSEC,
            "rate w0 above which the friction grows no more",
        )
        .within(1e-6 * ARCSEC, 1e9 * ARCSEC)
        .likely(1e-2 * ARCSEC, 1e2 * ARCSEC)
        .log()
        .shown("arcsec_per_s"),
        friction_limit::TORQUE,
    ],
    twins: &[],
    action: Action::Load(act),
};

fn act(own: &[Dual], row: &Row, load: &mut Load) {
    let none = Dual::constant(0.0);
    // What a run has of frictions is the same at all of its readings, whether time has passed or not.
    let timeless = Friction {
        law: without_memory,
        radius_m: none,
        engagement_angle_rad: Dual::constant(1.0),
        exponent: Dual::constant(1.0),
        torque_Nm: none,
        load_share: none,
        helps: false,
    };
    load.friction.push(if row.step_time_s > 0.0 && row.rate_share > 0.0 {
        Friction {
            radius_m: own[0],
            torque_Nm: own[2],
            engagement_angle_rad: own[1] * (row.step_time_s / row.rate_share),
            ..timeless
        }
    } else {
        timeless
    });
}

/// Dahl's law from no torque: 1 - exp(-|w|/w0), as a way over a time is a rate.
fn without_memory(_: f64, way_rad: f64, engagement_angle_rad: f64, exponent: f64) -> (f64, [f64; 4]) {
    let (share, [by_way, _, by_angle, _]) = dahl(0.0, way_rad, engagement_angle_rad, exponent);
    (share, [by_way, 0.0, by_angle, 0.0])
}

#[cfg(test)]
#[allow(clippy::float_cmp)] // where nothing is rounded
mod tests {
    use super::*;
    use crate::effect::testing::{ROW, assert_close, vanishes};

    /// The friction torque after a way at a rate, from a state before that must not matter.
    fn torque_Nm(rate_rad_per_s: f64, step_time_s: f64, rate_share: f64) -> f64 {
        let zero = Dual::constant(0.0);
        let mut load = Load {
            torque_Nm: zero,
            preload_N: Dual::constant(500.0),
            spring_N_per_m: zero,
            friction: Vec::new(),
        };
        act(&[1e-3, 2e-5, 1.5].map(Dual::constant), &Row { step_time_s, rate_share, ..ROW }, &mut load);
        let friction = load.friction[0];
        let way = rate_rad_per_s * step_time_s;
        friction.limit_Nm(&load).value * friction.after(0.7, way).0
    }

    /// 2 N m at most; at the rate w0 ln 2 half of it, however the reading is timed.
    #[test]
    fn it_follows_the_rate() {
        let half = 2e-5 * 2_f64.ln();
        for time_s in [0.5, 8.0] {
            assert_close(torque_Nm(half, time_s, 1.0), 1.0);
            assert_close(torque_Nm(-half, time_s, 1.0), -1.0);
        }
        assert!((torque_Nm(1.0, 3.0, 1.0) - 2.0).abs() < 1e-12);
        let slow = torque_Nm(2e-10, 3.0, 1.0);
        assert!((slow / 2e-5 - 1.0).abs() < 1e-4, "viscous far below w0: {slow}");
    }

    #[test]
    fn where_the_torque_slows_down_there_is_less_of_it() {
        let half = 2e-5 * 2_f64.ln();
        assert_close(torque_Nm(2.0 * half, 3.0, 0.5), 1.0);
        assert_eq!(torque_Nm(half, 3.0, 0.0), 0.0);
    }

    #[test]
    fn without_time_it_adds_nothing() {
        assert_eq!(torque_Nm(1.0, 0.0, 1.0), 0.0);
    }

    #[test]
    fn it_vanishes() {
        vanishes(&SPEC);
    }
}
