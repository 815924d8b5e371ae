//! History goes by time, wherever the readings stand in the table.

use super::{ARCSEC, Campaign, SHARES, drives, fitted, typical_values};
use cbpt_core::predict::{History, Predictor};

const IDS: [&str; 6] = ["run_in", "drift", "thermal_preload", "wear", "creep", "friction_hysteresis"];

/// Three runs by one clock, as (run, readings); no run has the largest torque of the table before the last.
fn by_one_clock() -> Vec<Vec<Reading>> {
    let run = |number: i64| {
        let reading = |(i, share): (usize, &f64)| {
            let time = number as f64 * 150.0 + i as f64 * 7.0;
            let torque = share * (0.5 + 0.25 * number as f64) * 3.0;
            Reading { run: number, time, torque, warmth: (time / 400.0).sin() }
        };
        SHARES.iter().enumerate().map(reading).collect()
    };
    (0..3).map(run).collect()
}

#[derive(Clone, Copy)]
struct Reading {
    run: i64,
    time: f64,
    torque: f64,
    warmth: f64,
}

fn table(readings: &[Reading]) -> Campaign {
    Campaign {
        run: readings.iter().map(|row| row.run).collect(),
        time_s: readings.iter().map(|row| row.time).collect(),
        torque_Nm: readings.iter().map(|row| row.torque).collect(),
        preload_N: vec![600.0; readings.len()],
        input_angle_rad: vec![0.3; readings.len()],
        temperature_K: readings.iter().map(|row| 293.0 + row.warmth).collect(),
        cycle: vec![1.0; readings.len()],
    }
}

fn predictor(campaign: &Campaign, ids: &[&str], counted: bool) -> Predictor {
    let columns = cbpt_core::predict::Columns {
        run: &campaign.run,
        time_s: &campaign.time_s,
        torque_Nm: &campaign.torque_Nm,
        preload_N: Some(&campaign.preload_N),
        input_angle_rad: &campaign.input_angle_rad,
        temperature_K: Some(&campaign.temperature_K),
        cycle: counted.then_some(&campaign.cycle[..]),
    };
    let rows = cbpt_core::predict::Rows::new(columns).unwrap();
    Predictor::new(drives()[0].1.clone(), ids, rows).unwrap()
}

/// Runs that a file has in another order are the same campaign, in every effect that remembers.
#[test]
fn the_order_of_runs_in_the_table_does_not_matter() {
    let runs = by_one_clock();
    let found = |order: [usize; 3]| {
        let readings: Vec<Reading> = order.iter().flat_map(|run| runs[*run].clone()).collect();
        let mut predictor = predictor(&table(&readings), &IDS, false);
        let values = typical_values(&predictor);
        let wanted = fitted(&predictor);
        let found = predictor.predict(&values, &wanted).unwrap();
        let mut rows: Vec<(f64, f64, Vec<f64>)> = readings
            .iter()
            .enumerate()
            .map(|(i, reading)| {
                let slopes = &found.sensitivities[i * wanted.len()..(i + 1) * wanted.len()];
                (reading.time, found.angle_rad[i], slopes.to_vec())
            })
            .collect();
        rows.sort_by(|a, b| a.0.total_cmp(&b.0));
        rows
    };
    let expected = found([0, 1, 2]);
    assert!(expected.iter().all(|(_, angle, _)| angle.is_finite()));
    for order in [[1, 0, 2], [2, 1, 0]] {
        assert!(found(order) == expected, "{order:?}");
    }
}

/// Where no cycle was counted, runs count, in their order of time.
#[test]
fn runs_count_as_cycles() {
    let runs = by_one_clock();
    let readings: Vec<Reading> = [2, 0, 1].iter().flat_map(|run| runs[*run].clone()).collect();
    let angles = |settled: f64| {
        let mut predictor = predictor(&table(&readings), &["run_in"], false);
        predictor.predict(&[0.0, 0.0, settled, 1.5], &[]).unwrap().angle_rad
    };
    let (with, without) = (angles(-8.0 * ARCSEC), angles(0.0));
    for ((reading, with), without) in readings.iter().zip(with).zip(without) {
        let expected = -8.0 * ARCSEC * (1.0 - (-reading.run as f64 / 1.5).exp());
        assert!((with - without - expected).abs() < 1e-16);
    }
}

/// Runs that overlap in time have clocks of their own: their order is that of the table, and a lag starts with each.
#[test]
fn clocks_of_runs_start_again() {
    let runs: Vec<Vec<Reading>> = by_one_clock()
        .into_iter()
        .map(|run| {
            let start = run[0].time;
            run.into_iter().map(|row| Reading { time: row.time - start, ..row }).collect()
        })
        .collect();
    let all: Vec<Reading> = runs.concat();
    let values = [0.0, 1e-6, 40.0, 0.0, 600.0];
    let whole = predictor(&table(&all), &["drift"], true).predict(&values, &[]).unwrap().angle_rad;
    let bare = predictor(&table(&all), &[], true).predict(&[], &[]).unwrap().angle_rad;
    for (number, run) in runs.iter().enumerate() {
        let own = predictor(&table(run), &["drift"], true).predict(&values, &[]).unwrap().angle_rad;
        let first = number * SHARES.len();
        // The run by itself has another first temperature.
        let shift = 1e-6 * (run[0].warmth - runs[0][0].warmth);
        let alone = predictor(&table(run), &[], true).predict(&[], &[]).unwrap().angle_rad;
        for (i, own) in own.iter().enumerate() {
            let (with, without) = (whole[first + i] - bare[first + i], own - alone[i]);
            assert!((with - without - shift).abs() < 1e-16, "{number} {i}: {with} {without} {shift}");
        }
    }
}

