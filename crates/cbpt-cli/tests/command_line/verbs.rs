//! The verbs of the mechanics: numbers, units, what is told.

use serde_json::Value;

use crate::{Desk, EXAMPLE, assert_close, cells, keys, number};

// --- solve --------------------------------------------------------------------------------

#[test]
fn solve_gives_the_base_case() {
    let desk = Desk::new("solve");
    let solved = desk.json("solve bare.toml --torque-Nm 5 --preload-N 600 --input-angle-deg 0 --json", 0);
    assert_eq!(solved["status"], "ok");
    assert_close(&solved["elastic_angle_arcsec"], 12.460_454_90, 1e-9);
    assert_close(&solved["alpha_deceleration_arcsec"], 5.159_034_343_406_146, 1e-10);
    assert_close(&solved["alpha_equal_speed_arcsec"], 7.301_420_557_567_914, 1e-10);
    let parts = number(&solved["alpha_deceleration_arcsec"]) + number(&solved["alpha_equal_speed_arcsec"]);
    assert_close(&solved["elastic_angle_arcsec"], parts, 1e-15);
    assert!((0.0..=1e-11).contains(&number(&solved["residual"])));
    assert_eq!(solved["hold_preload_N"], Value::Null);
    assert_close(&solved["transmission_ratio"], 10.5, 1e-15);
    assert_eq!(solved["pairs"]["deceleration"]["points"].as_array().map(Vec::len), Some(40));
    assert_eq!(solved["pairs"]["equal_speed"]["points"].as_array().map(Vec::len), Some(28));
}

#[test]
fn solve_prints_a_summary_for_people() {
    let desk = Desk::new("solve_text");
    let ran = desk.cbpt("solve case.toml");
    assert_eq!((ran.code, ran.err.as_str()), (0, ""));
    for part in ["Elastic angle: 12.4605 arcsec", "Status: solved", "80 of 80", "56 of 56"] {
        assert!(ran.out.contains(part), "{part:?} is not in {}", ran.out);
    }
    assert!(!ran.out.contains("Meshing points"));
    let with_points = desk.cbpt("solve case.toml --points").out;
    assert!(with_points.contains("Meshing points") && with_points.contains("force_N"));
}

#[test]
fn what_the_preload_cannot_hold_has_nulls_and_the_preload_that_would() {
    let desk = Desk::new("beyond");
    let solved = desk.json("solve case.toml --torque-Nm 50 --json", 3);
    assert_eq!(solved["status"], "beyond_hold");
    for key in ["elastic_angle_arcsec", "alpha_deceleration_arcsec", "alpha_equal_speed_arcsec", "residual"] {
        assert_eq!(solved[key], Value::Null, "{key}");
    }
    let hold = number(&solved["hold_preload_N"]);
    assert!(hold > 600.0);
    let at = |preload: f64| desk.cbpt(&format!("solve case.toml --torque-Nm 50 --preload-N {preload}")).code;
    assert_eq!((at(hold * 0.999_99), at(hold * 1.001)), (3, 0));
    assert!(desk.cbpt("solve case.toml --torque-Nm 50").out.contains("no solution"));
}

#[test]
fn a_load_comes_from_flags_then_from_the_case() {
    let desk = Desk::new("load");
    let own = desk.json("solve case.toml --json", 0);
    assert_eq!(own, desk.json("solve bare.toml --torque-Nm 5 --preload-N 600 --json", 0));
    let other = desk.json("solve case.toml --torque-Nm 7 --json", 0);
    assert_eq!(other, desk.json("solve bare.toml --torque-Nm 7 --preload-N 600 --json", 0));
    assert_ne!(own["elastic_angle_arcsec"], other["elastic_angle_arcsec"]);
    desk.write("turned.toml", &EXAMPLE.replace("input_angle_deg = 0.0", "input_angle_deg = 40.0"));
    let turned = desk.json("solve turned.toml --json", 0);
    assert_close(&turned["load"]["input_angle_deg"], 40.0, 1e-14);
    assert_eq!(
        desk.json("solve turned.toml --input-angle-deg 0 --json", 0)["elastic_angle_arcsec"],
        own["elastic_angle_arcsec"]
    );
    desk.cbpt("solve bare.toml --torque-Nm 5").refused(&["--preload-N", "`preload_N` under [load]"]);
    desk.cbpt("solve bare.toml --preload-N 5").refused(&["--torque-Nm", "`torque_Nm` under [load]"]);
    desk.cbpt("preload bare.toml").refused(&["--torque-Nm"]);
    desk.cbpt("sweep bare.toml --torque-Nm 1,2").refused(&["--preload-N"]);
}

