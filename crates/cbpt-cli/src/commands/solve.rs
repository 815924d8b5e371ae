//! `cbpt solve`: elastic angle under one load, with every meshing point.

use cbpt_core::equilibrium::report::PairSolution;
use cbpt_core::extremes::LargestAngle;
use cbpt_core::hertz::LoadedContact;
use cbpt_core::pair::Diagonal;
use cbpt_core::predict::Contribution;
use cbpt_core::predict::loads::{Effects, LoadDetail, solve_load};
use cbpt_core::{Angles, Finding, Load, Reducer, Solution, Status};
use serde_json::{Value, json};

use super::check::finding_text;
use super::{CaseEffects, Units, ball_drive, cost, enclosure, load, note_bare_drive, note_nominal_parts};
use crate::args::Solve;
use crate::bars;
use crate::case::Case;
use crate::exit::{Exit, Failure};
use crate::report::{Report, Table, escaped, number, object, six_digits};

/// Runs the verb.
pub fn run(verb: &Solve) -> Result<Exit, Failure> {
    verb.output.check(&verb.case.path)?;
    let case = Case::read(&verb.case.path)?;
    let effects = CaseEffects::of(&case);
    let load = load(&case, &verb.load)?;
    let detail = effects.map(|effects| solve_load(&case.reducer, effects.core(), &load)).transpose()?;
    let solution = match &detail {
        Some(detail) => detail.solution.clone(),
        None => solved(&case.reducer, &load)?,
    };
    let units = Units::from(&verb.output);
    let mut report = report(&case.reducer, &solution, detail.as_ref(), &units);
    let mut of_drive_alone = vec!["findings"];
    if verb.points {
        ball_drive(&case, &verb.case.path, "meshing points are")?;
    }
    if verb.over_period {
        let drive = ball_drive(&case, &verb.case.path, "the largest angle over a period is")?;
        let (status, largest) = drive.largest_elastic_angle(load.torque_Nm(), load.preload_N())?;
        add_period(&mut report, status, largest.as_ref(), &units);
        note_nominal_parts(&mut report, &case, "the largest angle over a period is");
        of_drive_alone.push("the largest angle over a period");
    }
    if verb.friction {
        let drive = ball_drive(&case, &verb.case.path, "friction is")?;
        cost::add(&mut report, drive, &load, &case.rubbing())?;
        of_drive_alone.push("friction and safety");
    }
    let proved = !verb.certify || certify(&mut report, &case, verb, &solution, detail.as_ref())?;
    if verb.points && solution.status.has_solution() {
        let ellipses = match &verb.output.out {
            Some(file) => format!("{} has the contact ellipses too", file.display()),
            None => "--out FILE.csv adds the contact ellipses".to_owned(),
        };
        report.text += &format!(
            "\n\nMeshing points (one row for each diagonal: the two points at its ends carry the same force; {ellipses})\n"
        );
        report.text.push_str(&report.table.narrowed(|column| !column.starts_with("wall")).text());
    }
    if case.drive().is_some() {
        note_bare_drive(&mut report, &case, &format!("{} are", of_drive_alone.join(" and ")));
    }
    report.deliver(&verb.output)?;
    Ok(if solution.status.has_solution() && proved { Exit::Success } else { Exit::NoSolution })
}

/// Adds the proof; whether there is one.
fn certify(
    report: &mut Report,
    case: &Case,
    verb: &Solve,
    solution: &Solution,
    detail: Option<&LoadDetail>,
) -> Result<bool, Failure> {
    let drive = ball_drive(case, &verb.case.path, "a proof is")?;
    let found = match detail {
        Some(detail) => detail.points.as_ref().and_then(|points| {
            let [torque_Nm, preload_N] = detail.mesh_load;
            points.enclosure(torque_Nm, preload_N)
        }),
        None => drive.enclosure(&solution.load),
    };
    let solved = solution.status.has_solution();
    enclosure::add(report, found.as_ref(), verb.output.angle_unit, solved, detail.is_some());
    Ok(found.is_some())
}

/// A reducer without effects under a load.
///
/// # Errors
/// [`InvalidInput`](cbpt_core::InvalidInput) for a ball drive without a preload.
pub fn solved(reducer: &Reducer, load: &Load) -> Result<Solution, cbpt_core::InvalidInput> {
    match reducer.ball_drive().filter(|_| load.preload_N() > 0.0) {
        Some(drive) => Ok(drive.solve(load)),
        None => Ok(solve_load(reducer, Effects { effects: &[], values: &[] }, load)?.solution),
    }
}

