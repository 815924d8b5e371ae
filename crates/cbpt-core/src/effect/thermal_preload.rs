//! A preload that follows the temperature.
//!
//! N_Z -> N_Z + c (T_p - T0), T0 the first temperature. T_p is the measured temperature, or that of a part which follows it
//! with a time constant ([`super::lag`]): housing and shaft are heavier than the sensor that is stuck on them.

use super::dual::Dual;
use super::lag::time_constant;
use super::port::{Action, Load};
use super::spec::{Class, Parameter, Port, Reducers, Spec};
use crate::units::Quantity;

/// The effect.
pub static SPEC: Spec = Spec {
    id: "thermal_preload",
    class: Class::Effect,
    port: Port::Load,
    reducers: Reducers::BallDrives,
    equation: "N_Z -> N_Z + c (T_p - T0), where T0 is the first temperature of the table and tau dT_p/dt = T - T_p",
    source: "difference in thermal expansion between shaft and housing; lag of a lumped thermal mass: Incropera et al., Fundamentals of Heat and Mass Transfer (2007), section 5.1",
    tell_tale: "the readings look as if the preload followed the temperature",
    parameters: &[
        Parameter::size("rate", Quantity::ForcePerTemperature, "change c of the preload per kelvin")
            .within(-1e5, 1e5)
            .likely(-100.0, 100.0),
        time_constant(),
    ],
    twins: &[],
    action: Action::ThermalLoad(1, act),
};

fn act(own: &[Dual], part_temperature_K: Dual, load: &mut Load) {
    load.preload_N += own[0] * part_temperature_K;
}

#[cfg(test)]
#[allow(clippy::float_cmp)] // where nothing is rounded
mod tests {
    use super::*;
    use crate::effect::testing::{ROW, assert_close, load, vanishes};

    /// 50 N/K at 3 K.
    #[test]
    fn it_adds_what_the_temperature_makes() {
        assert_close(load(&SPEC, &[50.0, 0.0]).preload_N.value, ROW.preload_N + 150.0);
    }

    #[test]
    fn it_vanishes() {
        vanishes(&SPEC);
    }
}
