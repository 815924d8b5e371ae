//! Command line of CBPT, as a library: the same verbs serve the plain binary and the `cbpt` command of the Python
//! package.
//!
//! - [`case`]: case files in TOML, the one parser; JSON Schema and key table come from the same list of keys;
//! - [`formula`]: the expressions of own effects in them;
//! - [`sweep`]: plans of sweeps over any parameter, and their files; [`progress`]: the bar;
//! - [`args`]: the tree of verbs and flags;
//! - [`commands`]: one file a verb: case and flags to a [`report::Report`];
//! - [`report`]: what a verb has to say, as a table, as JSON and as CSV;
//! - `bars`: a small picture of them for notebooks;
//! - [`terminal`]: its width and colours;
//! - `whole`: files that are written whole or not at all;
//! - [`run`]: arguments to exit code.

pub mod args;
mod bars;
pub mod case;
pub mod commands;
pub mod exit;
pub mod formula;
pub mod progress;
pub mod report;
pub mod sweep;
pub mod terminal;
mod whole;

use std::ffi::OsString;

use clap::Parser;

use args::{Cli, Verb};
use exit::{Exit, Failure};

/// Runs one command line, program name first; prints to standard output and error, and returns the exit code.
///
/// Exit codes are listed at [`Exit`].
pub fn run(arguments: impl IntoIterator<Item = OsString>) -> u8 {
    let cli = match Cli::try_parse_from(arguments) {
        Ok(cli) => cli,
        Err(error) => {
            // Help and version are "errors" to the parser and belong on standard output, with success.
            let code = if error.use_stderr() { Exit::BadInput } else { Exit::Success };
            // Nothing is left to do where even this cannot be printed.
            let _ = error.print();
            return code.code();
        }
    };
    let outcome = match &cli.verb {
        Verb::Solve(verb) => commands::solve::run(verb),
        Verb::Preload(verb) => commands::preload::run(verb),
        Verb::Friction(verb) => commands::friction::run(verb),
        Verb::Sweep(verb) => commands::sweep::run(verb),
        Verb::Sensitivity(verb) => commands::sensitivity::run(verb),
        Verb::Check(verb) => commands::check::run(verb),
        Verb::Effects(verb) => commands::effects::run(verb),
        Verb::Schema(verb) => commands::schema::run(verb),
        Verb::Compare(_) => Err(Failure::needs_python("compare")),
        Verb::Preflight(_) => Err(Failure::needs_python("preflight")),
        Verb::Characterise(_) => Err(Failure::needs_python("characterise")),
        Verb::Diagnose(_) => Err(Failure::needs_python("diagnose")),
        Verb::Change(_) => Err(Failure::needs_python("change")),
        Verb::Fit(_) => Err(Failure::needs_python("fit")),
        Verb::Isolability(_) => Err(Failure::needs_python("isolability")),
        Verb::Simulate(_) => Err(Failure::needs_python("simulate")),
        Verb::NextRun(_) => Err(Failure::needs_python("next-run")),
        Verb::Plan(_) => Err(Failure::needs_python("plan")),
        Verb::Report(_) => Err(Failure::needs_python("report")),
        Verb::Workbench(_) => Err(Failure::needs_python("workbench")),
        Verb::Tolerance(_) => Err(Failure::needs_python("tolerance")),
        Verb::Optimise(_) => Err(Failure::needs_python("optimise")),
        Verb::Transmission(_) => Err(Failure::needs_python("transmission")),
        Verb::Datasheet(_) => Err(Failure::needs_python("datasheet")),
    };
    match outcome {
        Ok(exit) => exit.code(),
        // A reader that has closed the pipe (`| head`) has seen enough.
        Err(Failure::Closed) => Exit::Success.code(),
        Err(failure) => {
            let told = match &failure {
                Failure::Case(error) => error.shown(),
                other => other.to_string(),
            };
            eprintln!("{}", terminal::for_terminal(&format!("cbpt: {told}"), true));
            failure.exit().code()
        }
    }
}
