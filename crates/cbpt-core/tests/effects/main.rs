//! A drive with effects on a campaign: the limit where effects vanish, contributions, the scaling law, the loop of friction,
//! independence of what was asked before, `again` of which solver is at work too; `sensitivities` against differences; `order`:
//! what goes by time.
#![allow(clippy::unwrap_used, clippy::panic, clippy::float_cmp)]

mod again;
mod order;
mod sensitivities;

use cbpt_core::drive::{
    CrossSlide, CrossSlideForm, CrossSlideShare, Deceleration, Drive, EqualSpeed, GrooveSection, Load,
    Material, OutputPlate, RingGroove, TrackCurvature,
};
use cbpt_core::effect::{LIBRARY, Scale};
use cbpt_core::predict::loads::{Effects, solve_load, solve_loads};
use cbpt_core::predict::{Columns, Effect, Predictor, Rows};
use cbpt_core::sweep::Progress;
use cbpt_core::{InvalidInput, Status};

const ARCSEC: f64 = std::f64::consts::PI / 648_000.0;
const GROOVE: GrooveSection =
    GrooveSection { ball_radius_m: 1.2e-3, groove_conformity: 1.08, groove_depth_m: None };
const BETA: f64 = std::f64::consts::FRAC_PI_4;

fn drive(output_plate: OutputPlate, equal_speed: EqualSpeed) -> Drive {
    let deceleration = Deceleration {
        ball_count: 12,
        short_amplitude_coefficient: 0.5,
        rolling_circle_radius_m: 4e-3,
        contact_angle_rad: BETA,
        groove: GROOVE,
        output_plate,
    };
    Drive::new(Material::default(), deceleration, equal_speed, TrackCurvature::Exact).unwrap()
}

fn rings(outside_deg: f64) -> EqualSpeed {
    EqualSpeed::RingGroove(RingGroove {
        ball_count: 10,
        pitch_radius_m: 35e-3,
        outside_contact_angle_rad: outside_deg.to_radians(),
        inside_contact_angle_rad: BETA,
        groove: GROOVE,
    })
}

/// An odd number of balls, so that the floating plate shifts sideways.
fn slide(form: CrossSlideForm) -> EqualSpeed {
    EqualSpeed::CrossSlide(CrossSlide {
        ball_count: 9,
        pitch_radius_m: 35e-3,
        contact_angle_rad: BETA,
        groove: GROOVE,
        form,
        share: CrossSlideShare::Carried,
    })
}

