//! Nonlinearity of the angle sensor.
//!
//! The instrument shows alpha + c2 alpha^2 + c3 alpha^3.

use super::dual::Dual;
use super::port::{Action, Row};
use super::spec::{Class, Parameter, Port, Reducers, Spec};
use crate::units::{ARCSEC, Quantity};

/// The effect.
pub static SPEC: Spec = Spec {
    id: "sensor_nonlinearity",
    class: Class::Rig,
    port: Port::Reading,
    reducers: Reducers::All,
    equation: "reading = alpha + c2 alpha^2 + c3 alpha^3",
    source: "data sheets of eddy-current sensors: quadratic and cubic departures from the straight line",
    tell_tale: "the residual depends on the angle alone, whatever the load",
    // The largest that is likely is about 17 arcsec at a reading of 60 arcsec, for each of the two.
    parameters: &[
        Parameter::size("quadratic", Quantity::PerAngle, "coefficient c2 of the squared angle")
            .within(-1e6, 1e6)
            .likely(-1e3, 1e3),
        Parameter::size("cubic", Quantity::PerAngleSquared, "coefficient c3 of the cubed angle")
            .within(-1e10, 1e10)
            .likely(-1e3 / (60.0 * ARCSEC), 1e3 / (60.0 * ARCSEC)),
    ],
    twins: &[],
    action: Action::Reading(act),
};

fn act(own: &[Dual], _: &Row, angle_rad: Dual) -> Dual {
    let squared = angle_rad * angle_rad;
    angle_rad + own[0] * squared + own[1] * (squared * angle_rad)
}

#[cfg(test)]
#[allow(clippy::float_cmp)] // where nothing is rounded
mod tests {
    use super::*;
    use crate::effect::testing::{assert_close, reading, vanishes};

    #[test]
    fn it_adds_square_and_cube() {
        assert_close(reading(&SPEC, &[50.0, 1e6], -1e-4), -1e-4 + 50.0 * 1e-8 - 1e6 * 1e-12);
    }

    #[test]
    fn it_vanishes() {
        vanishes(&SPEC);
    }
}
