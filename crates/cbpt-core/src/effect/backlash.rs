//! Backlash between the members that carry the torque.
//!
//! They take up the play j as the torque m that they carry turns over: alpha += (j/2) m/sqrt(m^2 + m_t^2), a step of j as
//! m_t goes to 0. Behind friction, so that a loop crosses its play where the friction of that way is overcome. Where another
//! torque holds the members to one flank (a weight on the output, say), they turn over as m outweighs it, at m_c; the angle counts
//! from where they stand without m.

use super::dual::Dual;
use super::port::{Action, Contact, PLAY_NUMBERS};
use super::spec::{Class, Parameter, Port, Reducers, Spec};
use crate::units::Quantity;

/// The effect.
pub static SPEC: Spec = Spec {
    id: "backlash",
    class: Class::Effect,
    port: Port::Contact,
    reducers: Reducers::TorsionSprings,
    equation: "alpha += j (g(m - m_c) - g(-m_c)), g(x) = x/(2 sqrt(x^2 + m_t^2)), where m is the torque that the spring carries",
    source: "lost motion as makers of reducers state it: the angle between both flanks at next to no torque",
    tell_tale: "the angle changes steeply near zero torque, or near the one that outweighs what holds the output; with friction, the steep part lies at different torques for loading and unloading",
    parameters: &[
        Parameter::size("play", Quantity::Angle, "angle j between both flanks")
            .within(0.0, 1.0)
            .likely(0.0, 0.1),
        Parameter::shape(
            "transition_torque",
            Quantity::Torque,
            0.1,
            "torque m_t within which the play is taken up",
        )
        .within(1e-9, 1e6)
        .likely(1e-3, 1e3)
        .log(),
        Parameter::shape("centre_torque", Quantity::Torque, 0.0, "torque m_c at which the members turn over")
            .within(-1e6, 1e6)
            .likely(-1e3, 1e3),
    ],
    twins: &[],
    action: Action::Contact(act),
};

fn act(own: &[Dual], contact: &mut Contact) {
    contact.plays.extend(own.first_chunk());
}

/// What it adds to the angle under a torque, and its derivative by the torque.
pub fn turned(&[play_rad, transition_Nm, centre_Nm]: &[f64; PLAY_NUMBERS], torque_Nm: f64) -> [f64; 2] {
    let (share, [by_torque, _]) = taken_up(torque_Nm - centre_Nm, transition_Nm);
    let (at_rest, _) = taken_up(-centre_Nm, transition_Nm);
    [play_rad * (share - at_rest), play_rad * by_torque]
}

/// The derivatives of the angle by its numbers.
pub fn slopes(
    &[play_rad, transition_Nm, centre_Nm]: &[f64; PLAY_NUMBERS],
    torque_Nm: f64,
) -> [f64; PLAY_NUMBERS] {
    let (share, [by_torque, by_transition]) = taken_up(torque_Nm - centre_Nm, transition_Nm);
    let (at_rest, [by_torque_at_rest, by_transition_at_rest]) = taken_up(-centre_Nm, transition_Nm);
    [
        share - at_rest,
        play_rad * (by_transition - by_transition_at_rest),
        play_rad * (by_torque_at_rest - by_torque),
    ]
}

/// The share of the play, -1/2 to 1/2, that a torque takes up, and its derivatives by the torque and by m_t.
pub fn taken_up(torque_Nm: f64, transition_Nm: f64) -> (f64, [f64; 2]) {
    let size = (torque_Nm * torque_Nm + transition_Nm * transition_Nm).sqrt();
    let (sine, cosine) = (torque_Nm / size, transition_Nm / size);
    let steep = 0.5 * cosine * cosine / size;
    (0.5 * sine, [steep, -0.5 * sine * cosine / size])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effect::testing::{assert_close, vanishes};

    /// 3 and 4 make 5; far from the transition it is the step, at no torque nothing.
    #[test]
    fn it_takes_up_the_play() {
        assert_close(taken_up(3.0, 4.0).0, 0.3);
        assert_close(taken_up(-5.0, 1e-9).0, -0.5);
        assert_close(taken_up(0.0, 0.1).0, 0.0);
    }

    #[test]
    fn its_derivatives_are_exact() {
        for torque in [-2.0, 0.0, 0.3] {
            let (_, [by_torque, by_transition]) = taken_up(torque, 0.5);
            let h = 1e-6;
            let difference = |f: &dyn Fn(f64) -> f64| (f(h) - f(-h)) / (2.0 * h);
            assert!((by_torque - difference(&|h| taken_up(torque + h, 0.5).0)).abs() < 1e-9);
            assert!((by_transition - difference(&|h| taken_up(torque, 0.5 + h).0)).abs() < 1e-9);
        }
    }

    /// Held to one flank by 5 N m, it is taken up between 4 and 6 N m, and from rest as far as both flanks are apart.
    #[test]
    fn it_is_taken_up_off_centre() {
        let own = [2.0, 1e-6, 5.0];
        assert_close(turned(&own, 0.0)[0], 0.0);
        assert!(turned(&own, 4.0)[0].abs() < 1e-9);
        assert!((turned(&own, 6.0)[0] - 2.0).abs() < 1e-9);
    }

    #[test]
    fn its_numbers_have_exact_derivatives() {
        let own = [2.0, 0.7, -1.2];
        for torque in [-2.0, 0.0, 0.3] {
            for (place, exact) in slopes(&own, torque).into_iter().enumerate() {
                let at = |sign: f64| {
                    let mut moved = own;
                    moved[place] += sign * 1e-6;
                    turned(&moved, torque)[0]
                };
                assert!((exact - (at(1.0) - at(-1.0)) / 2e-6).abs() < 1e-8);
            }
        }
    }

    #[test]
    fn it_vanishes() {
        vanishes(&SPEC);
    }
}
