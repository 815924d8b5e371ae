//! `cbpt friction`: what preload and stiffness cost.
//!
//! [`Costs`] is all that is computed, over a period; [`answer`] what it has to say.

use std::f64::consts::TAU;

use cbpt_core::friction::period::{Backdriving, DriveOverPeriod, FrictionPeriod, PairOverPeriod};
use cbpt_core::strength::{
    Contacts, PreloadWindow, Strength, WorstContact, natural_frequency_Hz, unbalance_kg_m,
};
use cbpt_core::{Drive, InvalidInput, Load, Status};
use serde_json::{Value, json};

use super::{ball_drive, load, note_bare_drive};
use crate::args::Friction;
use crate::case::{self, Case, Operation};
use crate::exit::{Exit, Failure};
use crate::report::{Report, Table, number, object, six_digits};

/// Coefficients between which the friction torque is also told.
const SPREAD: [f64; 2] = [0.05, 0.15];

/// Runs the verb.
pub fn run(verb: &Friction) -> Result<Exit, Failure> {
    verb.output.check(&verb.case.path)?;
    verb.output.only_usual_units("friction")?;
    let case = Case::read(&verb.case.path)?;
    let drive = ball_drive(&case, &verb.case.path, "friction and wear are")?;
    let load = load(&case, &verb.load)?;
    let mut asked = Asked::of(&case);
    asked.friction.coefficient = verb.coefficient.unwrap_or(asked.friction.coefficient);
    asked.operation.static_safety = verb.static_safety.unwrap_or(asked.operation.static_safety);
    let costs = Costs::of(drive, &load, asked)?;
    let report = answer(&costs, &case);
    report.deliver(&verb.output)?;
    Ok(if costs.status.has_solution() { Exit::Success } else { Exit::NoSolution })
}

/// What a case says of friction and operation.
#[derive(Debug, Clone, Copy)]
pub struct Asked {
    /// The coefficient.
    pub friction: case::Friction,
    /// Speed, inertia, mass and safety.
    pub operation: Operation,
}

impl Asked {
    /// Of a case.
    pub fn of(case: &Case) -> Self {
        Self { friction: case.friction, operation: case.operation }
    }
}

/// All of it.
#[derive(Debug)]
pub struct Costs {
    /// How the load ended over the period.
    pub status: Status,
    load: Load,
    asked: Asked,
    transmission_ratio: f64,
    eccentricity_m: f64,
    loaded: Option<DriveOverPeriod>,
    unloaded: Option<DriveOverPeriod>,
    backdriving: Backdriving,
    strength: Strength,
    largest_torque_Nm: Option<f64>,
    window: PreloadWindow,
    stiffness_Nm_per_rad: Option<f64>,
}

impl Costs {
    /// Of a drive under a load; its angle counts for the stiffness alone.
    ///
    /// # Errors
    /// [`InvalidInput`] for a coefficient or a safety that cannot be.
    pub fn of(drive: &Drive, load: &Load, asked: Asked) -> Result<Self, InvalidInput> {
        let (mu, safety) = (asked.friction.coefficient, asked.operation.static_safety);
        if !(safety.is_finite() && safety > 0.0) {
            return Err(InvalidInput::new("static_safety", safety, "must be a finite number greater than 0"));
        }
        let (torque_Nm, preload_N) = (load.torque_Nm(), load.preload_N());
        let (period, contacts) = (FrictionPeriod::new(drive), Contacts::new(drive));
        let (status, loaded) = period.at(torque_Nm, preload_N, mu)?;
        Ok(Self {
            status,
            load: *load,
            asked,
            transmission_ratio: drive.transmission_ratio(),
            eccentricity_m: drive.deceleration().eccentricity_m(),
            loaded,
            unloaded: period.at(0.0, preload_N, mu)?.1,
            backdriving: period.backdriving(preload_N, mu)?,
            strength: contacts.strength(torque_Nm, preload_N),
            largest_torque_Nm: contacts.largest_torque_Nm(preload_N, safety),
            window: contacts.preload_window(torque_Nm, safety),
            stiffness_Nm_per_rad: drive.solve(load).torsional_stiffness_Nm_per_rad,
        })
    }

    /// Friction torque at the input with another coefficient, N m: it is proportional to it.
    fn with_coefficient(&self, coefficient: f64) -> Option<f64> {
        self.loaded.map(|found| coefficient * found.wear_Nm_per_turn() / TAU)
    }

