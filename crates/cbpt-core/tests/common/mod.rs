//! Random valid pairs and drives for the property tests.
#![allow(dead_code, missing_docs)]

use cbpt_core::drive::{
    CrossSlide, CrossSlideForm, CrossSlideShare, Deceleration, Drive, EqualSpeed, GrooveSection, Material,
    OutputPlate, RingGroove, TrackCurvature,
};
use cbpt_core::equilibrium::solve::{PairState, solve_pair};
use cbpt_core::equilibrium::{PairEquilibrium, ReadyPair};
use cbpt_core::pair::{MeshingPoints, cross_slide, deceleration, ring_groove};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;

/// The same cases in every run, so that a test cannot fail by chance; `PROPTEST_CASES=100000` draws more of them and
/// `PROPTEST_RNG_SEED=7` others.
pub fn config(cases: u32) -> ProptestConfig {
    let from_environment = ProptestConfig::default();
    let given = |name: &str| std::env::var_os(name).is_some();
    let cases = if given("PROPTEST_CASES") { from_environment.cases } else { cases };
    ProptestConfig {
        cases,
        max_global_rejects: 20 * cases,
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

/// A pair that can be set at any phase.
#[derive(Debug, Clone, Copy)]
pub enum Pair {
    Deceleration(Deceleration),
    /// With its ring radius e, m.
    RingGroove(RingGroove, f64),
    CrossSlide(CrossSlide),
}

impl Pair {
    pub fn at(&self, phase_rad: f64) -> MeshingPoints {
        let modulus = Material::default().contact_modulus_Pa();
        let exact = TrackCurvature::Exact;
        match self {
            Self::Deceleration(pair) => deceleration::meshing_points(pair, modulus, exact, phase_rad),
            Self::RingGroove(pair, e) => ring_groove::meshing_points(pair, *e, modulus, exact, phase_rad),
            Self::CrossSlide(pair) => cross_slide::meshing_points(pair, modulus, exact, 0.0),
        }
    }

    pub fn ball_count(&self) -> u32 {
        match self {
            Self::Deceleration(pair) => pair.ball_count,
            Self::RingGroove(pair, _) => pair.ball_count,
            Self::CrossSlide(pair) => pair.ball_count,
        }
    }
}

/// The meshing points of a pair at a phase; a failing test shows what they were made of.
#[derive(Clone)]
pub struct PairAtPhase {
    pub pair: Pair,
    pub phase_rad: f64,
    pub points: MeshingPoints,
}

impl std::ops::Deref for PairAtPhase {
    type Target = MeshingPoints;

    fn deref(&self) -> &MeshingPoints {
        &self.points
    }
}

impl std::fmt::Debug for PairAtPhase {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{:?} at phase {}", self.pair, self.phase_rad)
    }
}

/// Any pair at any phase that can hold a torque either way, missing walls included.
pub fn any_pair() -> impl Strategy<Value = PairAtPhase> {
    prop_oneof![
        (deceleration_pair(), -7.0..7.0_f64).prop_map(|(pair, phase)| (Pair::Deceleration(pair), phase)),
        (ring_groove_pair(), 0.2e-3..6e-3_f64, -7.0..7.0_f64)
            .prop_map(|(pair, e, phase)| (Pair::RingGroove(pair, e), phase)),
        cross_slide_pair().prop_map(|pair| (Pair::CrossSlide(pair), 0.0)),
    ]
    .prop_map(|(pair, phase_rad)| PairAtPhase { pair, phase_rad, points: pair.at(phase_rad) })
    .prop_filter("a pair that can hold a torque either way", |points| {
        points.holding_arm_m(1.0) > 0.0 && points.holding_arm_m(-1.0) > 0.0
    })
}

/// A whole drive without undercut, of any kind.
pub fn any_drive() -> impl Strategy<Value = Drive> {
    drive_with(200, 60)
}

/// A drive of so few balls that a whole period is soon sampled.
pub fn small_drive() -> impl Strategy<Value = Drive> {
    drive_with(12, 9)
}

fn drive_with(most_deceleration_balls: u32, most_equal_speed_balls: u32) -> impl Strategy<Value = Drive> {
    (deceleration_pair(), ring_groove_pair(), cross_slide_pair(), any::<bool>())
        .prop_map(move |(mut pair, mut ring, mut slide, crossed)| {
            pair.ball_count = 3 + (pair.ball_count - 3) % (most_deceleration_balls - 2);
            for count in [&mut ring.ball_count, &mut slide.ball_count] {
                *count = 3 + (*count - 3) % (most_equal_speed_balls - 2);
            }
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

/// Torque that a preload of 1 N holds at a crank angle, in the direction of `sign`, m.
pub fn drive_holding_arm_m(drive: &Drive, input_angle_rad: f64, sign: f64) -> f64 {
    let points = drive.points(input_angle_rad);
    let equal = points.equal_speed.iter().map(|row| row.holding_arm_m(sign) / points.equal_speed_share);
    equal.fold(points.deceleration.holding_arm_m(sign), f64::min)
}

/// Torque that is `share` of what the preload holds in its direction, N m.
pub fn torque_Nm(points: &MeshingPoints, preload_N: f64, share: f64) -> f64 {
    share * preload_N * points.holding_arm_m(share.signum())
}

/// A load that must be solved.
pub fn solved(points: &MeshingPoints, torque_Nm: f64, preload_N: f64) -> PairState {
    let (status, state) = solve_pair(points, torque_Nm, preload_N);
    state.unwrap_or_else(|| panic!("{torque_Nm} N m at {preload_N} N: {status}"))
}

/// The approach under the preload alone, m, if no point had an offset: what other displacements are measured by.
pub fn approach_scale_m(points: &MeshingPoints, preload_N: f64) -> f64 {
    let pair = ReadyPair::new(points);
    let equations = PairEquilibrium::new(&pair, 0.0, preload_N, None).unwrap();
    equations.state(&PairEquilibrium::start::<2>()).approach_m()
}

/// The approach under the preload alone, m, from which an axial spring is relaxed.
pub fn unloaded_approach_m(points: &MeshingPoints, preload_N: f64) -> f64 {
    solved(&MeshingPoints { axial_spring_N_per_m: 0.0, ..points.clone() }, 0.0, preload_N).state.approach_m()
}

/// What effects may do to a pair, in terms of the approach under the preload alone.
#[derive(Debug, Clone)]
pub struct Effects {
    /// Offsets of the diagonals, dealt out in turn.
    pub axial: Vec<f64>,
    pub normal: Vec<f64>,
    pub in_plane: Vec<f64>,
    pub exponent: f64,
    /// Stiffness of what holds the preload, in preloads per approach.
    pub spring: f64,
}

impl Effects {
    pub fn on(&self, points: &MeshingPoints, preload_N: f64) -> MeshingPoints {
        let mut changed = MeshingPoints { exponent: self.exponent, ..points.clone() };
        let approach = approach_scale_m(&changed, preload_N);
        changed.axial_spring_N_per_m = self.spring * preload_N / approach;
        for (index, point) in changed.points.iter_mut().enumerate() {
            let deal = |offsets: &[f64]| approach * offsets[index % offsets.len()];
            point.axial_offset_m = deal(&self.axial);
            point.normal_offset_m = deal(&self.normal);
            point.in_plane_offset_m = deal(&self.in_plane);
        }
        changed
    }

    /// The same offsets, smaller or larger.
    #[must_use]
    pub fn scaled(&self, factor: f64) -> Self {
        let scale = |offsets: &[f64]| offsets.iter().map(|offset| factor * offset).collect();
        Self {
            axial: scale(&self.axial),
            normal: scale(&self.normal),
            in_plane: scale(&self.in_plane),
            ..*self
        }
    }
}

/// Offsets of up to 3 approaches, exponents from 1.2 to 3, springs of up to 100 preloads per approach; each may be absent.
pub fn effects() -> impl Strategy<Value = Effects> {
    effects_up_to(3.0, 100.0)
}

/// Effects with offsets of up to `most_offset` approaches and springs of up to `most_spring` preloads per approach.
pub fn effects_up_to(most_offset: f64, most_spring: f64) -> impl Strategy<Value = Effects> {
    let size =
        |most: f64| prop_oneof![1 => Just(0.0), 3 => (-3.0..most.log10()).prop_map(|log| 10_f64.powf(log))];
    let offsets = move || {
        (proptest::collection::vec(-1.0..1.0_f64, 1..14), size(most_offset))
            .prop_map(|(shape, size)| shape.into_iter().map(|offset| size * offset).collect::<Vec<f64>>())
    };
    let exponent = prop_oneof![Just(1.5), 1.2..3.0_f64];
    (offsets(), offsets(), offsets(), exponent, size(most_spring)).prop_map(
        |(axial, normal, in_plane, exponent, spring)| Effects { axial, normal, in_plane, exponent, spring },
    )
}

/// Whether the preload alone leaves the output plate all but free play: large offsets may leave so few contacts that
/// next to nothing resists a small rotation.
pub fn is_loose(points: &MeshingPoints, preload_N: f64) -> bool {
    let unsprung = MeshingPoints { axial_spring_N_per_m: 0.0, ..points.clone() };
    let usual = preload_N * points.largest_arm_m().powi(2) / approach_scale_m(points, preload_N);
    let (_, state) = solve_pair(&unsprung, 0.0, preload_N);
    state.is_none_or(|state| state.torsional_stiffness_Nm_per_rad <= 1e-4 * usual)
}
