//! Contact angle: every contact angle differs from its nominal value by the same amount.
//!
//! beta -> beta + d beta in geometry and contact alike, so undercut and missing walls follow it.

use super::dual::Dual;
use super::port::{Action, Contact};
use super::spec::{Class, Parameter, Port, Reducers, Spec};
use crate::units::{DEGREE, Quantity};

/// The effect.
pub static SPEC: Spec = Spec {
    id: "contact_angle",
    class: Class::Parameter,
    port: Port::Contact,
    reducers: Reducers::BallDrives,
    equation: "beta -> beta + d_beta at every contact",
    source: "geometry of the groove section",
    tell_tale: "the onset of contact loss moves to another torque",
    parameters: &[Parameter::size("contact_angle_shift", Quantity::Angle, "added to every contact angle")
        .shown("deg")
        .within(-40.0 * DEGREE, 40.0 * DEGREE)
        .likely(-0.17, 0.17)],
    twins: &["torque_scale", "preload_scale", "preload_loss"],
    action: Action::Contact(act),
};

fn act(own: &[Dual], contact: &mut Contact) {
    contact.contact_angle_shift_rad += own[0];
}

#[cfg(test)]
#[allow(clippy::float_cmp)] // where nothing is rounded
mod tests {
    use super::*;
    use crate::effect::testing::{contact, vanishes};

    #[test]
    fn it_shifts_every_angle() {
        assert_eq!(contact(&SPEC, &[0.02]).contact_angle_shift_rad.value, 0.02);
    }

    #[test]
    fn it_vanishes() {
        vanishes(&SPEC);
    }
}
