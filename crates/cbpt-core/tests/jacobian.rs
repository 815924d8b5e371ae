//! The derivatives that Newton's method is given, against central finite differences: residual of the energy, Jacobian
//! of the residual, in two and three unknowns, with gaps, any exponent, an axial spring and contacts that have parted.

use crate::common;
use crate::common::{any_pair, approach_scale_m, effects, preload_N, torque_Nm};
use cbpt_core::equilibrium::{PairEquilibrium, ReadyPair};
use cbpt_core::pair::MeshingPoints;
use cbpt_core::solver::problem::{Evaluation, Problem};
use nalgebra::{SMatrix, SVector};
use proptest::prelude::*;
use proptest::test_runner::TestCaseError;

/// Step in scaled unknowns, where 1 is the approach under the preload alone. Together with the distance from the kinks
/// below it keeps both errors of a central difference, of truncation and of rounding, below the tolerance.
const STEP: f64 = 3e-7;
const TOLERANCE: f64 = 1e-7;

/// The force law has no second derivative where a contact parts, so differences are not taken within this distance.
const FROM_KINK: f64 = 1e-3;

fn step<const N: usize>(i: usize, size: f64) -> SVector<f64, N> {
    SVector::from_fn(|j, _| if i == j { size } else { 0.0 })
}

/// Checks all derivatives at one state.
fn check<const N: usize>(
    points: &MeshingPoints,
    torque_Nm: f64,
    preload_N: f64,
    x: &SVector<f64, N>,
) -> Result<(), TestCaseError> {
    let size = approach_scale_m(points, preload_N);
    let pair = ReadyPair::new(points);
    let equations = PairEquilibrium::new(&pair, torque_Nm, preload_N, Some(0.7 * size)).unwrap();
    let deformations: Vec<f64> =
        points.points.iter().map(|point| equations.state(x).deformation_m(point) / size).collect();
    prop_assume!(deformations.iter().all(|deformation| deformation.abs() > FROM_KINK));
    let at = |x: &SVector<f64, N>| -> Evaluation<N> { equations.evaluate(x) };
    let here = at(x);
    let energy_size = 1.0 + here.energy.abs();
    let residual_size = 1.0 + here.jacobian.amax();
    for i in 0..N {
        let (before, after) = (at(&(x - step(i, STEP))), at(&(x + step(i, STEP))));
        let slope = (after.energy - before.energy) / (2.0 * STEP);
        prop_assert!(
            (slope - here.residual[i]).abs() <= TOLERANCE * (energy_size + residual_size),
            "residual {i}: {} against {slope}",
            here.residual[i]
        );
        let column = (after.residual - before.residual) / (2.0 * STEP);
        let difference = (column - here.jacobian.column(i)).amax();
        prop_assert!(
            difference <= TOLERANCE * residual_size,
            "column {i}: {} against {column}",
            here.jacobian.column(i)
        );
    }
    // A Hessian is symmetric, that of a convex energy never negative: no direction in which its curvature is.
    prop_assert!((here.jacobian - here.jacobian.transpose()).amax() <= 1e-14 * residual_size);
    for direction in [*x, here.residual, step(0, 1.0) - step(N - 1, 1.0)] {
        let curvature = direction.dot(&(here.jacobian * direction));
        prop_assert!(curvature >= -1e-13 * residual_size * direction.norm_squared(), "{curvature}");
    }
    Ok(())
}

proptest! {
    #![proptest_config(common::config(1500))]

    #[test]
    fn residual_and_jacobian_are_derivatives(
        points in any_pair(),
        effects in effects(),
        preload in preload_N(),
        share in -3.0..3.0_f64,
        (approach, rotation, sideways) in (-1.0..4.0_f64, -3.0..3.0_f64, -2.0..2.0_f64),
    ) {
        let points = effects.on(&points, preload);
        let torque = torque_Nm(&points, preload, share);
        check(&points, torque, preload, &SVector::from([approach, rotation]))?;
        check(&points, torque, preload, &SVector::from([approach, rotation, sideways]))?;
    }

    /// What is reported in newtons, metres and radians is the same Jacobian in those units.
    #[test]
    fn the_unscaled_jacobian_is_that_of_forces_and_torques(
        points in any_pair(),
        preload in preload_N(),
        share in -0.9..0.9_f64,
    ) {
        let torque = torque_Nm(&points, preload, share);
        let pair = ReadyPair::new(&points);
        let equations = PairEquilibrium::new(&pair, torque, preload, None).unwrap();
        let x = SVector::from([1.0, 0.5, 0.1]);
        let si: SMatrix<f64, 3, 3> = equations.unscaled_jacobian(&equations.evaluate(&x).jacobian);
        let state = equations.state(&x);
        let pivot = torque / preload;
        let mut expected = SMatrix::<f64, 3, 3>::zeros();
        for point in points.points.points.iter().filter(|point| point.exists()) {
            let slope = 1.5 * point.stiffness * state.deformation_m(point).max(0.0).sqrt();
            let in_plane = point.diagonal.sign() * point.cos_beta;
            let lever =
                SVector::from([point.sin_beta, in_plane * point.arm_m - pivot * point.sin_beta, in_plane]);
            expected += slope * lever * lever.transpose();
        }
        for i in 0..3 {
            for j in 0..3 {
                let size = (expected[(i, i)] * expected[(j, j)]).sqrt();
                prop_assert!((si[(i, j)] - expected[(i, j)]).abs() <= 1e-11 * size, "({i}, {j})");
            }
        }
    }
}
