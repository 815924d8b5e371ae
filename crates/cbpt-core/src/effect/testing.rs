//! A row, a drive and a ball to test effects on, and the limit that all of them share.
#![allow(clippy::panic, clippy::float_cmp)]

use super::dual::Dual;
use super::dual::values;
use super::port::{Action, Ball, Contact, DriveNumbers, Load, Row};
use super::spec::Spec;
use super::{backlash, hard_stop, stiffness_curve};

pub const ROW: Row = Row {
    place: 0,
    torque_Nm: 4.0,
    preload_N: 600.0,
    input_angle_rad: std::f64::consts::PI / 6.0,
    time_s: 500.0,
    run_time_s: 60.0,
    step_time_s: 4.0,
    rate_share: 1.0,
    temperature_difference_K: 3.0,
    largest_torque_share: 0.75,
    largest_torque_share_of_run: 0.5,
    cycles_done: 2.0,
    direction: 1.0,
};

pub const DRIVE: DriveNumbers = DriveNumbers { pitch_arm_m: 0.04, planet_turn: 0.9 };

pub const BALL: Ball = Ball {
    decelerates: true,
    number: 4,
    from_line_rad: 0.7,
    on_fixed_groove_rad: 1.1,
    on_planet_groove_rad: 1.06,
    in_plate_rad: 1.04,
    pitch_radius_m: 0.05,
};

pub fn assert_close(found: f64, expected: f64) {
    assert!((found - expected).abs() <= 1e-14 * expected.abs().max(1e-12), "{found} {expected}");
}

fn duals(own: &[f64]) -> Vec<Dual> {
    own.iter().copied().map(Dual::constant).collect()
}

pub fn load(spec: &Spec, own: &[f64]) -> Load {
    let mut load = Load {
        torque_Nm: Dual::constant(ROW.torque_Nm),
        preload_N: Dual::constant(ROW.preload_N),
        spring_N_per_m: Dual::constant(0.0),
        friction: Vec::new(),
    };
    match spec.action {
        Action::Load(act) => act(&duals(own), &ROW, &mut load),
        Action::Friction(act) => load.friction = act(&duals(own)),
        Action::ThermalLoad(_, act) => {
            act(&duals(own), Dual::constant(ROW.temperature_difference_K), &mut load);
        }
        _ => panic!("{} acts elsewhere", spec.id),
    }
    load
}

/// What is added to the torques of a run, given as its times (s) and torques (N m).
pub fn torques(spec: &Spec, own: &[Dual], run: &[(f64, f64)]) -> Vec<Dual> {
    let Action::Torques(act) = spec.action else { panic!("{} acts elsewhere", spec.id) };
    let mut before_s = run[0].0;
    let row = |&(run_time_s, torque_Nm): &(f64, f64)| {
        let step_time_s = run_time_s - std::mem::replace(&mut before_s, run_time_s);
        Row { torque_Nm, run_time_s, step_time_s, ..ROW }
    };
    act(own, &run.iter().map(row).collect::<Vec<_>>())
}

/// A run that goes up and comes back, with two readings at one time: times (s) and torques (N m).
pub const RAMP: [(f64, f64); 6] = [(0.0, 0.0), (2.0, 1.0), (4.0, 2.0), (4.0, 2.5), (6.0, 3.5), (8.0, 1.5)];

/// What is added to the torques of [`RAMP`] where it begins at rest and something is late by a time.
pub fn added_late(spec: &Spec, late_s: f64) -> Vec<f64> {
    let own = [Dual::constant(late_s), Dual::constant(0.0)];
    torques(spec, &own, &RAMP).iter().map(|torque| torque.value).collect()
}

/// A sine that began long before: times (s) and torques (N m).
pub fn sine() -> Vec<(f64, f64)> {
    (0..60).map(|i| 0.1 * f64::from(i)).map(|time_s| (time_s, time_s.sin())).collect()
}

pub fn contact(spec: &Spec, own: &[f64]) -> Contact {
    let Action::Contact(act) = spec.action else { panic!("{} acts elsewhere", spec.id) };
    let mut contact = Contact::unchanged();
    act(&duals(own), &mut contact);
    contact
}

pub fn gap(spec: &Spec, own: &[f64], size: usize, ball: &Ball) -> [f64; 3] {
    let Action::Gap(shape) = spec.action else { panic!("{} acts elsewhere", spec.id) };
    shape(own, size, ball)
}

