//! The exact sensitivities of the elastic angle and of the thresholds against central differences of the drive itself.

use crate::common;
use crate::common::{any_drive, drive_holding_arm_m, small_drive};
use cbpt_core::design::{Design, DesignNumber, NUMBERS, find, numbers_of};
use cbpt_core::sensitivity::{DriveSensitivities, Sensitivity};
use cbpt_core::{
    CrossSlideForm, CrossSlideShare, Deceleration, Drive, DriveThresholds, EqualSpeed, Load, TrackCurvature,
};
use proptest::prelude::*;
use proptest::test_runner::TestCaseError;

/// Step of a difference, as a part of the number.
const STEP: f64 = 2e-5;
/// Agreement, as a part of the derivative and of the result over the number: differences of solutions that are good to
/// 1e-11 to 1e-10 are no better.
const TOLERANCE: f64 = 3e-5;

/// The angle with its parts, and the thresholds of both pairs, which take long with many balls.
fn results(drive: &Drive, load: &Load, thresholds: bool) -> Option<Vec<f64>> {
    let (_, angles) = drive.angles(load);
    let angles = angles?;
    let angles = vec![angles.elastic_angle_rad(), angles.deceleration_rad, angles.equal_speed_rad];
    if !thresholds {
        return Some(angles);
    }
    let DriveThresholds { deceleration: d, equal_speed: e } = drive.preload_thresholds(load.torque_Nm());
    let thresholds =
        [d.hold_N, d.continuous_N, d.zero_backlash_N, e.hold_N, e.continuous_N, e.zero_backlash_N];
    Some([angles, thresholds.to_vec()].concat())
}

const NAMES: [&str; 9] = [
    "angle",
    "deceleration angle",
    "equal-speed angle",
    "deceleration hold",
    "deceleration continuous",
    "deceleration zero backlash",
    "equal-speed hold",
    "equal-speed continuous",
    "equal-speed zero backlash",
];

fn told(found: &DriveSensitivities) -> Vec<Option<&Sensitivity>> {
    [&found.elastic_angle, &found.deceleration_angle, &found.equal_speed_angle]
        .into_iter()
        .chain(&found.deceleration)
        .chain(&found.equal_speed)
        .map(Option::as_ref)
        .collect()
}

/// How far a number moves in one step.
fn step(drive: &Drive, number: &DesignNumber, value: f64) -> f64 {
    match number.name {
        // Over the angle between two balls everything comes round.
        "load.input_angle_rad" => {
            STEP / f64::from(drive.deceleration().ball_count.max(drive.equal_speed().ball_count()))
        }
        // What counts is how far it is from 1.
        "deceleration.groove_conformity" | "equal_speed.groove_conformity" => STEP * (value - 1.0),
        "deceleration.short_amplitude_coefficient" => STEP * value.min(1.0 - value),
        _ => STEP * value.abs(),
    }
}

fn check(drive: &Drive, load: &Load, thresholds: bool) -> Result<(), TestCaseError> {
    let numbers = &numbers_of(drive, load);
    let found = drive.sensitivities(load, numbers).unwrap();
    let design = Design::of(drive, load);
    let Some(here) = results(drive, load, thresholds) else {
        prop_assert!(found.elastic_angle.is_none());
        return Ok(());
    };
    for (result, sensitivity) in told(&found).into_iter().take(here.len()).enumerate() {
        let Some(sensitivity) = sensitivity else {
            prop_assert!(here[result].is_infinite(), "{}: none", NAMES[result]);
            continue;
        };
        let off = (sensitivity.value - here[result]).abs();
        prop_assert!(off <= 1e-9 * here[result].abs(), "{}: {}", NAMES[result], sensitivity.value);
    }
    for (place, number) in numbers.iter().enumerate() {
        let value = design.get(number).unwrap();
        let h = step(drive, number, value);
        let at = |steps: f64| {
            let mut moved = design.clone();
            moved.set(number, value + steps * h);
            let (drive, load) = moved.build().ok()?;
            results(&drive, &load, thresholds)
        };
        let (Some(a), Some(b), Some(c), Some(d)) = (at(-2.0), at(-1.0), at(1.0), at(2.0)) else { continue };
        for (result, sensitivity) in told(&found).into_iter().take(here.len()).enumerate() {
            let Some(sensitivity) = sensitivity else { continue };
            if sensitivity.tied[place] {
                continue;
            }
            // Of fourth order: (f(-2) - 8 f(-1) + 8 f(1) - f(2)) / 12 h.
            let of_step = (a[result] - 8.0 * b[result] + 8.0 * c[result] - d[result]) / 12.0;
            let exact = sensitivity.slopes[place] * h;
            let size = exact.abs() + STEP * here[result].abs();
            // The force law has no second derivative where a contact parts: there differences do not agree themselves.
            let of_second_order = (c[result] - b[result]) / 2.0;
            if (of_second_order - of_step).abs() > 0.3 * TOLERANCE * size {
                continue;
            }
            prop_assert!(
                (exact - of_step).abs() <= TOLERANCE * size,
                "{} by {}: {exact:e} against {of_step:e} of {:e}",
                NAMES[result],
                number.name,
                here[result]
            );
        }
    }
    Ok(())
}

