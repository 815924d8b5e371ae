//! A stiffness of a torsion spring that changes with its load otherwise than the case states.
//!
//! alpha += a x |x| + b x^3 + c x^2 with x = m/M_r, m the torque that the spring carries. Negative parts stiffen it; the last one
//! bends both senses differently, as flanks for each sense do. Behind friction, as `backlash` is.

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
    equation: "alpha += a x |x| + b x^3 + c x^2, x = m/M_r, where m is the torque that the spring carries and M_r the reference torque",
    source: "stiffness over the load as makers state it in pieces (K1, K2, K3), smooth: first terms of the curve, of which the odd ones are alike under both signs",
    tell_tale: "the residual follows the torque alone, mostly alike under both signs, and bends; without friction or play an angle sensor that bends as much looks the same",
    parameters: &[
        part("squared", "turn a at the reference torque of the part with the square of the torque"),
        part("cubed", "turn b at the reference torque of the part with its cube"),
        part(
            "skewed",
            "turn c at the reference torque of the part with the square that does not change its sign",
        ),
        Parameter::shape(
            "reference_torque",
            Quantity::Torque,
            1.0,
            "torque M_r at which a, b and c are stated",
        )
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
    for (part, own) in contact.curve_rad.iter_mut().zip(own) {
        *part += *own;
    }
    contact.reference_torque_Nm = own[3];
}

/// x |x|, x^3 and x^2 of a torque, and their derivatives by it.
pub fn parts(torque_Nm: f64, reference_Nm: f64) -> ([f64; 3], [f64; 3]) {
    let x = torque_Nm / reference_Nm;
    ([x * x.abs(), x * x * x, x * x], [2.0 * x.abs(), 3.0 * x * x, 2.0 * x].map(|slope| slope / reference_Nm))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effect::testing::{assert_close, contact, vanishes};

    #[test]
    fn its_parts_are_those_of_the_contacts() {
        let [squared, cubed, skewed] =
            contact(&SPEC, &[1e-3, 2e-3, 3e-3, 50.0]).curve_rad.map(|part| part.value);
        assert_close(squared, 1e-3);
        assert_close(cubed, 2e-3);
        assert_close(skewed, 3e-3);
    }

    /// At the reference torque each part is 1, and but for the last one it is odd.
    #[test]
    fn it_is_stated_at_the_reference_torque() {
        for part in parts(5.0, 5.0).0 {
            assert_close(part, 1.0);
        }
        let ([squared, cubed, skewed], _) = parts(-2.0, 4.0);
        assert_close(squared, -0.25);
        assert_close(cubed, -0.125);
        assert_close(skewed, 0.25);
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
