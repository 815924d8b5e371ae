//! Play of the eccentric bearing.
//!
//! A diametral clearance c lets the planet move by c/2 to either side: alpha += sgn(M0) (c/2)/(Zo e), 0 at M0 = 0. What rubs
//! in the bearing or presses it to one side gives way within a torque m_t: M0/sqrt(M0^2 + m_t^2) in place of sgn(M0).

use super::backlash::taken_up;
use super::dual::Dual;
use super::port::{Action, DriveNumbers, Row};
use super::spec::{Class, Parameter, Port, Reducers, Spec};
use crate::units::Quantity;

/// The effect.
pub static SPEC: Spec = Spec {
    id: "bearing_play",
    class: Class::Effect,
    port: Port::Series,
    reducers: Reducers::AllByRadius,
    equation: "alpha += sgn(M0) (c/2)/(Zo e); with m_t alpha += (c/2)/(Zo e) M0/sqrt(M0^2 + m_t^2)",
    source: "geometry of a bearing with diametral clearance",
    tell_tale: "the angle steps, or changes steeply, where the torque reverses",
    parameters: &[
        Parameter::size("clearance", Quantity::Length, "diametral clearance c")
            .within(0.0, 1e-3)
            .likely(0.0, 20e-6),
        Parameter::shape(
            "transition_torque",
            Quantity::Torque,
            0.0,
            "torque m_t within which the clearance is taken up; 0: a step",
        )
        .within(0.0, 1e6)
        .likely(1e-3, 1e3)
        .log(),
    ],
    twins: &[],
    action: Action::Series(act),
};

fn act(own: &[Dual], _: &Row, drive: &DriveNumbers, torque_Nm: Dual) -> Dual {
    let transition_Nm = own[1];
    if transition_Nm.value > 0.0 {
        let (share, [by_torque, by_transition]) = taken_up(torque_Nm.value, transition_Nm.value);
        let mut turned = torque_Nm.chain(share, by_torque);
        turned.add_slope(by_transition, &transition_Nm);
        return own[0] * turned * (1.0 / drive.pitch_arm_m);
    }
    let side = if torque_Nm.value == 0.0 { 0.0 } else { torque_Nm.value.signum() };
    own[0] * (0.5 * side / drive.pitch_arm_m)
}

#[cfg(test)]
#[allow(clippy::float_cmp)] // where nothing is rounded
mod tests {
    use super::*;
    use crate::effect::testing::{assert_close, series, vanishes};

    #[test]
    fn it_steps_where_the_torque_reverses() {
        assert_close(series(&SPEC, &[8e-6, 0.0], 0.1), 4e-6 / 0.04);
        assert_close(series(&SPEC, &[8e-6, 0.0], -9.0), -4e-6 / 0.04);
        assert_eq!(series(&SPEC, &[8e-6, 0.0], 0.0), 0.0);
    }

    /// 3 and 4 make 5; far from the transition, or where that is short, it is the step.
    #[test]
    fn it_is_taken_up_within_its_transition() {
        assert_close(series(&SPEC, &[8e-6, 4.0], 3.0), 0.6 * 4e-6 / 0.04);
        assert_close(series(&SPEC, &[8e-6, 4.0], -3.0), -0.6 * 4e-6 / 0.04);
        assert_close(series(&SPEC, &[8e-6, 1e-9], -9.0), -4e-6 / 0.04);
        assert_eq!(series(&SPEC, &[8e-6, 0.1], 0.0), 0.0);
    }

    #[test]
    fn it_vanishes() {
        vanishes(&SPEC);
    }
}
