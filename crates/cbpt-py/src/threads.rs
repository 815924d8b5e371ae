//! The threads that work is spread over, also in a process that was forked.
//!
//! A fork copies the memory of rayon's shared pool, but none of its threads: what is handed to them waits for ever. A forked
//! process therefore gets a pool of its own, the first time that it has work.

use std::mem;
use std::process;
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Arc, Mutex};

use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};

/// The process that has rayon's shared pool: the first one with work, 0 before.
static OWNER: AtomicU32 = AtomicU32::new(0);

/// The pool of a process that was forked from it.
static FORKED: Mutex<Option<(u32, Arc<ThreadPool>)>> = Mutex::new(None);

/// Runs `work` without the GIL on threads that are alive. Raises `RuntimeError` where they cannot be started.
pub fn detached<T: Send>(py: Python<'_>, work: impl FnOnce() -> T + Send) -> PyResult<T> {
    py.detach(|| on_living_threads(work))
}

/// The same for a thread that has no GIL.
pub fn on_living_threads<T: Send>(work: impl FnOnce() -> T + Send) -> PyResult<T> {
    let process = process::id();
    match OWNER.compare_exchange(0, process, Ordering::Relaxed, Ordering::Relaxed) {
        Err(owner) if owner != process => Ok(pool_of(process)?.install(work)),
        _ => Ok(work()),
    }
}

/// The pool of a forked process.
fn pool_of(process: u32) -> PyResult<Arc<ThreadPool>> {
    // Another thread may have held the lock when the process was forked: then nobody ever opens it, and this call does without.
    let mut kept = FORKED.try_lock().ok();
    if let Some((owner, pool)) = kept.as_deref().and_then(Option::as_ref)
        && *owner == process
    {
        return Ok(Arc::clone(pool));
    }
    let pool = ThreadPoolBuilder::new().build().map_err(|error| {
        PyRuntimeError::new_err(format!("the threads of a forked process could not be started: {error}"))
    })?;
    let pool = Arc::new(pool);
    if let Some(kept) = kept.as_deref_mut() {
        // To end a pool whose threads are gone would wait for them.
        mem::forget(kept.replace((process, Arc::clone(&pool))));
    }
    Ok(pool)
}
