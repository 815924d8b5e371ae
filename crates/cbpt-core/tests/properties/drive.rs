//! The whole drive, and its largest angle.

use std::f64::consts::TAU;

use cbpt_core::drive::{CrossSlide, CrossSlideForm, CrossSlideShare, EqualSpeed};
use cbpt_core::pair::MeshingPoints;
use cbpt_core::sweep::Progress;
use cbpt_core::{Angles, Drive, Elasticity, Load, Material, Status, TrackCurvature};
use proptest::prelude::*;

use crate::common::{any_drive, approach_scale_m, preload_N, small_drive, solved};
use crate::input::Numbers;
use crate::{SAME, close, common, share};

/// A drive, a preload, a crank angle and a torque that is a share of what holds there.
fn loaded_drive() -> impl Strategy<Value = (Drive, f64, f64, f64)> {
    (any_drive(), preload_N(), -7.0..7.0_f64, share()).prop_map(|(drive, preload, angle, share)| {
        let torque = share * preload * common::drive_holding_arm_m(&drive, angle, share.signum());
        (drive, torque, preload, angle)
    })
}

fn angles(drive: &Drive, torque_Nm: f64, preload_N: f64, angle_rad: f64) -> Angles {
    let (status, angles) = drive.angles(&Load::new(torque_Nm, preload_N, angle_rad).unwrap());
    angles.unwrap_or_else(|| panic!("{status}"))
}

/// What the approach under the preload alone makes of the smaller pair's arm, rad.
fn drive_angle_scale(drive: &Drive, preload_N: f64, angle_rad: f64) -> f64 {
    let points = drive.points(angle_rad);
    let of = |points: &MeshingPoints| approach_scale_m(points, preload_N) / points.largest_arm_m();
    points.equal_speed.iter().map(of).fold(of(&points.deceleration), f64::max)
}

