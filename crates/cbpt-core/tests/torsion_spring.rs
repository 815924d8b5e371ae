//! A torsion spring: its curve between, at and beyond the points; effects on it against closed forms and differences; what
//! it does not have.

use cbpt_core::effect::{LIBRARY, Scale};
use cbpt_core::predict::loads::{Effects, solve_load};
use cbpt_core::predict::{Columns, Number, Predictor, Rows, Slot};
use cbpt_core::{Drive, Load, Status, TorsionSpring};
use proptest::prelude::*;

const STIFFNESS: f64 = 2000.0;

fn linear() -> TorsionSpring {
    TorsionSpring::linear(STIFFNESS, Some(0.05)).unwrap()
}

/// Two loops of torque, the second slower and begun on the other side.
fn rows() -> Rows {
    let loop_of =
        |peak: f64| (0..=40).map(move |i| peak * (f64::from(i) * std::f64::consts::TAU / 40.0).sin());
    let torque_Nm: Vec<f64> = loop_of(30.0).chain(loop_of(-20.0)).collect();
    let count = torque_Nm.len();
    let time: Vec<f64> = (0..count).map(|i| i as f64).collect();
    Rows::new(Columns {
        run: &(0..count).map(|i| i64::from(i > 40)).collect::<Vec<_>>(),
        time_s: &time,
        torque_Nm: &torque_Nm,
        preload_N: None,
        input_angle_rad: &time.iter().map(|t| 0.1 * t).collect::<Vec<_>>(),
        temperature_K: Some(&time.iter().map(|t| 20.0 + 0.01 * t).collect::<Vec<_>>()),
        cycle: Some(&time.iter().map(|t| (t / 41.0).floor()).collect::<Vec<_>>()),
    })
    .unwrap()
}

/// Name without its unit of a number of the library.
fn stem_of(slot: &Slot) -> &'static str {
    match &slot.parameter {
        Number::Library(parameter) => parameter.stem,
        Number::Own(_) => unreachable!("no own effects here"),
    }
}

fn value(predictor: &Predictor, values: &mut [f64], effect: &str, stem: &str, value: f64) {
    let place = predictor
        .parameters()
        .iter()
        .position(|slot| predictor.effects()[slot.effect].id() == effect && stem_of(slot) == stem);
    values[place.unwrap()] = value;
}

/// Rising columns that no step makes degenerate.
fn tables() -> impl Strategy<Value = (Vec<f64>, Vec<f64>)> {
    (2_usize..12).prop_flat_map(|count| {
        let steps = || proptest::collection::vec(0.05..5.0_f64, count);
        (steps(), steps(), -20.0..5.0_f64, -0.02..0.01_f64).prop_map(|(widths, rises, from, start)| {
            let summed = |steps: Vec<f64>, from: f64, size: f64| -> Vec<f64> {
                steps
                    .iter()
                    .scan(from, |sum, step| {
                        *sum += size * step;
                        Some(*sum)
                    })
                    .collect()
            };
            (summed(widths, from, 1.0), summed(rises, start, 1e-3))
        })
    })
}

proptest! {
    #[test]
    fn the_curve_goes_through_its_points_and_rises((torque, angle) in tables(), shares in proptest::collection::vec(-0.3..1.3_f64, 20)) {
        let spring = TorsionSpring::table(&torque, &angle, None).unwrap();
        let size = angle.last().unwrap() - angle[0];
        for (torque, angle) in torque.iter().zip(&angle) {
            let there = spring.twist(*torque);
            prop_assert!((there.angle_rad - angle).abs() < 1e-12 * (size + angle.abs()));
            prop_assert_eq!(there.status, Status::Solved);
        }
        let (first, last) = (torque[0], *torque.last().unwrap());
        let mut at: Vec<f64> = shares.iter().map(|share| first + share * (last - first)).collect();
        at.sort_by(f64::total_cmp);
        let twists: Vec<_> = at.iter().map(|torque| spring.twist(*torque)).collect();
        for (pair, torques) in twists.windows(2).zip(at.windows(2)) {
            prop_assert!(pair[1].angle_rad >= pair[0].angle_rad || torques[0] == torques[1]);
        }
        for (torque, twist) in at.iter().zip(&twists) {
            let inside = (first..=last).contains(torque);
            prop_assert_eq!(twist.status, if inside { Status::Solved } else { Status::OutsideTable });
            let h = 1e-6 * (last - first);
            let difference = (spring.twist(torque + h).angle_rad - spring.twist(torque - h).angle_rad) / (2.0 * h);
            prop_assert!((twist.compliance_rad_per_Nm - difference).abs() < 1e-3 * (difference + size / (last - first)));
            prop_assert!(twist.compliance_rad_per_Nm > 0.0);
        }
    }
}

