//! The bar that shows how far long work has come.

use std::io::IsTerminal;
use std::thread;
use std::time::Duration;

use cbpt_core::sweep::Progress;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

/// Runs `work`, which has `done` of `total` behind it, and shows a bar with rate and time left on a terminal once it has
/// taken a second.
pub fn with_progress_bar<T: Send>(done: u64, total: u64, work: impl FnOnce(&Progress) -> T + Send) -> T {
    let progress = Progress::default();
    if !std::io::stderr().is_terminal() {
        return work(&progress);
    }
    thread::scope(|scope| {
        let worker = scope.spawn(|| work(&progress));
        let bar = ProgressBar::with_draw_target(Some(total - done.min(total)), ProgressDrawTarget::hidden());
        if let Ok(style) = ProgressStyle::with_template("{bar:40} {pos}/{len} {per_sec} left {eta}") {
            bar.set_style(style);
        }
        let mut ticks = 0_u32;
        while !worker.is_finished() {
            thread::sleep(Duration::from_millis(50));
            ticks += 1;
            if ticks == 20 {
                bar.set_draw_target(ProgressDrawTarget::stderr());
            }
            bar.set_position(progress.done() as u64);
        }
        bar.finish_and_clear();
        match worker.join() {
            Ok(result) => result,
            Err(panic) => std::panic::resume_unwind(panic),
        }
    })
}
