//! What is read.

use std::collections::BTreeMap;
use std::f64::consts::{FRAC_PI_4, PI};

use cbpt_core::effect::{AddsTo, OwnEffect};
use cbpt_core::{
    CrossSlideForm, CrossSlideShare, Deceleration, Drive, Elasticity, EqualSpeed, GrooveSection, Material,
    OutputPlate, RingGroove, TrackCurvature,
};
use serde_json::json;

use super::super::{
    Case, Friction, History, LoadDefaults, Measurement, Operation, Rating, TorqueTurns, Uncertainty, Zero,
};
use super::{RING, edited, message, read};

#[test]
fn a_drive_is_read_in_si() {
    let groove = GrooveSection { ball_radius_m: 1.2e-3, groove_conformity: 1.08, groove_depth_m: None };
    let drive = Drive::new(
        Material::default(),
        Deceleration {
            ball_count: 20,
            short_amplitude_coefficient: 0.5,
            rolling_circle_radius_m: 2.5e-3,
            contact_angle_rad: FRAC_PI_4,
            groove,
            output_plate: OutputPlate::Hypocycloid,
        },
        EqualSpeed::RingGroove(RingGroove {
            ball_count: 12,
            pitch_radius_m: 35e-3,
            outside_contact_angle_rad: FRAC_PI_4,
            inside_contact_angle_rad: FRAC_PI_4,
            groove,
        }),
        TrackCurvature::Exact,
    );
    let uncertainty = Uncertainty {
        contact_stiffness_rel: 0.10,
        contact_angle_rad: PI / 360.0,
        torque_gain_rel: 0.01,
        preload_gain_rel: 0.02,
        sensor_gain_rel: 0.05,
        of_drive: BTreeMap::new(),
    };
    let expected = Case {
        reducer: drive.unwrap().into(),
        load: LoadDefaults::default(),
        measurement: Measurement {
            zero: Zero::Common,
            lever_arm_m: None,
            friction_between_runs: History::ByClock,
            torque_turns: TorqueTurns::WhereRampsMeet,
        },
        rating: Rating::default(),
        friction: Friction::default(),
        operation: Operation::default(),
        uncertainty,
        tolerance: BTreeMap::new(),
        effects: Vec::new(),
    };
    assert_eq!(read(RING), expected);
}