#[test]
fn a_torque_backwards_mirrors_the_angle() {
    let desk = Desk::new("mirror");
    let there = desk.json("solve case.toml --torque-Nm 8 --preload-N 300 --input-angle-deg 25 --json", 0);
    let back = desk.json("solve case.toml --torque-Nm -8 --preload-N 300 --input-angle-deg -25 --json", 0);
    assert_close(&back["elastic_angle_arcsec"], -number(&there["elastic_angle_arcsec"]), 1e-9);
}

#[test]
fn over_a_period_gives_the_largest_angle() {
    let desk = Desk::new("period");
    let solved = desk.json("solve case.toml --over-period --json", 0);
    let over = &solved["over_period"];
    let largest = number(&over["largest_elastic_angle_arcsec"]);
    let amplitude = number(&over["amplitude_arcsec"]);
    assert_eq!(over["status"], "ok");
    assert!(largest >= number(&solved["elastic_angle_arcsec"]) && amplitude >= 0.0);
    let angle = number(&over["input_angle_deg"]);
    let there = desk.json(&format!("solve case.toml --input-angle-deg {angle} --json"), 0);
    assert_close(&there["elastic_angle_arcsec"], largest, 1e-9);
}

#[test]
fn results_are_said_in_the_units_that_are_asked_for() {
    let desk = Desk::new("units");
    let plain = desk.json("solve case.toml --json", 0);
    let rad_per_arcsec = std::f64::consts::PI / 648_000.0;
    for (unit, per_arcsec) in [
        ("arcmin", 1.0 / 60.0),
        ("deg", 1.0 / 3600.0),
        ("urad", 1e6 * rad_per_arcsec),
        ("mrad", 1e3 * rad_per_arcsec),
        ("rad", rad_per_arcsec),
    ] {
        let said = desk.json(&format!("solve case.toml --json --angle-unit {unit}"), 0);
        for key in ["elastic_angle", "alpha_deceleration", "alpha_equal_speed"] {
            let expected = number(&plain[format!("{key}_arcsec")]) * per_arcsec;
            assert_close(&said[format!("{key}_{unit}")], expected, 1e-14);
            assert_eq!(said[format!("{key}_arcsec")], Value::Null);
        }
    }
    let said = desk.json(
        "solve case.toml --json --force-unit kN --torque-unit Nmm --length-unit nm --pressure-unit MPa",
        0,
    );
    let (pair, in_plain) = (&said["pairs"]["equal_speed"], &plain["pairs"]["equal_speed"]);
    for (key, plain_key, factor) in [
        ("torque_Nmm", "torque_Nm", 1e3),
        ("approach_nm", "approach_um", 1e3),
        ("in_plane_force_along_kN", "in_plane_force_along_N", 1e-3),
        ("tilt_couple_Nmm", "tilt_couple_Nm", 1e3),
        ("peak_pressure_MPa", "peak_pressure_GPa", 1e3),
    ] {
        assert_close(&pair[key], number(&in_plain[plain_key]) * factor, 1e-14);
    }
    let (point, in_plain) = (&pair["points"][0], &in_plain["points"][0]);
    assert_close(&point["force_kN"], number(&in_plain["force_N"]) * 1e-3, 1e-14);
    assert_close(&point["deformation_nm"], number(&in_plain["deformation_um"]) * 1e3, 1e-14);
    assert!(desk.cbpt("solve case.toml --angle-unit mrad").out.contains("0.06041 mrad"));
    desk.cbpt("solve case.toml --angle-unit grad").refused(&["grad", "arcsec"]);
}

// --- preload ------------------------------------------------------------------------------

const THRESHOLDS: [&str; 3] = ["hold_N", "continuous_N", "zero_backlash_N"];

