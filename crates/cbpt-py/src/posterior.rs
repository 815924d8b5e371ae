//! Readings whitened, their misfit, and the search for the most probable values.

use std::sync::Arc;
use std::time::{Duration, Instant};

use cbpt_core::covariance::filter::{self, Beside};
use cbpt_core::covariance::whitener::{self, Offsets, Shared};
use cbpt_core::posterior::misfit::{self, Point, Unknowns};
use cbpt_core::posterior::search::{Failed, Limits, Model, search};
use cbpt_core::{InvalidInput, predict};
use nalgebra::DMatrix;
use pyo3::prelude::*;

use crate::arrays::{Column, Flags, Floats, Integers, Matrix, Table};
use crate::effects::Predictor;
use crate::error::not_positive;

/// Whitens n readings that scatter beside an autoregression along their runs.
///
/// Parameters
/// ----------
/// sd : array, shape (n,)
///     Standard deviation of each reading by the autoregression.
/// correlation : float
///     From a reading to the next of its run.
/// order : array of int, shape (n,)
///     The readings run by run.
/// before : array of int, shape (n,)
///     The reading before each one in its run, or -1.
/// own : array, shape (n,), optional
///     Standard deviation by which each reading scatters by itself.
/// held : tuple of array, optional
///     Of what readings share while a torque was held: the standard deviation of each reading, shape (n,), and its hold, int,
///     shape (n,).
#[pyclass(frozen, module = "cbpt._core")]
pub struct NoiseFilter(filter::Filter);

#[pymethods]
impl NoiseFilter {
    #[new]
    #[pyo3(signature = (sd, correlation, order, before, own, held))]
    fn new(
        sd: Floats<'_>,
        correlation: f64,
        order: Integers<'_>,
        before: Integers<'_>,
        own: Option<Floats<'_>>,
        held: Option<(Floats<'_>, Integers<'_>)>,
    ) -> Self {
        let own = own.map(|own| own.view().to_vec()).unwrap_or_default();
        let (shared, hold) =
            held.map(|(sd, hold)| (sd.view().to_vec(), hold.view().to_vec())).unwrap_or_default();
        let beside = Beside { own: &own, shared: &shared, hold: &hold };
        let (order, before) = (places(&order), readings_before(&before));
        Self(filter::Filter::new(&sd.view().to_vec(), correlation, &order, &before, beside))
    }

    /// Logarithm of the determinant of the covariance.
    #[getter]
    fn log_det(&self) -> f64 {
        self.0.log_det
    }
}

/// A root of the inverse of a covariance of n readings.
///
/// Parameters
/// ----------
/// inverse : array, shape (n,)
///     One over the standard deviation of each reading.
/// correlation : float
///     From a reading to the next of its run.
/// before : array of int, shape (n,)
///     The reading before each one in its run, or -1.
/// offsets : tuple of array, optional
///     Run of each reading, shape (n,); a column of ones, whitened, shape (n,); by how much each run's is shortened over its
///     square, shape (runs,).
/// shared : list of tuple of array
///     Of what moves many readings at once: orthonormal axes, shape (n, k), and by how much each is shortened, shape (k,).
/// filter : NoiseFilter, optional
///     Of noise that no differences whiten.
#[pyclass(frozen, module = "cbpt._core")]
pub struct Whitener(Arc<whitener::Whitener>);

/// Run of each reading, ones, shortening.
type RunOffsets<'py> = (Integers<'py>, Floats<'py>, Floats<'py>);

#[pymethods]
impl Whitener {
    #[new]
    #[pyo3(signature = (inverse, correlation, before, offsets, shared, filter))]
    fn new(
        inverse: Floats<'_>,
        correlation: f64,
        before: Integers<'_>,
        offsets: Option<RunOffsets<'_>>,
        shared: Vec<(Matrix<'_>, Floats<'_>)>,
        filter: Option<&NoiseFilter>,
    ) -> Self {
        Self(Arc::new(whitener::Whitener {
            inverse: inverse.view().to_vec(),
            filter: filter.map(|filter| filter.0.clone()),
            correlation,
            before: readings_before(&before),
            offsets: offsets.map(|(run, ones, shrink)| Offsets {
                run: places(&run),
                ones: ones.view().to_vec(),
                shrink: shrink.view().to_vec(),
            }),
            shared: shared
                .into_iter()
                .map(|(axes, shorter)| Shared { axes: axes.matrix(), shorter: shorter.vector() })
                .collect(),
        }))
    }

    /// Columns of shape (n, m), whitened.
    fn whitened<'py>(&self, py: Python<'py>, columns: Matrix<'py>) -> PyResult<Table<'py, f64>> {
        let mut columns = columns.matrix();
        self.0.whiten(&mut columns);
        Table::of_columns(py, columns.as_slice(), columns.nrows())
    }
}

