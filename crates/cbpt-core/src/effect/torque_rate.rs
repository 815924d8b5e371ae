//! How fast the torque of a run changes at each of its readings.
//!
//! The rate at a reading is that from the reading before to the one behind, so that the noise of a torque reading has no share
//! in it but at a corner; at the last it is that from the one before. At a corner, where a ramp turns back or begins to hold, that is the rate
//! of neither side: the torque arrives with the one and leaves with the other. A corner is a reading at which the rate jumps
//! by more than twice what it changes over the steps before and behind together: it does neither at the top of a sine nor, but
//! for one noisy reading in forty, along a ramp.

/// The rates at a reading, N m/s; the same but at a corner.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rate {
    /// Just before it.
    pub arriving_Nm_per_s: f64,
    /// Just after it.
    pub leaving_Nm_per_s: f64,
}

/// Of all readings of a run, given by its times (s) and torques (N m); the first has that of the first step, and two readings at
/// one time have no rate between them.
pub fn rates(time_s: &[f64], torque_Nm: &[f64]) -> Vec<Rate> {
    let Some(last) = time_s.len().checked_sub(1) else { return Vec::new() };
    let between = |first: usize, second: usize| {
        let passed_s = time_s[second] - time_s[first];
        if passed_s > 0.0 { (torque_Nm[second] - torque_Nm[first]) / passed_s } else { 0.0 }
    };
    // The rate at one end of a step, as it changes from the step beyond its other end to this one, and by how much it does.
    let side = |at: usize, next: usize, beyond: usize| {
        let ordered = |one: usize, other: usize| between(one.min(other), one.max(other));
        let (near, far) = (ordered(at, next), ordered(next, beyond));
        let share = (time_s[next] - time_s[at]) / (time_s[beyond] - time_s[at]);
        (near, near + (near - far) * share, (near - far).abs())
    };
    (0..=last)
        .map(|place| {
            let smooth = between(place.saturating_sub(1), last.min(place + 1));
            let even = Rate { arriving_Nm_per_s: smooth, leaving_Nm_per_s: smooth };
            if place < 2 || place + 2 > last {
                return even;
            }
            let (before, arriving, change_before) = side(place, place - 1, place - 2);
            let (behind, leaving, change_behind) = side(place, place + 1, place + 2);
            let is_corner = (behind - before).abs() > 2.0 * (change_before + change_behind);
            if is_corner && arriving.is_finite() && leaving.is_finite() {
                Rate { arriving_Nm_per_s: arriving, leaving_Nm_per_s: leaving }
            } else {
                even
            }
        })
        .collect()
}

#[cfg(test)]
#[allow(clippy::float_cmp)] // where nothing is rounded
mod tests {
    use super::*;

    fn of(torque_Nm: &[f64]) -> Vec<(f64, f64)> {
        let time_s: Vec<f64> = (0..torque_Nm.len()).map(|i| 2.0 * i as f64).collect();
        rates(&time_s, torque_Nm).iter().map(|rate| (rate.arriving_Nm_per_s, rate.leaving_Nm_per_s)).collect()
    }

    #[test]
    fn a_ramp_that_turns_back_arrives_with_one_rate_and_leaves_with_the_other() {
        let found = of(&[0.0, 2.0, 4.0, 6.0, 4.0, 2.0, 0.0]);
        let expected =
            [(1.0, 1.0), (1.0, 1.0), (1.0, 1.0), (1.0, -1.0), (-1.0, -1.0), (-1.0, -1.0), (-1.0, -1.0)];
        assert_eq!(found, expected);
    }

    #[test]
    fn a_ramp_that_holds_has_a_corner_at_both_ends() {
        let found = of(&[0.0, 2.0, 4.0, 4.0, 4.0, 6.0, 8.0]);
        assert_eq!((found[2], found[4]), ((1.0, 0.0), (0.0, 1.0)));
    }

    #[test]
    fn the_top_of_a_sine_is_no_corner() {
        for steps in [12, 40, 200] {
            let torque: Vec<f64> = (0..=steps)
                .map(|i| (std::f64::consts::TAU * f64::from(i) / f64::from(steps)).sin())
                .collect();
            assert!(of(&torque).iter().all(|(arriving, leaving)| arriving == leaving), "{steps}");
        }
    }

    #[test]
    fn two_readings_at_one_time_and_short_runs_have_a_rate() {
        assert_eq!(rates(&[], &[]), []);
        for (time_s, torque_Nm) in [
            (vec![0.0], vec![1.0]),
            (vec![0.0; 6], vec![1.0; 6]),
            (vec![0.0, 1.0, 1.0, 1.0, 2.0, 3.0], vec![0.0; 6]),
        ] {
            assert!(rates(&time_s, &torque_Nm).iter().all(|rate| rate.arriving_Nm_per_s.is_finite()));
        }
    }
}