/// A drive with another material and unlike contact angles.
fn varied(drive: &Drive, load: &Load, [ball, plate, ratio, angle]: [f64; 4], unlike: bool) -> (Drive, Load) {
    let mut design = Design::of(drive, load);
    design.set(find("material.ball_youngs_modulus_Pa").unwrap(), ball);
    design.set(find("material.plate_youngs_modulus_Pa").unwrap(), plate);
    design.set(find("material.plate_poissons_ratio").unwrap(), ratio);
    if unlike && matches!(drive.equal_speed(), EqualSpeed::RingGroove(_)) {
        design.set(find("equal_speed.inside_contact_angle_rad").unwrap(), angle);
    }
    design.build().unwrap()
}

/// Anything a drive and its load may be.
fn drive_and_load(drive: impl Strategy<Value = Drive>) -> impl Strategy<Value = (Drive, Load)> {
    let material = [70e9..400e9_f64, 70e9..400e9_f64, 0.1..0.45_f64, 0.4..1.1_f64];
    (drive, 1.0..4.0_f64, 0.02..0.9_f64, any::<[bool; 3]>(), -7.0..7.0_f64, material).prop_map(
        |(drive, exponent, share, [backwards, unlike, steel], crank, material)| {
            let preload = 10_f64.powf(exponent);
            let sign = if backwards { -1.0 } else { 1.0 };
            let held = preload * drive_holding_arm_m(&drive, crank, sign);
            let load = Load::new(sign * share * held, preload, crank).unwrap();
            if steel { (drive, load) } else { varied(&drive, &load, material, unlike) }
        },
    )
}

proptest! {
    #![proptest_config(common::config(100))]

    #[test]
    fn sensitivities_of_the_angle_are_derivatives((drive, load) in drive_and_load(any_drive())) {
        check(&drive, &load, false)?;
    }
}

proptest! {
    #![proptest_config(common::config(25))]

    #[test]
    fn sensitivities_of_thresholds_are_derivatives((drive, load) in drive_and_load(small_drive())) {
        check(&drive, &load, true)?;
    }
}

fn base_load() -> Load {
    Load::new(5.0, 600.0, 0.03).unwrap()
}

/// The forms of the 2017 paper and straight tracks have derivatives of their own.
#[test]
fn every_form_of_a_drive_is_differentiated() {
    let base = Drive::paper_base_case();
    let load = base_load();
    let mut forms = vec![
        Drive::new(*base.material(), *base.deceleration(), *base.equal_speed(), TrackCurvature::Neglect)
            .unwrap(),
    ];
    for (balls, form, share) in [
        (16, CrossSlideForm::Balanced, CrossSlideShare::Paper),
        (15, CrossSlideForm::Balanced, CrossSlideShare::Carried),
        (16, CrossSlideForm::Paper, CrossSlideShare::Paper),
    ] {
        let slide = cbpt_core::CrossSlide {
            ball_count: balls,
            pitch_radius_m: 40e-3,
            contact_angle_rad: 0.8,
            groove: *base.equal_speed().groove(),
            form,
            share,
        };
        let equal = EqualSpeed::CrossSlide(slide);
        forms.push(Drive::new(*base.material(), *base.deceleration(), equal, TrackCurvature::Exact).unwrap());
    }
    for drive in &forms {
        check(drive, &load, true).unwrap();
    }
}

