//! Hertz's contact of two smooth bodies against an independent set of elliptic integrals (the crate `ellip`, in
//! Carlson's symmetric form, which needs no 1 - m and so keeps its digits from a circle to a line).
//!
//! Source: K. L. Johnson, Contact Mechanics (1985), equations 4.26 and 4.28 to 4.30.

use crate::common;
use std::f64::consts::PI;

use cbpt_core::hertz::{HertzContact, in_series};
use ellip::{elliprd, elliprf, elliprg};
use proptest::prelude::*;

const CONTACT_MODULUS_PA: f64 = 1.1e11;

/// Largest relative error that a contact may have anywhere; it is measured to be 5e-15 at most.
const TOLERANCE: f64 = 1e-13;

fn relative(found: f64, expected: f64) -> f64 {
    (found / expected - 1.0).abs()
}

/// Complete elliptic integrals of parameter m = 1 - 1/kappa^2: K, E, D = (K - E)/m and B = (E - (1 - m) K)/m.
struct Integrals {
    k: f64,
    e: f64,
    d: f64,
    b: f64,
}

impl Integrals {
    fn of_ellipse(kappa: f64) -> Self {
        let complement = (1.0 / kappa).powi(2);
        let k = elliprf(0.0, complement, 1.0).unwrap();
        let e = 2.0 * elliprg(0.0, complement, 1.0).unwrap();
        let d = elliprd(0.0, complement, 1.0).unwrap() / 3.0;
        Self { k, e, d, b: e - complement * d }
    }
}

/// Largest relative error of a contact in the equations that define it, at a force of 1 kN.
///
/// The pressure p sqrt(1 - x^2/a^2 - y^2/b^2) must bend both bodies to the two curvatures and to the approach:
/// - weak curvature:   c = 2 p b D / (E* a^2);
/// - strong curvature: c = 2 p B / (E* b);
/// - approach:         delta = p b K / E*.
fn largest_error(weak: f64, strong: f64, modulus: f64) -> f64 {
    error_of(&HertzContact::new(weak, strong, modulus).unwrap(), weak, strong, modulus)
}

fn error_of(contact: &HertzContact, weak: f64, strong: f64, modulus: f64) -> f64 {
    let force = 1e3;
    let loaded = contact.under(force);
    let (a, b) = (loaded.major_semi_axis_m, loaded.minor_semi_axis_m);
    let pressure = 1.5 * force / (PI * a * b);
    let integrals = Integrals::of_ellipse(contact.ellipticity);
    [
        relative(2.0 * pressure * b * integrals.d / (modulus * a * a), weak),
        relative(2.0 * pressure * integrals.b / (modulus * b), strong),
        relative(pressure * b * integrals.k / modulus, loaded.approach_m),
        relative(contact.compliance * contact.stiffness().powf(2.0 / 3.0), 1.0),
        relative(contact.stiffness() * loaded.approach_m.powf(1.5), force),
        relative(loaded.peak_pressure_Pa, pressure),
        relative(a / b, contact.ellipticity),
        // The closed form of the stiffness, in which E stands instead of B and D.
        relative(
            2.0 * PI / 3.0 * modulus * contact.ellipticity * (2.0 * integrals.e / (weak + strong)).sqrt()
                / integrals.k.powf(1.5),
            contact.stiffness(),
        ),
    ]
    .into_iter()
    .fold(0.0, f64::max)
}

/// Ratios of curvatures from a sphere to a line: everywhere, ever closer to 1, and closely about 1 + 7.5e-4, where
/// m = 1e-3 and a series hands over to the arithmetic-geometric mean.
fn ratios() -> impl Iterator<Item = f64> {
    let wide = (0..=6000).map(|i| 10_f64.powf(f64::from(i) * 1e-3));
    let near_circle = (0..=480).map(|i| 1.0 + 10_f64.powf(-16.0 + f64::from(i) / 30.0).min(1.0));
    let hand_over = (0..=2000).map(|i| 1.0 + 7.5e-4 * (0.99 + 1e-5 * f64::from(i)));
    wide.chain(near_circle).chain(hand_over)
}

#[test]
fn the_defining_equations_hold_from_circle_to_line() {
    for ratio in ratios() {
        let error = largest_error(700.0, 700.0 * ratio, CONTACT_MODULUS_PA);
        assert!(error <= TOLERANCE, "ratio {ratio}: {error:e}");
    }
}

/// A circle is the limit of the ellipse, and no step shows where one formula hands over to the other: the stiffness at
/// a constant sum of curvatures changes by second order in the ratio near 1 and smoothly elsewhere.
#[test]
fn the_stiffness_is_smooth_across_the_hand_over() {
    let stiffness = |ratio: f64| {
        let weak = 2.0 / (1.0 + ratio);
        HertzContact::new(weak, weak * ratio, 1.0).unwrap().stiffness()
    };
    let step = 1e-6;
    for i in 0..200 {
        let ratio = 1.0 + 7.5e-4 + f64::from(i - 100) * step;
        let [before, here, after] = [ratio - step, ratio, ratio + step].map(stiffness);
        assert!(((before - 2.0 * here + after) / here).abs() < 1e-13 + step * step, "ratio {ratio}");
    }
}

