//! Drift of the zero with time or temperature.
//!
//! The instrument shows alpha + c t, alpha + c (T_p - T0) or alpha + z (1 - exp(-t/tau_w)), t and T0 from the first reading. T_p is
//! the measured temperature, or that of a part which follows it with a time constant ([`super::lag`]). The last one is a
//! warm-up whose temperature nobody measured: a body that is heated evenly comes to its end temperature that way.

use super::dual::Dual;
use super::lag::time_constant;
use super::port::{Action, Row};
use super::spec::{Class, Parameter, Port, Reducers, Spec};
use crate::units::{ARCSEC, Quantity};

/// The effect.
pub static SPEC: Spec = Spec {
    id: "drift",
    class: Class::Rig,
    port: Port::Reading,
    reducers: Reducers::All,
    equation: "reading = alpha + c_t t + c_T (T_p - T0) + z (1 - exp(-t/tau_w)), where T0 is the first temperature of the table and tau dT_p/dt = T - T_p",
    source: "zero drift and warm-up as sensors' data sheets state them; a heated body: Newton's law of cooling",
    tell_tale: "the residual follows time or temperature and does not depend on load",
    parameters: &[
        Parameter::size("rate", Quantity::AnglePerTime, "drift c_t with time")
            .within(-1e-2, 1e-2)
            .likely(-1e-7, 1e-7),
        Parameter::size("rate", Quantity::AnglePerTemperature, "drift c_T with temperature")
            .within(-1e-2, 1e-2)
            .likely(-3e-5, 3e-5),
        time_constant(),
        Parameter::size("warm_up", Quantity::Angle, "zero drift z until the instrument is warm")
            .within(-0.1, 0.1)
            .likely(-30.0 * ARCSEC, 30.0 * ARCSEC),
        Parameter::shape("warm_up_time", Quantity::Time, 600.0, "time tau_w over which it warms up")
            .within(1e-3, 1e7)
            .likely(60.0, 1e4)
            .log(),
    ],
    twins: &[],
    action: Action::ThermalReading(2, act),
};

fn act(own: &[Dual], row: &Row, part_temperature_K: Dual, angle_rad: Dual) -> Dual {
    let warm = own[4].settled(row.time_s);
    angle_rad + own[0] * row.time_s + own[1] * part_temperature_K + own[3] * warm
}

#[cfg(test)]
#[allow(clippy::float_cmp)] // where nothing is rounded
mod tests {
    use super::*;
    use crate::effect::testing::{assert_close, reading, vanishes};

    /// 500 s and 3 K.
    #[test]
    fn it_goes_with_time_and_temperature() {
        assert_close(reading(&SPEC, &[1e-9, 2e-6, 0.0, 0.0, 600.0], 1e-4), 1e-4 + 5e-7 + 6e-6);
    }

    #[test]
    fn it_ends_when_the_instrument_is_warm() {
        let share = 1.0 - (-2.0_f64).exp();
        assert_close(reading(&SPEC, &[0.0, 0.0, 0.0, 3e-6, 250.0], 1e-4), 1e-4 + 3e-6 * share);
    }

    #[test]
    fn it_vanishes() {
        vanishes(&SPEC);
    }
}
