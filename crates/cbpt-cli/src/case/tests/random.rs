//! Any case is written and read back the same, and no text panics.

use cbpt_core::{
    CrossSlide, CrossSlideForm, CrossSlideShare, Deceleration, Drive, Elasticity, EqualSpeed, GrooveSection,
    Material, OutputPlate, RingGroove, TrackCurvature,
};
use proptest::collection::{btree_map, vec};
use proptest::option;
use proptest::prelude::*;

use std::sync::Arc;

use cbpt_core::effect::{AddsTo, LIBRARY, OwnParameter, Parameter, Scale};

use crate::formula::Formula;

use super::super::fields;
use super::super::{
    Case, EffectEntry, Friction, History, LoadDefaults, Measurement, Operation, Rating, TorqueTurns,
    Uncertainty, Zero,
};

fn positive() -> impl Strategy<Value = f64> {
    prop_oneof![
        1e-6..1e-1,
        1e8..1e12,
        any::<f64>().prop_map(f64::abs).prop_filter("usable", |x| x.is_normal())
    ]
}

fn angle() -> impl Strategy<Value = f64> {
    1e-3..1.57
}

fn any_groove() -> impl Strategy<Value = GrooveSection> {
    (positive(), 1.001..2.0, option::of(positive())).prop_map(
        |(ball_radius_m, groove_conformity, groove_depth_m)| GrooveSection {
            ball_radius_m,
            groove_conformity,
            groove_depth_m,
        },
    )
}

fn any_material() -> impl Strategy<Value = Material> {
    let body = || {
        (positive(), -0.9..0.499)
            .prop_map(|(youngs_modulus_Pa, poissons_ratio)| Elasticity { youngs_modulus_Pa, poissons_ratio })
    };
    let bodies = prop_oneof![body().prop_map(|body| (body, body)), (body(), body())];
    (bodies, positive()).prop_map(|((ball, plate), pressure_limit_Pa)| Material {
        ball,
        plate,
        pressure_limit_Pa,
    })
}

fn any_equal_speed() -> impl Strategy<Value = EqualSpeed> {
    let angles = prop_oneof![angle().prop_map(|angle| (angle, angle)), (angle(), angle())];
    (3..=1000_u32, positive(), angles, any_groove(), any::<[bool; 3]>()).prop_map(
        |(ball_count, pitch_radius_m, (outside, inside), groove, [ring, form, share])| {
            if ring {
                EqualSpeed::RingGroove(RingGroove {
                    ball_count,
                    pitch_radius_m,
                    outside_contact_angle_rad: outside,
                    inside_contact_angle_rad: inside,
                    groove,
                })
            } else {
                EqualSpeed::CrossSlide(CrossSlide {
                    ball_count,
                    pitch_radius_m,
                    contact_angle_rad: inside,
                    groove,
                    form: if form { CrossSlideForm::Paper } else { CrossSlideForm::Balanced },
                    share: if share { CrossSlideShare::Paper } else { CrossSlideShare::Carried },
                })
            }
        },
    )
}

fn any_drive() -> impl Strategy<Value = Drive> {
    let numbers = (3..=1000_u32, 0.001..0.999, positive(), angle(), any_groove());
    (any_material(), numbers, any_equal_speed(), any::<[bool; 2]>()).prop_map(
        |(
            material,
            (ball_count, k, radius, contact_angle_rad, groove),
            equal_speed,
            [epicycloid, neglect],
        )| {
            let epicycloid = epicycloid && matches!(equal_speed, EqualSpeed::RingGroove(_));
            let deceleration = Deceleration {
                ball_count,
                short_amplitude_coefficient: k,
                rolling_circle_radius_m: radius,
                contact_angle_rad,
                groove,
                output_plate: if epicycloid { OutputPlate::Epicycloid } else { OutputPlate::Hypocycloid },
            };
            let curvature = if neglect { TrackCurvature::Neglect } else { TrackCurvature::Exact };
            Drive::new(material, deceleration, equal_speed, curvature).unwrap()
        },
    )
}

fn any_effect() -> impl Strategy<Value = EffectEntry> {
    let number = || -1e9..1e9;
    let shares = vec(0.0..1.0_f64, 8);
    let of_ball_drives: Vec<_> = LIBRARY.into_iter().filter(|spec| spec.suits_ball_drives()).collect();
    let built_in = (proptest::sample::select(of_ball_drives), shares).prop_map(|(spec, shares)| {
        let number = |(parameter, share): (&Parameter, f64)| {
            let (low, high) = (parameter.lower.max(-1e9), parameter.upper.min(1e9));
            let value = low + share * (high - low);
            let whole = parameter.scale == Scale::Fixed;
            (parameter.name(), if whole { value.floor() } else { value })
        };
        let numbers = spec.parameters.iter().zip(shares).map(number).collect();
        EffectEntry { id: spec.id.into(), numbers, own: None }
    });
    let unit = proptest::sample::select(vec!["", "rad/(N m)", "N m", "1/s", "rad/(N m)^2 N"])
        .prop_map(str::to_owned);
    let parameter = (unit, number(), option::of(0.0..1e9), option::of(0.0..1e9));
    let adds_to =
        proptest::sample::select(vec![AddsTo::Torque, AddsTo::Preload, AddsTo::Series, AddsTo::Reading]);
    let own =
        (adds_to, btree_map("p[A-Za-z0-9_]{0,8}_", parameter, 0..4)).prop_map(|(adds_to, parameters)| {
            // A number has whatever dimension is needed, so that any units fit.
            let expression =
                parameters.keys().fold("2 * torque_Nm".to_owned(), |text, name| text + " * " + name);
            let parameter =
                |(name, (unit, start, below, above)): (String, (String, f64, Option<f64>, Option<f64>))| {
                    let (min, max) = (below.map(|below| start - below), above.map(|above| start + above));
                    OwnParameter { name, unit, stated: String::new(), start, min, max }
                };
            let parameters = parameters.into_iter().map(parameter).collect();
            let own = Formula::new("own_effect", adds_to, expression, parameters).unwrap();
            EffectEntry { id: "own_effect".into(), numbers: Vec::new(), own: Some(Arc::new(own)) }
        });
    prop_oneof![built_in, own]
}

