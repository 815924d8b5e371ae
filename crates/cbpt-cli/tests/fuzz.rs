//! Text of strangers: whatever case files, plans, formulas and names of units are made into, there is an answer or an error.
//!
//! Seeds are `tests/data/corpus` and the examples of the repository; each input is a seed with some edits. A run tries a few hundred;
//! `make fuzz` sets `FUZZ_SECONDS`, for which each target goes on with other inputs. An input that fails is shrunk and kept beside
//! the seeds, so that it stays a test once the cause is mended.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::print_stdout)]

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

use cbpt_cli::case::Case;
use cbpt_cli::commands::schema::EXAMPLE;
use cbpt_cli::formula::Formula;
use cbpt_cli::sweep::Plan;
use cbpt_core::effect::{AddsTo, OwnParameter};
use cbpt_core::predict::{Columns, Effect, Predictor, Rows};
use cbpt_core::units::{self, Quantity};
use proptest::prelude::*;
use proptest::sample::Index;
use proptest::test_runner::{RngSeed, TestError, TestRunner};

/// What an edit may put in: what these languages are made of, and numbers at the edge.
const TOKENS: [&str; 40] = [
    "[",
    "]",
    "[[effect]]\n",
    "{",
    "}",
    "=",
    ".",
    ",",
    "\"",
    "'",
    "\"\"\"",
    "#",
    "\n",
    "\t",
    "\u{feff}",
    "\0",
    "\\u0000",
    "-",
    "+",
    "_",
    "1e999",
    "-1e-400",
    "inf",
    "nan",
    "0x",
    "9999999999999999999999",
    "1979-05-27",
    "true",
    "torque_Nm",
    "_per_",
    "deg",
    "id = ",
    "(",
    ")",
    "^",
    "**",
    "/ 0",
    "log(",
    "ä€😀",
    "case = \"case.toml\"\n",
];
/// No input is worth more; a longer one is a finding.
const MOST: Duration = Duration::from_secs(10);

/// One change of a text.
#[derive(Debug, Clone)]
enum Edit {
    Flip(Index, u8),
    Delete(Index, Index),
    Repeat(Index, Index, usize),
    Token(Index, usize),
    Splice(Index, Index, Index, Index),
}

fn edit() -> impl Strategy<Value = Edit> {
    let place = any::<Index>;
    prop_oneof![
        (place(), any::<u8>()).prop_map(|(at, byte)| Edit::Flip(at, byte)),
        (place(), place()).prop_map(|(from, to)| Edit::Delete(from, to)),
        (place(), place(), prop_oneof![1..4_usize, Just(300)]).prop_map(|(a, b, n)| Edit::Repeat(a, b, n)),
        (place(), 0..TOKENS.len()).prop_map(|(at, token)| Edit::Token(at, token)),
        (place(), place(), place(), place())
            .prop_map(|(at, seed, from, to)| Edit::Splice(at, seed, from, to)),
    ]
}

fn span(bytes: &[u8], a: Index, b: Index) -> std::ops::Range<usize> {
    let (a, b) = (a.index(bytes.len() + 1), b.index(bytes.len() + 1));
    // Nearby rather than anywhere, so that most of a seed stays.
    a.min(b)..a.max(b).min(a.min(b) + 60)
}

fn edited(seeds: &[Vec<u8>], seed: Index, edits: &[Edit]) -> String {
    let mut text = seed.get(seeds).clone();
    for edit in edits {
        let at = |place: Index| place.index(text.len() + 1);
        match edit {
            Edit::Flip(place, byte) if !text.is_empty() => {
                let place = place.index(text.len());
                text[place] = *byte;
            }
            Edit::Flip(..) => {}
            Edit::Delete(a, b) => drop(text.drain(span(&text, *a, *b))),
            Edit::Repeat(a, b, times) => {
                let span = span(&text, *a, *b);
                let more = text[span.clone()].repeat(*times);
                text.splice(span.end..span.end, more);
            }
            Edit::Token(place, token) => {
                let place = at(*place);
                text.splice(place..place, TOKENS[*token].bytes());
            }
            Edit::Splice(place, other, from, to) => {
                let (place, other) = (at(*place), other.get(seeds));
                text.splice(place..place, other[span(other, *from, *to)].to_vec());
            }
        }
        text.truncate(1 << 17);
    }
    String::from_utf8_lossy(&text).into_owned()
}

fn repository() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// What is kept for a target, and the examples that name one of its keys.
fn seeds(target: &str, key: &str) -> Vec<Vec<u8>> {
    let read = |folder: PathBuf| {
        let files = fs::read_dir(folder).into_iter().flatten().flatten();
        let mut paths: Vec<PathBuf> = files.map(|file| file.path()).filter(|path| path.is_file()).collect();
        paths.sort();
        paths.into_iter().filter_map(|path| fs::read(path).ok())
    };
    let kept = read(repository().join("tests/data/corpus").join(target));
    let examples = read(repository().join("examples"))
        .filter(|text| !key.is_empty() && text.windows(key.len()).any(|part| part == key.as_bytes()));
    // An unpacked crate has no repository around it.
    std::iter::once(EXAMPLE.as_bytes().to_vec()).chain(kept).chain(examples).collect()
}

