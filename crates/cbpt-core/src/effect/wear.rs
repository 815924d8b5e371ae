//! Wear: preload lost with time.
//!
//! N_Z -> N_Z (1 - w t), t since the table's first reading.

use super::dual::Dual;
use super::port::{Action, Load, Row};
use super::spec::{Class, Dimension, Parameter, Port, Spec};

/// The effect.
pub static SPEC: Spec = Spec {
    id: "wear",
    class: Class::Effect,
    port: Port::Load,
    equation: "N_Z -> N_Z (1 - w t)",
    source: "linear wear: Archard, J. Appl. Phys. 24 (1953) 981",
    tell_tale: "a slow trend one way",
    parameters: &[Parameter::size(
        "lost_share",
        Dimension::PerTime,
        "share w of the preload lost in a second",
    )
    .within(0.0, 1.0)
    .likely(0.0, 1e-4)],
    twins: &[],
    action: Action::Load(act),
};

fn act(own: &[Dual], row: &Row, load: &mut Load) {
    load.preload_N *= own[0] * -row.time_s + 1.0;
}