fn any_case() -> impl Strategy<Value = Case> {
    let load = (option::of(-1e6..1e6), option::of(positive()), option::of(-1e3..1e3));
    let names: Vec<String> = fields::uncertain()
        .filter(|(_, key)| key.only.is_none())
        .map(|(section, key)| section.si_name(key))
        .collect();
    let of_drive = btree_map(proptest::sample::select(names), positive(), 0..5);
    let limits: Vec<String> = fields::tolerated()
        .filter(|(_, key)| key.only.is_none())
        .map(|(section, key)| section.si_name(key))
        .collect();
    let tolerance = btree_map(proptest::sample::select(limits), positive(), 0..5);
    let spreads = (proptest::array::uniform5(positive()), of_drive, tolerance);
    let between = History::WORDS.map(|(_, history)| history);
    let turns = TorqueTurns::WORDS.map(|(_, turns)| turns);
    let zeros =
        (any::<bool>(), proptest::sample::select(between.to_vec()), proptest::sample::select(turns.to_vec()));
    let measurement = (zeros, option::of(positive()), option::of(positive()));
    let friction = (0.0..10.0, positive());
    let operation = (option::of(positive()), option::of(positive()), option::of(positive()), positive());
    let costs = (friction, operation);
    (any_drive(), load, measurement, spreads, costs, vec(any_effect(), 0..3)).prop_map(
        |(
            drive,
            (torque_Nm, preload_N, input_angle_rad),
            ((per_run, friction_between_runs, torque_turns), lever_arm_m, rated_torque_Nm),
            ([k, angle, torque, preload, sensor], of_drive, tolerance),
            ((coefficient, coefficient_uncertainty), (speed, inertia, mass, static_safety)),
            effects,
        )| Case {
            reducer: drive.into(),
            load: LoadDefaults { torque_Nm, preload_N, input_angle_rad },
            measurement: Measurement {
                zero: if per_run { Zero::PerRun } else { Zero::Common },
                lever_arm_m,
                friction_between_runs,
                torque_turns,
            },
            rating: Rating { rated_torque_Nm },
            friction: Friction { coefficient, coefficient_uncertainty },
            operation: Operation {
                input_speed_rad_per_s: speed,
                output_inertia_kg_m2: inertia,
                planet_mass_kg: mass,
                static_safety,
            },
            uncertainty: Uncertainty {
                contact_stiffness_rel: k,
                contact_angle_rad: angle,
                torque_gain_rel: torque,
                preload_gain_rel: preload,
                sensor_gain_rel: sensor,
                of_drive,
            },
            tolerance,
            effects,
        },
    )
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 300, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn what_is_written_reads_back_the_same(case in any_case()) {
        let text = case.to_toml();
        let again = Case::from_toml(&text, "written").map_err(|error| TestCaseError::fail(format!("{error}\n{text}")))?;
        prop_assert_eq!(&again, &case);
        prop_assert_eq!(again.to_toml(), text);
    }

    #[test]
    fn no_bytes_make_it_panic(bytes in vec(any::<u8>(), 0..400)) {
        let _ = Case::from_toml(&String::from_utf8_lossy(&bytes), "bytes");
    }

    #[test]
    fn no_toml_like_text_makes_it_panic(text in "([a-z_]{0,9}[\\[\\]{}.,=\"'#\n +\\-0-9]){0,60}") {
        let _ = Case::from_toml(&text, "text");
    }

    #[test]
    fn no_edit_makes_it_panic(case in any_case(), edits in vec((any::<prop::sample::Index>(), any::<char>(), 0..3), 1..6)) {
        let mut text: Vec<char> = case.to_toml().chars().collect();
        for (at, char, what) in edits {
            let at = at.index(text.len());
            match what {
                0 => text[at] = char,
                1 => text.insert(at, char),
                _ => drop(text.remove(at)),
            }
        }
        let text: String = text.into_iter().collect();
        if let Err(error) = Case::from_toml(&text, "edited") {
            prop_assert!(!error.mistakes.is_empty());
            let lines = text.split('\n').count();
            prop_assert!(error.mistakes.iter().all(|mistake| mistake.line.is_none_or(|line| line <= lines)));
        }
    }
}
