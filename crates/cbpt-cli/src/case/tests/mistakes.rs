//! What is refused, and how it is told.

use std::fs;
use std::path::{Path, PathBuf};

use super::super::{Case, CaseError, LARGEST};
use super::{RING, edited, message, messages, read};

#[test]
fn a_wrong_key_is_told_what_it_may_have_meant() {
    let circle = "rolling_circle_radius_mm = 2.5";
    let keys = "ball_count, short_amplitude_coefficient, rolling_circle_radius_mm, ball_radius_mm, \
                groove_conformity, contact_angle_deg, groove_depth_mm, output_plate, track_curvature";
    assert_eq!(
        message(&edited(circle, "rolling_circle_radus_mm = 2.5")),
        format!(
            "drive.toml:8: deceleration.rolling_circle_radus_mm: unknown key; \
             did you mean rolling_circle_radius_mm? Allowed here: {keys}"
        )
    );
    assert_eq!(
        message(&edited(circle, "rolling_circle_radius_inch = 0.1")),
        "drive.toml:8: deceleration.rolling_circle_radius_inch: unit inch is not read; use m, cm, mm, um, nm"
    );
    assert_eq!(
        message(&edited(circle, "rolling_circle_radius_MM = 0.1")),
        "drive.toml:8: deceleration.rolling_circle_radius_MM: unit MM is not read; \
         did you mean rolling_circle_radius_mm? Use m, cm, mm, um, nm"
    );
    assert_eq!(
        message(&edited(circle, "rolling_circle_radius = 2.5")),
        "drive.toml:8: deceleration.rolling_circle_radius: the key needs a unit; write one of \
         rolling_circle_radius_m, rolling_circle_radius_cm, rolling_circle_radius_mm, rolling_circle_radius_um, \
         rolling_circle_radius_nm"
    );
    assert_eq!(
        message(&edited("groove_conformity = 1.08", "groove_conformity_mm = 1.08")),
        "drive.toml:10: deceleration.groove_conformity_mm: the key has no unit; write groove_conformity"
    );
    assert_eq!(
        message(&edited(circle, &format!("{circle}\npitch_radius_mm = 35"))),
        format!(
            "drive.toml:9: deceleration.pitch_radius_mm: the key belongs to [equal_speed]; allowed here: {keys}"
        )
    );
    assert_eq!(
        message(&edited(circle, &format!("{circle}\nnumber = 35"))),
        format!(
            "drive.toml:9: deceleration.number: unknown key; did you mean ball_count? Allowed here: {keys}"
        )
    );
    assert_eq!(
        message(&edited(circle, &format!("{circle}\ncolour = 35"))),
        format!("drive.toml:9: deceleration.colour: unknown key; allowed here: {keys}")
    );
    assert_eq!(
        message(&edited(circle, &format!("{circle}\nrolling_circle_radius_um = 2500"))),
        "drive.toml:9: deceleration.rolling_circle_radius_um: the same quantity is already given as \
         deceleration.rolling_circle_radius_mm on line 8; keep one of them"
    );
    assert_eq!(
        message(&format!("track_curvatur = \"exact\"\n{RING}")),
        "drive.toml:1: track_curvatur: unknown key; did you mean track_curvature? Allowed here: track_curvature"
    );
    let error =
        Case::from_toml(&edited(circle, "  rolling_circle_radus_mm = 2.5"), "drive.toml").unwrap_err();
    let mistake = &error.mistakes[0];
    assert_eq!((mistake.line, mistake.column), (Some(8), Some(3)));
    assert_eq!(mistake.nearest.as_deref(), Some("rolling_circle_radius_mm"));
}

