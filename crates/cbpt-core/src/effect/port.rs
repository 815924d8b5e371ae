//! What an effect is given at its port, and what it may change there.

use super::dual::Dual;
use crate::pair::HERTZ_EXPONENT;

/// One reading as effects see it: the columns of the table but for the angle, and its place in the history.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Row {
    /// Its place among the readings, run by run.
    pub place: usize,
    /// Torque that was read, N m.
    pub torque_Nm: f64,
    /// Preload that was read, N; 0 where there is none.
    pub preload_N: f64,
    /// Angle of the input crank, rad.
    pub input_angle_rad: f64,
    /// Time since the first reading of the table, s; the first is the earliest where all runs have one clock.
    pub time_s: f64,
    /// Time since the run's first reading, s.
    pub run_time_s: f64,
    /// Time since the reading before in the run, s; 0 of the first.
    pub step_time_s: f64,
    /// The rate with which the torque arrives at the reading ([`super::torque_rate`]) over its mean rate since the reading before,
    /// 0 to 2. 1 where there is none behind, or the torque held.
    pub rate_share: f64,
    /// Temperature less that of the first reading, K; 0 where none was read.
    pub temperature_difference_K: f64,
    /// Largest torque either way so far over the largest of the table.
    pub largest_torque_share: f64,
    /// The same since the run began.
    pub largest_torque_share_of_run: f64,
    /// Load cycles that were complete before this reading; where none were counted, the runs before this one.
    pub cycles_done: f64,
    /// 1 where the torque rises from the reading before in the run, -1 where it falls, 0 where it holds; the first reading of
    /// a run takes the value of the next.
    pub direction: f64,
}

/// What effects know of the drive.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DriveNumbers {
    /// Zo e, from the centre of the output plate to the pitch point, m; of a torsion spring its reference radius.
    pub pitch_arm_m: f64,
    /// Turn of the planet's groove against the line of centres for one turn of the crank: Z1/Z3 with the hypocycloid plate
    /// as output, Z3/Z1 with the epicycloid plate; 0 of a torsion spring.
    pub planet_turn: f64,
}

/// The load of a row on its way to the meshing points.
#[derive(Debug, Clone, Default)]
pub struct Load {
    /// Torque M0 on the output, N m.
    pub torque_Nm: Dual,
    /// Preload `N_Z` that reaches the meshing points at no torque, N.
    pub preload_N: Dual,
    /// Axial spring in place of a constant preload, N/m.
    pub spring_N_per_m: Dual,
    /// What rubs on the output's rotation.
    pub friction: Vec<Friction>,
}

/// A friction torque after a rotation, as a share of its limit, from that before it, the rotation (rad), the angle over which
/// it builds up (rad) and the exponent of its law; and its derivatives by these four.
pub type FrictionLaw = fn(f64, f64, f64, f64) -> (f64, [f64; 4]);

/// A friction torque with memory.
#[derive(Debug, Clone, Copy)]
pub struct Friction {
    /// How it builds up.
    pub law: FrictionLaw,
    /// Largest friction torque over the preload, m.
    pub radius_m: Dual,
    /// Largest friction torque whatever the preload, N m.
    pub torque_Nm: Dual,
    /// Share of the torque on the output by which it is larger.
    pub load_share: Dual,
    /// Angle over which it builds up, rad.
    pub engagement_angle_rad: Dual,
    /// Exponent of its law, where that has one.
    pub exponent: Dual,
    /// Whether it helps the rotation on: a part that weakens another friction.
    pub helps: bool,
}

impl Friction {
    /// Its share of the limit after a rotation, rad, from that before it, and the derivatives of its law.
    pub fn after(&self, before: f64, way_rad: f64) -> (f64, [f64; 4]) {
        (self.law)(before, way_rad, self.engagement_angle_rad.value, self.exponent.value)
    }

    /// Largest friction torque under a load, N m; negative where it helps.
    pub fn limit_Nm(&self, load: &Load) -> Dual {
        let sign = self.sign();
        let mut limit = self.torque_Nm * sign;
        limit.add_product(sign, &self.radius_m, &load.preload_N);
        let sense = if load.torque_Nm.value < 0.0 { -sign } else { sign };
        limit.add_product(sense, &self.load_share, &load.torque_Nm);
        limit
    }

    /// The same where it is one under every load.
    pub fn lasting_limit_Nm(&self) -> Option<Dual> {
        let follows = |share: &Dual| share.value != 0.0 || share.depends();
        (!follows(&self.radius_m) && !follows(&self.load_share)).then(|| self.torque_Nm * self.sign())
    }

    fn sign(&self) -> f64 {
        if self.helps { -1.0 } else { 1.0 }
    }
}