    fn efficiency_of(&self, friction_Nm: f64) -> f64 {
        let useful = (self.load.torque_Nm() / self.transmission_ratio).abs();
        if useful > 0.0 { useful / (useful + friction_Nm) } else { 0.0 }
    }

    fn input_speed(&self) -> Option<f64> {
        self.asked.operation.input_speed_rad_per_s
    }

    fn heat_W(&self) -> Option<f64> {
        Some(self.loaded?.torque.mean_Nm * self.input_speed()?)
    }

    fn natural_frequency_Hz(&self) -> Option<f64> {
        let inertia = self.asked.operation.output_inertia_kg_m2?;
        Some(natural_frequency_Hz(self.stiffness_Nm_per_rad?, inertia))
    }

    fn unbalance_kg_m(&self) -> Option<f64> {
        self.asked.operation.planet_mass_kg.map(|mass| unbalance_kg_m(mass, self.eccentricity_m))
    }

    fn unbalance_force_N(&self) -> Option<f64> {
        Some(self.unbalance_kg_m()? * self.input_speed()?.powi(2))
    }

    fn backdriving_torque_Nm(&self) -> Option<f64> {
        match self.backdriving {
            Backdriving::From { torque_Nm } => Some(torque_Nm),
            Backdriving::Locks { .. } => None,
        }
    }
}

/// What is left out.
const NEGLECTED: [&str; 4] = [
    "slip and pivoting are added: an upper bound, at most about 1.3 times the integral over the contact ellipse",
    "the normal forces are those without friction",
    "lubricant, cage, seals and bearings",
    "cross-slide: the turn of the floating plate within its elastic shift, its inertia, and the places where the balls turn round",
];

/// The costs of a case, with what of it they leave out.
pub fn answer(costs: &Costs, case: &Case) -> Report {
    let mut report = report(costs);
    note_bare_drive(&mut report, case, "this is");
    if case.drive().is_some_and(|drive| drive.as_made().is_some()) {
        report.text +=
            "\nNote: this is of the parts as made, at angles spread over all turns after which they repeat.";
    }
    report
}

/// What the costs have to say.
fn report(costs: &Costs) -> Report {
    let table = table(costs);
    Report { text: text(costs, &table), json: document(costs), table }
}

const COLUMNS: [&str; 7] = [
    "pair",
    "friction_torque_Nm",
    "least_Nm",
    "largest_Nm",
    "no_load_Nm",
    "wear_Nm_per_turn",
    "track_wear_Nm_per_mm",
];

/// Largest wear for a length of track, N m for each mm.
fn track_wear(pair: &PairOverPeriod) -> f64 {
    pair.track_wear_N[0].max(pair.track_wear_N[1]) * 1e-3
}

fn table(costs: &Costs) -> Table {
    let mut table = Table::new(COLUMNS);
    let Some(loaded) = costs.loaded else { return table };
    let pairs = [
        ("deceleration", loaded.deceleration, costs.unloaded.map(|found| found.deceleration)),
        ("equal_speed", loaded.equal_speed, costs.unloaded.map(|found| found.equal_speed)),
    ];
    for (name, pair, unloaded) in pairs {
        let torque = pair.torque;
        table.rows.push(vec![
            json!(name),
            json!(torque.mean_Nm),
            json!(torque.least_Nm),
            json!(torque.largest_Nm),
            number(unloaded.map(|pair| pair.torque.mean_Nm)),
            json!(pair.wear_Nm_per_turn),
            json!(track_wear(&pair)),
        ]);
    }
    table.rows.push(vec![
        json!("drive"),
        json!(loaded.torque.mean_Nm),
        json!(loaded.torque.least_Nm),
        json!(loaded.torque.largest_Nm),
        number(costs.unloaded.map(|found| found.torque.mean_Nm)),
        json!(loaded.wear_Nm_per_turn()),
        json!(track_wear(&loaded.deceleration).max(track_wear(&loaded.equal_speed))),
    ]);
    table
}

