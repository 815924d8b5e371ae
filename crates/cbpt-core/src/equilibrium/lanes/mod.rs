//! Many loads on one pair, side by side in the lanes of the processor's vector registers.
//!
//! - here: which loads may run here, and what comes out; `kernel`: the iteration; `curve`: its start.
//!
//! Contacts by Hertz's law without offsets, and a preload that no spring changes, make deformations linear in the
//! unknowns and the energy homogeneous. Scaled as in the parent, with the pivot A = M0/N_Z, the unknowns then are a
//! function of A alone, and all loads on a pair lie on one curve: w = N_Z^(2/3) w(A), alpha = N_Z^(2/3) alpha(A).
//!
//! [`super::solve`] stays the readable solver: it takes whatever is not done here after a few steps (at the edge of what
//! holds, nearly free motions) and everything that is not homogeneous. Existence and smallness are asked by its functions,
//! so statuses are the same; angles agree to 1e-10. A load's result does not depend on its neighbours; whether the curve is
//! made depends on how many loads are announced, which moves an angle by rounding. A geometry with a single load fills the
//! lanes with its contacts instead ([`LanePair::for_one`]).

// What runs in lanes must be inlined into the function that knows the instruction set; its loops over the unknowns read
// as the algebra does.
#![allow(clippy::inline_always, clippy::needless_range_loop)]

mod curve;
mod kernel;
mod powers;

use std::sync::OnceLock;

use super::solve::{smallness, solve_ready};
use super::{ReadyPair, State};
use crate::pair::{HERTZ_EXPONENT, MeshingPoint, MeshingPoints};
use crate::status::Status;
use curve::Curve;
use kernel::{Block, Contact};
pub use powers::two_thirds_powers;

/// Loads that are solved in one go.
pub const BATCH: usize = 128;
/// The same where a geometry has few loads: a whole batch would take longer to lay out than to solve.
pub const FEW: usize = 8;

/// Preloads far from any machine's are left to the scalar solver: at the ends of the numbers scaling back would lose them.
const PRELOADS_N: std::ops::RangeInclusive<f64> = 1e-9..=1e9;

/// From so many loads on, the curve is worth making.
const CURVE_PAYS_FROM: usize = 1024;

/// A load's outcome; the numbers count exactly when [`Status::has_solution`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LaneOutcome {
    /// How it ended.
    pub status: Status,
    /// Rotation of one row, rad.
    pub rotation_rad: f64,
    /// Largest scaled residual: of the returned state by the scalar solver, before a last Newton step here.
    pub residual: f64,
    /// Solver steps.
    pub steps: u32,
}

impl LaneOutcome {
    /// Nothing solved yet.
    pub const NONE: Self =
        Self { status: Status::Indeterminate, rotation_rad: f64::NAN, residual: f64::NAN, steps: 0 };
}

/// A pair, ready for many loads.
#[derive(Debug)]
pub struct LanePair {
    pair: ReadyPair,
    /// Scaled; empty where the pair is not homogeneous.
    contacts: Vec<Contact>,
    /// The same side by side, instead, for a single load.
    blocks: Vec<Block>,
    /// Approach under a preload of 1 N, m.
    approach_at_1N_m: f64,
    /// By which the arms are scaled, m.
    torque_scale_m: f64,
    per_torque_scale: f64,
    /// How many loads were announced.
    loads: usize,
    /// For torques to the negative and to the positive side.
    curves: [OnceLock<Option<Curve>>; 2],
}

impl LanePair {
    /// Ready for about `loads` loads: many are worth more preparation.
    pub fn new(points: &MeshingPoints, loads: usize) -> Self {
        let mut pair = Self::unprepared(points, loads);
        if homogeneous(points) {
            pair.contacts = pair.scaled_contacts().collect();
        }
        if loads >= CURVE_PAYS_FROM {
            pair.contacts = kernel::merged(pair.contacts);
        }
        pair
    }

    /// Ready for a single load, whose contacts run side by side.
    pub fn for_one(points: &MeshingPoints) -> Self {
        let mut pair = Self::unprepared(points, 1);
        if homogeneous(points) {
            pair.blocks = kernel::in_blocks(pair.scaled_contacts(), pair.pair.levers.len());
        }
        pair
    }

    fn unprepared(points: &MeshingPoints, loads: usize) -> Self {
        let pair = ReadyPair::new(points);
        Self {
            contacts: Vec::new(),
            blocks: Vec::new(),
            approach_at_1N_m: pair.rigid_approach_m(1.0),
            torque_scale_m: pair.largest_torque_per_preload_m,
            per_torque_scale: 1.0 / pair.largest_torque_per_preload_m,
            pair,
            loads,
            curves: [const { OnceLock::new() }; 2],
        }
    }

    /// None where nothing carries.
    fn scaled_contacts(&self) -> impl Iterator<Item = Contact> {
        let levers = if self.torque_scale_m > 0.0 { self.pair.levers.as_slice() } else { &[] };
        let per_cot = 1.0 / self.pair.largest_cot;
        let per_force = 1.0 / self.pair.axial_force_at_1m_N;
        levers.iter().map(move |levers| Contact {
            levers: [levers.axial, levers.turning_m * self.per_torque_scale, levers.in_plane * per_cot],
            stiffness: levers.stiffness * per_force,
        })
    }