/// Hertz's sphere of radius r on a flat: k = 4/3 E* sqrt(r), a^3 = 3 N r/(4 E*), p^3 = 6 N E*^2/(pi^3 r^2).
#[test]
fn a_sphere_on_a_flat_is_a_circle() {
    for radius in [1e-6, 1.5e-3, 0.2, 30.0] {
        let contact = HertzContact::new(1.0 / radius, 1.0 / radius, CONTACT_MODULUS_PA).unwrap();
        assert!(relative(contact.stiffness(), 4.0 / 3.0 * CONTACT_MODULUS_PA * radius.sqrt()) < 1e-15 * 4.0);
        assert!(relative(contact.ellipticity, 1.0) < 1e-15);
        let loaded = contact.under(250.0);
        let semi_axis = (0.75 * 250.0 * radius / CONTACT_MODULUS_PA).cbrt();
        let pressure = (6.0 * 250.0 * CONTACT_MODULUS_PA.powi(2) / (PI.powi(3) * radius * radius)).cbrt();
        assert!(relative(loaded.major_semi_axis_m, semi_axis) < 1e-14);
        assert!(relative(loaded.minor_semi_axis_m, semi_axis) < 1e-14);
        assert!(relative(loaded.peak_pressure_Pa, pressure) < 1e-14);
        assert!(relative(loaded.approach_m, semi_axis * semi_axis / radius) < 1e-14);
    }
}

/// Without a force bodies touch in a point, without pressure.
#[test]
fn no_force_is_no_contact_area() {
    let loaded = HertzContact::new(300.0, 900.0, CONTACT_MODULUS_PA).unwrap().under(0.0);
    let all =
        [loaded.approach_m, loaded.major_semi_axis_m, loaded.minor_semi_axis_m, loaded.peak_pressure_Pa];
    assert!(all.iter().all(|value| value.abs() < f64::MIN_POSITIVE), "{loaded:?}");
}

/// Only a point contact of two bodies that curve towards each other is an ellipse.
#[test]
fn a_curvature_or_modulus_that_cannot_be_is_refused() {
    for bad in [0.0, -0.0, -5.0, f64::INFINITY, f64::NEG_INFINITY, f64::NAN] {
        assert_eq!(HertzContact::new(bad, 400.0, CONTACT_MODULUS_PA), None, "{bad}");
        assert_eq!(HertzContact::new(400.0, bad, CONTACT_MODULUS_PA), None, "{bad}");
        assert_eq!(HertzContact::new(bad, bad, CONTACT_MODULUS_PA), None, "{bad}");
        assert_eq!(HertzContact::new(400.0, 400.0, bad), None, "{bad}");
    }
}

/// Contacts in series carry one force and add their approaches; a missing one leaves nothing.
#[test]
fn contacts_in_series_add_their_compliances() {
    let contact = |curvature: f64| HertzContact::new(curvature, 50.0, CONTACT_MODULUS_PA);
    for (a, b) in [(700.0, 700.0), (60.0, 9000.0), (1e-3, 1e6)] {
        let both = in_series([contact(a), contact(b)]);
        let approach = |k: f64| (55.0_f64 / k).powf(2.0 / 3.0);
        let [first, second] = [a, b].map(|curvature| contact(curvature).unwrap().stiffness());
        assert!(relative(approach(both), approach(first) + approach(second)) < 1e-14);
        assert!(relative(in_series([contact(b), contact(a)]), both) < 1e-15);
        assert!(both < first.min(second));
    }
    for missing in [[None, contact(700.0)], [contact(700.0), None], [None, None]] {
        assert!(in_series(missing).abs() < f64::MIN_POSITIVE);
    }
}

/// Contacts made together satisfy the same equations as those made alone, over the whole range and beyond the table.
#[test]
fn contacts_made_together_satisfy_the_defining_equations() {
    let across = 50.0;
    let along: Vec<f64> =
        ratios().filter(|ratio| *ratio > 1.0).flat_map(|ratio| [across * ratio, across / ratio]).collect();
    let contacts = HertzContact::many(&along, across, CONTACT_MODULUS_PA);
    assert_eq!(contacts.len(), along.len());
    for (contact, along) in contacts.iter().zip(along) {
        let (weak, strong) = (across.min(along), across.max(along));
        let error = error_of(&contact.unwrap(), weak, strong, CONTACT_MODULUS_PA);
        assert!(error < TOLERANCE, "{weak} {strong}: {error:e}");
    }
}

