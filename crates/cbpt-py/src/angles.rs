//! Many loads at once: arrays in, arrays out.

use cbpt_core::Load;
use cbpt_core::sweep::solve_all;
use numpy::{PyArray1, PyReadonlyArray1};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::case::Drive;
use crate::error::invalid_input;
use crate::interrupt::without_gil;

type Columns<'py> = (
    Bound<'py, PyArray1<f64>>,
    Bound<'py, PyArray1<f64>>,
    Bound<'py, PyArray1<f64>>,
    Bound<'py, PyArray1<f64>>,
    Vec<&'static str>,
);

/// Solves a drive for arrays of torque (N m), preload (N) and input angle (rad), all of shape (n,), on all cores.
///
/// Returns the parts of the deceleration and the equal-speed pair (rad), the scaled residual, the hold preload (N, NaN
/// unless the status is ``beyond_hold``) and the status, each of length n; NaN where there is no solution. Raises
/// ``InvalidInputError`` with the index of a number that cannot be; Ctrl-C stops it.
#[pyfunction]
pub fn solve_angles<'py>(
    py: Python<'py>,
    drive: &Drive,
    torque_Nm: PyReadonlyArray1<'py, f64>,
    preload_N: PyReadonlyArray1<'py, f64>,
    input_angle_rad: PyReadonlyArray1<'py, f64>,
) -> PyResult<Columns<'py>> {
    let (torque, preload, angle) = (torque_Nm.as_array(), preload_N.as_array(), input_angle_rad.as_array());
    if torque.len() != preload.len() || torque.len() != angle.len() {
        return Err(PyValueError::new_err("torque_Nm, preload_N and input_angle_rad differ in length"));
    }
    let mut loads = Vec::with_capacity(torque.len());
    for (index, ((torque, preload), angle)) in torque.iter().zip(preload).zip(angle).enumerate() {
        loads.push(Load::new(*torque, *preload, *angle).map_err(|mut error| {
            error.field = format!("{}[{index}]", error.field);
            invalid_input(py, &error)
        })?);
    }
    let rust = drive.rust().clone();
    let rows = without_gil(py, |progress| solve_all(&rust, &loads, progress))?.unwrap_or_default();
    let column = |of: &dyn Fn(&cbpt_core::Angles) -> f64| {
        PyArray1::from_iter(py, rows.iter().map(|(_, angles)| angles.as_ref().map_or(f64::NAN, of)))
    };
    let hold = PyArray1::from_iter(
        py,
        rows.iter().map(|(status, _)| match status {
            cbpt_core::Status::BeyondHold { hold_preload_N } => *hold_preload_N,
            _ => f64::NAN,
        }),
    );
    Ok((
        column(&|angles| angles.deceleration_rad),
        column(&|angles| angles.equal_speed_rad),
        column(&|angles| angles.residual),
        hold,
        rows.iter().map(|(status, _)| status.name()).collect(),
    ))
}
