//! Agreement with an independent reference model, of other formulas and in extended precision
//! (tests/data/golden/reference.json at the top of the repository; its layout stands at the head of
//! tests/reference/make_golden.py): single contacts, pairs with and without gaps, spring and other exponents, thresholds
//! and whole drives.
//!
//! Relative 1e-8, and for angles and approaches what rounding of the inputs alone does to them. The reference itself is
//! good to 1e-9.

use crate::common;
use cbpt_core::drive::{
    CrossSlide, CrossSlideForm, CrossSlideShare, Deceleration, EqualSpeed, GrooveSection, OutputPlate,
    RingGroove,
};
use cbpt_core::equilibrium::report::PairSolution;
use cbpt_core::equilibrium::solve::solve_pair;
use cbpt_core::hertz::HertzContact;
use cbpt_core::pair::{Diagonal, MeshingPoint, MeshingPoints, cross_slide, deceleration, ring_groove};
use cbpt_core::preload::pair_thresholds;
use cbpt_core::transmission::DrivePoints;
use cbpt_core::{Drive, Elasticity, Load, Material, PreloadThresholds, Status, TrackCurvature};
use serde_json::Value;

const TOLERANCE: f64 = 1e-8;

fn reference() -> Value {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/data/golden/reference.json");
    serde_json::from_str(&std::fs::read_to_string(path).expect(path)).unwrap()
}

fn list(value: &Value) -> &Vec<Value> {
    value.as_array().unwrap_or_else(|| panic!("not a list: {value}"))
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("not a number: {value}"))
}

fn numbers(value: &Value) -> Vec<f64> {
    list(value).iter().map(number).collect()
}

fn text(value: &Value) -> &str {
    value.as_str().unwrap_or_else(|| panic!("not a text: {value}"))
}

fn count(value: &Value) -> u32 {
    u32::try_from(value.as_u64().unwrap()).unwrap()
}

fn near(found: f64, expected: f64, allowed: f64, what: &str) {
    let off = (found - expected).abs();
    assert!(off <= allowed, "{what}: found {found:e}, expected {expected:e}, {off:e} off");
}

/// Within the tolerance of the value itself and a floor.
fn close(found: f64, expected: f64, floor: f64, what: &str) {
    near(found, expected, TOLERANCE * expected.abs() + floor, what);
}

// --- parameters of the file to the public types -----------------------------------------------------

fn material(parameters: &Value) -> Material {
    let m = &parameters["material"];
    let elasticity = |modulus: &str, ratio: &str| Elasticity {
        youngs_modulus_Pa: number(&m[modulus]),
        poissons_ratio: number(&m[ratio]),
    };
    Material {
        ball: elasticity("ball_modulus_Pa", "ball_poisson"),
        plate: elasticity("plate_modulus_Pa", "plate_poisson"),
        ..Material::default()
    }
}

fn groove(p: &Value) -> GrooveSection {
    GrooveSection {
        ball_radius_m: number(&p["ball_radius_m"]),
        groove_conformity: number(&p["conformity"]),
        groove_depth_m: None,
    }
}

fn track_curvature(p: &Value) -> TrackCurvature {
    match p["track_curvature"].as_str() {
        Some("neglect") => TrackCurvature::Neglect,
        _ => TrackCurvature::Exact,
    }
}

fn deceleration_pair(p: &Value) -> Deceleration {
    Deceleration {
        ball_count: count(&p["ball_count"]),
        short_amplitude_coefficient: number(&p["short_amplitude"]),
        rolling_circle_radius_m: number(&p["rolling_radius_m"]),
        contact_angle_rad: number(&p["contact_angle_rad"]),
        groove: groove(p),
        output_plate: match text(&p["output"]) {
            "hypocycloid" => OutputPlate::Hypocycloid,
            _ => OutputPlate::Epicycloid,
        },
    }
}

