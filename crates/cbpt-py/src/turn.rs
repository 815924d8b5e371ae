//! What each ball carries at many angles of the crank.

use cbpt_core::Load;
use cbpt_core::turn::{BallLoad, BallLoads};
use pyo3::prelude::*;

use crate::arrays::{Floats, Table};
use crate::drive::Drive;
use crate::error::invalid_input;
use crate::interrupt::without_gil;

/// Of the deceleration pair and of the equal-speed pair: axial force, torque and normal force.
type Carried<'py> =
    (Table<'py, f64>, Table<'py, f64>, Table<'py, f64>, Table<'py, f64>, Table<'py, f64>, Table<'py, f64>);

/// What every ball of a drive carries at many angles of the crank. Ctrl-C stops it.
///
/// Parameters
/// ----------
/// drive : Drive
///     A ball drive.
/// torque_Nm : float
///     Torque on the output, N m.
/// preload_N : float
///     Axial preload, N.
/// input_angle_rad : array, shape (n,)
///     Angles of the input crank, rad.
///
/// Returns
/// -------
/// tuple
///     Axial force (N), share of the pair's torque (N m) and larger normal force (N) of each ball of the deceleration pair,
///     then of the equal-speed pair (of a cross-slide its first row), each of shape (n, balls). NaN where there is no
///     solution.
///
/// Raises
/// ------
/// InvalidInputError
///     For an invalid number, and for a torsion spring.
#[pyfunction]
pub fn ball_loads<'py>(
    py: Python<'py>,
    drive: &Drive,
    torque_Nm: f64,
    preload_N: f64,
    input_angle_rad: Floats<'py>,
) -> PyResult<Carried<'py>> {
    let ball_drive = drive.ball_drive(py, "ball_loads")?;
    let load = |angle: &f64| Load::new(torque_Nm, preload_N, *angle);
    let loads: Result<Vec<Load>, _> = input_angle_rad.view().iter().map(load).collect();
    let loads = loads.map_err(|error| invalid_input(py, &error))?;
    let found = without_gil(py, None, |progress| ball_drive.ball_loads(&loads, progress))?;
    let balls = [ball_drive.deceleration().ball_count, ball_drive.equal_speed().ball_count()];
    let table = |pair: usize, of: &dyn Fn(&BallLoad) -> f64| {
        let width = balls[pair] as usize;
        let row = |loads: &Option<BallLoads>| match loads {
            Some(loads) => [&loads.deceleration, &loads.equal_speed][pair].iter().map(of).collect(),
            None => vec![f64::NAN; width],
        };
        let values: Vec<f64> = found.iter().flat_map(|(_, loads)| row(loads)).collect();
        Table::of_rows(py, &values, found.len())
    };
    let axial = |load: &BallLoad| load.axial_N;
    let torque = |load: &BallLoad| load.torque_Nm;
    let normal = |load: &BallLoad| load.normal_N;
    Ok((
        table(0, &axial)?,
        table(0, &torque)?,
        table(0, &normal)?,
        table(1, &axial)?,
        table(1, &torque)?,
        table(1, &normal)?,
    ))
}