/// alpha = k^(-2/3) N_Z^(2/3) f(M0/N_Z) with k proportional to E*: a percent more of both loads is 2/3 percent of angle,
/// a percent more of the modulus -2/3; a threshold is proportional to the torque and does not know the modulus.
#[test]
fn relative_sensitivities_obey_the_scaling_of_hertz() {
    let (drive, load) = (Drive::paper_base_case(), base_load());
    let numbers =
        ["load.torque_Nm", "load.preload_N", "material.youngs_modulus_Pa"].map(|name| find(name).unwrap());
    let found = drive.sensitivities(&load, &numbers).unwrap();
    let angle = found.elastic_angle.unwrap();
    let relative: Vec<f64> =
        [5.0, 600.0, 208e9].iter().zip(&angle.slopes).map(|(q, s)| q * s / angle.value).collect();
    assert!((relative[0] + relative[1] - 2.0 / 3.0).abs() < 1e-10, "{relative:?}");
    assert!((relative[2] + 2.0 / 3.0).abs() < 1e-10, "{relative:?}");
    for threshold in found.drive.into_iter().flatten() {
        assert!((threshold.slopes[0] * 5.0 / threshold.value - 1.0).abs() < 1e-12);
        assert!(threshold.slopes[1].abs() < 1e-300);
        assert!((threshold.slopes[2] * 208e9 / threshold.value).abs() < 1e-9);
    }
}

/// Hold rests on one diagonal: its own angle alone counts, and where both diagonals hold alike that is told.
#[test]
fn where_contacts_decide_alike_that_is_told() {
    let (drive, load) = (Drive::paper_base_case(), base_load());
    let both = find("equal_speed.contact_angle_rad").unwrap();
    let outside = find("equal_speed.outside_contact_angle_rad").unwrap();
    let found = drive.sensitivities(&load, &[both, outside]).unwrap();
    let hold = found.equal_speed[0].as_ref().unwrap();
    // tan(beta) at 45 degrees has the derivative 2.
    assert!((hold.slopes[0] / hold.value - 2.0).abs() < 1e-9, "{hold:?}");
    assert_eq!(hold.tied, [false, true]);
}

#[test]
fn without_torque_a_threshold_has_a_kink_and_the_angle_none() {
    let drive = Drive::paper_base_case();
    let torque = find("load.torque_Nm").unwrap();
    let at =
        |torque_Nm: f64| drive.sensitivities(&Load::new(torque_Nm, 600.0, 0.0).unwrap(), &[torque]).unwrap();
    let (none, some) = (at(0.0), at(5.0));
    for (none, some) in none.deceleration.iter().zip(&some.deceleration) {
        let (none, some) = (none.as_ref().unwrap(), some.as_ref().unwrap());
        assert!(none.value == 0.0 && none.tied == [true]);
        assert!((none.slopes[0] - some.value / 5.0).abs() < 1e-12 * some.value);
    }
    assert_eq!(none.elastic_angle.unwrap().tied, [false]);
}

#[test]
fn what_has_no_derivative_is_refused_or_absent() {
    let (drive, load) = (Drive::paper_base_case(), base_load());
    let balls = NUMBERS.iter().find(|number| number.whole).unwrap();
    let error = drive.sensitivities(&load, &[balls]).unwrap_err().to_string();
    assert!(error.contains("deceleration.ball_count") && error.contains("whole"), "{error}");
    assert!(find("deceleration.ball_radius_mm").is_err());

    let pair = Deceleration { short_amplitude_coefficient: 0.8, ..*drive.deceleration() };
    let undercut = Drive::new(*drive.material(), pair, *drive.equal_speed(), TrackCurvature::Exact).unwrap();
    let found = undercut.sensitivities(&load, &numbers_of(&undercut, &load)).unwrap();
    assert_eq!(found.status, cbpt_core::Status::Undercut);
    assert!(found.elastic_angle.is_none() && found.deceleration[0].is_none() && found.drive[0].is_none());
    assert!(found.equal_speed[0].is_some());

    let beyond = Load::new(50.0, 600.0, 0.0).unwrap();
    let found = drive.sensitivities(&beyond, &numbers_of(&drive, &beyond)).unwrap();
    assert_eq!(found.status.name(), "beyond_hold");
    assert!(found.elastic_angle.is_none() && found.drive[0].is_some());
}

#[test]
fn a_design_is_built_as_it_was_laid_open() {
    let (drive, load) = (Drive::paper_base_case(), base_load());
    assert_eq!(Design::of(&drive, &load).build().unwrap(), (drive.clone(), load));
    assert_eq!(numbers_of(&drive, &load).len(), 14);
    let (unlike, load) = varied(&drive, &load, [200e9, 208e9, 0.3, 0.7], true);
    assert_eq!(Design::of(&unlike, &load).build().unwrap(), (unlike.clone(), load));
    // Two moduli and two angles in place of one each.
    assert_eq!(numbers_of(&unlike, &load).len(), 16);
}
