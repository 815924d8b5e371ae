//! Minimum preload: three thresholds of a pair, each the preload of its own defining state.
//!
//! Below a threshold's preload, at the same torque:
//! 1. **hold**: the balls slip out; one contact carries all (see [`MeshingPoints::holding_arm_m`]);
//! 2. **continuous transmission** (the 2017 paper's minimum APF): the state d = 0, in which the diagonals that the
//!    torque loads carry all and the others have just parted; below it balls with small arms come loose;
//! 3. **zero backlash**: the state in which the first diagonal is about to part.
//!
//! States 2 and 3 are rays: with d = A |alpha| every deformation is |alpha| (A sin beta + s cos beta), s the arm with
//! the signs of diagonal and torque, so the ratio of preload to torque follows from A alone:
//!
//! N_Z/|M0| = sum k (A sin beta + s cos beta)^n sin beta / sum k (A sin beta + s cos beta)^n s cos beta,
//!
//! over what touches; A = 0 for state 2, A = max(-s cot beta) for state 3. This holds for unlike contact angles too.
//! Where a plate floats sideways, s contains its shift, found from the balance across the grooves. That is for nominal
//! parts; `made` has those of parts as they were made.

mod made;

use std::f64::consts::TAU;

use rayon::prelude::*;

use crate::drive::{Drive, EqualSpeed};
use crate::geometry::undercut::undercuts;
use crate::pair::MeshingPoints;
use crate::period;
use crate::real::Real;
use made::made_thresholds;

/// Places for each ball and turn at which parts as made are looked at, and how many at most.
const PLACES_PER_BALL: usize = 8;
const MOST_PLACES: usize = 4096;

/// The three preloads that a torque needs, N; infinite if no preload is enough.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PreloadThresholds {
    /// More than this holds the torque at all, N.
    pub hold_N: f64,
    /// From here on no ball comes loose: continuous transmission, the paper's minimum APF, N.
    pub continuous_N: f64,
    /// From here on no diagonal parts: zero backlash, N.
    pub zero_backlash_N: f64,
}

impl PreloadThresholds {
    /// No preload does it.
    pub const NEVER: Self =
        Self { hold_N: f64::INFINITY, continuous_N: f64::INFINITY, zero_backlash_N: f64::INFINITY };

    /// The larger of each.
    #[must_use]
    pub fn max(self, other: Self) -> Self {
        Self {
            hold_N: self.hold_N.max(other.hold_N),
            continuous_N: self.continuous_N.max(other.continuous_N),
            zero_backlash_N: self.zero_backlash_N.max(other.zero_backlash_N),
        }
    }

    fn map(self, f: impl Fn(f64) -> f64) -> Self {
        Self {
            hold_N: f(self.hold_N),
            continuous_N: f(self.continuous_N),
            zero_backlash_N: f(self.zero_backlash_N),
        }
    }
}

/// One of the three.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Threshold {
    /// The torque is held at all.
    Hold,
    /// No ball comes loose.
    Continuous,
    /// No diagonal parts.
    ZeroBacklash,
}

impl Threshold {
    /// All of them, the least first.
    pub const ALL: [Self; 3] = [Self::Hold, Self::Continuous, Self::ZeroBacklash];

    /// `hold`, `continuous` or `zero_backlash`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Hold => "hold",
            Self::Continuous => "continuous",
            Self::ZeroBacklash => "zero_backlash",
        }
    }

    /// It among the three.
    pub fn of(self, thresholds: PreloadThresholds) -> f64 {
        match self {
            Self::Hold => thresholds.hold_N,
            Self::Continuous => thresholds.continuous_N,
            Self::ZeroBacklash => thresholds.zero_backlash_N,
        }
    }
}

/// Thresholds of both pairs and of the drive, all in terms of the drive's M0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DriveThresholds {
    /// Of the deceleration pair.
    pub deceleration: PreloadThresholds,
    /// Of the equal-speed pair.
    pub equal_speed: PreloadThresholds,
}

impl DriveThresholds {
    /// Of the drive: the larger of each, because both pairs share one preload.
    pub fn drive(&self) -> PreloadThresholds {
        self.deceleration.max(self.equal_speed)
    }
}

