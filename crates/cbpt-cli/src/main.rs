//! `cbpt`: see the library.

use std::process::ExitCode;

fn main() -> ExitCode {
    ExitCode::from(cbpt_cli::run(std::env::args_os()))
}
