//! Friction that is larger when the rotation begins than when it goes on.
//!
//! Two of Dahl's elements: Tf = L ((1 + b) `z_1` - b `z_2`), `z_1` over the angle `alpha_p`, `z_2` over r `alpha_p`. After a reversal the
//! torque rises with `z_1`, peaks, and falls to L as `z_2` follows; it depends on the way alone, not on the rate. From rest the
//! peak lies at w* = `alpha_p` r/(r - 1) ln(r (1 + b)/b); b = 0 is `friction_hysteresis`. A loop of the amplitude A takes the energy
//! 4 L ((1 + b)(A - `alpha_p` tanh(A/`alpha_p`)) - b (A - r `alpha_p` tanh(A/(r `alpha_p`)))). Where it falls faster than the members
//! stiffen, the angle jumps: the member sticks and slips. See [`crate::predict`] for which solution is then the one reached.

use super::dual::Dual;
use super::friction_hysteresis::{ENGAGEMENT_ANGLE, dahl};
use super::friction_limit;
use super::port::{Action, Friction};
use super::spec::{Class, Parameter, Port, Reducers, Spec};
use crate::units::Quantity;

/// The effect.
pub static SPEC: Spec = Spec {
    id: "breakaway_friction",
    class: Class::Effect,
    port: Port::Load,
    reducers: Reducers::All,
    equation: "M_mesh = M0 - Tf, Tf = (mu_T N_Z + T0)((1 + b) z_1 - b z_2), dz/dalpha = (1 - sgn(dalpha) z)/a with a = alpha_p and r alpha_p",
    source: "Bliman and Sorine, Easy-to-use realistic dry friction models for automatic control, Proc. 3rd European Control Conf. (1995) 3788",
    tell_tale: "after each reversal the angle holds, then moves by a step, or jumps, under a torque that is larger than the one that moves it on",
    parameters: &[
        friction_limit::RADIUS,
        ENGAGEMENT_ANGLE,
        friction_limit::TORQUE,
        Parameter::shape(
            "breakaway_share",
            Quantity::Number,
            0.5,
            "share b of that torque that builds up beside it and is lost again",
        )
        .within(0.0, 100.0)
        .likely(0.02, 3.0)
        .log(),
        Parameter::shape(
            "weakening_ratio",
            Quantity::Number,
            5.0,
            "ratio r of the angle over which that share is lost to the engagement angle",
        )
        .within(1.0, 1e4)
        .likely(1.5, 50.0)
        .log(),
    ],
    twins: &[],
    action: Action::Friction(act),
};

fn act(own: &[Dual]) -> Vec<Friction> {
    let [radius_m, engagement_rad, torque_Nm, share, ratio] = [own[0], own[1], own[2], own[3], own[4]];
    let part = |of: Dual, engagement_angle_rad, helps| Friction {
        law: dahl,
        radius_m: radius_m * of,
        torque_Nm: torque_Nm * of,
        load_share: Dual::constant(0.0),
        engagement_angle_rad,
        exponent: Dual::constant(1.0),
        helps,
    };
    vec![part(share + 1.0, engagement_rad, false), part(share, engagement_rad * ratio, true)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effect::testing::{assert_close, load, vanishes};

    const RAD: f64 = 1e-4;

    /// The torque on a way, from rest or from a rotation that has gone on the other way for long; 2 N m at last.
    fn torque_Nm(way_rad: f64, before: f64) -> f64 {
        let load = load(&SPEC, &[1e-3, RAD, 1.4, 0.75, 4.0]);
        let law = |part: &Friction| part.after(before, way_rad).0;
        load.friction.iter().map(|part| part.limit_Nm(&load).value * law(part)).sum()
    }

    /// (1.75 (1 - exp(-w)) - 0.75 (1 - exp(-w/4))) 2 N m; 600 N at 1 mm and 1.4 N m make the 2 N m.
    #[test]
    fn it_builds_up_peaks_and_falls() {
        assert_close(torque_Nm(RAD, 0.0), 2.0 * (1.75 * -(-1.0_f64).exp_m1() - 0.75 * -(-0.25_f64).exp_m1()));
        let peak = RAD * 4.0 / 3.0 * (4.0 * 1.75 / 0.75_f64).ln();
        for before in [0.0, -1.0] {
            let top = torque_Nm(peak, before);
            let grown = (1.0 - before) * 2.0;
            let (quick, slow) = ((-peak / RAD).exp(), (-peak / RAD / 4.0).exp());
            assert_close(top, 2.0 - grown * (1.75 * quick - 0.75 * slow));
            assert!(top > torque_Nm(peak * 0.99, before) && top > torque_Nm(peak * 1.01, before));
        }
        assert!((torque_Nm(100.0 * RAD, 0.0) - 2.0).abs() < 1e-9);
    }

    /// The quicker part always outweighs the one that helps, so friction resists at first whatever its shape.
    #[test]
    fn it_resists_from_the_first() {
        for (share, ratio) in [(0.0, 1.0), (100.0, 1.0), (100.0, 1e4), (0.5, 3.0)] {
            let load = load(&SPEC, &[0.0, RAD, 1.0, share, ratio]);
            let slope = |part: &Friction| part.limit_Nm(&load).value / part.engagement_angle_rad.value;
            assert!(load.friction.iter().map(slope).sum::<f64>() > 0.0, "{share} {ratio}");
        }
    }

    #[test]
    fn it_vanishes() {
        vanishes(&SPEC);
    }
}