/// Thresholds of a pair without offsets and axial spring, at torque M0 (N m).
pub fn pair_thresholds(points: &MeshingPoints, torque_Nm: f64) -> PreloadThresholds {
    if torque_Nm == 0.0 {
        return PreloadThresholds { hold_N: 0.0, continuous_N: 0.0, zero_backlash_N: 0.0 };
    }
    let torque_sign = torque_Nm.signum();
    let row = Row::new(points, torque_sign);
    PreloadThresholds {
        hold_N: 1.0 / points.holding_arm_m(torque_sign),
        continuous_N: row.preload_per_torque(|_| 0.0),
        zero_backlash_N: row.preload_per_torque(|shift| row.touching_ratio(shift)),
    }
    .map(|per_torque| per_torque * torque_Nm.abs())
}

/// A diagonal that exists, as the thresholds see it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Ray<T> {
    /// +1 or -1, as the diagonal is squeezed.
    pub sign: f64,
    pub arm_m: T,
    pub sin_beta: T,
    pub cos_beta: T,
    pub stiffness: T,
}

/// A row of meshing points seen from one direction of torque; in dual numbers it knows how its thresholds answer.
#[derive(Debug, Clone)]
pub(crate) struct Row<T> {
    pub rays: Vec<Ray<T>>,
    pub torque_sign: f64,
    pub exponent: f64,
    pub floats_sideways: bool,
}

impl<T: Real> Row<T> {
    /// Arm with the signs of diagonal and torque, and with a sideways shift of the plate, m.
    fn arm(&self, ray: &Ray<T>, shift_m: T) -> T {
        (ray.arm_m + shift_m) * (self.torque_sign * ray.sign)
    }

    /// s cot beta of every diagonal of one sign, or of all: the torque that it alone holds per preload, m.
    pub fn torques_per_preload_m(&self, sign: Option<f64>) -> impl Iterator<Item = T> {
        let wanted = move |ray: &&Ray<T>| sign.is_none_or(|sign| sign * ray.sign > 0.0);
        self.rays.iter().filter(wanted).map(|ray| self.arm(ray, T::of(0.0)) * ray.cos_beta / ray.sin_beta)
    }

    /// -s cot beta of every diagonal: the approach per rotation at which it is about to part, m.
    pub fn parting_ratios_m(&self, shift_m: T) -> impl Iterator<Item = T> {
        self.rays.iter().map(move |ray| -(self.arm(ray, shift_m) * ray.cos_beta / ray.sin_beta))
    }

    /// Sums of axial force, torque and sideways force per unit of rotation^n.
    pub fn sums(&self, ratio: T, shift_m: T) -> [T; 3] {
        self.rays.iter().fold([T::of(0.0); 3], |[axial, torque, sideways], ray| {
            let arm = self.arm(ray, shift_m);
            let deformation = ratio * ray.sin_beta + arm * ray.cos_beta;
            // What other exponents make of the unit of k is in both sums of a ratio.
            let force = ray.stiffness * deformation.pressed(self.exponent);
            [
                axial + force * ray.sin_beta,
                torque + force * arm * ray.cos_beta,
                sideways + force * ray.cos_beta * ray.sign,
            ]
        })
    }
}

impl Row<f64> {
    pub fn new(points: &MeshingPoints, torque_sign: f64) -> Self {
        let rays = points.points.iter().filter(|point| point.exists()).map(|point| Ray {
            sign: point.diagonal.sign(),
            arm_m: point.arm_m,
            sin_beta: point.sin_beta,
            cos_beta: point.cos_beta,
            stiffness: point.stiffness,
        });
        let (exponent, floats_sideways) = (points.exponent, points.floats_sideways);
        Self { rays: rays.collect(), torque_sign, exponent, floats_sideways }
    }

    /// A = max(-s cot beta): the approach per rotation at which the first diagonal is about to part, m.
    pub fn touching_ratio(&self, shift_m: f64) -> f64 {
        self.parting_ratios_m(shift_m).fold(f64::NEG_INFINITY, f64::max)
    }