fn equal_speed_pair(kind: &str, p: &Value) -> EqualSpeed {
    let (ball_count, pitch_radius_m) = (count(&p["ball_count"]), number(&p["pitch_radius_m"]));
    if kind == "ring_groove" {
        EqualSpeed::RingGroove(RingGroove {
            ball_count,
            pitch_radius_m,
            outside_contact_angle_rad: number(&p["contact_angle_outside_rad"]),
            inside_contact_angle_rad: number(&p["contact_angle_inside_rad"]),
            groove: groove(p),
        })
    } else {
        EqualSpeed::CrossSlide(CrossSlide {
            ball_count,
            pitch_radius_m,
            contact_angle_rad: number(&p["contact_angle_rad"]),
            groove: groove(p),
            form: CrossSlideForm::Balanced,
            share: CrossSlideShare::Carried,
        })
    }
}

/// A drive that has the pair of a case; the other pair is that of the base case, but its eccentricity is the ring radius.
fn drive_with(case: &Value) -> Drive {
    let p = &case["parameters"];
    let base = Drive::paper_base_case();
    let (first, second) = match text(&case["pair"]) {
        "deceleration" => (deceleration_pair(p), *base.equal_speed()),
        kind => {
            let mut first = *base.deceleration();
            if kind == "ring_groove" {
                first.rolling_circle_radius_m = 2.0 * number(&p["ring_radius_m"]);
            }
            (first, equal_speed_pair(kind, p))
        }
    };
    Drive::new(material(p), first, second, track_curvature(p)).unwrap()
}

/// The meshing points of a case, with its gaps, exponent and spring.
fn points(case: &Value) -> MeshingPoints {
    let p = &case["parameters"];
    let (modulus, track, phase) =
        (material(p).contact_modulus_Pa(), track_curvature(p), number(&case["phase_rad"]));
    let mut made = match text(&case["pair"]) {
        "deceleration" => deceleration::meshing_points(&deceleration_pair(p), modulus, track, phase),
        kind => match equal_speed_pair(kind, p) {
            EqualSpeed::RingGroove(ring) => {
                ring_groove::meshing_points(&ring, number(&p["ring_radius_m"]), modulus, track, phase)
            }
            EqualSpeed::CrossSlide(slide) => cross_slide::meshing_points(&slide, modulus, track, 0.0),
        },
    };
    made.exponent = number(&case["exponent"]);
    made.axial_spring_N_per_m = number(&case["axial_spring_N_per_m"]);
    let gaps = &case["gaps"];
    if !gaps.is_null() {
        let [axial, normal, in_plane] = ["axial_m", "normal_m", "in_plane_m"].map(|key| numbers(&gaps[key]));
        for point in &mut made.points {
            point.axial_offset_m = axial[point.ball];
            point.normal_offset_m = normal[point.ball];
            point.in_plane_offset_m = in_plane[point.ball];
        }
    }
    made
}

fn of_diagonal(points: &MeshingPoints, diagonal: Diagonal) -> Vec<(usize, &MeshingPoint)> {
    points.points.iter().enumerate().filter(|(_, point)| point.diagonal == diagonal).collect()
}

const DIAGONALS: [(Diagonal, &str); 2] = [(Diagonal::Plus, "plus"), (Diagonal::Minus, "minus")];

// --- the comparisons ------------------------------------------------------------------------------------

#[test]
fn contacts() {
    let reference = reference();
    for case in list(&reference["contacts"]) {
        let of = |key: &str| number(&case[key]);
        let contact =
            HertzContact::new(of("curvature_1_per_m"), of("curvature_2_per_m"), of("contact_modulus_Pa"))
                .unwrap();
        let loaded = contact.under(of("force_N"));
        close(contact.stiffness(), of("stiffness_N_per_m1p5"), 0.0, "stiffness");
        close(loaded.major_semi_axis_m, of("semi_axis_major_m"), 0.0, "major semi-axis");
        close(loaded.minor_semi_axis_m, of("semi_axis_minor_m"), 0.0, "minor semi-axis");
        close(loaded.peak_pressure_Pa, of("peak_pressure_Pa"), 0.0, "peak pressure");
        close(loaded.approach_m, of("approach_m"), 0.0, "approach");
    }
}