#[test]
fn preload_gives_three_thresholds_of_each_pair_and_of_the_drive() {
    let desk = Desk::new("preload");
    let needed = desk.json("preload bare.toml --torque-Nm 5 --json", 0);
    for pair in ["deceleration", "equal_speed", "drive"] {
        assert_eq!(keys(&needed[pair]), THRESHOLDS);
        let [hold, continuous, zero_backlash] = THRESHOLDS.map(|key| number(&needed[pair][key]));
        assert!(0.0 < hold && hold <= continuous && continuous <= zero_backlash, "{pair}");
    }
    assert_close(&needed["deceleration"]["continuous_N"], 145.0457, 1e-6);
    assert_close(&needed["equal_speed"]["continuous_N"], 152.4597, 1e-6);
    for key in THRESHOLDS {
        let larger = number(&needed["deceleration"][key]).max(number(&needed["equal_speed"][key]));
        assert_close(&needed["drive"][key], larger, 0.0);
    }
    assert_eq!(needed, desk.json("preload case.toml --json", 0));
    // Thresholds are proportional to the torque, so say them in kN of a thousandfold torque.
    let thousandfold = desk.json("preload bare.toml --torque-Nm 5000 --force-unit kN --json", 0);
    assert_close(&thousandfold["drive"]["hold_kN"], number(&needed["drive"]["hold_N"]), 1e-12);
}

#[test]
fn thresholds_at_one_angle_stay_below_their_maxima() {
    let desk = Desk::new("preload_at");
    let maxima = desk.json("preload case.toml --json", 0);
    assert_eq!(maxima["input_angle_deg"], Value::Null);
    for angle in [0, 7, 20, -100] {
        let here = desk.json(&format!("preload case.toml --input-angle-deg {angle} --json"), 0);
        assert_close(&here["input_angle_deg"], f64::from(angle), 0.0);
        for pair in ["deceleration", "equal_speed", "drive"] {
            for key in THRESHOLDS {
                let (value, most) = (number(&here[pair][key]), number(&maxima[pair][key]));
                assert!(value <= most * (1.0 + 1e-12), "{pair} {key} at {angle} deg");
            }
        }
    }
}

#[test]
fn the_hold_threshold_is_where_solving_begins() {
    let desk = Desk::new("hold");
    let hold = number(&desk.json("preload case.toml --input-angle-deg 33 --json", 0)["drive"]["hold_N"]);
    for (factor, code) in [(0.999_999, 3), (1.0001, 0)] {
        let preload = hold * factor;
        let ran = desk.cbpt(&format!("solve case.toml --input-angle-deg 33 --preload-N {preload}"));
        assert_eq!(ran.code, code, "{ran:?}");
    }
}

// --- sweep --------------------------------------------------------------------------------

#[test]
fn sweep_runs_over_lists_and_ranges_in_order() {
    let desk = Desk::new("sweep");
    let line = "sweep bare.toml --torque-Nm -1:1:0.5,4 --preload-N 600,300 --input-angle-deg 0:20:10 --json";
    let swept = desk.json(line, 0);
    let columns = [
        "torque_Nm",
        "preload_N",
        "input_angle_deg",
        "elastic_angle_arcsec",
        "alpha_deceleration_arcsec",
        "alpha_equal_speed_arcsec",
        "residual",
        "status",
    ];
    assert_eq!(keys(&swept), columns);
    for column in columns {
        assert_eq!(swept[column].as_array().map(Vec::len), Some(6 * 2 * 3), "{column}");
    }
    let torques: Vec<f64> = (0..6).map(|row| number(&swept["torque_Nm"][row])).collect();
    assert_eq!(torques, [-1.0, -0.5, 0.0, 0.5, 1.0, 4.0]);
    assert_eq!(
        [0, 5, 6, 11, 12].map(|row| number(&swept["preload_N"][row])),
        [600.0, 600.0, 300.0, 300.0, 600.0]
    );
    let angles = [0, 12, 24].map(|row| number(&swept["input_angle_deg"][row]).round());
    assert_eq!(angles, [0.0, 10.0, 20.0]);
    let one = desk.json("solve bare.toml --torque-Nm 4 --preload-N 300 --input-angle-deg 20 --json", 0);
    // Many loads are solved side by side, which rounds otherwise.
    let (many, single) = (number(&swept["elastic_angle_arcsec"][35]), number(&one["elastic_angle_arcsec"]));
    assert!((many / single - 1.0).abs() < 1e-12, "{many} {single}");
}

