//! What the grooves stand: static safety, the groove's edge, the largest torque, the window of the preload; vibration.
//!
//! - static safety s0 = (`p_limit`/p)^3 with the highest peak pressure p of any contact over a period (ISO 76: the load of a
//!   point contact grows with the cube of its pressure);
//! - the window: preloads from continuous transmission (which includes hold) up to the one at which s0 falls to what is required;
//! - torsional natural frequency sqrt(k/J)/(2 pi) of an inertia J at the output, the input held;
//! - unbalance: the planet turns about the housing's axis at 2 e, so a mass m has m 2 e, and at the speed w the force m 2 e w^2.
//!
//! [`Contacts`] is a drive ready for many loads; `made` looks at parts as made.

mod made;

use std::f64::consts::TAU;

use crate::drive::{Drive, EqualSpeed};
use crate::equilibrium::report::PairSolution;
use crate::equilibrium::solve::solve_pair;
use crate::findings::distance_to_edge_m;
use crate::geometry::undercut::undercuts;
use crate::pair::MeshingPoints;
use crate::period;
use made::MadeContacts;

/// Contacts of a pair at the worst place of a period.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WorstContact {
    /// Highest peak pressure, Pa; infinite where some place has no solution.
    pub peak_pressure_Pa: f64,
    /// Largest semi-axis of a contact ellipse, m.
    pub semi_axis_m: f64,
    /// What is left between the ellipse and the edge of the groove, m, below 0 past it; `None` where no depth is given.
    pub edge_margin_m: Option<f64>,
}

/// What the contacts of a drive stand under a load, at the worst places of a period.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Strength {
    /// The deceleration pair.
    pub deceleration: WorstContact,
    /// The equal-speed pair.
    pub equal_speed: WorstContact,
    /// s0; 0 where some place has no solution.
    pub static_safety: f64,
}

/// Preloads that hold, transmit without a loose ball and are safe.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PreloadWindow {
    /// Holds above it, N.
    pub hold_N: f64,
    /// No ball comes loose from here on, N.
    pub continuous_N: f64,
    /// Least preload at which all is met, N; `None` where no preload does.
    pub least_N: Option<f64>,
    /// Largest such preload, N.
    pub largest_N: Option<f64>,
}

/// Halvings of a bracket, to 1e-9 of it.
const HALVINGS: u32 = 30;
/// The window ends below this multiple of its least preload.
const FAR: f64 = 1e6;

impl Drive {
    /// Worst contacts over a period at torque M0 (N m) and preload (N), of its parts as made where it has them.
    pub fn strength(&self, torque_Nm: f64, preload_N: f64) -> Strength {
        Contacts::new(self).strength(torque_Nm, preload_N)
    }
}

/// The contacts of a drive over a period, for many loads: nominal, or as its parts were made.
pub struct Contacts<'a> {
    drive: &'a Drive,
    made: Option<MadeContacts>,
}

impl<'a> Contacts<'a> {
    /// Of a drive.
    pub fn new(drive: &'a Drive) -> Self {
        let made = drive.as_made().filter(|_| !undercuts(drive)).map(|_| MadeContacts::new(drive));
        Self { drive, made }
    }

    /// Worst contacts over a period at torque M0 (N m) and preload (N).
    pub fn strength(&self, torque_Nm: f64, preload_N: f64) -> Strength {
        let drive = self.drive;
        let [first, second] = match &self.made {
            Some(made) => made.worst(torque_Nm, preload_N).0,
            None => nominal(drive, torque_Nm, preload_N),
        };
        let (pair, equal_speed) = (drive.deceleration(), drive.equal_speed());
        let angles = match equal_speed {
            EqualSpeed::RingGroove(ring) => {
                vec![ring.outside_contact_angle_rad, ring.inside_contact_angle_rad]
            }
            EqualSpeed::CrossSlide(slide) => vec![slide.contact_angle_rad],
        };
        let contact =
            |[peak_pressure_Pa, semi_axis_m]: [f64; 2], groove: &crate::GrooveSection, angles: &[f64]| {
                let room = |depth| {
                    let to_edge = angles.iter().map(|angle| distance_to_edge_m(groove, depth, *angle));
                    to_edge.fold(f64::INFINITY, f64::min) - semi_axis_m
                };
                WorstContact { peak_pressure_Pa, semi_axis_m, edge_margin_m: groove.groove_depth_m.map(room) }
            };
        let deceleration = contact(first, &pair.groove, &[pair.contact_angle_rad]);
        let equal_speed = contact(second, equal_speed.groove(), &angles);
        let highest = deceleration.peak_pressure_Pa.max(equal_speed.peak_pressure_Pa);
        let static_safety = static_safety(drive.material().pressure_limit_Pa, highest);
        Strength { deceleration, equal_speed, static_safety }
    }

    /// The last number from `low`, which is safe, to `high` up to which static safety s0 is met; `load` makes torque (N m) and
    /// preload (N) of it.
    fn last_safe(&self, range: [f64; 2], static_safety: f64, load: impl Fn(f64) -> [f64; 2]) -> f64 {
        if let Some(made) = &self.made {
            let most_Pa = self.drive.material().pressure_limit_Pa / static_safety.cbrt();
            return made.last_safe(range, most_Pa, load);
        }
        bisected(range[0], range[1], |number| {
            let [torque_Nm, preload_N] = load(number);
            self.strength(torque_Nm, preload_N).static_safety >= static_safety
        })
    }