#[test]
fn a_wrong_section_is_told_what_it_may_have_meant() {
    let sections = "material, deceleration, equal_speed, as_made, torsion_spring, load, measurement, rating, friction, operation, uncertainty, \
                    tolerance, effect";
    assert_eq!(
        message(&edited("[deceleration]", "[decelaration]")),
        format!(
            "drive.toml:5: decelaration: unknown section; did you mean deceleration? Allowed: {sections}"
        )
    );
    assert_eq!(
        message(&edited("[material]", "[plot]")),
        format!("drive.toml:1: plot: unknown section; allowed: {sections}")
    );
    assert_eq!(
        messages("[equal_speed]\n"),
        [
            "drive.toml:1: equal_speed.kind: missing; expected \"ring_groove\" or \"cross_slide\"",
            "drive.toml:1: equal_speed.ball_count: missing; \
             expected a whole number not less than 3 and not more than 1000",
            "drive.toml:1: equal_speed.pitch_radius: missing; write one of pitch_radius_m, pitch_radius_cm, \
             pitch_radius_mm, pitch_radius_um, pitch_radius_nm",
            "drive.toml:1: equal_speed.ball_radius: missing; write one of ball_radius_m, ball_radius_cm, \
             ball_radius_mm, ball_radius_um, ball_radius_nm",
            "drive.toml:1: equal_speed.groove_conformity: missing; expected a finite number greater than 1",
            "drive.toml:1: equal_speed.contact_angle: missing; write one of contact_angle_rad, contact_angle_mrad, \
             contact_angle_urad, contact_angle_deg, contact_angle_arcmin, contact_angle_arcsec, \
             or both outside_contact_angle and inside_contact_angle",
            "drive.toml: deceleration: the section is missing; it needs ball_count, short_amplitude_coefficient, \
             rolling_circle_radius_mm, ball_radius_mm, groove_conformity, contact_angle_deg; any other reducer has a [torsion_spring]",
        ]
    );
    assert_eq!(
        message(&edited("[material]", "[[material]]")),
        "drive.toml:1: material = an array: expected one section [material]"
    );
    assert_eq!(message(&format!("load = 5\n{RING}")), "drive.toml:1: load = 5: expected one section [load]");
    assert_eq!(
        message(&format!("{RING}[effect]\nid = \"creep\"")),
        "drive.toml:24: effect = a table: expected an entry of its own for each effect, headed [[effect]]"
    );
}

#[test]
fn a_wrong_value_is_told_what_is_expected() {
    for (line, by, expected) in [
        (
            "groove_conformity = 1.08",
            "groove_conformity = \"wide\"",
            "10: deceleration.groove_conformity = \"wide\": expected a finite number greater than 1",
        ),
        (
            "ball_radius_mm = 1.2",
            "ball_radius_mm = nan",
            "9: deceleration.ball_radius_mm = nan: expected a finite number in mm greater than 0",
        ),
        (
            "ball_radius_mm = 1.2",
            "ball_radius_mm = -inf",
            "9: deceleration.ball_radius_mm = -inf: expected a finite number in mm greater than 0",
        ),
        (
            "youngs_modulus_GPa = 208.0",
            "youngs_modulus_GPa = 1e300",
            "2: material.youngs_modulus_GPa = 1e300: expected a finite number in GPa greater than 0",
        ),
        (
            "contact_angle_deg = 45.0",
            "contact_angle_deg = true",
            "11: deceleration.contact_angle_deg = true: expected a finite number in deg greater than 0 and less than 90",
        ),
        (
            "ball_count = 20",
            "ball_count = 20.5",
            "6: deceleration.ball_count = 20.5: expected a whole number not less than 3 and not more than 1000",
        ),
        (
            "ball_count = 20",
            "ball_count = -20",
            "6: deceleration.ball_count = -20: expected a whole number not less than 3 and not more than 1000",
        ),
        (
            "kind = \"ring_groove\"",
            "kind = \"ring_grove\"",
            "14: equal_speed.kind = \"ring_grove\": did you mean ring_groove? Expected \"ring_groove\" or \"cross_slide\"",
        ),
        (
            "sensor_gain_rel = 0.05",
            "sensor_gain_rel = -0.05",
            "23: uncertainty.sensor_gain_rel = -0.05: expected a finite number not less than 0",
        ),
    ] {
        assert_eq!(message(&edited(line, by)), format!("drive.toml:{expected}"));
    }
}