/// Points on a line give the line; from (0, 0) on both ways alike.
#[test]
fn a_straight_table_is_a_spring() {
    let spring = TorsionSpring::table(&[0.0, 1.0, 5.0, 20.0], &[0.0, 5e-4, 2.5e-3, 1e-2], None).unwrap();
    for torque in [-19.0, -5.0, -0.3, 0.0, 0.7, 20.0] {
        assert!((spring.twist(torque).angle_rad - torque / STIFFNESS).abs() < 1e-16);
        assert_eq!(spring.twist(torque).status, Status::Solved);
    }
    let beyond = spring.twist(-40.0);
    assert!((beyond.angle_rad + 0.02).abs() < 1e-15);
    assert_eq!(beyond.status, Status::OutsideTable);
}

/// Between the last two points too, where a secant as slope of the end would leave a sixteenth of the third.
#[test]
fn a_parabola_is_followed_up_to_the_end() {
    let torque: Vec<f64> = (0..6).map(f64::from).collect();
    let angle = |m: f64| 1e-3 * m * (20.0 - m);
    let spring = TorsionSpring::table(&torque, &torque.iter().map(|m| angle(*m)).collect::<Vec<_>>(), None)
        .unwrap_or_else(|why| panic!("{why}"));
    let (found, at_end) = (spring.twist(4.5), spring.twist(5.0));
    assert!((found.angle_rad - angle(4.5)).abs() < 2e-5, "{}", found.angle_rad);
    assert!((at_end.compliance_rad_per_Nm - 1e-2).abs() < 1e-12);
}

#[test]
fn tables_that_cannot_be_are_named() {
    let message =
        |torque: &[f64], angle: &[f64]| TorsionSpring::table(torque, angle, None).unwrap_err().to_string();
    assert!(message(&[1.0], &[1.0]).contains("from 2 to 10000 points"));
    assert!(message(&[1.0, 2.0], &[1.0]).contains("as many entries as the torques, 2"));
    assert!(message(&[1.0, 1.0], &[1.0, 2.0]).contains("torsion_spring.torque_Nm = 1"));
    assert!(message(&[1.0, 2.0, 3.0], &[1.0, 2.0, 1.5]).contains("entry 3 is not above the one before"));
    assert!(TorsionSpring::linear(0.0, None).is_err());
    assert!(TorsionSpring::linear(1.0, Some(-0.1)).is_err());
}

/// alpha = M0/(s k) + (j/2) M0/sqrt(M0^2 + m_t^2), gains about it.
#[test]
fn effects_without_memory_follow_the_closed_form() {
    let ids = ["contact_stiffness", "torque_scale", "sensor_gain", "backlash"];
    let mut predictor = Predictor::new(linear(), &ids, rows()).unwrap();
    let mut values = predictor.neutral();
    value(&predictor, &mut values, "contact_stiffness", "stiffness_scale", 0.7);
    value(&predictor, &mut values, "torque_scale", "torque_gain", 1.1);
    value(&predictor, &mut values, "sensor_gain", "sensor_gain", 0.9);
    value(&predictor, &mut values, "backlash", "play", 0.02);
    value(&predictor, &mut values, "backlash", "transition_torque", 3.0);
    let found = predictor.predict(&values, &[]).unwrap();
    for (i, angle) in found.angle_rad.iter().enumerate().take(41) {
        let torque = 1.1 * 30.0 * (i as f64 * std::f64::consts::TAU / 40.0).sin();
        let expected = 0.9 * (torque / (0.7 * STIFFNESS) + 0.01 * torque / torque.hypot(3.0));
        assert!((angle - expected).abs() < 1e-15, "{angle} {expected}");
    }
    assert!(found.regime.iter().all(Option::is_none));
}