/// What a solution has to say; `detail` is that of a case with effects.
pub fn report(reducer: &Reducer, solution: &Solution, detail: Option<&LoadDetail>, units: &Units) -> Report {
    let findings = reducer.ball_drive().map(|drive| drive.findings(Some(&solution.load))).unwrap_or_default();
    Report {
        text: text(reducer, solution, detail, &findings, units),
        json: document(reducer, solution, detail, &findings, units),
        table: points_table(solution, units),
    }
}

fn add_period(report: &mut Report, status: Status, largest: Option<&LargestAngle>, units: &Units) {
    let (suffix, per_si) = (units.angle.symbol, units.angle.per_si());
    report.text += &match largest {
        Some(l) => format!(
            "\n\nLargest elastic angle over a period: {} {suffix} at an input angle of {} deg (ripple {} {suffix} \
             peak to peak; the drive repeats after {} deg)",
            six_digits(l.elastic_angle_rad * per_si),
            six_digits(l.input_angle_rad.to_degrees()),
            six_digits(l.amplitude_rad * per_si),
            six_digits(l.period_rad.to_degrees()),
        ),
        None => format!("\n\nLargest elastic angle over a period: {status} somewhere in the period"),
    };
    let document = object([
        ("status".to_owned(), json!(status.name())),
        (format!("largest_elastic_angle_{suffix}"), number(largest.map(|l| l.elastic_angle_rad * per_si))),
        ("input_angle_deg".to_owned(), number(largest.map(|l| l.input_angle_rad.to_degrees()))),
        (format!("amplitude_{suffix}"), number(largest.map(|l| l.amplitude_rad * per_si))),
        ("period_deg".to_owned(), number(largest.map(|l| l.period_rad.to_degrees()))),
    ]);
    if let Value::Object(entries) = &mut report.json {
        entries.insert("over_period".to_owned(), document);
    }
}

fn pairs(solution: &Solution) -> impl Iterator<Item = (&'static str, &PairSolution)> {
    let named = [("deceleration", &solution.deceleration), ("equal_speed", &solution.equal_speed)];
    named.into_iter().filter_map(|(name, pair)| pair.as_ref().map(|pair| (name, pair)))
}

/// The summary, as `print(solution)` and `cbpt solve` show it.
pub fn text(
    reducer: &Reducer,
    solution: &Solution,
    detail: Option<&LoadDetail>,
    findings: &[Finding],
    units: &Units,
) -> String {
    let load = &solution.load;
    let force = |value: f64| format!("{} {}", six_digits(value * units.force.per_si()), units.force.written);
    let preload = match load.preload_N() {
        0.0 => String::new(),
        preload_N => format!(", preload {}", force(preload_N)),
    };
    let of = match reducer {
        Reducer::BallDrive(drive) => format!("transmission ratio {}", six_digits(drive.transmission_ratio())),
        Reducer::TorsionSpring(_) => "a reducer as a torsion spring".to_owned(),
    };
    let mut lines = vec![format!(
        "Load: {} {}{preload}, input angle {} deg; {of}",
        six_digits(load.torque_Nm() * units.torque.per_si()),
        units.torque.written,
        six_digits(load.input_angle_rad().to_degrees()),
    )];
    match &solution.angles {
        Some(angles) => lines.extend(answer_lines(reducer, solution, angles, detail, units)),
        None => lines.push(format!("Status: {}", solution.status)),
    }
    // A finding about the load itself is what the status line says already.
    lines.extend(findings.iter().filter(|finding| finding.pair != "drive").map(finding_text));
    lines.join("\n")
}

/// The summary for a notebook: its lines, the table of the pairs, and how their meshing points share the force.
pub fn html(reducer: &Reducer, solution: &Solution, findings: &[Finding], units: &Units) -> String {
    let text = text(reducer, solution, None, findings, units);
    let framed = |line: &&str| line.is_empty() || line.starts_with(['┌', '│', '╞', '└']);
    let lines: Vec<String> = text.lines().filter(|line| !framed(line)).map(escaped).collect();
    let table = pair_table(solution, units);
    let table = if table.columns.len() > 1 { table.html() } else { String::new() };
    let shares = |(name, pair): (&str, &PairSolution)| {
        let name = format!("{}: normal forces", name.replace('_', "-"));
        (name, pair.points.iter().map(|point| point.force_N * units.force.per_si()).collect())
    };
    let picture = bars::svg(&pairs(solution).map(shares).collect::<Vec<_>>(), units.force.written);
    format!("<p>{}</p>{table}{picture}", lines.join("<br>"))
}

