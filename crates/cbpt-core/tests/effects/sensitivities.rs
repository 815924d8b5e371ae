//! Sensitivities to every number of every effect, against differences.

use cbpt_core::Status;
use cbpt_core::predict::{Number, Predictor};

use super::{ARCSEC, all_ids, campaign, drives, fitted, predictor, typical, typical_values};

/// Every sensitivity at `values` against differences, from the inside where a value stands at its bound.
fn check_sensitivities(label: &str, predictor: &mut Predictor, values: &[f64]) {
    let wanted = fitted(predictor);
    let width = wanted.len();
    let here = predictor.predict(values, &wanted).unwrap();
    assert!(here.status.iter().all(Status::has_solution), "{label}: {:?}", here.status);
    for (column, &place) in wanted.iter().enumerate() {
        let slot = predictor.parameters()[place].clone();
        let (id, name) = (predictor.effects()[slot.effect].id().to_owned(), slot.parameter.name());
        let at = |predictor: &mut Predictor, change: f64| {
            let mut values = values.to_vec();
            values[place] += change;
            predictor.predict(&values, &[]).unwrap().angle_rad
        };
        let h = 1e-5 * typical(&id, &name).abs();
        let difference: Vec<f64> = if values[place] - h < slot.parameter.limits().0 {
            let (one, two) = (at(predictor, h), at(predictor, 2.0 * h));
            let ahead = here.angle_rad.iter().zip(one).zip(two);
            ahead.map(|((here, one), two)| (4.0 * one - 3.0 * here - two) / (2.0 * h)).collect()
        } else {
            let (up, down) = (at(predictor, h), at(predictor, -h));
            up.iter().zip(down).map(|(up, down)| (up - down) / (2.0 * h)).collect()
        };
        let exact: Vec<f64> = here.sensitivities.iter().skip(column).step_by(width).copied().collect();
        let size = exact.iter().fold(0.0, |size: f64, exact| size.max(exact.abs()));
        // Differences see the angle to about 1e-15 rad.
        let tolerance = 1e-5 * size + 1e-14 / h;
        for (row, (exact, difference)) in exact.iter().zip(&difference).enumerate() {
            if ["torque_zero", "torque_lag", "torque_hysteresis", "damping"].contains(&id.as_str())
                && campaign().torque_Nm[row] == 0.0
            {
                continue; // a bearing, a play and a joint that differs by the sign have a kink there
            }
            let error = (exact - difference).abs();
            assert!(
                error <= tolerance,
                "{label}, {name} of {id}, row {row}: {exact:e} against {difference:e}, largest {size:e}"
            );
        }
    }
}

#[test]
fn sensitivities_are_derivatives_where_effects_vanish() {
    for (label, drive) in drives() {
        let mut predictor = predictor(&drive, &all_ids());
        let neutral = predictor.neutral();
        check_sensitivities(label, &mut predictor, &neutral);
    }
}

#[test]
fn sensitivities_are_derivatives_where_all_effects_act() {
    for (label, drive) in drives() {
        let mut predictor = predictor(&drive, &all_ids());
        let values = typical_values(&predictor);
        check_sensitivities(label, &mut predictor, &values);
    }
}

/// One effect after the other at its typical size, the others neutral.
#[test]
fn sensitivities_are_derivatives_where_one_effect_acts() {
    let (label, drive) = &drives()[0];
    let mut predictor = predictor(drive, &all_ids());
    let typical = typical_values(&predictor);
    for effect in 0..predictor.effects().len() {
        let mut values = predictor.neutral();
        for (place, slot) in predictor.parameters().iter().enumerate() {
            if slot.effect == effect {
                values[place] = typical[place];
            }
        }
        check_sensitivities(
            &format!("{label}, {}", predictor.effects()[effect].id()),
            &mut predictor,
            &values,
        );
    }
}

/// Two shapes of the same effect, one of them of no size: its history is that of the other.
#[test]
fn a_dictionary_of_shapes_has_right_sensitivities() {
    let (label, drive) = &drives()[0];
    let ids = [
        "friction_hysteresis",
        "friction_hysteresis",
        "creep",
        "creep",
        "groove_pitch_error",
        "groove_pitch_error",
    ];
    let mut predictor = predictor(drive, &ids);
    let mut values = predictor.neutral();
    let place = |effect: usize, stem: &str| {
        let mut places = predictor.parameters().iter();
        places
            .position(|slot| {
                slot.effect == effect
                    && matches!(slot.parameter, Number::Library(known) if known.stem == stem)
            })
            .unwrap()
    };
    let (radius, slow) = (place(0, "friction_radius"), place(1, "engagement_angle"));
    let (long, high) = (place(3, "time_constant"), place(5, "harmonic"));
    (values[radius], values[slow], values[long], values[high]) = (4e-4, 30.0 * ARCSEC, 300.0, 7.0);
    check_sensitivities(label, &mut predictor, &values);
}
