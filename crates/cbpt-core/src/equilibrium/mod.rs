//! Equilibrium of a pair: meshing points and load to residual and Jacobian.
//!
//! - here: the equations; [`ready`]: what of them does not depend on the load;
//! - [`solve`]: their solution, [`PairState`](solve::PairState); [`lanes`]: many loads side by side;
//! - [`response`]: the same from a start nearby, and how it answers to every number that it depends on;
//! - [`report`]: what it means at each meshing point, [`PairSolution`](report::PairSolution);
//! - [`proof`]: intervals in which it lies for certain, [`PairEnclosure`](proof::PairEnclosure).
//!
//! Unknowns: approach d, rotation alpha and, where the plate floats sideways, its shift t. Per diagonal
//! delta = (d + zeta) sin(beta) + g +- (a alpha + p + t) cos(beta), N = k max(delta, 0)^1.5 (or another exponent n:
//! N = k delta_0^1.5 (delta/delta_0)^n with `delta_0` = 1 um).
//!
//! - axial:     sum N sin(beta) = N_Z - k_c (d - d0)
//! - torque:    sum +- N cos(beta) a = M0
//! - sideways:  sum +- N cos(beta) = 0
//!
//! These are the gradient of the convex energy sum of k delta^2.5/2.5 + k_c (d - d0)^2/2 - N_Z d - M0 alpha, so below
//! the holding limit there is one solution and no other.
//!
//! Numerically the axial load is moved to its line of action: with the pivot A = M0/N_Z and d = w - A alpha the unknowns
//! are (w, alpha, t), a diagonal's lever on alpha becomes +- a cos(beta) - A sin(beta), and the torque equation's right
//! side is M0 - A N_Z = 0. Near the holding limit d and a alpha are large and nearly cancel; w and these levers do not.
//! With an axial spring M0/N_Z may lie far outside the balls, where nothing acts; A then stays at the holding arm H, the
//! outermost line on which contacts can carry, and M0 - A N_Z is not 0.
//!
//! Scaling: forces by F = max(N_Z, |M0|/H), the least preload that the points must see, torques by F max(|a| cot beta);
//! w by the approach under F, alpha and t so that the scaled equations stay a gradient. The scaled residual is what
//! [`crate::Status`] is judged by.

pub mod lanes;
pub mod proof;
pub mod ready;
pub mod report;
pub mod response;
pub mod solve;

use nalgebra::{SMatrix, SVector};

use crate::pair::{HERTZ_EXPONENT, MeshingPoint, REFERENCE_DEFORMATION_M};
use crate::solver::problem::{Evaluation, Problem};
pub use ready::ReadyPair;

/// Unknowns of a pair in SI units: approach, rotation, sideways shift.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct State {
    /// Rotation alpha of the output plate, rad.
    pub rotation_rad: f64,
    /// Sideways shift t of a floating plate, m; 0 for every other pair.
    pub sideways_m: f64,
    /// Approach w at the load's line of action, m.
    pivot_approach_m: f64,
    /// Distance A of that line from the axis, m.
    pivot_m: f64,
}

impl State {
    /// A state from approach d (m), rotation alpha (rad) and sideways shift t (m).
    pub fn new(approach_m: f64, rotation_rad: f64, sideways_m: f64) -> Self {
        Self { rotation_rad, sideways_m, pivot_approach_m: approach_m, pivot_m: 0.0 }
    }

    /// Axial approach d of the two plates at their axis, m.
    pub fn approach_m(&self) -> f64 {
        self.pivot_approach_m - self.pivot_m * self.rotation_rad
    }

    /// Deformation of a diagonal, m; below 0 the ball has parted from it by that much.
    pub fn deformation_m(&self, point: &MeshingPoint) -> f64 {
        Levers::new(0, point).deformation_m(self)
    }
}

/// A diagonal as the equations see it: what its deformation gains per unit of each unknown. Its force acts on each
/// equation with the same levers.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Levers {
    /// Place of the diagonal among all of its pair.
    index: usize,
    /// sin(beta), per approach.
    axial: f64,
    /// +- a cos(beta), per rotation about the axis, m.
    turning_m: f64,
    /// +- cos(beta), per sideways shift.
    in_plane: f64,
    arm_m: f64,
    axial_offset_m: f64,
    in_plane_offset_m: f64,
    /// Deformation at rest, from zeta, g and p, m.
    offset_m: f64,
    stiffness: f64,
}

