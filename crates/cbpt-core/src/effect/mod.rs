//! The library of effects that a nominal drive on an ideal rig leaves out: one physical term per file.
//!
//! Each file holds one effect: equation, source, tell-tale, parameters, and its two tests, of a value and of the limit
//! where it vanishes. [`LIBRARY`] is the one table of them; case files, Python, the page and the documentation follow it.
//!
//! - [`spec`]: the description of an effect and of its parameters;
//! - [`port`]: what it is given and may change where it acts;
//! - [`dual`]: numbers that carry derivatives, in which all formulas are written;
//! - `friction_limit`: the parameters of the largest friction torque;
//! - [`lag`]: the temperature of a part that follows the measured one;
//! - `play`: what follows a value through a slack;
//! - [`torque_rate`]: how fast the torque of a run changes at its readings;
//! - [`own`]: effects of the user's own, which are no part of the table.
//!
//! Ports act in the order load, gap, contact, series, reading; the errors of torque and preload readings change the row
//! before the load. Within a port the order is that of the table, so no result depends on the order of a list. Effects
//! know nothing of pairs and solvers: [`crate::predict`] applies them.

pub mod dual;
mod friction_limit;
pub mod lag;
pub mod own;
mod play;
pub mod port;
pub mod spec;
pub mod torque_rate;

pub mod backlash;
pub mod ball_diameter_lot;
pub mod bearing_play;
pub mod breakaway_friction;
pub mod contact_angle;
pub mod contact_stiffness;
pub mod creep;
pub mod damping;
pub mod distributed_friction;
pub mod drift;
pub mod eccentric_bearing;
pub mod eccentricity_error;
pub mod friction_hysteresis;
pub mod groove_pitch_error;
pub mod hard_stop;
pub mod loose_fixture;
pub mod output_torsion;
pub mod plate_tilt;
pub mod preload_crosstalk;
pub mod preload_loss;
pub mod preload_scale;
pub mod preload_spring;
pub mod rate_friction;
pub mod rough_contact;
pub mod run_in;
pub mod run_offset;
pub mod sensor_gain;
pub mod sensor_hysteresis;
pub mod sensor_nonlinearity;
pub mod shaft_shift;
pub mod span_drift;
pub mod stiffness_curve;
pub mod thermal_preload;
pub mod torque_hysteresis;
pub mod torque_lag;
pub mod torque_scale;
pub mod torque_zero;
pub mod wear;

#[cfg(test)]
mod testing;

pub use own::{AddsTo, OwnEffect, OwnParameter};
pub use spec::{Class, Parameter, Port, Reducers, Scale, Spec};

/// Every effect, in the order in which all documents list them.
pub static LIBRARY: [&Spec; 38] = [
    &contact_stiffness::SPEC,
    &contact_angle::SPEC,
    &torque_scale::SPEC,
    &torque_zero::SPEC,
    &torque_lag::SPEC,
    &torque_hysteresis::SPEC,
    &preload_scale::SPEC,
    &preload_crosstalk::SPEC,
    &shaft_shift::SPEC,
    &loose_fixture::SPEC,
    &sensor_hysteresis::SPEC,
    &sensor_gain::SPEC,
    &sensor_nonlinearity::SPEC,
    &run_offset::SPEC,
    &drift::SPEC,
    &span_drift::SPEC,
    &eccentric_bearing::SPEC,
    &bearing_play::SPEC,
    &backlash::SPEC,
    &output_torsion::SPEC,
    &stiffness_curve::SPEC,
    &hard_stop::SPEC,
    &friction_hysteresis::SPEC,
    &distributed_friction::SPEC,
    &rate_friction::SPEC,
    &breakaway_friction::SPEC,
    &damping::SPEC,
    &preload_loss::SPEC,
    &preload_spring::SPEC,
    &thermal_preload::SPEC,
    &eccentricity_error::SPEC,
    &groove_pitch_error::SPEC,
    &ball_diameter_lot::SPEC,
    &plate_tilt::SPEC,
    &rough_contact::SPEC,
    &run_in::SPEC,
    &wear::SPEC,
    &creep::SPEC,
];

/// Effects that rub on the rotation, and so make a run a history.
pub const RUBS: [&str; 4] = [
    friction_hysteresis::SPEC.id,
    distributed_friction::SPEC.id,
    rate_friction::SPEC.id,
    breakaway_friction::SPEC.id,
];

/// The effect of this id.
pub fn find(id: &str) -> Option<&'static Spec> {
    LIBRARY.into_iter().find(|spec| spec.id == id)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_is_sound() {
        for (place, spec) in LIBRARY.iter().enumerate() {
            assert!(LIBRARY[..place].iter().all(|other| other.id != spec.id), "{} twice", spec.id);
            assert!(find(spec.id).is_some_and(|found| std::ptr::eq(found, *spec)));
            assert!(spec.parameters.iter().any(|parameter| parameter.is_size), "{} has no size", spec.id);
            assert!(["parameter", "rig", "effect"].contains(&spec.class.name()), "{}", spec.id);
            assert!(
                ["load", "gap", "contact", "series", "reading"].contains(&spec.port.name()),
                "{}",
                spec.id
            );
            for parameter in spec.parameters {
                let name = parameter.name();
                let (low, high) = parameter.range;
                assert!(parameter.lower <= low && low < high && high <= parameter.upper, "{name}");
                assert!(
                    parameter.lower <= parameter.neutral && parameter.neutral <= parameter.upper,
                    "{name}"
                );
                assert!(parameter.scale != Scale::Log || low > 0.0, "{name}");
                let names = spec.parameters.iter().filter(|other| other.name() == name).count();
                assert_eq!(names, 1, "{name} twice");
            }
        }
    }

    #[test]
    fn twins_are_twins_of_each_other() {
        for spec in LIBRARY {
            let twinless = spec.parameters.iter().filter(|parameter| parameter.twinless).count();
            assert!(twinless == 0 || !spec.twins.is_empty(), "{} has no twins at all", spec.id);
            for twin in spec.twins {
                assert!(find(twin).is_some_and(|twin| twin.twins.contains(&spec.id)), "{} {twin}", spec.id);
            }
        }
    }
}
