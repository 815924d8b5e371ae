//! Torsion of the output shaft or of a joint behind it.
//!
//! alpha += c J(M0) (1 + a sgn M0) (N_ref/N_Z)^p, c = 1/k_t, N_ref = 500 N. A plain shaft has J = M0, a = p = 0. A joint may
//! - be stiffer one way (a): a key or a claw has a flank for each sense. Preloaded ball contacts cannot: at no torque both
//!   senses load all of them, so their stiffness there is one number;
//! - be clamped by the preload (p): p = 1/3 for one smooth contact (Mindlin), 1 for rough faces, as far as they slip by little;
//! - stiffen with the torque (h): k_t (1 + h |M0|), so J = sgn(M0) ln(1 + h |M0|)/h;
//! - come to a stop (`M_s`): J stays as it is at `M_s`;
//! - open (`M_o`): clamped, it is rigid up to `M_o`, and |M0| - `M_o` takes the place of |M0|.

use super::dual::Dual;
use super::port::{Action, DriveNumbers, Row};
use super::spec::{Class, Parameter, Port, Reducers, Spec};
use crate::units::Quantity;

/// Preload at which a joint that it clamps has its stated compliance, N.
const REFERENCE_PRELOAD_N: f64 = 500.0;
/// A stop that is never reached, N m.
const NO_STOP_NM: f64 = 1e9;

/// The effect.
pub static SPEC: Spec = Spec {
    id: "output_torsion",
    class: Class::Effect,
    port: Port::Series,
    reducers: Reducers::All,
    equation: "alpha += (J/k_t) (1 + a sgn M0) (500 N/N_Z)^p, J = M0; of a joint J = sgn(M0) ln(1 + h |M0|)/h, up to |M0| = M_s; |M0| - M_o for |M0| where it opens at M_o",
    source: "torsion of an elastic shaft; stiffness of a clamped joint: Mindlin, J. Appl. Mech. 16 (1949) 259 (p = 1/3), Greenwood and Williamson, Proc. R. Soc. A 295 (1966) 300 (p = 1); a clamped joint opens at a load: Bickford, An Introduction to the Design and Behavior of Bolted Joints (CRC Press)",
    tell_tale: "the residual is proportional to torque, does not depend on preload and has no loop; of a joint it differs by the sign of the torque, falls with the preload, levels off, or begins at a torque",
    parameters: &[
        Parameter::size("compliance", Quantity::AnglePerTorque, "torsional compliance 1/k_t")
            .within(0.0, 1.0)
            .likely(1e-7, 1e-4)
            .log(),
        Parameter::shape(
            "asymmetry",
            Quantity::Number,
            0.0,
            "share a by which it is softer under positive torque and stiffer under negative",
        )
        .within(-1.0, 1.0)
        .likely(-1.0, 1.0),
        Parameter::shape(
            "preload_exponent",
            Quantity::Number,
            0.0,
            "exponent p of the compliance's fall with the preload",
        )
        .within(0.0, 3.0)
        .likely(0.3, 1.0),
        Parameter::shape("stiffening", Quantity::PerTorque, 0.0, "growth h of the stiffness with the torque")
            .within(0.0, 1e6)
            .likely(1e-3, 10.0)
            .log(),
        Parameter::shape(
            "stop_torque",
            Quantity::Torque,
            NO_STOP_NM,
            "torque M_s at which the joint comes to a stop, beyond the one at which it opens",
        )
        .within(1e-9, 1e12)
        .likely(1e-3, 1e3)
        .log(),
        Parameter::shape("opening_torque", Quantity::Torque, 0.0, "torque M_o from which on the joint gives")
            .within(0.0, 1e9)
            .likely(1e-3, 1e3),
    ],
    twins: &[],
    action: Action::Series(act),
};

fn act(own: &[Dual], row: &Row, _: &DriveNumbers, torque_Nm: Dual) -> Dual {
    let [compliance, asymmetry, exponent, stiffening, stop_Nm, opening_Nm] =
        [own[0], own[1], own[2], own[3], own[4], own[5]];
    let mut angle = compliance * wound(beyond(torque_Nm, &opening_Nm), &stiffening, &stop_Nm);
    if acts(&asymmetry) {
        let sign = if torque_Nm.value < 0.0 { -1.0 } else { 1.0 };
        angle *= asymmetry * sign + 1.0;
    }
    if acts(&exponent) {
        let loosened = REFERENCE_PRELOAD_N / row.preload_N;
        let factor = loosened.powf(exponent.value);
        angle *= exponent.chain(factor, factor * loosened.ln());
    }
    angle
}

