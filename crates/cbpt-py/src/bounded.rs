//! The step of a linear problem within bounds.

use cbpt_core::solver::bounded::{Linear, Quadratic, step_within};
use nalgebra::DVector;
use pyo3::prelude::*;

use crate::arrays::{Column, Floats, Matrix};
use crate::error::not_positive;

/// The step of the least ``z' curved z - 2 slope' z`` within bounds, shape (p,), and what it promises to gain.
///
/// Parameters
/// ----------
/// curved : array, shape (p, p)
///     Symmetric.
/// slope : array, shape (p,)
///     Half the slope of the gain where the step begins.
/// bounds : tuple of array, shape (p,)
///     Lower and upper ones of the step; 0 is between them.
/// scale : array, shape (p,)
///     By which the length of a step is measured, above 0.
/// radius : float
///     The longest step.
///
/// Raises
/// ------
/// numpy.linalg.LinAlgError
///     Where the numbers are not finite.
#[pyfunction]
pub fn quadratic_step<'py>(
    py: Python<'py>,
    curved: Matrix<'py>,
    slope: Floats<'py>,
    bounds: (Floats<'py>, Floats<'py>),
    scale: Floats<'py>,
    radius: f64,
) -> PyResult<(Column<'py, f64>, f64)> {
    let problem = Quadratic { curved: curved.matrix(), slope: slope.vector(), scale: scale.vector(), radius };
    if !problem.is_finite() {
        return Err(not_positive(py));
    }
    let Ok(step) = step_within(&problem, &bounds.0.vector(), &bounds.1.vector());
    Ok((Column::new(py, step.iter().copied()), problem.promised(&step)))
}

/// Functions of Python.
struct Asked<'py> {
    asked: Bound<'py, PyAny>,
    pull: Bound<'py, PyAny>,
}

impl Asked<'_> {
    fn column(&self, values: &DVector<f64>) -> Column<'_, f64> {
        Column::new(self.asked.py(), values.iter().copied())
    }
}

impl Linear for Asked<'_> {
    type Error = PyErr;

    fn asked(&self, step: &DVector<f64>, free: &[bool]) -> PyResult<DVector<f64>> {
        let free = Column::new(self.asked.py(), free.iter().copied());
        Ok(self.asked.call1((self.column(step), free))?.extract::<Floats<'_>>()?.vector())
    }

    fn pull(&self, step: &DVector<f64>) -> PyResult<DVector<f64>> {
        Ok(self.pull.call1((self.column(step),))?.extract::<Floats<'_>>()?.vector())
    }
}

/// The step within bounds of a linear problem that functions tell of, shape (p,).
///
/// Parameters
/// ----------
/// asked : callable
///     Given a step, shape (p,), and which unknowns are free, a mask of shape (p,): the step of those, shape (free,), where the
///     others have made theirs.
/// pull : callable
///     Given a step, half the slope of the gain after it, shape (p,).
/// lower, upper : array, shape (p,)
///     Of the step; 0 is between them.
#[pyfunction]
pub fn held_at_bounds<'py>(
    asked: Bound<'py, PyAny>,
    pull: Bound<'py, PyAny>,
    lower: Floats<'py>,
    upper: Floats<'py>,
) -> PyResult<Column<'py, f64>> {
    let py = asked.py();
    let step = step_within(&Asked { asked, pull }, &lower.vector(), &upper.vector())?;
    Ok(Column::new(py, step.iter().copied()))
}
