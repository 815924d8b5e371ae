//! The tree of verbs and flags. Every flag carries its unit.

use std::path::PathBuf;

use cbpt_core::cost::Cost;
use cbpt_core::units::{Quantity, Unit};
use clap::builder::{PossibleValuesParser, TypedValueParser};
use clap::{Args, Parser, Subcommand};

/// Reads a unit of a quantity by its symbol.
fn unit_of(quantity: Quantity) -> impl TypedValueParser<Value = &'static Unit> {
    let symbols = quantity.units().iter().map(|unit| unit.symbol);
    PossibleValuesParser::new(symbols)
        .map(move |symbol| quantity.unit(&symbol).unwrap_or_else(|| quantity.usual()))
}

/// Reads a cost by its name.
fn cost() -> impl TypedValueParser<Value = Cost> {
    PossibleValuesParser::new(Cost::ALL.map(Cost::name))
        .map(|name| Cost::find(&name).unwrap_or(Cost::FrictionTorque))
}

/// Elastic angle of a cycloid ball planetary transmission.
#[derive(Debug, Parser)]
#[command(
    name = "cbpt",
    version,
    propagate_version = true,
    after_help = "A CASE is a TOML file that describes the drive; `cbpt schema --example` prints an example to start from.\n\
                  Exit codes: 0 done, 1 cannot write, 2 bad input, 3 no solution, 4 design error."
)]
pub struct Cli {
    /// What to do.
    #[command(subcommand)]
    pub verb: Verb,
}

const SWEEP_OUT: &str = "Write to FILE. For a CASE: .csv or .json, in addition to the screen. For a PLAN: .csv, or .parquet with the \
                         Python package; a PLAN needs this flag";

/// The verbs.
#[derive(Debug, Subcommand)]
pub enum Verb {
    /// Elastic angle under one load, with every meshing point
    Solve(Solve),
    /// Preload that a torque needs: to hold it, for continuous transmission, for zero backlash
    Preload(Preload),
    /// What preload and stiffness cost: friction torque, efficiency, wear, static safety, the window of the preload
    Friction(Friction),
    /// Elastic angle over a grid of loads (CASE) or over any parameters (PLAN), on all cores
    #[command(mut_arg("out", |out| out.help(SWEEP_OUT)))]
    Sweep(Sweep),
    /// Derivatives of elastic angle and preload thresholds with respect to every design parameter
    Sensitivity(Sensitivity),
    /// Design findings: undercut, missing walls, touching balls, pressure
    Check(UnderLoad),
    /// The library of effects: equations, how they show in readings, parameters with their ranges
    Effects(Effects),
    /// JSON Schema of case files for editors, the table of keys, or an example
    Schema(Schema),
    /// Compare the model with a table of readings: bias, RMSE, where it fails (Python package)
    #[command(disable_help_flag = true)]
    Compare(Elsewhere),
    /// What a table of readings holds and what it cannot tell, before any model (Python package)
    #[command(disable_help_flag = true)]
    Preflight(Elsewhere),
    /// Figures of catalogues: lost motion, hysteresis loss, backlash, rigidity (Python package)
    #[command(disable_help_flag = true)]
    Characterise(Elsewhere),
    /// Find the effect that the readings need, or say that none is needed or that they cannot decide (Python package)
    #[command(disable_help_flag = true)]
    Diagnose(Elsewhere),
    /// What changed between two campaigns on the same reducer, or from level to level (Python package)
    #[command(disable_help_flag = true)]
    Change(Elsewhere),
    /// Fit effects to readings and write the case with them (Python package)
    #[command(disable_help_flag = true)]
    Fit(Elsewhere),
    /// Effects that a planned campaign could detect and tell apart, before any reading (Python package)
    #[command(disable_help_flag = true)]
    Isolability(Elsewhere),
    /// Simulate the readings of a planned campaign, with effects and noise (Python package)
    #[command(disable_help_flag = true)]
    Simulate(Elsewhere),
    /// The runs that would decide between the explanations that the readings leave open (Python package)
    #[command(disable_help_flag = true)]
    NextRun(Elsewhere),
    /// The shortest campaign that tells effects apart (Python package)
    #[command(disable_help_flag = true)]
    Plan(Elsewhere),
    /// The diagnosis as one HTML page that opens without a network (Python package)
    #[command(disable_help_flag = true)]
    Report(Elsewhere),
    /// The same page, interactive in the browser and served on this machine only (Python package)
    #[command(disable_help_flag = true)]
    Workbench(Elsewhere),
    /// Spread of the elastic angle that the tolerances of the drawing cause (Python package)
    #[command(disable_help_flag = true)]
    Tolerance(Elsewhere),
    /// The design with the smallest elastic angle within bounds (Python package)
    #[command(disable_help_flag = true)]
    Optimise(Elsewhere),
    /// Transmission error of the parts as they were made, its spectrum, the share of each ball (Python package)
    #[command(disable_help_flag = true)]
    Transmission(Elsewhere),
    /// One page of the drive for a catalogue, HTML or PDF (Python package)
    #[command(disable_help_flag = true)]
    Datasheet(Elsewhere),
}

