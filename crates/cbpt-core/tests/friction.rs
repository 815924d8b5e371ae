//! Friction: the values of an independent minimisation, a closed form, and properties.

use cbpt_core::friction::period::FrictionPeriod;
use cbpt_core::friction::spin::{Touch, least_dissipation};
use cbpt_core::sweep::Progress;
use cbpt_core::{CrossSlide, CrossSlideForm, CrossSlideShare, Drive, EqualSpeed, Load};
use proptest::prelude::*;
use std::f64::consts::FRAC_PI_4;

fn parts(torque_Nm: f64, preload_N: f64) -> [f64; 2] {
    let load = Load::new(torque_Nm, preload_N, 0.0).unwrap();
    let found = Drive::paper_base_case().friction(&load, 0.1).unwrap();
    [found.deceleration.unwrap().torque_Nm, found.equal_speed.unwrap().torque_Nm]
}

/// Origin: an independent minimisation, to about 0.5 %.
#[test]
fn values_of_an_independent_minimisation() {
    for (torque_Nm, preload_N, expected) in
        [(0.0, 600.0, [0.0680, 0.0179]), (5.0, 600.0, [0.0684, 0.0183]), (0.0, 300.0, [0.0305, 0.0071])]
    {
        for (found, expected) in parts(torque_Nm, preload_N).into_iter().zip(expected) {
            // Half a digit of the value stated is within the tolerance.
            assert!(
                (found - expected).abs() < 0.005 * expected + 5e-5,
                "{torque_Nm} {preload_N}: {found} {expected}"
            );
        }
    }
    let load = Load::new(5.0, 600.0, 0.0).unwrap();
    let found = Drive::paper_base_case().friction(&load, 0.1).unwrap();
    assert!((found.efficiency().unwrap() - 0.846).abs() < 5e-4);
}

/// A straight V-groove between two plates that move at +-u, four equal contacts: P = 4 mu Q kappa u cot(beta)/r.
#[test]
fn a_straight_v_groove_has_a_closed_form() {
    let (r, u, force_N, kappa) = (1.5e-3, 2e-3, 20.0, 4e-5);
    for beta in [0.4_f64, 0.7, 1.1] {
        let touches = [(1.0, 0), (-1.0, 0), (1.0, 1), (-1.0, 1)].map(|(across, side)| {
            let away = if side == 0 { 1.0 } else { -1.0 };
            Touch {
                normal: [across * away * beta.cos(), away * beta.sin()],
                track_speed_m: away * u,
                plate_turn: 0.3,
                force_N,
                pivoting_arm_m: kappa,
            }
        });
        let expected = 4.0 * force_N * kappa * u / beta.tan() / r;
        let found = least_dissipation(r, &touches);
        assert!((found.loss_Nm / expected - 1.0).abs() < 1e-12, "{} {expected}", found.loss_Nm);
        assert!(found.gap < 1e-12);
    }
}

/// A ball that one diagonal holds between plates that move alike rolls about it without loss.
#[test]
fn a_ball_on_one_diagonal_rolls_freely() {
    let touches = [(1.0, 2e-3), (-1.0, -2e-3)].map(|(side, track_speed_m)| Touch {
        normal: [side * 0.6, side * 0.8],
        track_speed_m,
        plate_turn: -0.9,
        force_N: 7.0,
        pivoting_arm_m: 5e-5,
    });
    let found = least_dissipation(1.5e-3, &touches);
    assert!(found.loss_Nm <= 0.0 && found.gap <= 0.0);
    assert!(least_dissipation(1.5e-3, &[]).loss_Nm <= 0.0);
}

/// Any four contacts of a ball between two plates, as few as one of them loaded.
fn touches() -> impl Strategy<Value = [Touch; 4]> {
    let speeds = prop::array::uniform2(-5e-3..5e-3);
    let turns = prop::array::uniform2(-3.0..3.0);
    let contact = (0.2..1.4_f64, 0.0..50.0_f64, 1e-5..2e-4_f64);
    (speeds, turns, prop::array::uniform4(contact)).prop_map(|(speeds, turns, contacts)| {
        std::array::from_fn(|place| {
            let (side, across) = (place / 2, if place % 2 == 0 { 1.0 } else { -1.0 });
            let (beta, force_N, pivoting_arm_m) = contacts[place];
            let away = if side == 0 { 1.0 } else { -1.0 };
            Touch {
                normal: [across * beta.cos(), away * beta.sin()],
                track_speed_m: speeds[side],
                plate_turn: turns[side],
                force_N,
                pivoting_arm_m,
            }
        })
    })
}