    /// N_Z/|M0| (1/m) of the state with approach per rotation `ratio(shift)`.
    fn preload_per_torque(&self, ratio: impl Fn(f64) -> f64) -> f64 {
        let shift = self.balanced_shift_m(&ratio);
        let [axial, torque, _] = self.sums(ratio(shift), shift);
        if torque > 0.0 { axial / torque } else { f64::INFINITY }
    }

    /// The shift per rotation at which the forces across the grooves balance, by bisection: the sideways force rises
    /// with the shift (falls for a negative torque, whose rotation is negative too). 0 where no plate floats.
    pub fn balanced_shift_m(&self, ratio: &impl Fn(f64) -> f64) -> f64 {
        if !self.floats_sideways {
            return 0.0;
        }
        let limit = self.rays.iter().map(|ray| ray.arm_m.abs()).fold(0.0, f64::max);
        let (mut low, mut high) = (-limit, limit);
        for _ in 0..200 {
            let middle = 0.5 * (low + high);
            if middle <= low || middle >= high {
                break;
            }
            if self.torque_sign * self.sums(ratio(middle), middle)[2] < 0.0 {
                low = middle;
            } else {
                high = middle;
            }
        }
        0.5 * (low + high)
    }
}

/// Phases of the pairs at which their thresholds (hold, continuous, zero backlash) are largest over a period, rad.
#[derive(Debug, Clone, Copy)]
pub(crate) struct WorstPhases {
    pub deceleration_rad: [f64; 3],
    pub equal_speed_rad: [f64; 3],
}

impl Drive {
    /// The three thresholds at one angle of the input crank (rad) for torque M0 (N m).
    ///
    /// Those of a deceleration pair that undercuts are infinite: no preload makes it work.
    pub fn preload_thresholds_at(&self, torque_Nm: f64, input_angle_rad: f64) -> DriveThresholds {
        let points = self.points(input_angle_rad);
        let of_pair = if self.as_made().is_some() { made_thresholds } else { pair_thresholds };
        DriveThresholds {
            deceleration: if undercuts(self) {
                PreloadThresholds::NEVER
            } else {
                of_pair(&points.deceleration, torque_Nm)
            },
            equal_speed: rows_thresholds(&points.equal_speed, torque_Nm * points.equal_speed_share, of_pair),
        }
    }

    /// The three thresholds for torque M0 (N m), each as its maximum over a period of its pair; infinite as in
    /// [`Drive::preload_thresholds_at`].
    ///
    /// ```
    /// use cbpt_core::Drive;
    ///
    /// let needed = Drive::paper_base_case().preload_thresholds(5.0).drive();
    /// assert!(0.0 < needed.hold_N && needed.hold_N < needed.continuous_N);
    /// assert!(needed.continuous_N < needed.zero_backlash_N);
    /// ```
    pub fn preload_thresholds(&self, torque_Nm: f64) -> DriveThresholds {
        if self.as_made().is_some() { self.made_maxima(torque_Nm) } else { self.worst_phases(torque_Nm).0 }
    }

    /// The thresholds of parts as they were made at so many places of the turns after which they repeat, the largest of each.
    fn made_maxima(&self, torque_Nm: f64) -> DriveThresholds {
        let none = PreloadThresholds { hold_N: 0.0, continuous_N: 0.0, zero_backlash_N: 0.0 };
        let at = |angle_rad: f64| self.preload_thresholds_at(torque_Nm, angle_rad);
        places_as_made_rad(self).into_par_iter().map(at).reduce(
            || DriveThresholds { deceleration: none, equal_speed: none },
            |a, b| DriveThresholds {
                deceleration: a.deceleration.max(b.deceleration),
                equal_speed: a.equal_speed.max(b.equal_speed),
            },
        )
    }

    /// One of them, of the drive, alone: soon found.
    pub fn preload_threshold_N(&self, torque_Nm: f64, which: Threshold) -> f64 {
        if self.as_made().is_some() {
            return which.of(self.made_maxima(torque_Nm).drive());
        }
        let [[(_, one)], [(_, other)]] = self.over_period(torque_Nm, |thresholds| [which.of(thresholds)]);
        one.max(other)
    }

