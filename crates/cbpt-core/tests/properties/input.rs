//! Input that cannot be.

use cbpt_core::drive::{
    CrossSlide, CrossSlideForm, CrossSlideShare, Deceleration, EqualSpeed, OutputPlate, RingGroove,
};
use cbpt_core::{Drive, InvalidInput, Load, Material, TrackCurvature};
use proptest::prelude::*;

use crate::common;

/// The numbers of a drive, to be changed one by one.
pub struct Numbers {
    pub material: Material,
    pub deceleration: Deceleration,
    pub ring: RingGroove,
    pub slide: CrossSlide,
}

impl Numbers {
    pub fn of_the_base_case() -> Self {
        let drive = Drive::paper_base_case();
        let EqualSpeed::RingGroove(ring) = *drive.equal_speed() else { panic!("ring grooves") };
        Self {
            material: *drive.material(),
            deceleration: *drive.deceleration(),
            ring,
            slide: CrossSlide {
                ball_count: 16,
                pitch_radius_m: ring.pitch_radius_m,
                contact_angle_rad: ring.inside_contact_angle_rad,
                groove: ring.groove,
                form: CrossSlideForm::Balanced,
                share: CrossSlideShare::Carried,
            },
        }
    }

    fn drive(&self, equal: EqualSpeed) -> Result<Drive, InvalidInput> {
        Drive::new(self.material, self.deceleration, equal, TrackCurvature::Exact)
    }

    pub fn drives(&self) -> [Result<Drive, InvalidInput>; 2] {
        [EqualSpeed::RingGroove(self.ring), EqualSpeed::CrossSlide(self.slide)].map(|equal| self.drive(equal))
    }
}

type Field = fn(&mut Numbers) -> &mut f64;

/// Every number of a drive by its name; those of the first list must be above 0, those of the others lie between limits.
const POSITIVE: [(&str, Field); 10] = [
    ("material.ball_youngs_modulus_Pa", |n| &mut n.material.ball.youngs_modulus_Pa),
    ("material.plate_youngs_modulus_Pa", |n| &mut n.material.plate.youngs_modulus_Pa),
    ("material.pressure_limit_Pa", |n| &mut n.material.pressure_limit_Pa),
    ("deceleration.rolling_circle_radius_m", |n| &mut n.deceleration.rolling_circle_radius_m),
    ("deceleration.ball_radius_m", |n| &mut n.deceleration.groove.ball_radius_m),
    ("deceleration.groove_depth_m", |n| n.deceleration.groove.groove_depth_m.get_or_insert(1e-3)),
    ("equal_speed.pitch_radius_m", |n| &mut n.ring.pitch_radius_m),
    ("equal_speed.ball_radius_m", |n| &mut n.ring.groove.ball_radius_m),
    ("equal_speed.groove_depth_m", |n| n.ring.groove.groove_depth_m.get_or_insert(1e-3)),
    ("equal_speed.pitch_radius_m", |n| &mut n.slide.pitch_radius_m),
];
const POISSONS_RATIOS: [(&str, Field); 2] = [
    ("material.ball_poissons_ratio", |n| &mut n.material.ball.poissons_ratio),
    ("material.plate_poissons_ratio", |n| &mut n.material.plate.poissons_ratio),
];
const CONTACT_ANGLES: [(&str, Field); 4] = [
    ("deceleration.contact_angle_rad", |n| &mut n.deceleration.contact_angle_rad),
    ("equal_speed.outside_contact_angle_rad", |n| &mut n.ring.outside_contact_angle_rad),
    ("equal_speed.inside_contact_angle_rad", |n| &mut n.ring.inside_contact_angle_rad),
    ("equal_speed.contact_angle_rad", |n| &mut n.slide.contact_angle_rad),
];
const CONFORMITIES: [(&str, Field); 2] = [
    ("deceleration.groove_conformity", |n| &mut n.deceleration.groove.groove_conformity),
    ("equal_speed.groove_conformity", |n| &mut n.ring.groove.groove_conformity),
];
const SHORT_AMPLITUDE: [(&str, Field); 1] =
    [("deceleration.short_amplitude_coefficient", |n| &mut n.deceleration.short_amplitude_coefficient)];

