//! Creep under torque.
//!
//! alpha += c M0 ln(1 + t/tau), t since the run began.

use super::dual::Dual;
use super::port::{Action, DriveNumbers, Row};
use super::spec::{Class, Dimension, Parameter, Port, Reducers, Spec};

/// The effect.
pub static SPEC: Spec = Spec {
    id: "creep",
    class: Class::Effect,
    port: Port::Series,
    reducers: Reducers::All,
    equation: "alpha += c M0 ln(1 + t/tau), t since the run began",
    source: "logarithmic creep: Phillips, Phil. Mag. 9 (1905) 513",
    tell_tale: "grows at constant torque",
    parameters: &[
        Parameter::size("compliance", Dimension::AnglePerTorque, "growth c of the compliance")
            .within(0.0, 1.0)
            .likely(1e-9, 1e-5)
            .log(),
        Parameter::shape("time_constant", Dimension::Time, 20.0, "time tau after which the growth slows")
            .within(1e-3, 1e7)
            .likely(1.0, 1e4)
            .log(),
    ],
    twins: &[],
    action: Action::Series(act),
};

fn act(own: &[Dual], row: &Row, _: &DriveNumbers, torque_Nm: Dual) -> Dual {
    own[0] * torque_Nm * (own[1].recip() * row.run_time_s).ln_1p()
}

#[cfg(test)]
#[allow(clippy::float_cmp)] // where nothing is rounded
mod tests {
    use super::*;
    use crate::effect::testing::{assert_close, series, vanishes};

    /// At a run time of 60 s, ln(1 + 60/20) = ln 4.
    #[test]
    fn it_grows_with_the_logarithm_of_time() {
        assert_close(series(&SPEC, &[1e-6, 20.0], 5.0), 5e-6 * 4_f64.ln());
    }

    #[test]
    fn it_vanishes() {
        vanishes(&SPEC);
    }
}
