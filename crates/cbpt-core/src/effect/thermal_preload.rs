//! A preload that follows the temperature.
//!
//! N_Z -> N_Z + c (T - T0), T0 the temperature of the table's first reading.

use super::dual::Dual;
use super::port::{Action, Load, Row};
use super::spec::{Class, Parameter, Port, Reducers, Spec};
use crate::units::Quantity;

/// The effect.
pub static SPEC: Spec = Spec {
    id: "thermal_preload",
    class: Class::Effect,
    port: Port::Load,
    reducers: Reducers::BallDrives,
    equation: "N_Z -> N_Z + c (T - T0), where T0 is the first temperature of the table",
    source: "difference in thermal expansion between shaft and housing",
    tell_tale: "the readings look as if the preload followed the temperature",
    parameters: &[Parameter::size(
        "rate",
        Quantity::ForcePerTemperature,
        "change c of the preload per kelvin",
    )
    .within(-1e5, 1e5)
    .likely(-100.0, 100.0)],
    twins: &[],
    action: Action::Load(act),
};

fn act(own: &[Dual], row: &Row, load: &mut Load) {
    load.preload_N += own[0] * row.temperature_difference_K;
}

#[cfg(test)]
#[allow(clippy::float_cmp)] // where nothing is rounded
mod tests {
    use super::*;
    use crate::effect::testing::{ROW, assert_close, load, vanishes};

    /// 50 N/K at 3 K.
    #[test]
    fn it_adds_what_the_temperature_makes() {
        assert_close(load(&SPEC, &[50.0]).preload_N.value, ROW.preload_N + 150.0);
    }

    #[test]
    fn it_vanishes() {
        vanishes(&SPEC);
    }
}
