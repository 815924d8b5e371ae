//! A stiffness of a torsion spring that changes with its load otherwise than the case states.
//!
//! alpha += a x |x| + b x^3 + c x^2 with x = m/M_r, m the torque that the spring carries. Negative parts stiffen it; the last one
//! bends both senses differently, as flanks for each sense do. In pieces, as makers of strain-wave gears state it, it is softer
//! up to two break torques: alpha += c1 m up to |m| = T1 and c2 m up to |m| = T2, and no more beyond, so with the stated stiffness k
//! 1/K1 = 1/k + c1 + c2, 1/K2 = 1/k + c2 and K3 = k. Behind friction, as `backlash` is.

use super::dual::Dual;
use super::port::{Action, CURVE_NUMBERS, Contact};
use super::spec::{Class, Parameter, Port, Reducers, Spec};
use crate::units::Quantity;

/// The effect.
pub static SPEC: Spec = Spec {
    id: "stiffness_curve",
    class: Class::Effect,
    port: Port::Contact,
    reducers: Reducers::TorsionSprings,
    equation: "alpha += a x |x| + b x^3 + c x^2, x = m/M_r, where m is the torque that the spring carries and M_r the reference torque; in pieces alpha += c1 min(|m|, T1) sgn m + c2 min(|m|, T2) sgn m",
    source: "stiffness over the load as makers state it in pieces (K1 up to T1, K2 up to T2, K3: catalogues of strain-wave gears), and smooth: first terms of the curve, of which the odd ones are alike under both signs",
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
        softer(
            "added_compliance_1",
            "compliance c1 = 1/K1 - 1/K2 that it has more up to the break torque T1",
        ),
        softer(
            "added_compliance_2",
            "compliance c2 = 1/K2 - 1/K3 that it has more up to the break torque T2",
        ),
        break_torque("break_torque_1", "break torque T1"),
        break_torque("break_torque_2", "break torque T2"),
    ],
    twins: &[],
    action: Action::Contact(act),
};

const fn part(stem: &'static str, meaning: &'static str) -> Parameter {
    Parameter::size(stem, Quantity::Angle, meaning).within(-1.0, 1.0).likely(-0.1, 0.1)
}

const fn softer(stem: &'static str, meaning: &'static str) -> Parameter {
    Parameter::size(stem, Quantity::AnglePerTorque, meaning).within(-1.0, 1.0).likely(-1e-2, 1e-2)
}

const fn break_torque(stem: &'static str, meaning: &'static str) -> Parameter {
    Parameter::shape(stem, Quantity::Torque, 1.0, meaning).within(1e-9, 1e12).likely(1e-3, 1e3).log()
}

fn act(own: &[Dual], contact: &mut Contact) {
    contact.curves.extend(own.first_chunk());
}

/// What it adds to the angle under a torque, and its derivative by the torque.
pub fn turned(&[a, b, c, reference_Nm, c1, c2, t1, t2]: &[f64; CURVE_NUMBERS], torque_Nm: f64) -> [f64; 2] {
    let (value, by_torque) = parts(torque_Nm, reference_Nm);
    let [first, second] = [t1, t2].map(|at| up_to(torque_Nm, at));
    let of_parts = |[squared, cubed, skewed]: [f64; 3]| a * squared + b * cubed + c * skewed;
    [
        of_parts(value) + c1 * first.carried + c2 * second.carried,
        of_parts(by_torque) + c1 * first.by_torque + c2 * second.by_torque,
    ]
}

/// The derivatives of the angle by its numbers.
pub fn slopes(own: &[f64; CURVE_NUMBERS], torque_Nm: f64) -> [f64; CURVE_NUMBERS] {
    let &[a, b, c, reference_Nm, c1, c2, t1, t2] = own;
    let ([squared, cubed, skewed], by_torque) = parts(torque_Nm, reference_Nm);
    let [first, second] = [t1, t2].map(|at| up_to(torque_Nm, at));
    let bends = a * by_torque[0] + b * by_torque[1] + c * by_torque[2];
    let by_reference = -bends * torque_Nm / reference_Nm;
    [
        squared,
        cubed,
        skewed,
        by_reference,
        first.carried,
        second.carried,
        c1 * first.by_break,
        c2 * second.by_break,
    ]
}

/// The torque m up to a break torque T.
#[derive(Debug, Clone, Copy)]
pub struct UpTo {
    /// min(|m|, T) sgn m, N m.
    pub carried: f64,
    /// Its derivative by m.
    pub by_torque: f64,
    /// Its derivative by T.
    pub by_break: f64,
}

/// The torque that a piece of the curve carries.
pub fn up_to(torque_Nm: f64, break_torque_Nm: f64) -> UpTo {
    if torque_Nm.abs() < break_torque_Nm {
        UpTo { carried: torque_Nm, by_torque: 1.0, by_break: 0.0 }
    } else {
        let sign = 1.0_f64.copysign(torque_Nm);
        UpTo { carried: sign * break_torque_Nm, by_torque: 0.0, by_break: sign }
    }
}

/// x |x|, x^3 and x^2 of a torque, and their derivatives by it.
pub fn parts(torque_Nm: f64, reference_Nm: f64) -> ([f64; 3], [f64; 3]) {
    let x = torque_Nm / reference_Nm;
    ([x * x.abs(), x * x * x, x * x], [2.0 * x.abs(), 3.0 * x * x, 2.0 * x].map(|slope| slope / reference_Nm))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effect::testing::{assert_close, vanishes};

    /// At its reference torque, beyond the first break torque and below the second.
    #[test]
    fn its_parts_add_up() {
        let [angle_rad, by_torque] = turned(&[1e-3, 2e-3, 3e-3, 50.0, 1e-5, 2e-5, 10.0, 90.0], 50.0);
        assert_close(angle_rad, 6e-3 + 1e-4 + 1e-3);
        assert_close(by_torque, (2e-3 + 6e-3 + 6e-3) / 50.0 + 2e-5);
    }

    #[test]
    fn its_derivatives_by_its_numbers_are_exact() {
        let own = [1e-3, 2e-3, 3e-3, 2.0, 1e-2, 2e-2, 0.5, 3.0];
        for torque in [-2.0, 0.3, 1.0] {
            for (place, slope) in slopes(&own, torque).into_iter().enumerate() {
                let at = |h: f64| {
                    let mut moved = own;
                    moved[place] += h;
                    turned(&moved, torque)[0]
                };
                assert!((slope - (at(1e-6) - at(-1e-6)) / 2e-6).abs() < 1e-8, "{place} {torque}");
            }
        }
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

    /// Between zero and T1, between T1 and T2, and beyond.
    #[test]
    fn its_pieces_are_straight() {
        for (torque, expected) in [(1.0, [1.0, 1.0, 0.0]), (-3.0, [-2.0, 0.0, -1.0]), (5.0, [2.0, 0.0, 1.0])]
        {
            let UpTo { carried, by_torque, by_break } = up_to(torque, 2.0);
            for (value, expected) in [carried, by_torque, by_break].into_iter().zip(expected) {
                assert_close(value, expected);
            }
        }
    }

    #[test]
    fn it_vanishes() {
        vanishes(&SPEC);
    }
}
