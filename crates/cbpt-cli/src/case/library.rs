//! The core's library of effects as sections of keys: each effect has the keys of its parameters.

use std::ops::Bound::{self, Included, Unbounded};
use std::sync::LazyLock;

use cbpt_core::effect::{LIBRARY, Parameter, Scale, Spec};
use cbpt_core::units::Quantity;

use super::keys::{Key, Kind, PORTS, Section, Value};

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
    let port = Key::choice("port", PORTS, "where the effect acts; its id fixes it").optional();
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
    let (kind, default) = match (parameter.scale, parameter.quantity) {
        // A whole number that is not negative, checked by the core's table.
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        (Scale::Fixed, _) => (Kind::Count, Value::Count(parameter.neutral as u32)),
        (_, Quantity::Number) => (Kind::Number, Value::Real(parameter.neutral)),
        (_, quantity) => {
            (Kind::Quantity(quantity, parameter.display().symbol), Value::Real(parameter.neutral))
        }
    };
    let bound = |value: f64| -> Bound<f64> { if value.is_finite() { Included(value) } else { Unbounded } };
    Key::new(parameter.stem, kind, default, parameter.meaning)
        .within((bound(parameter.lower), bound(parameter.upper)))
        .by_default()
}
