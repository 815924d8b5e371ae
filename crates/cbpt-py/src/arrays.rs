//! numpy arrays whose element type shows in the generated stubs.

use std::convert::Infallible;

use nalgebra::{DMatrix, DVector};
use numpy::ndarray::{ArrayView1, Dimension, Ix1, Ix2};
use numpy::npyffi::NPY_ORDER;
use numpy::{Element, PyArray, PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::inspect::PyStaticExpr;
use pyo3::prelude::*;

/// An array of a known element type, `numpy.typing.NDArray[numpy.float64]` to a type checker.
pub struct Array<'py, T, D>(Bound<'py, PyArray<T, D>>);

/// One number a row.
pub type Column<'py, T> = Array<'py, T, Ix1>;

/// Two numbers a row.
pub type Table<'py, T> = Array<'py, T, Ix2>;

impl<'py, T: Element> Column<'py, T> {
    pub fn new(py: Python<'py>, values: impl IntoIterator<Item = T>) -> Self {
        Self(PyArray1::from_iter(py, values))
    }
}

impl<'py, T: Element> Table<'py, T> {
    pub fn new(py: Python<'py>, rows: &[Vec<T>]) -> PyResult<Self> {
        Ok(Self(PyArray2::from_vec2(py, rows)?))
    }

    /// So many rows, one after the other in `values`.
    pub fn of_rows(py: Python<'py>, values: &[T], rows: usize) -> PyResult<Self> {
        let width = values.len().checked_div(rows).unwrap_or(0);
        Ok(Self(PyArray1::from_slice(py, values).reshape([rows, width])?))
    }
}

impl<'py> Table<'py, f64> {
    /// Columns of so many rows, one after the other in `values`.
    pub fn of_columns(py: Python<'py>, values: &[f64], rows: usize) -> PyResult<Self> {
        let shape = [rows, values.len().checked_div(rows).unwrap_or(0)];
        Ok(Self(PyArray1::from_slice(py, values).reshape_with_order(shape, NPY_ORDER::NPY_FORTRANORDER)?))
    }
}

/// Element types by their names in numpy.
pub trait Named {
    const NAME: PyStaticExpr;
}

const fn in_module(module: &'static PyStaticExpr, attr: &'static str) -> PyStaticExpr {
    PyStaticExpr::Attribute { value: module, attr }
}

const NUMPY: PyStaticExpr = PyStaticExpr::Name { id: "numpy" };
const NUMPY_TYPING: PyStaticExpr = PyStaticExpr::Name { id: "numpy.typing" };
const ND_ARRAY: PyStaticExpr = in_module(&NUMPY_TYPING, "NDArray");

impl Named for f64 {
    const NAME: PyStaticExpr = in_module(&NUMPY, "float64");
}

impl Named for bool {
    const NAME: PyStaticExpr = in_module(&NUMPY, "bool_");
}

impl Named for u8 {
    const NAME: PyStaticExpr = in_module(&NUMPY, "uint8");
}

impl Named for i64 {
    const NAME: PyStaticExpr = in_module(&NUMPY, "int64");
}

impl Named for u32 {
    const NAME: PyStaticExpr = in_module(&NUMPY, "uint32");
}

impl<'py, T: Element + Named, D: Dimension> IntoPyObject<'py> for Array<'py, T, D> {
    type Target = PyArray<T, D>;
    type Output = Bound<'py, Self::Target>;
    type Error = Infallible;

    const OUTPUT_TYPE: PyStaticExpr = PyStaticExpr::Subscript { value: &ND_ARRAY, slice: &T::NAME };

    fn into_pyobject(self, _py: Python<'py>) -> Result<Self::Output, Self::Error> {
        Ok(self.0)
    }
}

/// An argument of shape (n,), read in place.
pub struct Argument<'py, T: Element>(PyReadonlyArray1<'py, T>);

/// An argument: float64 of shape (n,).
pub type Floats<'py> = Argument<'py, f64>;

/// An argument: int64 of shape (n,).
pub type Integers<'py> = Argument<'py, i64>;

/// An argument: bool of shape (n,).
pub type Flags<'py> = Argument<'py, bool>;

impl<T: Element> Argument<'_, T> {
    pub fn view(&self) -> ArrayView1<'_, T> {
        self.0.as_array()
    }
}

impl Floats<'_> {
    /// A copy.
    pub fn vector(&self) -> DVector<f64> {
        let view = self.view();
        DVector::from_iterator(view.len(), view.iter().copied())
    }
}

impl<'a, 'py, T: Element + Named> FromPyObject<'a, 'py> for Argument<'py, T> {
    type Error = PyErr;

    const INPUT_TYPE: PyStaticExpr = PyStaticExpr::Subscript { value: &ND_ARRAY, slice: &T::NAME };

    fn extract(object: Borrowed<'a, 'py, PyAny>) -> PyResult<Self> {
        Ok(Self(object.extract()?))
    }
}

/// An argument: float64 of shape (n, m).
pub struct Matrix<'py>(PyReadonlyArray2<'py, f64>);

impl Matrix<'_> {
    /// A copy, column by column.
    pub fn matrix(&self) -> DMatrix<f64> {
        let view = self.0.as_array();
        let (rows, columns) = view.dim();
        match view.t().as_slice() {
            Some(in_order) => DMatrix::from_column_slice(rows, columns, in_order),
            None => DMatrix::from_row_iterator(rows, columns, view.iter().copied()),
        }
    }

    /// A copy, row by row.
    pub fn by_rows(&self) -> Vec<f64> {
        self.0.as_array().iter().copied().collect()
    }
}

impl<'a, 'py> FromPyObject<'a, 'py> for Matrix<'py> {
    type Error = PyErr;

    const INPUT_TYPE: PyStaticExpr = PyStaticExpr::Subscript { value: &ND_ARRAY, slice: &f64::NAME };

    fn extract(object: Borrowed<'a, 'py, PyAny>) -> PyResult<Self> {
        Ok(Self(object.extract()?))
    }
}
