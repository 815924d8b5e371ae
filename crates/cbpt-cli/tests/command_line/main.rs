//! The `cbpt` binary as its users and their scripts meet it: verbs, numbers, units, files, exit codes.
//!
//! Numbers known beforehand are those of the base case; everything else is an identity between two runs.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]
// Torques and preloads are told as they were given.
#![allow(clippy::float_cmp)]

mod files;
mod proof;
mod refused;
mod verbs;

use std::ffi::OsStr;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use serde_json::Value;

/// The example that `cbpt schema --example` prints: the base case, with a `[load]` of 5 N m and 600 N.
const EXAMPLE: &str = include_str!("../../src/example.toml");

/// A directory of its own for each test, with the example as `case.toml` and, without its `[load]`, as `bare.toml`.
struct Desk {
    directory: PathBuf,
}

/// What a run of the binary left behind.
#[derive(Debug)]
struct Ran {
    code: i32,
    out: String,
    err: String,
}

impl Desk {
    fn new(name: &str) -> Self {
        let directory = Path::new(env!("CARGO_TARGET_TMPDIR")).join("command_line").join(name);
        let _ = fs::remove_dir_all(&directory);
        fs::create_dir_all(&directory).expect("a directory for the test");
        let desk = Self { directory };
        desk.write("case.toml", EXAMPLE);
        desk.write("bare.toml", EXAMPLE.split("[load]").next().expect("text before [load]"));
        desk
    }

    fn write(&self, name: &str, text: &str) {
        fs::write(self.directory.join(name), text).expect("the directory can be written");
    }

    fn read(&self, name: &str) -> String {
        fs::read_to_string(self.directory.join(name)).expect("the file was written")
    }

    fn command(&self, arguments: impl IntoIterator<Item = impl AsRef<OsStr>>) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_cbpt"));
        command.current_dir(&self.directory).args(arguments).stdin(Stdio::null());
        command
    }

    fn run(&self, arguments: impl IntoIterator<Item = impl AsRef<OsStr>>) -> Ran {
        let output = self.command(arguments).output().expect("the binary starts");
        Ran {
            code: output.status.code().expect("an exit code, not a signal"),
            out: String::from_utf8(output.stdout).expect("text on standard output"),
            err: String::from_utf8(output.stderr).expect("text on standard error"),
        }
    }

    /// Runs a line of words.
    fn cbpt(&self, line: &str) -> Ran {
        self.run(line.split_whitespace())
    }

    /// Runs a line of words, which must end with `code` and print one JSON object.
    fn json(&self, line: &str, code: i32) -> Value {
        let ran = self.cbpt(line);
        assert_eq!(ran.code, code, "{line}: {ran:?}");
        assert_eq!(ran.err, "", "{line}");
        serde_json::from_str(&ran.out).unwrap_or_else(|error| panic!("{line}: {error} in {}", ran.out))
    }
}

impl Ran {
    /// Bad input: exit code 2, nothing on standard output, and these words on standard error.
    fn refused(&self, words: &[&str]) {
        assert_eq!(self.code, 2, "{self:?}");
        assert_eq!(self.out, "", "{self:?}");
        for word in words {
            assert!(self.err.contains(word), "{word:?} is not in {:?}", self.err);
        }
    }
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value} is no number"))
}

fn assert_close(value: &Value, expected: f64, relative: f64) {
    let found = number(value);
    assert!((found - expected).abs() <= relative * expected.abs(), "{found} is not {expected}");
}

fn keys(object: &Value) -> Vec<&str> {
    object.as_object().expect("an object").keys().map(String::as_str).collect()
}

fn cells(csv: &str) -> Vec<Vec<&str>> {
    csv.lines().map(|line| line.split(',').collect()).collect()
}
