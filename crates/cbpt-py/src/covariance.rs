//! The search for a noise, on products of columns that numpy has made.

use cbpt_core::covariance::products::{Polynomials, Products, Whitened};
use cbpt_core::covariance::search::{self, Failed, Task};
use cbpt_core::covariance::solved::Solved;
use pyo3::prelude::*;

use crate::arrays::{Column, Floats, Matrix, Table};
use crate::error::not_positive;

/// Products of columns through a noise of any scale and correlation, of readings that differences whiten.
///
/// Parameters
/// ----------
/// grams : list of array, shape (m, m)
///     Products of the columns over the standard deviations: of first readings of runs, of followers, of followers with those
///     before them (twice, negative), of those before.
/// by_run : list of array, shape (runs, m + 1)
///     The same run by run, of the columns with a column of ones, and of that with itself.
/// log_det : float
///     Log determinant of the covariance at a scale of 1 without correlation.
/// readings : tuple of int
///     How many there are, and how many of them follow another one in their run.
#[pyclass(frozen, module = "cbpt._core")]
pub struct NoisePolynomials(Polynomials);

#[pymethods]
impl NoisePolynomials {
    #[new]
    fn new(grams: [Matrix<'_>; 4], by_run: [Matrix<'_>; 4], log_det: f64, readings: [usize; 2]) -> Self {
        let [grams, by_run] = [grams, by_run].map(|four| four.map(|matrix| matrix.matrix()));
        Self(Polynomials { grams, by_run, log_det, readings })
    }
}

/// Products of columns by the noise that they are seen through.
#[derive(FromPyObject)]
pub enum NoiseProducts<'py> {
    /// Of readings that differences whiten.
    Polynomials(PyRef<'py, NoisePolynomials>),
    /// What a function of scale and correlation returns: products, the same by run, log determinant.
    Function(Bound<'py, PyAny>),
}

impl Whitened for NoiseProducts<'_> {
    type Error = PyErr;

    fn scales(&self) -> bool {
        matches!(self, Self::Polynomials(_))
    }

    fn products(&self, scale: f64, correlation: f64, by_run: bool) -> PyResult<Products> {
        match self {
            Self::Polynomials(polynomials) => {
                polynomials.0.products(scale, correlation, by_run).map_err(|never| match never {})
            }
            Self::Function(function) => {
                let made: (Matrix<'_>, Matrix<'_>, f64) = function.call1((scale, correlation))?.extract()?;
                Ok(Products { gram: made.0.matrix(), by_run: made.1.matrix(), log_det: made.2 })
            }
        }
    }
}

/// Products of columns through a noise of a scale, a correlation and offsets of runs, the last `shared` columns being a part of
/// the noise, shape (m, m); and the log determinant of its covariance.
///
/// Raises `numpy.linalg.LinAlgError` where that is no covariance.
#[pyfunction]
pub fn noise_products<'py>(
    py: Python<'py>,
    products: NoiseProducts<'py>,
    noise: (f64, f64, f64),
    shared: usize,
) -> PyResult<(Table<'py, f64>, f64)> {
    let (scale, correlation, offset) = noise;
    let made = products.products(scale, correlation, offset != 0.0)?;
    let (gram, log_det) = made.beside(offset, shared).ok_or_else(|| not_positive(py))?;
    // Symmetric, so that rows are columns.
    Ok((Table::of_rows(py, gram.as_slice(), gram.nrows())?, log_det))
}

/// Of a search: see `search_noise`.
type Given = (usize, usize, f64, f64, f64, f64, f64);

