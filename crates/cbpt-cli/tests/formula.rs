//! Formulas of own effects: equal to the library's where they say the same, exact slopes, and nothing but an error for what
//! is no formula.
#![allow(clippy::unwrap_used, clippy::panic)]

use std::sync::Arc;

use cbpt_cli::case::Case;
use cbpt_cli::commands::schema::EXAMPLE;
use cbpt_cli::formula::Formula;
use cbpt_core::effect::{self, AddsTo, OwnParameter};
use cbpt_core::predict::{Columns, Effect, Prediction, Predictor, Rows};
use proptest::prelude::*;

/// An id of the library, a formula that says the same, and its parameters.
type Like = (&'static str, &'static str, AddsTo, &'static [(&'static str, f64)]);

fn parameter(name: &str, start: f64) -> OwnParameter {
    OwnParameter {
        name: name.into(),
        unit: String::new(),
        stated: String::new(),
        start,
        min: None,
        max: None,
    }
}

fn own(adds_to: AddsTo, text: &str, parameters: &[(&str, f64)]) -> Effect {
    let parameters = parameters.iter().map(|(name, start)| parameter(name, *start)).collect();
    Effect::Own(Arc::new(Formula::new("mine", adds_to, text, parameters).unwrap()))
}

fn library(id: &str) -> Effect {
    Effect::Library(effect::find(id).unwrap())
}

/// Two runs up and down at two preloads, with times and temperatures.
fn rows() -> Rows {
    let torque = [0.0, 2.0, 4.0, 4.0, 1.0, -3.0, 0.0, -2.0, -4.0, 1.0, 3.0, 3.0];
    let run = [1, 1, 1, 1, 1, 1, 2, 2, 2, 2, 2, 2];
    let time: Vec<f64> = (0..12).map(|i| 7.0 * f64::from(i)).collect();
    let preload: Vec<f64> = run.iter().map(|run| if *run == 1 { 500.0 } else { 800.0 }).collect();
    let angle: Vec<f64> = run.iter().map(|run| if *run == 1 { 0.2 } else { 2.2 }).collect();
    let temperature: Vec<f64> = (0..12).map(|i| 20.0 + 0.3 * f64::from(i)).collect();
    Rows::new(Columns {
        run: &run,
        time_s: &time,
        torque_Nm: &torque,
        preload_N: Some(&preload),
        input_angle_rad: &angle,
        temperature_K: Some(&temperature),
        cycle: None,
    })
    .unwrap()
}

fn predicted(effects: Vec<Effect>, values: &[f64], wanted: &[usize]) -> Prediction {
    let reducer = Case::from_toml(EXAMPLE, "example").unwrap().reducer;
    Predictor::of(reducer, effects, rows()).unwrap().predict(values, wanted).unwrap()
}

fn assert_same(one: &[f64], other: &[f64], relative: f64, what: &str) {
    let size = one.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
    for (a, b) in one.iter().zip(other) {
        assert!((a - b).abs() <= relative * size, "{what}: {a} is not {b}");
    }
}

/// Beside friction, so that the term is part of the rotation that friction counts, and beside a sensor's gain.
#[test]
fn a_formula_is_the_effect_of_the_library_that_it_says() {
    let creep = "a * torque_Nm * log(1 + run_time_s / tau)";
    let bearing = "u * (abs(torque_Nm) / pitch_arm_m / 100)^q * sign(torque_Nm) / pitch_arm_m";
    let cases: [Like; 6] = [
        ("creep", creep, AddsTo::Series, &[("a", 2e-6), ("tau", 20.0)]),
        ("output_torsion", "c * torque_Nm", AddsTo::Series, &[("c", 3e-6)]),
        ("eccentric_bearing", bearing, AddsTo::Series, &[("u", 2e-6), ("q", 0.8)]),
        ("thermal_preload", "c * temperature_difference_K", AddsTo::Preload, &[("c", -20.0)]),
        ("preload_loss", "-eta * preload_N", AddsTo::Preload, &[("eta", 0.2)]),
        (
            "sensor_nonlinearity",
            "q * alpha_rad^2 + c * alpha_rad^3",
            AddsTo::Reading,
            &[("q", 100.0), ("c", -1e6)],
        ),
    ];
    for (id, text, adds_to, parameters) in cases {
        let mut values = vec![1e-3, 4e-5, 0.0, 0.0, 1.0];
        values.extend(parameters.iter().map(|(_, start)| *start));
        let wanted: Vec<usize> = (0..values.len()).collect();
        let with =
            |effect, values: &[f64]| predicted(vec![library("friction_hysteresis"), effect], values, &wanted);
        let mine = with(own(adds_to, text, parameters), &values);
        // The library's effect may have further numbers, for forms that the formula has not.
        let further = effect::find(id).unwrap().parameters[parameters.len()..].iter();
        let neutral: Vec<f64> = further.map(|parameter| parameter.neutral).collect();
        let theirs = with(library(id), &[values.clone(), neutral].concat());
        assert_same(&theirs.angle_rad, &mine.angle_rad, 1e-12, id);
        for column in wanted {
            let of = |found: &Prediction| -> Vec<f64> {
                found.sensitivities.iter().skip(column).step_by(values.len()).copied().collect()
            };
            assert_same(&of(&theirs), &of(&mine), 1e-10, &format!("{id}, slope {column}"));
        }
    }
}