fn readings_before(before: &Integers<'_>) -> Vec<Option<usize>> {
    before.view().iter().map(|place| usize::try_from(*place).ok()).collect()
}

fn places(integers: &Integers<'_>) -> Vec<usize> {
    integers.view().iter().map(|place| usize::try_from(*place).unwrap_or(usize::MAX)).collect()
}

/// Values of a model, its prediction, and slopes by the unknowns, shape (n, p), or by none.
type PointArrays<'py> = (Floats<'py>, Floats<'py>, Matrix<'py>);

/// Place, mean, unit, precision, whether it is searched in logarithms, bounds; of each unknown, in its coordinate.
type UnknownArrays<'py> =
    (Integers<'py>, Floats<'py>, Floats<'py>, Floats<'py>, Flags<'py>, Floats<'py>, Floats<'py>);

fn point_of((values, predicted, slopes): &PointArrays<'_>) -> Point {
    let column = |floats: &Floats<'_>| floats.view().to_vec();
    Point { values: column(values), predicted: column(predicted), slopes: slopes.by_rows() }
}

/// All but the first column.
fn columns_of<'py>(py: Python<'py>, matrix: &DMatrix<f64>) -> PyResult<Table<'py, f64>> {
    let rows = matrix.nrows();
    Table::of_columns(py, &matrix.as_slice()[rows..], rows)
}

/// What a misfit sees of a point: n readings less model, and p columns.
#[pyclass(frozen, module = "cbpt._core")]
pub struct Seen(misfit::Seen);

#[pymethods]
impl Seen {
    /// Readings less model, whitened, shape (n,).
    #[getter]
    fn y<'py>(&self, py: Python<'py>) -> Column<'py, f64> {
        Column::new(py, self.0.white.column(0).iter().copied())
    }

    /// Slopes by one step of each unknown, whitened, shape (n, p).
    #[getter]
    fn x<'py>(&self, py: Python<'py>) -> PyResult<Table<'py, f64>> {
        columns_of(py, &self.0.white)
    }

    /// As ``y``, less what the offsets take.
    #[getter]
    fn y_left<'py>(&self, py: Python<'py>) -> Column<'py, f64> {
        Column::new(py, self.0.left.column(0).iter().copied())
    }

    /// As ``x``, less what the offsets take.
    #[getter]
    fn x_left<'py>(&self, py: Python<'py>) -> PyResult<Table<'py, f64>> {
        columns_of(py, &self.0.left)
    }

    /// Of the unknowns, logarithms where they are searched in these, shape (p,).
    #[getter]
    fn coordinates<'py>(&self, py: Python<'py>) -> Column<'py, f64> {
        Column::new(py, self.0.coordinates.iter().copied())
    }

    /// Unknowns off the mean of their priors, in steps, shape (p,); 0 where there is no prior.
    #[getter]
    fn off<'py>(&self, py: Python<'py>) -> Column<'py, f64> {
        Column::new(py, self.0.off.iter().copied())
    }

    /// Whitened misfit after the best offsets, and priors.
    #[getter]
    fn misfit(&self) -> f64 {
        self.0.misfit
    }

    /// How far readings and priors see one step of each unknown, in standard deviations, shape (p,).
    #[getter]
    fn reach<'py>(&self, py: Python<'py>) -> Column<'py, f64> {
        Column::new(py, self.0.reach.iter().copied())
    }
}

/// Misfit of n readings with the priors of p unknowns.
///
/// Parameters
/// ----------
/// readings : array, shape (n,)
///     In arcsec.
/// offsets : array, shape (n, k)
///     Columns of what is always free, whitened.
/// whitener : Whitener
///     Of the noise.
/// unknowns : tuple of array, shape (p,)
///     Place among the values of the model, mean of the prior, one step, precision of the prior by steps (0: none), whether it is
///     searched in logarithms, and the least and the most that it can be.
#[pyclass(frozen, module = "cbpt._core")]
pub struct Misfit(misfit::Misfit);

#[pymethods]
impl Misfit {
    #[new]
    fn new(
        readings: Floats<'_>,
        offsets: Matrix<'_>,
        whitener: &Whitener,
        unknowns: UnknownArrays<'_>,
    ) -> Self {
        let (index, mean, unit, precision, log, low, high) = unknowns;
        let unknowns = Unknowns {
            index: places(&index),
            mean: mean.view().to_vec(),
            unit: unit.view().to_vec(),
            precision: precision.view().to_vec(),
            log: log.view().to_vec(),
            low: low.view().to_vec(),
            high: high.view().to_vec(),
        };
        let whitener = Arc::clone(&whitener.0);
        Self(misfit::Misfit::new(readings.view().to_vec(), offsets.matrix(), whitener, unknowns))
    }