fn text(costs: &Costs, table: &Table) -> String {
    let load = &costs.load;
    let mu = costs.asked.friction.coefficient;
    let mut lines = vec![format!(
        "Friction torque at the input over a period, at {} N m and {} N, friction coefficient {}",
        six_digits(load.torque_Nm()),
        six_digits(load.preload_N()),
        six_digits(mu)
    )];
    let Some(loaded) = costs.loaded else {
        lines.push(format!("Some angle of the period has {}", costs.status));
        return lines.join("\n");
    };
    lines.push(table.text());
    lines.push(format!(
        "efficiency {}: the input needs {} N m",
        six_digits(loaded.efficiency()),
        six_digits(loaded.input_torque_Nm())
    ));
    let spread = SPREAD.map(|mu| costs.with_coefficient(mu).unwrap_or(f64::NAN));
    lines.push(format!(
        "friction torque {} to {} N m (efficiency {} to {}) for a coefficient of {} to {}; standard uncertainty {} N m",
        six_digits(spread[0]),
        six_digits(spread[1]),
        six_digits(costs.efficiency_of(spread[0])),
        six_digits(costs.efficiency_of(spread[1])),
        SPREAD[0],
        SPREAD[1],
        six_digits(costs.with_coefficient(costs.asked.friction.coefficient_uncertainty).unwrap_or(f64::NAN)),
    ));
    lines.push(match costs.backdriving {
        Backdriving::From { torque_Nm } => {
            format!("driven from the output: {} N m turn a free input", six_digits(torque_Nm))
        }
        Backdriving::Locks { hold_torque_Nm } => format!(
            "driven from the output: locks up to {} N m, where the balls slip out",
            six_digits(hold_torque_Nm)
        ),
    });
    lines.extend(strength_lines(costs));
    lines.extend(motion_lines(costs));
    lines.push(format!("Not in it: {}.", NEGLECTED.join("; ")));
    lines.join("\n")
}

fn strength_lines(costs: &Costs) -> Vec<String> {
    let required = six_digits(costs.asked.operation.static_safety);
    let mut lines = vec![format!(
        "static safety {} over a period (peak pressure {} GPa in the deceleration pair, {} GPa in the equal-speed pair)",
        six_digits(costs.strength.static_safety),
        six_digits(costs.strength.deceleration.peak_pressure_Pa * 1e-9),
        six_digits(costs.strength.equal_speed.peak_pressure_Pa * 1e-9),
    )];
    for (name, worst) in
        [("deceleration", costs.strength.deceleration), ("equal-speed", costs.strength.equal_speed)]
    {
        if let Some(margin) = worst.edge_margin_m {
            lines.push(format!(
                "{name} pair: the contact ellipse ends {} um from the edge of the groove",
                six_digits(margin * 1e6)
            ));
        }
    }
    lines.push(match costs.largest_torque_Nm {
        Some(torque) => {
            format!(
                "largest torque with static safety {required} at this preload: {} N m",
                six_digits(torque)
            )
        }
        None => format!("this preload alone leaves less than static safety {required}"),
    });
    let window = &costs.window;
    lines.push(match (window.least_N, window.largest_N) {
        (Some(least), Some(largest)) => format!(
            "window of the preload: {} to {} N (hold {} N, continuous {} N, static safety {required})",
            six_digits(least),
            six_digits(largest),
            six_digits(window.hold_N),
            six_digits(window.continuous_N),
        ),
        _ => format!("window of the preload: none, no preload meets static safety {required} at this torque"),
    });
    lines
}

fn motion_lines(costs: &Costs) -> Vec<String> {
    let mut lines = Vec::new();
    if let Some(heat) = costs.heat_W() {
        lines.push(format!("heat {} W", six_digits(heat)));
    }
    if let Some(frequency) = costs.natural_frequency_Hz() {
        lines.push(format!("torsional natural frequency {} Hz", six_digits(frequency)));
    }
    if let Some(unbalance) = costs.unbalance_kg_m() {
        let force = costs.unbalance_force_N();
        let force =
            force.map_or(String::new(), |force| format!(", {} N at the input's speed", six_digits(force)));
        lines.push(format!("unbalance {} g mm{force}", six_digits(unbalance * 1e6)));
    }
    lines
}

fn pair_document(pair: &PairOverPeriod, unloaded: Option<PairOverPeriod>) -> Value {
    object([
        ("friction_torque_Nm".to_owned(), json!(pair.torque.mean_Nm)),
        ("least_Nm".to_owned(), json!(pair.torque.least_Nm)),
        ("largest_Nm".to_owned(), json!(pair.torque.largest_Nm)),
        ("ripple_Nm".to_owned(), json!(pair.torque.ripple_Nm())),
        ("no_load_Nm".to_owned(), number(unloaded.map(|pair| pair.torque.mean_Nm))),
        ("wear_Nm_per_turn".to_owned(), json!(pair.wear_Nm_per_turn)),
        ("track_wear_Nm_per_mm".to_owned(), json!(pair.track_wear_N.map(|wear| wear * 1e-3))),
    ])
}