/// Two own effects after each other at every port, where the first changes what the second sees.
#[test]
fn slopes_are_exact_along_the_whole_chain() {
    let effects = || {
        vec![
            library("torque_scale"),
            library("friction_hysteresis"),
            own(AddsTo::Torque, "a * torque_Nm^3", &[("a", 1e-3)]),
            own(AddsTo::Preload, "b * torque_Nm * exp(-input_angle_rad)", &[("b", 5.0)]),
            own(
                AddsTo::Series,
                "c * tanh(torque_Nm / d) + e * direction",
                &[("c", 1e-5), ("d", 2.0), ("e", 1e-6)],
            ),
            own(AddsTo::Series, "f * alpha_rad / max(1, preload_N / 600)", &[("f", 0.05)]),
            own(AddsTo::Reading, "g * sqrt(abs(alpha_rad)) * cos(time_s / h)", &[("g", 1e-4), ("h", 30.0)]),
        ]
    };
    let values = [1.1, 1e-3, 4e-5, 0.05, 0.01, 0.8, 1e-3, 5.0, 1e-5, 2.0, 1e-6, 0.05, 1e-4, 30.0];
    let wanted: Vec<usize> = (0..values.len()).collect();
    let found = predicted(effects(), &values, &wanted);
    for (place, value) in values.iter().enumerate() {
        let at = |share: f64| {
            let mut moved = values;
            moved[place] = value * (1.0 + share);
            predicted(effects(), &moved, &[]).angle_rad
        };
        let (h, above, below) = (1e-5, at(1e-5), at(-1e-5));
        let difference: Vec<f64> =
            above.iter().zip(&below).map(|(above, below)| (above - below) / (2.0 * h * value)).collect();
        let slopes: Vec<f64> =
            found.sensitivities.iter().skip(place).step_by(values.len()).copied().collect();
        // Row 0 of each run is unloaded: the root of its angle has no slope there.
        let rows: Vec<usize> = (0..slopes.len()).filter(|row| slopes[*row].is_finite()).collect();
        assert!(rows.len() >= 10, "{place}: {slopes:?}");
        let pick = |all: &[f64]| -> Vec<f64> { rows.iter().map(|row| all[*row]).collect() };
        assert_same(&pick(&slopes), &pick(&difference), 2e-5, &format!("parameter {place}"));
    }
}

#[test]
fn contributions_add_up_and_name_own_effects() {
    let reducer = Case::from_toml(EXAMPLE, "example").unwrap().reducer;
    let effects = vec![own(AddsTo::Series, "c * torque_Nm", &[("c", 3e-6)]), library("creep")];
    let mut predictor = Predictor::of(reducer, effects, rows()).unwrap();
    let values = [3e-6, 1e-6, 20.0, 0.0, 0.0, 0.3];
    let parts = predictor.contributions(&values).unwrap();
    let names: Vec<&str> = parts.iter().map(|part| &*part.name).collect();
    assert_eq!(names, ["model", "creep", "mine"]);
    let total = predictor.predict(&values, &[]).unwrap().angle_rad;
    for (row, total) in total.iter().enumerate() {
        let sum: f64 = parts.iter().map(|part| part.angle_rad[row]).sum();
        assert!((sum - total).abs() < 1e-15);
    }
    let torque = [0.0, 2.0, 4.0];
    for (row, torque) in torque.iter().enumerate() {
        assert!((parts[2].angle_rad[row] - 3e-6 * torque).abs() < 1e-15);
    }
}

