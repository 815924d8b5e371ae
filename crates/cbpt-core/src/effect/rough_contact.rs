//! Rough contacts: a law with another exponent.
//!
//! N = k delta_0^1.5 (delta/delta_0)^n with delta_0 = 1 um, where Hertz's force is kept.

use super::dual::Dual;
use super::port::{Action, Contact};
use super::spec::{Class, Parameter, Port, Reducers, Spec};
use crate::pair::HERTZ_EXPONENT;
use crate::units::Quantity;

/// The effect.
pub static SPEC: Spec = Spec {
    id: "rough_contact",
    class: Class::Effect,
    port: Port::Contact,
    reducers: Reducers::BallDrives,
    equation: "N = k delta_0^1.5 (delta/delta_0)^n, delta_0 = 1 um",
    source: "rough surfaces in contact: Greenwood and Tripp, J. Appl. Mech. 34 (1967) 153",
    tell_tale: "the drive is softer at low preload",
    parameters: &[Parameter {
        neutral: HERTZ_EXPONENT,
        ..Parameter::size(
            "exponent",
            Quantity::Number,
            "exponent n of force as a function of deformation; 1.5 for a Hertz contact",
        )
    }
    .within(1.1, 4.0)
    .likely(1.3, 2.5)],
    twins: &[],
    action: Action::Contact(act),
};

fn act(own: &[Dual], contact: &mut Contact) {
    contact.exponent += own[0] + -HERTZ_EXPONENT;
}

#[cfg(test)]
#[allow(clippy::float_cmp)] // where nothing is rounded
mod tests {
    use super::*;
    use crate::effect::testing::{assert_close, contact, vanishes};

    #[test]
    fn it_sets_the_exponent() {
        assert_close(contact(&SPEC, &[1.9]).exponent.value, 1.9);
    }

    #[test]
    fn it_vanishes() {
        vanishes(&SPEC);
    }
}