#[test]
#[expect(clippy::too_many_lines, reason = "one case that has every key")]
fn everything_a_case_may_hold() {
    let case = read(
        r#"
        track_curvature = "neglect"
        material = { youngs_modulus_GPa = 210, ball_youngs_modulus_GPa = 310.0, plate_poissons_ratio = 0.28 }
        [deceleration]
        ball_count = 20
        short_amplitude_coefficient = 0.5
        rolling_circle_radius_um = 4_000
        ball_radius_cm = 0.15
        groove_conformity = 1.08
        contact_angle_arcmin = 2700
        groove_depth_mm = 1
        output_plate = "hypocycloid"
        [equal_speed]
        kind = "cross_slide"
        ball_count = 0x10
        pitch_radius_m = 0.04
        ball_radius_mm = 1.5
        groove_conformity = 1.05
        contact_angle_deg = 40
        form = "paper"
        torque_share = "paper"
        track_curvature = "neglect"
        [load]
        torque_Nmm = -5e3
        preload_kN = 0.6
        input_angle_deg = -90
        [measurement]
        zero = "per_run"
        friction_between_runs = "released"
        torque_turns = "at_readings"
        lever_arm_mm = 100
        [rating]
        rated_torque_Nmm = 4000
        [friction]
        coefficient = 0.08
        [operation]
        input_speed_rpm = 60
        output_inertia_kg_cm2 = 250
        planet_mass_g = 300
        static_safety = 2
        [uncertainty]
        deceleration_ball_radius_um = 0.5
        deceleration_groove_conformity = 0.01
        equal_speed_contact_angle_arcmin = 60
        material_ball_youngs_modulus_GPa = 2
        [tolerance]
        equal_speed_pitch_radius_um = 20
        load_preload_N = 30
        [[effect]]
        id = "eccentric_bearing"
        reference_deflection_um = 2
        [[effect]]
        id = "my_creep"
        port = "series"
        expression = "a * torque_Nm * log(1 + run_time_s / tau)"
        parameters = { tau = { unit = "s", start = 20, min = 1, max = 1e4 }, a = { unit = "rad/(N m)", start = 1e-7 } }
        "#,
    );
    let drive = case.drive().unwrap();
    assert_eq!(drive.track_curvature(), TrackCurvature::Neglect);
    assert_eq!(drive.material().ball, Elasticity { youngs_modulus_Pa: 310e9, poissons_ratio: 0.3 });
    assert_eq!(drive.material().plate, Elasticity { youngs_modulus_Pa: 210e9, poissons_ratio: 0.28 });
    assert_eq!(drive.deceleration().rolling_circle_radius_m, 4e-3);
    assert_eq!(drive.deceleration().contact_angle_rad, FRAC_PI_4);
    assert_eq!(drive.deceleration().groove.ball_radius_m, 1.5e-3);
    let EqualSpeed::CrossSlide(slide) = drive.equal_speed() else { panic!("{drive:?}") };
    assert_eq!(
        (slide.ball_count, slide.form, slide.share),
        (16, CrossSlideForm::Paper, CrossSlideShare::Paper)
    );
    let load =
        LoadDefaults { torque_Nm: Some(-5.0), preload_N: Some(600.0), input_angle_rad: Some(-PI / 2.0) };
    assert_eq!(case.load, load);
    let expected = Measurement {
        zero: Zero::PerRun,
        lever_arm_m: Some(0.1),
        friction_between_runs: History::Released,
        torque_turns: TorqueTurns::AtReadings,
    };
    assert_eq!(case.measurement, expected);
    assert_eq!(case.rating, Rating { rated_torque_Nm: Some(4.0) });
    assert_eq!(case.friction, Friction { coefficient: 0.08, coefficient_uncertainty: 0.03 });
    let operation = Operation {
        input_speed_rad_per_s: Some(2.0 * PI),
        output_inertia_kg_m2: Some(0.025),
        planet_mass_kg: Some(0.3),
        static_safety: 2.0,
    };
    assert_eq!(case.operation, operation);
    let of_drive = [
        ("deceleration.ball_radius_m", 0.5e-6),
        ("deceleration.groove_conformity", 0.01),
        ("equal_speed.contact_angle_rad", PI / 180.0),
        ("material.ball_youngs_modulus_Pa", 2e9),
    ];
    assert_eq!(case.uncertainty.of_drive, of_drive.map(|(name, value)| (name.to_owned(), value)).into());
    let tolerance = [("equal_speed.pitch_radius_m", 20e-6), ("load.preload_N", 30.0)];
    assert_eq!(case.tolerance, tolerance.map(|(name, value)| (name.to_owned(), value)).into());
    assert_eq!(case.effects[0].numbers, [("reference_deflection_m".into(), 2e-6), ("exponent".into(), 0.9)]);
    let own = case.effects[1].own.as_ref().unwrap();
    let names: Vec<&str> = own.parameters().iter().map(|parameter| &*parameter.name).collect();
    assert_eq!((own.adds_to(), names), (AddsTo::Series, vec!["tau", "a"]));
    assert_eq!(own.parameters()[0].max, Some(1e4));
    assert_eq!(own.parameters()[1].max, None);
    assert_eq!(case.effects[1].values(), [20.0, 1e-7]);
    assert_eq!(read(&case.to_toml()), case);
}

#[test]
fn each_wall_may_have_its_own_angle() {
    let angles = |text: &str| match read(&edited("contact_angle_deg = 45.0\n\n[uncertainty]", text))
        .drive()
        .unwrap()
        .equal_speed()
    {
        EqualSpeed::RingGroove(ring) => (ring.outside_contact_angle_rad, ring.inside_contact_angle_rad),
        EqualSpeed::CrossSlide(_) => panic!("{text}"),
    };
    let both = "outside_contact_angle_rad = 0.7\ninside_contact_angle_rad = 0.8\n[uncertainty]";
    let one = "contact_angle_rad = 0.7\ninside_contact_angle_rad = 0.8\n[uncertainty]";
    assert_eq!(angles(both), (0.7, 0.8));
    assert_eq!(angles(one), (0.7, 0.8));
}

#[test]
fn units_are_equivalent_to_the_last_bit() {
    let radius = |line: &str| {
        read(&edited("ball_radius_mm = 1.2", line)).drive().unwrap().deceleration().groove.ball_radius_m
    };
    for line in ["m = 0.0012", "cm = 0.12", "mm = 1.2", "um = 1200", "um = 1.2e3", "nm = 1_200_000"] {
        assert_eq!(radius(&format!("ball_radius_{line}")), 0.0012, "{line}");
    }
    let angle = |line: &str| {
        read(&edited("contact_angle_deg = 45.0", line)).drive().unwrap().deceleration().contact_angle_rad
    };
    for line in [
        "deg = 45",
        "arcmin = 2700",
        "arcsec = 162e3",
        "rad = 0.7853981633974483",
        "mrad = 785.3981633974483",
    ] {
        assert_eq!(angle(&format!("contact_angle_{line}")), FRAC_PI_4, "{line}");
    }
    let modulus = |line: &str| {
        read(&edited("youngs_modulus_GPa = 208.0", line)).drive().unwrap().material().ball.youngs_modulus_Pa
    };
    for line in ["GPa = 208", "MPa = 208e3", "kPa = 208e6", "Pa = 208000000000"] {
        assert_eq!(modulus(&format!("youngs_modulus_{line}")), 208e9, "{line}");
    }
    let load = |lines: &str| read(&format!("{RING}[load]\n{lines}")).load;
    for lines in [
        "torque_Nm = 1.3\npreload_N = 620",
        "torque_Nmm = 1300\npreload_kN = 0.62",
        "torque_mNm = 1300\npreload_mN = 620e3",
        "torque_kNm = 0.0013\npreload_N = 6.2e2",
    ] {
        let expected = LoadDefaults { torque_Nm: Some(1.3), preload_N: Some(620.0), input_angle_rad: None };
        assert_eq!(load(lines), expected, "{lines}");
    }
}

