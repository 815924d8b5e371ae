//! A torque that is shown late: by a sensor or a filter of first order, M0 = M_read + tau r with r = dM_read/dt.
//!
//! A run begins at rest, r = 0. Else r at a reading is the rate from the reading before to the one behind, so that the noise of a
//! torque reading has no share in what is added to it; at the last that from the one before. Where no time passes nothing is
//! added. An angle that is late is [`super::damping`].

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
    parameters: &[Parameter::size("lag", Quantity::Time, "time tau by which the torque readings are late")
        .within(0.0, 1e6)
        .likely(0.0, 10.0)],
    twins: &[],
    action: Action::Torques(act),
};

fn act(own: &[Dual], run: &[Row]) -> Vec<Dual> {
    rates_Nm_per_s(run).into_iter().map(|rate| own[0] * rate).collect()
}

/// At which the torque of a run changes, at each reading.
pub(super) fn rates_Nm_per_s(run: &[Row]) -> Vec<f64> {
    let last = run.len() - 1;
    let rate = |place: usize| {
        let (before, behind) = (&run[place - 1], &run[last.min(place + 1)]);
        let passed_s = behind.run_time_s - before.run_time_s;
        if passed_s > 0.0 { (behind.torque_Nm - before.torque_Nm) / passed_s } else { 0.0 }
    };
    (0..=last).map(|place| if place == 0 { 0.0 } else { rate(place) }).collect()
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
        assert_eq!(added(0.5), [0.0, 0.25, 0.375, 0.375, -0.125, -0.5]);
    }

    #[test]
    fn its_derivative_is_exact() {
        let found = torques(&SPEC, &[Dual::parameter(0.4, 0)], &RAMP);
        for (found, rate) in found.iter().zip(added(1.0)) {
            assert!((found.partials[0] - rate).abs() < 1e-12, "{found:?}");
        }
    }

    #[test]
    fn it_vanishes() {
        vanishes(&SPEC);
    }
}
