//! What the grooves stand: closed forms, and that the ends of a range are its ends.

use std::f64::consts::TAU;

use cbpt_core::strength::{Contacts, natural_frequency_Hz, static_safety, unbalance_kg_m};
use cbpt_core::{Deceleration, Drive, OutputPlate};

const TORQUE_NM: f64 = 5.0;
const PRELOAD_N: f64 = 600.0;

/// Of the base case under its load, and a safety a little less than it has there.
fn contacts(drive: &Drive) -> (Contacts<'_>, f64) {
    let contacts = Contacts::new(drive);
    let less = 0.8 * contacts.strength(TORQUE_NM, PRELOAD_N).static_safety;
    (contacts, less)
}

#[test]
fn closed_forms() {
    assert!((static_safety(4.2e9, 2.1e9) - 8.0).abs() < 1e-12);
    assert!((unbalance_kg_m(3.0, 2e-3) - 12e-3).abs() < 1e-15);
    assert!((natural_frequency_Hz(8e4, 2e-2) - 2e3 / TAU).abs() < 1e-9);
}

#[test]
fn the_largest_torque_is_the_last_that_is_safe() {
    let drive = Drive::paper_base_case();
    let (contacts, required) = contacts(&drive);
    let largest = contacts.largest_torque_Nm(PRELOAD_N, required).unwrap();
    assert!(largest > TORQUE_NM);
    let safety = |torque_Nm: f64| contacts.strength(torque_Nm, PRELOAD_N).static_safety;
    assert!(safety(largest * (1.0 - 1e-6)) >= required && safety(largest * (1.0 + 1e-6)) < required);
    // The preload alone is too much.
    assert_eq!(contacts.largest_torque_Nm(PRELOAD_N, 2.0 * safety(0.0)), None);
}

#[test]
fn the_window_of_the_preload_ends_where_it_is_no_longer_safe() {
    let drive = Drive::paper_base_case();
    let (contacts, required) = contacts(&drive);
    let found = contacts.preload_window(TORQUE_NM, required);
    let safety = |preload_N: f64| contacts.strength(TORQUE_NM, preload_N).static_safety;
    let (least, largest) = (found.least_N.unwrap(), found.largest_N.unwrap());
    assert!(
        found.hold_N <= least && found.continuous_N <= least && least <= PRELOAD_N && PRELOAD_N < largest
    );
    assert!(safety(least) >= required && safety(largest * (1.0 - 1e-6)) >= required);
    assert!(safety(largest * (1.0 + 1e-6)) < required);
    // No preload is as safe as that.
    let none = contacts.preload_window(TORQUE_NM, 1e3 * safety(least));
    assert_eq!((none.least_N, none.largest_N), (None, None));
}

/// For one turn of the crank: Z1/Z3 with the hypocycloid plate as output, Z3/Z1 with the epicycloid plate.
#[test]
fn the_planet_turns_by_the_ratio_of_the_lobes() {
    let base = Drive::paper_base_case();
    for output_plate in [OutputPlate::Hypocycloid, OutputPlate::Epicycloid] {
        let pair = Deceleration { output_plate, ..*base.deceleration() };
        let drive = Drive::new(*base.material(), pair, *base.equal_speed(), base.track_curvature()).unwrap();
        let ratio = f64::from(pair.epicycloid_lobes()) / f64::from(pair.hypocycloid_lobes());
        let expected = if output_plate == OutputPlate::Hypocycloid { ratio } else { 1.0 / ratio };
        assert!((drive.planet_turn() / expected - 1.0).abs() < 1e-12);
    }
}
