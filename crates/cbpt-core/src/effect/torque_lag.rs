//! A torque that is shown late: by a sensor or a filter of first order, M0 = M_read + tau r with r = dM_read/dt.
//!
//! r at a reading is the rate with which the torque arrives at it ([`super::torque_rate`]). A run begins at rest, r = 0, or while
//! the torque changes: r is then that of the first two steps, gone on to the first reading, or of the first where the torque
//! turns after it. Where no time passes nothing is added. An angle that is late is [`super::damping`].

use super::dual::Dual;
use super::port::{Action, Row};
use super::spec::{Class, Parameter, Port, Reducers, Spec};
use super::torque_rate::{Rate, rates};
use crate::units::Quantity;

/// How runs begin.
pub(super) const STARTS_MOVING: Parameter = Parameter::chosen(
    "starts_moving",
    0.0,
    "1 where runs begin while the torque changes, 0 where they begin at rest",
)
.within(0.0, 1.0)
.likely(0.0, 1.0);

/// The effect.
pub static SPEC: Spec = Spec {
    id: "torque_lag",
    class: Class::Rig,
    port: Port::Reading,
    reducers: Reducers::All,
    equation: "M0 = M_read + tau dM_read/dt",
    source: "first-order measuring system: Doebelin, Measurement Systems (2004), section 3.3",
    tell_tale: "loading and unloading form a loop that is wider where the torque changes faster, and vanishes where it holds",
    parameters: &[
        Parameter::size("lag", Quantity::Time, "time tau by which the torque readings are late")
            .within(0.0, 1e6)
            .likely(0.0, 10.0),
        STARTS_MOVING,
    ],
    twins: &[],
    action: Action::Torques(act),
};

fn act(own: &[Dual], run: &[Row]) -> Vec<Dual> {
    rates_of(run, own[1].value).into_iter().map(|rate| own[0] * rate.arriving_Nm_per_s).collect()
}

/// At which the torque of a run changes, at each reading; it arrives at the first by how the run starts.
pub(super) fn rates_of(run: &[Row], starts_moving: f64) -> Vec<Rate> {
    let time_s: Vec<f64> = run.iter().map(|row| row.run_time_s).collect();
    let torque_Nm: Vec<f64> = run.iter().map(|row| row.torque_Nm).collect();
    let mut found = rates(&time_s, &torque_Nm);
    let last = run.len() - 1;
    let between = |first: usize, second: usize| {
        let passed_s = time_s[second] - time_s[first];
        if passed_s > 0.0 { (torque_Nm[second] - torque_Nm[first]) / passed_s } else { 0.0 }
    };
    let (one, two) = (between(0, last.min(1)), between(last.min(1), last.min(2)));
    let share = (time_s[last.min(1)] - time_s[0]) / (time_s[last.min(2)] - time_s[0]).max(f64::MIN_POSITIVE);
    let first = if one * two > 0.0 { one + (one - two) * share } else { one };
    found[0] = Rate { arriving_Nm_per_s: starts_moving * first, leaving_Nm_per_s: first };
    found
}

#[cfg(test)]
#[allow(clippy::float_cmp)] // where nothing is rounded
mod tests {
    use super::*;
    use crate::effect::testing::{RAMP, added_late, sine, torques, vanishes};

    #[test]
    fn a_late_sensor_shows_what_was_before() {
        assert_eq!(added_late(&SPEC, 0.5), [0.0, 0.25, 0.375, 0.375, -0.125, -0.5]);
    }

    #[test]
    fn a_run_that_starts_moving_has_its_rate_at_once() {
        let own = [Dual::constant(0.5), Dual::constant(1.0)];
        let found = torques(&SPEC, &own, &sine());
        assert!((found[0].value - 0.5).abs() < 0.002, "{}", found[0].value);
        let turns = torques(&SPEC, &own, &[(0.0, 1.0), (1.0, 3.0), (2.0, 2.0)]);
        assert_eq!(turns[0].value, 1.0);
        let short = torques(&SPEC, &own, &RAMP[..1]);
        assert_eq!(short[0].value, 0.0);
    }

    #[test]
    fn its_derivative_is_exact() {
        let found = torques(&SPEC, &[Dual::parameter(0.4, 0), Dual::constant(0.0)], &RAMP);
        for (found, rate) in found.iter().zip(added_late(&SPEC, 1.0)) {
            assert!((found.partials[0] - rate).abs() < 1e-12, "{found:?}");
        }
    }

    #[test]
    fn it_vanishes() {
        vanishes(&SPEC);
    }
}
