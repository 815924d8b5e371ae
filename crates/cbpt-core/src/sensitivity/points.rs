//! Meshing points in dual numbers: how arms, contact angles and stiffnesses answer to the design numbers.
//!
//! Values are those of the meshing points themselves; the partials follow from the same formulas
//! ([`on_tracks`], [`meusnier_per_m`], [`across_of_per_m`]) and from the slopes of Hertz's stiffness. A diagonal is two
//! contacts in series, so each contact's slope counts with its share of the compliance.

use std::f64::consts::TAU;

use crate::design::Design;
use crate::design::{
    BALL, DECELERATION_ANGLE, DECELERATION_GROOVE, DesignNumber, EQUAL_SPEED_ANGLES, EQUAL_SPEED_GROOVE,
    INPUT_ANGLE, PITCH_RADIUS, PLACES, PLATE, ROLLING_CIRCLE, SHORT_AMPLITUDE,
};
use crate::drive::{
    CrossSlide, CrossSlideForm, Drive, EqualSpeed, OutputPlate, TrackCurvature, contact_modulus_Pa,
};
use crate::effect::dual::Dual;
use crate::geometry::trochoid::on_tracks;
use crate::geometry::wall::{across_of_per_m, meusnier_per_m};
use crate::pair::{Diagonal, MeshingPoint, MeshingPoints};
use crate::preload::{Ray, Row};
use crate::real::Real;

/// Every open number of a design, those that are asked about seeded with a partial.
#[derive(Debug, Clone, Copy)]
pub struct Seeded(pub [Dual; PLACES]);

impl Seeded {
    pub fn new(design: &Design, numbers: &[&DesignNumber]) -> Self {
        let mut seeded = design.values.map(Dual::constant);
        for (slot, number) in numbers.iter().enumerate() {
            for &place in number.places {
                seeded[place].partials[slot] = 1.0;
            }
        }
        Self(seeded)
    }

    fn pick<const N: usize>(&self, places: [usize; N]) -> [Dual; N] {
        places.map(|place| self.0[place])
    }

    fn modulus_Pa(&self) -> Dual {
        contact_modulus_Pa(self.pick(BALL), self.pick(PLATE))
    }

    fn eccentricity_m(&self) -> Dual {
        self.0[SHORT_AMPLITUDE] * self.0[ROLLING_CIRCLE]
    }
}

/// A wall's contact: what it is made of.
struct Walls {
    radius_m: Dual,
    conformity: Dual,
    modulus_Pa: Dual,
    track: TrackCurvature,
}

impl Walls {
    fn new(drive: &Drive, seeded: &Seeded, groove: [usize; 2]) -> Self {
        let [radius_m, conformity] = seeded.pick(groove);
        Self { radius_m, conformity, modulus_Pa: seeded.modulus_Pa(), track: drive.track_curvature() }
    }

    /// A diagonal between walls that see the track curved so; `None` where it does not exist.
    fn ray(
        &self,
        point: &MeshingPoint,
        arm_m: Dual,
        angle_rad: Dual,
        curvatures_per_m: &[Dual; 2],
    ) -> Option<Ray<Dual>> {
        let (sin_beta, cos_beta) = angle_rad.sin_cos();
        let across = across_of_per_m(self.radius_m, self.conformity);
        let (mut compliance, mut log_stiffness) = (0.0, Dual::constant(0.0));
        for (wall, curvature) in point.walls.iter().zip(curvatures_per_m) {
            let contact = wall.as_ref()?;
            let along = match self.track {
                TrackCurvature::Exact => meusnier_per_m(self.radius_m, *curvature, cos_beta),
                TrackCurvature::Neglect => self.radius_m.recip(),
            };
            let share = contact.compliance;
            compliance += share;
            for (varied, other) in [(along, across), (across, along)] {
                let slope = contact.stiffness_slope(varied.value, other.value);
                log_stiffness.add_slope(share * slope / varied.value, &varied);
            }
        }
        let mut stiffness = log_stiffness.chain(point.stiffness, point.stiffness / compliance);
        stiffness.add_slope(point.stiffness / self.modulus_Pa.value, &self.modulus_Pa);
        Some(Ray { sign: point.diagonal.sign(), arm_m, sin_beta, cos_beta, stiffness })
    }
}

