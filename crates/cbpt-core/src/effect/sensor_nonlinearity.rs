//! Nonlinearity of the angle sensor.
//!
//! The instrument shows alpha + c2 alpha^2 + c3 alpha^3 + s (tanh(alpha/k) - alpha/k). The last term is the S of a sensor that
//! flattens towards the ends of its range: a cube near 0, and one slope the other beyond k.

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
    equation: "reading = alpha + c2 alpha^2 + c3 alpha^3 + s (tanh(alpha/k) - alpha/k)",
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
        Parameter::size("flattening", Quantity::Angle, "size s of the departure that flattens beyond k")
            .within(-1.0, 1.0)
            .likely(-60.0 * ARCSEC, 60.0 * ARCSEC),
        Parameter::shape("knee", Quantity::Angle, 60.0 * ARCSEC, "angle k beyond which it flattens")
            .within(1e-9, 1.0)
            .likely(10.0 * ARCSEC, 200.0 * ARCSEC)
            .log(),
    ],
    twins: &[],
    action: Action::Reading(act),
};

fn act(own: &[Dual], _: &Row, angle_rad: Dual) -> Dual {
    let squared = angle_rad * angle_rad;
    let share = angle_rad.quotient(&own[3]);
    let flat = share.value.tanh();
    let departure = share.chain(flat - share.value, -flat * flat);
    angle_rad + own[0] * squared + own[1] * (squared * angle_rad) + own[2] * departure
}

#[cfg(test)]
#[allow(clippy::float_cmp)] // where nothing is rounded
mod tests {
    use super::*;
    use crate::effect::testing::{assert_close, reading, vanishes};

    #[test]
    fn it_adds_square_and_cube() {
        assert_close(reading(&SPEC, &[50.0, 1e6, 0.0, 1e-4], -1e-4), -1e-4 + 50.0 * 1e-8 - 1e6 * 1e-12);
    }

    /// Near 0 it is the cube -s (alpha/k)^3/3; far beyond k it is a straight line.
    #[test]
    fn it_flattens_beyond_the_knee() {
        let (s, k) = (3e-6, 1e-4);
        assert_close(
            reading(&SPEC, &[0.0, 0.0, s, k], 1e-6),
            1e-6 - s * 1e-6 / 3.0 + s * 1e-10 * (2.0 / 15.0),
        );
        assert_close(reading(&SPEC, &[0.0, 0.0, s, k], -4e-3), -4e-3 + s * 39.0);
    }

    #[test]
    fn it_vanishes() {
        vanishes(&SPEC);
    }
}
