//! Hysteresis of the angle sensor: slack of its coupling or mount, friction in its bearing.
//!
//! The instrument shows P_h(alpha), the play operator (`play`): what it shows stays until the angle has gone on by h, and
//! then follows h behind. Every run begins without a history.

use super::dual::Dual;
use super::play;
use super::port::{Action, Row};
use super::spec::{Class, Parameter, Port, Reducers, Spec};
use crate::units::{ARCSEC, Quantity};

/// The effect.
pub static SPEC: Spec = Spec {
    id: "sensor_hysteresis",
    class: Class::Rig,
    port: Port::Reading,
    reducers: Reducers::All,
    equation: "reading = P_h(alpha), P_h the play operator of the half width h",
    source: "play operator: Visintin, Differential Models of Hysteresis (1994), chapter III",
    tell_tale: "loading and unloading form a loop of one width in angle, at every load and rate; angles stay the same after the torque turns",
    parameters: &[Parameter::size(
        "half_width",
        Quantity::Angle,
        "half the width h of the loop that the angle readings describe",
    )
    .within(0.0, 1.0)
    .likely(0.0, 60.0 * ARCSEC)],
    twins: &[],
    action: Action::Readings(act),
};

fn act(own: &[Dual], _: &[Row], angles_rad: &[Dual]) -> Vec<Dual> {
    play::following(own[0], angles_rad.iter().copied())
}

#[cfg(test)]
#[allow(clippy::float_cmp)] // where nothing is rounded
mod tests {
    use super::*;
    use crate::effect::testing::vanishes;

    fn shown(half_width: f64, angles: &[f64]) -> Vec<f64> {
        let angles: Vec<Dual> = angles.iter().map(|angle| Dual::constant(*angle)).collect();
        act(&[Dual::constant(half_width)], &[], &angles).iter().map(|angle| angle.value).collect()
    }

    #[test]
    fn what_is_shown_stays_until_the_angle_has_gone_on_by_the_half_width() {
        assert_eq!(shown(0.5, &[0.25, 2.0, 1.75, 1.0, -2.0, -1.5]), [0.0, 1.5, 1.5, 1.5, -1.5, -1.5]);
    }

    #[test]
    fn a_row_without_a_solution_is_passed_over() {
        let angles = shown(0.5, &[2.0, f64::NAN, 1.75]);
        assert!(angles[1].is_nan());
        assert_eq!([angles[0], angles[2]], [1.5, 1.5]);
    }

    #[test]
    fn it_vanishes() {
        vanishes(&SPEC);
    }
}
