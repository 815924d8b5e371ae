//! Many loads on one pair, side by side in the lanes of the processor's vector registers.
//!
//! - here: which loads may run here, and what comes out; `kernel`: the iteration; `curve`: its start;
//! - `alone`: the iteration where the contacts fill the lanes, not the loads; [`nearby`]: with it from a start nearby, and how
//!   the rotation answers;
//! - [`contacts`]: the sums of any pair's equations and answers, which are all of it that the scalar solver has in lanes.
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

mod alone;
pub mod contacts;
mod curve;
mod kernel;
pub mod nearby;
mod powers;

use std::sync::OnceLock;

use super::solve::{smallness, solve_ready};
use super::{Levers, ReadyPair, State};
use crate::pair::MeshingPoints;
use crate::status::Status;
use alone::Block;
use curve::Curve;
use kernel::Contact;
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

/// What makes numbers of a homogeneous pair those of its scaled equations.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Scale {
    /// Approach under a preload of 1 N, m.
    approach_at_1N_m: f64,
    /// By which the arms are scaled, m.
    torque_scale_m: f64,
    per_torque_scale: f64,
    largest_cot: f64,
}

impl Scale {
    fn of(pair: &ReadyPair) -> Self {
        Self {
            approach_at_1N_m: pair.rigid_approach_m(1.0),
            torque_scale_m: pair.largest_torque_per_preload_m,
            per_torque_scale: 1.0 / pair.largest_torque_per_preload_m,
            largest_cot: pair.largest_cot,
        }
    }

    /// None where nothing carries.
    fn contacts(&self, pair: &ReadyPair) -> impl Iterator<Item = Contact> {
        let levers = if self.torque_scale_m > 0.0 { pair.levers.as_slice() } else { &[] };
        let (per_torque_scale, per_cot) = (self.per_torque_scale, 1.0 / self.largest_cot);
        let per_force = 1.0 / pair.axial_force_at_1m_N;
        levers.iter().map(move |levers| Contact {
            levers: [levers.axial, levers.turning_m * per_torque_scale, levers.in_plane * per_cot],
            stiffness: levers.stiffness * per_force,
        })
    }

    /// Whether the load is held and what it leads to are numbers far from their ends.
    fn holds(pair: &ReadyPair, torque_Nm: f64, preload_N: f64) -> bool {
        PRELOADS_N.contains(&preload_N) && torque_Nm.abs() < preload_N * pair.holding_arm_m(torque_Nm)
    }

    /// The scaled pivot of a load.
    fn pivot(&self, torque_Nm: f64, preload_N: f64) -> f64 {
        torque_Nm / preload_N * self.per_torque_scale
    }

    /// Scaled unknowns to SI, with the approach under the preload alone (m).
    fn state(&self, found: &kernel::Found, approach_m: f64) -> State {
        State {
            rotation_rad: found.x[1] * approach_m * self.per_torque_scale,
            sideways_m: found.x[2] * approach_m / self.largest_cot,
            pivot_approach_m: found.x[0] * approach_m,
            pivot_m: found.pivot * self.torque_scale_m,
        }
    }
}

/// A pair, ready for many loads.
#[derive(Debug)]
pub struct LanePair {
    pair: ReadyPair,
    /// Scaled; empty where the pair is not homogeneous.
    contacts: Vec<Contact>,
    /// The same side by side, instead, for a single load.
    blocks: Vec<Block>,
    scale: Scale,
    /// How many loads were announced.
    loads: usize,
    /// For torques to the negative and to the positive side.
    curves: [OnceLock<Option<Curve>>; 2],
}

impl LanePair {
    /// Ready for about `loads` loads: many are worth more preparation.
    pub fn new(points: &MeshingPoints, loads: usize) -> Self {
        let mut pair = Self::unprepared(points, loads);
        if homogeneous(&pair.pair) {
            pair.contacts = pair.scale.contacts(&pair.pair).collect();
        }
        if loads >= CURVE_PAYS_FROM {
            pair.contacts = kernel::merged(pair.contacts);
        }
        pair
    }

    /// Ready for a single load, whose contacts run side by side.
    pub fn for_one(points: &MeshingPoints) -> Self {
        let mut pair = Self::unprepared(points, 1);
        if homogeneous(&pair.pair) {
            pair.blocks = alone::in_blocks(pair.scale.contacts(&pair.pair), pair.pair.levers.len());
        }
        pair
    }

    fn unprepared(points: &MeshingPoints, loads: usize) -> Self {
        let pair = ReadyPair::new(points);
        Self {
            contacts: Vec::new(),
            blocks: Vec::new(),
            scale: Scale::of(&pair),
            pair,
            loads,
            curves: [const { OnceLock::new() }; 2],
        }
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
                let found = Scale::holds(&self.pair, torque, preload).then(|| {
                    let pivot = self.scale.pivot(torque, preload);
                    alone::run(&self.blocks, self.pair.floats_sideways, pivot, kernel::COLD)
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
            held[count] = Scale::holds(&self.pair, torque, preload);
            let pivot = if held[count] { self.scale.pivot(torque, preload) } else { 0.0 };
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

    fn outcome(
        &self,
        torque_Nm: f64,
        preload_N: f64,
        preload_power: f64,
        found: Option<kernel::Found>,
    ) -> LaneOutcome {
        if let Some(found) = found.filter(kernel::Found::is_solved) {
            let state = self.scale.state(&found, self.scale.approach_at_1N_m * preload_power);
            let status = smallness(&self.pair, &state);
            let (rotation_rad, residual, steps) = (state.rotation_rad, found.residual, found.steps);
            return LaneOutcome { status, rotation_rad, residual, steps };
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
        let make = || Curve::new(&self.pair, &self.contacts, sign, self.scale.torque_scale_m, self.loads);
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
fn homogeneous(pair: &ReadyPair) -> bool {
    pair.law.is_hertz() && pair.axial_spring_N_per_m == 0.0 && pair.levers.iter().all(Levers::has_no_offset)
}