/// Tries seeds as they are, then edits of them.
fn fuzz(target: &str, key: &str, check: impl Fn(&str)) {
    let seeds = seeds(target, key);
    for seed in &seeds {
        check(&String::from_utf8_lossy(seed));
    }
    let seconds: Option<u64> = std::env::var("FUZZ_SECONDS").ok().map(|text| text.parse().expect("seconds"));
    let began = Instant::now();
    let given = (any::<Index>(), proptest::collection::vec(edit(), 0..8));
    let mut tried = 0;
    for round in 1.. {
        let rng_seed = if seconds.is_some() { RngSeed::Random } else { RngSeed::Fixed(round) };
        let config =
            ProptestConfig { cases: 400, failure_persistence: None, rng_seed, ..ProptestConfig::default() };
        let run = TestRunner::new(config).run(&given, |(seed, edits)| {
            let text = edited(&seeds, seed, &edits);
            let began = Instant::now();
            check(&text);
            prop_assert!(seconds.is_none() || began.elapsed() < MOST, "it took {:?}", began.elapsed());
            Ok(())
        });
        if let Err(TestError::Fail(why, (seed, edits))) = run {
            let text = edited(&seeds, seed, &edits);
            let kept = repository().join("tests/data/corpus").join(target).join(format!("found-{round}.txt"));
            if seconds.is_some() {
                fs::write(&kept, &text).expect("the corpus can be written");
            }
            panic!("{why}\n{} ({} bytes): {:.2000}", kept.display(), text.len(), text);
        }
        tried += 400;
        if began.elapsed().as_secs() >= seconds.unwrap_or(0) {
            break;
        }
    }
    if seconds.is_some() {
        println!("{target}: {tried} inputs in {:.0} s, none failed", began.elapsed().as_secs_f64());
    }
}

#[test]
fn case_files() {
    fuzz("case", "deceleration", |text| match Case::from_toml(text, "case.toml") {
        Ok(case) => {
            let written = case.to_toml();
            let again = Case::from_toml(&written, "written").expect("what is written can be read");
            assert_eq!(again.to_toml(), written);
        }
        Err(error) => {
            assert!(!error.mistakes.is_empty());
            let lines = text.split('\n').count();
            assert!(error.mistakes.iter().all(|mistake| mistake.line.is_none_or(|line| line <= lines)));
            assert!(error.to_string().len() < 100_000, "a message of {} bytes", error.to_string().len());
        }
    });
}

#[test]
fn plans_of_sweeps() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("fuzz_plans");
    fs::create_dir_all(&folder).unwrap();
    fs::write(folder.join("case.toml"), EXAMPLE).unwrap();
    fs::write(folder.join("base_case.toml"), EXAMPLE).unwrap();
    fs::write(folder.join("rows.csv"), "load.torque_Nm,load.preload_N\n1,600\n2,700\n").unwrap();
    let path = folder.join("plan.toml");
    fuzz("plan", "[axes]", |text| {
        fs::write(&path, text).unwrap();
        match Plan::read(&path) {
            Ok(plan) => {
                assert!(!plan.axes().is_empty() && plan.rows() > 0);
                drop(plan.record());
            }
            Err(error) => assert!(!error.to_string().is_empty()),
        }
    });
}

#[test]
fn tables_of_rows() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("fuzz_tables");
    fs::create_dir_all(&folder).unwrap();
    fs::write(folder.join("case.toml"), EXAMPLE).unwrap();
    fs::write(folder.join("plan.toml"), "case = \"case.toml\"\ntable = \"rows.csv\"\n").unwrap();
    fuzz("readings", "load.torque_Nm", |text| {
        fs::write(folder.join("rows.csv"), text).unwrap();
        if let Err(error) = Plan::read(&folder.join("plan.toml")) {
            assert!(!error.to_string().is_empty());
        }
    });
}

fn parameter(name: &str) -> OwnParameter {
    OwnParameter {
        name: name.into(),
        unit: String::new(),
        stated: String::new(),
        start: 0.5,
        min: None,
        max: None,
    }
}

#[test]
fn formulas() {
    let drive = cbpt_core::Drive::paper_base_case();
    let columns = || Columns {
        run: &[1, 1, 2],
        time_s: &[0.0, 1.0, 0.0],
        torque_Nm: &[-3.0, 0.0, 5.0],
        preload_N: Some(&[600.0, 600.0, 700.0]),
        input_angle_rad: &[0.0, 0.1, 3.0],
        temperature_K: None,
        cycle: None,
    };
    fuzz("formula", "", |text| {
        for adds_to in [AddsTo::Torque, AddsTo::Series] {
            match Formula::new("mine", adds_to, text, vec![parameter("a"), parameter("b")]) {
                Ok(formula) => {
                    assert_eq!(formula.text(), text);
                    let effects = vec![Effect::Own(Arc::new(formula))];
                    let rows = Rows::new(columns()).unwrap();
                    let mut predictor = Predictor::of(drive.clone(), effects, rows).unwrap();
                    let found = predictor.predict(&[0.5, 0.5], &[0, 1]).unwrap();
                    let solved = found.status.iter().map(cbpt_core::Status::has_solution);
                    assert!(found.angle_rad.iter().map(|angle| angle.is_finite()).eq(solved));
                }
                Err(wrong) => {
                    assert!(wrong.character >= 1 && wrong.character <= text.chars().count() + 1);
                    assert!(!wrong.problem.is_empty());
                }
            }
        }
    });
}

#[test]
fn names_of_units() {
    fuzz("unit", "", |text| {
        for quantity in Quantity::ALL {
            if let Some(unit) = quantity.unit(text) {
                assert_eq!((unit.symbol, unit.quantity), (text, quantity));
            }
        }
        // The same name as the ending of a key.
        let found = Case::from_toml(&format!("load.torque_{text} = 1\n"), "case.toml");
        assert!(found.is_err(), "a case without a drive");
        for unit in units::all() {
            for value in [0.0, -1.0, 1e300, 5e-324, f64::INFINITY, f64::NAN] {
                let back = unit.of_si(unit.to_si(value));
                assert!(
                    !value.is_finite()
                        || value.abs() >= 1e300
                        || (back - value).abs() <= 1e-9 * value.abs().max(1.0)
                );
            }
        }
    });
}