    /// All of them with the phases where they are so large.
    pub(crate) fn worst_phases(&self, torque_Nm: f64) -> (DriveThresholds, WorstPhases) {
        let [first, second] =
            self.over_period(torque_Nm, |thresholds| Threshold::ALL.map(|which| which.of(thresholds)));
        let thresholds = |found: [(f64, f64); 3]| {
            let [hold_N, continuous_N, zero_backlash_N] = found.map(|(_, value)| value);
            PreloadThresholds { hold_N, continuous_N, zero_backlash_N }
        };
        let (deceleration, equal_speed) = (thresholds(first), thresholds(second));
        let phases = WorstPhases {
            deceleration_rad: first.map(|(phase, _)| phase),
            equal_speed_rad: second.map(|(phase, _)| phase),
        };
        (DriveThresholds { deceleration, equal_speed }, phases)
    }

    /// Phase and value of the largest of what is picked of the thresholds of both pairs.
    fn over_period<const N: usize>(
        &self,
        torque_Nm: f64,
        pick: impl Fn(PreloadThresholds) -> [f64; N],
    ) -> [[(f64, f64); N]; 2] {
        let share = self.equal_speed_share();
        let deceleration = |phase: f64| pick(pair_thresholds(&self.deceleration_points(phase), torque_Nm));
        // The paper's cross-slide form shifts with the crank itself; every other pair depends on its own phase alone.
        let equal_speed = |phase: f64| {
            pick(rows_thresholds(&self.equal_speed_points(phase, phase), torque_Nm * share, pair_thresholds))
        };
        [
            if undercuts(self) {
                pick(PreloadThresholds::NEVER).map(|never| (0.0, never))
            } else {
                period::maxima(self.deceleration_period_rad(), deceleration)
            },
            match self.equal_speed_period_rad() {
                Some(period) => period::maxima(period, equal_speed),
                None => equal_speed(0.0).map(|value| (0.0, value)),
            },
        ]
    }

    /// Period of the deceleration pair in its phase Phi, 2 pi/Z2, rad.
    pub fn deceleration_period_rad(&self) -> f64 {
        TAU / f64::from(self.deceleration().ball_count)
    }

    /// Period of the equal-speed pair in its phase psi, rad: 2 pi/Zd for ring grooves, `None` for the cross-slide,
    /// which is constant (2 pi of the crank in the paper's form).
    pub fn equal_speed_period_rad(&self) -> Option<f64> {
        match self.equal_speed() {
            EqualSpeed::RingGroove(ring) => Some(TAU / f64::from(ring.ball_count)),
            EqualSpeed::CrossSlide(slide) => {
                (slide.form == crate::drive::CrossSlideForm::Paper).then_some(TAU)
            }
        }
    }
}

/// Crank angles spread over the turns after which parts as made repeat, at which they are looked at, rad.
pub(crate) fn places_as_made_rad(drive: &Drive) -> Vec<f64> {
    let turns = drive.repetition_turns() as usize;
    let places = (turns * PLACES_PER_BALL * drive.deceleration().ball_count as usize).min(MOST_PLACES);
    let step_rad = TAU * turns as f64 / places as f64;
    (0..places).map(|place| step_rad * place as f64).collect()
}

fn rows_thresholds(
    rows: &[MeshingPoints],
    torque_Nm: f64,
    of_pair: fn(&MeshingPoints, f64) -> PreloadThresholds,
) -> PreloadThresholds {
    let none = PreloadThresholds { hold_N: 0.0, continuous_N: 0.0, zero_backlash_N: 0.0 };
    rows.iter().map(|row| of_pair(row, torque_Nm)).fold(none, PreloadThresholds::max)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_are_spread_over_all_turns() {
        let drive = Drive::paper_base_case();
        let places = places_as_made_rad(&drive);
        let whole_rad = TAU * f64::from(drive.repetition_turns());
        let next = places.iter().skip(1).chain([&whole_rad]);
        for (here, next) in places.iter().zip(next) {
            assert!(((next - here) * places.len() as f64 / whole_rad - 1.0).abs() < 1e-6);
        }
    }
}
