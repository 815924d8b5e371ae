//! `cbpt check`: design findings.

use cbpt_core::{Drive, Finding, Severity};
use serde_json::{Value, json};

use super::{ball_drive, load, note_bare_drive};
use crate::args::UnderLoad;
use crate::case::Case;
use crate::exit::{Exit, Failure};
use crate::report::{Report, Table, six_digits};

/// Runs the verb.
pub fn run(verb: &UnderLoad) -> Result<Exit, Failure> {
    verb.output.check(&verb.case.path)?;
    let case = Case::read(&verb.case.path)?;
    let drive = ball_drive(&case, &verb.case.path, "findings are")?;
    // A load is checked where one is meant: given whole in the case, or begun on the command line.
    let begun = verb.load.torque_Nm.is_some() || verb.load.preload_N.is_some();
    let whole = case.load.torque_Nm.is_some() && case.load.preload_N.is_some();
    let load = if begun || whole { Some(load(&case, &verb.load)?) } else { None };
    let findings = drive.findings(load.as_ref());
    let mut report = report(drive, &findings, load.is_some());
    note_bare_drive(&mut report, &case, "these are findings");
    report.deliver(&verb.output)?;
    let failed = findings.iter().any(|finding| finding.severity == Severity::Error);
    Ok(if failed { Exit::DesignError } else { Exit::Success })
}

/// What the findings have to say.
pub fn report(drive: &Drive, findings: &[Finding], with_load: bool) -> Report {
    let pair = drive.deceleration();
    let mut text = format!(
        "Transmission ratio {}; eccentricity {} mm (crank {} mm); circle of {} deceleration balls of radius {} mm\n",
        six_digits(drive.transmission_ratio()),
        six_digits(pair.eccentricity_m() * 1e3),
        six_digits(2.0 * pair.eccentricity_m() * 1e3),
        pair.ball_count,
        six_digits(pair.pitch_radius_m() * 1e3),
    );
    if findings.is_empty() {
        text.push_str("No findings: walls, spacing and conformity are sound");
        text.push_str(if with_load { ", pressure too." } else { ". Give a load to check pressure as well." });
    }
    let mut table = Table::new(["severity", "code", "pair", "message", "remedy"]);
    for finding in findings {
        let severity = finding.severity.name();
        text += &finding_text(finding);
        text.push('\n');
        table.rows.push(
            [severity, finding.code, finding.pair, &finding.message, &finding.remedy]
                .map(|cell| json!(cell))
                .to_vec(),
        );
    }
    let json = json!({
        "transmission_ratio": drive.transmission_ratio(),
        "checked_under_load": with_load,
        "findings": findings.iter().map(finding_document).collect::<Value>(),
    });
    Report { text, json, table }
}

/// A finding as text.
pub fn finding_text(finding: &Finding) -> String {
    format!(
        "{} ({}): {}.\n  Remedy: {}.",
        finding.severity.name(),
        finding.pair,
        finding.message,
        finding.remedy
    )
}

/// A finding as JSON.
pub fn finding_document(finding: &Finding) -> Value {
    json!({
        "code": finding.code,
        "severity": finding.severity.name(),
        "pair": finding.pair,
        "message": finding.message,
        "remedy": finding.remedy,
    })
}