/// Both kinds of equal-speed pair, both outputs, unlike angles, the paper's form with its two rows.
fn drives() -> [(&'static str, Drive); 4] {
    [
        ("rings", drive(OutputPlate::Hypocycloid, rings(45.0))),
        ("epicycloid output, unlike angles", drive(OutputPlate::Epicycloid, rings(50.0))),
        ("slide", drive(OutputPlate::Hypocycloid, slide(CrossSlideForm::Balanced))),
        ("slide as in the paper", drive(OutputPlate::Hypocycloid, slide(CrossSlideForm::Paper))),
    ]
}

/// Torques of a run as shares of the largest: up, down, to the other side and back.
const SHARES: [f64; 14] =
    [0.0, 0.21, 0.43, 0.66, 0.93, 0.71, 0.38, 0.12, -0.27, -0.58, -0.87, -0.33, 0.11, 0.52];

#[derive(Clone)]
struct Campaign {
    run: Vec<i64>,
    time_s: Vec<f64>,
    torque_Nm: Vec<f64>,
    preload_N: Vec<f64>,
    input_angle_rad: Vec<f64>,
    temperature_K: Vec<f64>,
    cycle: Vec<f64>,
}

impl Campaign {
    fn rows(&self) -> Result<Rows, InvalidInput> {
        Rows::new(Columns {
            run: &self.run,
            time_s: &self.time_s,
            torque_Nm: &self.torque_Nm,
            preload_N: Some(&self.preload_N),
            input_angle_rad: &self.input_angle_rad,
            temperature_K: Some(&self.temperature_K),
            cycle: Some(&self.cycle),
        })
    }
}

/// Three runs at two preloads, the last with a crank angle of its own at every reading, whose readings alternate with
/// those of the second.
fn campaign() -> Campaign {
    let mut readings = Vec::new();
    for (run, preload, angle) in [(1_i64, 420.0, 0.3), (2, 800.0, 1.9), (3, 560.0, 4.0)] {
        for (i, share) in SHARES.iter().enumerate() {
            let time = i as f64 * 7.0 + 10.0;
            let angle = if run == 3 { angle + 0.1 * i as f64 } else { angle };
            readings.push((
                run,
                time,
                share * 5.5e-3 * preload,
                preload,
                angle,
                293.0 + 0.01 * time * run as f64,
            ));
        }
    }
    let half = 2 * SHARES.len();
    let alternating = (0..SHARES.len()).flat_map(|i| [readings[SHARES.len() + i], readings[half + i]]);
    let mixed: Vec<_> = readings[..SHARES.len()].iter().copied().chain(alternating).collect();
    Campaign {
        run: mixed.iter().map(|row| row.0).collect(),
        time_s: mixed.iter().map(|row| row.1).collect(),
        torque_Nm: mixed.iter().map(|row| row.2).collect(),
        preload_N: mixed.iter().map(|row| row.3).collect(),
        input_angle_rad: mixed.iter().map(|row| row.4).collect(),
        temperature_K: mixed.iter().map(|row| row.5).collect(),
        // The first run is the first cycle, all others follow.
        cycle: mixed.iter().map(|row| row.0 as f64).collect(),
    }
}

fn all_ids() -> Vec<&'static str> {
    LIBRARY.iter().filter(|spec| spec.suits_ball_drives()).map(|spec| spec.id).collect()
}

fn predictor(drive: &Drive, ids: &[&str]) -> Predictor {
    Predictor::new(drive.clone(), ids, campaign().rows().unwrap()).unwrap()
}

/// Effects of the library by their ids.
fn library(ids: &[&str]) -> Vec<Effect> {
    ids.iter().map(|id| Effect::Library(cbpt_core::effect::find(id).unwrap())).collect()
}

