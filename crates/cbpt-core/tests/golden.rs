//! Agreement with numbers of an independent reference model (tests/data/golden/forward.json at the top of the
//! repository), relative 1e-8 everywhere; the reference itself is good to 1e-9.

use cbpt_core::drive::{
    CrossSlide, CrossSlideForm, CrossSlideShare, Deceleration, GrooveSection, RingGroove,
};
use cbpt_core::equilibrium::report::PairSolution;
use cbpt_core::equilibrium::solve::solve_pair;
use cbpt_core::hertz::HertzContact;
use cbpt_core::pair::{Diagonal, MeshingPoints, cross_slide, deceleration, ring_groove};
use cbpt_core::preload::pair_thresholds;
use cbpt_core::{Material, OutputPlate, Status, TrackCurvature};
use serde_json::Value;

const TOLERANCE: f64 = 1e-8;

fn golden() -> Value {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/data/golden/forward.json");
    serde_json::from_str(&std::fs::read_to_string(path).expect(path)).unwrap()
}

fn close(found: f64, expected: f64, scale: f64, what: &str) {
    let allowed = TOLERANCE * expected.abs().max(scale);
    assert!((found - expected).abs() <= allowed, "{what}: found {found}, expected {expected}");
}

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect()
}

fn points(case: &Value) -> MeshingPoints {
    let p = &case["parameters"];
    let number = |key: &str| p[key].as_f64().unwrap_or_else(|| panic!("{key} in {p}"));
    let count = |key: &str| u32::try_from(p[key].as_u64().unwrap()).unwrap();
    let section = |radius: &str| GrooveSection {
        ball_radius_m: number(radius),
        groove_conformity: number("conf"),
        groove_depth_m: None,
    };
    let modulus = Material::default().contact_modulus_Pa();
    match case["pair"].as_str().unwrap() {
        "deceleration" => {
            let pair = Deceleration {
                ball_count: count("Z2"),
                short_amplitude_coefficient: number("K"),
                rolling_circle_radius_m: number("r0"),
                contact_angle_rad: number("beta"),
                groove: section("rd"),
                output_plate: OutputPlate::Hypocycloid,
            };
            deceleration::meshing_points(&pair, modulus, TrackCurvature::Exact, number("phase"))
        }
        "ring_groove" => {
            let pair = RingGroove {
                ball_count: count("Zd"),
                pitch_radius_m: number("Rw"),
                outside_contact_angle_rad: number("beta"),
                inside_contact_angle_rad: p["beta_inside"].as_f64().unwrap_or(number("beta")),
                groove: section("rq"),
            };
            ring_groove::meshing_points(
                &pair,
                number("ring_r"),
                modulus,
                TrackCurvature::Exact,
                number("phase"),
            )
        }
        "cross_slide" => {
            let pair = CrossSlide {
                ball_count: count("ZS"),
                pitch_radius_m: number("RS"),
                contact_angle_rad: number("beta"),
                groove: section("rs"),
                form: CrossSlideForm::Balanced,
                share: CrossSlideShare::Carried,
            };
            cross_slide::meshing_points(&pair, modulus, TrackCurvature::Exact, 0.0)
        }
        other => panic!("unknown pair {other}"),
    }
}

#[test]
fn hertz_stiffness() {
    for case in golden()["hertz"].as_array().unwrap() {
        let number = |key: &str| case[key].as_f64().unwrap();
        let contact = HertzContact::new(number("c1"), number("c2"), number("e_star")).unwrap();
        close(contact.stiffness(), number("k"), 0.0, "k");
    }
}

#[test]
fn meshing_points_of_every_pair() {
    for case in golden()["pairs"].as_array().unwrap() {
        let found = points(case);
        let arms = numbers(&case["arm"]);
        let largest = arms.iter().fold(0.0_f64, |m, a| m.max(a.abs()));
        for (diagonal, key) in [(Diagonal::Plus, "k_plus"), (Diagonal::Minus, "k_minus")] {
            let of_kind: Vec<_> = found.points.iter().filter(|p| p.diagonal == diagonal).collect();
            assert_eq!(of_kind.len(), arms.len());
            for (point, (arm, k)) in of_kind.iter().zip(arms.iter().zip(numbers(&case[key]))) {
                close(point.arm_m, *arm, largest, "arm");
                close(point.stiffness, k, 0.0, key);
            }
        }
    }
}

#[test]
fn solutions_and_refusals_of_every_pair() {
    let mut solved = 0;
    for case in golden()["pairs"].as_array().unwrap() {
        let points = points(case);
        for solution in case["solutions"].as_array().unwrap() {
            let number = |key: &str| solution[key].as_f64().unwrap();
            let (torque, preload) = (number("torque"), number("preload"));
            let what = format!("{} {} at {torque} N m, {preload} N", case["pair"], case["parameters"]);
            let (status, state) = solve_pair(&points, torque, preload);
            if solution["alpha"].is_null() {
                assert!(matches!(status, Status::BeyondHold { .. }) && state.is_none(), "{what}: {status:?}");
                continue;
            }
            let state = state.unwrap_or_else(|| panic!("{what}: {status}"));
            assert!(state.residual <= 1e-11, "{what}: {}", state.residual);
            close(state.state.rotation_rad, number("alpha"), 0.0, &what);
            // The approach passes through 0 at the continuous threshold; its scale is what the arm makes of the angle.
            let scale = points.largest_arm_m() * number("alpha").abs();
            close(state.state.approach_m(), number("axial_approach"), scale, &what);
            let report = PairSolution::new(&points, torque, &state);
            for (diagonal, key) in [(Diagonal::Plus, "n_plus"), (Diagonal::Minus, "n_minus")] {
                let of_kind = report.points.iter().filter(|p| p.diagonal == diagonal);
                for (point, force) in of_kind.zip(numbers(&solution[key])) {
                    close(point.force_N, force, preload / 100.0, &what);
                }
            }
            solved += 1;
        }
    }
    assert!(solved > 70, "only {solved} solutions compared");
}

#[test]
fn preload_thresholds_of_every_pair() {
    for case in golden()["pairs"].as_array().unwrap() {
        let expected = &case["preload_limits"];
        if expected.is_null() {
            continue;
        }
        let number = |key: &str| expected[key].as_f64().unwrap();
        let found = pair_thresholds(&points(case), number("torque"));
        close(found.hold_N, number("hold"), 0.0, "hold");
        close(found.continuous_N, number("continuous"), 0.0, "continuous");
        close(found.zero_backlash_N, number("no_backlash"), 0.0, "zero backlash");
    }
}