#[test]
fn meshing_points_of_every_pair() {
    let reference = reference();
    for case in list(&reference["pairs"]) {
        let id = text(&case["id"]);
        let found = points(case);
        let arms = numbers(&case["arm_m"]);
        let largest = arms.iter().fold(0.0_f64, |most, arm| most.max(arm.abs()));
        for (diagonal, name) in DIAGONALS {
            let stiffness = numbers(&case[format!("stiffness_{name}_N_per_m1p5")]);
            let angle = number(&case[format!("contact_angle_{name}_rad")]);
            let found = of_diagonal(&found, diagonal);
            assert_eq!(found.len(), arms.len(), "{id}");
            for (ball, (_, point)) in found.iter().enumerate() {
                assert_eq!(point.ball, ball);
                close(point.arm_m, arms[ball], TOLERANCE * largest, id);
                close(point.stiffness, stiffness[ball], 0.0, id);
                near(point.sin_beta.atan2(point.cos_beta), angle, 1e-14, id);
            }
        }
    }
}

fn check_solution(id: &str, points: &MeshingPoints, expected: &Value) {
    let of = |key: &str| number(&expected[key]);
    let (torque, preload) = (of("torque_Nm"), of("preload_N"));
    let what = |name: &str| format!("{id} at {torque} N m, {preload} N: {name}");
    let (status, state) = solve_pair(points, torque, preload);
    if text(&expected["status"]) == "refused" {
        let Status::BeyondHold { hold_preload_N } = status else { panic!("{}: {status}", what("status")) };
        assert!(state.is_none());
        close(hold_preload_N, of("preload_that_holds_N"), 0.0, &what("preload that holds"));
        return;
    }
    assert_eq!(status.name(), text(&expected["status"]), "{}", what("status"));
    let state = state.unwrap();
    assert!(state.residual <= 1e-11, "{}", what("residual"));
    let unknowns = state.state;
    close(unknowns.rotation_rad, of("alpha_rad"), of("alpha_floor_rad"), &what("alpha"));
    close(unknowns.approach_m(), of("approach_m"), of("approach_floor_m"), &what("approach"));
    let lateral = of("alpha_floor_rad") * points.largest_arm_m() + 1e-9 * of("approach_m").abs();
    close(unknowns.sideways_m, of("lateral_m"), lateral, &what("lateral"));
    let stiffness = of("torsional_stiffness_Nm_per_rad");
    near(state.torsional_stiffness_Nm_per_rad, stiffness, 1e-6 * stiffness, &what("torsional stiffness"));

    let report = PairSolution::new(points, torque, &state);
    let at_points = of("preload_at_points_N");
    for (diagonal, name) in DIAGONALS {
        let forces = numbers(&expected[format!("force_{name}_N")]);
        for ((index, point), force) in of_diagonal(points, diagonal).into_iter().zip(&forces) {
            let load = &report.points[index];
            assert_eq!((load.ball, load.diagonal), (point.ball, diagonal));
            near(load.force_N, *force, TOLERANCE * preload.max(at_points), &what(name));
        }
    }
    let axial: f64 =
        points.points.iter().zip(&report.points).map(|(p, load)| p.sin_beta * load.force_N).sum();
    near(axial, at_points, TOLERANCE * preload.max(at_points), &what("preload at the points"));
    if !expected["approach_unloaded_m"].is_null() {
        let unsprung = MeshingPoints { axial_spring_N_per_m: 0.0, ..points.clone() };
        let unloaded = common::solved(&unsprung, 0.0, preload).state.approach_m();
        close(unloaded, of("approach_unloaded_m"), 0.0, &what("unloaded approach"));
    }
    // Forces in the plane are as large as the preload that makes them.
    let floor = TOLERANCE * preload.max(at_points) * points.points[0].cos_beta / points.points[0].sin_beta;
    for (axis, key) in ["force_along_N", "force_across_N"].iter().enumerate() {
        if !expected[*key].is_null() {
            close(report.in_plane_force_N[axis], of(key), floor, &what(key));
        }
    }
    let couple = TOLERANCE * at_points * points.largest_arm_m();
    close(report.tilt_couple_Nm, of("tilt_couple_Nm"), couple, &what("tilt couple"));
    close(report.peak_pressure_Pa, of("peak_pressure_Pa"), 0.0, &what("peak pressure"));
    assert_eq!(report.carrying, count(&expected["carrying_diagonals"]) as usize, "{}", what("carrying"));
}

