//! An offset of its own in each run.
//!
//! A variance component: the offsets of the runs are drawn from one distribution. The model adds nothing to the mean; the
//! statistics use the spread, and this table states its range.

use super::port::Action;
use super::spec::{Class, Parameter, Port, Reducers, Spec};
use crate::units::{ARCSEC, Quantity};

/// The effect.
pub static SPEC: Spec = Spec {
    id: "run_offset",
    class: Class::Rig,
    port: Port::Reading,
    reducers: Reducers::All,
    equation: "reading = alpha + z_run, where z_run is normally distributed with the spread as standard deviation",
    source: "zeroing of the instrument at the start of a run",
    tell_tale: "the residual is constant within a run and differs between runs",
    parameters: &[Parameter::size(
        "spread",
        Quantity::Angle,
        "standard deviation of the offsets of the runs",
    )
    .within(0.0, 1.0)
    .likely(0.0, 10.0 * ARCSEC)],
    twins: &[],
    action: Action::Spread,
};

#[cfg(test)]
#[allow(clippy::float_cmp)] // where nothing is rounded
mod tests {
    use super::*;
    use crate::effect::testing::vanishes;

    #[test]
    fn it_adds_nothing_to_the_mean() {
        assert!(matches!(SPEC.action, Action::Spread));
    }

    #[test]
    fn it_vanishes() {
        vanishes(&SPEC);
    }
}