proptest! {
    #![proptest_config(common::config(300))]

    /// `alpha_d` = alpha1 + alpha2, `alpha_s` = alpha1(M0) + Z1/Z3 alpha3(M0 Z1/Z3): the parts are those of the pairs
    /// alone, they do the same work as the whole, and their compliances add.
    #[test]
    fn the_parts_add_up((drive, torque, preload, angle) in loaded_drive()) {
        let solution = drive.solve(&Load::new(torque, preload, angle).unwrap());
        let (Some(whole), Some(first), Some(second)) =
            (solution.angles, solution.deceleration, solution.equal_speed)
        else {
            panic!("{}", solution.status)
        };
        let share = match drive.equal_speed() {
            EqualSpeed::RingGroove(_) => 1.0,
            EqualSpeed::CrossSlide(_) => {
                let balls = f64::from(drive.deceleration().ball_count);
                (balls - 1.0) / (balls + 1.0)
            }
        };
        let phase = drive.deceleration_phase_rad(angle);
        let alone = solved(&drive.deceleration_points(phase), torque, preload);
        close(first.rotation_rad, alone.state.rotation_rad, 0.0, "deceleration alone")?;
        let row = &drive.equal_speed_points(drive.equal_speed_phase_rad(angle), angle)[0];
        let alone = solved(row, share * torque, preload);
        let rows = if share < 1.0 { 2.0 } else { 1.0 };
        close(second.rotation_rad, rows * alone.state.rotation_rad, 0.0, "equal-speed alone")?;
        close(second.torque_Nm, share * torque, 0.0, "torque of the equal-speed pair")?;
        let scale = drive_angle_scale(&drive, preload, angle).max(whole.elastic_angle_rad().abs());
        close(whole.deceleration_rad, first.rotation_rad, 0.0, "deceleration")?;
        close(whole.equal_speed_rad, share * second.rotation_rad, 1e-14 * scale, "equal-speed")?;
        close(whole.elastic_angle_rad(), whole.deceleration_rad + whole.equal_speed_rad, 0.0, "sum")?;
        let work = torque * first.rotation_rad + second.torque_Nm * second.rotation_rad;
        close(torque * whole.elastic_angle_rad(), work, 1e-13 * scale * torque.abs(), "work")?;
        let compliance = 1.0 / first.torsional_stiffness_Nm_per_rad
            + share * share / second.torsional_stiffness_Nm_per_rad;
        let stiffness = solution.torsional_stiffness_Nm_per_rad.unwrap();
        close(stiffness * compliance, 1.0, 1e-13, "compliance")?;
        close(whole.residual, first.residual.max(second.residual), 0.0, "residual")?;
    }

    /// The 2017 paper's cross-slide, kept to compare: the whole torque and the whole angle; and, in its form, arms shifted
    /// by e cos(theta) in one row and e sin(theta) in the other, with no balance across.
    #[test]
    fn the_papers_cross_slide_is_what_it_says((drive, torque, preload, angle) in loaded_drive()) {
        let EqualSpeed::CrossSlide(slide) = *drive.equal_speed() else { return Ok(()) };
        let other = |form, share| {
            let slide = EqualSpeed::CrossSlide(CrossSlide { form, share, ..slide });
            let pair = *drive.deceleration();
            Drive::new(*drive.material(), pair, slide, TrackCurvature::Exact).unwrap()
        };
        let load = Load::new(torque, preload, angle).unwrap();
        let row = drive.points(angle).equal_speed.remove(0);
        if let (_, Some(found)) = other(CrossSlideForm::Balanced, CrossSlideShare::Paper).angles(&load) {
            let alone = 2.0 * solved(&row, torque, preload).state.rotation_rad;
            close(found.equal_speed_rad, alone, 0.0, "share")?;
        }
        if let (_, Some(found)) = other(CrossSlideForm::Paper, CrossSlideShare::Carried).angles(&load) {
            let share = drive.equal_speed_share();
            let e = drive.deceleration().eccentricity_m();
            let shifted = |shift: f64| {
                let mut held = MeshingPoints { floats_sideways: false, rows: 1, ..row.clone() };
                held.points.iter_mut().for_each(|point| point.arm_m += shift);
                solved(&held, share * torque, preload).state.rotation_rad
            };
            let both = share * (shifted(e * angle.cos()) + shifted(e * angle.sin()));
            let scale = both.abs().max(drive_angle_scale(&drive, preload, angle));
            close(found.equal_speed_rad, both, 1e-13 * scale, "form")?;
        }
    }

    /// The stiffness of the drive is the slope of torque over its angle.
    #[test]
    fn the_stiffness_of_the_drive_is_the_slope((drive, torque, preload, angle) in loaded_drive()) {
        let limit = |sign| preload * common::drive_holding_arm_m(&drive, angle, sign);
        prop_assume!(torque.abs() < 0.9 * limit(torque.signum()));
        let step = 1e-7 * limit(1.0).min(limit(-1.0));
        let alpha = |torque| angles(&drive, torque, preload, angle).elastic_angle_rad();
        let slope = 2.0 * step / (alpha(torque + step) - alpha(torque - step));
        let solution = drive.solve(&Load::new(torque, preload, angle).unwrap());
        close(solution.torsional_stiffness_Nm_per_rad.unwrap(), slope, 1e-3 * slope, "stiffness")?;
    }

    /// Turned the other way, crank and torque, a drive gives the opposite angle; a cross-slide gives the same at every
    /// angle of the crank.
    #[test]
    fn the_drive_mirrors((drive, torque, preload, angle) in loaded_drive(), other in -7.0..7.0_f64) {
        let here = angles(&drive, torque, preload, angle);
        let image = angles(&drive, -torque, preload, -angle);
        let scale = drive_angle_scale(&drive, preload, angle).max(here.elastic_angle_rad().abs());
        close(image.deceleration_rad, -here.deceleration_rad, SAME * scale, "deceleration")?;
        close(image.equal_speed_rad, -here.equal_speed_rad, SAME * scale, "equal-speed")?;
        if matches!(drive.equal_speed(), EqualSpeed::CrossSlide(_)) {
            let (_, elsewhere) = drive.angles(&Load::new(torque, preload, other).unwrap());
            if let Some(elsewhere) = elsewhere {
                close(elsewhere.equal_speed_rad, here.equal_speed_rad, 0.0, "cross-slide")?;
            }
        }
    }

    /// Each pair repeats when the crank has moved its balls by one place: the deceleration pair after 2 pi/Z1 with the
    /// hypocycloid plate as output (2 pi/Z3 with the epicycloid plate), ring grooves after 2 pi Z3/(Z1 Zd)
    /// (2 pi Z1/(Z3 Zd)).
    #[test]
    fn the_pairs_repeat_with_the_crank((drive, torque, preload, angle) in loaded_drive()) {
        let here = angles(&drive, torque, preload, angle);
        let scale = drive_angle_scale(&drive, preload, angle).max(here.elastic_angle_rad().abs());
        let pair = drive.deceleration();
        let (z1, z3) = (f64::from(pair.ball_count) - 1.0, f64::from(pair.ball_count) + 1.0);
        let (own, other) = if drive.transmission_ratio() > 0.0 { (z1, z3) } else { (z3, z1) };
        // Ring grooves may not hold everywhere, so each pair is solved by itself.
        let first = drive.points(angle + TAU / own).deceleration;
        close(solved(&first, torque, preload).state.rotation_rad, here.deceleration_rad, SAME * scale, "first")?;
        if let EqualSpeed::RingGroove(ring) = drive.equal_speed() {
            let period = TAU * other / (own * f64::from(ring.ball_count));
            let second = &drive.points(angle - period).equal_speed[0];
            close(solved(second, torque, preload).state.rotation_rad, here.equal_speed_rad, SAME * scale, "second")?;
        }
    }

    /// Similar drives: alpha goes with E*^(-2/3) at the same loads, and with L^(-4/3) for all lengths L times as large
    /// at the same preload and L times the torque, so that the stresses fall and the state keeps its shape.
    #[test]
    fn similar_drives_scale(
        (drive, torque, preload, angle) in loaded_drive(),
        modulus in 0.05..20.0_f64,
        length in 0.05..20.0_f64,
    ) {
        let here = angles(&drive, torque, preload, angle);
        let scale = drive_angle_scale(&drive, preload, angle).max(here.elastic_angle_rad().abs());
        let material = Material {
            ball: Elasticity { youngs_modulus_Pa: 208e9 * modulus, ..Elasticity::BEARING_STEEL },
            plate: Elasticity { youngs_modulus_Pa: 208e9 * modulus, ..Elasticity::BEARING_STEEL },
            ..Material::default()
        };
        let other = Drive::new(material, *drive.deceleration(), *drive.equal_speed(), TrackCurvature::Exact);
        let other = angles(&other.unwrap(), torque, preload, angle);
        let factor = modulus.powf(2.0 / 3.0);
        close(other.deceleration_rad * factor, here.deceleration_rad, SAME * scale, "modulus, first")?;
        close(other.equal_speed_rad * factor, here.equal_speed_rad, SAME * scale, "modulus, second")?;

        let mut first = *drive.deceleration();
        first.rolling_circle_radius_m *= length;
        first.groove.ball_radius_m *= length;
        let second = match *drive.equal_speed() {
            EqualSpeed::RingGroove(mut ring) => {
                ring.pitch_radius_m *= length;
                ring.groove.ball_radius_m *= length;
                EqualSpeed::RingGroove(ring)
            }
            EqualSpeed::CrossSlide(mut slide) => {
                slide.pitch_radius_m *= length;
                slide.groove.ball_radius_m *= length;
                EqualSpeed::CrossSlide(slide)
            }
        };
        let other = Drive::new(Material::default(), first, second, TrackCurvature::Exact).unwrap();
        let other = angles(&other, torque * length, preload, angle);
        let factor = length.powf(4.0 / 3.0);
        close(other.deceleration_rad * factor, here.deceleration_rad, SAME * scale, "length, first")?;
        close(other.equal_speed_rad * factor, here.equal_speed_rad, SAME * scale, "length, second")?;
    }
}

