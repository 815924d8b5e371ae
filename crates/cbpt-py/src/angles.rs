//! Many loads at once: arrays in, arrays out.

use cbpt_core::sweep::{Row, solve_all};
use cbpt_core::{Angles, Load, Reducer, TorsionSpring};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::arrays::{Column, Floats};
use crate::drive::Drive;
use crate::error::invalid_input;
use crate::interrupt::without_gil;

/// Two angles, the residual, the hold preload, the place of the status in the names that follow.
type Columns<'py> = (
    Column<'py, f64>,
    Column<'py, f64>,
    Column<'py, f64>,
    Column<'py, f64>,
    Column<'py, u8>,
    Vec<&'static str>,
);

/// Solves a drive for arrays of loads on all cores. Ctrl-C stops it.
///
/// Parameters
/// ----------
/// drive : Drive
///     A ball drive or a torsion spring.
/// torque_Nm, preload_N, input_angle_rad : array, shape (n,)
///     The loads: N m, N and rad. For a torsion spring, a preload of 0 means none.
/// shape : list of int
///     The shape of the n loads in C order, for messages.
/// progress : callable, optional
///     Called from time to time with the number of loads solved.
///
/// Returns
/// -------
/// tuple
///     Parts of the deceleration and of the equal-speed pair (rad; of a torsion spring, the first part is the whole angle),
///     scaled residual, hold preload (N, NaN unless the status is ``beyond_hold``), the status as an index into the names
///     that follow, each of shape (n,), and these names. NaN where there is no solution.
///
/// Raises
/// ------
/// InvalidInputError
///     For an invalid number; names its index.
#[pyfunction]
#[pyo3(signature = (drive, torque_Nm, preload_N, input_angle_rad, shape, progress = None))]
#[expect(clippy::too_many_arguments, reason = "the columns of a table")]
pub fn solve_angles<'py>(
    py: Python<'py>,
    drive: &Drive,
    torque_Nm: Floats<'py>,
    preload_N: Floats<'py>,
    input_angle_rad: Floats<'py>,
    shape: Vec<usize>,
    progress: Option<Bound<'py, PyAny>>,
) -> PyResult<Columns<'py>> {
    let (torque, preload, angle) = (torque_Nm.view(), preload_N.view(), input_angle_rad.view());
    if torque.len() != preload.len() || torque.len() != angle.len() {
        return Err(PyValueError::new_err("torque_Nm, preload_N and input_angle_rad differ in length"));
    }
    let mut loads = Vec::with_capacity(torque.len());
    for (index, ((torque, preload), angle)) in torque.iter().zip(preload).zip(angle).enumerate() {
        let load = match (drive.rust(), *preload) {
            (Reducer::TorsionSpring(_), 0.0) => Load::without_preload(*torque, *angle),
            _ => Load::new(*torque, *preload, *angle),
        };
        loads.push(load.map_err(|mut error| {
            error.field += &place(index, &shape);
            invalid_input(py, &error)
        })?);
    }
    let rust = drive.rust().clone();
    let rows = match &rust {
        Reducer::BallDrive(drive) => {
            without_gil(py, progress.as_ref(), |progress| solve_all(drive, &loads, progress))?
                .unwrap_or_default()
        }
        Reducer::TorsionSpring(spring) => loads.iter().map(|load| twisted(spring, load)).collect(),
    };
    let column = |of: &dyn Fn(&cbpt_core::Angles) -> f64| {
        Column::new(py, rows.iter().map(|(_, angles)| angles.as_ref().map_or(f64::NAN, of)))
    };
    let hold = Column::new(
        py,
        rows.iter().map(|(status, _)| match status {
            cbpt_core::Status::BeyondHold { hold_preload_N } => *hold_preload_N,
            _ => f64::NAN,
        }),
    );
    let mut names: Vec<&'static str> = Vec::new();
    let mut codes: Vec<u8> = Vec::with_capacity(rows.len());
    for (status, _) in &rows {
        let known = names.iter().position(|name| *name == status.name());
        // There are six statuses.
        #[allow(clippy::cast_possible_truncation)]
        codes.push(known.unwrap_or(names.len()) as u8);
        if known.is_none() {
            names.push(status.name());
        }
    }
    Ok((
        column(&|angles| angles.deceleration_rad),
        column(&|angles| angles.equal_speed_rad),
        column(&|angles| angles.residual),
        hold,
        Column::new(py, codes),
        names,
    ))
}

/// A torsion spring has one part.
fn twisted(spring: &TorsionSpring, load: &Load) -> Row {
    let twist = spring.twist(load.torque_Nm());
    let angles = Angles { deceleration_rad: twist.angle_rad, equal_speed_rad: 0.0, residual: 0.0, steps: 0 };
    (twist.status, Some(angles))
}

/// The place of a load in its array, as numpy writes it: `[2, 0]`, or nothing where there is only one load.
fn place(mut index: usize, shape: &[usize]) -> String {
    let mut place: Vec<String> = Vec::new();
    for size in shape.iter().rev().map(|&size| size.max(1)) {
        place.push((index % size).to_string());
        index /= size;
    }
    place.reverse();
    if place.is_empty() { String::new() } else { format!("[{}]", place.join(", ")) }
}