/// A shape that is not 0, or whose derivative is wanted.
fn acts(shape: &Dual) -> bool {
    *shape != Dual::constant(0.0)
}

/// What is left of the torque beyond the one at which the joint opens.
fn beyond(torque_Nm: Dual, opening_Nm: &Dual) -> Dual {
    if torque_Nm.value.abs() < opening_Nm.value {
        return Dual::constant(0.0);
    }
    if torque_Nm.value < 0.0 { torque_Nm + *opening_Nm } else { torque_Nm - *opening_Nm }
}

/// J: what the torque winds up, over the compliance, N m.
fn wound(torque_Nm: Dual, stiffening: &Dual, stop_Nm: &Dual) -> Dual {
    let sign = if torque_Nm.value < 0.0 { -1.0 } else { 1.0 };
    let carried = if torque_Nm.value.abs() > stop_Nm.value { *stop_Nm * sign } else { torque_Nm };
    if !acts(stiffening) {
        return carried;
    }
    let (torque, h) = (carried.value.abs(), stiffening.value);
    let x = h * torque;
    // ln(1 + x)/x and its derivative by x times torque^2, from their series where x is small.
    let (share, slope) = if x < 1e-4 {
        (1.0 - x / 2.0 + x * x / 3.0, -0.5 + x * (2.0 / 3.0))
    } else {
        let share = x.ln_1p() / x;
        (share, (1.0 / (1.0 + x) - share) / x)
    };
    let mut wound = carried.chain(carried.value * share, 1.0 / (1.0 + x));
    wound.add_slope(sign * torque * torque * slope, stiffening);
    wound
}

#[cfg(test)]
#[allow(clippy::float_cmp)] // where nothing is rounded
mod tests {
    use super::*;
    use crate::effect::testing::{assert_close, series, vanishes};

    const SHAFT: [f64; 6] = [1e-6, 0.0, 0.0, 0.0, NO_STOP_NM, 0.0];

    fn joint(change: [(usize, f64); 1], torque_Nm: f64) -> f64 {
        let mut own = SHAFT;
        for (place, value) in change {
            own[place] = value;
        }
        series(&SPEC, &own, torque_Nm)
    }

    #[test]
    fn it_is_linear_in_torque() {
        assert_eq!(series(&SPEC, &SHAFT, -3.0), -3e-6);
    }

    /// A share of 0.2 more one way, and as much less the other.
    #[test]
    fn its_flanks_may_differ() {
        assert_close(joint([(1, 0.2)], 3.0), 3.6e-6);
        assert_close(joint([(1, 0.2)], -3.0), -2.4e-6);
    }

    /// 600 N clamp it.
    #[test]
    fn the_preload_clamps_it() {
        assert_close(joint([(2, 0.5)], 3.0), 3e-6 * (500.0_f64 / 600.0).sqrt());
    }

    /// The angle is the integral of dM/(k (1 + h M)); beyond a stop it stays.
    #[test]
    fn it_stiffens_and_stops() {
        assert_close(joint([(3, 0.5)], -4.0), -1e-6 * 3.0_f64.ln() / 0.5);
        assert_close(joint([(3, 1e-7)], 4.0), 4e-6 * (1.0 - 2e-7 + 16e-14 / 3.0));
        assert_close(joint([(4, 2.5)], -4.0), -2.5e-6);
        assert_close(joint([(4, 2.5)], 2.0), 2e-6);
    }

    /// Below 2.5 N m it is rigid.
    #[test]
    fn it_opens() {
        assert_close(joint([(5, 2.5)], -4.0), -1.5e-6);
        assert_eq!(joint([(5, 2.5)], 2.0), 0.0);
    }

    #[test]
    fn its_derivatives_are_exact() {
        for (torque, h, stop) in [(4.0, 0.3, 9.0), (-4.0, 0.3, 9.0), (4.0, 1e-5, 9.0), (-4.0, 0.3, 2.0)] {
            let at = |torque: f64, h: f64, stop: f64| {
                wound(Dual::parameter(torque, 0), &Dual::parameter(h, 1), &Dual::parameter(stop, 2))
            };
            let exact = at(torque, h, stop).partials;
            let e = 1e-6;
            let difference = |d: [f64; 3]| {
                let by = |s: f64| at(torque + s * d[0], h + s * d[1], stop + s * d[2]).value;
                (by(e) - by(-e)) / (2.0 * e)
            };
            for (place, d) in [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].into_iter().enumerate() {
                assert!((exact[place] - difference(d)).abs() < 1e-7, "{torque} {h} {place}");
            }
        }
    }

    #[test]
    fn it_vanishes() {
        vanishes(&SPEC);
    }
}