#[test]
fn solutions_and_refusals_of_every_pair() {
    let reference = reference();
    let mut compared = 0;
    for case in list(&reference["pairs"]) {
        let points = points(case);
        for expected in list(&case["solutions"]) {
            check_solution(text(&case["id"]), &points, expected);
            compared += 1;
        }
    }
    assert!(compared > 250, "only {compared} solutions compared");
}

fn check_thresholds(found: PreloadThresholds, expected: &Value, what: &str) {
    close(found.hold_N, number(&expected["hold_N"]), 0.0, what);
    close(found.continuous_N, number(&expected["continuous_N"]), 0.0, what);
    close(found.zero_backlash_N, number(&expected["zero_backlash_N"]), 0.0, what);
}

#[test]
fn preload_thresholds_of_every_pair() {
    let reference = reference();
    for case in list(&reference["pairs"]) {
        let (id, points, limits) = (text(&case["id"]), points(case), &case["limits"]);
        let torque = number(&limits["torque_Nm"]);
        for (key, torque) in [("positive", torque), ("negative", -torque)] {
            let expected = &limits[key];
            let found = pair_thresholds(&points, torque);
            if case["gaps"].is_null() {
                check_thresholds(found, expected, id);
            } else {
                // The other thresholds are of a pair without gaps.
                close(found.hold_N, number(&expected["hold_N"]), 0.0, id);
            }
        }
        let expected = &case["limits_over_period"];
        if !expected.is_null() {
            let drive = drive_with(case);
            let found = drive.preload_thresholds(number(&expected["torque_Nm"]));
            let (found, period) = if text(&case["pair"]) == "deceleration" {
                (found.deceleration, drive.deceleration_period_rad())
            } else {
                (found.equal_speed, drive.equal_speed_period_rad().unwrap())
            };
            check_thresholds(found, expected, id);
            close(period, number(&expected["period_rad"]), 0.0, id);
        }
    }
}

#[test]
fn design_findings_of_every_pair() {
    let reference = reference();
    let mut missing = 0;
    for case in list(&reference["pairs"]) {
        let name = if text(&case["pair"]) == "deceleration" { "deceleration" } else { "equal_speed" };
        let found = drive_with(case).findings(None);
        for (key, code) in [
            ("undercut", "undercut"),
            ("inside_wall_missing", "inside_wall_missing"),
            ("balls_touch", "balls_touch"),
            ("grooves_overlap", "rings_overlap"),
        ] {
            let Some(expected) = case["findings"][key].as_bool() else { continue };
            let has = found.iter().any(|finding| finding.code == code && finding.pair == name);
            assert_eq!(has, expected, "{}: {code}", text(&case["id"]));
            missing += usize::from(expected);
        }
    }
    assert!(missing >= 6, "only {missing} findings compared");
}

/// A drive of the file. Its equal-speed pair may be one that a [`Drive`] cannot have, of another material or with rings
/// of another radius than the eccentricity; then `itself` is not the drive of the file but for its deceleration pair.
struct WholeDrive {
    itself: Drive,
    consistent: bool,
    equal_speed: MeshingPoints,
}

impl WholeDrive {
    fn new(case: &Value) -> Self {
        let (p, q) = (&case["deceleration"], &case["equal_speed"]);
        let equal = equal_speed_pair(text(&case["equal_speed_pair"]), q);
        let itself = Drive::new(material(p), deceleration_pair(p), equal, track_curvature(p)).unwrap();
        let e = itself.deceleration().eccentricity_m();
        let radius = q["ring_radius_m"].as_f64().unwrap_or(e);
        let (modulus, track) = (material(q).contact_modulus_Pa(), track_curvature(q));
        let phase = number(&case["equal_speed_phase_rad"]);
        Self {
            consistent: material(p) == material(q) && (radius - e).abs() < 1e-12,
            itself,
            equal_speed: match equal {
                EqualSpeed::RingGroove(ring) => {
                    ring_groove::meshing_points(&ring, radius, modulus, track, phase)
                }
                EqualSpeed::CrossSlide(slide) => cross_slide::meshing_points(&slide, modulus, track, 0.0),
            },
        }
    }

