//! A stiffness of a torsion spring that changes with its load otherwise than the case states.
//!
//! alpha += a x |x| + b x^3 with x = m/M_r, m the torque that the spring carries. Negative parts stiffen it. Behind friction, as
//! `backlash` is.

use super::dual::Dual;
use super::port::{Action, Contact};
use super::spec::{Class, Parameter, Port, Reducers, Spec};
use crate::units::Quantity;

/// The effect.
pub static SPEC: Spec = Spec {
    id: "stiffness_curve",
    class: Class::Effect,
    port: Port::Contact,
    reducers: Reducers::TorsionSprings,
    equation: "alpha += a x |x| + b x^3, x = m/M_r, where m is the torque that the spring carries and M_r the reference torque",
    source: "stiffness over the load as makers state it in pieces (K1, K2, K3), smooth: first two odd terms of the curve",
    tell_tale: "the residual follows the torque alone, alike under both signs, and bends; without friction or play an angle sensor that bends as much looks the same",
    parameters: &[
        part("squared", "turn a at the reference torque of the part with the square of the torque"),
        part("cubed", "turn b at the reference torque of the part with its cube"),
        Parameter::shape("reference_torque", Quantity::Torque, 1.0, "torque M_r at which a and b are stated")
            .within(1e-9, 1e12)
            .likely(1e-3, 1e3)
            .log(),
    ],
    twins: &[],
    action: Action::Contact(act),
};

const fn part(stem: &'static str, meaning: &'static str) -> Parameter {
    Parameter::size(stem, Quantity::Angle, meaning).within(-1.0, 1.0).likely(-0.1, 0.1)
}

fn act(own: &[Dual], contact: &mut Contact) {
    contact.curve_rad = [contact.curve_rad[0] + own[0], contact.curve_rad[1] + own[1]];
    contact.reference_torque_Nm = own[2];
}

/// x |x| and x^3 of a torque, and their derivatives by it.
pub fn parts(torque_Nm: f64, reference_Nm: f64) -> ([f64; 2], [f64; 2]) {
    let x = torque_Nm / reference_Nm;
    ([x * x.abs(), x * x * x], [2.0 * x.abs() / reference_Nm, 3.0 * x * x / reference_Nm])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effect::testing::{assert_close, contact, vanishes};

    #[test]
    fn its_parts_are_those_of_the_contacts() {
        let [squared, cubed] = contact(&SPEC, &[1e-3, 2e-3, 50.0]).curve_rad.map(|part| part.value);
        assert_close(squared, 1e-3);
        assert_close(cubed, 2e-3);
    }

    /// At the reference torque each part is 1, and it is odd.
    #[test]
    fn it_is_stated_at_the_reference_torque() {
        for part in parts(5.0, 5.0).0 {
            assert_close(part, 1.0);
        }
        let ([squared, cubed], _) = parts(-2.0, 4.0);
        assert_close(squared, -0.25);
        assert_close(cubed, -0.125);
    }

    #[test]
    fn its_derivatives_are_exact() {
        for torque in [-2.0, 0.0, 0.3] {
            let h = 1e-6;
            let (_, slopes) = parts(torque, 0.5);
            for (part, slope) in slopes.into_iter().enumerate() {
                let difference =
                    (parts(torque + h, 0.5).0[part] - parts(torque - h, 0.5).0[part]) / (2.0 * h);
                assert!((slope - difference).abs() < 1e-5, "{part} {torque}");
            }
        }
    }

    #[test]
    fn it_vanishes() {
        vanishes(&SPEC);
    }
}
