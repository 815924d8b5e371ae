//! Files that are written, readers that leave early, full disks.

use std::fs;
use std::process::Stdio;

use crate::{Desk, assert_close, cells};

#[test]
fn a_json_file_holds_what_would_be_printed() {
    let desk = Desk::new("out_json");
    for verb in ["solve case.toml", "preload case.toml", "sweep case.toml", "check case.toml"] {
        let printed = desk.cbpt(&format!("{verb} --json"));
        let ran = desk.cbpt(&format!("{verb} --out answer.JSON"));
        assert_eq!((printed.code, ran.code), (0, 0), "{verb}");
        assert_eq!(desk.read("answer.JSON").trim_end(), printed.out.trim_end(), "{verb}");
        assert_ne!(ran.out, printed.out, "{verb}: the text is printed all the same");
    }
}

#[test]
fn a_csv_file_keeps_every_digit() {
    let desk = Desk::new("out_csv");
    let solved = desk.json("solve case.toml --json --out points.csv", 0);
    let table = desk.read("points.csv");
    let rows = cells(&table);
    assert_eq!(rows.len(), 1 + 40 + 28);
    let column = |name: &str| rows[0].iter().position(|cell| *cell == name).unwrap();
    let (force, pair) = (column("force_N"), column("pair"));
    let mut seen = 0;
    for name in ["deceleration", "equal_speed"] {
        for point in solved["pairs"][name]["points"].as_array().unwrap() {
            seen += 1;
            assert_eq!(rows[seen][pair], name);
            let cell: f64 = rows[seen][force].parse().unwrap();
            // The last bit may go where JSON is read.
            assert_close(&point["force_N"], cell, 3e-16);
        }
    }
    assert_eq!(seen + 1, rows.len());
    assert_eq!(desk.cbpt("preload case.toml --out needed.csv").code, 0);
    assert!(desk.read("needed.csv").starts_with("pair,hold_N,continuous_N,zero_backlash_N\ndeceleration,"));
    // What has no solution has no points either.
    assert_eq!(desk.cbpt("solve case.toml --torque-Nm 99 --out none.csv").code, 3);
    assert_eq!(desk.read("none.csv").lines().count(), 1);
}

#[test]
fn a_file_that_cannot_be_written_is_exit_code_1() {
    let desk = Desk::new("unwritable");
    for verb in ["solve case.toml", "preload case.toml", "sweep case.toml", "check case.toml", "schema"] {
        let ran = desk.cbpt(&format!("{verb} --out no/such/place/answer.json"));
        assert_eq!(ran.code, 1, "{ran:?}");
        assert!(ran.err.starts_with("cbpt: cannot write no/such/place/answer.json: "), "{}", ran.err);
        assert_eq!(ran.out, "");
    }
}

#[test]
fn a_file_of_unknown_ending_is_refused() {
    let desk = Desk::new("ending");
    for name in ["answer.xlsx", "answer", ".csv"] {
        desk.cbpt(&format!("solve case.toml --out {name}")).refused(&[name, ".csv or .json"]);
        assert!(!desk.directory.join(name).exists());
    }
}

#[test]
fn a_reader_that_leaves_early_is_no_failure() {
    let desk = Desk::new("pipe");
    let mut child = desk
        .command("sweep case.toml --torque-Nm 0:5:0.001 --json".split(' '))
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    drop(child.stdout.take());
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(0));
    assert_eq!(String::from_utf8(output.stderr).unwrap(), "");
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_behind_standard_output_is_exit_code_1() {
    let desk = Desk::new("full");
    let full = fs::File::options().write(true).open("/dev/full").unwrap();
    let output = desk.command(["schema", "--keys"]).stdout(full).output().unwrap();
    assert_eq!(output.status.code(), Some(1));
    assert!(String::from_utf8(output.stderr).unwrap().contains("cannot write standard output"));
}