#[test]
fn track_curvature_is_one_setting() {
    let neglect = "track_curvature = \"neglect\"\n";
    for text in [
        format!("{neglect}{RING}"),
        edited("kind =", &format!("{neglect}kind =")),
        edited("ball_count = 20", &format!("ball_count = 20\n{neglect}")),
        format!("{neglect}{}", edited("kind =", &format!("{neglect}kind ="))),
    ] {
        assert_eq!(read(&text).drive().unwrap().track_curvature(), TrackCurvature::Neglect, "{text}");
    }
    let exact = edited("kind =", "track_curvature = \"exact\"\nkind =");
    assert_eq!(
        message(&format!("{neglect}{exact}")),
        "drive.toml:15: equal_speed.track_curvature = \"exact\": contradicts track_curvature = \"neglect\"; \
         it is one setting of the whole drive; keep one of them"
    );
}

#[test]
fn byte_order_mark_and_windows_lines_are_read() {
    let windows = format!("\u{feff}{}", RING.replace('\n', "\r\n"));
    assert_eq!(read(&windows), read(RING));
    assert!(
        message(&windows.replace("rolling_circle_radius_mm", "rolling_circle_radius"))
            .starts_with("drive.toml:8: ")
    );
}

#[test]
fn json_has_the_same_keys() {
    let table = json!({
        "deceleration": {
            "ball_count": 20, "short_amplitude_coefficient": 0.5, "rolling_circle_radius_mm": 2.5,
            "ball_radius_mm": 1.2, "groove_conformity": 1.08, "contact_angle_deg": 45
        },
        "equal_speed": {
            "kind": "ring_groove", "ball_count": 12, "pitch_radius_mm": 35.0,
            "ball_radius_mm": 1.2, "groove_conformity": 1.08, "contact_angle_deg": 45.0
        },
        "uncertainty": {"sensor_gain_rel": 0.05},
    });
    assert_eq!(Case::from_json(&table), Ok(read(RING)));
    let mut wrong = table.clone();
    wrong["deceleration"]["ball_radius_mm"] = json!(-1.2);
    wrong["equal_speed"]["ball_radius_um"] = json!(1200.0);
    wrong["load"] = json!({"preload_N": null});
    assert_eq!(
        Case::from_json(&wrong).unwrap_err().to_string(),
        "equal_speed.ball_radius_um: the same quantity is already given as equal_speed.ball_radius_mm; keep one of them\n\
         load.preload_N = null: expected a finite number in N greater than 0\n\
         deceleration.ball_radius_mm = -1.2: must be a finite number greater than 0"
    );
    let message = Case::from_json(&json!([1])).unwrap_err().to_string();
    assert_eq!(message, "a case is an object with the sections of a case file");
}

/// Any other reducer: one stiffness or a table, in the units of its makers.
#[test]
fn a_torsion_spring_is_read_and_written() {
    let line = read("[torsion_spring]\ntorsional_stiffness_Nm_per_arcmin = 2.0\nreference_radius_mm = 50\n");
    let spring = line.reducer.torsion_spring().unwrap();
    let stiffness = spring.torsional_stiffness_Nm_per_rad().unwrap();
    assert!((stiffness - 2.0 * 10_800.0 / PI).abs() < 1e-9);
    assert_eq!(spring.reference_radius_m(), Some(0.05));
    assert!(line.drive().is_none());
    let table = read("[torsion_spring]\ntorque_Nm = [0, 10, 30]\nelastic_angle_arcmin = [0.0, 6.0, 15.0]\n");
    assert_eq!(table.reducer.torsion_spring().unwrap().points()[2], [30.0, 15.0 / 10_800.0 * PI]);
    for case in [line, table] {
        assert_eq!(read(&case.to_toml()), case);
        assert_eq!(read(&Case::reducer_to_toml(&case.reducer)).reducer, case.reducer);
    }
}