impl Levers {
    fn new(index: usize, point: &MeshingPoint) -> Self {
        let in_plane = point.diagonal.sign() * point.cos_beta;
        let mut levers = Self {
            index,
            axial: point.sin_beta,
            turning_m: in_plane * point.arm_m,
            in_plane,
            arm_m: point.arm_m,
            axial_offset_m: 0.0,
            in_plane_offset_m: 0.0,
            offset_m: 0.0,
            stiffness: point.stiffness,
        };
        levers.add_offset([point.axial_offset_m, point.normal_offset_m, point.in_plane_offset_m]);
        levers
    }

    /// Adds to zeta, g and p, m.
    fn add_offset(&mut self, offset: [f64; 3]) {
        let [axial, _, in_plane] = offset;
        self.axial_offset_m += axial;
        self.in_plane_offset_m += in_plane;
        self.offset_m += self.closing(offset);
    }

    /// What zeta, g and p add to the deformation, m.
    fn closing(&self, [axial, normal, in_plane]: [f64; 3]) -> f64 {
        axial * self.axial + normal + in_plane * self.in_plane
    }

    /// Whether ball and grooves are nominal here.
    // Neutral values are set, never computed.
    #[allow(clippy::float_cmp)]
    fn has_no_offset(&self) -> bool {
        [self.axial_offset_m, self.in_plane_offset_m, self.offset_m] == [0.0; 3]
    }

    /// Per approach, rotation about a pivot and sideways shift.
    fn per_unknown(&self, pivot_m: f64) -> [f64; 3] {
        [self.axial, self.turning_m - pivot_m * self.axial, self.in_plane]
    }

    /// What the contact angle changes of these, per rad: d sin = cos, d(+- cos) = -+ sin.
    fn per_contact_angle(&self, pivot_m: f64) -> [f64; 3] {
        let (cos_beta, turned) = (self.in_plane.abs(), -self.in_plane.signum() * self.axial);
        [cos_beta, turned * self.arm_m - pivot_m * cos_beta, turned]
    }

    fn deformation_m(&self, state: &State) -> f64 {
        let [axial, rotation, sideways] = self.per_unknown(state.pivot_m);
        axial * state.pivot_approach_m
            + rotation * state.rotation_rad
            + sideways * state.sideways_m
            + self.offset_m
    }
}

/// Force of a contact law and its derivative with the deformation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContactLaw {
    exponent: f64,
    /// Factor on k: `delta_0`^(1.5 - n), 1 for Hertz.
    factor: f64,
}

impl ContactLaw {
    /// N = k `delta_0`^(1.5 - n) delta^n.
    pub fn new(exponent: f64) -> Self {
        Self { exponent, factor: REFERENCE_DEFORMATION_M.powf(HERTZ_EXPONENT - exponent) }
    }

    /// Force (N) of a diagonal of stiffness `stiffness` at `deformation_m`; 0 where it has parted.
    pub fn force_N(&self, stiffness: f64, deformation_m: f64) -> f64 {
        if deformation_m <= 0.0 { 0.0 } else { self.force_per_m(stiffness, deformation_m) * deformation_m }
    }

    /// Force over deformation (N/m) of a diagonal that is pressed, `deformation_m` > 0.
    fn force_per_m(&self, stiffness: f64, deformation_m: f64) -> f64 {
        let k = stiffness * self.factor;
        // Exactly Hertz in nearly every call, and a square root is far cheaper than a power.
        if self.is_hertz() { k * deformation_m.sqrt() } else { k * deformation_m.powf(self.exponent - 1.0) }
    }

    // A neutral value is set, never computed.
    #[allow(clippy::float_cmp)]
    fn is_hertz(&self) -> bool {
        self.exponent == HERTZ_EXPONENT
    }
}

/// A pair under a load, scaled, in N = 2 (approach, rotation) or 3 (and sideways shift) unknowns.
#[derive(Debug, Clone)]
pub struct PairEquilibrium<'a> {
    pair: &'a ReadyPair,
    preload_N: f64,
    /// A: M0/N_Z, at most the holding arm.
    pivot_m: f64,
    /// M0 - A N_Z.
    torque_about_pivot_Nm: f64,
    /// k_c and the approach d0 from which it is relaxed.
    spring_N_per_m: f64,
    unloaded_approach_m: f64,
    /// Size of each unknown: m, rad, m.
    unknown_scale: [f64; 3],
    /// Size of each equation: N, N m, N.
    equation_scale: [f64; 3],
}