/// An effect may stand twice, once without a size: its shapes are no matter, even where its sensitivity is wanted.
#[test]
fn angles_do_not_depend_on_what_is_wanted() {
    for (id, acting) in [
        ("hard_stop", [("taken_share", 0.5), ("stop_torque", 2.0)]),
        ("backlash", [("play", 0.02), ("transition_torque", 3.0)]),
        ("stiffness_curve", [("squared", 0.01), ("reference_torque", 10.0)]),
        ("friction_hysteresis", [("friction_torque", 2.0), ("engagement_angle", 1e-3)]),
    ] {
        let mut predictor = Predictor::new(linear(), &[id, id], rows()).unwrap();
        let mut values = predictor.neutral();
        for (stem, number) in acting {
            // That of the first instance.
            let place = predictor.parameters().iter().position(|slot| stem_of(slot) == stem);
            values[place.unwrap_or_else(|| panic!("{id} has no {stem}"))] = number;
        }
        let all: Vec<usize> = (0..values.len()).collect();
        let fitted: Vec<usize> =
            all.into_iter().filter(|place| predictor.predict(&values, &[*place]).is_ok()).collect();
        assert!(
            fitted.iter().any(|place| *place >= values.len() / 2),
            "{id}: nothing of the second is wanted"
        );
        predictor.cold();
        let plain = predictor.predict(&values, &[]).unwrap().angle_rad;
        predictor.cold();
        let beside = predictor.predict(&values, &fitted).unwrap().angle_rad;
        assert_eq!(plain, beside, "{id}");
    }
}

/// An effect may stand many times. What the angle answers to each is that of its own shapes: of the one that acts and of those
/// that have no size yet, also where more are wanted than are carried along together.
#[test]
fn each_of_many_answers_by_its_own_shapes() {
    for (id, size, shape) in [
        ("hard_stop", ("taken_share", 0.5), ("stop_torque", 9.0)),
        ("backlash", ("play", 0.02), ("transition_torque", 2.0)),
        ("stiffness_curve", ("added_compliance_1", 1e-3), ("break_torque_1", 9.0)),
        ("stiffness_curve", ("squared", 1e-3), ("reference_torque", 9.0)),
        ("friction_hysteresis", ("friction_torque", 2.0), ("engagement_angle", 1e-3)),
    ] {
        let mut predictor = Predictor::new(linear(), &[id; 18], rows()).unwrap();
        let mut values = predictor.neutral();
        let stems: Vec<&str> = predictor.parameters().iter().map(stem_of).collect();
        let places =
            |stem: &str| -> Vec<usize> { (0..stems.len()).filter(|place| stems[*place] == stem).collect() };
        let (sizes, shapes) = (places(size.0), places(shape.0));
        for (number, place) in shapes.iter().enumerate() {
            values[*place] = shape.1 * (1.0 + 0.1 * number as f64);
        }
        values[sizes[0]] = size.1;
        let wanted = [vec![shapes[0]], sizes].concat();
        let found = predictor.predict(&values, &wanted).unwrap();
        for (number, &place) in wanted.iter().enumerate() {
            let step = 1e-7 * if number == 0 { values[place] } else { size.1 };
            let mut moved = values.clone();
            moved[place] += step;
            let after = predictor.predict(&moved, &[]).unwrap().angle_rad;
            let slopes = found.sensitivities.iter().skip(number).step_by(wanted.len());
            for ((slope, after), before) in slopes.zip(after).zip(&found.angle_rad) {
                let error = (slope * step - (after - before)).abs();
                assert!(error < 1e-4 * (slope * step).abs() + 1e-14, "{id} {number}: {error} of {slope}");
            }
        }
    }
}

