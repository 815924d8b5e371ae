//! The progress bar.

use std::fmt::Write;
use std::io::IsTerminal;
use std::thread;
use std::time::Duration;

use cbpt_core::sweep::Progress;
use indicatif::{HumanCount, ProgressBar, ProgressDrawTarget, ProgressState, ProgressStyle};

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
        if let Ok(style) = ProgressStyle::with_template("{bar:40} {pos}/{len} {rate} left {eta}") {
            let rate = |state: &ProgressState, text: &mut dyn Write| {
                // What cannot be written is not shown.
                let _ = text.write_str(&rate(state.per_sec()));
            };
            bar.set_style(style.with_key("rate", rate));
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

/// Three digits say all that a rate means.
fn rate(per_second: f64) -> String {
    if !per_second.is_finite() || per_second < 0.0 {
        return "? a second".into();
    }
    if per_second < 100.0 {
        return format!("{per_second:.1} a second");
    }
    let unit = 10_f64.powf((per_second.log10() - 2.0).floor());
    let rounded = (per_second / unit).round() * unit;
    // Not negative; what is too large stays the largest.
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    let whole = rounded.round() as u64;
    format!("{} a second", HumanCount(whole))
}

#[cfg(test)]
mod tests {
    use super::rate;

    #[test]
    fn a_rate_has_three_digits() {
        for (found, text) in [
            (0.0, "0.0"),
            (0.26, "0.3"),
            (12.345_678, "12.3"),
            (123.456_7, "123"),
            (999.9, "1,000"),
            (1_096_712.345_6, "1,100,000"),
            (f64::INFINITY, "?"),
        ] {
            assert_eq!(rate(found), format!("{text} a second"));
        }
    }
}
