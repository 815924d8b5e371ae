//! Hysteresis of the torque sensor.
//!
//! P_h(M) is the play operator (`play`). h > 0: what is read is late,
//! so that the load on a branch is larger than what is read by h after a way of 2 h. h < 0: the load follows what is read, as
//! behind friction between the sensor and the reducer. Every run begins without a history.

use super::dual::Dual;
use super::play;
use super::port::{Action, Row};
use super::spec::{Class, Parameter, Port, Reducers, Spec};
use crate::units::Quantity;

/// The effect.
pub static SPEC: Spec = Spec {
    id: "torque_hysteresis",
    class: Class::Rig,
    port: Port::Reading,
    reducers: Reducers::All,
    equation: "M0 = M_read + sgn(h) (M_read - P_|h|(M_read)), P_h(M) the play operator of the half width h",
    source: "play operator: Visintin, Differential Models of Hysteresis (1994), chapter III",
    tell_tale: "loading and unloading form a loop of one width in torque, at every load and rate",
    parameters: &[Parameter::size(
        "half_width",
        Quantity::Torque,
        "half the width h of the loop that the torque readings describe; negative: the load lags behind the readings",
    )
    .within(-1e6, 1e6)
    .likely(-1.0, 1.0)],
    twins: &[],
    action: Action::Torques(act),
};

fn act(own: &[Dual], run: &[Row]) -> Vec<Dual> {
    let read = || run.iter().map(|row| Dual::constant(row.torque_Nm));
    let sign = if own[0].value < 0.0 { -1.0 } else { 1.0 };
    let following = play::following(own[0].abs(), read());
    read().zip(following).map(|(read_Nm, follows_Nm)| (read_Nm - follows_Nm) * sign).collect()
}

#[cfg(test)]
#[allow(clippy::float_cmp)] // where nothing is rounded
mod tests {
    use super::*;
    use crate::effect::testing::{torques, vanishes};

    const CYCLE: [(f64, f64); 7] =
        [(0.0, 0.0), (1.0, 0.25), (2.0, 2.0), (3.0, 1.75), (4.0, 1.0), (5.0, -2.0), (6.0, -1.5)];

    fn added(half_width_Nm: f64) -> Vec<f64> {
        torques(&SPEC, &[Dual::constant(half_width_Nm)], &CYCLE).iter().map(|torque| torque.value).collect()
    }

    #[test]
    fn the_load_on_a_branch_is_half_the_width_ahead_of_the_reading() {
        assert_eq!(added(0.5), [0.0, 0.25, 0.5, 0.25, -0.5, -0.5, 0.0]);
    }

    #[test]
    fn a_load_that_lags_is_the_same_the_other_way() {
        let negative: Vec<f64> = added(0.5).into_iter().map(|torque_Nm| 0.0 - torque_Nm).collect();
        assert_eq!(added(-0.5), negative);
    }

    #[test]
    fn it_vanishes() {
        vanishes(&SPEC);
    }
}