/// Far past the engagement angle the branches of a loop stand T0 (1 + g |M|)/k to either side of the spring.
#[test]
fn the_loop_is_as_wide_as_the_friction_that_grows_with_the_load() {
    let torque_Nm: Vec<f64> =
        (0..=400).map(|i| 30.0 * (f64::from(i) * std::f64::consts::TAU / 400.0).sin()).collect();
    let times: Vec<f64> = (0..=400).map(f64::from).collect();
    let count = times.len();
    let rows = Rows::new(Columns {
        run: &vec![0; count],
        time_s: &times,
        torque_Nm: &torque_Nm,
        preload_N: None,
        input_angle_rad: &vec![0.0; count],
        temperature_K: None,
        cycle: None,
    });
    let mut predictor = Predictor::new(linear(), &["friction_hysteresis"], rows.unwrap()).unwrap();
    let mut values = predictor.neutral();
    value(&predictor, &mut values, "friction_hysteresis", "friction_torque", 2.0);
    value(&predictor, &mut values, "friction_hysteresis", "engagement_angle", 1e-5);
    value(&predictor, &mut values, "friction_hysteresis", "load_share", 0.2);
    let found = predictor.predict(&values, &[]).unwrap();
    for (i, up) in [(50, true), (90, true), (180, false), (250, false), (380, true)] {
        let friction = (2.0 + 0.2 * torque_Nm[i].abs()) * if up { 1.0 } else { -1.0 };
        assert!((found.angle_rad[i] - (torque_Nm[i] - friction) / STIFFNESS).abs() < 1e-9, "{i}");
    }
}

/// A value at which every parameter of an effect shows.
fn typical(id: &str, stem: &str) -> f64 {
    match (id, stem) {
        (_, "stiffness_scale" | "torque_gain" | "sensor_gain") => 0.9,
        ("shaft_shift", "shift") => -2e-5,
        (_, "quadratic") => 0.5,
        (_, "cubic") => 20.0,
        (_, "flattening" | "reference_rate") => 1e-3,
        (_, "knee") => 0.01,
        ("span_drift", "rate") => 3e-3,
        (_, "rate") => 1e-6,
        ("eccentric_bearing", "exponent") => 0.8,
        (_, "play" | "fixture_play") => 5e-3,
        (_, "holding_torque") => 3.1,
        (_, "centre_torque") => 2.3,
        ("sensor_hysteresis", "half_width") => 4e-4,
        (_, "warm_up_time") => 9.0,
        (_, "taken_share" | "half_width" | "growth_exponent") => 0.3,
        ("hard_stop", "stop_torque") => 11.3,
        (_, "transition_torque") => 1.5,
        (_, "squared" | "cubed" | "skewed") => 4e-3,
        (_, "reference_torque") => 21.0,
        ("stiffness_curve", "added_compliance_1") => 2e-4,
        ("stiffness_curve", "break_torque_1") => 5.3,
        ("stiffness_curve", "break_torque_2") => 9.7,
        ("stiffness_curve", "added_compliance_2") | ("output_torsion", "compliance") => 1e-4,
        ("output_torsion", "asymmetry") | (_, "lag" | "first_share") => 0.2,
        ("output_torsion", "stiffening") => 0.02,
        ("output_torsion", "stop_torque") => 17.3,
        ("output_torsion", "opening_torque") => 3.7,
        ("creep", "compliance" | "superposed_compliance" | "power_compliance")
        | (_, "reference_deflection" | "clearance" | "offset_sine" | "offset_cosine") => 2e-5,
        (_, "friction_torque") => 3.0,
        (_, "zero_error") => 0.31,
        (_, "zero_drift") => 6e-3,
        (_, "engagement_angle" | "slip_angle") => 2e-3,
        (_, "load_share") => 0.09,
        (_, "build_up_exponent") => 0.7,
        (_, "breakaway_share") => 0.4,
        (_, "weakening_ratio") => 4.5,
        (_, "permanent_set" | "permanent_set_of_run" | "settled" | "warm_up") => 3e-4,
        // Not so late that no load reaches a stop.
        ("damping", "time_constant") => 2.1,
        (_, "time_constant") => 7.0,
        (_, "settling_cycles") => 2.0,
        (_, "starts_moving") => 1.0,
        (
            _,
            "preload_exponent"
            | "slip_exponent"
            | "spread"
            | "friction_radius"
            | "planet_offset_sine"
            | "planet_offset_cosine",
        ) => 0.0,
        _ => panic!("a new parameter, {stem} of {id}, wants a typical value"),
    }
}

