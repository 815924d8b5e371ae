//! `cbpt sweep PLAN`: any parameter of drive, load or effects, to a file that survives a kill.

use std::path::Path;

use crate::args::Sweep;
use crate::exit::{Exit, Failure};
use crate::progress::with_progress_bar;
use crate::report::print;
use crate::sweep::output::CsvOutput;
use crate::sweep::{CHUNK_ROWS, Plan, read, stream};

/// Whether a file is a plan; one that cannot be read is left to the reader of cases to tell.
pub fn is_plan(path: &Path) -> bool {
    std::fs::read_to_string(path).is_ok_and(|text| read::is_plan(&text))
}

/// Runs the verb.
pub fn run(verb: &Sweep) -> Result<Exit, Failure> {
    let flags = [
        (verb.torque_Nm.is_some(), "--torque-Nm", "load.torque_Nm"),
        (verb.preload_N.is_some(), "--preload-N", "load.preload_N"),
        (verb.input_angle_deg.is_some(), "--input-angle-deg", "load.input_angle_deg"),
    ];
    if let Some((_, flag, axis)) = flags.iter().find(|(given, _, _)| *given) {
        return Err(Failure::Usage(format!("{flag} is for cases; in a plan, write the axis {axis} instead")));
    }
    if !verb.columns.is_empty() {
        let instead = "--columns is for cases; in a plan, write columns = [...] instead";
        return Err(Failure::Usage(instead.into()));
    }
    if verb.output.json {
        return Err(Failure::Usage("--json is for cases; the rows of a plan go to --out FILE.csv".into()));
    }
    verb.output.only_usual_units("a plan, whose columns are arcsec and what its axes say")?;
    let path = output_path(verb)?;
    let plan = Plan::read(&verb.path)?;
    let mut output = CsvOutput::open(&plan, path, verb.fresh)?;
    let found = output.done();
    if output.is_complete() {
        let text = format!("{}: the file has all {} rows already", path.display(), plan.rows());
        return print(&text).map(|()| Exit::Success);
    }
    for text in plan.remarks() {
        eprintln!("cbpt: {text}");
    }
    let tally = with_progress_bar(found, plan.rows(), |progress| {
        stream::to_csv(&plan, &mut output, verb.chunk_rows.unwrap_or(CHUNK_ROWS), progress)
    })?;
    let earlier = if found > 0 { format!(", {found} of them from an earlier sweep") } else { String::new() };
    print(&format!(
        "{}: {} rows{earlier}; the status column says which rows have no solution",
        path.display(),
        plan.rows()
    ))?;
    if let Some(text) = tally.text() {
        eprintln!("cbpt: {text}");
    }
    Ok(Exit::Success)
}

/// Where the rows go.
fn output_path(verb: &Sweep) -> Result<&Path, Failure> {
    let Some(path) = verb.output.out.as_deref() else {
        return Err(Failure::Usage(
            "--out is missing: the rows of a plan go to a file, for example --out result.csv".into(),
        ));
    };
    match path.extension().and_then(|ending| ending.to_str()).map(str::to_ascii_lowercase).as_deref() {
        Some("csv") => Ok(path),
        Some("parquet") => Err(Failure::Usage(format!(
            "--out {}: Parquet is written by the Python package: pip install \"cbpt[io]\"; this program writes .csv",
            path.display()
        ))),
        _ => Err(Failure::Usage(format!("--out {}: the name must end in .csv or .parquet", path.display()))),
    }
}
