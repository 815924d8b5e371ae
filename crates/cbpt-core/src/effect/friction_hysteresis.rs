//! Friction that resists the rotation of the output and depends on the history of the run.
//!
//! The meshing points carry M0 - Tf. Tf = Tf0 z with the limit Tf0 = mu_T N_Z + T0 + c |M0|: a part that follows the
//! preload, one that follows neither, and one that follows the load. dz/dalpha = (1 - sgn(dalpha) z)/alpha_p
//! on the total angle (meshing points and what stands in series), z = 0 in the unloaded state in which a history starts.
//! Between readings alpha moves one way, so z follows in closed form: with s the sense of rotation
//! z2 = s - (s - z1) exp(-|dalpha|/alpha_p).

use super::dual::Dual;
use super::friction_limit;
use super::port::{Action, Friction, Load, Row};
use super::spec::{Class, Parameter, Port, Reducers, Spec};
use crate::units::{ARCSEC, Quantity};

/// The effect.
pub static SPEC: Spec = Spec {
    id: "friction_hysteresis",
    class: Class::Effect,
    port: Port::Load,
    reducers: Reducers::All,
    equation: "M_mesh = M0 - Tf, dTf/dalpha = (Tf0/alpha_p)(1 - sgn(dalpha) Tf/Tf0), Tf0 = mu_T N_Z + T0 + c |M0|",
    source: "Dahl, A Solid Friction Model, Aerospace Corporation TOR-0158(3107-18)-1 (1968)",
    tell_tale: "loading and unloading form a loop, which is wider at higher preload if mu_T is not 0; the first loading of a run looks stiffer",
    parameters: &[friction_limit::RADIUS, ENGAGEMENT_ANGLE, friction_limit::TORQUE, friction_limit::LOAD],
    twins: &[],
    action: Action::Load(act),
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

fn act(own: &[Dual], _: &Row, load: &mut Load) {
    load.friction.push(Friction {
        law: dahl,
        radius_m: own[0],
        engagement_angle_rad: own[1],
        torque_Nm: own[2],
        load_share: own[3],
        helps: false,
    });
}

/// z after the rotation `way_rad` from `before`, and its derivatives by the way, by `before` and by alpha_p.
pub fn dahl(before: f64, way_rad: f64, engagement_angle_rad: f64) -> (f64, [f64; 3]) {
    let sense = if way_rad < 0.0 { -1.0 } else { 1.0 };
    let share = way_rad.abs() / engagement_angle_rad;
    let left = (-share).exp();
    let rest = (sense - before) * left;
    let by_way = sense * rest / engagement_angle_rad;
    (sense - rest, [by_way, left, -by_way * way_rad / engagement_angle_rad])
}

#[cfg(test)]
#[allow(clippy::float_cmp)] // where nothing is rounded
mod tests {
    use super::*;
    use crate::effect::testing::{assert_close, vanishes};

    /// Virgin loading is 1 - exp(-way/alpha_p); a way back is the solution of the differential equation, here by its own
    /// slope in small steps.
    #[test]
    fn it_follows_dahl() {
        let (loaded, _) = dahl(0.0, 3e-5, 2e-5);
        assert_close(loaded, 1.0 - (-1.5_f64).exp());
        let steps = 100_000;
        let mut by_steps = loaded;
        for _ in 0..steps {
            let way = -5e-5 / f64::from(steps);
            let middle = by_steps + 0.5 * way * (1.0 + by_steps) / 2e-5;
            by_steps += way * (1.0 + middle) / 2e-5;
        }
        assert!((dahl(loaded, -5e-5, 2e-5).0 - by_steps).abs() < 1e-9);
    }

    #[test]
    fn its_derivatives_are_exact() {
        let (before, angle) = (0.3, 2e-5);
        for way in [3e-5, -1e-5] {
            let (_, [by_way, by_before, by_angle]) = dahl(before, way, angle);
            let difference = |f: &dyn Fn(f64) -> f64, h: f64| (f(h) - f(-h)) / (2.0 * h);
            let close = |a: f64, b: f64| assert!((a / b - 1.0).abs() < 1e-7, "{a} {b}");
            close(by_way, difference(&|h| dahl(before, way + h, angle).0, 1e-9));
            close(by_before, difference(&|h| dahl(before + h, way, angle).0, 1e-5));
            close(by_angle, difference(&|h| dahl(before, way, angle + h).0, 1e-9));
        }
    }

    #[test]
    fn it_vanishes() {
        vanishes(&SPEC);
    }
}
