//! How a solved pair answers to the numbers it depends on, by the implicit function theorem.
//!
//! With the equations r(x, q) = 0 and J = dr/dx, symmetric, an unknown u = c . x has du/dq = -lambda . dr/dq with
//! J lambda = c: one small system for all q. Per diagonal, with its levers l (its deformation per unknown), force N,
//! slope s = dN/d delta and w = lambda . l:
//!
//! - torque and preload: du/dM0 = lambda_alpha, du/dN_Z = lambda_d;
//! - stiffness: du/d ln k = -N w;
//! - offsets: du/dzeta = -s w sin(beta), du/dg = -s w, du/dp = -+ s w cos(beta);
//! - contact angle: -(s ddelta/dbeta + N dln k/dbeta) w - N lambda . dl/dbeta;
//! - exponent: -N ln(delta/delta_0) w.
//!
//! An axial spring is N_Z - k_c (d - d0) in place of N_Z, and d0, the approach without torque, answers in the same way.
//! All in coordinates about the load's line of action (see the parent), which is only another choice of unknowns.

use nalgebra::{SMatrix, SVector};

use super::lanes::contacts::{ByContact, Wanted};
use super::solve::{Balance, balance, existence, smallness, unloaded};
use super::{PairEquilibrium, ReadyPair, State};
use crate::solver::newton_lm::solve_symmetric;
use crate::status::Status;

/// A change of the gaps at every diagonal of a pair for one unit of a parameter: zeta, g and p, each m per unit.
pub type GapShape = Vec<[f64; 3]>;

/// What is asked for beside the answers to torque and preload.
#[derive(Debug, Clone, Copy, Default)]
pub struct Asked<'a> {
    /// d ln k / d beta of every contact, 1/rad, where the answer to the contact angle is wanted.
    pub stiffness_slopes_per_rad: Option<&'a ByContact>,
    /// Whether the answer to the stiffness is wanted.
    pub stiffness: bool,
    /// Whether the answer to the exponent is wanted.
    pub exponent: bool,
    /// Whether the answer to an axial spring is wanted.
    pub spring: bool,
    /// What the shapes of the gaps whose answers are wanted add to the deformations ([`ReadyPair::closing`]).
    pub gaps: &'a [ByContact],
}

impl Asked<'_> {
    fn by_point(&self) -> bool {
        self.stiffness || self.exponent || self.stiffness_slopes_per_rad.is_some() || !self.gaps.is_empty()
    }
}

/// Derivatives of an unknown (rotation or approach); all per row of the pair, at the torque that it carries.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Slopes {
    /// Per torque, 1/(N m).
    pub torque: f64,
    /// Per preload, 1/N.
    pub preload: f64,
    /// Per force across the grooves on a plate that floats sideways, 1/N; 0 for every other pair.
    pub sideways: f64,
    /// Per axial spring stiffness, m/N.
    pub spring: f64,
    /// Per logarithm of the stiffness of all diagonals.
    pub log_stiffness: f64,
    /// Per contact angle, 1/rad.
    pub contact_angle: f64,
    /// Per exponent of the contact law.
    pub exponent: f64,
    /// Per unit of each gap shape.
    pub gaps: Vec<f64>,
}

impl Slopes {
    /// Adds `weight` times other slopes, but for those of the spring.
    fn add(&mut self, weight: f64, other: &Self) {
        self.preload += weight * other.preload;
        self.log_stiffness += weight * other.log_stiffness;
        self.contact_angle += weight * other.contact_angle;
        self.exponent += weight * other.exponent;
        for (gap, other) in self.gaps.iter_mut().zip(&other.gaps) {
            *gap += weight * other;
        }
    }
}

/// A pair in equilibrium and how its rotation answers.
#[derive(Debug, Clone, PartialEq)]
pub struct Response {
    /// Whether the displacements are small.
    pub status: Status,
    /// Unknowns of one row.
    pub state: State,
    /// Unknowns without torque, where there is an axial spring or its answer is wanted.
    pub unloaded: Option<State>,
    /// Derivatives of the rotation of one row.
    pub rotation: Slopes,
    /// Largest scaled residual.
    pub residual: f64,
    /// How many diagonals of one row carry.
    pub carrying: usize,
    /// How many diagonals of one row exist but have parted.
    pub parted: usize,
}

/// Solves a pair under a torque (N m) and preload (N), from states nearby where there are any, and says how its rotation
/// answers to what is asked.
///
/// # Errors
/// The status, where there is no solution.
pub fn respond(
    pair: &ReadyPair,
    load: [f64; 2],
    nearby: [Option<&State>; 2],
    asked: Asked<'_>,
) -> Result<Response, Status> {
    if pair.floats_sideways {
        respond_in::<3>(pair, load, nearby, asked)
    } else {
        respond_in::<2>(pair, load, nearby, asked)
    }
}