/// Angles, stiffness, status and contributions of a load that has a solution.
fn answer_lines(
    reducer: &Reducer,
    solution: &Solution,
    angles: &Angles,
    detail: Option<&LoadDetail>,
    units: &Units,
) -> Vec<String> {
    let pairs = reducer.ball_drive().is_some();
    let mut lines = Vec::new();
    let angle = |rad: f64| format!("{} {}", six_digits(rad * units.angle.per_si()), units.angle.symbol);
    let shown = detail.and_then(|detail| detail.angle_rad);
    lines.push(match shown {
        Some(shown) => {
            format!("Elastic angle: {} as the instrument shows it, with effects", angle(shown))
        }
        None => format!("Elastic angle: {}", angle(angles.elastic_angle_rad())),
    });
    if pairs {
        lines.push(format!(
            "  deceleration pair {}, equal-speed pair {} (the part that reaches the output)",
            angle(angles.deceleration_rad),
            angle(angles.equal_speed_rad)
        ));
    }
    if let Some(detail) = detail.filter(|_| !pairs) {
        let torque = six_digits(detail.mesh_load[0] * units.torque.per_si());
        lines.push(format!("  carried by the spring: {torque} {}", units.torque.written));
    }
    if let Some(detail) = detail.filter(|_| pairs) {
        let [torque_Nm, preload_N] = detail.mesh_load;
        lines.push(format!(
            "  at the meshing points: torque {} {}, preload {} {}",
            six_digits(torque_Nm * units.torque.per_si()),
            units.torque.written,
            six_digits(preload_N * units.force.per_si()),
            units.force.written,
        ));
    }
    if let Some(stiffness) = solution.torsional_stiffness_Nm_per_rad {
        let (_, value) = stiffness_unit(units, stiffness);
        let unit = format!("{}/{}", units.torque.written, units.angle.symbol);
        let of = match detail {
            Some(_) if pairs => " of the meshing points",
            Some(_) => " of the spring",
            None => "",
        };
        lines.push(format!("Torsional stiffness{of} at this load: {} {unit}", six_digits(value)));
    }
    if pairs {
        lines.push(format!("Status: {} (scaled residual {:.1e})", solution.status, angles.residual));
        lines.push(String::new());
        lines.push(pair_table(solution, units).text());
    } else {
        lines.push(format!("Status: {}", solution.status));
    }
    lines.extend(detail.map(|detail| contribution_table(detail, units).text()));
    lines
}

fn stiffness_unit(units: &Units, stiffness_Nm_per_rad: f64) -> (String, f64) {
    let unit = format!("{}_per_{}", units.torque.symbol, units.angle.symbol);
    (unit, stiffness_Nm_per_rad * units.torque.per_si() / units.angle.per_si())
}

/// Quantities down, pairs across: it fits a terminal.
fn pair_table(solution: &Solution, units: &Units) -> Table {
    type Quantity = (String, fn(&PairSolution, &Units) -> Value);
    let [angle, length, force, torque] = [units.angle, units.length, units.force, units.torque];
    let quantities: [Quantity; 9] = [
        (format!("angle ({})", angle.symbol), |p, u| json!(p.rotation_rad * u.angle.per_si())),
        (format!("torque carried ({})", torque.written), |p, u| json!(p.torque_Nm * u.torque.per_si())),
        (format!("axial approach ({})", length.symbol), |p, u| json!(p.approach_m * u.length.per_si())),
        (format!("torsional stiffness ({}/{})", torque.written, angle.symbol), |p, u| {
            json!(stiffness_unit(u, p.torsional_stiffness_Nm_per_rad).1)
        }),
        (format!("in-plane force along line of centres ({})", force.symbol), |p, u| {
            json!(p.in_plane_force_N[0] * u.force.per_si())
        }),
        (format!("in-plane force across it ({})", force.symbol), |p, u| {
            json!(p.in_plane_force_N[1] * u.force.per_si())
        }),
        (format!("tilt couple ({})", torque.written), |p, u| json!(p.tilt_couple_Nm * u.torque.per_si())),
        (format!("peak pressure ({})", units.pressure.symbol), |p, u| {
            json!(p.peak_pressure_Pa * u.pressure.per_si())
        }),
        ("meshing points that carry".to_owned(), |p, _| {
            json!(format!("{} of {}", 2 * p.carrying, 2 * p.points.len()))
        }),
    ];
    let mut table = Table::new(std::iter::once("").chain(pairs(solution).map(|(name, _)| name)));
    for (label, value) in quantities {
        let cells = pairs(solution).map(|(_, pair)| value(pair, units));
        table.rows.push(std::iter::once(json!(label)).chain(cells).collect());
    }
    table
}

