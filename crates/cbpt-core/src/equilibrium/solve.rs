//! Solution of one pair's equations: existence first, then the iteration, then the check.

use nalgebra::SMatrix;

use super::{PairEquilibrium, State};
use crate::pair::MeshingPoints;
use crate::solver::newton_lm::{self, Options};
use crate::status::Status;

/// Displacements beyond this share of the ball radius are no longer small.
pub const SMALL_DISPLACEMENT: f64 = 0.05;

/// The solved unknowns of one row of a pair, and how they were found.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PairState {
    /// Unknowns of one row; the pair's angle is this rotation times its rows.
    pub state: State,
    /// Torsional stiffness dM0/dalpha of one row at constant preload, N m/rad.
    pub torsional_stiffness_Nm_per_rad: f64,
    /// Largest scaled residual, evaluated at the returned state.
    pub residual: f64,
    /// Solver steps.
    pub steps: u32,
}

/// Solves a pair at torque M0 (N m) and preload N_Z (N, above 0).
///
/// The first element says how it ended; the second is there exactly when [`Status::has_solution`].
pub fn solve_pair(points: &MeshingPoints, torque_Nm: f64, preload_N: f64) -> (Status, Option<PairState>) {
    if points.floats_sideways {
        solve_in::<3>(points, torque_Nm, preload_N)
    } else {
        solve_in::<2>(points, torque_Nm, preload_N)
    }
}

fn solve_in<const N: usize>(
    points: &MeshingPoints,
    torque_Nm: f64,
    preload_N: f64,
) -> (Status, Option<PairState>) {
    let holding_arm = points.holding_arm_m(torque_Nm.signum());
    let never = torque_Nm != 0.0 && holding_arm <= 0.0;
    // A spring that is relaxed takes up preload as the plates part, so with it any torque finds a balance.
    let springless = points.axial_spring_N_per_m <= 0.0;
    if never || (springless && torque_Nm.abs() >= preload_N * holding_arm && torque_Nm != 0.0) {
        return (Status::BeyondHold { hold_preload_N: torque_Nm.abs() / holding_arm }, None);
    }
    let unloaded_approach_m = if springless { Ok(0.0) } else { unloaded_approach_m::<N>(points, preload_N) };
    let balance = unloaded_approach_m.and_then(|d0| balance::<N>(points, torque_Nm, preload_N, d0));
    let Balance { state, jacobian, residual, steps } = match balance {
        Ok(balance) => balance,
        Err(status) => return (status, None),
    };
    let Some(torsional_stiffness_Nm_per_rad) = torsional_stiffness(&jacobian) else {
        return (Status::Indeterminate, None);
    };
    let solved = PairState { state, torsional_stiffness_Nm_per_rad, residual, steps };
    let largest = (points.largest_arm_m() * state.rotation_rad)
        .abs()
        .max(state.approach_m().abs())
        .max(state.sideways_m.abs());
    let small = largest <= SMALL_DISPLACEMENT * points.ball_radius_m;
    (if small { Status::Solved } else { Status::OutsideSmallDisplacements }, Some(solved))
}

/// Where the forces balance; what resists a rotation there is not asked.
struct Balance<const N: usize> {
    state: State,
    /// Of the unscaled equations.
    jacobian: SMatrix<f64, N, N>,
    residual: f64,
    steps: u32,
}

fn balance<const N: usize>(
    points: &MeshingPoints,
    torque_Nm: f64,
    preload_N: f64,
    unloaded_approach_m: f64,
) -> Result<Balance<N>, Status> {
    let equations = PairEquilibrium::new(points, torque_Nm, preload_N, unloaded_approach_m)
        .ok_or(Status::BeyondHold { hold_preload_N: f64::INFINITY })?;
    let options = Options::default();
    let stop = newton_lm::solve(&equations, PairEquilibrium::start::<N>(), options);
    let residual = equations.largest_residual(&stop.at.residual);
    if residual.is_nan() || residual > options.tolerance {
        return Err(Status::NotConverged { residual });
    }
    let (state, jacobian) = (equations.state(&stop.x), equations.unscaled_jacobian(&stop.at.jacobian));
    Ok(Balance { state, jacobian, residual, steps: stop.steps })
}

/// d0, the approach under the preload alone, from which the axial spring is relaxed, m.
///
/// It is one number even where nothing resists a rotation: the forces sum up the levers to (N_Z, 0, 0), so a motion that
/// deforms no loaded diagonal has no approach.
fn unloaded_approach_m<const N: usize>(points: &MeshingPoints, preload_N: f64) -> Result<f64, Status> {
    let unsprung = MeshingPoints { axial_spring_N_per_m: 0.0, ..points.clone() };
    balance::<N>(&unsprung, 0.0, preload_N, 0.0).map(|unloaded| unloaded.state.approach_m())
}

/// dM0/dalpha with the other unknowns free: one over the rotation's diagonal element of the inverse Jacobian.
fn torsional_stiffness<const N: usize>(jacobian: &SMatrix<f64, N, N>) -> Option<f64> {
    let scale = jacobian.diagonal().map(|d| d.abs().sqrt().recip());
    let scaled = SMatrix::<f64, N, N>::from_fn(|i, j| jacobian[(i, j)] * scale[i] * scale[j]);
    let compliance = scaled.try_inverse()?[(1, 1)] * scale[1] * scale[1];
    (compliance.is_finite() && compliance > 0.0).then(|| 1.0 / compliance)
}
