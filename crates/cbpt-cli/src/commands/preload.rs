//! `cbpt preload`: the three preloads that a torque needs.

use cbpt_core::{DriveThresholds, PreloadThresholds};
use serde_json::{Value, json};

use super::check::{finding_document, finding_text};
use super::{Units, ball_drive, note_bare_drive, torque_Nm};
use crate::args::Preload;
use crate::case::Case;
use crate::exit::{Exit, Failure};
use crate::report::{Report, Table, number, object, six_digits};

/// Runs the verb.
pub fn run(verb: &Preload) -> Result<Exit, Failure> {
    verb.output.check(&verb.case.path)?;
    let case = Case::read(&verb.case.path)?;
    let drive = ball_drive(&case, &verb.case.path, "preload thresholds are")?;
    let torque = torque_Nm(&case, verb.torque_Nm)?;
    // A torque that cannot be is refused with the same words as everywhere.
    cbpt_core::Load::new(torque, 1.0, verb.input_angle_deg.unwrap_or(0.0))?;
    let thresholds = match verb.input_angle_deg {
        Some(angle) => drive.preload_thresholds_at(torque, angle.to_radians()),
        None => drive.preload_thresholds(torque),
    };
    let mut report = report(&thresholds, torque, verb.input_angle_deg, &Units::from(&verb.output));
    let findings = drive.findings(None);
    for finding in &findings {
        report.text.push('\n');
        report.text += &finding_text(finding);
    }
    if let Value::Object(entries) = &mut report.json {
        entries.insert("findings".to_owned(), findings.iter().map(finding_document).collect());
    }
    note_bare_drive(&mut report, &case, "these are thresholds");
    report.deliver(&verb.output)?;
    Ok(if thresholds.drive().hold_N.is_finite() { Exit::Success } else { Exit::NoSolution })
}

/// What the thresholds have to say.
pub fn report(
    thresholds: &DriveThresholds,
    torque_Nm: f64,
    input_angle_deg: Option<f64>,
    units: &Units,
) -> Report {
    let drive = thresholds.drive();
    let named = [
        ("deceleration", thresholds.deceleration),
        ("equal_speed", thresholds.equal_speed),
        ("drive", drive),
    ];
    let suffix = units.force.symbol;
    let mut table = Table::new([
        "pair".to_owned(),
        format!("hold_{suffix}"),
        format!("continuous_{suffix}"),
        format!("zero_backlash_{suffix}"),
    ]);
    for (name, of_pair) in &named {
        let values = [of_pair.hold_N, of_pair.continuous_N, of_pair.zero_backlash_N];
        let mut row = vec![json!(name)];
        row.extend(values.map(|value| number(Some(value * units.force.per_si()))));
        table.rows.push(row);
    }
    let place = match input_angle_deg {
        Some(angle) => format!("at an input angle of {} deg", six_digits(angle)),
        None => "as maxima over a period".to_owned(),
    };
    let text = format!(
        "Preload needed for {} N m, {place}\n{}\nhold: below this preload the balls slip out.  continuous: below it balls come loose \
         (the paper's minimum APF).\nzero_backlash: above it every meshing point stays in contact.  The drive needs the larger value of its two pairs.",
        six_digits(torque_Nm),
        table.text()
    );
    let mut entries: Vec<(String, Value)> = vec![
        ("torque_Nm".to_owned(), json!(torque_Nm)),
        ("input_angle_deg".to_owned(), number(input_angle_deg)),
    ];
    entries.extend(named.iter().map(|(name, of_pair)| ((*name).to_owned(), document(of_pair, units))));
    Report { text, json: object(entries), table }
}

fn document(of_pair: &PreloadThresholds, units: &Units) -> Value {
    let suffix = units.force.symbol;
    let force = |value: f64| number(Some(value * units.force.per_si()));
    object([
        (format!("hold_{suffix}"), force(of_pair.hold_N)),
        (format!("continuous_{suffix}"), force(of_pair.continuous_N)),
        (format!("zero_backlash_{suffix}"), force(of_pair.zero_backlash_N)),
    ])
}
