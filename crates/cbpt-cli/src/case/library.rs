//! The core's library of effects as sections of keys: each effect has the keys of its parameters.

use std::ops::Bound::{self, Included, Unbounded};
use std::sync::LazyLock;

use cbpt_core::effect::{self, LIBRARY, Parameter, Scale, Spec};

use super::fields::PORTS;
use super::keys::{Key, Kind, Section, Value};
use super::units::Dimension;

/// Ids of the built-in effects.
pub static EFFECTS: LazyLock<Vec<&'static str>> =
    LazyLock::new(|| LIBRARY.into_iter().map(|spec| spec.id).collect());

static SECTIONS: LazyLock<Vec<Section>> = LazyLock::new(|| LIBRARY.into_iter().map(section).collect());

/// Effects with their sections.
pub(super) fn built_in() -> impl Iterator<Item = (&'static Spec, &'static Section)> {
    LIBRARY.into_iter().zip(&*SECTIONS)
}

/// The effect of an id with its section.
pub(super) fn find(id: &str) -> Option<(&'static Spec, &'static Section)> {
    built_in().find(|(spec, _)| spec.id == id)
}

/// The keys of an effect's parameters.
pub(super) fn parameters(section: &'static Section) -> impl Iterator<Item = &'static Key> {
    section.keys.iter().filter(|key| !matches!(key.kind, Kind::Text | Kind::Choice(_)))
}

fn section(spec: &'static Spec) -> Section {
    let id = Key::text("id", spec.id, "id of the effect");
    let port = Key::choice("port", PORTS, "where the effect acts, which its id says already").optional();
    let numbers = spec.parameters.iter().map(key);
    Section {
        name: "effect",
        required: false,
        mechanics: false,
        meaning: spec.equation,
        keys: [id, port].into_iter().chain(numbers).collect(),
    }
}

fn key(parameter: &'static Parameter) -> Key {
    let (kind, default) = match (parameter.scale, dimension(parameter.dimension)) {
        // A whole number that is not negative, checked by the core's table.
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        (Scale::Fixed, _) => (Kind::Count, Value::Count(parameter.neutral as u32)),
        (_, None) => (Kind::Number, Value::Real(parameter.neutral)),
        (_, Some(dimension)) => {
            (Kind::Quantity(dimension, parameter.display.suffix), Value::Real(parameter.neutral))
        }
    };
    let bound = |value: f64| -> Bound<f64> { if value.is_finite() { Included(value) } else { Unbounded } };
    Key::new(parameter.stem, kind, default, parameter.meaning)
        .within((bound(parameter.lower), bound(parameter.upper)))
        .by_default()
}

fn dimension(of_core: effect::Dimension) -> Option<Dimension> {
    use effect::Dimension as Core;
    Some(match of_core {
        Core::Number => return None,
        Core::Length => Dimension::Length,
        Core::Angle => Dimension::Angle,
        Core::PerAngle => Dimension::PerAngle,
        Core::PerAngleSquared => Dimension::PerAngleSquared,
        Core::AnglePerTime => Dimension::AnglePerTime,
        Core::AnglePerTemperature => Dimension::AnglePerTemperature,
        Core::AnglePerTorque => Dimension::AnglePerTorque,
        Core::Force => Dimension::Force,
        Core::Torque => Dimension::Torque,
        Core::PerTorque => Dimension::PerTorque,
        Core::ForcePerLength => Dimension::ForcePerLength,
        Core::ForcePerTemperature => Dimension::ForcePerTemperature,
        Core::PerTime => Dimension::PerTime,
        Core::Time => Dimension::Time,
    })
}