/// How many numbers a `backlash` has.
pub const PLAY_NUMBERS: usize = 3;
/// How many numbers a `stiffness_curve` has.
pub const CURVE_NUMBERS: usize = 8;
/// How many numbers a `hard_stop` has.
pub const STOP_NUMBERS: usize = 2;

/// What the contacts of all pairs become. Effects that may stand more than once with shapes of their own are listed, each with
/// its numbers in their order.
#[derive(Debug, Clone)]
pub struct Contact {
    /// Factor on every stiffness.
    pub stiffness_scale: Dual,
    /// Added to every contact angle, rad.
    pub contact_angle_shift_rad: Dual,
    /// Exponent of the contact law.
    pub exponent: Dual,
    /// Each `backlash` of a torsion spring.
    pub plays: Vec<[Dual; PLAY_NUMBERS]>,
    /// Each `stiffness_curve` of a torsion spring.
    pub curves: Vec<[Dual; CURVE_NUMBERS]>,
    /// Each `hard_stop`, of which a later one bears on what those before it leave.
    pub stops: Vec<[Dual; STOP_NUMBERS]>,
}

impl Contact {
    /// Without effects.
    pub fn unchanged() -> Self {
        Self {
            stiffness_scale: Dual::constant(1.0),
            contact_angle_shift_rad: Dual::constant(0.0),
            exponent: Dual::constant(HERTZ_EXPONENT),
            plays: Vec::new(),
            curves: Vec::new(),
            stops: Vec::new(),
        }
    }
}

/// A ball's place, for effects on gaps.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ball {
    /// Whether it is one of the deceleration pair.
    pub decelerates: bool,
    /// Its number, from 0.
    pub number: usize,
    /// Its angle from the line of centres, rad; in a cross-slide from the grooves' normal.
    pub from_line_rad: f64,
    /// Its angle along the fixed groove of the deceleration pair, which is its angle in the housing, rad.
    pub on_fixed_groove_rad: f64,
    /// Its angle along the planet's groove of the deceleration pair, rad.
    pub on_planet_groove_rad: f64,
    /// Its angle from the pair's first ball, which in the equal-speed pair is its angle in both plates, rad.
    pub in_plate_rad: f64,
    /// Radius of the circle of balls, m.
    pub pitch_radius_m: f64,
}

/// An angle at every reading of a run.
pub type OfRun = fn(&[Dual], &[Row], &[Dual]) -> Vec<Dual>;

/// What an effect does, by its port. The first argument is always the effect's own parameters in their order.
#[derive(Debug, Clone, Copy)]
pub enum Action {
    /// Nothing to the mean; statistics handle it.
    Spread,
    /// Changes the load.
    Load(fn(&[Dual], &Row, &mut Load)),
    /// Frictions of the output's rotation that are the same at every reading.
    Friction(fn(&[Dual]) -> Vec<Friction>),
    /// Changes the load by the temperature of a part (K, less the first one), which follows the measured one with the effect's
    /// number of this place as time constant; see [`super::lag`].
    ThermalLoad(usize, fn(&[Dual], Dual, &mut Load)),
    /// Changes the torque of each reading of a run, N m: for what depends on the torques read before.
    Torques(fn(&[Dual], &[Row]) -> Vec<Dual>),
    /// zeta, g and p at a ball for one unit of the size given by its index, m per unit; the sizes act linearly.
    Gap(fn(&[f64], usize, &Ball) -> [f64; 3]),
    /// Changes the contacts.
    Contact(fn(&[Dual], &mut Contact)),
    /// An angle at the output, given the torque M0 (N m), rad.
    Series(fn(&[Dual], &Row, &DriveNumbers, Dual) -> Dual),
    /// The same at every reading of a run, given the readings and the torque M0 (N m) at each: for what depends on the
    /// torques before.
    History(OfRun),
    /// What the instrument shows of an angle, rad.
    Reading(fn(&[Dual], &Row, Dual) -> Dual),
    /// The same at every reading of a run, given the readings and the angle (rad) at each: for what depends on the angles
    /// before.
    Readings(OfRun),
    /// What the instrument shows of an angle with the temperature of a part before it; see [`Self::ThermalLoad`].
    ThermalReading(usize, fn(&[Dual], &Row, Dual, Dual) -> Dual),
    /// What the instrument shows of an angle (rad) while the output carries the torque M0 (N m), which stands before it.
    TorqueReading(fn(&[Dual], Dual, Dual) -> Dual),
}

impl Action {
    /// Which of the effect's numbers is the time constant of a temperature.
    pub fn time_constant(&self) -> Option<usize> {
        match self {
            Self::ThermalLoad(place, _) | Self::ThermalReading(place, _) => Some(*place),
            _ => None,
        }
    }
}
