//! Friction of many contacts that slip one after another.
//!
//! Elements side by side, each a spring that slips at its own angle y (Jenkin; Iwan's parallel model). Elements that carry the
//! share (y/a)^(x + 2) of the largest torque slip before y; all have slipped after the angle a. The first loading is then
//! `Tf/Tf0` = ((x + 2) u - u^(x + 2))/(x + 1) with u = angle/a, at x = 0 a parabola; a way back is the same curve twice as large
//! (Masing); a loop of the amplitude u takes the energy 4 Tf0 a u^(x + 3)/(x + 3). `ELEMENTS` elements stand for all, at the
//! middles of even steps of y. Small loops inside large ones close, which those of `friction_hysteresis` do not. Its limit is as
//! there.

use super::dual::Dual;
use super::friction_limit;
use super::port::{Action, Friction};
use super::spec::{Class, Parameter, Port, Reducers, Spec};
use crate::units::{ARCSEC, Quantity};

/// The effect.
pub static SPEC: Spec = Spec {
    id: "distributed_friction",
    class: Class::Effect,
    port: Port::Load,
    reducers: Reducers::All,
    equation: "M_mesh = M0 - Tf, Tf the sum of elements that slip at angles y, of which those with the share (y/a)^(x + 2) of Tf0 slip before y <= a; Tf0 = mu_T N_Z + T0 + c |M0|",
    source: "Iwan, J. Appl. Mech. 33 (1966) 893; power law of the slip: Segalman, J. Appl. Mech. 72 (2005) 752; Masing, Proc. 2nd Int. Congr. Appl. Mech. (1926) 332",
    tell_tale: "loading and unloading form a loop whose branches bend from their reversal on, and smaller loops inside it close; small loops are narrower than in proportion",
    parameters: &[
        friction_limit::RADIUS,
        Parameter::shape(
            "slip_angle",
            Quantity::Angle,
            20.0 * ARCSEC,
            "angle a after which all contacts have slipped",
        )
        .within(1e-3 * ARCSEC, 1e6 * ARCSEC)
        .likely(1.0 * ARCSEC, 120.0 * ARCSEC)
        .log(),
        friction_limit::TORQUE,
        Parameter::shape(
            "slip_exponent",
            Quantity::Number,
            0.0,
            "exponent x of the density of the angles of slip; 0: all are alike frequent",
        )
        .within(-0.99, 20.0)
        .likely(-0.8, 2.0),
        friction_limit::LOAD,
    ],
    twins: &[],
    action: Action::Friction(act),
};

/// Elements that stand for all: the first loading is right to 0.3 % of the largest torque, and to 0.1 % where x >= 0.
const ELEMENTS: u32 = 24;

fn act(own: &[Dual]) -> Vec<Friction> {
    let [radius_m, slip_rad, torque_Nm, exponent, load_share] = [own[0], own[1], own[2], own[3], own[4]];
    let power = exponent.value + 2.0;
    // What slips before a share of the slip angle, and its derivative by the exponent.
    let before = |edge: f64| {
        let share = edge.powf(power);
        exponent.chain(share, if edge > 0.0 { share * edge.ln() } else { 0.0 })
    };
    let element = |element: u32| {
        let edge = |step: f64| (f64::from(element) + step) / f64::from(ELEMENTS);
        let share = before(edge(1.0)) - before(edge(0.0));
        Friction {
            law: jenkin,
            radius_m: radius_m * share,
            torque_Nm: torque_Nm * share,
            load_share: load_share * share,
            engagement_angle_rad: slip_rad * edge(0.5),
            exponent: Dual::constant(0.0),
            helps: false,
        }
    };
    (0..ELEMENTS).map(element).collect()
}