#[test]
fn a_load_without_solution_stays_a_row() {
    let desk = Desk::new("rows");
    let ran = desk.cbpt("sweep case.toml --torque-Nm 5,500 --out rows.csv");
    assert_eq!((ran.code, ran.err.as_str()), (0, ""));
    assert!(ran.out.contains("1 of 2 loads have no solution"), "{}", ran.out);
    let table = desk.read("rows.csv");
    let rows = cells(&table);
    assert_eq!(rows.len(), 3);
    assert_eq!(rows[1][0..3], ["5.0", "600.0", "0.0"]);
    assert_eq!(rows[1][7], "ok");
    assert_eq!(rows[2][3..8], ["", "", "", "", "beyond_hold"]);
    let none = desk.json("sweep case.toml --torque-Nm 500,600 --json", 3);
    assert_eq!(none["elastic_angle_arcsec"], Value::Array(vec![Value::Null; 2]));
}

#[test]
fn a_drive_that_cannot_be_built_is_told_before_its_rows() {
    let desk = Desk::new("unbuildable");
    for (key, sound, wrong, code) in [
        ("ball_count", "14", "60", "rings_overlap"),
        ("short_amplitude_coefficient", "0.5", "0.95", "undercut"),
    ] {
        let drive = EXAMPLE.replace(&format!("{key} = {sound}"), &format!("{key} = {wrong}"));
        desk.write("wrong.toml", &drive);
        desk.write("plan.toml", "case = \"wrong.toml\"\n[axes]\nload.torque_Nm = [1, 2]\n");
        let ran = desk.cbpt("sweep wrong.toml --torque-Nm 1,2 --json");
        let told = format!("cbpt: warning: the drive of the case cannot be built ({code}): ");
        assert!(ran.err.starts_with(&told), "{ran:?}");
        assert_eq!(ran.err.matches("Remedy: ").count(), 1, "{ran:?}");
        assert!(serde_json::from_str::<Value>(&ran.out).is_ok(), "{ran:?}");
        let plan = desk.cbpt("sweep plan.toml --out rows.csv --fresh");
        assert_eq!(plan.err.lines().next(), ran.err.lines().next(), "the same words as of a plan");
    }
}

#[test]
fn a_long_sweep_shows_its_beginning_and_writes_all() {
    let desk = Desk::new("long");
    let ran = desk.cbpt("sweep case.toml --torque-Nm 0:10:0.01 --out long.csv --angle-unit urad");
    assert_eq!(ran.code, 0);
    assert!(ran.out.contains("1001 rows in all"), "{}", ran.out);
    assert!(ran.out.lines().count() < 80);
    let table = desk.read("long.csv");
    assert_eq!(table.lines().count(), 1002);
    assert!(cells(&table)[0].contains(&"elastic_angle_urad"));
}

#[test]
fn ranges_that_cannot_be_are_refused_at_once() {
    let desk = Desk::new("ranges");
    for (torques, words) in [
        ("1,,2", ["`` is not a number", "start:stop:step"]),
        ("0:1", ["`0:1`", "neither a number nor a range"]),
        ("0:1:0", ["`0:1:0`", "step"]),
        ("0:1:-0.1", ["`0:1:-0.1`", "step"]),
        ("0:inf:1", ["`inf`", "number"]),
        ("five", ["`five`", "number"]),
        ("0:1:1e-12", ["`0:1:1e-12`", "step"]),
    ] {
        desk.run(["sweep", "case.toml", "--torque-Nm", torques]).refused(&[
            "--torque-Nm",
            words[0],
            words[1],
        ]);
    }
    // A slip in two steps: 1e8 rows.
    desk.cbpt("sweep case.toml --torque-Nm 0:1:1e-4 --input-angle-deg 0:1:1e-4").refused(&["100020001 rows"]);
    desk.cbpt("sweep case.toml --preload-N 100,0").refused(&["preload_N = 0", "greater than 0"]);
}

