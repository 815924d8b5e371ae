//! What is refused, and any arguments at all.

use std::ffi::OsStr;
use std::fs;

use proptest::prelude::*;
use proptest::sample::select;

use crate::{Desk, EXAMPLE};

// --- what is refused ----------------------------------------------------------------------

#[test]
fn a_mistake_in_the_case_is_told_with_its_place() {
    let desk = Desk::new("mistake");
    desk.write("case.toml", &EXAMPLE.replacen("contact_angle_deg", "contact_angel_deg", 1));
    let line = 1 + EXAMPLE.lines().position(|line| line.contains("contact_angle_deg")).unwrap();
    for verb in ["solve", "preload", "sweep", "check"] {
        let place = format!("{line}");
        desk.cbpt(&format!("{verb} case.toml")).refused(&[
            "case.toml",
            &place,
            "contact_angel_deg",
            "contact_angle_deg",
        ]);
    }
    desk.cbpt("solve missing.toml").refused(&["missing.toml", "not found"]);
    desk.cbpt("solve .").refused(&["directory"]);
    desk.write("empty.toml", "");
    desk.cbpt("solve empty.toml").refused(&["empty.toml", "deceleration"]);
    fs::write(desk.directory.join("binary.toml"), [0xff, 0x00, 0xfe]).unwrap();
    desk.cbpt("check binary.toml").refused(&["binary.toml"]);
}

#[test]
fn a_number_that_cannot_be_is_named() {
    let desk = Desk::new("numbers");
    for (flag, value) in [
        ("--torque-Nm", "nan"),
        ("--torque-Nm", "1e999"),
        ("--preload-N", "0"),
        ("--preload-N", "-600"),
        ("--preload-N", "inf"),
        ("--input-angle-deg", "inf"),
    ] {
        let name = match flag {
            "--torque-Nm" => "torque_Nm",
            "--preload-N" => "preload_N",
            _ => "input_angle",
        };
        desk.run(["solve", "case.toml", flag, value]).refused(&[name]);
    }
    desk.run(["solve", "case.toml", "--torque-Nm", "5 Nm"]).refused(&["5 Nm", "--torque-Nm"]);
    desk.cbpt("solve case.toml --torque 5").refused(&["--torque-Nm"]);
    desk.cbpt("preload case.toml --torque-Nm nan").refused(&["torque_Nm"]);
}

#[test]
fn numbers_of_an_effect_beyond_the_drive_are_refused() {
    let desk = Desk::new("far_effect");
    let far = "\n[[effect]]\nid = \"ball_diameter_lot\"\nball = 20\noversize_um = 1\n";
    desk.write("case.toml", &format!("{EXAMPLE}{far}"));
    desk.cbpt("solve case.toml").refused(&["ball of ball_diameter_lot", "20"]);
}

/// Never a number where the formula has none: the status says so.
#[test]
fn a_formula_that_is_not_finite_is_a_status() {
    let desk = Desk::new("not_finite");
    let own = "\n[[effect]]\nid = \"mine\"\nport = \"series\"\nexpression = \"log(torque_Nm - 10)\"\n";
    desk.write("case.toml", &format!("{EXAMPLE}{own}"));
    let solved = desk.json("solve case.toml --json", 3);
    assert_eq!(solved["status"], "effect_not_finite");
    assert!(solved["elastic_angle_arcsec"].is_null());
    let swept = desk.json("sweep case.toml --torque-Nm 5,12 --json", 0);
    assert_eq!(swept["status"], serde_json::json!(["effect_not_finite", "ok"]));
}

#[test]
fn an_effect_that_is_not_there_is_told_what_it_may_have_meant() {
    Desk::new("no_effect")
        .cbpt("effects frictoin_hysteresis")
        .refused(&["did you mean friction_hysteresis?"]);
}

#[test]
fn verbs_of_the_lab_name_the_wheel() {
    let desk = Desk::new("lab");
    for line in ["compare", "compare case.toml data.csv --json", "compare --plot x.svg", "compare --help"] {
        desk.cbpt(line).refused(&["`cbpt compare`", "pip install cbpt"]);
    }
}

#[test]
fn help_lists_every_verb_and_every_exit_code() {
    let desk = Desk::new("help");
    for line in ["--help", "-h", "help"] {
        let ran = desk.cbpt(line);
        assert_eq!((ran.code, ran.err.as_str()), (0, ""), "{line}");
        for word in
            ["solve", "preload", "sweep", "check", "schema", "compare", "Exit codes: 0", "4 design error"]
        {
            assert!(ran.out.contains(word), "{word:?} is not in the help");
        }
    }
    for verb in ["solve", "preload", "sweep", "check", "schema"] {
        let ran = desk.cbpt(&format!("{verb} --help"));
        assert_eq!(ran.code, 0);
        assert!(ran.out.contains("--out") && ran.err.is_empty(), "{verb}");
    }
    let version = desk.cbpt("--version");
    assert_eq!((version.code, version.out.trim()), (0, concat!("cbpt ", env!("CARGO_PKG_VERSION"))));
    let bare = desk.run(Vec::<&str>::new());
    assert_eq!(bare.code, 2);
    assert!(bare.err.contains("Usage: cbpt <COMMAND>"));
    desk.cbpt("slove case.toml").refused(&["slove", "solve"]);
}