/// A size of each parameter that shows in readings; its scale for differences too.
#[allow(clippy::match_same_arms)] // one line a quantity
fn typical(id: &str, name: &str) -> f64 {
    match (id, name) {
        ("output_torsion", "compliance_rad_per_Nm") | (_, "shift_rad_per_Nm") => 2e-6,
        (_, "asymmetry" | "taken_share" | "breakaway_share" | "growth_exponent") => 0.3,
        (_, "starts_moving") => 1.0,
        (_, "preload_exponent") => 0.5,
        (_, "stiffening_per_Nm" | "first_share") => 0.2,
        (_, "stop_torque_Nm") => 2.9,
        ("creep", "compliance_rad_per_Nm") => 3e-7,
        (_, "superposed_compliance_rad_per_Nm" | "power_compliance_rad_per_Nm") => 2e-7,
        (_, "stiffness_scale") => 0.8,
        (_, "contact_angle_shift_rad" | "lag_s" | "half_width_Nm") => 0.02,
        (_, "torque_gain") => 1.05,
        (_, "zero_error_Nm") => 0.03,
        (_, "zero_drift_Nm_per_s") => 2e-4,
        (_, "preload_gain") => 0.95,
        (_, "sensor_gain") => 1.1,
        (_, "quadratic_per_rad" | "warm_up_time_s") => 300.0,
        (_, time) if time.ends_with("ing_time_s") => 300.0,
        (_, "cubic_per_rad2") => 1e6,
        (_, "flattening_rad") => 8.0 * ARCSEC,
        (_, "knee_rad") => 40.0 * ARCSEC,
        (_, "spread_rad" | "half_width_rad" | "fixture_play_rad") => ARCSEC,
        (_, "rate_rad_per_s") => 1e-8,
        (_, "rate_rad_per_K") => 1e-6,
        (_, "rate_per_s") => 2e-5,
        (_, "rate_per_K") => 1e-3,
        (_, "crosstalk_force_N") => 30.0,
        ("preload_crosstalk", "reference_torque_Nm") => 4.5,
        (_, "reference_deflection_m" | "clearance_m") => 1.5e-6,
        ("eccentric_bearing", "exponent") | (_, "build_up_exponent" | "slowing_exponent") => 0.8,
        (_, "friction_radius_m") => 4e-4,
        (_, "friction_torque_Nm") => 0.1,
        (_, "load_share" | "relaxing_lost_share") => 0.05,
        (_, "engagement_angle_rad" | "warm_up_rad") => 6.0 * ARCSEC,
        (_, "lost_share" | "crosstalk_share" | "slowing_lost_share" | "seated_lost_share") => 0.1,
        (_, "lost_force_N") => 20.0,
        (_, "spring_rate_N_per_m") => 1e7,
        (_, "rate_N_per_K") => 5.0,
        (_, "offset_sine_m" | "planet_offset_cosine_m") => 1e-6,
        (_, "offset_cosine_m" | "planet_offset_sine_m") => -7e-7,
        (_, "harmonic" | "ball") => 3.0,
        (_, "cosine_m" | "sine_m" | "oversize_m") => 4e-7,
        (_, "planet_cosine_m" | "planet_sine_m") => 2e-7,
        (_, "tilt_cosine_rad" | "tilt_sine_rad") => 1.5e-5,
        (_, "housing_tilt_cosine_rad" | "housing_tilt_sine_rad") => 8e-6,
        (_, "fixed_plate_tilt_cosine_rad" | "output_plate_tilt_sine_rad") => 6e-6,
        (_, "fixed_plate_tilt_sine_rad" | "output_plate_tilt_cosine_rad") => -9e-6,
        (_, "transition_torque_Nm" | "opening_torque_Nm" | "holding_torque_Nm") => 0.7,
        ("rough_contact", "exponent") => 1.6,
        (_, "permanent_set_rad" | "permanent_set_of_run_rad" | "settled_rad") => 5.0 * ARCSEC,
        (_, "settling_cycles") => 2.0,
        (_, "lost_share_per_s") => 5e-4,
        (_, "time_constant_s") => 30.0,
        (_, "slip_angle_rad") => 6.0 * ARCSEC,
        (_, "slip_exponent") => -0.4,
        (_, "weakening_ratio") => 4.0,
        (_, "reference_rate_rad_per_s") => 1e-6,
        _ => panic!("a new parameter, {name} of {id}, wants a typical value"),
    }
}

fn typical_values(predictor: &Predictor) -> Vec<f64> {
    let id = |slot: &cbpt_core::predict::Slot| predictor.effects()[slot.effect].id().to_owned();
    predictor.parameters().iter().map(|slot| typical(&id(slot), &slot.parameter.name())).collect()
}

/// Parameters that are fitted.
fn fitted(predictor: &Predictor) -> Vec<usize> {
    let fitted = |place: &usize| predictor.parameters()[*place].parameter.scale() != Scale::Fixed;
    (0..predictor.parameters().len()).filter(fitted).collect()
}

/// At neutral values the angles are those of the bare drive: without any effect to the last bit the same, and those of a
/// single solve to the tolerance of the equations.
#[test]
fn without_size_all_effects_vanish() {
    for (label, drive) in drives() {
        let mut with = predictor(&drive, &all_ids());
        let neutral = with.neutral();
        let with = with.predict(&neutral, &[]).unwrap();
        let bare = predictor(&drive, &[]).predict(&[], &[]).unwrap();
        assert_eq!(with, bare, "{label}");
        let campaign = campaign();
        for (row, angle) in bare.angle_rad.iter().enumerate() {
            let load =
                Load::new(campaign.torque_Nm[row], campaign.preload_N[row], campaign.input_angle_rad[row]);
            let single = drive.solve(&load.unwrap()).elastic_angle_rad().unwrap();
            assert!(
                (angle - single).abs() <= 1e-12 * single.abs() + 1e-18,
                "{label} {row}: {angle} {single}"
            );
        }
    }
}

