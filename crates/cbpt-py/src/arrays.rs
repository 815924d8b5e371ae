//! numpy arrays whose element type shows in the generated stubs.

use std::convert::Infallible;

use numpy::ndarray::{ArrayView1, Dimension, Ix1, Ix2};
use numpy::{Element, PyArray, PyArray1, PyArray2, PyReadonlyArray1};
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

/// An argument: float64 of shape (n,), read in place.
pub struct Floats<'py>(PyReadonlyArray1<'py, f64>);

impl Floats<'_> {
    pub fn view(&self) -> ArrayView1<'_, f64> {
        self.0.as_array()
    }
}

impl<'a, 'py> FromPyObject<'a, 'py> for Floats<'py> {
    type Error = PyErr;

    const INPUT_TYPE: PyStaticExpr = PyStaticExpr::Subscript { value: &ND_ARRAY, slice: &f64::NAME };

    fn extract(object: Borrowed<'a, 'py, PyAny>) -> PyResult<Self> {
        Ok(Self(object.extract()?))
    }
}
