//! Sideways shift of the output shaft, which a sensor on a lever reads as an angle.
//!
//! The instrument shows alpha + s |M0|. A side load (a coupling or a brake out of line, a belt, a
//! chain, a dead weight on one side) pushes the shaft the same way whatever the sign of the torque,
//! by x in proportion to it. A sensor at the radius h of a lever on the shaft reads x as the angle
//! x/h, so s = x/(h |M0|): x = s h |M0|. At h = 0.1 m, 1 um reads as 2.06 arcsec.

use super::dual::Dual;
use super::port::Action;
use super::spec::{Class, Parameter, Port, Reducers, Spec};
use crate::units::Quantity;

/// The effect.
pub static SPEC: Spec = Spec {
    id: "shaft_shift",
    class: Class::Rig,
    port: Port::Reading,
    reducers: Reducers::All,
    equation: "reading = alpha + s |M0|, where s = x/(h |M0|) of a shaft that moves sideways by x and a sensor at the radius h of a lever",
    source: "geometry of a sensor on a lever",
    tell_tale: "the residual has one sign at torques of both signs, grows in proportion to the torque and does not depend on preload; at torques of one sign it looks like output_torsion",
    parameters: &[Parameter::size(
        "shift",
        Quantity::AnglePerTorque,
        "angle s per torque, alike under both signs; the shift itself is x = s h |M0|",
    )
    .within(-1.0, 1.0)
    .likely(-1e-4, 1e-4)],
    twins: &[],
    action: Action::TorqueReading(act),
};

fn act(own: &[Dual], torque_Nm: Dual, angle_rad: Dual) -> Dual {
    angle_rad + own[0] * torque_Nm.abs()
}

#[cfg(test)]
#[allow(clippy::float_cmp)] // where nothing is rounded
mod tests {
    use super::*;
    use crate::effect::testing::{assert_close, reading_under, vanishes};
    use crate::units::ARCSEC;

    /// 1 um under 2 N m, read at 0.1 m.
    #[test]
    fn a_shift_is_read_over_the_lever() {
        let shift = 1e-6 / 0.1 / 2.0;
        let angle_rad = reading_under(&SPEC, &[shift], 2.0, 3e-4) - 3e-4;
        assert!((angle_rad / ARCSEC - 2.06).abs() < 0.005, "{}", angle_rad / ARCSEC);
    }

    #[test]
    fn it_is_alike_under_both_signs_and_in_proportion() {
        assert_close(reading_under(&SPEC, &[2e-6], 4.0, 1e-4), 1e-4 + 8e-6);
        assert_close(reading_under(&SPEC, &[2e-6], -4.0, -1e-4), -1e-4 + 8e-6);
        assert_close(reading_under(&SPEC, &[-2e-6], -1.0, 1e-4), 1e-4 - 2e-6);
        assert_eq!(reading_under(&SPEC, &[2e-6], 0.0, 1e-4), 1e-4);
    }

    #[test]
    fn it_vanishes() {
        vanishes(&SPEC);
    }
}
