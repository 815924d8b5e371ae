//! How the elastic angle and the preload thresholds of a drive answer to every design number: exact derivatives.
//!
//! - `points`: meshing points in dual numbers; `thresholds`: the three thresholds of a pair;
//! - here: the elastic angle, and all of it for a drive.
//!
//! The angle by the implicit function theorem. With the equations of a pair r(x, q) = 0, dalpha/dq = -lambda . dr/dq,
//! where lambda is how alpha answers to a force along each equation: to preload, torque and a sideways force
//! ([`Slopes`](crate::equilibrium::response::Slopes)). dr/dq at the solution held is r in dual numbers.

mod points;
mod thresholds;

use crate::design::{Design, DesignNumber, PRELOAD, TORQUE};
use crate::drive::{Drive, EqualSpeed, Load};
use crate::effect::dual::{Dual, WIDTH};
use crate::equilibrium::ReadyPair;
use crate::equilibrium::response::{Asked, respond};
use crate::error::{InvalidInput, require};
use crate::geometry::undercut::undercuts;
use crate::pair::MeshingPoints;
use crate::preload::Row;
use crate::real::Real;
use crate::status::Status;

use points::Seeded;

/// Slots of a dual number that are kept for the phase of a pair and the sideways shift of a plate.
const PHASE: usize = WIDTH - 2;
const SHIFT: usize = WIDTH - 1;

/// A result and its derivatives by the numbers asked about, in their order; SI.
#[derive(Debug, Clone, PartialEq)]
pub struct Sensitivity {
    /// The result.
    pub value: f64,
    /// Its derivative by each number.
    pub slopes: Vec<f64>,
    /// Whether contacts that decide alike answer differently to a number: the derivative is then that of one of them, to
    /// one side.
    pub tied: Vec<bool>,
}

impl Sensitivity {
    /// A result whose derivatives are still to come.
    pub(crate) fn constant(value: f64) -> Self {
        Self { value, slopes: Vec::new(), tied: Vec::new() }
    }

    fn of(number: Dual, tied: impl Fn(usize) -> bool) -> Self {
        Self { value: number.value, slopes: number.partials.to_vec(), tied: (0..WIDTH).map(tied).collect() }
    }

    /// The same with the answers to further numbers.
    fn joined(mut self, mut further: Self) -> Self {
        self.slopes.append(&mut further.slopes);
        self.tied.append(&mut further.tied);
        self
    }

    /// The product with a torque of either sign, by its size; at no torque every threshold has a kink in it.
    fn times(mut self, torque: Dual) -> Self {
        let size = torque.abs();
        for (slot, (slope, tied)) in self.slopes.iter_mut().zip(&mut self.tied).enumerate() {
            *slope = *slope * size.value + self.value * size.partials[slot];
            *tied |= size.value == 0.0 && size.partials[slot] != 0.0;
        }
        self.value *= size.value;
        self
    }

    fn cut(mut self, numbers: usize) -> Self {
        self.slopes.truncate(numbers);
        self.tied.truncate(numbers);
        self
    }
}

/// Hold, continuous and zero backlash; `None` where no preload does it.
pub type ThresholdSensitivities = [Option<Sensitivity>; 3];

/// The answers of a drive under a load.
#[derive(Debug, Clone, PartialEq)]
pub struct DriveSensitivities {
    /// How the load ended.
    pub status: Status,
    /// Elastic angle at the output, rad; `None` where there is no solution.
    pub elastic_angle: Option<Sensitivity>,
    /// Part of the deceleration pair, rad.
    pub deceleration_angle: Option<Sensitivity>,
    /// Part of the equal-speed pair that reaches the output, rad.
    pub equal_speed_angle: Option<Sensitivity>,
    /// Thresholds of the deceleration pair at the load's torque, as maxima over a period, N.
    pub deceleration: ThresholdSensitivities,
    /// Of the equal-speed pair.
    pub equal_speed: ThresholdSensitivities,
    /// Of the drive: the larger of each.
    pub drive: ThresholdSensitivities,
}