    /// Largest torque (N m) at which a preload (N) holds, with static safety s0 over a period; `None` where the preload alone
    /// is too much.
    pub fn largest_torque_Nm(&self, preload_N: f64, static_safety: f64) -> Option<f64> {
        if self.strength(0.0, preload_N).static_safety < static_safety {
            return None;
        }
        // Parts as made hold what nominal ones do.
        let hold = preload_N / self.drive.nominal().preload_thresholds(1.0).drive().hold_N;
        Some(self.last_safe([0.0, hold], static_safety, |torque_Nm| [torque_Nm, preload_N]))
    }

    /// The preloads at which torque M0 (N m) is held and transmitted without a loose ball, with static safety s0.
    ///
    /// The pressure rises with the preload but for its neighbourhood of the holding limit, where few contacts carry all; the
    /// least preload is looked for there too.
    pub fn preload_window(&self, torque_Nm: f64, static_safety: f64) -> PreloadWindow {
        let needed = self.drive.preload_thresholds(torque_Nm).drive();
        let (hold_N, continuous_N) = (needed.hold_N, needed.continuous_N);
        let none = PreloadWindow { hold_N, continuous_N, least_N: None, largest_N: None };
        let safety = |preload_N: f64| self.strength(torque_Nm, preload_N).static_safety;
        let safe = |preload_N: f64| safety(preload_N) >= static_safety;
        let at = |preload_N: f64| [torque_Nm, preload_N];
        // Without a torque any preload above 0 does.
        let lower = hold_N.max(continuous_N).max(1e-3);
        if !lower.is_finite() {
            return none;
        }
        let (start, least) = if safe(lower) {
            (lower, lower)
        } else {
            let log_safety = &mut |log: f64| safety(log.exp());
            let (best, most) = period::golden_section(lower.ln(), (10.0 * lower).ln(), log_safety);
            if most < static_safety {
                return none;
            }
            let best = best.exp();
            (best, -self.last_safe([-best, -lower], static_safety, |preload_N| at(-preload_N)))
        };
        let mut high = 2.0 * start;
        while safe(high) && high < FAR * lower.max(1.0) {
            high *= 2.0;
        }
        let largest = self.last_safe([start, high], static_safety, at);
        PreloadWindow { least_N: Some(least), largest_N: Some(largest), ..none }
    }
}

/// Highest peak pressure (Pa) and largest semi-axis (m) of each pair over a period, its parts nominal.
fn nominal(drive: &Drive, torque_Nm: f64, preload_N: f64) -> [[f64; 2]; 2] {
    let share = drive.equal_speed_share();
    let deceleration = |phase: f64| worst(&[drive.deceleration_points(phase)], torque_Nm, preload_N);
    let equal = |phase: f64| worst(&drive.equal_speed_points(phase, phase), torque_Nm * share, preload_N);
    let first = if undercuts(drive) {
        [f64::INFINITY; 2]
    } else {
        period::maxima(drive.deceleration_period_rad(), deceleration).map(|(_, value)| value)
    };
    let second = match drive.equal_speed_period_rad() {
        Some(period) => period::maxima(period, equal).map(|(_, value)| value),
        None => equal(0.0),
    };
    [first, second]
}

/// The last place from `low` (where `safe` is true) to `high` up to which it stays so.
fn bisected(mut low: f64, mut high: f64, safe: impl Fn(f64) -> bool) -> f64 {
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        if safe(middle) {
            low = middle;
        } else {
            high = middle;
        }
    }
    low
}

/// Highest peak pressure (Pa) and largest semi-axis (m) of rows under a load; infinite without solution.
fn worst(rows: &[MeshingPoints], torque_Nm: f64, preload_N: f64) -> [f64; 2] {
    let mut found = [0.0_f64; 2];
    for row in rows {
        let (_, Some(solved)) = solve_pair(row, torque_Nm, preload_N) else { return [f64::INFINITY; 2] };
        let pair = PairSolution::new(row, torque_Nm, &solved);
        for wall in pair.points.iter().flat_map(|point| point.walls.iter().flatten()) {
            found = [found[0].max(wall.peak_pressure_Pa), found[1].max(wall.major_semi_axis_m)];
        }
    }
    found
}

/// s0 = (`p_limit`/p)^3 of a highest peak pressure p, both Pa; 0 of an infinite one.
pub fn static_safety(limit_Pa: f64, peak_pressure_Pa: f64) -> f64 {
    (limit_Pa / peak_pressure_Pa).powi(3)
}

/// sqrt(k/J)/(2 pi), Hz, of a stiffness (N m/rad) and an inertia at the output (kg m^2).
pub fn natural_frequency_Hz(stiffness_Nm_per_rad: f64, inertia_kg_m2: f64) -> f64 {
    (stiffness_Nm_per_rad / inertia_kg_m2).sqrt() / TAU
}

/// m 2 e, kg m, of the planet's mass (kg) and the eccentricity e (m).
pub fn unbalance_kg_m(planet_mass_kg: f64, eccentricity_m: f64) -> f64 {
    2.0 * planet_mass_kg * eccentricity_m
}
