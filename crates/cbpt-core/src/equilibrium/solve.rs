//! Solution of one pair's equations: existence first, then the iteration, then the check.

use nalgebra::{SMatrix, SVector};

use super::{PairEquilibrium, ReadyPair, State};
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
    solve_ready(&ReadyPair::new(points), torque_Nm, preload_N)
}

/// The same for a pair that is ready.
pub(super) fn solve_ready(pair: &ReadyPair, torque_Nm: f64, preload_N: f64) -> (Status, Option<PairState>) {
    let solved = if pair.floats_sideways {
        solve_in::<3>(pair, torque_Nm, preload_N)
    } else {
        solve_in::<2>(pair, torque_Nm, preload_N)
    };
    match solved {
        Ok(solved) => (smallness(pair, &solved.state), Some(solved)),
        Err(status) => (status, None),
    }
}

fn solve_in<const N: usize>(pair: &ReadyPair, torque_Nm: f64, preload_N: f64) -> Result<PairState, Status> {
    existence(pair, torque_Nm, preload_N)?;
    let unloaded_approach_m = if pair.axial_spring_N_per_m > 0.0 {
        Some(unloaded::<N>(pair, preload_N, None)?.state().approach_m())
    } else {
        None
    };
    let balance = balance::<N>(pair, torque_Nm, preload_N, unloaded_approach_m, None)?;
    let jacobian = balance.equations.unscaled_jacobian(&balance.jacobian);
    let torsional_stiffness_Nm_per_rad = torsional_stiffness(&jacobian).ok_or(Status::Indeterminate)?;
    let (state, residual, steps) = (balance.state(), balance.residual, balance.steps);
    Ok(PairState { state, torsional_stiffness_Nm_per_rad, residual, steps })
}

/// Whether the pair can hold the load: its limit is a closed form.
///
/// A spring that is relaxed takes up preload as the plates part, so with it any torque finds a balance.
pub(super) fn existence(pair: &ReadyPair, torque_Nm: f64, preload_N: f64) -> Result<(), Status> {
    let holding_arm = pair.holding_arm_m(torque_Nm);
    let springless = pair.axial_spring_N_per_m <= 0.0;
    let beyond = holding_arm <= 0.0 || (springless && torque_Nm.abs() >= preload_N * holding_arm);
    if torque_Nm != 0.0 && beyond {
        return Err(Status::BeyondHold { hold_preload_N: torque_Nm.abs() / holding_arm });
    }
    Ok(())
}

/// Whether the displacements are small against the balls.
pub(super) fn smallness(pair: &ReadyPair, state: &State) -> Status {
    let largest = (pair.largest_arm_m * state.rotation_rad)
        .abs()
        .max(state.approach_m().abs())
        .max(state.sideways_m.abs());
    if largest <= SMALL_DISPLACEMENT * pair.ball_radius_m {
        Status::Solved
    } else {
        Status::OutsideSmallDisplacements
    }
}

/// Where the forces balance; what resists a rotation there is not asked.
pub(super) struct Balance<'a, const N: usize> {
    pub equations: PairEquilibrium<'a>,
    pub x: SVector<f64, N>,
    /// Of the scaled equations.
    pub jacobian: SMatrix<f64, N, N>,
    pub residual: f64,
    pub steps: u32,
}

impl<const N: usize> Balance<'_, N> {
    pub fn state(&self) -> State {
        self.equations.state(&self.x)
    }
}

/// A start nearby is worth so many steps; beyond them the cold start is taken. Further digits than `floor` are not sought.
const WARM: Options = Options { tolerance: 1e-11, floor: 1e-14, most_steps: 16 };

/// The balance from a state nearby, if there is one and it leads there, or from the cold start.
pub(super) fn balance<'a, const N: usize>(
    pair: &'a ReadyPair,
    torque_Nm: f64,
    preload_N: f64,
    unloaded_approach_m: Option<f64>,
    nearby: Option<&State>,
) -> Result<Balance<'a, N>, Status> {
    let equations = PairEquilibrium::new(pair, torque_Nm, preload_N, unloaded_approach_m)
        .ok_or(Status::BeyondHold { hold_preload_N: f64::INFINITY })?;
    let cold = || (PairEquilibrium::start::<N>(), Options::default());
    let starts = nearby.map(|state| (equations.unknowns::<N>(state), WARM)).into_iter();
    let mut stopped_at = f64::NAN;
    for (start, options) in starts.chain(std::iter::once_with(cold)) {
        let stop = newton_lm::solve(&equations, start, options);
        let residual = equations.largest_residual(&stop.at.residual);
        if residual <= options.tolerance {
            let (x, jacobian, steps) = (stop.x, stop.at.jacobian, stop.steps);
            return Ok(Balance { equations, x, jacobian, residual, steps });
        }
        stopped_at = residual;
    }
    Err(Status::NotConverged { residual: stopped_at })
}

/// The balance under the preload alone, whose approach is the d0 from which the axial spring is relaxed.
///
/// That is one number even where nothing resists a rotation: the forces sum up the levers to (N_Z, 0, 0), so a motion
/// that deforms no loaded diagonal has no approach.
pub(super) fn unloaded<'a, const N: usize>(
    pair: &'a ReadyPair,
    preload_N: f64,
    nearby: Option<&State>,
) -> Result<Balance<'a, N>, Status> {
    balance::<N>(pair, 0.0, preload_N, None, nearby)
}

/// dM0/dalpha with the other unknowns free: one over the rotation's diagonal element of the inverse Jacobian.
fn torsional_stiffness<const N: usize>(jacobian: &SMatrix<f64, N, N>) -> Option<f64> {
    let scale = jacobian.diagonal().map(|d| d.abs().sqrt().recip());
    let scaled = SMatrix::<f64, N, N>::from_fn(|i, j| jacobian[(i, j)] * scale[i] * scale[j]);
    let compliance = scaled.try_inverse()?[(1, 1)] * scale[1] * scale[1];
    (compliance.is_finite() && compliance > 0.0).then(|| 1.0 / compliance)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The inverse of [[4, 2], [2, 3]] has 4/8 on the diagonal.
    #[test]
    fn stiffness_is_one_over_the_compliance() {
        let found = torsional_stiffness(&SMatrix::<f64, 2, 2>::new(4.0, 2.0, 2.0, 3.0));
        assert!(found.is_some_and(|stiffness| (stiffness - 2.0).abs() < 1e-14), "{found:?}");
    }

    /// A rotation that gains energy, one that nothing resists, one that is resisted by less than numbers can tell.
    #[test]
    fn a_rotation_without_resistance_has_no_stiffness() {
        for resistance in [-1.0, 0.0, 1e-320] {
            let jacobian = SMatrix::<f64, 2, 2>::new(1.0, 0.0, 0.0, resistance);
            assert_eq!(torsional_stiffness(&jacobian), None, "{resistance}");
        }
        // One that other motions would make rigid.
        let jacobian = SMatrix::<f64, 3, 3>::new(1.0, 0.5, 1.0, 0.5, 1.0, 0.0, 1.0, 0.0, 1.0);
        assert_eq!(torsional_stiffness(&jacobian), None);
    }
}