#[test]
fn the_help_of_sweep_tells_files_and_chunks() {
    let desk = Desk::new("sweep_help");
    for flag in ["--help", "-h"] {
        let help = desk.cbpt(&format!("sweep {flag}")).out;
        let told = help.split_whitespace().collect::<Vec<_>>().join(" ");
        for words in ["For a PLAN: .csv, or .parquet", "8192, at least one block", "[default: 65536]"] {
            assert!(told.contains(words), "{words} in {help}");
        }
    }
    assert!(desk.cbpt("solve --help").out.contains("Also write to FILE.csv or FILE.json"));
}

#[test]
fn numbers_that_clash_are_told_with_their_rows() {
    let desk = Desk::new("clash");
    let axes =
        "deceleration.output_plate = [\"hypocycloid\", \"epicycloid\"]\nload.torque_Nm = [1, 2, 500]\n";
    let axes = format!("{axes}equal_speed.kind = [\"ring_groove\", \"cross_slide\"]\n");
    desk.write("plan.toml", &format!("case = \"case.toml\"\n[axes]\n{axes}"));
    let ran = desk.cbpt("sweep plan.toml --out rows.csv");
    assert_eq!(ran.code, 0, "{ran:?}");
    let csv = desk.read("rows.csv");
    let rows: Vec<&str> = csv.lines().skip(1).collect();
    let invalid: Vec<usize> = (0..rows.len()).filter(|&row| rows[row].ends_with("invalid_input")).collect();
    let first = invalid[0] + 1;
    let told = format!("invalid_input: {} rows, for example row {first}: ", invalid.len());
    assert!(ran.err.contains(&told) && ran.err.contains("equal_speed"), "{told} in {}", ran.err);
    assert!(ran.err.contains(&format!("of {} rows solved now: ", rows.len())), "{}", ran.err);
    assert!(ran.err.contains("beyond_hold "), "{}", ran.err);
    // Where all is well nothing is said.
    desk.write("plan.toml", "case = \"case.toml\"\n[axes]\nload.torque_Nm = [1, 2]\n");
    assert_eq!(desk.cbpt("sweep plan.toml --out good.csv").err, "");
}

// --- sensitivity --------------------------------------------------------------------------

#[test]
fn sensitivity_tells_every_number_in_its_usual_unit() {
    let desk = Desk::new("sensitivity");
    let found = desk.json("sensitivity case.toml --json", 0);
    let numbers = found["numbers"].as_array().unwrap();
    assert_eq!(numbers.len(), 14);
    let ball = numbers.iter().find(|number| number["number"] == "deceleration.ball_radius_mm").unwrap();
    assert_eq!(ball["value"], Value::from(1.5));
    let (slope, relative) =
        (&ball["per_unit"]["elastic_angle_arcsec"], &ball["relative"]["elastic_angle_arcsec"]);
    let angle = found["elastic_angle_arcsec"].as_f64().unwrap();
    let expected = slope.as_f64().unwrap() * 1.5 / angle;
    assert!((relative.as_f64().unwrap() - expected).abs() < 1e-12);
    let ran = desk.cbpt("sensitivity case.toml --out table.csv --force-unit kN");
    assert!(ran.code == 0 && ran.out.contains("hold 0.128215 kN"), "{}", ran.out);
    assert!(desk.read("table.csv").starts_with("number,value,angle_arcsec_per_unit,"));
    // A terminal is narrow: a column that is empty is left out, and no line is long.
    assert!(!ran.out.contains("share_%"), "{}", ran.out);
    assert!(ran.out.lines().all(|line| line.chars().count() < 100), "{}", ran.out);
    desk.write("u.toml", &format!("{EXAMPLE}[uncertainty]\ndeceleration_ball_radius_um = 1.2345678\n"));
    let ran = desk.cbpt("sensitivity u.toml");
    assert!(ran.out.contains("share_%"), "{}", ran.out);
    assert!(ran.out.lines().all(|line| line.chars().count() < 100), "{}", ran.out);
    // What has no solution still has thresholds.
    let beyond = desk.json("sensitivity case.toml --torque-Nm 50 --json", 3);
    assert_eq!(beyond["elastic_angle_arcsec"], Value::Null);
    assert!(beyond["hold_N"].as_f64().unwrap() > 1000.0);
}

// --- check --------------------------------------------------------------------------------