/// An element's torque over its limit after the rotation `way_rad` from `before`, and its derivatives by the way, by `before` and by
/// the angle at which it slips: `dahl` with the exponent 0, in less time.
pub fn jenkin(before: f64, way_rad: f64, slip_rad: f64, _: f64) -> (f64, [f64; 4]) {
    let stuck = before + way_rad / slip_rad;
    if stuck.abs() > 1.0 {
        return (1.0_f64.copysign(stuck), [0.0; 4]);
    }
    (stuck, [1.0 / slip_rad, 1.0, -way_rad / (slip_rad * slip_rad), 0.0])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effect::port::Load;
    use crate::effect::testing::vanishes;

    const SLIP_RAD: f64 = 1e-4;

    /// The torque on a way through these angles (shares of the slip angle), N m, 2 N m at most; at the end of each step.
    fn along(exponent: f64, angles: &[f64]) -> Vec<f64> {
        let own = [0.0, SLIP_RAD, 2.0, exponent, 0.0].map(Dual::constant);
        let zero = Dual::constant(0.0);
        let load = Load { torque_Nm: zero, preload_N: zero, spring_N_per_m: zero, friction: act(&own) };
        let mut states = vec![0.0; load.friction.len()];
        let mut at = 0.0;
        let mut torques = Vec::new();
        for &angle in angles {
            let mut torque = 0.0;
            for (state, friction) in states.iter_mut().zip(&load.friction) {
                let way = (angle - at) * SLIP_RAD;
                *state = friction.after(*state, way).0;
                torque += friction.limit_Nm(&load).value * *state;
            }
            at = angle;
            torques.push(torque);
        }
        torques
    }

    fn virgin(exponent: f64, u: f64) -> f64 {
        let u = u.min(1.0);
        2.0 * ((exponent + 2.0) * u - u.powf(exponent + 2.0)) / (exponent + 1.0)
    }

    #[test]
    fn the_first_loading_is_the_closed_form() {
        for exponent in [-0.5, 0.0, 1.0] {
            for u in [0.05, 0.3, 0.8, 1.0, 1.7] {
                let found = along(exponent, &[u])[0];
                assert!((found - virgin(exponent, u)).abs() < 4e-3, "{exponent} {u}: {found}");
            }
        }
    }

    /// Masing: the way back is the first loading twice as large; and a loop inside closes where it began.
    #[test]
    fn a_way_back_is_twice_the_first_loading_and_inner_loops_close() {
        let found = along(0.0, &[0.8, 0.2, 0.5, 0.2, -0.8]);
        assert!((found[0] - found[1] - 2.0 * virgin(0.0, 0.3)).abs() < 4e-3, "{found:?}");
        assert!((found[3] - found[1]).abs() < 1e-12, "{found:?}");
        assert!((found[4] + found[0]).abs() < 1e-12, "{found:?}");
    }

    /// The energy of a loop, 4 Tf0 a u^(x + 3)/(x + 3), and with all slipped 4 Tf0 a (u - 1 + 1/(x + 3)).
    #[test]
    fn the_energy_of_a_loop_is_the_closed_form() {
        for (exponent, u) in [(-0.5, 0.6), (0.0, 0.5), (0.0, 1.0), (1.0, 0.9), (0.0, 1.5)] {
            let steps = 4000;
            let leg = |from: f64, to: f64| {
                (1..=steps).map(move |i| from + (to - from) * f64::from(i) / f64::from(steps))
            };
            let angles: Vec<f64> = leg(0.0, u).chain(leg(u, -u)).chain(leg(-u, u)).collect();
            let torques = along(exponent, &angles);
            let start = angles.len() / 3 - 1;
            let energy: f64 = (start..angles.len() - 1)
                .map(|i| 0.5 * (torques[i] + torques[i + 1]) * (angles[i + 1] - angles[i]))
                .sum();
            let within = f64::min(u, 1.0);
            let expected = 8.0 * (within.powf(exponent + 3.0) / (exponent + 3.0) + (u - within));
            assert!((energy / expected - 1.0).abs() < 5e-3, "{exponent} {u}: {energy} {expected}");
        }
    }

    #[test]
    fn its_derivatives_are_exact() {
        for (before, way) in [(0.3, 2e-5), (-0.5, -1e-5), (0.9, 4e-5)] {
            let (_, exact) = jenkin(before, way, SLIP_RAD, 0.0);
            let by =
                |d: [f64; 3], s: f64| jenkin(before + s * d[0], way + s * d[1], SLIP_RAD + s * d[2], 0.0).0;
            for (place, (d, h)) in [([0.0, 1.0, 0.0], 1e-9), ([1.0, 0.0, 0.0], 1e-6), ([0.0, 0.0, 1.0], 1e-9)]
                .into_iter()
                .enumerate()
            {
                let difference = (by(d, h) - by(d, -h)) / (2.0 * h);
                assert!((exact[place] - difference).abs() <= 1e-4 * difference.abs(), "{before} {place}");
            }
        }
    }

    #[test]
    fn it_vanishes() {
        vanishes(&SPEC);
    }
}
