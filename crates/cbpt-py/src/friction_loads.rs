//! Friction over a period for many loads: arrays in, arrays out.

use cbpt_core::friction::period::{DriveOverPeriod, FrictionPeriod, PeriodRow};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::arrays::{Column, Floats};
use crate::drive::Drive;
use crate::error::invalid_input;
use crate::interrupt::without_gil;

/// Mean, least and largest friction torque, efficiency, wear, and the name of the status.
type Columns<'py> = (
    Column<'py, f64>,
    Column<'py, f64>,
    Column<'py, f64>,
    Column<'py, f64>,
    Column<'py, f64>,
    Vec<&'static str>,
);

/// Friction of a drive over a period for arrays of loads, on all cores. Ctrl-C stops it.
///
/// Parameters
/// ----------
/// drive : Drive
///     A ball drive.
/// torque_Nm, preload_N : array, shape (n,)
///     The loads: N m and N.
/// coefficient : float
///     Friction coefficient.
/// progress : callable, optional
///     Called from time to time with the number of loads computed.
///
/// Returns
/// -------
/// tuple
///     Mean, least and largest friction torque at the input (N m), efficiency and Archard's index for a turn of the input
///     (N m), each of shape (n,), NaN where there is no solution, and the status of each load.
///
/// Raises
/// ------
/// InvalidInputError
///     For an invalid number, and for a torsion spring.
#[pyfunction]
#[pyo3(signature = (drive, torque_Nm, preload_N, coefficient, progress = None))]
pub fn friction_of_loads<'py>(
    py: Python<'py>,
    drive: &Drive,
    torque_Nm: Floats<'py>,
    preload_N: Floats<'py>,
    coefficient: f64,
    progress: Option<Bound<'py, PyAny>>,
) -> PyResult<Columns<'py>> {
    let drive = drive.ball_drive(py, "friction_of_loads")?;
    let (torque, preload) = (torque_Nm.view(), preload_N.view());
    if torque.len() != preload.len() {
        return Err(PyValueError::new_err("torque_Nm and preload_N differ in length"));
    }
    let loads: Vec<[f64; 2]> =
        torque.iter().zip(preload).map(|(torque, preload)| [*torque, *preload]).collect();
    let work = |progress: &_| FrictionPeriod::new(drive).map(&loads, coefficient, progress);
    let rows = without_gil(py, progress.as_ref(), work)?.map_err(|error| invalid_input(py, &error))?;
    let rows: Vec<PeriodRow> = rows.unwrap_or_default();
    let column = |of: &dyn Fn(&DriveOverPeriod) -> f64| {
        Column::new(py, rows.iter().map(|(_, found)| found.as_ref().map_or(f64::NAN, of)))
    };
    Ok((
        column(&|found| found.torque.mean_Nm),
        column(&|found| found.torque.least_Nm),
        column(&|found| found.torque.largest_Nm),
        column(&DriveOverPeriod::efficiency),
        column(&DriveOverPeriod::wear_Nm_per_turn),
        rows.iter().map(|(status, _)| status.name()).collect(),
    ))
}