    fn points(&self, input_angle_rad: f64) -> DrivePoints {
        let points = self.itself.points(input_angle_rad);
        DrivePoints { equal_speed: vec![self.equal_speed.clone()], ..points }
    }

    fn thresholds_at(&self, torque_Nm: f64, input_angle_rad: f64) -> PreloadThresholds {
        let found = self.itself.preload_thresholds_at(torque_Nm, input_angle_rad);
        if self.consistent {
            return found.drive();
        }
        let share = self.itself.equal_speed_share();
        found.deceleration.max(pair_thresholds(&self.equal_speed, torque_Nm * share))
    }
}

#[test]
fn whole_drives() {
    let reference = reference();
    let mut compared = 0;
    for case in list(&reference["drives"]) {
        let id = text(&case["id"]);
        let whole = WholeDrive::new(case);
        let drive = &whole.itself;
        let angle = number(&case["crank_angle_rad"]);
        let [first, second] =
            ["deceleration_phase_rad", "equal_speed_phase_rad"].map(|key| number(&case[key]));
        near(drive.deceleration_phase_rad(angle), first, 1e-14, id);
        near(drive.equal_speed_phase_rad(angle), second, 1e-14, id);
        close(drive.transmission_ratio(), number(&case["ratio"]), 0.0, id);
        for expected in list(&case["solutions"]) {
            check_drive_solution(id, &whole, angle, expected);
            compared += 1;
        }
        let limits = &case["limits"];
        check_thresholds(whole.thresholds_at(number(&limits["torque_Nm"]), angle), limits, id);
        let limits = &case["limits_over_period"];
        if !limits.is_null() {
            check_thresholds(drive.preload_thresholds(number(&limits["torque_Nm"])).drive(), limits, id);
        }
    }
    assert!(compared >= 80, "only {compared} solutions compared");
}

fn check_drive_solution(id: &str, whole: &WholeDrive, angle: f64, expected: &Value) {
    let of = |key: &str| number(&expected[key]);
    let load = Load::new(of("torque_Nm"), of("preload_N"), angle).unwrap();
    let what = |name: &str| format!("{id} at {} N m, {} N: {name}", load.torque_Nm(), load.preload_N());
    let points = whole.points(angle);
    let (status, angles) = points.angles(load.torque_Nm(), load.preload_N());
    if text(&expected["status"]) == "refused" {
        let Status::BeyondHold { hold_preload_N } = status else { panic!("{}", what("status")) };
        assert!(angles.is_none());
        close(hold_preload_N, of("preload_that_holds_N"), 0.0, &what("preload that holds"));
        return;
    }
    assert_eq!(status.name(), text(&expected["status"]), "{}", what("status"));
    let (floor, angles) = (of("floor_rad"), angles.unwrap());
    close(angles.deceleration_rad, of("deceleration_rad"), floor, &what("deceleration"));
    close(angles.equal_speed_rad, of("equal_speed_at_output_rad"), floor, &what("at the output"));
    close(angles.elastic_angle_rad(), of("total_rad"), floor, &what("total"));
    if whole.consistent {
        let found = whole.itself.solve(&load);
        assert_eq!((found.status, found.angles), (status, Some(angles)));
        let second = found.equal_speed.unwrap();
        close(second.rotation_rad, of("equal_speed_rad"), floor, &what("equal-speed pair"));
    }
    // The 2017 paper puts the whole torque on a cross-slide and its whole angle on the output.
    let paper = DrivePoints { equal_speed_share: 1.0, ..points };
    let (_, angles) = paper.angles(load.torque_Nm(), load.preload_N());
    match expected["paper_total_rad"].as_f64() {
        Some(total) => close(angles.unwrap().elastic_angle_rad(), total, floor, &what("paper's total")),
        None => assert!(angles.is_none(), "{}", what("paper's total")),
    }
}