#[test]
fn what_the_mechanics_refuse_is_told_in_the_words_of_the_file() {
    for (line, by, expected) in [
        (
            "ball_radius_mm = 1.2",
            "ball_radius_um = -1_200",
            "9: deceleration.ball_radius_um = -1_200: must be a finite number greater than 0",
        ),
        ("ball_count = 12", "ball_count = 2", "15: equal_speed.ball_count = 2: must lie between 3 and 1000"),
        (
            "youngs_modulus_GPa = 208.0",
            "youngs_modulus_MPa = 0",
            "2: material.youngs_modulus_MPa = 0: must be a finite number greater than 0",
        ),
        (
            "poissons_ratio = 0.3",
            "ball_poissons_ratio = 0.5",
            "3: material.ball_poissons_ratio = 0.5: must lie between -1 and 0.5, 0.3 for steel",
        ),
        (
            "poissons_ratio = 0.3",
            "contact_pressure_limit_GPa = -1",
            "3: material.contact_pressure_limit_GPa = -1: must be a finite number greater than 0",
        ),
        (
            "[material]",
            "[load]\npreload_kN = -0.6\n[material]",
            "2: load.preload_kN = -0.6: must be a finite number greater than 0",
        ),
    ] {
        assert_eq!(message(&edited(line, by)), format!("drive.toml:{expected}"));
    }
    let angle = message(&RING.replace("contact_angle_deg = 45.0\n\n[unc", "contact_angle_deg = 90\n\n[unc"));
    assert!(
        angle.starts_with("drive.toml:19: equal_speed.contact_angle_deg = 90: must lie between"),
        "{angle}"
    );
    let plate =
        RING.replace("ring_groove", "cross_slide").replace("[equal", "output_plate = \"epicycloid\"\n[equal");
    let plate = message(&plate);
    assert!(
        plate.starts_with("drive.toml:13: deceleration.output_plate = \"epicycloid\": a cross-slide"),
        "{plate}"
    );
}

#[test]
fn one_reading_finds_all_mistakes_in_the_order_of_the_file() {
    let text = RING
        .replace("poissons_ratio = 0.3", "poissons_ratio = 0.6")
        .replace("rolling_circle_radius_mm = 2.5", "rolling_circle_radus_mm = 2.5")
        .replace("groove_conformity = 1.08", "groove_conformity = 0.9")
        .replace("kind = \"ring_groove\"", "kind = 3")
        .replace("contact_stiffness_rel", "contact_stiffness");
    let starts = [
        "drive.toml:3: material.poissons_ratio = 0.6: must",
        "drive.toml:8: deceleration.rolling_circle_radus_mm: unknown key",
        "drive.toml:10: deceleration.groove_conformity = 0.9: must",
        "drive.toml:14: equal_speed.kind = 3: expected",
        "drive.toml:18: equal_speed.groove_conformity = 0.9: must",
        "drive.toml:22: uncertainty.contact_stiffness: unknown key; did you mean contact_stiffness_rel?",
    ];
    let messages = messages(&text);
    assert_eq!(messages.len(), starts.len(), "{messages:#?}");
    for (message, start) in messages.iter().zip(starts) {
        assert!(message.starts_with(start), "{message}");
    }
}

#[test]
fn a_key_of_the_other_kind_says_so() {
    assert_eq!(
        message(&edited("ball_count = 12", "ball_count = 12\nform = \"paper\"")),
        "drive.toml:16: equal_speed.form: only a pair with kind = \"cross_slide\" has this key; \
         this pair has kind = \"ring_groove\""
    );
    let slide = RING.replace("ring_groove", "cross_slide");
    let angles = "outside_contact_angle_deg = 45\ninside_contact_angle_deg = 45\n\n[unc";
    let messages = messages(&slide.replace("contact_angle_deg = 45.0\n\n[unc", angles));
    assert_eq!(messages.len(), 3, "{messages:#?}");
    assert!(messages[0].contains("equal_speed.contact_angle: missing"), "{messages:#?}");
    assert!(messages[1].contains("outside_contact_angle_deg: only a pair with"), "{messages:#?}");
    let uncertain = message(&format!("{slide}equal_speed_inside_contact_angle_deg = 1\n"));
    assert!(uncertain.contains("only a pair with kind = \"ring_groove\""), "{uncertain}");
}