/// The noise that makes readings most likely, and its log likelihood with the prior of the scale, less its price.
///
/// Parameters
/// ----------
/// products : NoisePolynomials or callable
///     Of the readings, the columns of the unknowns, and those that are a part of the noise. A callable is given scale and
///     correlation and returns products, products by run, and the log determinant of the covariance.
/// columns : tuple
///     Precision of the prior of each unknown, 0 where it is flat, shape (p,); how many columns are a part of the noise.
/// start : tuple of float
///     Scale, correlation and offset of runs to begin with.
/// given : tuple
///     Number of readings and of runs; typical uncertainty; repeats that what is stated is worth; the least scale; the largest
///     correlation; what a correlation and offsets have to gain, each.
/// structures : bool
///     Whether correlation and offsets are sought, too.
///
/// Returns
/// -------
/// tuple of float
///     Scale, correlation, offset of runs, and the log likelihood.
///
/// Raises
/// ------
/// numpy.linalg.LinAlgError
///     Where the covariance or the linear problem is not positive.
#[pyfunction]
pub fn search_noise(
    py: Python<'_>,
    products: NoiseProducts<'_>,
    columns: (Floats<'_>, usize),
    start: (f64, f64, f64),
    given: Given,
    structures: bool,
) -> PyResult<(f64, f64, f64, f64)> {
    let precision = columns.0.view().to_vec();
    let (start, shared): ([f64; 3], usize) = (start.into(), columns.1);
    let found = match &products {
        NoiseProducts::Polynomials(polynomials) => {
            let polynomials = &polynomials.0;
            let found = py.detach(|| task(polynomials, (&precision, shared), given).solve(start, structures));
            found.map_err(|failed| match failed {
                Failed::Products(never) => match never {},
                Failed::NotPositive => not_positive(py),
            })?
        }
        NoiseProducts::Function(_) => {
            let found = task(&products, (&precision, shared), given).solve(start, structures);
            found.map_err(|failed| match failed {
                Failed::Products(error) => error,
                Failed::NotPositive => not_positive(py),
            })?
        }
    };
    Ok((found.scale, found.correlation, found.offset, found.value))
}

fn task<'a, W>(
    whitened: &'a W,
    (precision, shared): (&'a [f64], usize),
    (readings, runs, typical, stated_dof, least_scale, most_correlation, price): Given,
) -> Task<'a, W> {
    Task {
        whitened,
        shared,
        precision,
        readings,
        runs,
        typical,
        stated_dof,
        least_scale,
        most_correlation,
        price,
    }
}

/// Normal unknowns taken out of readings: the upper Cholesky factor of A = X'X + precisions, shape (p, p), the mode, shape
/// (p,), misfit and priors there, and the log volume, half the log determinant of the precisions less half that of A.
///
/// Parameters
/// ----------
/// gram : array, shape (p, p)
///     X'X.
/// projection : array, shape (p,)
///     X'y.
/// square : float
///     y'y.
/// precision : array, shape (p,)
///     Of the prior of each unknown, 0 where it is flat.
///
/// Raises
/// ------
/// numpy.linalg.LinAlgError
///     Where A is not positive.
#[pyfunction]
pub fn take_out<'py>(
    py: Python<'py>,
    gram: Matrix<'py>,
    projection: Floats<'py>,
    square: f64,
    precision: Floats<'py>,
) -> PyResult<(Table<'py, f64>, Column<'py, f64>, f64, f64)> {
    let projection = projection.vector();
    let solved = Solved::of(gram.matrix(), &projection, square, &precision.view().to_vec());
    let solved = solved.ok_or_else(|| not_positive(py))?;
    // Column by column, which is the factor's transpose row by row.
    let factor = Table::of_rows(py, solved.factor.l().as_slice(), projection.len())?;
    Ok((factor, Column::new(py, solved.mode.iter().copied()), solved.chi2, solved.log_volume))
}

/// Log prior of scales, 0 where one is 1, shape (n,).
#[pyfunction]
pub fn log_scale_prior<'py>(py: Python<'py>, scales: Floats<'py>, stated_dof: f64) -> Column<'py, f64> {
    let scales = scales.view();
    Column::new(py, scales.iter().map(|scale| search::log_scale_prior(*scale, stated_dof)))
}