#[test]
fn check_finds_what_cannot_be_built() {
    let desk = Desk::new("check");
    let clean = desk.json("check case.toml --json", 0);
    assert_eq!(clean["findings"], Value::Array(Vec::new()));
    assert_eq!(clean["checked_under_load"], Value::Bool(true));
    assert_eq!(desk.json("check bare.toml --json", 0)["checked_under_load"], Value::Bool(false));
    assert!(desk.cbpt("check bare.toml").out.contains("No findings"));

    // Balls larger than the radius of the centreline leave no wall.
    let undercut = EXAMPLE.replacen("ball_radius_mm = 1.5", "ball_radius_mm = 20", 1);
    desk.write("undercut.toml", &undercut);
    let found = desk.json("check undercut.toml --json", 4);
    let first = &found["findings"][0];
    assert_eq!(keys(first), ["code", "severity", "pair", "message", "remedy"]);
    assert_eq!((&first["severity"], &first["pair"]), (&Value::from("error"), &Value::from("deceleration")));
    let codes: Vec<&Value> =
        found["findings"].as_array().unwrap().iter().map(|finding| &finding["code"]).collect();
    assert!(codes.contains(&&Value::from("undercut")), "{codes:?}");
    let ran = desk.cbpt("check undercut.toml --out found.csv");
    assert_eq!(ran.code, 4);
    assert!(ran.out.contains("Remedy:"));
    assert!(desk.read("found.csv").starts_with("severity,code,pair,message,remedy\nerror,"));
    let solved = desk.json("solve undercut.toml --json", 3);
    assert_eq!(
        (&solved["status"], &solved["elastic_angle_arcsec"]),
        (&Value::from("undercut"), &Value::Null)
    );
    assert_eq!(desk.cbpt("sweep undercut.toml --torque-Nm 1,2").code, 3);
}

#[test]
fn a_warning_is_told_and_is_no_failure() {
    let desk = Desk::new("warning");
    let found = desk.json("check case.toml --preload-N 5e3 --json", 0);
    let pressure = &found["findings"][0];
    assert_eq!(
        (&pressure["code"], &pressure["severity"]),
        (&Value::from("peak_pressure"), &Value::from("warning"))
    );
    let ran = desk.cbpt("solve case.toml --preload-N 5e3");
    assert_eq!(ran.code, 0);
    assert!(ran.out.contains("warning (equal_speed): the peak contact pressure"), "{}", ran.out);
}

// --- schema -------------------------------------------------------------------------------

#[test]
fn schema_prints_what_editors_and_people_need() {
    let desk = Desk::new("schema");
    let schema = desk.json("schema", 0);
    assert!(schema["$schema"].as_str().is_some_and(|dialect| dialect.contains("json-schema.org")));
    for section in ["material", "deceleration", "equal_speed", "load", "measurement", "uncertainty", "effect"]
    {
        assert!(schema["properties"][section].is_object(), "{section}");
    }
    let table = desk.cbpt("schema --keys");
    assert_eq!(table.code, 0);
    assert!(table.out.contains("`ball_radius_mm`") && table.out.contains("| required |"));
    assert_eq!(desk.cbpt("schema --example").out, EXAMPLE);
    let written = desk.cbpt("schema --example --out new.toml");
    assert_eq!((written.code, written.out.as_str()), (0, ""));
    assert_eq!(desk.read("new.toml"), EXAMPLE);
    assert_eq!(desk.cbpt("solve new.toml --json").out, desk.cbpt("solve case.toml --json").out);
    desk.cbpt("schema --keys --example").refused(&["--keys", "--example"]);
}

// --- effects ------------------------------------------------------------------------------

