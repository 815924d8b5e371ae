//! A fixture with play, which its own friction holds.
//!
//! alpha += j s, s from -1/2 to 1/2. The play is taken up as in [`backlash`], but not before the torque has overcome what holds
//! the fixture: with g the share that is taken up within m_t, s rises along g(M - T) and falls along g(M + T), M as it was
//! read, and stays in between where it was. A loop to less than T does not see it. Every run begins with the same share s_0, as
//! nobody has read what came before.
//!
//! [`backlash`]: super::backlash

use super::backlash::taken_up;
use super::dual::Dual;
use super::port::{Action, Row};
use super::spec::{Class, Parameter, Port, Reducers, Spec};
use crate::units::Quantity;

/// The effect.
pub static SPEC: Spec = Spec {
    id: "loose_fixture",
    class: Class::Rig,
    port: Port::Reading,
    reducers: Reducers::All,
    equation: "alpha += j s, s as little moved as keeps g(M - T) <= s <= g(M + T), M the torque read, g(x) = x/(2 sqrt(x^2 + m_t^2))",
    source: "generalised play: Visintin, Differential Models of Hysteresis (1994), chapter III",
    tell_tale: "the angle steps by one amount at one torque of each sign, on the way there alone; loops to less than that torque show nothing of it",
    parameters: &[
        Parameter::size("fixture_play", Quantity::Angle, "angle j by which the fixture turns")
            .within(0.0, 1.0)
            .likely(0.0, 0.1),
        Parameter::shape("holding_torque", Quantity::Torque, 1.0, "torque T up to which friction holds it")
            .within(1e-9, 1e6)
            .likely(1e-3, 1e3)
            .log(),
        Parameter::shape(
            "transition_torque",
            Quantity::Torque,
            0.1,
            "torque m_t within which the play is taken up",
        )
        .within(1e-9, 1e6)
        .likely(1e-3, 1e3)
        .log(),
        Parameter::shape(
            "first_share",
            Quantity::Number,
            0.0,
            "share s_0 of the play at which the fixture stands when a run begins; 0: in the middle",
        )
        .within(-0.5, 0.5)
        .likely(-0.5, 0.5),
    ],
    twins: &[],
    action: Action::Readings(act),
};

fn act(own: &[Dual], run: &[Row], angles_rad: &[Dual]) -> Vec<Dual> {
    let [play_rad, holding_Nm, transition_Nm, first] = [own[0], own[1], own[2], own[3]];
    // The share that is taken up at a torque from which what holds is taken `sense` times.
    let share = |torque_Nm: f64, sense: f64| {
        let (share, [by_torque, by_transition]) =
            taken_up(torque_Nm + sense * holding_Nm.value, transition_Nm.value);
        let mut taken = holding_Nm.chain(share, sense * by_torque);
        taken.add_slope(by_transition, &transition_Nm);
        taken
    };
    let after = |before: Dual, row: &Row| {
        let (low, high) = (share(row.torque_Nm, -1.0), share(row.torque_Nm, 1.0));
        if before.value < low.value {
            low
        } else if before.value > high.value {
            high
        } else {
            before
        }
    };
    let mut stands = first;
    let shown = run.iter().zip(angles_rad).map(|(row, angle_rad)| {
        stands = after(stands, row);
        *angle_rad + play_rad * stands
    });
    shown.collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effect::testing::{ROW, assert_close, vanishes};

    const PLAY_RAD: f64 = 2e-3;

    /// What is shown of no angle, over the play.
    fn shares(torques_Nm: &[f64], own: [f64; 4]) -> Vec<f64> {
        let run: Vec<Row> = torques_Nm.iter().map(|&torque_Nm| Row { torque_Nm, ..ROW }).collect();
        let angles = vec![Dual::constant(0.0); run.len()];
        let shown = act(&own.map(Dual::constant), &run, &angles);
        shown.iter().map(|angle| angle.value / PLAY_RAD).collect()
    }

    #[test]
    fn it_steps_beyond_the_torque_that_holds_it_and_stays_on_the_way_back() {
        let torques = [0.0, 4.9, 5.1, 8.0, -4.9, -5.1, -8.0, 0.0, 4.9];
        let found = shares(&torques, [PLAY_RAD, 5.0, 1e-6, -0.5]);
        let wanted = [-0.5, -0.5, 0.5, 0.5, 0.5, -0.5, -0.5, -0.5, -0.5];
        for (share, exact) in found.iter().zip(wanted) {
            assert!((share - exact).abs() < 1e-9, "{found:?}");
        }
    }

    #[test]
    fn a_small_loop_does_not_see_it() {
        for share in shares(&[0.0, 3.0, -3.0, 3.0], [PLAY_RAD, 5.0, 1e-6, 0.2]) {
            assert_close(share, 0.2);
        }
    }

    /// What nothing holds is a play: 3 and 4 make 5.
    #[test]
    fn what_nothing_holds_is_a_play() {
        let found = shares(&[3.0, -3.0, 0.0, 3.0], [PLAY_RAD, 1e-9, 4.0, 0.0]);
        for (share, exact) in found.iter().zip([0.3, -0.3, 0.0, 0.3]) {
            assert!((share - exact).abs() < 1e-9, "{found:?}");
        }
    }

    #[test]
    fn its_derivatives_are_exact() {
        let torques = [0.0, 4.2, 5.5, 8.0, 0.0, -4.5, -6.0, 2.0];
        let run: Vec<Row> = torques.iter().map(|&torque_Nm| Row { torque_Nm, ..ROW }).collect();
        let angles = vec![Dual::constant(1e-3); run.len()];
        let values = [PLAY_RAD, 5.0, 0.7, 0.2];
        let of = |own: [f64; 4]| act(&own.map(Dual::constant), &run, &angles);
        let exact = act(&[0, 1, 2, 3].map(|slot| Dual::parameter(values[slot], slot)), &run, &angles);
        for slot in 0..4 {
            let h = 1e-6 * values[slot];
            let moved = |sign: f64| {
                let mut own = values;
                own[slot] += sign * h;
                of(own)
            };
            for ((more, less), exact) in moved(1.0).iter().zip(&moved(-1.0)).zip(&exact) {
                let difference = (more.value - less.value) / (2.0 * h);
                assert!((difference - exact.partials[slot]).abs() < 1e-7 * (1.0 + difference.abs()));
            }
        }
    }

    #[test]
    fn it_vanishes() {
        vanishes(&SPEC);
    }
}
