//! What is nominal is solved in lanes, anything else by the scalar solver: the same prediction by both, and none that depends on
//! what was asked before.

use super::{drives, fitted, predictor, typical_values};
use cbpt_core::predict::{Prediction, Predictor};

/// Effects that leave the pairs nominal, without and with friction; the last one does not, at any other value than 0.
const NOMINAL: [&[&str]; 2] = [
    &["contact_stiffness", "contact_angle", "preload_scale", "torque_scale", "plate_tilt"],
    &["contact_stiffness", "contact_angle", "preload_scale", "friction_hysteresis", "plate_tilt"],
];

/// Typical values, the tilt at `tilt_rad`, and the numbers to differentiate by, all but those of the tilt.
fn asked(predictor: &Predictor, tilt_rad: f64) -> (Vec<f64>, Vec<usize>) {
    let mut values = typical_values(predictor);
    let tilted = predictor.effects().len() - 1;
    let of_tilt = |place: &usize| predictor.parameters()[*place].effect == tilted;
    for place in (0..values.len()).filter(of_tilt) {
        if predictor.parameters()[place].parameter.is_size() {
            values[place] = tilt_rad;
        }
    }
    (values, fitted(predictor).into_iter().filter(|place| !of_tilt(place)).collect())
}

fn bits(found: &Prediction) -> Vec<u64> {
    let numbers = found.angle_rad.iter().chain(&found.sensitivities).chain(&found.residual);
    numbers.map(|number| number.to_bits()).collect()
}

/// A tilt far below a rounding error of the angle leaves the scalar solver as the only way.
#[test]
fn nominal_pairs_answer_as_the_scalar_solver_has_them() {
    for (label, drive) in drives() {
        for ids in NOMINAL {
            let mut predictor = predictor(&drive, ids);
            let (values, wanted) = asked(&predictor, 0.0);
            let lanes = predictor.predict(&values, &wanted).unwrap();
            predictor.cold();
            let scalar = predictor.predict(&asked(&predictor, 1e-25).0, &wanted).unwrap();
            assert_eq!(lanes.status, scalar.status, "{label}");
            assert_eq!((&lanes.carrying, &lanes.regime), (&scalar.carrying, &scalar.regime), "{label}");
            let size = scalar.angle_rad.iter().fold(0.0, |size: f64, angle| size.max(angle.abs()));
            for (one, other) in lanes.angle_rad.iter().zip(&scalar.angle_rad) {
                assert!((one - other).abs() <= 1e-10 * size, "{label}: {one:e} {other:e}");
            }
            for column in 0..wanted.len() {
                let of = |found: &Prediction| -> Vec<f64> {
                    found.sensitivities.iter().skip(column).step_by(wanted.len()).copied().collect()
                };
                let size = of(&scalar).iter().fold(0.0, |size: f64, slope| size.max(slope.abs()));
                for (one, other) in of(&lanes).iter().zip(of(&scalar)) {
                    assert!((one - other).abs() <= 1e-7 * size, "{label}, {column}: {one:e} {other:e}");
                }
            }
        }
    }
}

/// To rounding with solutions nearby, to the last bit without them; also where effects come and go between the calls.
#[test]
fn a_cold_prediction_is_that_of_a_new_predictor() {
    for (label, drive) in drives() {
        for ids in NOMINAL {
            let mut fresh = predictor(&drive, ids);
            let (values, wanted) = asked(&fresh, 0.0);
            let new = fresh.predict(&values, &wanted).unwrap();
            let mut used = predictor(&drive, ids);
            for tilt_rad in [0.0, 1e-5] {
                let (mut other, _) = asked(&used, tilt_rad);
                other[0] *= 1.1;
                used.predict(&other, &[]).unwrap();
            }
            used.predict(&used.neutral(), &[]).unwrap();
            let warm = used.predict(&values, &wanted).unwrap();
            let size = new.angle_rad.iter().fold(0.0, |size: f64, angle| size.max(angle.abs()));
            for (one, other) in warm.angle_rad.iter().zip(&new.angle_rad) {
                assert!((one - other).abs() <= 1e-10 * size, "{label}: {one:e} {other:e}");
            }
            used.cold();
            assert_eq!(bits(&used.predict(&values, &wanted).unwrap()), bits(&new), "{label}");
        }
    }
}