/// Every sensitivity of everything that a spring can have, all at once, against differences.
#[test]
fn sensitivities_are_derivatives() {
    let table = TorsionSpring::table(&[0.0, 5.0, 15.0, 40.0], &[0.0, 4e-3, 9e-3, 0.018], Some(0.05)).unwrap();
    let ids: Vec<&str> = LIBRARY.iter().filter(|spec| spec.suits_springs(true)).map(|spec| spec.id).collect();
    let mut predictor = Predictor::new(table, &ids, rows()).unwrap();
    let id_of = |place: usize| predictor.effects()[predictor.parameters()[place].effect].id();
    let stems: Vec<&str> = predictor.parameters().iter().map(stem_of).collect();
    let values: Vec<f64> = (0..stems.len()).map(|place| typical(id_of(place), stems[place])).collect();
    let fitted = |place: &usize| predictor.parameters()[*place].parameter.scale() != Scale::Fixed;
    let wanted: Vec<usize> = (0..values.len()).filter(fitted).filter(|place| values[*place] != 0.0).collect();
    let here = predictor.predict(&values, &wanted).unwrap();
    assert!(here.status.iter().all(Status::has_solution));
    for (column, &place) in wanted.iter().enumerate() {
        let h = 1e-5 * values[place];
        let mut at = |change: f64| {
            let mut values = values.clone();
            values[place] += change;
            predictor.predict(&values, &[]).unwrap().angle_rad
        };
        let (above, below) = (at(h), at(-h));
        let differences: Vec<f64> = above.iter().zip(below).map(|(a, b)| (a - b) / (2.0 * h)).collect();
        let size = differences.iter().fold(0.0, |most: f64, d| most.max(d.abs()));
        for (row, difference) in differences.iter().enumerate() {
            let slope = here.sensitivities[row * wanted.len() + column];
            assert!(
                (slope - difference).abs() < 1e-5 * size,
                "{} row {row}: {slope} {difference}",
                stems[place]
            );
        }
    }
}

#[test]
fn a_load_is_solved_without_a_preload() {
    let load = Load::without_preload(10.0, 0.0).unwrap();
    let none = Effects { effects: &[], values: &[] };
    let detail = solve_load(linear(), none, &load).unwrap();
    assert_eq!(detail.angle_rad, Some(10.0 / STIFFNESS));
    assert_eq!(detail.solution.torsional_stiffness_Nm_per_rad, Some(STIFFNESS));
    let ball = solve_load(Drive::paper_base_case(), none, &load).unwrap_err().to_string();
    assert!(ball.contains("a ball drive needs a preload"), "{ball}");
}

#[test]
fn what_a_reducer_cannot_have_is_refused() {
    let refused =
        |spring: TorsionSpring, id: &str| Predictor::new(spring, &[id], rows()).unwrap_err().to_string();
    let without_radius = || TorsionSpring::linear(STIFFNESS, None).unwrap();
    assert!(refused(linear(), "plate_tilt").contains("does not have"));
    assert!(refused(linear(), "preload_loss").contains("does not have"));
    assert!(refused(without_radius(), "bearing_play").contains("torsion_spring.reference_radius_mm"));
    let rows_with_preload = Rows::of_loads(&[Load::new(1.0, 600.0, 0.0).unwrap()]);
    let ball = Predictor::new(Drive::paper_base_case(), &["backlash"], rows_with_preload).unwrap_err();
    assert!(ball.to_string().contains("is for torsion springs only"), "{ball}");
    let mut friction = Predictor::new(linear(), &["friction_hysteresis"], rows()).unwrap();
    let mut values = friction.neutral();
    value(&friction, &mut values, "friction_hysteresis", "friction_radius", 1e-3);
    let message = friction.predict(&values, &[]).unwrap_err().to_string();
    assert!(message.contains("the readings have no preload"), "{message}");
}