#[test]
fn contributions_are_named_and_add_up() {
    let (_, drive) = &drives()[0];
    let ids = ["sensor_gain", "creep", "preload_loss", "creep", "plate_tilt", "rough_contact"];
    let mut predictor = predictor(drive, &ids);
    let values = typical_values(&predictor);
    let parts = predictor.contributions(&values).unwrap();
    let names: Vec<&str> = parts.iter().map(|part| part.name.as_str()).collect();
    let in_port_order =
        ["model", "preload_loss", "plate_tilt", "rough_contact", "creep", "creep#2", "sensor_gain"];
    assert_eq!(names, in_port_order);
    let angle = predictor.predict(&values, &[]).unwrap().angle_rad;
    let bare = Predictor::new(drive.clone(), &[""; 0], campaign().rows().unwrap())
        .unwrap()
        .predict(&[], &[])
        .unwrap();
    for (row, angle) in angle.iter().enumerate() {
        let sum: f64 = parts.iter().map(|part| part.angle_rad[row]).sum();
        assert!((sum - angle).abs() <= 1e-15 * angle.abs().max(1e-6), "{sum} {angle}");
        assert!((parts[0].angle_rad[row] - bare.angle_rad[row]).abs() <= 1e-16);
    }
}

/// alpha = k^(-2/3) N^(2/3) f(M/N): a scale s on the stiffness multiplies every angle by s^(-2/3), equal gains of torque and
/// preload by g^(2/3).
#[test]
fn angles_scale_with_stiffness_and_load() {
    for (label, drive) in drives() {
        let mut predictor = predictor(&drive, &["contact_stiffness", "torque_scale", "preload_scale"]);
        let base = predictor.predict(&[1.0; 3], &[]).unwrap().angle_rad;
        let softer = predictor.predict(&[0.6, 1.0, 1.0], &[]).unwrap().angle_rad;
        let heavier = predictor.predict(&[1.0, 1.3, 1.3], &[]).unwrap().angle_rad;
        for row in 0..base.len() {
            let close = |found: f64, factor: f64| {
                let error = (found - factor * base[row]).abs();
                assert!(error <= 1e-12 * base[row].abs() + 1e-17, "{label} {row}: {found}");
            };
            close(softer[row], 0.6_f64.powf(-2.0 / 3.0));
            close(heavier[row], 1.3_f64.powf(2.0 / 3.0));
        }
    }
}

/// Angle at a torque on the way up less that on the way down.
fn loop_width(preload_N: f64) -> f64 {
    let torque_Nm: Vec<f64> =
        (0..=40).map(|i| if i <= 20 { f64::from(i) } else { f64::from(40 - i) } * 0.1).collect();
    let count = torque_Nm.len();
    let rows = Rows::new(Columns {
        run: &vec![1; count],
        time_s: &vec![0.0; count],
        torque_Nm: &torque_Nm,
        preload_N: Some(&vec![preload_N; count]),
        input_angle_rad: &vec![0.3; count],
        temperature_K: None,
        cycle: None,
    });
    let mut predictor =
        Predictor::new(drives()[0].1.clone(), &["friction_hysteresis"], rows.unwrap()).unwrap();
    let angle = predictor.predict(&[4e-4, 0.2 * ARCSEC, 0.0, 0.0, 1.0], &[]).unwrap().angle_rad;
    let bare = predictor.predict(&[0.0, 0.2 * ARCSEC, 0.0, 0.0, 1.0], &[]).unwrap().angle_rad;
    assert!(angle[10] < bare[10] && angle[30] > bare[30], "virgin loading reads stiffer, unloading lags");
    angle[30] - angle[10]
}

/// The loop is as wide as the friction torque, which goes with the preload, times the compliance, which falls with its
/// cube root.
#[test]
fn the_loop_widens_with_the_preload() {
    let widths = [300.0, 600.0, 1200.0].map(loop_width);
    for pair in widths.windows(2) {
        assert!(pair[1] > 1.4 * pair[0] && pair[1] < 1.8 * pair[0], "{widths:?}");
    }
}

