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

use super::solve::{SMALL_DISPLACEMENT, solve_pair};
use super::{Levers, PairEquilibrium, State};
use crate::pair::{MeshingPoint, MeshingPoints, REFERENCE_DEFORMATION_M};
use crate::solver::newton_lm::{self, Options, Stop, solve_symmetric};
use crate::solver::problem::Problem;
use crate::status::Status;

/// A start nearby is worth so many steps; beyond them the cold start is taken.
const WARM: Options = Options { tolerance: 1e-11, most_steps: 16 };

/// A change of the gaps at every diagonal of a pair for one unit of a parameter: zeta, g and p, each m per unit.
pub type GapShape = Vec<[f64; 3]>;

/// What is asked for beside the answers to torque and preload.
#[derive(Debug, Clone, Copy, Default)]
pub struct Asked<'a> {
    /// d ln k / d beta of every diagonal, 1/rad, where the answer to the contact angle is wanted.
    pub stiffness_slopes_per_rad: Option<&'a [f64]>,
    /// Whether the answers to stiffness and exponent are wanted.
    pub contact: bool,
    /// Whether the answer to an axial spring is wanted.
    pub spring: bool,
    /// Shapes of the gaps whose answers are wanted.
    pub gaps: &'a [GapShape],
}

impl Asked<'_> {
    fn by_point(&self) -> bool {
        self.contact || self.stiffness_slopes_per_rad.is_some() || !self.gaps.is_empty()
    }
}

/// Derivatives of an unknown (rotation or approach); all per row of the pair, at the torque that it carries.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Slopes {
    /// Per torque, 1/(N m).
    pub torque: f64,
    /// Per preload, 1/N.
    pub preload: f64,
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
    /// How many diagonals of one row carry.
    pub carrying: u32,
    /// How many diagonals of one row exist but have parted.
    pub parted: u32,
}

/// Solves a pair from states nearby where there are any, and says how its rotation answers to what is asked.
///
/// # Errors
/// The status, where there is no solution.
pub fn respond(
    points: &MeshingPoints,
    load: [f64; 2],
    start: Option<&State>,
    unloaded_start: Option<&State>,
    asked: Asked<'_>,
) -> Result<Response, Status> {
    if points.floats_sideways {
        respond_in::<3>(points, load, start, unloaded_start, asked)
    } else {
        respond_in::<2>(points, load, start, unloaded_start, asked)
    }
}

fn respond_in<const N: usize>(
    points: &MeshingPoints,
    [torque_Nm, preload_N]: [f64; 2],
    start: Option<&State>,
    unloaded_start: Option<&State>,
    asked: Asked<'_>,
) -> Result<Response, Status> {
    let spring = points.axial_spring_N_per_m;
    let holding_arm = points.holding_arm_m(torque_Nm.signum());
    let beyond = torque_Nm.abs() >= preload_N * holding_arm && torque_Nm != 0.0;
    if preload_N <= 0.0 || (beyond && (spring <= 0.0 || holding_arm <= 0.0)) {
        return Err(Status::BeyondHold { hold_preload_N: torque_Nm.abs() / holding_arm.max(0.0) });
    }
    let unloaded = if spring > 0.0 || asked.spring {
        Some(Unloaded::new::<N>(points, preload_N, unloaded_start, asked)?)
    } else {
        None
    };
    let d0 = unloaded.as_ref().map_or(0.0, |unloaded| unloaded.state.approach_m());
    let solved = Solved::<N>::near(points, torque_Nm, preload_N, d0, start)?;
    let state = solved.state();
    let mut rotation = solved.slopes(SVector::from_fn(|i, _| f64::from(i == 1)), asked)?;
    if let Some(unloaded) = &unloaded {
        rotation.spring = -rotation.preload * (state.approach_m() - d0);
        // What d0 gains is as much more preload as the spring gives for it.
        let per_d0 = rotation.preload * spring;
        rotation.add(per_d0, &unloaded.approach);
    }
    let existing = || points.points.iter().filter(|point| point.exists());
    let carrying = existing().filter(|point| state.deformation_m(point) > 0.0).count() as u32;
    let largest = (points.largest_arm_m() * state.rotation_rad)
        .abs()
        .max(state.approach_m().abs())
        .max(state.sideways_m.abs());
    let small = largest <= SMALL_DISPLACEMENT * points.ball_radius_m;
    Ok(Response {
        status: if small { Status::Solved } else { Status::OutsideSmallDisplacements },
        state,
        unloaded: unloaded.map(|unloaded| unloaded.state),
        rotation,
        carrying,
        parted: existing().count() as u32 - carrying,
    })
}

/// The pair without torque, from whose approach d0 the axial spring is relaxed.
struct Unloaded {
    state: State,
    /// Derivatives of d0.
    approach: Slopes,
}

impl Unloaded {
    fn new<const N: usize>(
        points: &MeshingPoints,
        preload_N: f64,
        start: Option<&State>,
        asked: Asked<'_>,
    ) -> Result<Self, Status> {
        let unsprung;
        let points = if points.axial_spring_N_per_m > 0.0 {
            unsprung = MeshingPoints { axial_spring_N_per_m: 0.0, ..points.clone() };
            &unsprung
        } else {
            points
        };
        let solved = Solved::<N>::near(points, 0.0, preload_N, 0.0, start)?;
        let approach = solved.slopes(SVector::from_fn(|i, _| f64::from(i == 0)), asked)?;
        Ok(Self { state: solved.state(), approach })
    }
}