/// Anything: the verb is implemented elsewhere.
#[derive(Debug, Args)]
pub struct Elsewhere {
    /// Handed on.
    #[arg(trailing_var_arg = true, allow_hyphen_values = true, hide = true)]
    pub rest: Vec<String>,
}

/// The case file.
#[derive(Debug, Args)]
pub struct CaseFile {
    /// Case file (TOML)
    #[arg(value_name = "CASE")]
    pub path: PathBuf,
}

/// Units and form of the output.
#[derive(Debug, Args)]
pub struct OutputOptions {
    /// Print one JSON object instead of tables
    #[arg(long)]
    pub json: bool,
    /// Also write to FILE.csv or FILE.json
    #[arg(long, value_name = "FILE")]
    pub out: Option<PathBuf>,
    /// Unit of elastic angles
    #[arg(long, value_parser = unit_of(Quantity::Angle), default_value = "arcsec", value_name = "UNIT")]
    pub angle_unit: &'static Unit,
    /// Unit of forces
    #[arg(long, value_parser = unit_of(Quantity::Force), default_value = "N", value_name = "UNIT")]
    pub force_unit: &'static Unit,
    /// Unit of torques
    #[arg(long, value_parser = unit_of(Quantity::Torque), default_value = "Nm", value_name = "UNIT")]
    pub torque_unit: &'static Unit,
    /// Unit of deformations and contact ellipses
    #[arg(long, value_parser = unit_of(Quantity::Length), default_value = "um", value_name = "UNIT")]
    pub length_unit: &'static Unit,
    /// Unit of contact pressures
    #[arg(long, value_parser = unit_of(Quantity::Stress), default_value = "GPa", value_name = "UNIT")]
    pub pressure_unit: &'static Unit,
}

/// A load; values that are not given come from the `[load]` section of the case.
#[derive(Debug, Args)]
pub struct LoadOptions {
    /// Resistance torque on the output, N m
    #[arg(long = "torque-Nm", value_name = "T", allow_negative_numbers = true)]
    pub torque_Nm: Option<f64>,
    /// Axial preload, N
    #[arg(long = "preload-N", value_name = "F", allow_negative_numbers = true)]
    pub preload_N: Option<f64>,
    /// Angle of the input crank from the line of centres, degrees [default: the value of the case, or 0]
    #[arg(long = "input-angle-deg", value_name = "A", allow_negative_numbers = true)]
    pub input_angle_deg: Option<f64>,
}

/// `cbpt solve`.
#[derive(Debug, Args)]
#[expect(clippy::struct_excessive_bools, reason = "what may be asked for besides, one flag each")]
pub struct Solve {
    /// The case file.
    #[command(flatten)]
    pub case: CaseFile,
    /// The load.
    #[command(flatten)]
    pub load: LoadOptions,
    /// List every meshing point
    #[arg(long)]
    pub points: bool,
    /// Also give the largest elastic angle over a period of the drive
    #[arg(long)]
    pub over_period: bool,
    /// Also give friction torque, efficiency, wear, static safety and natural frequency at the input angle
    #[arg(long)]
    pub friction: bool,
    /// Also prove the solution: an interval that holds the elastic angle for certain, rounding included
    #[arg(long)]
    pub certify: bool,
    /// Form of the output.
    #[command(flatten)]
    pub output: OutputOptions,
}