/// What each effect adds, in the order of the ports.
fn contribution_table(detail: &LoadDetail, units: &Units) -> Table {
    let mut table = Table::new(["contribution".to_owned(), format!("angle ({})", units.angle.symbol)]);
    for part in &detail.contributions {
        table.rows.push(vec![json!(part.name), number(Some(part.angle_rad[0] * units.angle.per_si()))]);
    }
    table
}

/// The JSON object: angles null where there is no solution.
pub fn document(
    reducer: &Reducer,
    solution: &Solution,
    detail: Option<&LoadDetail>,
    findings: &[Finding],
    units: &Units,
) -> Value {
    let load = &solution.load;
    let angle = |rad: Option<f64>| number(rad.map(|rad| rad * units.angle.per_si()));
    let suffix = units.angle.symbol;
    let (stiffness_suffix, _) = stiffness_unit(units, 0.0);
    let of_pairs_angles = solution.angles.filter(|_| reducer.ball_drive().is_some());
    let of_pairs = object(pairs(solution).map(|(name, pair)| (name.to_owned(), pair_document(pair, units))));
    let shown = detail.map_or_else(|| solution.elastic_angle_rad(), |detail| detail.angle_rad);
    let mut document = object([
        ("status".to_owned(), json!(solution.status.name())),
        ("message".to_owned(), json!(solution.status.to_string())),
        (format!("elastic_angle_{suffix}"), angle(shown)),
        (format!("alpha_deceleration_{suffix}"), angle(of_pairs_angles.map(|a| a.deceleration_rad))),
        (format!("alpha_equal_speed_{suffix}"), angle(of_pairs_angles.map(|a| a.equal_speed_rad))),
        ("residual".to_owned(), number(solution.angles.map(|a| a.residual))),
        (
            "hold_preload_N".to_owned(),
            match solution.status {
                cbpt_core::Status::BeyondHold { hold_preload_N } => number(Some(hold_preload_N)),
                _ => Value::Null,
            },
        ),
        (
            format!("torsional_stiffness_{stiffness_suffix}"),
            number(solution.torsional_stiffness_Nm_per_rad.map(|k| stiffness_unit(units, k).1)),
        ),
        (
            "load".to_owned(),
            json!({
                "torque_Nm": load.torque_Nm(),
                "preload_N": number(Some(load.preload_N()).filter(|preload| *preload > 0.0)),
                "input_angle_deg": load.input_angle_rad().to_degrees(),
            }),
        ),
        (
            "transmission_ratio".to_owned(),
            number(reducer.ball_drive().map(cbpt_core::Drive::transmission_ratio)),
        ),
        ("pairs".to_owned(), of_pairs),
        ("findings".to_owned(), findings.iter().map(super::check::finding_document).collect()),
    ]);
    if let (Value::Object(entries), Some(detail)) = (&mut document, detail) {
        let part = |part: &Contribution| (part.name.clone(), angle(Some(part.angle_rad[0])));
        entries.insert(format!("contributions_{suffix}"), object(detail.contributions.iter().map(part)));
        let [torque_Nm, preload_N] = detail.mesh_load.map(|value| number(Some(value)));
        let at_mesh = [("torque_Nm".to_owned(), torque_Nm), ("preload_N".to_owned(), preload_N)];
        entries.insert("load_at_meshing_points".to_owned(), object(at_mesh));
    }
    document
}