/// Contributions by what each effect does to the base case's 12.46 arcsec at 5 N m.
#[test]
fn effects_of_the_case_are_part_of_the_answer() {
    let desk = Desk::new("effects");
    let effects = "
        [[effect]]
        id = \"sensor_gain\"
        sensor_gain = 1.1
        [[effect]]
        id = \"output_torsion\"
        compliance_arcsec_per_Nm = 0.5
        [[effect]]
        id = \"creep\"
        compliance_rad_per_Nm = 1e-6";
    desk.write("with.toml", &format!("{EXAMPLE}{effects}"));
    let bare = desk.json("solve case.toml --json", 0)["elastic_angle_arcsec"].as_f64().unwrap();
    let with = desk.json("solve with.toml --json", 0);
    let parts = &with["contributions_arcsec"];
    let close = |found: &Value, expected: f64| {
        let found = found.as_f64().unwrap();
        assert!((found - expected).abs() < 1e-9, "{found} {expected}");
    };
    close(&parts["model"], bare);
    close(&parts["output_torsion"], 2.5);
    close(&parts["creep"], 0.0);
    close(&parts["sensor_gain"], 0.1 * (bare + 2.5));
    close(&with["elastic_angle_arcsec"], 1.1 * (bare + 2.5));
    close(&with["load_at_meshing_points"]["torque_Nm"], 5.0);
    assert_eq!(with["effects_not_counted"][0], "sensor_gain");
    let said = desk.cbpt("solve with.toml").out;
    for words in [
        "as the instrument shows it",
        "contribution",
        "output_torsion",
        "Note: findings are computed for the drive alone",
    ] {
        assert!(said.contains(words), "{words} in {said}");
    }
    let sweep = desk.json("sweep with.toml --torque-Nm 5,1000 --json", 0);
    close(&sweep["elastic_angle_arcsec"][0], 1.1 * (bare + 2.5));
    assert!(sweep["elastic_angle_arcsec"][1].is_null() && sweep["status"][1] == "beyond_hold");
    close(&sweep["alpha_deceleration_arcsec"][0], with["alpha_deceleration_arcsec"].as_f64().unwrap());
    for verb in ["preload", "check"] {
        assert!(
            desk.cbpt(&format!("{verb} with.toml"))
                .out
                .contains("computed for the drive alone, without the effects of the case: sensor_gain")
        );
        assert!(!desk.cbpt(&format!("{verb} case.toml")).out.contains("leave out"));
    }
}

/// A preload that is held back, twice as stiff contacts and a gap are those of the pairs that are shown.
#[test]
fn effects_reach_the_meshing_points_that_are_shown() {
    let desk = Desk::new("effects_at_points");
    let effects = "
        [[effect]]
        id = \"preload_loss\"
        lost_share = 0.25
        [[effect]]
        id = \"contact_stiffness\"
        stiffness_scale = 2
        [[effect]]
        id = \"friction_hysteresis\"
        friction_radius_um = 300";
    desk.write("with.toml", &format!("{EXAMPLE}{effects}"));
    let with = desk.json("solve with.toml --json", 0);
    let at_points = &with["load_at_meshing_points"];
    assert_eq!(at_points["preload_N"], 450.0);
    let torque = at_points["torque_Nm"].as_f64().unwrap();
    assert!(torque > 4.86 && torque < 5.0);
    let bare = desk.json(&format!("solve case.toml --torque-Nm {torque} --preload-N 450 --json"), 0);
    for pair in ["deceleration", "equal_speed"] {
        let angle = |of: &Value| of["pairs"][pair]["angle_arcsec"].as_f64().unwrap();
        let stiffer = angle(&bare) * 2_f64.powf(-2.0 / 3.0);
        assert!((angle(&with) / stiffer - 1.0).abs() < 1e-9, "{pair}");
        let force = |of: &Value| of["pairs"][pair]["points"][0]["force_N"].as_f64().unwrap();
        assert!((force(&with) / force(&bare) - 1.0).abs() < 1e-9, "{pair}");
    }
}

#[test]
fn the_library_is_listed() {
    let desk = Desk::new("library");
    let list = desk.cbpt("effects").out;
    let all = desk.json("effects --json", 0);
    let effects = all["effects"].as_array().unwrap();
    assert_eq!(effects.len(), cbpt_core::effect::LIBRARY.len());
    for effect in effects {
        let id = effect["id"].as_str().unwrap();
        assert!(list.contains(id), "{id}");
        assert_eq!(&desk.json(&format!("effects {id} --json"), 0), effect);
        assert!(desk.cbpt(&format!("effects {id}")).out.contains(effect["equation"].as_str().unwrap()));
    }
    let friction = effects.iter().find(|effect| effect["id"] == "friction_hysteresis").unwrap();
    let friction = &friction["parameters"][0];
    assert_eq!((&friction["name"], &friction["is_size"]), (&"friction_radius_m".into(), &true.into()));
    desk.cbpt("effects creep --page").refused(&["--page"]);
}
