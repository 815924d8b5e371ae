//! Torque and angle that do not belong to one instant.
//!
//! M0 = M_read + tau dM_read/dt: a sensor or filter of first order that is late by tau > 0; where tau < 0 the angle, or the load
//! behind the sensor, is late, to first order in tau. The rate is that from the reading before to the one behind, so that the noise
//! of a torque reading has no share in what is added to it; at the ends of a run that of one side. Nothing is added where no time passes.

use super::dual::Dual;
use super::port::{Action, Row};
use super::spec::{Class, Parameter, Port, Reducers, Spec};
use crate::units::Quantity;

/// The effect.
pub static SPEC: Spec = Spec {
    id: "torque_lag",
    class: Class::Rig,
    port: Port::Reading,
    reducers: Reducers::All,
    equation: "M0 = M_read + tau dM_read/dt",
    source: "first-order measuring system: Doebelin, Measurement Systems (2004), section 3.3",
    tell_tale: "loading and unloading form a loop that is wider where the torque changes faster, and vanishes where it holds",
    parameters: &[Parameter::size(
        "lag",
        Quantity::Time,
        "time tau by which the torque readings are late; negative: by which the load or the angle is late",
    )
    .within(-1e6, 1e6)
    .likely(-10.0, 10.0)],
    twins: &[],
    action: Action::Torques(act),
};

fn act(own: &[Dual], run: &[Row]) -> Vec<Dual> {
    let last = run.len() - 1;
    (0..=last)
        .map(|place| {
            let (before, behind) = (&run[place.saturating_sub(1)], &run[last.min(place + 1)]);
            let passed_s = behind.run_time_s - before.run_time_s;
            if passed_s > 0.0 {
                own[0] * ((behind.torque_Nm - before.torque_Nm) / passed_s)
            } else {
                Dual::constant(0.0)
            }
        })
        .collect()
}

#[cfg(test)]
#[allow(clippy::float_cmp)] // where nothing is rounded
mod tests {
    use super::*;
    use crate::effect::testing::{torques, vanishes};

    const RAMP: [(f64, f64); 6] = [(0.0, 0.0), (2.0, 1.0), (4.0, 2.0), (4.0, 2.5), (6.0, 3.5), (8.0, 1.5)];

    fn added(tau_s: f64) -> Vec<f64> {
        torques(&SPEC, &[Dual::constant(tau_s)], &RAMP).iter().map(|torque| torque.value).collect()
    }

    #[test]
    fn a_late_sensor_shows_what_was_before() {
        assert_eq!(added(0.5), [0.25, 0.25, 0.375, 0.375, -0.125, -0.5]);
    }

    #[test]
    fn a_late_load_is_the_same_the_other_way() {
        let negative: Vec<f64> = added(0.5).into_iter().map(|torque_Nm| -torque_Nm).collect();
        assert_eq!(added(-0.5), negative);
    }

    #[test]
    fn it_vanishes() {
        vanishes(&SPEC);
    }
}
