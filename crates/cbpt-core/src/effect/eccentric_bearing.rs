//! Yielding of the eccentric bearing that carries the deceleration pair's force across the line of centres.
//!
//! F = M0/(Zo e), u = u_ref (|F|/100 N)^q, alpha += sgn(M0) u/(Zo e): q = 0.9 for rollers, 2/3 for balls.

use super::dual::Dual;
use super::port::{Action, DriveNumbers, Row};
use super::spec::{Class, Parameter, Port, Reducers, Spec};
use crate::units::Quantity;

/// Force at which the deflection is the reference one, N.
const REFERENCE_FORCE_N: f64 = 100.0;

/// The effect.
pub static SPEC: Spec = Spec {
    id: "eccentric_bearing",
    class: Class::Effect,
    port: Port::Series,
    reducers: Reducers::AllByRadius,
    equation: "alpha += sgn(M0) u/(Zo e), u = u_ref (|F|/100 N)^q, F = M0/(Zo e)",
    source: "Palmgren, Ball and Roller Bearing Engineering (1959): exponents 2/3 for balls, 0.9 for rollers",
    tell_tale: "the residual grows with torque and does not depend on preload",
    parameters: &[
        Parameter::size("reference_deflection", Quantity::Length, "deflection u_ref at a force of 100 N")
            .within(0.0, 1e-3)
            .likely(0.02e-6, 20e-6)
            .log(),
        Parameter::shape("exponent", Quantity::Number, 0.9, "exponent q: 0.9 for rollers, 2/3 for balls")
            .within(0.5, 1.0)
            .likely(0.6, 1.0),
    ],
    twins: &[],
    action: Action::Series(act),
};

fn act(own: &[Dual], _: &Row, drive: &DriveNumbers, torque_Nm: Dual) -> Dual {
    let force = torque_Nm.abs() * (1.0 / (drive.pitch_arm_m * REFERENCE_FORCE_N));
    own[0] * force.powf(&own[1]) * (torque_Nm.value.signum() / drive.pitch_arm_m)
}

#[cfg(test)]
#[allow(clippy::float_cmp)] // where nothing is rounded
mod tests {
    use super::*;
    use crate::effect::testing::{assert_close, series, vanishes};

    /// 4 N m at an arm of 40 mm are 100 N, 8 N m are 200 N; the deflection turns the output by u/arm, with the torque.
    #[test]
    fn it_yields_with_a_power_of_the_force() {
        assert_close(series(&SPEC, &[1e-6, 0.9], 4.0), 1e-6 / 0.04);
        assert_close(series(&SPEC, &[1e-6, 0.9], -8.0), -1e-6 * 2_f64.powf(0.9) / 0.04);
        assert_eq!(series(&SPEC, &[1e-6, 0.9], 0.0), 0.0);
    }

    #[test]
    fn it_vanishes() {
        vanishes(&SPEC);
    }
}
