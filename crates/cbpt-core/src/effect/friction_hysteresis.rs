//! Friction that resists the rotation of the output and depends on the history of the run.
//!
//! The meshing points carry M0 - Tf. Tf = Tf0 z with the limit Tf0 = mu_T N_Z + T0 + c |M0|: a part that follows the
//! preload, one that follows neither, and one that follows the load. With s = sgn(dalpha), dz/dalpha = (1 - s z)^i/alpha_p
//! on the total angle (meshing points and what stands in series), z = 0 in the unloaded state in which a history starts. The
//! exponent i says how the limit is reached: 1 exponentially, 0 like a spring that slips (Prandtl, Jenkin), and in between at
//! the finite angle alpha_p/(1 - i) from rest.
//! Between readings alpha moves one way, so z follows in closed form: with r = 1 - s z what is left to the limit and
//! q = 1 - i, r2^q = r1^q - q |dalpha|/alpha_p, and r2 = r1 exp(-|dalpha|/alpha_p) at q = 0.

use super::dual::Dual;
use super::friction_limit;
use super::port::{Action, Friction};
use super::spec::{Class, Parameter, Port, Reducers, Spec};
use crate::units::{ARCSEC, Quantity};

/// The effect.
pub static SPEC: Spec = Spec {
    id: "friction_hysteresis",
    class: Class::Effect,
    port: Port::Load,
    reducers: Reducers::All,
    equation: "M_mesh = M0 - Tf, dTf/dalpha = (Tf0/alpha_p)(1 - sgn(dalpha) Tf/Tf0)^i, Tf0 = mu_T N_Z + T0 + c |M0|",
    source: "Dahl, A Solid Friction Model, Aerospace Corporation TOR-0158(3107-18)-1 (1968)",
    tell_tale: "loading and unloading form a loop, which is wider at higher preload if mu_T is not 0; the first loading of a run looks stiffer",
    parameters: &[
        friction_limit::RADIUS,
        ENGAGEMENT_ANGLE,
        friction_limit::TORQUE,
        friction_limit::LOAD,
        Parameter::shape(
            "build_up_exponent",
            Quantity::Number,
            1.0,
            "exponent i by which the friction builds up; 1: exponentially, 0: like a spring that slips",
        )
        .within(0.0, 3.0)
        .likely(0.0, 1.0),
    ],
    twins: &[],
    action: Action::Friction(act),
};

/// Angle over which the friction builds up after a reversal.
pub(super) const ENGAGEMENT_ANGLE: Parameter = Parameter::shape(
    "engagement_angle",
    Quantity::Angle,
    10.0 * ARCSEC,
    "angle alpha_p over which the friction builds up",
)
.within(1e-3 * ARCSEC, 1e6 * ARCSEC)
.likely(0.3 * ARCSEC, 60.0 * ARCSEC)
.log();

fn act(own: &[Dual]) -> Vec<Friction> {
    vec![Friction {
        law: dahl,
        radius_m: own[0],
        engagement_angle_rad: own[1],
        torque_Nm: own[2],
        load_share: own[3],
        exponent: own[4],
        helps: false,
    }]
}

/// Nearer to 1 the exponent is 1.
const EXPONENTIAL: f64 = 1e-9;

/// z after the rotation `way_rad` from `before`, and its derivatives by the way, by `before`, by alpha_p and by the exponent.
pub fn dahl(before: f64, way_rad: f64, engagement_angle_rad: f64, exponent: f64) -> (f64, [f64; 4]) {
    let sense = if way_rad < 0.0 { -1.0 } else { 1.0 };
    let share = way_rad.abs() / engagement_angle_rad;
    let left = 1.0 - sense * before;
    let q = 1.0 - exponent;
    let exponential = q.abs() < EXPONENTIAL;
    if left <= 0.0 {
        // On its limit, which exponential friction leaves behind as slowly as it comes there.
        let by_before = if exponential { (-share).exp() } else { 0.0 };
        return (sense - (sense - before) * by_before, [0.0, by_before, 0.0, 0.0]);
    }
    let log_left = left.ln();
    if exponential {
        let by_before = (-share).exp();
        let rest = left * by_before;
        let by_way = rest / engagement_angle_rad;
        let by_exponent = share * (log_left - 0.5 * share);
        let by_angle = -by_way * way_rad / engagement_angle_rad;
        return (sense * (1.0 - rest), [by_way, by_before, by_angle, sense * rest * by_exponent]);
    }
    // The way in shares of the angle over which what is left builds up.
    let local = share * (-q * log_left).exp();
    let slipped = q * local;
    if slipped >= 1.0 {
        return (sense, [0.0; 4]);
    }
    let (g, g_slope) = log_series(slipped);
    let log_gone = -local * g;
    let rest = left * log_gone.exp();
    let by_way = (exponent * (log_left + log_gone)).exp() / engagement_angle_rad;
    let by_exponent = local * log_left * g - local * local * (1.0 - q * log_left) * g_slope;
    (
        sense * (1.0 - rest),
        [
            by_way,
            (exponent * log_gone).exp(),
            -by_way * way_rad / engagement_angle_rad,
            sense * rest * by_exponent,
        ],
    )
}