proptest! {
    /// The loss is that of the slips that are told, and no spin has less.
    #[test]
    fn the_loss_is_that_of_the_slips(touches in touches()) {
        let r = 1.5e-3;
        let found = least_dissipation(r, &touches);
        let lost = |touch: &Touch| touch.loss_Nm(touch.motion(r, found.spin));
        let lost_Nm = touches.iter().map(lost).sum::<f64>();
        prop_assert!((found.loss_Nm - lost_Nm).abs() <= 1e-9 * found.loss_Nm + 1e-15);
        prop_assert!(found.gap.abs() <= 1e-8, "{}", found.gap);
    }

    /// Who turns with the ball about the axis sees other turns, the same slips and the same loss.
    #[test]
    fn the_loss_does_not_depend_on_the_frame(touches in touches(), turn in -10.0..10.0_f64) {
        let r = 1.5e-3;
        let turned = touches.map(|touch| Touch { plate_turn: touch.plate_turn + turn, ..touch });
        let (here, there) = (least_dissipation(r, &touches), least_dissipation(r, &turned));
        prop_assert!((here.loss_Nm - there.loss_Nm).abs() <= 1e-9 * here.loss_Nm);
        for (touch, other) in touches.iter().zip(&turned) {
            let [slip_m, pivoting] = touch.motion(r, here.spin);
            let [other_m, other] = other.motion(r, [here.spin[0], here.spin[1] + turn]);
            prop_assert!((slip_m - other_m).abs() < 1e-14 && (pivoting - other).abs() < 1e-11);
        }
    }

    /// Everything turned the other way round slips the other way round.
    #[test]
    fn the_loss_does_not_depend_on_the_sense_of_rotation(touches in touches()) {
        let back = touches.map(|touch| Touch {
            track_speed_m: -touch.track_speed_m,
            plate_turn: -touch.plate_turn,
            ..touch
        });
        let (here, there) = (least_dissipation(1.5e-3, &touches), least_dissipation(1.5e-3, &back));
        prop_assert!((here.loss_Nm - there.loss_Nm).abs() <= 1e-12 * here.loss_Nm);
    }
}

#[test]
fn mean_lies_between_least_and_largest() {
    let drive = Drive::paper_base_case();
    let (status, found) = FrictionPeriod::new(&drive).at(5.0, 600.0, 0.1).unwrap();
    assert!(status.has_solution());
    let found = found.unwrap();
    let torque = found.torque;
    assert!(torque.least_Nm <= torque.mean_Nm && torque.mean_Nm <= torque.largest_Nm);
    // What the input gives is what the output takes and what is lost; 5 N m at a ratio of 10.5.
    let taken_Nm = 5.0 / 10.5;
    assert!((found.input_torque_Nm() / (taken_Nm + torque.mean_Nm) - 1.0).abs() < 1e-14);
    assert!((found.efficiency() * found.input_torque_Nm() / taken_Nm - 1.0).abs() < 1e-14);
}

/// Over a period one solution serves a balanced cross-slide at every angle; here each has its own.
#[test]
fn a_cross_slide_over_a_period_has_the_losses_of_its_angles() {
    let base = Drive::paper_base_case();
    let slide = EqualSpeed::CrossSlide(CrossSlide {
        ball_count: 15,
        pitch_radius_m: 40e-3,
        contact_angle_rad: 0.8,
        groove: base.deceleration().groove,
        form: CrossSlideForm::Balanced,
        share: CrossSlideShare::Carried,
    });
    let drive = Drive::new(*base.material(), *base.deceleration(), slide, base.track_curvature()).unwrap();
    let (_, found) = FrictionPeriod::new(&drive).at(5.0, 600.0, 0.1).unwrap();
    let over = found.unwrap().equal_speed.torque;
    let at = |angle: f64| {
        let load = Load::new(5.0, 600.0, angle).unwrap();
        drive.friction(&load, 0.1).unwrap().equal_speed.unwrap().torque_Nm
    };
    let angles = (0..100).map(|i| (f64::from(i) + 0.5) / 100.0 * FRAC_PI_4);
    let mean = angles.map(at).sum::<f64>() / 100.0;
    assert!((over.mean_Nm / mean - 1.0).abs() < 1e-4, "{} {mean}", over.mean_Nm);
    assert!((over.largest_Nm / at(FRAC_PI_4) - 1.0).abs() < 1e-3);
    assert!((over.least_Nm / at(0.0) - 1.0).abs() < 1e-9);
}

#[test]
fn a_coefficient_that_cannot_be_is_refused() {
    let load = Load::new(5.0, 600.0, 0.0).unwrap();
    for coefficient in [-0.1, 10.1, f64::NAN] {
        let error = Drive::paper_base_case().friction(&load, coefficient).unwrap_err();
        assert_eq!(error.field, "friction.coefficient");
    }
}

#[test]
fn many_loads_are_each_as_one() {
    let drive = Drive::paper_base_case();
    let period = FrictionPeriod::new(&drive);
    let loads = [[5.0, 600.0], [0.0, 300.0], [500.0, 1.0]];
    let found = period.map(&loads, 0.1, &Progress::default()).unwrap().unwrap();
    let one = |[torque_Nm, preload_N]: [f64; 2]| period.at(torque_Nm, preload_N, 0.1).unwrap();
    assert_eq!(format!("{found:?}"), format!("{:?}", loads.map(one)));
}