fn pair_document(pair: &PairSolution, units: &Units) -> Value {
    let (stiffness_suffix, stiffness) = stiffness_unit(units, pair.torsional_stiffness_Nm_per_rad);
    let force = |value: f64| json!(value * units.force.per_si());
    object([
        (format!("angle_{}", units.angle.symbol), json!(pair.rotation_rad * units.angle.per_si())),
        (format!("torque_{}", units.torque.symbol), json!(pair.torque_Nm * units.torque.per_si())),
        (format!("approach_{}", units.length.symbol), json!(pair.approach_m * units.length.per_si())),
        (format!("sideways_{}", units.length.symbol), json!(pair.sideways_m * units.length.per_si())),
        (format!("torsional_stiffness_{stiffness_suffix}"), json!(stiffness)),
        (format!("in_plane_force_along_{}", units.force.symbol), force(pair.in_plane_force_N[0])),
        (format!("in_plane_force_across_{}", units.force.symbol), force(pair.in_plane_force_N[1])),
        (format!("tilt_couple_{}", units.torque.symbol), json!(pair.tilt_couple_Nm * units.torque.per_si())),
        ("carrying".to_owned(), json!(pair.carrying)),
        (
            format!("peak_pressure_{}", units.pressure.symbol),
            json!(pair.peak_pressure_Pa * units.pressure.per_si()),
        ),
        ("residual".to_owned(), json!(pair.residual)),
        ("steps".to_owned(), json!(pair.steps)),
        ("points".to_owned(), pair.points.iter().map(|point| point_document(point, units)).collect()),
    ])
}

fn diagonal_name(diagonal: Diagonal) -> &'static str {
    match diagonal {
        Diagonal::Plus => "plus",
        Diagonal::Minus => "minus",
    }
}

fn point_document(point: &cbpt_core::equilibrium::report::LoadedPoint, units: &Units) -> Value {
    let wall = |contact: &Option<LoadedContact>| match contact {
        None => Value::Null,
        Some(contact) => object([
            (format!("approach_{}", units.length.symbol), json!(contact.approach_m * units.length.per_si())),
            (
                format!("major_semi_axis_{}", units.length.symbol),
                json!(contact.major_semi_axis_m * units.length.per_si()),
            ),
            (
                format!("minor_semi_axis_{}", units.length.symbol),
                json!(contact.minor_semi_axis_m * units.length.per_si()),
            ),
            (
                format!("peak_pressure_{}", units.pressure.symbol),
                json!(contact.peak_pressure_Pa * units.pressure.per_si()),
            ),
        ]),
    };
    object([
        ("ball".to_owned(), json!(point.ball)),
        ("diagonal".to_owned(), json!(diagonal_name(point.diagonal))),
        ("role".to_owned(), json!(point.role.name())),
        ("contact".to_owned(), json!(point.contact.name())),
        (format!("deformation_{}", units.length.symbol), json!(point.deformation_m * units.length.per_si())),
        (format!("gap_{}", units.length.symbol), json!(point.gap_m * units.length.per_si())),
        (format!("force_{}", units.force.symbol), json!(point.force_N * units.force.per_si())),
        ("walls".to_owned(), point.walls.iter().map(wall).collect()),
    ])
}

/// One row a diagonal; the wall columns come twice, first the driving plate's wall.
fn points_table(solution: &Solution, units: &Units) -> Table {
    let (length, pressure) = (units.length, units.pressure);
    let mut columns: Vec<String> =
        ["pair", "ball", "diagonal", "role", "contact"].map(str::to_owned).to_vec();
    columns.push(format!("deformation_{}", length.symbol));
    columns.push(format!("gap_{}", length.symbol));
    columns.push(format!("force_{}", units.force.symbol));
    for wall in 1..=2 {
        columns.push(format!("wall{wall}_approach_{}", length.symbol));
        columns.push(format!("wall{wall}_major_semi_axis_{}", length.symbol));
        columns.push(format!("wall{wall}_minor_semi_axis_{}", length.symbol));
        columns.push(format!("wall{wall}_peak_pressure_{}", pressure.symbol));
    }
    let mut table = Table::new(columns);
    for (name, pair) in pairs(solution) {
        for point in &pair.points {
            let mut row = vec![
                json!(name),
                json!(point.ball),
                json!(diagonal_name(point.diagonal)),
                json!(point.role.name()),
                json!(point.contact.name()),
                json!(point.deformation_m * length.per_si()),
                json!(point.gap_m * length.per_si()),
                json!(point.force_N * units.force.per_si()),
            ];
            for wall in &point.walls {
                row.push(number(wall.map(|w| w.approach_m * length.per_si())));
                row.push(number(wall.map(|w| w.major_semi_axis_m * length.per_si())));
                row.push(number(wall.map(|w| w.minor_semi_axis_m * length.per_si())));
                row.push(number(wall.map(|w| w.peak_pressure_Pa * pressure.per_si())));
            }
            table.rows.push(row);
        }
    }
    table
}
