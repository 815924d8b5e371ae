//! CBPT and the `levenberg-marquardt` crate behind the C ABI, for benches/peers.py. One thread unless it says so.
//!
//! Pairs are the deceleration pair of the base case at an input angle; everything is SI.
#![allow(non_snake_case)]

pub mod peer;

use std::time::Instant;

use cbpt_core::equilibrium::lanes::{BATCH, LaneOutcome, LanePair, two_thirds_powers};
use cbpt_core::equilibrium::solve::solve_pair;
use cbpt_core::hertz::HertzContact;
use cbpt_core::pair::MeshingPoints;
use cbpt_core::sweep::{Progress, Row, solve_each, solve_into};
use cbpt_core::{
    Deceleration, Drive, EqualSpeed, GrooveSection, Load, Material, RingGroove, Status, TrackCurvature,
};

/// # Safety
/// `values` points at `count` numbers, or `count` is 0.
unsafe fn read<'a>(values: *const f64, count: usize) -> &'a [f64] {
    unsafe { std::slice::from_raw_parts(values, count) }
}

/// # Safety
/// `values` points at `count` numbers that no one else uses, or `count` is 0.
unsafe fn write<'a>(values: *mut f64, count: usize) -> &'a mut [f64] {
    unsafe { std::slice::from_raw_parts_mut(values, count) }
}

pub fn points(input_angle_rad: f64) -> MeshingPoints {
    Drive::paper_base_case().points(input_angle_rad).deceleration
}

/// Arms (m, with the sign of the diagonal) and stiffnesses of the pair, as the peers need them; returns how many.
///
/// # Safety
/// Both point at room for 64 numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn pair_contacts(input_angle_rad: f64, arm_m: *mut f64, stiffness: *mut f64) -> usize {
    let points = points(input_angle_rad).points;
    let (arms, stiffnesses) = unsafe { (write(arm_m, 64), write(stiffness, 64)) };
    for (i, point) in points.iter().enumerate() {
        (arms[i], stiffnesses[i]) = (point.signed_arm_m(), point.stiffness);
    }
    points.len()
}

/// Torque that a preload of 1 N holds, m.
#[unsafe(no_mangle)]
pub extern "C" fn pair_holding_arm_m(input_angle_rad: f64) -> f64 {
    points(input_angle_rad).holding_arm_m(1.0)
}

/// Solves the pair for `count` loads with what `cbpt.solve_many` uses, preparation included; returns how many are solved.
///
/// # Safety
/// Four arrays of `count` numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cbpt_pair(
    input_angle_rad: f64,
    count: usize,
    torque_Nm: *const f64,
    preload_N: *const f64,
    rotation_rad: *mut f64,
    residual: *mut f64,
) -> usize {
    let (torque, preload) = unsafe { (read(torque_Nm, count), read(preload_N, count)) };
    let (rotation, residual) = unsafe { (write(rotation_rad, count), write(residual, count)) };
    solve_lanes(&points(input_angle_rad), torque, preload, rotation, residual)
}

pub fn solve_lanes(
    points: &MeshingPoints,
    torque: &[f64],
    preload: &[f64],
    rotation: &mut [f64],
    residual: &mut [f64],
) -> usize {
    let pair = LanePair::new(points, torque.len());
    let mut outcomes = [LaneOutcome::NONE; BATCH];
    let mut powers = [1.0; BATCH];
    let mut solved = 0;
    for first in (0..torque.len()).step_by(BATCH) {
        let some = first..(first + BATCH).min(torque.len());
        two_thirds_powers(&preload[some.clone()], &mut powers);
        pair.solve(&torque[some.clone()], &preload[some.clone()], &powers, &mut outcomes);
        for (place, outcome) in some.zip(&outcomes) {
            (rotation[place], residual[place]) = (outcome.rotation_rad, outcome.residual);
            solved += usize::from(outcome.status.has_solution());
        }
    }
    solved
}

/// The same with the scalar solver.
///
/// # Safety
/// As [`cbpt_pair`].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cbpt_pair_scalar(
    input_angle_rad: f64,
    count: usize,
    torque_Nm: *const f64,
    preload_N: *const f64,
    rotation_rad: *mut f64,
    residual: *mut f64,
) -> usize {
    let points = points(input_angle_rad);
    let (torque, preload) = unsafe { (read(torque_Nm, count), read(preload_N, count)) };
    let (rotation, residual) = unsafe { (write(rotation_rad, count), write(residual, count)) };
    let mut solved = 0;
    for i in 0..count {
        if let (_, Some(state)) = solve_pair(&points, torque[i], preload[i]) {
            (rotation[i], residual[i]) = (state.state.rotation_rad, state.residual);
            solved += 1;
        }
    }
    solved
}

/// The same with the crate `levenberg-marquardt` on the two equations.
///
/// # Safety
/// As [`cbpt_pair`].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn levenberg_marquardt_pair(
    input_angle_rad: f64,
    count: usize,
    torque_Nm: *const f64,
    preload_N: *const f64,
    rotation_rad: *mut f64,
    residual: *mut f64,
) -> usize {
    let points = points(input_angle_rad);
    let (torque, preload) = unsafe { (read(torque_Nm, count), read(preload_N, count)) };
    let (rotation, residual) = unsafe { (write(rotation_rad, count), write(residual, count)) };
    let pair = peer::Pair::new(&points);
    for i in 0..count {
        (rotation[i], residual[i]) = pair.solve(torque[i], preload[i]);
    }
    count
}