/// The same readings in runs of their own start unloaded each; a reading's history is that of its own run, wherever its
/// rows stand in the table.
#[test]
fn history_is_per_run() {
    let (_, drive) = &drives()[0];
    let ids = ["friction_hysteresis", "creep"];
    let values = [4e-4, 6.0 * ARCSEC, 0.0, 0.0, 1.0, 0.0, 30.0, 3e-7, 2e-7, 0.3];
    let mixed = campaign();
    let together = predictor(drive, &ids).predict(&values, &[]).unwrap().angle_rad;
    for run in [1, 2, 3] {
        let places: Vec<usize> = (0..mixed.run.len()).filter(|i| mixed.run[*i] == run).collect();
        let pick = |column: &[f64]| places.iter().map(|i| column[*i]).collect::<Vec<f64>>();
        let alone = Campaign {
            run: vec![7; places.len()],
            time_s: pick(&mixed.time_s),
            torque_Nm: pick(&mixed.torque_Nm),
            preload_N: pick(&mixed.preload_N),
            input_angle_rad: pick(&mixed.input_angle_rad),
            temperature_K: pick(&mixed.temperature_K),
            cycle: pick(&mixed.cycle),
        };
        let mut predictor = Predictor::new(drive.clone(), &ids, alone.rows().unwrap()).unwrap();
        let alone = predictor.predict(&values, &[]).unwrap().angle_rad;
        for (found, place) in alone.iter().zip(&places) {
            assert!((found - together[*place]).abs() <= 1e-14, "{found} {}", together[*place]);
        }
    }
}

/// Friction's own equation, checked from outside: what the friction holds back is Tf by Dahl along the angles found.
#[test]
fn friction_satisfies_its_equation() {
    let (_, drive) = &drives()[2];
    let (radius, engagement) = (4e-4, 6.0 * ARCSEC);
    let mut with = predictor(drive, &["friction_hysteresis"]);
    let angle = with.predict(&[radius, engagement, 0.0, 0.0, 1.0], &[]).unwrap().angle_rad;
    let campaign = campaign();
    let (mut before, mut z) = (f64::NAN, 0.0_f64);
    for row in (0..angle.len()).filter(|row| campaign.run[*row] == 2) {
        let (preload, theta) = (campaign.preload_N[row], campaign.input_angle_rad[row]);
        if before.is_nan() {
            before = drive.angles(&Load::new(0.0, preload, theta).unwrap()).1.unwrap().elastic_angle_rad();
        }
        let way = angle[row] - before;
        let sense = way.signum();
        z = sense - (sense - z) * (-way.abs() / engagement).exp();
        let mesh_torque = campaign.torque_Nm[row] - radius * preload * z;
        let load = Load::new(mesh_torque, preload, theta).unwrap();
        let expected = drive.angles(&load).1.unwrap().elastic_angle_rad();
        assert!(
            (angle[row] - expected).abs() <= 1e-11 * expected.abs() + 1e-16,
            "{row}: {} {expected}",
            angle[row]
        );
        before = angle[row];
    }
}

/// Angles and sensitivities do not depend on what was asked before.
#[test]
fn answers_do_not_depend_on_earlier_calls() {
    for (label, drive) in drives() {
        let mut fresh = predictor(&drive, &all_ids());
        let values = typical_values(&fresh);
        let wanted = fitted(&fresh);
        let fresh = fresh.predict(&values, &wanted).unwrap();
        let mut used = predictor(&drive, &all_ids());
        let neutral = used.neutral();
        used.predict(&neutral, &[]).unwrap();
        let halfway: Vec<f64> = neutral
            .iter()
            .zip(&values)
            .zip(used.parameters())
            .map(|((a, b), slot)| if slot.parameter.scale() == Scale::Fixed { *a } else { 0.5 * (a + b) })
            .collect();
        used.predict(&halfway, &wanted).unwrap();
        let used = used.predict(&values, &wanted).unwrap();
        for (fresh, used) in fresh.angle_rad.iter().zip(&used.angle_rad) {
            assert!((fresh - used).abs() <= 1e-10 * fresh.abs(), "{label}: {fresh} {used}");
        }
        for column in 0..wanted.len() {
            let of =
                |all: &[f64]| all.iter().skip(column).step_by(wanted.len()).copied().collect::<Vec<f64>>();
            let (fresh, used) = (of(&fresh.sensitivities), of(&used.sensitivities));
            let size = fresh.iter().fold(0.0, |size: f64, fresh| size.max(fresh.abs()));
            for (fresh, used) in fresh.iter().zip(used) {
                assert!((fresh - used).abs() <= 1e-8 * size, "{label} {column}: {fresh} {used}");
            }
        }
    }
}