impl<'a> PairEquilibrium<'a> {
    /// Scales the equations. `unloaded_approach_m` is d0, from which the axial spring is relaxed; without it no spring acts.
    ///
    /// `None` where no meshing point exists: nothing carries the preload.
    pub fn new(
        pair: &'a ReadyPair,
        torque_Nm: f64,
        preload_N: f64,
        unloaded_approach_m: Option<f64>,
    ) -> Option<Self> {
        let torque_scale = pair.largest_torque_per_preload_m;
        if torque_scale <= 0.0 {
            return None;
        }
        let holding_arm_m = pair.holding_arm_m(torque_Nm);
        let held = torque_Nm.abs() <= preload_N * holding_arm_m;
        let (pivot_m, torque_about_pivot_Nm, force_scale) = if held {
            (torque_Nm / preload_N, 0.0, preload_N)
        } else {
            let pivot_m = holding_arm_m.copysign(torque_Nm);
            (pivot_m, torque_Nm - pivot_m * preload_N, torque_Nm.abs() / holding_arm_m)
        };
        let approach = pair.rigid_approach_m(force_scale);
        let cot = pair.largest_cot;
        Some(Self {
            pair,
            preload_N,
            pivot_m,
            torque_about_pivot_Nm,
            spring_N_per_m: if unloaded_approach_m.is_some() { pair.axial_spring_N_per_m } else { 0.0 },
            unloaded_approach_m: unloaded_approach_m.unwrap_or(0.0),
            unknown_scale: [approach, approach / torque_scale, approach / cot],
            equation_scale: [force_scale, force_scale * torque_scale, force_scale * cot],
        })
    }

    /// The cold start: plates pressed together, no rotation.
    pub fn start<const N: usize>() -> SVector<f64, N> {
        SVector::from_fn(|i, _| if i == 0 { 1.0 } else { 0.0 })
    }

    /// Scaled unknowns to SI.
    pub fn state<const N: usize>(&self, x: &SVector<f64, N>) -> State {
        State {
            pivot_approach_m: x[0] * self.unknown_scale[0],
            pivot_m: self.pivot_m,
            rotation_rad: x[1] * self.unknown_scale[1],
            sideways_m: if N > 2 { x[2] * self.unknown_scale[2] } else { 0.0 },
        }
    }

    /// Largest of the scaled residuals of the axial, torque and sideways equation, the torque about the axis.
    pub fn largest_residual<const N: usize>(&self, about_pivot: &SVector<f64, N>) -> f64 {
        let mut about_axis = *about_pivot;
        about_axis[1] += self.pivot_m * self.equation_scale[0] / self.equation_scale[1] * about_pivot[0];
        about_axis.amax()
    }

    /// Jacobian of the unscaled equations (N, N m, N by w in m, rad, m) from the scaled one.
    pub fn unscaled_jacobian<const N: usize>(&self, scaled: &SMatrix<f64, N, N>) -> SMatrix<f64, N, N> {
        SMatrix::from_fn(|i, j| scaled[(i, j)] * self.equation_scale[i] / self.unknown_scale[j])
    }
}

impl<const N: usize> Problem<N> for PairEquilibrium<'_> {
    fn evaluate(&self, x: &SVector<f64, N>) -> Evaluation<N> {
        let state = self.state(x);
        let sums = self.pair.contacts().sums::<N>(&state);
        let mut energy = sums.work / (self.pair.law.exponent + 1.0);
        let mut residual = SVector::from(sums.forces);
        let mut jacobian = SMatrix::<f64, N, N>::from_fn(|i, j| sums.slopes[i.max(j)][i.min(j)]);
        let spring = self.spring_N_per_m;
        let travel = state.approach_m() - self.unloaded_approach_m;
        let lever = [1.0, -self.pivot_m, 0.0];
        energy += 0.5 * spring * travel * travel
            - self.preload_N * state.pivot_approach_m
            - self.torque_about_pivot_Nm * state.rotation_rad;
        residual[0] -= self.preload_N;
        residual[1] -= self.torque_about_pivot_Nm;
        for i in 0..N {
            residual[i] += spring * travel * lever[i];
            for j in 0..N {
                jacobian[(i, j)] += spring * lever[i] * lever[j];
            }
        }
        Evaluation {
            energy: energy / (self.equation_scale[0] * self.unknown_scale[0]),
            residual: SVector::from_fn(|i, _| residual[i] / self.equation_scale[i]),
            jacobian: SMatrix::from_fn(|i, j| {
                jacobian[(i, j)] * self.unknown_scale[j] / self.equation_scale[i]
            }),
        }
    }
}