/// Rows that carry the same are solved once, and have what stands in series each for itself: as rows that differ in the last
/// digits of their torques, of which each is solved.
#[test]
fn rows_that_carry_the_same_are_as_rows_that_hardly_differ() {
    let ids = ["output_torsion", "creep", "drift", "sensor_nonlinearity"];
    let readings: Vec<Reading> = by_one_clock().concat();
    let found = |near: f64| {
        let mut campaign = table(&readings);
        for (i, torque_Nm) in campaign.torque_Nm.iter_mut().enumerate() {
            *torque_Nm = SHARES[i % SHARES.len()] * 3.0 * (1.0 + near * i as f64);
        }
        let mut predictor = predictor(&campaign, &ids, false);
        let values = typical_values(&predictor);
        let wanted = fitted(&predictor);
        let found = predictor.predict(&values, &wanted).unwrap();
        (found.angle_rad, found.sensitivities)
    };
    let (alike, each) = (found(0.0), found(1e-15));
    // Each of the three runs carries the same.
    let run = SHARES.len();
    assert!((0..run).any(|i| (alike.0[i] - alike.0[i + run]).abs() > 1e-3 * alike.0[i].abs()));
    for (alike, each) in [(&alike.0, &each.0), (&alike.1, &each.1)] {
        let size = each.iter().fold(0.0_f64, |size, value| size.max(value.abs()));
        for (alike, each) in alike.iter().zip(each) {
            assert!((alike - each).abs() <= 1e-9 * each.abs() + 1e-12 * size, "{alike} {each}");
        }
    }
}

/// Angles and slopes under friction.
fn under_friction(campaign: &Campaign) -> (Vec<f64>, Vec<f64>) {
    let mut predictor = predictor(campaign, &["friction_hysteresis"], false);
    let values = typical_values(&predictor);
    let wanted = fitted(&predictor);
    let found = predictor.predict(&values, &wanted).unwrap();
    assert!(found.angle_rad.iter().all(|angle| angle.is_finite()));
    (found.angle_rad, found.sensitivities)
}

/// One way through the torques, cut into two runs.
fn cut_in_two() -> Campaign {
    let mut campaign = table(&by_one_clock()[0]);
    campaign.run[9..].fill(2);
    campaign
}

/// Where a run is cut in two, the second goes on with the friction that the first has left, whatever the pause.
#[test]
fn a_run_goes_on_where_the_one_before_it_ended() {
    let (mut cut, whole) = (cut_in_two(), table(&by_one_clock()[0]));
    assert_eq!(under_friction(&cut), under_friction(&whole));
    cut.time_s[9..].iter_mut().for_each(|time| *time += 3600.0);
    assert_eq!(under_friction(&cut), under_friction(&whole));
}

/// Unless every run starts anew: then it is what the same readings show by a clock that starts again.
#[test]
fn every_run_may_start_anew() {
    let cut = cut_in_two();
    assert_eq!(cut.rows().unwrap().runs_that_go_on(), 1);
    assert_eq!(cut.rows().unwrap().with_history(History::Released).runs_that_go_on(), 0);
    let mut apart = cut_in_two();
    apart.time_s[9..].iter_mut().for_each(|time| *time -= 50.0);
    let [mut carried, mut rested] =
        [&cut, &apart].map(|campaign| predictor(campaign, &["friction_hysteresis"], false));
    let values = typical_values(&carried);
    let before = carried.predict(&values, &[]).unwrap();
    carried.take_history(History::Released);
    let after = carried.predict(&values, &[]).unwrap();
    assert_eq!(after.angle_rad, rested.predict(&values, &[]).unwrap().angle_rad);
    assert_ne!(after.angle_rad, before.angle_rad);
}

/// Or goes on though each run has a clock of its own, or none.
#[test]
fn a_run_may_go_on_by_another_clock() {
    let whole = under_friction(&table(&by_one_clock()[0]));
    // Under the largest torque: a run that ends there does not close.
    let cut = || {
        let mut campaign = cut_in_two();
        campaign.run[5..].fill(2);
        campaign
    };
    for edit in [|time: &mut f64| *time -= 50.0, |time: &mut f64| *time = 0.0] {
        let mut apart = cut();
        apart.time_s[5..].iter_mut().for_each(edit);
        assert_eq!(apart.rows().unwrap().runs_that_go_on(), 0);
        let mut predictor = predictor(&apart, &["friction_hysteresis"], false);
        predictor.take_history(History::Carried);
        let values = typical_values(&predictor);
        let found = predictor.predict(&values, &fitted(&predictor)).unwrap();
        assert_eq!((found.angle_rad, found.sensitivities), whole);
    }
}