    /// How many equal copies of this row are in series; their angles add.
    pub fn rows(&self) -> u32 {
        self.pair.rows()
    }

    /// Solves up to [`BATCH`] loads: torques (N m), preloads (N, above 0) and their [`two_thirds_powers`], all finite.
    ///
    /// Four slices of one length; what is longer than the shortest is left as it is.
    pub fn solve(
        &self,
        torque_Nm: &[f64],
        preload_N: &[f64],
        preload_powers: &[f64],
        outcomes: &mut [LaneOutcome],
    ) {
        if !self.blocks.is_empty() {
            let loads = torque_Nm.iter().zip(preload_N).zip(preload_powers).zip(outcomes);
            for (((&torque, &preload), &power), outcome) in loads {
                let found = self.holds(torque, preload).then(|| {
                    let pivot = torque / preload * self.per_torque_scale;
                    kernel::run_alone(&self.blocks, self.pair.floats_sideways, pivot)
                });
                *outcome = self.outcome(torque, preload, power, found);
            }
        } else if torque_Nm.len() <= FEW {
            self.solve_in::<FEW>(torque_Nm, preload_N, preload_powers, outcomes);
        } else {
            self.solve_in::<BATCH>(torque_Nm, preload_N, preload_powers, outcomes);
        }
    }

    fn solve_in<const B: usize>(
        &self,
        torque_Nm: &[f64],
        preload_N: &[f64],
        preload_powers: &[f64],
        outcomes: &mut [LaneOutcome],
    ) {
        let loads = torque_Nm.iter().zip(preload_N).take(if self.contacts.is_empty() { 0 } else { B });
        let mut batch = kernel::Batch::<B>::new();
        let mut held = [false; B];
        let mut sides = [false; 2];
        let mut count = 0;
        for (&torque, &preload) in loads {
            // A load that is not held is asked about below; meanwhile its lane must only do no harm.
            held[count] = self.holds(torque, preload);
            let pivot = if held[count] { torque / preload * self.per_torque_scale } else { 0.0 };
            batch.set_pivot(count, pivot);
            sides[usize::from(pivot >= 0.0)] = true;
            count += 1;
        }
        let curves = [self.curve(0, sides[0]), self.curve(1, sides[1])];
        batch.start(count, |pivot| {
            curves[usize::from(pivot >= 0.0)].map_or(kernel::COLD, |curve| curve.at(pivot))
        });
        kernel::run(&self.contacts, self.pair.floats_sideways, &mut batch, count);
        let loads = torque_Nm.iter().zip(preload_N).zip(preload_powers).zip(outcomes);
        for (lane, (((&torque, &preload), &power), outcome)) in loads.take(B).enumerate() {
            *outcome = self.outcome(torque, preload, power, held[lane].then(|| batch.found(lane)));
        }
    }

    fn holds(&self, torque_Nm: f64, preload_N: f64) -> bool {
        PRELOADS_N.contains(&preload_N) && torque_Nm.abs() < preload_N * self.pair.holding_arm_m(torque_Nm)
    }

    fn outcome(
        &self,
        torque_Nm: f64,
        preload_N: f64,
        preload_power: f64,
        found: Option<kernel::Found>,
    ) -> LaneOutcome {
        if let Some(kernel::Found { pivot, x, residual, steps }) = found.filter(kernel::Found::is_solved) {
            let approach_m = self.approach_at_1N_m * preload_power;
            let state = State {
                rotation_rad: x[1] * approach_m * self.per_torque_scale,
                sideways_m: x[2] * approach_m / self.pair.largest_cot,
                pivot_approach_m: x[0] * approach_m,
                pivot_m: pivot * self.torque_scale_m,
            };
            let status = smallness(&self.pair, &state);
            return LaneOutcome { status, rotation_rad: state.rotation_rad, residual, steps };
        }
        match solve_ready(&self.pair, torque_Nm, preload_N) {
            (status, Some(solved)) => LaneOutcome {
                status,
                rotation_rad: solved.state.rotation_rad,
                residual: solved.residual,
                steps: solved.steps,
            },
            (status, None) => LaneOutcome { status, rotation_rad: f64::NAN, residual: f64::NAN, steps: 0 },
        }
    }

    /// The curve to one side, where loads ask for it and are many enough.
    fn curve(&self, side: usize, asked: bool) -> Option<&Curve> {
        let sign = if side == 1 { 1.0 } else { -1.0 };
        let make = || Curve::new(&self.pair, &self.contacts, sign, self.torque_scale_m, self.loads);
        if asked && self.loads >= CURVE_PAYS_FROM {
            self.curves[side].get_or_init(make).as_ref()
        } else {
            None
        }
    }
}

/// Whether nothing but Hertz's law acts, so that the energy is homogeneous in the unknowns.
// Neutral values are set, never computed.
#[allow(clippy::float_cmp)]
fn homogeneous(points: &MeshingPoints) -> bool {
    points.exponent == HERTZ_EXPONENT
        && points.axial_spring_N_per_m == 0.0
        && points.points.iter().all(MeshingPoint::has_no_offset)
}