#[test]
#[expect(clippy::too_many_lines, reason = "a list of mistakes and their messages")]
fn a_wrong_effect_is_told_what_is_expected() {
    let effect = |lines: &str| messages(&format!("{RING}[[effect]]\n{lines}\n"));
    let one = |lines: &str, expected: &str| {
        let found = effect(lines);
        assert!(found.len() == 1 && found[0].starts_with(expected), "{found:#?}");
    };
    one("u_um = 1", "drive.toml:24: effect[0].id: missing; expected a text in quotes");
    one(
        "id = \"eccentric_baering\"",
        "drive.toml:25: effect[0].id = \"eccentric_baering\": no built-in effect has this id; \
         did you mean eccentric_bearing? An own effect needs an expression; built-in are contact_stiffness,",
    );
    let of = |id: &str, line: &str, expected: &str| one(&format!("id = \"{id}\"\n{line}"), expected);
    of(
        "creep",
        "time_constant_s = nan",
        "drive.toml:26: effect[0].time_constant_s = nan: expected a finite number",
    );
    of(
        "creep",
        "compliance = 1",
        "drive.toml:26: effect[0].compliance: the key needs a unit; write one of compliance_rad_",
    );
    of(
        "drift",
        "rate = 1",
        "drive.toml:26: effect[0].rate: the key needs a unit; write one of rate_rad_per_s, rate_urad",
    );
    of(
        "wear",
        "lost_share_per_d = 1",
        "drive.toml:26: effect[0].lost_share_per_d: unit per_d is not read; use per_s,",
    );
    of(
        "bearing_play",
        "clearance_um = -1",
        "drive.toml:26: effect[0].clearance_um = -1: expected a finite number in um not less than 0 and not more than 1000",
    );
    of(
        "eccentric_bearing",
        "reference_deflecton_um = 1",
        "drive.toml:26: effect[0].reference_deflecton_um: unknown key; did you mean reference_deflection_um? Allowed here: id,",
    );
    of(
        "groove_pitch_error",
        "harmonic = 2.5",
        "drive.toml:26: effect[0].harmonic = 2.5: expected a whole number",
    );
    of("creep", "port = \"load\"", "drive.toml:26: effect[0].port = \"load\": creep acts at the port series");
    one("id = \"creep\"\nparameters = {}", "drive.toml:26: effect[0].parameters: only own effects");
    one(
        "id = \"mine\"\nexpression = \"1\"",
        "drive.toml:24: effect[0].port: missing; an own effect needs the port",
    );
    let own = "id = \"mine\"\nport = \"series\"\nexpression = \"1e-6 * torque_Nm\"";
    one(
        &own.replace("mine", "creep"),
        "drive.toml:25: effect[0].id = \"creep\": a built-in effect has this id",
    );
    one(&own.replace("series", "serie"), "drive.toml:26: effect[0].port = \"serie\": did you mean series?");
    one(
        &format!("{own}\na = 1"),
        "drive.toml:28: effect[0].a: unknown key; allowed here: id, port, adds_to, expression,",
    );
    one(&format!("{own}\nparameters = 1"), "drive.toml:28: effect[0].parameters = 1: expected a table of");
    let parameter = |text: &str, expected: &str| one(&format!("{own}\nparameters = {text}"), expected);
    parameter("{ a = 1 }", "drive.toml:28: effect[0].parameters.a = 1: expected a table such as");
    parameter("{ a = { start = 1 } }", "drive.toml:28: effect[0].parameters.a.unit: missing");
    parameter(
        "{ a = { unit = \"\", strt = 1 } }",
        "drive.toml:28: effect[0].parameters.a.strt: unknown key; did you mean start?",
    );
    parameter(
        "{ a = { unit = \"\", start = 1, min = 2 } }",
        "drive.toml:28: effect[0].parameters.a: min, start and max",
    );
    parameter(
        "{ 2a = { unit = \"\", start = 1 } }",
        "drive.toml:28: effect[0].parameters.2a: a parameter is named",
    );
}

#[test]
fn syntax_errors_have_their_line() {
    for (line, by, expected) in [
        (
            "kind = \"ring_groove\"",
            "kind = ring_groove",
            "drive.toml:14: not valid TOML: string values must be quoted, expected literal string, in `kind = ring_groove`",
        ),
        (
            "[deceleration]",
            "[deceleration",
            "drive.toml:5: not valid TOML: unclosed table, expected `]`, in `[deceleration`",
        ),
        (
            "ball_radius_mm = 1.2",
            "ball_radius_mm = 1,2",
            "drive.toml:9: not valid TOML: unexpected key or value, expected newline, `#`, in `ball_radius_mm = 1,2`; write 1.5, not 1,5",
        ),
        (
            "poissons_ratio = 0.3",
            "youngs_modulus_GPa = 1",
            "drive.toml:3: not valid TOML: duplicate key, in `youngs_modulus_GPa = 1`; write each key and each section once",
        ),
    ] {
        assert_eq!(message(&edited(line, by)), expected);
    }
}

#[test]
fn a_bad_line_is_told_once() {
    let text = edited("kind = \"ring_groove\"", "kind = = 3 x y = ] 5, \"");
    let told = message(&text);
    assert!(told.starts_with("drive.toml:14: not valid TOML: extra `=`"), "{told}");
    assert_eq!(told.lines().count(), 1, "{told}");
}