/// Stiffness of `count` contacts with one other curvature, by the exact solution.
///
/// # Safety
/// Two arrays of `count` numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cbpt_hertz(count: usize, along_per_m: *const f64, across_per_m: f64, stiffness: *mut f64) {
    let (along, stiffness) = unsafe { (read(along_per_m, count), write(stiffness, count)) };
    for (along, stiffness) in along.chunks(80).zip(stiffness.chunks_mut(80)) {
        for (contact, stiffness) in HertzContact::many(along, across_per_m, 1.1e11).iter().zip(stiffness) {
            *stiffness = contact.map_or(0.0, |contact| contact.stiffness());
        }
    }
}

/// The same one by one.
///
/// # Safety
/// As [`cbpt_hertz`].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cbpt_hertz_scalar(
    count: usize,
    along_per_m: *const f64,
    across_per_m: f64,
    stiffness: *mut f64,
) {
    let (along, stiffness) = unsafe { (read(along_per_m, count), write(stiffness, count)) };
    for (along, stiffness) in along.iter().zip(stiffness) {
        *stiffness = HertzContact::new(*along, across_per_m, 1.1e11).map_or(0.0, |contact| contact.stiffness());
    }
}

/// Drives of 20 and 14 balls with K, r0, contact angle and conformity as given in columns of `numbers`, each under its own
/// load with both pairs; the elastic angles (rad, NaN where a groove undercuts); returns how many are solved. `threads` of 0
/// uses all cores.
///
/// # Safety
/// `numbers` is 4 x `count`, the others `count`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cbpt_new_geometry(
    threads: usize,
    count: usize,
    numbers: *const f64,
    torque_Nm: *const f64,
    preload_N: *const f64,
    angle_rad: *mut f64,
) -> usize {
    let numbers = unsafe { read(numbers, 4 * count) };
    let (torque, preload) = unsafe { (read(torque_Nm, count), read(preload_N, count)) };
    let angles = unsafe { write(angle_rad, count) };
    let drives: Vec<Drive> = (0..count)
        .filter_map(|i| {
            let [k, r0, beta, conformity] = std::array::from_fn(|column| numbers[column * count + i]);
            drive(k, r0, beta, conformity)
        })
        .collect();
    let loads = loads(torque, preload);
    let mut rows = vec![NOT_SOLVED; count];
    in_threads(threads, || solve_each(&drives, &loads, &mut rows, &Progress::default()));
    for (angle, row) in angles.iter_mut().zip(&rows) {
        *angle = row.1.map_or(f64::NAN, |angles| angles.elastic_angle_rad());
    }
    rows.iter().filter(|row| row.1.is_some()).count()
}

const NOT_SOLVED: Row = (Status::Undercut, None);

fn drive(k: f64, r0: f64, beta: f64, conformity: f64) -> Option<Drive> {
    let groove = GrooveSection { ball_radius_m: 1.5e-3, groove_conformity: conformity, groove_depth_m: None };
    let base = Drive::paper_base_case();
    let deceleration = Deceleration {
        short_amplitude_coefficient: k,
        rolling_circle_radius_m: r0,
        contact_angle_rad: beta,
        groove,
        ..*base.deceleration()
    };
    let ring = RingGroove {
        ball_count: 14,
        pitch_radius_m: 40e-3,
        outside_contact_angle_rad: beta,
        inside_contact_angle_rad: beta,
        groove,
    };
    Drive::new(Material::default(), deceleration, EqualSpeed::RingGroove(ring), TrackCurvature::Exact).ok()
}

/// Both pairs of the base case for `count` loads at one input angle, on `threads` threads (0: all cores).
///
/// # Safety
/// Three arrays of `count` numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cbpt_drive(
    threads: usize,
    count: usize,
    torque_Nm: *const f64,
    preload_N: *const f64,
    angle_rad: *mut f64,
    seconds: *mut f64,
) -> usize {
    let (torque, preload) = unsafe { (read(torque_Nm, count), read(preload_N, count)) };
    let (angles, seconds) = unsafe { (write(angle_rad, count), write(seconds, 1)) };
    let loads = loads(torque, preload);
    let mut rows = vec![NOT_SOLVED; count];
    let drive = Drive::paper_base_case();
    in_threads(threads, || {
        let start = Instant::now();
        let done = solve_into(&drive, &loads, &mut rows, &Progress::default());
        seconds[0] = start.elapsed().as_secs_f64();
        done
    });
    for (angle, row) in angles.iter_mut().zip(&rows) {
        *angle = row.1.map_or(f64::NAN, |angles| angles.elastic_angle_rad());
    }
    rows.iter().filter(|row| row.1.is_some()).count()
}

fn loads(torque: &[f64], preload: &[f64]) -> Vec<Load> {
    torque.iter().zip(preload).filter_map(|(torque, preload)| Load::new(*torque, *preload, 0.1).ok()).collect()
}

fn in_threads(threads: usize, work: impl FnOnce() -> bool + Send) {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    pool.map(|pool| pool.install(work)).ok();
}
