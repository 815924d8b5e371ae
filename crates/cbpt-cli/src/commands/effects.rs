//! `cbpt effects`: the library of effects.

use cbpt_core::effect::{LIBRARY, Parameter, Scale, Spec, find};
use serde_json::{Value, json};

use crate::args::Effects;
use crate::case::nearest_effect;
use crate::exit::{Exit, Failure};
use crate::report::{Report, Table, number, print, six_digits};

/// Runs the verb.
pub fn run(verb: &Effects) -> Result<Exit, Failure> {
    if verb.page {
        print(&page())?;
        return Ok(Exit::Success);
    }
    let Some(id) = &verb.id else {
        let text = format!("{}\n{FURTHER}\n", overview().text());
        return deliver(verb, &Report { text, json: library(), table: Table::default() });
    };
    let Some(spec) = find(id) else {
        let near = nearest_effect(id).map(|near| format!("did you mean {near}? ")).unwrap_or_default();
        let ids: Vec<&str> = LIBRARY.into_iter().map(|spec| spec.id).collect();
        return Err(Failure::Usage(format!(
            "no effect has the id {id}; {near}the ids are {}",
            ids.join(", ")
        )));
    };
    let text = format!("{}\n{}", head(spec, "\n"), parameters(spec).text());
    deliver(verb, &Report { text, json: document(spec), table: Table::default() })
}

fn deliver(verb: &Effects, report: &Report) -> Result<Exit, Failure> {
    report.print(verb.json)?;
    Ok(Exit::Success)
}

/// What the overview leaves out, and its words.
const FURTHER: &str = "parameter: a number of the drive; rig: an error of the instruments; effect: physics of the reducer\n\
                       cbpt effects ID prints the equation, source and numbers of one, with their ranges";

fn overview() -> Table {
    let mut table = Table::new(["id", "class", "how readings show it"]);
    for spec in LIBRARY {
        let cells = [spec.id, spec.class.name(), spec.tell_tale];
        table.rows.push(cells.map(|cell| json!(cell)).to_vec());
    }
    table
}

/// What an effect is, line by line.
fn head(spec: &Spec, end: &str) -> String {
    let mut lines = vec![
        format!("{}: class {}, port {}", spec.id, spec.class.name(), spec.port.name()),
        format!("Equation: {}", spec.equation),
        format!("Tell-tale: {}", spec.tell_tale),
        format!("Source: {}", spec.source),
    ];
    match (spec.suits_ball_drives(), spec.suits_springs(false), spec.suits_springs(true)) {
        (true, true, _) => lines.push("For ball drives and torsion springs".to_owned()),
        (true, false, true) => {
            lines.push("For ball drives, and for torsion springs that have a reference_radius".to_owned());
        }
        (true, ..) => lines.push("For ball drives only".to_owned()),
        (false, ..) => lines.push("For torsion springs only".to_owned()),
    }
    lines.extend(twins(spec));
    lines.join(end)
}

/// What no torque-angle data tell it from; a twin may be one only without some of its numbers.
fn twins(spec: &Spec) -> Option<String> {
    let without = |spec: &Spec| {
        let twinless = spec.parameters.iter().filter(|parameter| parameter.twinless);
        let names: Vec<String> = twinless.map(Parameter::display_name).collect();
        (!names.is_empty()).then(|| format!("without {}", names.join(", ")))
    };
    let twin = |id: &&str| match cbpt_core::effect::find(id).and_then(without) {
        Some(without) => format!("{id} ({without})"),
        None => (*id).to_owned(),
    };
    let twins: Vec<String> = spec.twins.iter().map(twin).collect();
    let told = format!("o torque-angle data tell it from {}", twins.join(", "));
    (!twins.is_empty()).then(|| match without(spec) {
        Some(without) => format!("{}, n{told}", sentence(&without)),
        None => format!("N{told}"),
    })
}

fn parameters(spec: &Spec) -> Table {
    let mut table = Table::new(["number", "meaning", "default", "likely", "allowed"]);
    for parameter in spec.parameters {
        let shown = |value: f64| {
            if value.is_finite() { six_digits(in_display(parameter, value)) } else { "any".into() }
        };
        let default = if parameter.is_size {
            format!("{} (no effect)", shown(parameter.neutral))
        } else {
            shown(parameter.neutral)
        };
        let range = |(low, high): (f64, f64)| format!("{} to {}", shown(low), shown(high));
        let cells = [
            parameter.display_name(),
            parameter.meaning.to_owned(),
            default,
            range(parameter.range),
            range((parameter.lower, parameter.upper)),
        ];
        table.rows.push(cells.map(|cell| json!(cell)).to_vec());
    }
    table
}

fn in_display(parameter: &Parameter, value: f64) -> f64 {
    value / parameter.display().size()
}

fn library() -> Value {
    json!({ "effects": LIBRARY.into_iter().map(document).collect::<Value>() })
}

fn document(spec: &Spec) -> Value {
    json!({
        "id": spec.id,
        "class": spec.class.name(),
        "port": spec.port.name(),
        "equation": spec.equation,
        "tell_tale": spec.tell_tale,
        "source": spec.source,
        "twins": spec.twins,
        "parameters": spec.parameters.iter().map(parameter_document).collect::<Value>(),
    })
}

/// Numbers in SI, with the unit that people read beside it.
fn parameter_document(parameter: &Parameter) -> Value {
    json!({
        "name": parameter.name(),
        "display_name": parameter.display_name(),
        "display_size": parameter.display().size(),
        "meaning": parameter.meaning,
        "neutral": parameter.neutral,
        "lower": number(Some(parameter.lower)),
        "upper": number(Some(parameter.upper)),
        "range": [number(Some(parameter.range.0)), number(Some(parameter.range.1))],
        "scale": match parameter.scale {
            Scale::Linear => "linear",
            Scale::Log => "log",
            Scale::Fixed => "fixed",
        },
        "is_size": parameter.is_size,
        "twinless": parameter.twinless,
    })
}

/// The library as a page in Markdown.
fn page() -> String {
    let mut page = String::from("| id | class | port | tell-tale |\n|---|---|---|---|\n");
    for spec in LIBRARY {
        page += &format!(
            "| [`{}`](#{}) | {} | {} | {} |\n",
            spec.id,
            spec.id,
            spec.class.name(),
            spec.port.name(),
            spec.tell_tale
        );
    }
    for spec in LIBRARY {
        page += &format!("\n## {}\n\n    {}\n\n", spec.id, spec.equation);
        page += &format!(
            "{}, port {}. Tell-tale: {}. ",
            sentence(spec.class.name()),
            spec.port.name(),
            spec.tell_tale
        );
        page += &twins(spec).map_or(String::new(), |sentence| format!("{sentence}. "));
        page += &format!("Source: {}.\n\n", spec.source);
        let table = parameters(spec);
        page += &format!("| {} |\n|{}\n", table.columns.join(" | "), "---|".repeat(table.columns.len()));
        for row in &table.rows {
            let cells: Vec<&str> = row.iter().filter_map(Value::as_str).collect();
            page += &format!("| `{}` | {} |\n", cells[0], cells[1..].join(" | "));
        }
    }
    page
}

fn sentence(word: &str) -> String {
    let mut letters = word.chars();
    letters.next().map(|first| first.to_uppercase().chain(letters).collect()).unwrap_or_default()
}