proptest! {
    #![proptest_config(common::config(60))]

    /// The largest elastic angle is reached at the angle that is named, no angle exceeds it, and the drive repeats after
    /// its period.
    #[test]
    fn the_largest_angle_is_the_largest(
        drive in small_drive(),
        preload in preload_N(),
        share in prop_oneof![0.02..0.95_f64, -0.95..-0.02_f64],
        places in proptest::collection::vec(0.0..1.0_f64, 30),
    ) {
        let hold = drive.preload_thresholds(share.signum()).drive().hold_N;
        let torque = share * preload / hold;
        let (status, largest) = drive.largest_elastic_angle(torque, preload).unwrap();
        let Some(largest) = largest else { panic!("{status}") };
        let alpha = |angle| angles(&drive, torque, preload, angle).elastic_angle_rad();
        let most = largest.elastic_angle_rad * torque.signum();
        prop_assert!(most > 0.0);
        close(alpha(largest.input_angle_rad), largest.elastic_angle_rad, SAME * most, "where it is")?;
        prop_assert!((0.0..largest.period_rad).contains(&largest.input_angle_rad));
        let mut least = most;
        for place in places {
            let angle = place * largest.period_rad;
            let here = alpha(angle) * torque.signum();
            prop_assert!(here <= most + 1e-3 * largest.amplitude_rad + SAME * most, "{here} at {angle}, {most}");
            close(alpha(angle + largest.period_rad) * torque.signum(), here, SAME * most, "period")?;
            least = least.min(here);
        }
        prop_assert!(most - least <= 1.01 * largest.amplitude_rad + SAME * most);
    }

    /// The largest elastic angle of the drive rises with the torque and falls with the preload. (Not for a torque next to
    /// nothing: the preload alone turns a plate whose few balls stand on unlike walls by a trace, and more with more.)
    #[test]
    fn the_largest_angle_falls_with_the_preload_and_rises_with_the_torque(
        drive in small_drive(),
        preload in preload_N(),
        share in prop_oneof![0.25..0.95_f64, -0.95..-0.25_f64],
        more in 1.001..20.0_f64,
    ) {
        let hold = drive.preload_thresholds(share.signum()).drive().hold_N;
        let torque = share * preload / hold;
        let largest = |torque: f64, preload: f64| {
            let (status, largest) = drive.largest_elastic_angle(torque, preload).unwrap();
            largest.unwrap_or_else(|| panic!("{status}")).elastic_angle_rad.abs()
        };
        let here = largest(torque, preload);
        prop_assert!(largest(torque, preload * more) < here);
        prop_assert!(largest(torque / more, preload) < here);
    }
}

