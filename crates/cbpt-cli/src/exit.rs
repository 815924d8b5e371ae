//! Exit codes, and what stops a verb.

use std::io;
use std::path::{Path, PathBuf};

use cbpt_core::InvalidInput;

use crate::case::CaseError;

/// What the exit code of `cbpt` means.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Exit {
    /// 0: done.
    Success,
    /// 1: a file could not be written.
    CannotWrite,
    /// 2: the command line, the case file or a number in them is wrong.
    BadInput,
    /// 3: done, but the load has no solution (or no load of a sweep has); the output says why.
    NoSolution,
    /// 4: done, and the design has a finding of severity error.
    DesignError,
}

impl Exit {
    /// The number.
    pub fn code(self) -> u8 {
        match self {
            Self::Success => 0,
            Self::CannotWrite => 1,
            Self::BadInput => 2,
            Self::NoSolution => 3,
            Self::DesignError => 4,
        }
    }
}

/// Why a verb stopped before it was done.
#[derive(Debug, thiserror::Error)]
pub enum Failure {
    /// The case file is wrong.
    #[error("{0}")]
    Case(#[from] CaseError),
    /// A number of the command line is wrong.
    #[error("{0}")]
    Input(#[from] InvalidInput),
    /// A flag is missing or its text cannot be read.
    #[error("{0}")]
    Usage(String),
    /// A file could not be written.
    #[error("cannot write {}: {error}", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// Why.
        error: io::Error,
    },
    /// The reader of standard output has gone.
    #[error("standard output is closed")]
    Closed,
}

impl Failure {
    /// A verb that lives in the Python package.
    pub fn needs_python(verb: &str) -> Self {
        Self::Usage(format!(
            "`cbpt {verb}` needs the Python package, whose `cbpt` command has every verb: pip install cbpt"
        ))
    }

    /// The exit code it leads to.
    pub fn exit(&self) -> Exit {
        match self {
            Self::Case(_) | Self::Input(_) | Self::Usage(_) => Exit::BadInput,
            Self::Write { .. } => Exit::CannotWrite,
            Self::Closed => Exit::Success,
        }
    }
}

/// Refuses to write over a file that the verb reads.
///
/// # Errors
/// Names the file.
pub fn keep_input(out: &Path, inputs: &[impl AsRef<Path>]) -> Result<(), Failure> {
    let same = |input: &Path| matches!((out.canonicalize(), input.canonicalize()), (Ok(a), Ok(b)) if a == b);
    if inputs.iter().any(|input| same(input.as_ref())) {
        let problem = format!(
            "--out {}: the command reads this file and would overwrite it; give another name",
            out.display()
        );
        return Err(Failure::Usage(problem));
    }
    Ok(())
}
