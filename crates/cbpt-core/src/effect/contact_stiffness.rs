//! Contact stiffness: one factor scales every stiffness k.
//!
//! k -> s k. The factor covers errors of material, conformity and finish; a log-normal prior suits it.

use super::dual::Dual;
use super::port::{Action, Contact};
use super::spec::{Class, Parameter, Port, Reducers, Spec};

/// The effect.
pub static SPEC: Spec = Spec {
    id: "contact_stiffness",
    class: Class::Parameter,
    port: Port::Contact,
    reducers: Reducers::All,
    equation: "k -> s k, with one factor s for all pairs",
    source: "scaling of Hertz's solution: Johnson, Contact Mechanics (1985), section 4.2",
    tell_tale: "the residual is a constant share of the angle at low torque",
    parameters: &[Parameter::gain("stiffness_scale", "factor s on the stiffness of every contact")
        .within(1e-2, 1e2)
        .likely(0.2, 5.0)],
    twins: &["sensor_gain"],
    action: Action::Contact(act),
};

fn act(own: &[Dual], contact: &mut Contact) {
    contact.stiffness_scale *= own[0];
}

#[cfg(test)]
#[allow(clippy::float_cmp)] // where nothing is rounded
mod tests {
    use super::*;
    use crate::effect::testing::{contact, vanishes};

    #[test]
    fn it_scales_every_stiffness() {
        assert_eq!(contact(&SPEC, &[0.8]).stiffness_scale.value, 0.8);
    }

    #[test]
    fn it_vanishes() {
        vanishes(&SPEC);
    }
}