#[test]
fn what_is_not_finite_is_a_status_of_its_row_alone() {
    for adds_to in [AddsTo::Series, AddsTo::Reading, AddsTo::Torque, AddsTo::Preload] {
        let found = predicted(vec![own(adds_to, "1e-9 * log(torque_Nm - 3.5)", &[])], &[], &[]);
        let good: Vec<usize> = (0..12).filter(|row| found.angle_rad[*row].is_finite()).collect();
        assert_eq!(good, [2, 3], "{adds_to:?}");
        for (row, status) in found.status.iter().enumerate() {
            let expected = if good.contains(&row) { "ok" } else { "effect_not_finite" };
            assert_eq!(status.name(), expected, "{adds_to:?}, row {row}");
        }
    }
}

/// What a formula without variables is worth.
fn number(text: &str) -> f64 {
    let with = |text: &str| {
        let found = predicted(vec![own(AddsTo::Reading, text, &[])], &[], &[]);
        found.angle_rad[0]
    };
    with(text) - with("0")
}

#[test]
fn arithmetic_is_read_as_it_is_written() {
    for (text, value) in [
        ("-2^2", -4.0),
        ("2^3^2", 512.0),
        ("2**-1", 0.5),
        ("-(-2)^2", -4.0),
        ("8 / 4 / 2", 1.0),
        ("1 - 2 - 3", -4.0),
        ("2 * -3 + 1", -5.0),
        ("--2", 2.0),
        ("min(3, max(1, 2)) * sign(-7)", -2.0),
        (".5e1 + 1.e0", 6.0),
        ("exp(-(1)^2) * exp(1)", 1.0),
        ("cos(pi) + tan(atan(2)) + log(exp(3)) + sqrt(9) + tanh(0) + sin(0) + abs(-1)", 8.0),
    ] {
        assert!((number(text) - value).abs() < 1e-9, "{text} is {}", number(text));
    }
}

fn mistake(expression: &str) -> String {
    // A text of JSON is one of TOML, control characters escaped.
    let quoted = serde_json::Value::from(expression).to_string();
    let entry = format!(
        "\n[[effect]]\nid = \"mine\"\nport = \"series\"\nexpression = {quoted}\nparameters = {{ a = {{ unit = \"\", start = 1 }} }}\n"
    );
    Case::from_toml(&format!("{EXAMPLE}{entry}"), "case.toml").unwrap_err().to_string()
}

#[test]
fn a_mistake_names_file_line_key_and_place() {
    let line = EXAMPLE.lines().count() + 5;
    for (expression, told) in [
        ("a * torqe_Nm", "character 5: no parameter or variable is named torqe_Nm; did you mean torque_Nm?"),
        ("a * sine(1)", "character 5: no function is named sine"),
        (
            "a * (torque_Nm",
            "character 15: found the end, expected +, -, *, /, ^, a comma or a closing bracket",
        ),
        ("a * torque_Nm)", "character 14: found `)`, expected +, -, *, /, ^ or the end"),
        ("a * ", "character 5: found the end, expected a number, a name or an opening bracket"),
        ("", "character 1: found the end, expected a number"),
        ("2 a", "character 3: found `a`, expected"),
        ("sin", "character 1: the function sin needs brackets"),
        ("max(1)", "character 1: max takes 2 arguments, not 1"),
        ("1e999", "character 1: 1e999 is no finite number"),
        ("a = 1", "character 3: found `=`"),
        ("1/0*a", "character 2: makes a constant that is not finite (inf)"),
        ("a + log(-1)", "character 5: makes a constant that is not finite (NaN)"),
        ("min(a, -1/0)", "character 10: makes a constant that is not finite"),
        ("9^9^9^9", "makes a constant that is not finite"),
    ] {
        let message = mistake(expression);
        assert!(message.starts_with(&format!("case.toml:{line}: effect[0].expression = ")), "{message}");
        assert!(message.contains(told), "{message}");
        assert_eq!(message.lines().count(), 1, "{message}");
    }
}

