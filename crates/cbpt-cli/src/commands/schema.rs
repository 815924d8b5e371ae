//! `cbpt schema`: JSON Schema of case files, the table of keys, or an example.

use crate::args::Schema;
use crate::case::{json_schema, key_table};
use crate::exit::{Exit, Failure};
use crate::report::{pretty, print, write_file};

/// The example case file: the base case of the 2017 paper.
pub const EXAMPLE: &str = include_str!("../example.toml");

/// Runs the verb.
pub fn run(verb: &Schema) -> Result<Exit, Failure> {
    let text = if verb.keys {
        key_table()
    } else if verb.example {
        EXAMPLE.to_owned()
    } else {
        pretty(&json_schema())
    };
    match &verb.out {
        Some(path) => write_file(path, text.as_bytes())?,
        None => print(&text)?,
    }
    Ok(Exit::Success)
}