/// Refining the place of the maximum ends however small the step is against the place itself: with 100 and 61 balls the
/// drive repeats after 6161 places of its balls, and the largest angle lies far out.
#[test]
fn the_largest_angle_of_many_balls_is_found() {
    let mut numbers = Numbers::of_the_base_case();
    numbers.deceleration.ball_count = 100;
    numbers.ring.ball_count = 61;
    numbers.ring.pitch_radius_m = 0.2;
    let [drive, _] = numbers.drives();
    let (sender, receiver) = std::sync::mpsc::channel();
    std::thread::spawn(move || sender.send(drive.unwrap().largest_elastic_angle(1.0, 600.0)));
    let found = receiver.recv_timeout(std::time::Duration::from_secs(60)).expect("the search ends");
    let (status, largest) = found.unwrap();
    assert_eq!(status, Status::Solved);
    assert!(largest.unwrap().elastic_angle_rad > 0.0);
}

/// Cancelled, the search is over at once, however many balls there are.
#[test]
fn the_search_for_the_largest_angle_can_be_cancelled() {
    let mut numbers = Numbers::of_the_base_case();
    (numbers.deceleration.ball_count, numbers.ring.ball_count) = (1000, 999);
    numbers.ring.pitch_radius_m = 3.0;
    let [drive, _] = numbers.drives();
    let drive = drive.unwrap();
    let progress = Progress::default();
    let found = std::thread::scope(|scope| {
        let search = scope.spawn(|| drive.largest_elastic_angle_watched(1.0, 600.0, &progress));
        std::thread::sleep(std::time::Duration::from_millis(20));
        progress.cancel();
        search.join().unwrap()
    });
    assert_eq!(found.unwrap().1, None);
}
