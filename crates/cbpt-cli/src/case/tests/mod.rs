//! Case files: what is read, what is refused and how it is told, and that nothing is lost or panics.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test may fail this way")]
#![allow(clippy::float_cmp, reason = "the units promise the very same number")]

mod edited;
mod helped;
mod mistakes;
mod random;
mod reading;
mod table;

use super::Case;

/// A drive as a user writes it.
const RING: &str = "\
[material]
youngs_modulus_GPa = 208.0
poissons_ratio = 0.3

[deceleration]
ball_count = 20
short_amplitude_coefficient = 0.5
rolling_circle_radius_mm = 2.5
ball_radius_mm = 1.2
groove_conformity = 1.08
contact_angle_deg = 45.0

[equal_speed]
kind = \"ring_groove\"
ball_count = 12
pitch_radius_mm = 35
ball_radius_mm = 1.2
groove_conformity = 1.08
contact_angle_deg = 45.0

[uncertainty]
contact_stiffness_rel = 0.10
sensor_gain_rel = 0.05
";

fn read(text: &str) -> Case {
    Case::from_toml(text, "drive.toml").unwrap_or_else(|error| panic!("{error}"))
}

/// The example with one line in place of another.
fn edited(line: &str, by: &str) -> String {
    assert!(RING.contains(line), "{line}");
    RING.replacen(line, by, 1)
}

/// The messages on a text.
fn messages(text: &str) -> Vec<String> {
    let error = Case::from_toml(text, "drive.toml").unwrap_err();
    assert_eq!(error.to_string().lines().count(), error.mistakes.len());
    error.to_string().lines().map(str::to_owned).collect()
}

/// The only message on a text.
fn message(text: &str) -> String {
    let messages = messages(text);
    assert_eq!(messages.len(), 1, "{messages:#?}");
    messages[0].clone()
}