impl DriveSensitivities {
    fn joined(self, further: Self) -> Self {
        let both = |a: Option<Sensitivity>, b: Option<Sensitivity>| Some(a?.joined(b?));
        let three = |a: ThresholdSensitivities, b: ThresholdSensitivities| {
            let [a0, a1, a2] = a;
            let [b0, b1, b2] = b;
            [both(a0, b0), both(a1, b1), both(a2, b2)]
        };
        Self {
            status: self.status,
            elastic_angle: both(self.elastic_angle, further.elastic_angle),
            deceleration_angle: both(self.deceleration_angle, further.deceleration_angle),
            equal_speed_angle: both(self.equal_speed_angle, further.equal_speed_angle),
            deceleration: three(self.deceleration, further.deceleration),
            equal_speed: three(self.equal_speed, further.equal_speed),
            drive: three(self.drive, further.drive),
        }
    }
}

impl Drive {
    /// How the elastic angle under a load, and the thresholds at its torque over a period, answer to design numbers.
    ///
    /// # Errors
    /// [`InvalidInput`] for a whole number, by which nothing has a derivative, and for one that the drive does not have.
    pub fn sensitivities(
        &self,
        load: &Load,
        numbers: &[&DesignNumber],
    ) -> Result<DriveSensitivities, InvalidInput> {
        let design = Design::of(self, load);
        for number in numbers {
            let rule = "is a number of balls, a whole number, so there is no derivative with respect to it";
            require(!number.whole, "number", number.name, rule)?;
            design.suits(number)?;
        }
        // Phases do not depend on the size of the torque, which may be nothing.
        let (_, worst) = self.worst_phases(direction(load));
        let phases = [worst.deceleration_rad, worst.equal_speed_rad];
        let mut all: Option<DriveSensitivities> = None;
        for some in numbers.chunks(PHASE) {
            let found = block(self, load, &Seeded::new(&design, some), phases, some.len());
            all = Some(match all {
                Some(before) => before.joined(found),
                None => found,
            });
        }
        Ok(all.unwrap_or_else(|| block(self, load, &Seeded::new(&design, &[]), phases, 0)))
    }
}

fn block(
    drive: &Drive,
    load: &Load,
    seeded: &Seeded,
    worst_rad: [[f64; 3]; 2],
    numbers: usize,
) -> DriveSensitivities {
    let (status, angles) = match angles(drive, load, seeded) {
        Ok((status, parts)) => (status, Some(parts)),
        Err(status) => (status, None),
    };
    let told = |angle: Dual| Sensitivity::of(angle, |_| false).cut(numbers);
    let cut = |found: ThresholdSensitivities| found.map(|found| found.map(|found| found.cut(numbers)));
    let [deceleration, equal_speed] = thresholds_of(drive, load, seeded, worst_rad).map(cut);
    let larger =
        |kind: usize| Some(thresholds::larger(deceleration[kind].as_ref()?, equal_speed[kind].as_ref()?));
    DriveSensitivities {
        status,
        elastic_angle: angles.map(|[one, other]| told(one + other)),
        deceleration_angle: angles.map(|[one, _]| told(one)),
        equal_speed_angle: angles.map(|[_, other]| told(other)),
        drive: [larger(0), larger(1), larger(2)],
        deceleration,
        equal_speed,
    }
}