/// A number that cannot be is refused by its name, with what was found and what is required.
#[test]
fn each_number_that_cannot_be_is_refused_by_name() {
    let never = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY];
    let check = |fields: &[(&str, Field)], bad: &[f64]| {
        for (name, field) in fields {
            for value in bad.iter().chain(&never) {
                let mut numbers = Numbers::of_the_base_case();
                *field(&mut numbers) = *value;
                let refused = numbers.drives().into_iter().find_map(Result::err);
                let refused = refused.unwrap_or_else(|| panic!("{name} = {value} was accepted"));
                assert_eq!(refused.field, *name);
                assert_eq!(refused.found, value.to_string());
                assert!(refused.required.starts_with("must"), "{}", refused.required);
            }
        }
    };
    check(&POSITIVE, &[0.0, -0.0, -1e-3]);
    check(&POISSONS_RATIOS, &[0.5, -1.0, 0.7]);
    check(&CONTACT_ANGLES, &[0.0, -0.1, std::f64::consts::FRAC_PI_2, 45.0]);
    check(&CONFORMITIES, &[1.0, 0.9, 0.0, -1.08]);
    check(&SHORT_AMPLITUDE, &[0.0, 1.0, -0.5, 1.5]);
    for count in [0, 1, 2, 1001, u32::MAX] {
        let mut numbers = Numbers::of_the_base_case();
        numbers.deceleration.ball_count = count;
        assert_eq!(numbers.drives()[0].clone().unwrap_err().field, "deceleration.ball_count");
        let mut numbers = Numbers::of_the_base_case();
        (numbers.ring.ball_count, numbers.slide.ball_count) = (count, count);
        for refused in numbers.drives() {
            assert_eq!(refused.unwrap_err().field, "equal_speed.ball_count");
        }
    }
    assert!(Numbers::of_the_base_case().drives().iter().all(Result::is_ok));
}

/// A cross-slide holds the planet, so it goes with the hypocycloid plate as output alone.
#[test]
fn a_cross_slide_needs_the_hypocycloid_plate_as_output() {
    let mut numbers = Numbers::of_the_base_case();
    numbers.deceleration.output_plate = OutputPlate::Epicycloid;
    let [ring, slide] = numbers.drives();
    assert!(ring.is_ok());
    assert_eq!(slide.unwrap_err().field, "deceleration.output_plate");
}

#[test]
fn a_load_that_cannot_be_is_refused_by_name() {
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        assert_eq!(Load::new(bad, 600.0, 0.0).unwrap_err().field, "torque_Nm");
        assert_eq!(Load::new(5.0, 600.0, bad).unwrap_err().field, "input_angle_rad");
        let drive = Drive::paper_base_case();
        assert_eq!(drive.largest_elastic_angle(bad, 600.0).unwrap_err().field, "torque_Nm");
        assert_eq!(drive.largest_elastic_angle(5.0, bad).unwrap_err().field, "preload_N");
    }
    for bad in [0.0, -0.0, -600.0, f64::NAN, f64::INFINITY] {
        let refused = Load::new(5.0, bad, 0.0).unwrap_err();
        assert_eq!((refused.field.as_str(), refused.found), ("preload_N", bad.to_string()));
    }
}

/// Any number at all, and more often than by chance one that passes.
fn any_number() -> impl Strategy<Value = f64> {
    prop_oneof![
        1 => prop::num::f64::ANY,
        3 => (-300.0..300.0_f64).prop_map(|exponent| 10_f64.powf(exponent)),
        6 => 0.01..1.5_f64,
        6 => 1e-4..1e-2_f64,
    ]
}

proptest! {
    #![proptest_config(common::config(3000))]

    /// Whatever the numbers, there is no panic: the drive is refused, or a load has a status, or its numbers are finite.
    #[test]
    fn no_number_makes_a_panic(
        changes in proptest::collection::vec((0..19_usize, any_number()), 0..4),
        balls in (3..12_u32, 3..9_u32),
        crossed in any::<bool>(),
        load in (any_number(), any_number(), any_number()),
    ) {
        let mut numbers = Numbers::of_the_base_case();
        (numbers.deceleration.ball_count, numbers.ring.ball_count) = balls;
        let fields = POSITIVE.iter().chain(&POISSONS_RATIOS).chain(&CONTACT_ANGLES);
        let fields: Vec<_> = fields.chain(&CONFORMITIES).chain(&SHORT_AMPLITUDE).collect();
        for (which, value) in changes {
            *fields[which].1(&mut numbers) = value;
        }
        let [ring, slide] = numbers.drives();
        let Ok(drive) = (if crossed { slide } else { ring }) else { return Ok(()) };
        drive.findings(None);
        let Ok(load) = Load::new(load.0, load.1, load.2) else { return Ok(()) };
        drive.findings(Some(&load));
        drive.preload_thresholds_at(load.torque_Nm(), load.input_angle_rad());
        let solution = drive.solve(&load);
        prop_assert_eq!(solution.angles.is_some(), solution.status.has_solution());
        if let (Some(angles), Some(stiffness)) = (solution.angles, solution.torsional_stiffness_Nm_per_rad) {
            prop_assert!(angles.elastic_angle_rad().is_finite() && stiffness > 0.0, "{solution:?}");
            prop_assert!(angles.residual <= 1e-11);
        }
    }
}