#[test]
fn a_file_that_cannot_be_read_says_why() {
    let folder = std::env::temp_dir().join(format!("cbpt-case-{}", std::process::id()));
    fs::create_dir_all(&folder).unwrap();
    let written = |name: &str, bytes: &[u8]| -> PathBuf {
        let path = folder.join(name);
        fs::write(&path, bytes).unwrap();
        path
    };
    let refused =
        |path: &Path| Case::read(path).unwrap_err().to_string().replace(&path.display().to_string(), "FILE");
    assert_eq!(Case::read(&written("good.toml", RING.as_bytes())), Ok(read(RING)));
    assert_eq!(refused(&folder.join("none.toml")), "FILE: file not found");
    assert_eq!(refused(&folder), "FILE: is a directory, not a case file");
    assert_eq!(
        refused(&written("latin.toml", b"# x\n# \xe4\n")),
        "FILE:2: not UTF-8 text; save the file as UTF-8"
    );
    assert_eq!(
        refused(&written("large.toml", &vec![b'\n'; LARGEST + 1])),
        "FILE: the file is larger than 1 MiB, too large for a case file"
    );
    fs::remove_dir_all(folder).unwrap();
}

#[test]
fn a_flood_of_mistakes_stops() {
    let text = (0..10_000).map(|n| format!("key{n} = 1")).collect::<Vec<_>>().join("\n");
    let error = Case::from_toml(&text, "drive.toml").unwrap_err();
    assert_eq!(error.mistakes.len(), CaseError::MOST);
    let told = error.to_string();
    assert_eq!(told.lines().count(), CaseError::TOLD + 1);
    assert!(told.ends_with("\nand at least 80 more"), "{told}");
    let few = text.lines().take(30).collect::<Vec<_>>().join("\n");
    let told = Case::from_toml(&few, "drive.toml").unwrap_err();
    let more = told.mistakes.len() - CaseError::TOLD;
    assert!(told.to_string().ends_with(&format!("\nand {more} more")), "{told}");
}

#[test]
fn a_torsion_spring_is_no_ball_drive() {
    let spring = "[torsion_spring]\ntorsional_stiffness_Nm_per_rad = 1e4\n";
    assert!(messages(&format!("{RING}{spring}"))[0].contains("[material]: is about a ball drive"));
    assert_eq!(
        message(&format!("{spring}torque_Nm = [0, 1]\nelastic_angle_rad = [0, 1]\n")),
        "drive.toml:2: torsion_spring.torsional_stiffness_Nm_per_rad: torsion_spring.torque_Nm gives the stiffness as \
         well; keep one of them"
    );
    assert!(message("[torsion_spring]\ntorque_Nm = [0, 1]\n").contains("torsional_stiffness: missing"));
    let table =
        |torque: &str| format!("[torsion_spring]\ntorque_Nm = {torque}\nelastic_angle_mrad = [0, 1, 2]\n");
    assert_eq!(
        message(&table("[0, 2, 1]")),
        "drive.toml:2: torsion_spring.torque_Nm = an array: must rise from entry to entry, and entry 3 is not above the \
         one before"
    );
    for no_list in ["[0, \"a\", 1]", "5"] {
        assert!(messages(&table(no_list))[0].contains("expected a list of finite numbers in Nm"));
    }
    let tilt = message(&format!("{spring}[[effect]]\nid = \"plate_tilt\"\n"));
    assert!(tilt.contains("effect[0].id = \"plate_tilt\": is about the balls"), "{tilt}");
    let play = message(&format!("{spring}[[effect]]\nid = \"bearing_play\"\n"));
    assert!(play.contains("torsion_spring.reference_radius_mm"), "{play}");
}

/// A text of a mebibyte, each byte or line of it a mistake: searched anew for each it takes half an hour.
#[test]
fn a_flood_of_any_kind_takes_as_long_as_it_is() {
    for part in
        [",", ",\n", "=", "a = 1\n", "[a]\n", "[", "\r", ", \n[ \n= \n\" \n", "a = [,\n", "\"", "a = {,,"]
    {
        let text = part.repeat(LARGEST / part.len());
        let error = Case::from_toml(&text, "drive.toml").unwrap_err();
        assert!((1..=CaseError::MOST).contains(&error.mistakes.len()), "{part:?}");
    }
}

#[test]
fn lines_and_columns_count_from_one() {
    for (text, line, column) in [("= 1", 1, 1), ("\nä = 1\n", 2, 1), ("a = 1\n\n  [", 3, 3)] {
        let error = Case::from_toml(text, "drive.toml").unwrap_err();
        let first = &error.mistakes[0];
        assert_eq!(first.line, Some(line), "{text:?}");
        assert!(first.column.is_some_and(|found| found >= column), "{text:?}: {first:?}");
    }
}