fn drive_document(costs: &Costs, loaded: &DriveOverPeriod) -> Value {
    let spread = costs.asked.friction.coefficient_uncertainty;
    object([
        ("friction_torque_Nm".to_owned(), json!(loaded.torque.mean_Nm)),
        ("friction_torque_u_Nm".to_owned(), number(costs.with_coefficient(spread))),
        ("least_Nm".to_owned(), json!(loaded.torque.least_Nm)),
        ("largest_Nm".to_owned(), json!(loaded.torque.largest_Nm)),
        ("ripple_Nm".to_owned(), json!(loaded.torque.ripple_Nm())),
        ("no_load_Nm".to_owned(), number(costs.unloaded.map(|found| found.torque.mean_Nm))),
        ("wear_Nm_per_turn".to_owned(), json!(loaded.wear_Nm_per_turn())),
        ("efficiency".to_owned(), json!(loaded.efficiency())),
        ("input_torque_Nm".to_owned(), json!(loaded.input_torque_Nm())),
        ("period_deg".to_owned(), json!(loaded.period_rad.to_degrees())),
    ])
}

fn contact_document(worst: &WorstContact) -> Value {
    let finite = |value: f64| number(Some(value));
    object([
        ("peak_pressure_GPa".to_owned(), finite(worst.peak_pressure_Pa * 1e-9)),
        ("semi_axis_um".to_owned(), finite(worst.semi_axis_m * 1e6)),
        ("edge_margin_um".to_owned(), number(worst.edge_margin_m.map(|margin| margin * 1e6))),
    ])
}

fn document(costs: &Costs) -> Value {
    let spread = |mu: f64| {
        let friction = costs.with_coefficient(mu);
        object([
            ("coefficient".to_owned(), json!(mu)),
            ("friction_torque_Nm".to_owned(), number(friction)),
            ("efficiency".to_owned(), number(friction.map(|friction| costs.efficiency_of(friction)))),
        ])
    };
    let hold = match costs.backdriving {
        Backdriving::Locks { hold_torque_Nm } => Some(hold_torque_Nm),
        Backdriving::From { .. } => None,
    };
    let loaded = costs.loaded.as_ref();
    let of_pair = |pick: fn(&DriveOverPeriod) -> PairOverPeriod| {
        loaded.map_or(Value::Null, |found| pair_document(&pick(found), costs.unloaded.as_ref().map(pick)))
    };
    let window = &costs.window;
    object([
        ("status".to_owned(), json!(costs.status.name())),
        ("torque_Nm".to_owned(), json!(costs.load.torque_Nm())),
        ("preload_N".to_owned(), json!(costs.load.preload_N())),
        ("coefficient".to_owned(), json!(costs.asked.friction.coefficient)),
        ("coefficient_u".to_owned(), json!(costs.asked.friction.coefficient_uncertainty)),
        ("drive".to_owned(), loaded.map_or(Value::Null, |found| drive_document(costs, found))),
        ("deceleration".to_owned(), of_pair(|found| found.deceleration)),
        ("equal_speed".to_owned(), of_pair(|found| found.equal_speed)),
        ("spread".to_owned(), SPREAD.map(spread).into_iter().collect()),
        ("backdriving_torque_Nm".to_owned(), number(costs.backdriving_torque_Nm())),
        ("locks_up_to_Nm".to_owned(), number(hold)),
        ("heat_W".to_owned(), number(costs.heat_W())),
        ("static_safety".to_owned(), json!(costs.strength.static_safety)),
        ("required_static_safety".to_owned(), json!(costs.asked.operation.static_safety)),
        ("deceleration_contact".to_owned(), contact_document(&costs.strength.deceleration)),
        ("equal_speed_contact".to_owned(), contact_document(&costs.strength.equal_speed)),
        ("largest_torque_Nm".to_owned(), number(costs.largest_torque_Nm)),
        (
            "preload_window".to_owned(),
            object([
                ("hold_N".to_owned(), number(Some(window.hold_N))),
                ("continuous_N".to_owned(), number(Some(window.continuous_N))),
                ("least_N".to_owned(), number(window.least_N)),
                ("largest_N".to_owned(), number(window.largest_N)),
            ]),
        ),
        ("torsional_stiffness_Nm_per_rad".to_owned(), number(costs.stiffness_Nm_per_rad)),
        ("natural_frequency_Hz".to_owned(), number(costs.natural_frequency_Hz())),
        ("unbalance_kg_m".to_owned(), number(costs.unbalance_kg_m())),
        ("unbalance_force_N".to_owned(), number(costs.unbalance_force_N())),
        ("neglected".to_owned(), json!(NEGLECTED)),
    ])
}