/// The rays of points, in their order, those that exist.
fn row(
    points: &MeshingPoints,
    torque_sign: f64,
    ray: impl Fn(&MeshingPoint) -> Option<Ray<Dual>>,
) -> Row<Dual> {
    Row {
        rays: points.points.iter().filter_map(ray).collect(),
        torque_sign,
        exponent: points.exponent,
        floats_sideways: points.floats_sideways,
    }
}

/// The deceleration pair at a phase.
pub fn deceleration(
    drive: &Drive,
    seeded: &Seeded,
    phase_rad: Dual,
    torque_sign: f64,
) -> (MeshingPoints, Row<Dual>) {
    let pair = drive.deceleration();
    let points = drive.deceleration_points(phase_rad.value);
    let walls = Walls::new(drive, seeded, DECELERATION_GROOVE);
    let [k, r0, angle] = seeded.pick([SHORT_AMPLITUDE, ROLLING_CIRCLE, DECELERATION_ANGLE]);
    let ray = |point: &MeshingPoint| {
        let phi = phase_rad + TAU * point.ball as f64 / f64::from(pair.ball_count);
        let ball = on_tracks(pair.ball_count, pair.output_lobes(), k, r0, phi);
        let way = match pair.output_plate {
            OutputPlate::Hypocycloid => point.diagonal.sign(),
            OutputPlate::Epicycloid => -point.diagonal.sign(),
        };
        let curvatures = [ball.epicycloid_curvature_per_m * way, ball.hypocycloid_curvature_per_m * -way];
        walls.ray(point, ball.arm_m, angle, &curvatures)
    };
    let row = row(&points, torque_sign, ray);
    (points, row)
}

/// The rows of the equal-speed pair at a phase, which for the paper's cross-slide form is the crank angle.
pub fn equal_speed(
    drive: &Drive,
    seeded: &Seeded,
    phase_rad: Dual,
    torque_sign: f64,
) -> Vec<(MeshingPoints, Row<Dual>)> {
    let points = drive.equal_speed_points(phase_rad.value, phase_rad.value);
    let walls = Walls::new(drive, seeded, EQUAL_SPEED_GROOVE);
    let pitch = seeded.0[PITCH_RADIUS];
    let [outside, inside] = seeded.pick(EQUAL_SPEED_ANGLES);
    let place = |point: &MeshingPoint, count: u32| TAU * point.ball as f64 / f64::from(count);
    let (sin, cos) = phase_rad.sin_cos();
    let rows = points.into_iter().zip([cos, sin]).map(|(points, paper)| {
        let row = match drive.equal_speed() {
            EqualSpeed::RingGroove(ring) => row(&points, torque_sign, |point| {
                let arm = pitch * (phase_rad + place(point, ring.ball_count)).sin_cos().0;
                let curvature = seeded.eccentricity_m().recip() * -point.diagonal.sign();
                let angle = if point.diagonal == Diagonal::Plus { outside } else { inside };
                walls.ray(point, arm, angle, &[curvature; 2])
            }),
            EqualSpeed::CrossSlide(CrossSlide { ball_count, form, .. }) => {
                row(&points, torque_sign, |point| {
                    let shift = match form {
                        CrossSlideForm::Balanced => Dual::constant(0.0),
                        CrossSlideForm::Paper => seeded.eccentricity_m() * paper,
                    };
                    let arm = pitch * place(point, *ball_count).cos() + shift;
                    walls.ray(point, arm, outside, &[Dual::constant(0.0); 2])
                })
            }
        };
        (points, row)
    });
    rows.collect()
}

/// Phases of both pairs at the crank angle of the load.
pub fn phases_rad(drive: &Drive, seeded: &Seeded) -> [Dual; 2] {
    let crank = seeded.0[INPUT_ANGLE];
    let planet = match drive.equal_speed() {
        EqualSpeed::RingGroove(_) => crank * drive.equal_speed_phase_rad(1.0),
        EqualSpeed::CrossSlide(_) => crank,
    };
    let phase = crank * drive.deceleration_phase_rad(1.0);
    // The values to the last bit as the drive has them.
    let exactly = |phase: Dual, value: f64| phase.chain(value, 1.0);
    let planet_rad = match drive.equal_speed() {
        EqualSpeed::RingGroove(_) => drive.equal_speed_phase_rad(crank.value),
        EqualSpeed::CrossSlide(_) => crank.value,
    };
    [exactly(phase, drive.deceleration_phase_rad(crank.value)), exactly(planet, planet_rad)]
}
