//! Drift of the zero with time or temperature.
//!
//! The instrument shows alpha + c t or alpha + c (T_p - T0), t and T0 from the first reading. T_p is the measured temperature,
//! or that of a part which follows it with a time constant ([`super::lag`]).

use super::dual::Dual;
use super::lag::time_constant;
use super::port::{Action, Row};
use super::spec::{Class, Parameter, Port, Reducers, Spec};
use crate::units::Quantity;

/// The effect.
pub static SPEC: Spec = Spec {
    id: "drift",
    class: Class::Rig,
    port: Port::Reading,
    reducers: Reducers::All,
    equation: "reading = alpha + c_t t + c_T (T_p - T0), where T0 is the first temperature of the table and tau dT_p/dt = T - T_p",
    source: "zero drift as sensors' data sheets state it",
    tell_tale: "the residual follows time or temperature and does not depend on load",
    parameters: &[
        Parameter::size("rate", Quantity::AnglePerTime, "drift c_t with time")
            .within(-1e-2, 1e-2)
            .likely(-1e-7, 1e-7),
        Parameter::size("rate", Quantity::AnglePerTemperature, "drift c_T with temperature")
            .within(-1e-2, 1e-2)
            .likely(-3e-5, 3e-5),
        time_constant(),
    ],
    twins: &[],
    action: Action::ThermalReading(2, act),
};

fn act(own: &[Dual], row: &Row, part_temperature_K: Dual, angle_rad: Dual) -> Dual {
    angle_rad + own[0] * row.time_s + own[1] * part_temperature_K
}

#[cfg(test)]
#[allow(clippy::float_cmp)] // where nothing is rounded
mod tests {
    use super::*;
    use crate::effect::testing::{assert_close, reading, vanishes};

    /// 500 s and 3 K.
    #[test]
    fn it_goes_with_time_and_temperature() {
        assert_close(reading(&SPEC, &[1e-9, 2e-6, 0.0], 1e-4), 1e-4 + 5e-7 + 6e-6);
    }

    #[test]
    fn it_vanishes() {
        vanishes(&SPEC);
    }
}