    /// What is seen at a point: values, angles in arcsec, slopes by the unknowns. Without slopes only the misfit and the
    /// readings less model.
    fn at(&self, point: PointArrays<'_>) -> Seen {
        Seen(self.0.at(&point_of(&point)))
    }

    /// Of the unknowns at some values, logarithms where they are searched in these, shape (p,).
    fn coordinates<'py>(&self, py: Python<'py>, values: Floats<'py>) -> Column<'py, f64> {
        Column::new(py, self.0.coordinates(&values.view().to_vec()).iter().copied())
    }

    /// Some values with the unknowns at these coordinates.
    fn values_at<'py>(
        &self,
        py: Python<'py>,
        values: Floats<'py>,
        coordinates: Floats<'py>,
    ) -> Column<'py, f64> {
        let moved = self.0.values_at(&values.view().to_vec(), &coordinates.view().to_vec());
        Column::new(py, moved)
    }

    /// Slopes by one step of each unknown, arcsec, shape (n, p).
    fn columns<'py>(&self, py: Python<'py>, point: PointArrays<'py>) -> PyResult<Table<'py, f64>> {
        let columns = self.0.columns(&point_of(&point));
        Table::of_columns(py, columns.as_slice(), columns.nrows())
    }

    /// The step, shape (p,), that the linear problem asks for within the bounds, and what it promises.
    ///
    /// Parameters
    /// ----------
    /// seen : Seen
    ///     With slopes.
    /// radius : float
    ///     The longest step.
    /// scale : array, shape (p,)
    ///     By which each unknown is measured, above 0.
    ///
    /// Raises
    /// ------
    /// numpy.linalg.LinAlgError
    ///     Where the slopes are not finite.
    fn step<'py>(
        &self,
        py: Python<'py>,
        seen: &Seen,
        radius: f64,
        scale: Floats<'py>,
    ) -> PyResult<(Column<'py, f64>, f64)> {
        let found = self.0.step(&seen.0, radius, scale.vector());
        let (step, promised) = found.ok_or_else(|| not_positive(py))?;
        Ok((Column::new(py, step.iter().copied()), promised))
    }

    /// The most probable point, ``None`` where that is the start, and whether the search came to its end.
    ///
    /// Parameters
    /// ----------
    /// predictor : Predictor
    ///     Of the readings; goes on from the solutions that it has.
    /// start : tuple of array
    ///     Values, angles in arcsec, and slopes by the unknowns, as those of the point returned.
    /// limits : tuple of int, float and bool
    ///     Predictions after which it ends; the misfit above which it ends where what the last step promises stays there;
    ///     whether the end is only ranked among others, and comes sooner.
    ///
    /// Raises
    /// ------
    /// numpy.linalg.LinAlgError
    ///     Where slopes are not finite.
    /// InvalidInputError
    ///     For a value out of its bounds.
    #[expect(clippy::type_complexity, reason = "what numpy takes")]
    fn search<'py>(
        &self,
        py: Python<'py>,
        predictor: &Predictor,
        start: PointArrays<'py>,
        limits: (usize, f64, bool),
    ) -> PyResult<(Option<(Column<'py, f64>, Column<'py, f64>, Table<'py, f64>)>, bool)> {
        let start = point_of(&start);
        let (steps, bound, ranked) = limits;
        let reached = predictor.locked(py, |predictor| {
            let mut watched = Watched { predictor, looked: Instant::now() };
            search(&self.0, &mut watched, &start, Limits { steps, bound, ranked })
        })?;
        let reached = reached.map_err(|failed| match failed {
            Failed::NotFinite => not_positive(py),
            Failed::Model(Stopped::Signal(raised)) => raised,
            Failed::Model(Stopped::Input(input)) => predictor.told(py, &input),
        })?;
        let arrays = |Point { values, predicted, slopes }| -> PyResult<_> {
            let slopes = Table::of_rows(py, &slopes, predicted.len())?;
            Ok((Column::new(py, values), Column::new(py, predicted), slopes))
        };
        Ok((reached.point.map(arrays).transpose()?, reached.ended))
    }
}

/// How often Ctrl-C is looked for: each look waits for a thread of Python that is at work.
const POLL: Duration = Duration::from_millis(50);

/// A predictor that minds Ctrl-C.
struct Watched<'a> {
    predictor: &'a mut predict::Predictor,
    looked: Instant,
}

/// Why it predicts no more.
enum Stopped {
    Input(InvalidInput),
    Signal(PyErr),
}

impl Model for Watched<'_> {
    type Error = Stopped;

    fn at(&mut self, values: Vec<f64>, unknown: &[usize]) -> Result<Option<Point>, Stopped> {
        if self.looked.elapsed() > POLL {
            Python::attach(|py| py.check_signals().map_err(Stopped::Signal))?;
            self.looked = Instant::now();
        }
        self.predictor.at(values, unknown).map_err(Stopped::Input)
    }
}