/// `cbpt preload`.
#[derive(Debug, Args)]
pub struct Preload {
    /// The case file.
    #[command(flatten)]
    pub case: CaseFile,
    /// Resistance torque on the output, N m
    #[arg(long = "torque-Nm", value_name = "T", allow_negative_numbers = true)]
    pub torque_Nm: Option<f64>,
    /// Angle of the input crank, degrees, at which to take the thresholds instead of their maxima over a period
    #[arg(long = "input-angle-deg", value_name = "A", allow_negative_numbers = true)]
    pub input_angle_deg: Option<f64>,
    /// Form of the output.
    #[command(flatten)]
    pub output: OutputOptions,
}

/// `cbpt friction`.
#[derive(Debug, Args)]
pub struct Friction {
    /// The case file.
    #[command(flatten)]
    pub case: CaseFile,
    /// The load; the friction is that over a period, the angle counts for the natural frequency.
    #[command(flatten)]
    pub load: LoadOptions,
    /// Friction coefficient of the contacts [default: that of the case, or 0.1]
    #[arg(long, value_name = "MU", allow_negative_numbers = true)]
    pub coefficient: Option<f64>,
    /// Static safety that is required [default: that of the case, or 1]
    #[arg(long, value_name = "S0")]
    pub static_safety: Option<f64>,
    /// Form of the output.
    #[command(flatten)]
    pub output: OutputOptions,
}

/// `cbpt sweep`.
#[derive(Debug, Args)]
pub struct Sweep {
    /// Case file (TOML), or a plan: a TOML file that names a case and a table of axes
    #[arg(value_name = "CASE|PLAN")]
    pub path: PathBuf,
    /// Torques, N m: a list `1,2,5`, a range `0:10:0.5` (start:stop:step), or both mixed
    #[arg(long = "torque-Nm", value_name = "LIST", allow_hyphen_values = true)]
    pub torque_Nm: Option<String>,
    /// Preloads, N, in the same form
    #[arg(long = "preload-N", value_name = "LIST", allow_hyphen_values = true)]
    pub preload_N: Option<String>,
    /// Angles of the input crank, degrees, in the same form
    #[arg(long = "input-angle-deg", value_name = "LIST", allow_hyphen_values = true)]
    pub input_angle_deg: Option<String>,
    /// For a CASE: further columns, separated by commas; they take time
    #[arg(long, value_name = "NAMES", value_delimiter = ',', value_parser = cost())]
    pub columns: Vec<Cost>,
    /// For a PLAN: number of rows to solve and write at a time, rounded to blocks of 8192, at least one block [default: 65536]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..))]
    pub chunk_rows: Option<u64>,
    /// For a PLAN: start again and replace the file of --out
    #[arg(long)]
    pub fresh: bool,
    /// Form of the output.
    #[command(flatten)]
    pub output: OutputOptions,
}

/// `cbpt sensitivity`.
#[derive(Debug, Args)]
pub struct Sensitivity {
    /// Case, load and form of the output.
    #[command(flatten)]
    pub of: UnderLoad,
    /// Also friction torque, efficiency, wear, static safety and natural frequency at the input angle, by differences
    #[arg(long)]
    pub friction: bool,
}

/// Case, load and form of the output; `cbpt check` has no more.
#[derive(Debug, Args)]
pub struct UnderLoad {
    /// The case file.
    #[command(flatten)]
    pub case: CaseFile,
    /// The load; `check` also does without.
    #[command(flatten)]
    pub load: LoadOptions,
    /// Form of the output.
    #[command(flatten)]
    pub output: OutputOptions,
}

/// `cbpt effects`.
#[derive(Debug, Args)]
pub struct Effects {
    /// Effect to describe in full; without an ID, all effects are listed
    #[arg(value_name = "ID")]
    pub id: Option<String>,
    /// Print one JSON object instead, with numbers in SI
    #[arg(long)]
    pub json: bool,
    /// Print the page of the documentation (Markdown) instead
    #[arg(long, conflicts_with_all = ["json", "id"])]
    pub page: bool,
}

/// `cbpt schema`.
#[derive(Debug, Args)]
pub struct Schema {
    /// Print the table of keys (Markdown) instead
    #[arg(long, conflicts_with = "example")]
    pub keys: bool,
    /// Print an example case file instead
    #[arg(long)]
    pub example: bool,
    /// Write to FILE instead of standard output
    #[arg(long, value_name = "FILE")]
    pub out: Option<PathBuf>,
}