pub fn series(spec: &Spec, own: &[f64], torque_Nm: f64) -> f64 {
    let Action::Series(act) = spec.action else { panic!("{} acts elsewhere", spec.id) };
    act(&duals(own), &ROW, &DRIVE, Dual::constant(torque_Nm)).value
}

/// The angles of a run, given as its times (s) and torques (N m).
pub fn history(spec: &Spec, own: &[f64], run: &[(f64, f64)]) -> Vec<f64> {
    let Action::History(act) = spec.action else { panic!("{} acts elsewhere", spec.id) };
    let rows: Vec<Row> = run.iter().map(|&(run_time_s, _)| Row { run_time_s, ..ROW }).collect();
    let torque_Nm: Vec<Dual> = run.iter().map(|&(_, torque_Nm)| Dual::constant(torque_Nm)).collect();
    act(&duals(own), &rows, &torque_Nm).iter().map(|angle| angle.value).collect()
}

pub fn reading(spec: &Spec, own: &[f64], angle_rad: f64) -> f64 {
    reading_under(spec, own, ROW.torque_Nm, angle_rad)
}

/// The same while the output carries a torque, N m.
pub fn reading_under(spec: &Spec, own: &[f64], torque_Nm: f64, angle_rad: f64) -> f64 {
    let angle = Dual::constant(angle_rad);
    let shown = match spec.action {
        Action::Reading(act) => act(&duals(own), &ROW, angle),
        Action::ThermalReading(_, act) => {
            act(&duals(own), &ROW, Dual::constant(ROW.temperature_difference_K), angle)
        }
        Action::TorqueReading(act) => act(&duals(own), Dual::constant(torque_Nm), angle),
        _ => panic!("{} acts elsewhere", spec.id),
    };
    shown.value
}

/// At neutral sizes, and whatever its shape, the effect does nothing to the last bit.
pub fn vanishes(spec: &Spec) {
    let own: Vec<f64> = spec.parameters.iter().map(|parameter| parameter.neutral).collect();
    match spec.action {
        Action::Spread => {}
        Action::Load(_) | Action::Friction(_) | Action::ThermalLoad(..) => {
            let load = load(spec, &own);
            let values = [load.torque_Nm.value, load.preload_N.value, load.spring_N_per_m.value];
            assert_eq!(values, [ROW.torque_Nm, ROW.preload_N, 0.0]);
            assert!(load.friction.iter().all(|friction| friction.limit_Nm(&load).value == 0.0));
        }
        Action::Torques(_) => {
            let run = [(0.0, -3.0), (5.0, 0.0), (60.0, 5.0)];
            assert!(torques(spec, &duals(&own), &run).iter().all(|torque| torque.value == 0.0));
        }
        // A gap is its size times a shape.
        Action::Gap(_) => assert!(spec.parameters.iter().all(|p| !p.is_size || p.neutral == 0.0)),
        Action::Contact(_) => {
            let contact = contact(spec, &own);
            assert_eq!(contact.stiffness_scale.value, 1.0);
            assert_eq!(contact.contact_angle_shift_rad.value, 0.0);
            assert_eq!(contact.exponent.value, 1.5);
            for torque_Nm in [-3.0, 0.0, 5.0] {
                assert!(contact.plays.iter().all(|own| backlash::turned(&values(own), torque_Nm)[0] == 0.0));
                let turned = |own| stiffness_curve::turned(&values(own), torque_Nm)[0];
                assert!(contact.curves.iter().all(|own| turned(own) == 0.0));
                let carried = |own| hard_stop::carried(torque_Nm, &values(own)).0;
                assert!(contact.stops.iter().all(|own| carried(own) == torque_Nm));
            }
        }
        Action::Series(_) => {
            for torque_Nm in [-3.0, 0.0, 5.0] {
                assert_eq!(series(spec, &own, torque_Nm), 0.0);
            }
        }
        Action::History(_) => {
            let run = [(0.0, -3.0), (5.0, 0.0), (60.0, 5.0)];
            assert!(history(spec, &own, &run).iter().all(|angle| *angle == 0.0));
        }
        Action::Reading(_) | Action::ThermalReading(..) | Action::TorqueReading(_) => {
            for angle_rad in [-3e-4, 0.0, 1e-5] {
                assert_eq!(reading(spec, &own, angle_rad), angle_rad);
            }
        }
        Action::Readings(act) => {
            let angles = duals(&[-3e-4, 0.0, 1e-5]);
            assert_eq!(act(&duals(&own), &[ROW; 3], &angles), angles);
        }
    }
}
