//! `cbpt sweep CASE`: elastic angle over grids of torque, preload and input angle.

use std::path::Path;

use cbpt_core::cost::Cost;
use cbpt_core::predict::loads::{Effects, LoadOutcome, solve_loads};
use cbpt_core::sweep::solve_all;
use cbpt_core::{InvalidInput, Load};
use rayon::prelude::*;
use serde_json::{Value, json};

use super::{CaseEffects, Units, ball_drive, missing, sweep_plan};
use crate::args::{OutputOptions, Sweep};
use crate::case::Case;
use crate::exit::{Exit, Failure};
use crate::progress::with_progress_bar;
use crate::report::{Report, Table, number, object};
use crate::sweep::rows::{note_bare_columns, warn_unbuildable};

/// More rows than this are for a file, not for a screen.
const MOST_ROWS_ON_SCREEN: usize = 60;
/// Far beyond what a screen or a single file of this verb is for; keeps a slip in a step from eating all memory.
const MOST_ROWS: usize = 2_000_000;

/// Runs the verb.
pub fn run(verb: &Sweep) -> Result<Exit, Failure> {
    if sweep_plan::is_plan(&verb.path) {
        return sweep_plan::run(verb);
    }
    if verb.output.out.as_deref().is_some_and(is_parquet) {
        Case::read(&verb.path)?;
        return Err(Failure::Usage(for_parquet(&verb.path)));
    }
    verb.output.check(&verb.path)?;
    if verb.fresh || verb.chunk_rows.is_some() {
        let problem =
            format!("--fresh and --chunk-rows are for plans, and {} is a case", verb.path.display());
        return Err(Failure::Usage(problem));
    }
    let case = Case::read(&verb.path)?;
    let effects = CaseEffects::of(&case);
    let torques = axis(verb.torque_Nm.as_deref(), case.load.torque_Nm, "--torque-Nm", "torque_Nm")?;
    let preloads = match (verb.preload_N.as_deref(), case.load.preload_N) {
        (None, None) if case.drive().is_none() => vec![None],
        (flag, of_case) => {
            axis(flag, of_case, "--preload-N", "preload_N")?.into_iter().map(Some).collect::<Vec<_>>()
        }
    };
    let case_angle = case.load.input_angle_rad.unwrap_or(0.0).to_degrees();
    let angles =
        axis(verb.input_angle_deg.as_deref(), Some(case_angle), "--input-angle-deg", "input_angle_deg")?;
    let rows = torques.len().saturating_mul(preloads.len()).saturating_mul(angles.len());
    if rows > MOST_ROWS {
        return Err(Failure::Usage(format!(
            "the sweep has {rows} rows and may have at most {MOST_ROWS}; take larger steps"
        )));
    }
    let mut loads = Vec::with_capacity(rows);
    // The angle outermost, so that neighbours share their geometry.
    for angle in &angles {
        for preload in &preloads {
            for torque in &torques {
                let angle = angle.to_radians();
                loads.push(match preload {
                    Some(preload) => Load::new(*torque, *preload, angle)?,
                    None => Load::without_preload(*torque, angle)?,
                });
            }
        }
    }
    for text in warn_unbuildable(&case).into_iter().chain(note_bare_columns(&case, &verb.columns)) {
        eprintln!("cbpt: {text}");
    }
    let none = Effects { effects: &[], values: &[] };
    let solved = with_progress_bar(0, loads.len() as u64, |progress| match (&effects, case.drive()) {
        (None, Some(drive)) => Ok(solve_all(drive, &loads, progress)
            .map(|rows| rows.into_iter().map(LoadOutcome::of_mesh).collect())),
        (effects, _) => {
            let effects = effects.as_ref().map_or(none, CaseEffects::core);
            solve_loads(&case.reducer, effects, &loads, progress)
        }
    })?
    .ok_or_else(|| Failure::Usage("the sweep was cancelled".into()))?;
    let columns = Columns::of(&case, &verb.columns, &verb.path, &loads)?;
    let any = solved.iter().any(|outcome| outcome.status.has_solution());
    report(&loads, &solved, &columns, case.drive().is_some(), &verb.output).deliver(&verb.output)?;
    Ok(if any { Exit::Success } else { Exit::NoSolution })
}

/// Whether a file is to be Parquet by its name.
fn is_parquet(path: &Path) -> bool {
    path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("parquet"))
}

/// What to do instead, where the loads of a case are to go to Parquet.
fn for_parquet(case: &Path) -> String {
    let name = case.file_name().unwrap_or_default().to_string_lossy();
    let case = case.display();
    format!(
        "{case} is a case, whose rows go to --out FILE.csv or FILE.json. For Parquet, write a plan such as plan.toml beside \
         the case and sweep the plan:\n  case = \"{name}\"\n  [axes]\n  load.torque_Nm = {{ from = 0, to = 10, step = \
         0.5 }}\n  load.preload_N = [400, 600]"
    )
}

/// Further columns that were asked for by their names.
struct Columns {
    names: Vec<Cost>,
    /// Of each load.
    costs: Vec<Vec<f64>>,
}

impl Columns {
    /// Of the drive alone, without the effects of the case.
    fn of(case: &Case, names: &[Cost], path: &Path, loads: &[Load]) -> Result<Self, Failure> {
        if names.is_empty() {
            return Ok(Self { names: Vec::new(), costs: Vec::new() });
        }
        let drive = ball_drive(case, path, "these columns are")?;
        case.has_what_costs_need(names).map_err(|problem| Failure::Usage(format!("--columns: {problem}")))?;
        let rubbing = case.rubbing();
        let costs: Result<Vec<Vec<f64>>, InvalidInput> =
            loads.par_iter().map(|load| drive.costs(load, &rubbing, names)).collect();
        Ok(Self { names: names.to_vec(), costs: costs? })
    }
}