fn respond_in<const N: usize>(
    pair: &ReadyPair,
    [torque_Nm, preload_N]: [f64; 2],
    [nearby, unloaded_nearby]: [Option<&State>; 2],
    asked: Asked<'_>,
) -> Result<Response, Status> {
    if preload_N <= 0.0 {
        let holding_arm_m = pair.holding_arm_m(torque_Nm);
        return Err(Status::BeyondHold { hold_preload_N: torque_Nm.abs() / holding_arm_m });
    }
    existence(pair, torque_Nm, preload_N)?;
    let sprung = pair.axial_spring_N_per_m > 0.0 || asked.spring;
    let unloaded = if sprung { Some(unloaded::<N>(pair, preload_N, unloaded_nearby)?) } else { None };
    let d0 = unloaded.as_ref().map(|unloaded| unloaded.state().approach_m());
    let balance = balance::<N>(pair, torque_Nm, preload_N, d0, nearby)?;
    let state = balance.state();
    let mut rotation = slopes(&balance, SVector::from_fn(|i, _| f64::from(i == 1)), asked)?;
    if let Some(unloaded) = &unloaded {
        rotation.spring = -rotation.preload * (state.approach_m() - d0.unwrap_or(0.0));
        if pair.axial_spring_N_per_m > 0.0 {
            // What d0 gains is as much more preload as the spring gives for it.
            let approach = slopes(unloaded, SVector::from_fn(|i, _| f64::from(i == 0)), asked)?;
            rotation.add(rotation.preload * pair.axial_spring_N_per_m, &approach);
        }
    }
    let carrying = pair.contacts().carrying::<N>(&state);
    Ok(Response {
        status: smallness(pair, &state),
        state,
        unloaded: unloaded.map(|unloaded| unloaded.state()),
        rotation,
        residual: balance.residual,
        carrying,
        parted: pair.levers.len() - carrying,
    })
}

/// Derivatives of the unknown that `chosen` picks: the approach (about the axis, with no torque) or the rotation.
fn slopes<const N: usize>(
    balance: &Balance<'_, N>,
    chosen: SVector<f64, N>,
    asked: Asked<'_>,
) -> Result<Slopes, Status> {
    let e = &balance.equations;
    let (unknown, equation) = (e.unknown_scale, e.equation_scale);
    let right = SVector::from_fn(|i, _| chosen[i] / equation[i]);
    let scaled = solve_symmetric(balance.jacobian, right)
        .or_else(|| solve_symmetric(stiffened(balance.jacobian), right).filter(|_| chosen[1] == 0.0))
        .ok_or(Status::Indeterminate)?;
    let lambda = SVector::<f64, N>::from_fn(|i, _| scaled[i] * unknown[i]);
    let mut slopes = Slopes {
        torque: lambda[1],
        preload: lambda[0] - e.pivot_m * lambda[1],
        sideways: if N > 2 { lambda[2] } else { 0.0 },
        gaps: vec![0.0; asked.gaps.len()],
        ..Slopes::default()
    };
    if asked.by_point() {
        let wanted = Wanted {
            stiffness_slopes_per_rad: asked.stiffness_slopes_per_rad.map(Vec::as_slice),
            exponent: asked.exponent,
            gaps: asked.gaps,
        };
        let lambda = std::array::from_fn(|i| lambda[i]);
        let contacts = e.pair.contacts();
        let answers = contacts.answers::<N>(&balance.state(), lambda, wanted, &mut slopes.gaps);
        slopes.log_stiffness = answers.log_stiffness;
        slopes.contact_angle = answers.contact_angle;
        slopes.exponent = answers.exponent;
    }
    Ok(slopes)
}

/// Where nothing resists a rotation the approach is one number all the same (see [`unloaded`]), and so are its slopes: a
/// little resistance to everything finds them.
fn stiffened<const N: usize>(jacobian: SMatrix<f64, N, N>) -> SMatrix<f64, N, N> {
    jacobian + SMatrix::identity() * (1e-12 * jacobian.diagonal().amax())
}

impl PairEquilibrium<'_> {
    /// A state in SI to scaled unknowns.
    pub(super) fn unknowns<const N: usize>(&self, state: &State) -> SVector<f64, N> {
        let about_pivot = [
            state.pivot_approach_m + (self.pivot_m - state.pivot_m) * state.rotation_rad,
            state.rotation_rad,
            state.sideways_m,
        ];
        SVector::from_fn(|i, _| about_pivot[i] / self.unknown_scale[i])
    }
}
