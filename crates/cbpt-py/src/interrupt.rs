//! Long calls: without the GIL, and stopped by Ctrl-C.

use std::thread;
use std::time::Duration;

use cbpt_core::sweep::Progress;
use pyo3::prelude::*;

use crate::threads::on_living_threads;

/// How often Ctrl-C is looked for.
const POLL: Duration = Duration::from_millis(20);

/// Runs `work` on its own thread without the GIL; a signal cancels it and raises what the signal raises.
///
/// `report` is called at every look with what has been done; what it raises cancels the work too.
pub fn without_gil<T: Send>(
    py: Python<'_>,
    report: Option<&Bound<'_, PyAny>>,
    work: impl FnOnce(&Progress) -> T + Send,
) -> PyResult<T> {
    let progress = Progress::default();
    thread::scope(|scope| {
        let worker = scope.spawn(|| on_living_threads(|| work(&progress)));
        // Short work is done before the first look.
        let mut pause = Duration::from_micros(50);
        while !worker.is_finished() {
            py.detach(|| thread::sleep(pause));
            pause = (2 * pause).min(POLL);
            let told = report.map_or(Ok(()), |report| report.call1((progress.done(),)).map(|_| ()));
            if let Err(signal) = py.check_signals().and(told) {
                progress.cancel();
                let _ = py.detach(|| worker.join());
                return Err(signal);
            }
        }
        match py.detach(|| worker.join()) {
            Ok(result) => result,
            Err(panic) => std::panic::resume_unwind(panic),
        }
    })
}