/// The parts of the elastic angle, rad.
fn angles(drive: &Drive, load: &Load, seeded: &Seeded) -> Result<(Status, [Dual; 2]), Status> {
    if undercuts(drive) {
        return Err(Status::Undercut);
    }
    let [phase, planet] = points::phases_rad(drive, seeded);
    let sign = direction(load);
    let first = points::deceleration(drive, seeded, phase, sign);
    let rows = points::equal_speed(drive, seeded, planet, sign);
    let [torque, preload] = [seeded.0[TORQUE], seeded.0[PRELOAD]];
    let share = drive.equal_speed_share();
    let one = rotation(&first.0, &first.1, torque, preload);
    let others: Vec<Result<(Status, Dual), Status>> = rows
        .iter()
        .map(|(points, row)| {
            let (status, rotation) = rotation(points, row, torque * share, preload)?;
            Ok((status, rotation * (share * f64::from(points.rows))))
        })
        .collect();
    // The worst status of all, as a solve of the drive has it.
    let failed = others.iter().chain(std::iter::once(&one)).filter_map(|found| found.as_ref().err());
    if let Some(status) = failed.copied().reduce(Status::worse) {
        return Err(status);
    }
    let (mut status, deceleration) = one?;
    let mut equal_speed = Dual::constant(0.0);
    for (of_row, rotation) in others.into_iter().flatten() {
        status = status.worse(of_row);
        equal_speed += rotation;
    }
    Ok((status, [deceleration, equal_speed]))
}

/// The rotation of one row of a pair.
fn rotation(
    points: &MeshingPoints,
    row: &Row<Dual>,
    torque_Nm: Dual,
    preload_N: Dual,
) -> Result<(Status, Dual), Status> {
    let pair = ReadyPair::new(points);
    let found = respond(&pair, [torque_Nm.value, preload_N.value], [None; 2], Asked::default())?;
    let (state, slopes) = (&found.state, &found.rotation);
    let [approach, rotation, sideways] = [state.approach_m(), state.rotation_rad, state.sideways_m];
    let mut angle = Dual::constant(rotation);
    angle.add_slope(slopes.torque, &torque_Nm);
    angle.add_slope(slopes.preload, &preload_N);
    let existing = points.points.iter().filter(|point| point.exists());
    for (ray, point) in row.rays.iter().zip(existing) {
        let in_plane = ray.cos_beta * ray.sign;
        let turning = in_plane * ray.arm_m;
        let gained = ray.sin_beta * approach + turning * rotation + in_plane * sideways;
        // The value as the state has it, which keeps its digits near the limit.
        let deformation = gained.chain(state.deformation_m(point), 1.0);
        let force = ray.stiffness * deformation.pressed(points.exponent);
        angle.add_slope(-slopes.preload, &(force * ray.sin_beta));
        angle.add_slope(-slopes.torque, &(force * turning));
        angle.add_slope(-slopes.sideways, &(force * in_plane));
    }
    Ok((found.status, angle))
}

/// +1 or -1.
fn direction(load: &Load) -> f64 {
    1.0_f64.copysign(load.torque_Nm())
}

/// Thresholds of both pairs, N.
fn thresholds_of(
    drive: &Drive,
    load: &Load,
    seeded: &Seeded,
    [deceleration_rad, equal_speed_rad]: [[f64; 3]; 2],
) -> [ThresholdSensitivities; 2] {
    let (torque, sign) = (seeded.0[TORQUE], direction(load));
    let open = |phase: f64| Dual::parameter(phase, PHASE);
    let undercut = undercuts(drive);
    let deceleration = |kind: usize| {
        let row = points::deceleration(drive, seeded, open(deceleration_rad[kind]), sign);
        let found = if undercut { None } else { thresholds::decided(&[row], kind) };
        found.map(|per_torque| per_torque.times(torque))
    };
    let still =
        matches!(drive.equal_speed(), EqualSpeed::CrossSlide(_)) && drive.equal_speed_period_rad().is_none();
    let share = drive.equal_speed_share();
    let equal_speed = |kind: usize| {
        let phase = equal_speed_rad[kind];
        let phase = if still { Dual::constant(phase) } else { open(phase) };
        let rows = points::equal_speed(drive, seeded, phase, sign);
        thresholds::decided(&rows, kind).map(|per_torque| per_torque.times(torque * share))
    };
    [[0, 1, 2].map(deceleration), [0, 1, 2].map(equal_speed)]
}