#[cfg(unix)]
#[test]
fn a_path_that_is_no_text_is_a_path_all_the_same() {
    use std::os::unix::ffi::OsStrExt;
    let desk = Desk::new("bytes");
    let name = OsStr::from_bytes(b"dr\xffve.toml");
    desk.run([OsStr::new("solve"), name]).refused(&["not found"]);
    // Not every file system takes such a name.
    if fs::write(desk.directory.join(name), EXAMPLE).is_ok() {
        assert_eq!(desk.run([OsStr::new("check"), name]).code, 0);
    }
}

// --- any arguments ------------------------------------------------------------------------

/// Words that mean something to the command line.
const WORDS: &str = "solve preload sweep check schema compare help case.toml bare.toml undercut.toml missing.toml \
    --torque-Nm --preload-N --input-angle-deg --json --points --over-period --out --out=out.csv --out=out.json \
    --out=no/where.csv --angle-unit --angle-unit=mrad --force-unit --keys --example --help --version -h -- mrad kN";
/// Numbers, lists and ranges that mean trouble.
const NUMBERS: &str = "0 -0 1 5 600 -7.5 1e-3 1e6 1e300 -1e300 5e-324 nan inf 0:3:1 3:0:-1 0:1:0 1,2,, : :: 1:2:3:4 \
    0:9:1e-300 1e30 0.9999999";

fn any_argument() -> impl Strategy<Value = String> {
    let one_of = |words: &'static str| select(words.split_whitespace().collect::<Vec<_>>());
    prop_oneof![
        4 => one_of(WORDS).prop_map(str::to_owned),
        4 => one_of(NUMBERS).prop_map(str::to_owned),
        // No slash: nothing is written outside the directory of the test.
        1 => "[ -.0-~äµ°]{0,6}",
    ]
}

/// A verb that has what it needs, then anything.
fn arguments() -> impl Strategy<Value = Vec<String>> {
    let begun = select(vec!["solve", "preload", "sweep", "check", "schema"]).prop_flat_map(|verb| {
        let case = select(vec!["case.toml", "bare.toml", "undercut.toml"]);
        (Just(verb), case).prop_map(|(verb, case)| match verb {
            "schema" => vec![verb.to_owned()],
            _ => vec![verb.to_owned(), case.to_owned()],
        })
    });
    let flags = select(vec!["--torque-Nm", "--preload-N", "--input-angle-deg"]);
    let pairs = proptest::collection::vec((flags, any_argument()), 0..3)
        .prop_map(|pairs| pairs.into_iter().flat_map(|(flag, value)| [flag.to_owned(), value]).collect());
    let anything = || proptest::collection::vec(any_argument(), 0..5);
    prop_oneof![
        2 => (begun, pairs, anything())
            .prop_map(|(verb, pairs, rest): (_, Vec<String>, _)| [verb, pairs, rest].concat()),
        1 => anything(),
    ]
}

#[test]
fn no_arguments_panic() {
    let desk = Desk::new("any");
    desk.write("undercut.toml", &EXAMPLE.replacen("ball_radius_mm = 1.5", "ball_radius_mm = 20", 1));
    let config = ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(400) };
    proptest!(config, |(arguments in arguments())| {
        let ran = desk.run(&arguments);
        prop_assert!((0..=4).contains(&ran.code), "{arguments:?}: {ran:?}");
        prop_assert!(!ran.err.contains("panicked"), "{arguments:?}: {ran:?}");
        // Whoever is refused is told why, beside what a drive that cannot be built is warned of; and a number is never the
        // answer.
        let told = ran.err.lines().any(|line| !line.starts_with("cbpt: warning: the drive of the case cannot be built"));
        prop_assert_eq!(ran.code == 1 || ran.code == 2, told, "{:?}: {:?}", arguments, ran);
        for odd in ["NaN,", "inf,", ": NaN", ": inf"] {
            prop_assert!(!ran.out.contains(odd), "{arguments:?}: {ran:?}");
        }
    });
}

#[test]
fn an_input_is_not_written_over() {
    let desk = Desk::new("own_input");
    for name in ["case.csv", "./case.csv"] {
        desk.write("case.csv", EXAMPLE);
        for verb in ["solve", "preload", "sweep", "sensitivity", "check"] {
            desk.cbpt(&format!("{verb} case.csv --out {name}")).refused(&[
                "--out",
                name,
                "would overwrite it",
            ]);
            assert_eq!(desk.read("case.csv"), EXAMPLE, "{verb}");
        }
    }
    desk.write("plan.toml", "case = \"case.toml\"\ntable = \"rows.csv\"\n");
    desk.write("rows.csv", "load.torque_Nm\n1\n2\n");
    for fresh in ["", "--fresh"] {
        let ran = desk.cbpt(&format!("sweep plan.toml --out rows.csv {fresh}"));
        ran.refused(&["--out rows.csv", "would overwrite it"]);
    }
    assert_eq!(desk.read("rows.csv"), "load.torque_Nm\n1\n2\n");
}

#[test]
fn a_case_to_parquet_is_told_what_to_do() {
    let desk = Desk::new("parquet");
    let ran = desk.cbpt("sweep case.toml --torque-Nm 1,2 --out x.parquet");
    ran.refused(&[
        "case.toml is a case",
        ".csv or FILE.json",
        "plan.toml",
        "case = \"case.toml\"\n",
        "[axes]",
    ]);
}
