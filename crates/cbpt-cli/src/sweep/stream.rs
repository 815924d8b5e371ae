//! A plan to its file, chunk by chunk.

use std::ops::Range;

use cbpt_core::sweep::Progress;

use super::output::CsvOutput;
use super::tally::Tally;
use super::{BLOCK_ROWS, Plan};
use crate::exit::Failure;

/// The parts in which rows are solved and written: whole blocks, at least so many rows each.
pub fn chunks(done: u64, rows: u64, chunk_rows: u64) -> impl Iterator<Item = Range<u64>> {
    let size = chunk_rows.max(1).div_ceil(BLOCK_ROWS).saturating_mul(BLOCK_ROWS);
    let mut start = done;
    std::iter::from_fn(move || {
        (start < rows).then(|| {
            let chunk = start..start.saturating_add(size).min(rows);
            start = chunk.end;
            chunk
        })
    })
}

/// Solves what is left of a plan on all cores and writes it; says how these rows ended.
///
/// # Errors
/// Where the file cannot be written.
pub fn to_csv(
    plan: &Plan,
    output: &mut CsvOutput,
    chunk_rows: u64,
    progress: &Progress,
) -> Result<Tally, Failure> {
    let mut tally = Tally::default();
    for chunk in chunks(output.done(), plan.rows(), chunk_rows) {
        let Some((lines, ended)) = plan.csv(&chunk, progress) else { break };
        output.append(&lines, chunk.end - chunk.start)?;
        tally.merge(ended);
    }
    Ok(tally)
}

/// Runs `work` on the threads that all share, or on so many of its own: a process that was forked has lost the shared ones,
/// and workers that share a machine would fight over it. `None` where the threads cannot be started.
pub fn on_threads<T: Send>(threads: Option<usize>, work: impl FnOnce() -> Option<T> + Send) -> Option<T> {
    match threads {
        None => work(),
        Some(threads) => {
            rayon::ThreadPoolBuilder::new().num_threads(threads.max(1)).build().ok()?.install(work)
        }
    }
}
