//! A stop beside the contacts that takes part of the torque once it is reached.
//!
//! Beyond the torque `m_s` the contacts carry `m_s` + (1 - s)(m - `m_s`), alike under both signs; s = `k_s`/(k + `k_s`) of a stop of
//! stiffness `k_s` in parallel with a drive of stiffness k. At s = 1 the stop is rigid, and the angle stays as it is at `m_s`. Behind
//! friction, as `backlash` is, so that a loop reaches the stop at one angle on both of its branches.

use super::dual::Dual;
use super::port::{Action, Contact, STOP_NUMBERS};
use super::spec::{Class, Parameter, Port, Reducers, Spec};
use crate::units::Quantity;

/// The effect.
pub static SPEC: Spec = Spec {
    id: "hard_stop",
    class: Class::Effect,
    port: Port::Contact,
    reducers: Reducers::All,
    equation: "m -> sgn(m) (m_s + (1 - s)(|m| - m_s)) where |m| > m_s, m being the torque behind friction",
    source: "two springs in parallel, one of which begins to carry at an angle: Shigley, Mechanical Engineering Design (2011), section 4-1",
    tell_tale: "from one torque on the angle grows much less or no more, alike under both signs; below it nothing changes",
    parameters: &[
        Parameter::size(
            "taken_share",
            Quantity::Number,
            "share s of the further torque that the stop takes; 1: it is rigid",
        )
        .within(0.0, 1.0)
        .likely(0.0, 1.0),
        Parameter::shape("stop_torque", Quantity::Torque, 1.0, "torque m_s at which the stop is reached")
            .within(1e-9, 1e12)
            .likely(1e-3, 1e3)
            .log(),
    ],
    twins: &[],
    action: Action::Contact(act),
};

fn act(own: &[Dual], contact: &mut Contact) {
    contact.stops.extend(own.first_chunk());
}

/// What the contacts carry of a torque, its derivative by the torque, and those by the effect's numbers.
pub fn carried(torque_Nm: f64, &[share, stop_Nm]: &[f64; STOP_NUMBERS]) -> (f64, f64, [f64; STOP_NUMBERS]) {
    let beyond = torque_Nm.abs() - stop_Nm;
    if beyond <= 0.0 || share == 0.0 {
        let by_share = if beyond > 0.0 { -beyond.copysign(torque_Nm) } else { 0.0 };
        return (torque_Nm, 1.0, [by_share, 0.0]);
    }
    let left = 1.0 - share;
    let sign = 1.0_f64.copysign(torque_Nm);
    (sign * (stop_Nm + left * beyond), left, [-sign * beyond, sign * share])
}

#[cfg(test)]
#[allow(clippy::float_cmp)] // where nothing is rounded
mod tests {
    use super::*;
    use crate::effect::testing::{assert_close, vanishes};

    /// A stop three times as stiff as the drive takes 3/4 of the 4 N m beyond it; a rigid one all.
    #[test]
    fn it_takes_its_share_beyond_its_torque() {
        assert_close(carried(6.0, &[0.75, 2.0]).0, 3.0);
        assert_close(carried(-6.0, &[0.75, 2.0]).0, -3.0);
        assert_close(carried(6.0, &[1.0, 2.0]).0, 2.0);
        assert_eq!(carried(-1.5, &[0.75, 2.0]), (-1.5, 1.0, [0.0, 0.0]));
    }

    #[test]
    fn its_derivatives_are_exact() {
        for (torque, share) in [(6.0, 0.7), (-6.0, 0.7), (1.0, 0.7), (-6.0, 0.0)] {
            let (_, by_torque, [by_share, by_stop]) = carried(torque, &[share, 2.0]);
            let exact = [by_torque, by_share, by_stop];
            let e = 1e-6;
            let difference = |d: [f64; 3]| {
                let by = |s: f64| carried(torque + s * d[0], &[share + s * d[1], 2.0 + s * d[2]]).0;
                (by(e) - by(if share == 0.0 { 0.0 } else { -e })) / if share == 0.0 { e } else { 2.0 * e }
            };
            for (place, d) in [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].into_iter().enumerate() {
                assert!((exact[place] - difference(d)).abs() < 1e-7, "{torque} {share} {place}");
            }
        }
    }

    #[test]
    fn it_vanishes() {
        vanishes(&SPEC);
    }
}