/// -ln(1 - u)/u and its derivative, for u < 1; by their series near 0.
fn log_series(u: f64) -> (f64, f64) {
    if u.abs() < 1e-3 {
        let value = 1.0 + u * (1.0 / 2.0 + u * (1.0 / 3.0 + u * (1.0 / 4.0 + u / 5.0)));
        return (value, 1.0 / 2.0 + u * (2.0 / 3.0 + u * (3.0 / 4.0 + u * 4.0 / 5.0)));
    }
    let log = (-u).ln_1p();
    (-log / u, (u / (1.0 - u) + log) / (u * u))
}

#[cfg(test)]
#[allow(clippy::float_cmp)] // where nothing is rounded
mod tests {
    use super::*;
    use crate::effect::distributed_friction::jenkin;
    use crate::effect::testing::{assert_close, vanishes};

    const ANGLE: f64 = 2e-5;

    /// Virgin loading is 1 - exp(-way/alpha_p); a way back is the solution of the differential equation, here by its own
    /// slope in small steps.
    #[test]
    fn it_follows_dahl() {
        assert_close(dahl(0.0, 3e-5, ANGLE, 1.0).0, 1.0 - (-1.5_f64).exp());
        for (exponent, way) in [(1.0, -5e-5), (0.5, -4e-5), (0.2, -3e-5), (1.5, -5e-5)] {
            let loaded = dahl(0.0, 3e-5, ANGLE, exponent).0;
            let steps = 100_000;
            let mut by_steps = loaded;
            for _ in 0..steps {
                let step = way / f64::from(steps);
                let slope = |z: f64| (1.0 + z).powf(exponent) / ANGLE;
                let middle = by_steps + 0.5 * step * slope(by_steps);
                by_steps += step * slope(middle);
            }
            let found = dahl(loaded, way, ANGLE, exponent).0;
            assert!((found - by_steps).abs() < 1e-8, "{exponent}: {found} {by_steps}");
        }
    }

    /// A way in two parts is the way; the limit is reached at alpha_p/(1 - i) and kept.
    #[test]
    fn it_remembers_its_state_alone_and_keeps_to_its_limit() {
        for exponent in [0.0, 0.3, 1.0, 1.7] {
            for before in [-1.0, 0.4] {
                let middle = dahl(before, 1e-5, ANGLE, exponent).0;
                assert_close(
                    dahl(middle, 0.5e-5, ANGLE, exponent).0,
                    dahl(before, 1.5e-5, ANGLE, exponent).0,
                );
            }
        }
        assert!(dahl(0.0, 0.99 * ANGLE / 0.7, ANGLE, 0.3).0 < 1.0);
        assert_eq!(dahl(0.0, 1.01 * ANGLE / 0.7, ANGLE, 0.3).0, 1.0);
        assert_eq!(dahl(1.0, ANGLE, ANGLE, 0.3).0, 1.0);
    }

    /// A spring that slips.
    #[test]
    fn exponent_0_is_jenkins_element() {
        for (before, way) in [(0.3, 1e-5), (0.3, -2e-5), (-0.9, 5e-5), (1.0, -1e-5)] {
            let (z, slopes) = dahl(before, way, ANGLE, 0.0);
            let (spring, of_spring) = jenkin(before, way, ANGLE, 0.0);
            assert!((z - spring).abs() < 1e-15, "{before} {way}");
            for (one, other) in slopes.into_iter().zip(of_spring).take(3) {
                assert!((one - other).abs() <= 1e-12 * other.abs(), "{before} {way}");
            }
        }
    }

    #[test]
    fn its_derivatives_are_exact() {
        let before = 0.3;
        for exponent in [1.0, 1.0 + 1e-7, 0.6, 0.1, 1.8] {
            for way in [1.2e-5, -1e-5] {
                let (_, [by_way, by_before, by_angle, by_exponent]) = dahl(before, way, ANGLE, exponent);
                let difference = |f: &dyn Fn(f64) -> f64, h: f64| (f(h) - f(-h)) / (2.0 * h);
                let close = |a: f64, b: f64| assert!((a / b - 1.0).abs() < 1e-6, "{exponent} {way}: {a} {b}");
                close(by_way, difference(&|h| dahl(before, way + h, ANGLE, exponent).0, 1e-9));
                close(by_before, difference(&|h| dahl(before + h, way, ANGLE, exponent).0, 1e-5));
                close(by_angle, difference(&|h| dahl(before, way, ANGLE + h, exponent).0, 1e-9));
                close(by_exponent, difference(&|h| dahl(before, way, ANGLE, exponent + h).0, 1e-5));
            }
        }
    }

    #[test]
    fn it_vanishes() {
        vanishes(&SPEC);
    }
}