/// What is no ellipse is none among others either, and its neighbours are as they would be alone.
#[test]
fn what_is_no_contact_is_none_among_others() {
    let along = [700.0, f64::NAN, -1.0, 0.0, f64::INFINITY, 1e-300, 1e300, 700.0];
    for (across, modulus) in
        [(50.0, 1.1e11), (f64::NAN, 1.1e11), (50.0, f64::NAN), (50.0, 1e300), (0.0, 1.1e11)]
    {
        for (contact, along) in HertzContact::many(&along, across, modulus).iter().zip(along) {
            match (contact, HertzContact::new(along, across, modulus)) {
                (Some(contact), Some(alone)) => {
                    let same = relative(contact.stiffness(), alone.stiffness()) < TOLERANCE;
                    assert!(same || !alone.stiffness().is_normal(), "{along} {across} {modulus}");
                }
                (found, alone) => assert_eq!(found.is_some(), alone.is_some(), "{along} {across} {modulus}"),
            }
        }
    }
}

proptest! {
    #![proptest_config(common::config(2000))]

    /// The defining equations for bodies of any size and stiffness.
    #[test]
    fn any_contact_satisfies_the_defining_equations(
        weak in -2.0..7.0_f64,
        ratio in prop_oneof![0.0..6.0_f64, (-16.0..0.0_f64).prop_map(|log| 10_f64.powf(log))],
        modulus in 6.0..13.0_f64,
    ) {
        let (weak, modulus) = (10_f64.powf(weak), 10_f64.powf(modulus));
        let error = largest_error(weak, weak * 10_f64.powf(ratio), modulus);
        prop_assert!(error <= TOLERANCE, "{error:e}");
    }

    /// Which axis is called the first is a matter of names.
    #[test]
    fn the_axes_exchange(first in 1.0..1e6_f64, second in 1.0..1e6_f64) {
        let contact = HertzContact::new(first, second, CONTACT_MODULUS_PA);
        prop_assert!(contact.is_some());
        prop_assert_eq!(contact, HertzContact::new(second, first, CONTACT_MODULUS_PA));
    }

    /// Bodies of the same shape and another size or stiffness: k goes with E* and with the square root of the size, and
    /// the ellipse keeps its shape.
    #[test]
    fn similar_contacts_scale(
        first in 1.0..1e6_f64,
        second in 1.0..1e6_f64,
        size in 0.01..100.0_f64,
        stiffer in 0.01..100.0_f64,
    ) {
        let contact = HertzContact::new(first, second, CONTACT_MODULUS_PA).unwrap();
        let other = HertzContact::new(first / size, second / size, CONTACT_MODULUS_PA * stiffer).unwrap();
        prop_assert!(relative(other.stiffness(), contact.stiffness() * stiffer * size.sqrt()) < 1e-13);
        prop_assert!(relative(other.ellipticity, contact.ellipticity) < 1e-13);
    }

    /// Hertz's laws of a growing force: N = 2/3 pi a b p is the volume under the pressure, the semi-axes go with
    /// N^(1/3), the approach with N^(2/3); the ellipse is longer along the weaker curvature.
    #[test]
    fn a_force_spreads_over_its_ellipse(
        first in 1.0..1e6_f64,
        second in 1.0..1e6_f64,
        force in (-3.0..6.0_f64).prop_map(|exponent| 10_f64.powf(exponent)),
    ) {
        let contact = HertzContact::new(first, second, CONTACT_MODULUS_PA).unwrap();
        let loaded = contact.under(force);
        let (a, b) = (loaded.major_semi_axis_m, loaded.minor_semi_axis_m);
        prop_assert!(a >= b);
        prop_assert!(relative(2.0 / 3.0 * PI * a * b * loaded.peak_pressure_Pa, force) < 1e-14);
        prop_assert!(relative(contact.stiffness() * loaded.approach_m.powf(1.5), force) < 1e-13);
        let eight = contact.under(8.0 * force);
        prop_assert!(relative(eight.major_semi_axis_m, 2.0 * a) < 1e-14);
        prop_assert!(relative(eight.approach_m, 4.0 * loaded.approach_m) < 1e-14);
        prop_assert!(relative(eight.peak_pressure_Pa, 2.0 * loaded.peak_pressure_Pa) < 1e-14);
    }
}

proptest! {
    #![proptest_config(common::config(500))]

    /// The slope of the stiffness by a curvature against a central difference, from the circle to long ellipses.
    #[test]
    fn the_stiffness_slope_is_a_derivative(log_ratio in 0.0..9.0_f64, curvature in 10.0..1e4_f64, strong in any::<bool>()) {
        let other = if strong { curvature * (-log_ratio).exp() } else { curvature * log_ratio.exp() };
        let stiffness = |curvature: f64| HertzContact::new(curvature, other, 1e11).unwrap().stiffness();
        let h = 1e-5_f64;
        let difference = (stiffness(curvature * h.exp()) / stiffness(curvature * (-h).exp())).ln() / (2.0 * h);
        let exact = HertzContact::new(curvature, other, 1e11).unwrap().stiffness_slope(curvature, other);
        prop_assert!((exact - difference).abs() < 1e-8, "{exact} {difference}");
    }
}