/// Equations and the place where they hold.
struct Solved<'a, const N: usize> {
    points: &'a MeshingPoints,
    equations: PairEquilibrium<'a>,
    x: SVector<f64, N>,
    /// Of the scaled equations, there.
    jacobian: SMatrix<f64, N, N>,
}

impl<'a, const N: usize> Solved<'a, N> {
    fn near(
        points: &'a MeshingPoints,
        torque_Nm: f64,
        preload_N: f64,
        unloaded_approach_m: f64,
        start: Option<&State>,
    ) -> Result<Self, Status> {
        let equations = PairEquilibrium::new(points, torque_Nm, preload_N, unloaded_approach_m)
            .ok_or(Status::BeyondHold { hold_preload_N: f64::INFINITY })?;
        let warm = start.and_then(|start| {
            let stop = newton_lm::solve(&equations, equations.unknowns::<N>(start), WARM);
            holds(&equations, &stop).then_some((stop.x, stop.at.jacobian))
        });
        let (x, jacobian) = if let Some(found) = warm {
            found
        } else {
            let (status, cold) = solve_pair(points, torque_Nm, preload_N);
            let Some(cold) = cold else { return Err(status) };
            let x = equations.unknowns::<N>(&cold.state);
            (x, equations.evaluate(&x).jacobian)
        };
        Ok(Self { points, equations, x, jacobian })
    }

    fn state(&self) -> State {
        self.equations.state(&self.x)
    }

    /// Derivatives of the unknown that `chosen` picks: the approach (about the axis, with no torque) or the rotation.
    fn slopes(&self, chosen: SVector<f64, N>, asked: Asked<'_>) -> Result<Slopes, Status> {
        let e = &self.equations;
        let (unknown, equation) = (e.unknown_scale, e.equation_scale);
        let right = SVector::from_fn(|i, _| chosen[i] / equation[i]);
        let scaled = solve_symmetric(self.jacobian, right).ok_or(Status::Indeterminate)?;
        let lambda = SVector::<f64, N>::from_fn(|i, _| scaled[i] * unknown[i]);
        let mut slopes = Slopes {
            torque: lambda[1],
            preload: lambda[0] - e.pivot_m * lambda[1],
            gaps: vec![0.0; asked.gaps.len()],
            ..Slopes::default()
        };
        if asked.by_point() {
            let state = self.state();
            let existing = self.points.points.iter().enumerate().filter(|(_, point)| point.exists());
            for ((index, point), levers) in existing.zip(&e.levers) {
                self.add_point(&mut slopes, &lambda, &state, (index, point), levers, asked);
            }
        }
        Ok(slopes)
    }

    fn add_point(
        &self,
        slopes: &mut Slopes,
        lambda: &SVector<f64, N>,
        state: &State,
        (index, point): (usize, &MeshingPoint),
        levers: &Levers,
        asked: Asked<'_>,
    ) {
        let deformation = levers.deformation_m(state);
        if deformation <= 0.0 {
            return;
        }
        let (force, slope) = self.equations.law.force_and_slope(levers.stiffness, deformation);
        let along = |lever: [f64; 3]| (0..N).map(|i| lambda[i] * lever[i]).sum::<f64>();
        let w = along(levers.per_unknown);
        slopes.log_stiffness -= force * w;
        slopes.exponent -= force * (deformation / REFERENCE_DEFORMATION_M).ln() * w;
        let sign = point.diagonal.sign();
        if let Some(stiffness_slopes) = asked.stiffness_slopes_per_rad {
            let axial = state.approach_m() + point.axial_offset_m;
            let in_plane = point.arm_m * state.rotation_rad + point.in_plane_offset_m + state.sideways_m;
            let closing = point.cos_beta * axial - sign * point.sin_beta * in_plane;
            let turned = -sign * point.sin_beta;
            let levers_turned =
                [point.cos_beta, turned * point.arm_m - self.equations.pivot_m * point.cos_beta, turned];
            slopes.contact_angle -=
                (slope * closing + force * stiffness_slopes[index]) * w + force * along(levers_turned);
        }
        for (gap, shape) in slopes.gaps.iter_mut().zip(asked.gaps) {
            let [axial, normal, in_plane] = shape[index];
            *gap -= slope * w * (point.sin_beta * axial + normal + sign * point.cos_beta * in_plane);
        }
    }
}

fn holds<const N: usize>(equations: &PairEquilibrium<'_>, stop: &Stop<N>) -> bool {
    // False where it is not a number.
    equations.largest_residual(&stop.at.residual) <= WARM.tolerance
}

impl PairEquilibrium<'_> {
    /// A state in SI to scaled unknowns.
    fn unknowns<const N: usize>(&self, state: &State) -> SVector<f64, N> {
        let about_pivot = [
            state.pivot_approach_m + (self.pivot_m - state.pivot_m) * state.rotation_rad,
            state.rotation_rad,
            state.sideways_m,
        ];
        SVector::from_fn(|i, _| about_pivot[i] / self.unknown_scale[i])
    }
}