/// Readings that the preload cannot hold are told, and the others go on as if these were not there.
#[test]
fn rows_without_solution_are_told_and_skipped() {
    let (_, drive) = &drives()[0];
    let whole = campaign();
    let mut heavy = campaign();
    heavy.torque_Nm[4] = 50.0;
    let mut without = campaign();
    let columns = [
        &mut without.time_s,
        &mut without.torque_Nm,
        &mut without.preload_N,
        &mut without.input_angle_rad,
        &mut without.temperature_K,
        &mut without.cycle,
    ];
    for column in columns {
        column.remove(4);
    }
    without.run.remove(4);
    for values in [[0.0, 6.0 * ARCSEC, 0.0, 0.0, 1.0], [4e-4, 6.0 * ARCSEC, 0.0, 0.0, 1.0]] {
        let predict = |campaign: &Campaign| {
            let rows = campaign.rows().unwrap();
            let mut predictor = Predictor::new(drive.clone(), &["friction_hysteresis"], rows).unwrap();
            predictor.predict(&values, &[0]).unwrap()
        };
        let (heavy, without) = (predict(&heavy), predict(&without));
        assert!(matches!(heavy.status[4], Status::BeyondHold { hold_preload_N } if hold_preload_N > 420.0));
        assert!(heavy.angle_rad[4].is_nan() && heavy.sensitivities[4].is_nan());
        let others = (0..whole.run.len()).filter(|row| *row != 4);
        for (row, expected) in others.zip(&without.angle_rad) {
            assert!((heavy.angle_rad[row] - expected).abs() <= 1e-14, "{row}");
        }
    }
}

/// An effect that leaves no preload: told is the preload that would hold at the contacts, as without the effect.
#[test]
fn without_preload_it_is_told_what_would_hold() {
    let values = [0.0, 1e4]; // its force exceeds every preload of the campaign
    for (label, drive) in drives() {
        let campaign = campaign();
        let mut predictor =
            Predictor::new(drive.clone(), &["preload_loss"], campaign.rows().unwrap()).unwrap();
        let found = predictor.predict(&values, &[]).unwrap();
        for (row, status) in found.status.iter().enumerate() {
            let (torque_Nm, angle_rad) = (campaign.torque_Nm[row], campaign.input_angle_rad[row]);
            let expected = drive.preload_thresholds_at(torque_Nm, angle_rad).drive().hold_N;
            let Status::BeyondHold { hold_preload_N } = *status else { panic!("{label} {row}: {status}") };
            assert!(
                (hold_preload_N - expected).abs() <= 1e-9 * expected,
                "{label} {row}: {hold_preload_N} {expected}"
            );
        }
    }
}

#[test]
fn an_undercut_drive_has_no_row() {
    let (_, drive) = &drives()[0];
    let sharp = Deceleration { short_amplitude_coefficient: 0.9, ..*drive.deceleration() };
    let drive = Drive::new(*drive.material(), sharp, *drive.equal_speed(), TrackCurvature::Exact).unwrap();
    let found = predictor(&drive, &["creep"]).predict(&[0.0, 20.0, 0.0, 0.0, 0.3], &[0]).unwrap();
    assert!(found.status.iter().all(|status| *status == Status::Undercut));
    assert!(found.angle_rad.iter().chain(&found.sensitivities).all(|value| value.is_nan()));
}

