//! The two equations of a pair for the crate `levenberg-marquardt`: scaled, with their exact Jacobian.

use cbpt_core::pair::MeshingPoints;
use levenberg_marquardt::{LeastSquaresProblem, LevenbergMarquardt};
use nalgebra::{Matrix2, Owned, U2, Vector2};

/// A contact of unit axial lever: arm times cot(beta) and stiffness, all scaled by the largest arm and the preload.
pub struct Pair {
    contacts: Vec<[f64; 2]>,
    arm_m: f64,
    approach_at_1N_m: f64,
}

impl Pair {
    pub fn new(points: &MeshingPoints) -> Self {
        let arm_m = points.points.iter().map(|point| point.torque_per_preload_m()).fold(0.0, f64::max);
        let axial: Vec<f64> = points.points.iter().map(|p| p.stiffness * p.sin_beta.powf(2.5)).collect();
        let total: f64 = axial.iter().sum();
        let contacts = points.points.iter().zip(&axial);
        Self {
            contacts: contacts.map(|(point, k)| [point.torque_per_preload_m() / arm_m, k / total]).collect(),
            arm_m,
            approach_at_1N_m: total.powf(-2.0 / 3.0),
        }
    }

    /// Rotation (rad) and largest scaled residual.
    pub fn solve(&self, torque_Nm: f64, preload_N: f64) -> (f64, f64) {
        let load = torque_Nm / (preload_N * self.arm_m);
        // The response at rest: cheap, and what an expert would start from.
        let compliance: f64 = self.contacts.iter().map(|[arm, k]| 1.5 * k * arm * arm).sum();
        let problem = Balance { pair: self, load, x: Vector2::new(1.0, load / compliance) };
        let solver = LevenbergMarquardt::new().with_ftol(1e-14).with_xtol(1e-14).with_gtol(1e-14);
        let (problem, _) = solver.minimize(problem);
        let residual = problem.evaluate().0.amax();
        (problem.x[1] * self.approach_at_1N_m * preload_N.powf(2.0 / 3.0) / self.arm_m, residual)
    }
}

struct Balance<'a> {
    pair: &'a Pair,
    load: f64,
    x: Vector2<f64>,
}

impl Balance<'_> {
    fn evaluate(&self) -> (Vector2<f64>, Matrix2<f64>) {
        let mut residual = Vector2::new(-1.0, -self.load);
        let (mut j00, mut j01, mut j11) = (0.0, 0.0, 0.0);
        for [arm, k] in &self.pair.contacts {
            let deformation = (self.x[0] + arm * self.x[1]).max(0.0);
            let slope = 1.5 * k * deformation.sqrt();
            let force = slope * deformation * (2.0 / 3.0);
            residual += Vector2::new(force, force * arm);
            j00 += slope;
            j01 += slope * arm;
            j11 += slope * arm * arm;
        }
        (residual, Matrix2::new(j00, j01, j01, j11))
    }
}

impl LeastSquaresProblem<f64, U2, U2> for Balance<'_> {
    type ResidualStorage = Owned<f64, U2>;
    type JacobianStorage = Owned<f64, U2, U2>;
    type ParameterStorage = Owned<f64, U2>;

    fn set_params(&mut self, x: &Vector2<f64>) {
        self.x = *x;
    }

    fn params(&self) -> Vector2<f64> {
        self.x
    }

    fn residuals(&self) -> Option<Vector2<f64>> {
        Some(self.evaluate().0)
    }

    fn jacobian(&self) -> Option<Matrix2<f64>> {
        Some(self.evaluate().1)
    }
}