/// What a sweep has to say.
///
/// A torsion spring has no pairs, and where its loads have no preload none is shown.
fn report(
    loads: &[Load],
    solved: &[LoadOutcome],
    further: &Columns,
    pairs: bool,
    options: &OutputOptions,
) -> Report {
    let units = &Units::from(options);
    let suffix = units.angle.symbol;
    let heads = [
        format!("torque_{}", units.torque.symbol),
        format!("preload_{}", units.force.symbol),
        "input_angle_deg".to_owned(),
        format!("elastic_angle_{suffix}"),
        format!("alpha_deceleration_{suffix}"),
        format!("alpha_equal_speed_{suffix}"),
        "residual".to_owned(),
    ];
    let costs = further.names.iter().map(|cost| cost.name().to_owned());
    let mut table = Table::new(heads.into_iter().chain(costs).chain(["status".to_owned()]));
    for (row, (load, LoadOutcome { status, angle_rad, mesh: angles })) in loads.iter().zip(solved).enumerate()
    {
        let angle = |rad: Option<f64>| number(rad.map(|rad| rad * units.angle.per_si()));
        let mut cells = vec![
            json!(load.torque_Nm() * units.torque.per_si()),
            json!(load.preload_N() * units.force.per_si()),
            json!(load.input_angle_rad().to_degrees()),
            angle(Some(*angle_rad)),
            angle(angles.map(|a| a.deceleration_rad)),
            angle(angles.map(|a| a.equal_speed_rad)),
            number(angles.map(|a| a.residual)),
        ];
        cells.extend(further.costs.get(row).into_iter().flatten().map(|value| number(Some(*value))));
        cells.push(json!(status.name()));
        table.rows.push(cells);
    }
    if !pairs {
        let preload = loads.iter().any(|load| load.preload_N() > 0.0);
        let of_pairs = |column: &str| column.starts_with("alpha_") || column == "residual";
        table = table.narrowed(|column| !of_pairs(column) && (preload || !column.starts_with("preload_")));
    }
    let failed = solved.iter().filter(|outcome| !outcome.status.has_solution()).count();
    let mut shown = table.clone();
    shown.rows.truncate(MOST_ROWS_ON_SCREEN);
    let mut text = shown.text();
    if table.rows.len() > MOST_ROWS_ON_SCREEN {
        let all = match &options.out {
            Some(file) => format!("{} has all of them", file.display()),
            None => "--out FILE.csv writes all of them".to_owned(),
        };
        text += &format!("\n... {} rows in all; {all}", table.rows.len());
    }
    if failed > 0 {
        text += &format!("\n{failed} of {} loads have no solution; the status column says why", solved.len());
    }
    let columns = table.columns.iter().enumerate().map(|(index, column)| {
        (column.clone(), table.rows.iter().map(|row| row[index].clone()).collect::<Value>())
    });
    let json = object(columns);
    Report { text, json, table }
}

/// A list `1,2,5`, a range `start:stop:step`, or both mixed.
fn axis(flag: Option<&str>, default: Option<f64>, name: &str, key: &str) -> Result<Vec<f64>, Failure> {
    let Some(text) = flag else {
        return default.map(|value| vec![value]).ok_or_else(|| missing(name, key));
    };
    let wrong = |part: &str, why: &str| {
        Failure::Usage(format!(
            "{name} {text}: `{part}` {why}; give numbers `1,2,5` or a range `start:stop:step`"
        ))
    };
    let number = |part: &str| {
        part.trim()
            .parse::<f64>()
            .ok()
            .filter(|value| value.is_finite())
            .ok_or_else(|| wrong(part, "is not a number"))
    };
    let mut values = Vec::new();
    for part in text.split(',') {
        let bounds: Vec<&str> = part.split(':').collect();
        match bounds.as_slice() {
            [single] => values.push(number(single)?),
            [start, stop, step] => {
                let (start, stop, step) = (number(start)?, number(stop)?, number(step)?);
                let count = ((stop - start) / step + 1e-9).floor();
                if step == 0.0 || !(0.0..1e8).contains(&count) {
                    return Err(wrong(part, "is not a range: the step does not lead from start to stop"));
                }
                // Checked to lie between 0 and 1e8 just above.
                #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
                let count = count as u32;
                values.extend((0..=count).map(|i| start + f64::from(i) * step));
            }
            _ => return Err(wrong(part, "is neither a number nor a range")),
        }
    }
    Ok(values)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn read(text: &str) -> Result<Vec<f64>, String> {
        axis(Some(text), None, "--torque-Nm", "torque_Nm").map_err(|failure| failure.to_string())
    }

    #[test]
    fn lists_and_ranges() {
        assert_eq!(read("1,2.5,-3").unwrap(), [1.0, 2.5, -3.0]);
        assert_eq!(read("0:1:0.25").unwrap(), [0.0, 0.25, 0.5, 0.75, 1.0]);
        assert_eq!(read("0:0.3:0.1").unwrap().len(), 4);
        assert_eq!(read("2:0:-1,7").unwrap(), [2.0, 1.0, 0.0, 7.0]);
    }

    #[test]
    fn mistakes_name_the_part() {
        for (text, part) in [
            ("1,x", "`x`"),
            ("0:1", "`0:1`"),
            ("0:1:0", "`0:1:0`"),
            ("0:1:-1", "`0:1:-1`"),
            ("nan", "`nan`"),
            ("", "``"),
        ] {
            let message = read(text).unwrap_err();
            assert!(message.contains(part), "{message}");
        }
    }
}