/// A single load is a run of one reading, loaded from rest: alone in full, or one of many, or as a table of its own.
#[test]
fn a_load_is_a_run_of_one_reading() {
    for (label, drive) in drives() {
        let ids = all_ids();
        let values = typical_values(&predictor(&drive, &ids));
        let effects = Effects { effects: &library(&ids), values: &values };
        let campaign = campaign();
        let loads: Vec<Load> = (0..campaign.run.len())
            .map(|i| {
                Load::new(campaign.torque_Nm[i], campaign.preload_N[i], campaign.input_angle_rad[i]).unwrap()
            })
            .collect();
        let many = solve_loads(&drive, effects, &loads, &Progress::default()).unwrap().unwrap();
        for (load, outcome) in loads.iter().zip(&many).step_by(5) {
            let detail = solve_load(&drive, effects, load).unwrap();
            let table = Rows::new(Columns {
                run: &[1],
                time_s: &[50.0],
                torque_Nm: &[load.torque_Nm()],
                preload_N: Some(&[load.preload_N()]),
                input_angle_rad: &[load.input_angle_rad()],
                temperature_K: Some(&[300.0]),
                cycle: None,
            });
            let alone =
                Predictor::new(drive.clone(), &ids, table.unwrap()).unwrap().predict(&values, &[]).unwrap();
            let close = |a: f64, b: f64| {
                assert!((a - b).abs() <= 1e-10 * b.abs() + 1e-16, "{label} at {load:?}: {a} {b}");
            };
            close(outcome.angle_rad, alone.angle_rad[0]);
            close(detail.angle_rad.unwrap(), alone.angle_rad[0]);
            close(detail.contributions.iter().map(|part| part.angle_rad[0]).sum(), alone.angle_rad[0]);
            let (mesh, angles) = (outcome.mesh.unwrap(), detail.solution.angles.unwrap());
            close(mesh.deceleration_rad, angles.deceleration_rad);
            close(mesh.equal_speed_rad, angles.equal_speed_rad);
            assert_eq!((detail.solution.load, detail.solution.status), (*load, outcome.status));
        }
    }
}

fn message<T>(result: Result<T, InvalidInput>) -> String {
    match result {
        Ok(_) => panic!("must be refused"),
        Err(error) => error.to_string(),
    }
}

#[test]
fn numbers_that_cannot_be_are_named() {
    let (_, drive) = &drives()[0];
    let mut table = campaign();
    table.preload_N[3] = 0.0;
    assert!(message(table.rows()).starts_with("preload_N[3] = 0"));
    let mut table = campaign();
    table.time_s[2] = -1.0;
    assert!(message(table.rows()).starts_with("time_s[2] = -1: must not be earlier"));
    let mut table = campaign();
    table.torque_Nm.pop();
    assert!(message(table.rows()).starts_with("torque_Nm = 41 entries"));
    let rows = campaign().rows().unwrap();
    let unknown = message(Predictor::new(drive.clone(), &["crep"], rows));
    assert!(unknown.starts_with("effects[0] = crep: must be one of contact_stiffness"), "{unknown}");
    let mut predictor = predictor(drive, &["ball_diameter_lot", "thermal_preload"]);
    let mut refused = |values: &[f64], wanted: &[usize]| message(predictor.predict(values, wanted));
    assert!(refused(&[0.0, 0.0], &[]).starts_with("values = 2 entries"));
    assert!(refused(&[12.0, 0.0, 0.0, 0.0], &[]).contains("ball of ball_diameter_lot"));
    assert!(refused(&[0.5, 0.0, 0.0, 0.0], &[]).contains("whole number"));
    assert!(refused(&[0.0, f64::NAN, 0.0, 0.0], &[]).contains("oversize_m"));
    assert!(refused(&[0.0, 0.0, 1e9, 0.0], &[]).contains("must lie between"));
    assert!(refused(&[0.0, 0.0, 0.0, 0.0], &[4]).starts_with("wanted[0] = 4"));
    assert!(refused(&[0.0, 0.0, 0.0, 0.0], &[0]).contains("no derivative"));
}