#[test]
fn a_hostile_expression_does_nothing_but_give_an_error() {
    let long = "1+".repeat(100_000) + "1";
    let deep = "(".repeat(50_000) + "1" + &")".repeat(50_000);
    let calls = "sin(".repeat(40) + "1" + &")".repeat(40);
    let hostile = [
        long.as_str(),
        &deep,
        &calls,
        "__import__('os').system('true')",
        "import os",
        "a; a",
        "a\u{0}",
        "\u{ff11} + a",
        "a \u{2212} 1",
        "lambda: 1",
        "a if a else a",
        "open(1)",
        "a.real",
        "a[0]",
        "{a}",
        "NaN",
        "inf",
        "while(1)",
        "$(true)",
        "`true`",
        "\u{202e}a",
    ];
    for expression in hostile {
        let message = mistake(expression);
        assert!(message.starts_with("case.toml:") && message.contains("effect[0].expression"), "{message}");
        assert!(message.len() < 1000, "{} characters", message.len());
    }
    // Long, but allowed: it is computed, and what overflows is a status.
    for expression in ["9^9^torque_Nm^9", &("-".repeat(900) + "1"), &("2^".repeat(400) + "torque_Nm")] {
        let found = predicted(vec![own(AddsTo::Series, expression, &[])], &[], &[]);
        assert_eq!(found.angle_rad.len(), 12);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    /// Whatever is written, the reader answers; where it takes it, each row has a finite angle or a status.
    #[test]
    fn no_text_panics(text in "[-+*/^(),.0-9a-z_ ]{0,40}|\\PC{0,40}") {
        if let Ok(formula) = Formula::new("mine", AddsTo::Series, text, vec![parameter("a", 1.0)]) {
            let found = predicted(vec![Effect::Own(Arc::new(formula))], &[1.0], &[0]);
            for (angle, status) in found.angle_rad.iter().zip(&found.status) {
                prop_assert_eq!(angle.is_finite(), status.has_solution());
            }
        }
    }
}

/// What is told of a formula whose parameters have these units; empty where it is taken.
fn told_of_units(adds_to: AddsTo, text: &str, units: &[(&str, &str)]) -> String {
    let parameter =
        |(name, unit): &(&str, &str)| OwnParameter { unit: (*unit).into(), ..parameter(name, 1.0) };
    let found = Formula::new("mine", adds_to, text, units.iter().map(parameter).collect());
    found.map_or_else(|wrong| format!("{}: {}", wrong.character, wrong.problem), |_| String::new())
}

#[test]
fn a_unit_that_does_not_fit_is_refused_with_the_one_that_does() {
    for (adds_to, text, units, told) in [
        (
            AddsTo::Series,
            "a * torque_Nm",
            &[("a", "N/um")] as &[_],
            "1: a is in N/um, so a * torque_Nm is in N^2; a series term is an angle: give a in arcsec/(N m)",
        ),
        (
            AddsTo::Series,
            "a * torque_Nm * log(1 + run_time_s / tau)",
            &[("a", "rad/(N m)"), ("tau", "arcsec")],
            "25: tau is in arcsec, so run_time_s / tau is in s/rad; the argument of log is a plain number or an angle: \
             give tau in s",
        ),
        (
            AddsTo::Series,
            "a * (abs(torque_Nm) - t)",
            &[("a", "rad/(N m)"), ("t", "arcsec")],
            "23: t is in arcsec; it stands beside abs(torque_Nm), which is in N m: give t in N m",
        ),
        (
            AddsTo::Series,
            "a * (t + abs(torque_Nm))",
            &[("a", "rad/(N m)"), ("t", "arcsec")],
            "6: t is in arcsec; it stands beside abs(torque_Nm), which is in N m: give t in N m",
        ),
        (
            AddsTo::Series,
            "a * direction + b * torque_Nm^2",
            &[("a", "arcsec"), ("b", "rad/(N m)")],
            "17: b is in rad/(N m), so b * torque_Nm^2 is in rad N m; a series term is an angle: give b in rad/(N m)^2",
        ),
        (
            AddsTo::Reading,
            "-(sin(input_angle_rad) * max(b, 0))",
            &[("b", "1/arcsec")],
            "2: b is in 1/arcsec, so (sin(input_angle_rad) * max(b, 0)) is in 1/arcsec; a reading term is an angle: \
             give b in arcsec",
        ),
        (
            AddsTo::Torque,
            "preload_N * r",
            &[("r", "1")],
            "1: r is in 1, so preload_N * r is in N; a term of torque_Nm is a torque: give r in um",
        ),
        (
            AddsTo::Preload,
            "torque_Nm / sqrt(r)",
            &[("r", "um")],
            "1: r is in um, so torque_Nm / sqrt(r) is in m^0.5 N; a term of preload_N is a force: give r in m^2",
        ),
        (
            AddsTo::Series,
            "a * torque_Nm ^ n",
            &[("a", "rad/(N m)"), ("n", "N m")],
            "17: n is in N m; an exponent is a plain number: give n as a plain number",
        ),
    ] {
        assert_eq!(told_of_units(adds_to, text, units), told);
    }
}

/// What is free or cannot be decided is not refused: numbers, parameters without a unit, powers with a free exponent.
#[test]
fn a_formula_whose_units_fit_or_cannot_be_decided_is_taken() {
    let series: [(&str, &[(&str, &str)]); 16] = [
        ("a * torque_Nm", &[("a", "")]),
        ("a * torque_Nm", &[("a", "arcsec/(lbf in)")]),
        ("a / b * torque_Nm", &[("a", "mrad"), ("b", "kN m")]),
        ("torque_Nm / k", &[("k", "N m/arcmin")]),
        ("1e-6 * torque_Nm + log(torque_Nm - 10)", &[]),
        ("a * tanh(torque_Nm / 5)", &[("a", "arcsec")]),
        ("a * tanh(torque_Nm / b)", &[("a", "arcsec"), ("b", "")]),
        ("u * (abs(torque_Nm) / pitch_arm_m)^q / pitch_arm_m", &[("u", "m/N^0.8"), ("q", "")]),
        ("a * abs(torque_Nm)^(1/3) * sign(torque_Nm)", &[("a", "rad/(N m)^0.333333333333")]),
        ("a * sign(torque_Nm) * max(abs(torque_Nm) - t, 0)", &[("a", "rad/(N m)"), ("t", "N m")]),
        ("a * exp(k * (cos(input_angle_rad - c) - 1))", &[("a", "rad"), ("k", ""), ("c", "deg")]),
        ("a * sin(z * input_angle_rad + phi)", &[("a", "arcsec"), ("z", "1"), ("phi", "rad")]),
        ("a * cycles_done + d * temperature_difference_K", &[("a", "arcsec/cycle"), ("d", "arcsec/K")]),
        ("q * alpha_rad^2 + (g - 1) * alpha_rad", &[("q", "1/arcsec"), ("g", "")]),
        ("w * preload_N / (c * pitch_arm_m)", &[("w", "um/m"), ("c", "N/um")]),
        ("a * torque_Nm^0 * sqrt(preload_N / f)^3", &[("a", "rad"), ("f", "kN")]),
    ];
    for (text, units) in series {
        assert_eq!(told_of_units(AddsTo::Series, text, units), "", "{text}");
    }
    for (adds_to, text, units) in [
        (AddsTo::Preload, "c * temperature_difference_K", &[("c", "N/K")] as &[_]),
        (AddsTo::Preload, "-e * preload_N", &[("e", "1")]),
        (AddsTo::Torque, "k * sin(input_angle_rad) * preload_N", &[("k", "um")]),
    ] {
        assert_eq!(told_of_units(adds_to, text, units), "", "{text}");
    }
}

/// The angle follows from the load.
#[test]
fn the_load_does_not_know_the_angle() {
    for adds_to in [AddsTo::Torque, AddsTo::Preload] {
        let wrong = Formula::new("mine", adds_to, "1 + alpha_rad", Vec::new()).unwrap_err();
        assert_eq!(wrong.character, 5);
        assert!(wrong.problem.contains("port load"), "{}", wrong.problem);
    }
    assert!(Formula::new("mine", AddsTo::Series, "alpha_rad", Vec::new()).is_ok());
}
