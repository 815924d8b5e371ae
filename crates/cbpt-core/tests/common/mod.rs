//! Random valid pairs and drives for the property tests.
#![allow(dead_code, missing_docs)]

use cbpt_core::drive::{
    CrossSlide, CrossSlideForm, CrossSlideShare, Deceleration, Drive, EqualSpeed, GrooveSection, Material,
    OutputPlate, RingGroove, TrackCurvature,
};
use cbpt_core::pair::{MeshingPoints, cross_slide, deceleration, ring_groove};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;

/// The same cases in every run, so that a test cannot fail by chance; `PROPTEST_CASES=100000` draws more of them and
/// `PROPTEST_RNG_SEED=7` others.
pub fn config(cases: u32) -> ProptestConfig {
    let from_environment = ProptestConfig::default();
    let given = |name: &str| std::env::var_os(name).is_some();
    ProptestConfig {
        cases: if given("PROPTEST_CASES") { from_environment.cases } else { cases },
        rng_seed: if given("PROPTEST_RNG_SEED") { from_environment.rng_seed } else { RngSeed::Fixed(1) },
        ..from_environment
    }
}

/// 1e-3 to 1e6 N, even in the logarithm.
pub fn preload_N() -> impl Strategy<Value = f64> {
    (-3.0..6.0_f64).prop_map(|exponent| 10_f64.powf(exponent))
}

pub fn groove() -> impl Strategy<Value = GrooveSection> {
    (0.3e-3..4e-3_f64, 1.01..1.3_f64).prop_map(|(ball_radius_m, groove_conformity)| GrooveSection {
        ball_radius_m,
        groove_conformity,
        groove_depth_m: None,
    })
}

pub fn contact_angle_rad() -> impl Strategy<Value = f64> {
    (20.0..70.0_f64).prop_map(f64::to_radians)
}

pub fn output_plate() -> impl Strategy<Value = OutputPlate> {
    prop_oneof![Just(OutputPlate::Hypocycloid), Just(OutputPlate::Epicycloid)]
}

/// Any deceleration pair; its grooves may undercut.
pub fn deceleration_pair() -> impl Strategy<Value = Deceleration> {
    (3..=200_u32, 0.05..0.95_f64, 0.5e-3..8e-3_f64, contact_angle_rad(), groove(), output_plate()).prop_map(
        |(ball_count, k, r0, contact_angle_rad, groove, output_plate)| Deceleration {
            ball_count,
            short_amplitude_coefficient: k,
            rolling_circle_radius_m: r0,
            contact_angle_rad,
            groove,
            output_plate,
        },
    )
}

pub fn ring_groove_pair() -> impl Strategy<Value = RingGroove> {
    (3..=60_u32, 10e-3..80e-3_f64, contact_angle_rad(), contact_angle_rad(), any::<bool>(), groove())
        .prop_map(|(ball_count, pitch_radius_m, outside, inside, unlike, groove)| RingGroove {
            ball_count,
            pitch_radius_m,
            outside_contact_angle_rad: outside,
            inside_contact_angle_rad: if unlike { inside } else { outside },
            groove,
        })
}

pub fn cross_slide_pair() -> impl Strategy<Value = CrossSlide> {
    (3..=60_u32, 10e-3..80e-3_f64, contact_angle_rad(), groove()).prop_map(
        |(ball_count, pitch_radius_m, contact_angle_rad, groove)| CrossSlide {
            ball_count,
            pitch_radius_m,
            contact_angle_rad,
            groove,
            form: CrossSlideForm::Balanced,
            share: CrossSlideShare::Carried,
        },
    )
}

/// Meshing points of any pair at any phase, missing walls included.
pub fn any_pair() -> impl Strategy<Value = MeshingPoints> {
    let modulus = Material::default().contact_modulus_Pa();
    let exact = TrackCurvature::Exact;
    prop_oneof![
        (deceleration_pair(), -7.0..7.0_f64)
            .prop_map(move |(pair, phase)| deceleration::meshing_points(&pair, modulus, exact, phase)),
        (ring_groove_pair(), 0.2e-3..6e-3_f64, -7.0..7.0_f64)
            .prop_map(move |(pair, e, phase)| ring_groove::meshing_points(&pair, e, modulus, exact, phase)),
        cross_slide_pair().prop_map(move |pair| cross_slide::meshing_points(&pair, modulus, exact, 0.0)),
    ]
    .prop_filter("a pair that can hold a torque either way", |points| {
        points.holding_arm_m(1.0) > 0.0 && points.holding_arm_m(-1.0) > 0.0
    })
}

/// A whole drive without undercut, of any kind.
pub fn any_drive() -> impl Strategy<Value = Drive> {
    (deceleration_pair(), ring_groove_pair(), cross_slide_pair(), any::<bool>())
        .prop_map(|(mut pair, ring, slide, crossed)| {
            if crossed {
                pair.output_plate = OutputPlate::Hypocycloid;
            }
            let equal = if crossed { EqualSpeed::CrossSlide(slide) } else { EqualSpeed::RingGroove(ring) };
            Drive::new(Material::default(), pair, equal, TrackCurvature::Exact).unwrap()
        })
        .prop_filter("no undercut", |drive| {
            drive.findings(None).iter().all(|finding| finding.code != "undercut")
        })
}
