//! Drift of the ratio of angle to torque, with time or temperature.
//!
//! The angle is alpha (1 + s_t t + s_T (T - T0)), t and T0 from the first reading: the span of the angle sensor, or the stiffness of
//! the reducer, is not what it was. The readings of one campaign do not tell which.

use super::dual::Dual;
use super::port::{Action, Row};
use super::spec::{Class, Parameter, Port, Reducers, Spec};
use crate::units::Quantity;

/// The effect.
pub static SPEC: Spec = Spec {
    id: "span_drift",
    class: Class::Effect,
    port: Port::Reading,
    reducers: Reducers::All,
    equation: "reading = alpha (1 + s_t t + s_T (T - T0)), where T0 is the first temperature of the table",
    source: "drift of span as sensors' data sheets state it; softening with temperature: Young's modulus of polymers and metals",
    tell_tale: "the residual is a share of the angle that follows time or temperature; a sensor's span and a stiffness that drift look the same",
    parameters: &[
        Parameter::size("rate", Quantity::PerTime, "drift s_t with time, a share of the angle")
            .within(-1.0, 1.0)
            .likely(-1e-4, 1e-4),
        Parameter::size("rate", Quantity::PerTemperature, "drift s_T with temperature, a share of the angle")
            .within(-1.0, 1.0)
            .likely(-0.03, 0.03),
    ],
    twins: &[],
    action: Action::Reading(act),
};

fn act(own: &[Dual], row: &Row, angle_rad: Dual) -> Dual {
    angle_rad * (own[0] * row.time_s + own[1] * row.temperature_difference_K + 1.0)
}

#[cfg(test)]
#[allow(clippy::float_cmp)] // where nothing is rounded
mod tests {
    use super::*;
    use crate::effect::testing::{assert_close, reading, vanishes};

    /// 500 s and 3 K.
    #[test]
    fn it_goes_with_time_and_temperature() {
        assert_close(reading(&SPEC, &[2e-5, 1e-3], 1e-4), 1e-4 * (1.0 + 0.01 + 0.003));
    }

    #[test]
    fn it_vanishes() {
        vanishes(&SPEC);
    }
}
