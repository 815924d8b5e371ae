//! The core's table of units.

use cbpt_core::units;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::Reduced;

/// A unit: what it measures, how it is written and its exact conversion to SI.
#[pyclass(frozen, eq, hash, module = "cbpt._core")]
#[derive(Clone, PartialEq)]
pub struct Unit {
    unit: &'static units::Unit,
}

impl std::hash::Hash for Unit {
    fn hash<H: std::hash::Hasher>(&self, state: &mut H) {
        self.unit.symbol.hash(state);
    }
}

#[pymethods]
impl Unit {
    /// The unit with this symbol, as in ``units``; ``ValueError`` for an unknown symbol.
    #[new]
    fn new(symbol: &str) -> PyResult<Self> {
        let unit = units::all().find(|unit| unit.symbol == symbol);
        unit.map(|unit| Self { unit })
            .ok_or_else(|| PyValueError::new_err(format!("no unit has the symbol {symbol:?}")))
    }

    /// What it measures: ``angle``, ``torque per angle``.
    #[getter]
    fn quantity(&self) -> &'static str {
        self.unit.quantity.name()
    }

    /// Suffix of names, keys and columns, as in ``torque_Nm``; empty for plain numbers.
    #[getter]
    fn symbol(&self) -> &'static str {
        self.unit.symbol
    }

    /// How it is written in a sentence, as in ``5 N m``.
    #[getter]
    fn written(&self) -> &'static str {
        self.unit.written
    }

    /// Other spellings that are accepted, written here without blanks, dots and hyphens between their parts.
    #[getter]
    fn spellings(&self) -> Vec<&'static str> {
        self.unit.spellings.to_vec()
    }

    /// SI value of one unit, without the offset.
    #[getter]
    fn size(&self) -> f64 {
        self.unit.size()
    }

    /// SI value of 0 in this unit: 273.15 K for ``degC``, 0 for every other unit.
    #[getter]
    fn offset(&self) -> f64 {
        self.unit.offset
    }

    /// Numbers ``(times, over, plus)``: a value in this unit is ``value * times / over + plus`` in ``to``.
    ///
    /// ``times`` and ``over`` are whole numbers if the conversion has no factor pi; it is then rounded once if one of them
    /// is 1. ``ValueError`` if ``to`` measures another quantity.
    fn conversion(&self, to: &Self) -> PyResult<(f64, f64, f64)> {
        let conversion = self.unit.conversion(to.unit).ok_or_else(|| {
            PyValueError::new_err(format!(
                "{} measures {}, {} measures {}",
                self.unit.symbol,
                self.quantity(),
                to.unit.symbol,
                to.quantity()
            ))
        })?;
        Ok((conversion.times, conversion.over, conversion.plus))
    }

    fn __repr__(&self) -> String {
        format!("Unit({:?})", self.unit.symbol)
    }

    fn __reduce__(&self, py: Python<'_>) -> Reduced<(&'static str,)> {
        Ok((py.get_type::<Self>().into_any().unbind(), (self.unit.symbol,)))
    }
}

/// Every unit that keys, columns and flags may carry, quantity by quantity, the SI unit of each first.
#[pyfunction(name = "units")]
pub fn all_units() -> Vec<Unit> {
    units::all().map(|unit| Unit { unit }).collect()
}

/// The SI value of one unit as people write it, for example ``arcsec/(N m)``. Raises ``ValueError`` where it is none.
#[pyfunction]
pub fn unit_size(text: &str) -> PyResult<f64> {
    units::compound::read(text).map(|unit| unit.size).map_err(PyValueError::new_err)
}