/// A closed run that no other leads to goes on from a repetition of itself: as if that stood in the table before it.
#[test]
fn a_closed_run_may_have_been_repeated_before() {
    let rows = |copies: usize| {
        let torque_Nm = [0.0, 3.0, 6.0, 3.0, 0.0, -3.0, -6.0, -3.0, 0.0].repeat(copies);
        let count = torque_Nm.len();
        Campaign {
            run: (0..).take(count).map(|place: i64| place / 9).collect(),
            time_s: (0..count).map(|place| place as f64).collect(),
            torque_Nm,
            preload_N: vec![600.0; count],
            input_angle_rad: vec![0.2; count],
            temperature_K: vec![0.0; count],
            cycle: vec![0.0; count],
        }
    };
    let (angles, slopes) = under_friction(&rows(2));
    let mut predictor = predictor(&rows(1), &["friction_hysteresis"], false);
    let values = typical_values(&predictor);
    let wanted = fitted(&predictor);
    let virgin = predictor.predict(&values, &wanted).unwrap();
    assert_eq!(virgin.angle_rad, angles[..9]);
    predictor.take_history(History::Carried);
    let rows = predictor.rows();
    assert_eq!((rows.len(), rows.runs_that_go_on(), rows.runs_with_unmeasured_past()), (9, 0, 1));
    let found = predictor.predict(&values, &wanted).unwrap();
    assert_eq!(found.angle_rad, angles[9..]);
    assert_eq!(found.sensitivities, slopes[slopes.len() / 2..]);
    assert_eq!(found.status.len(), 9);
    predictor.take_history(History::ByClock);
    assert_eq!(predictor.predict(&values, &wanted).unwrap(), virgin);
}

/// A run that no other leads to goes on from a loop that came down, or up, to its first reading: as if that stood before it.
#[test]
fn a_run_may_begin_after_a_loop() {
    let rows = |torque_Nm: &[f64]| {
        let count = torque_Nm.len();
        Campaign {
            run: vec![0; count],
            time_s: (0..count).map(|place| place as f64).collect(),
            torque_Nm: torque_Nm.to_vec(),
            preload_N: vec![600.0; count],
            input_angle_rad: vec![0.2; count],
            temperature_K: vec![0.0; count],
            cycle: vec![0.0; count],
        }
    };
    let run = [1.0, 3.0, 6.0, 3.0, 0.0, -3.0, -6.0, -3.0];
    for (history, past) in
        [(History::CarriedFromAbove, [-6.0, 6.0]), (History::CarriedFromBelow, [6.0, -6.0])]
    {
        let angles = under_friction(&rows(&[&past[..], &run[..1], &run[..]].concat())).0;
        let mut predictor = predictor(&rows(&run), &["friction_hysteresis"], false);
        predictor.take_history(history);
        assert_eq!(predictor.rows().runs_with_unmeasured_past(), 1);
        // Nor does a run lead to the past of another one.
        let mut both = rows(&[&run[..], &[3.0, 6.0, 3.0]].concat());
        both.run[run.len()..].fill(1);
        let both = both.rows().unwrap().with_history(history);
        assert_eq!((both.runs_that_go_on(), both.runs_with_unmeasured_past()), (0, 2));
        let values = typical_values(&predictor);
        let found = predictor.predict(&values, &[]).unwrap().angle_rad;
        for (found, expected) in found.iter().zip(&angles[3..]) {
            assert!((found - expected).abs() <= 1e-9 * expected.abs(), "{found} {expected}");
        }
    }
}

/// After a leap of the torque, a turn of the input, another preload, by a clock that starts again or without one, a run is loaded
/// from rest.
#[test]
fn a_run_that_does_not_go_on_is_loaded_from_rest() {
    let change = |edit: &dyn Fn(&mut Campaign)| {
        let mut campaign = cut_in_two();
        edit(&mut campaign);
        campaign
    };
    let apart = [
        change(&|c| c.torque_Nm[9..].iter_mut().for_each(|torque| *torque += 4.0)),
        change(&|c| c.input_angle_rad[9..].fill(0.4)),
        change(&|c| c.preload_N[9..].fill(620.0)),
        change(&|c| c.time_s[9..].iter_mut().for_each(|time| *time -= 50.0)),
        change(&|c| c.time_s.fill(0.0)),
    ];
    for (number, both) in apart.iter().enumerate() {
        let alone = Campaign {
            run: both.run[9..].to_vec(),
            time_s: both.time_s[9..].to_vec(),
            torque_Nm: both.torque_Nm[9..].to_vec(),
            preload_N: both.preload_N[9..].to_vec(),
            input_angle_rad: both.input_angle_rad[9..].to_vec(),
            temperature_K: both.temperature_K[9..].to_vec(),
            cycle: both.cycle[9..].to_vec(),
        };
        let (found, expected) = (under_friction(both).0, under_friction(&alone).0);
        for (found, expected) in found[9..].iter().zip(&expected) {
            assert!((found - expected).abs() <= 1e-9 * expected.abs(), "{number}: {found} {expected}");
        }
    }
}
