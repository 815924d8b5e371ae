//! Wear: preload lost with time.
//!
//! N_Z -> N_Z (1 - w t), t since the table's first reading.

use super::dual::Dual;
use super::port::{Action, Load, Row};
use super::spec::{Class, Parameter, Port, Reducers, Spec};
use crate::units::Quantity;

/// The effect.
pub static SPEC: Spec = Spec {
    id: "wear",
    class: Class::Effect,
    port: Port::Load,
    reducers: Reducers::BallDrives,
    equation: "N_Z -> N_Z (1 - w t), where t is the time since the first reading of the table",
    source: "linear wear: Archard, J. Appl. Phys. 24 (1953) 981",
    tell_tale: "the residual grows slowly over the whole table",
    parameters: &[Parameter::size(
        "lost_share",
        Quantity::PerTime,
        "share w of the preload that is lost per unit of time",
    )
    .within(0.0, 1.0)
    .likely(0.0, 1e-3)],
    twins: &[],
    action: Action::Load(act),
};

fn act(own: &[Dual], row: &Row, load: &mut Load) {
    load.preload_N *= own[0] * -row.time_s + 1.0;
}

#[cfg(test)]
#[allow(clippy::float_cmp)] // where nothing is rounded
mod tests {
    use super::*;
    use crate::effect::testing::{ROW, assert_close, load, vanishes};

    /// A share of 1e-4 a second is 5 % after 500 s.
    #[test]
    fn it_takes_preload_with_time() {
        assert_close(load(&SPEC, &[1e-4]).preload_N.value, 0.95 * ROW.preload_N);
    }

    #[test]
    fn it_vanishes() {
        vanishes(&SPEC);
    }
}
