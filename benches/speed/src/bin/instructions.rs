//! The hot loops alone, for callgrind: `instructions loads|hard|geometry|hertz N`; what it counts is in benches/instructions.py.

use cbpt_core::hertz::HertzContact;
use cbpt_core::sweep::{Progress, solve_each};
use cbpt_core::{Drive, Load, Status};

fn main() {
    let arguments: Vec<String> = std::env::args().collect();
    let workload = arguments.get(1).map_or("loads", String::as_str);
    let count: usize = arguments.get(2).and_then(|count| count.parse().ok()).unwrap_or(10_000);
    let points = speed::points(0.1);
    let hold = points.holding_arm_m(1.0);
    let share = |i: usize| i as f64 / count as f64;
    let preload: Vec<f64> = (0..count).map(|i| 300.0 + 600.0 * share(i * 7919 % count)).collect();
    let torque = |from: f64, to: f64| -> Vec<f64> {
        (0..count).map(|i| (from + (to - from) * share(i * 104_729 % count)) * hold * preload[i]).collect()
    };
    let solved = match workload {
        "geometry" => {
            let drives = vec![Drive::paper_base_case(); count];
            let loads: Vec<Load> = preload.iter().filter_map(|n| Load::new(5.0, *n, 0.1).ok()).collect();
            let mut rows = vec![(Status::Undercut, None); count];
            solve_each(&drives, &loads, &mut rows, &Progress::default());
            rows.iter().filter(|row| row.1.is_some()).count()
        }
        "hertz" => {
            // As many at once as the walls of 20 balls.
            let along: Vec<f64> = (0..count).map(|i| 500.0 + 400.0 * share(i * 7919 % count)).collect();
            along.chunks(80).flat_map(|along| HertzContact::many(along, 50.0, 1.1e11)).flatten().count()
        }
        _ => {
            let torque = if workload == "hard" { torque(0.4, 0.999) } else { torque(0.02, 0.3) };
            let (mut rotation, mut residual) = (vec![0.0; count], vec![0.0; count]);
            // Announced as many, so that what is counted grows with the loads and not with the curve.
            speed::solve_lanes(&points, &torque, &preload, &mut rotation, &mut residual)
        }
    };
    println!("{solved} of {count} solved");
}
