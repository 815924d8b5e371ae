//! A solved load: angles, pairs and every meshing point as numpy arrays.

use cbpt_cli::commands::Units;
use cbpt_cli::commands::solve::{html, report, solved};
use cbpt_core::equilibrium::report::{LoadedPoint, PairSolution as RustPair};
use cbpt_core::hertz::LoadedContact;
use cbpt_core::interval::Interval;
use cbpt_core::units::ARCSEC_PER_RAD;
use cbpt_core::{InvalidInput, Load, Reducer, Status};
use pyo3::prelude::*;

use crate::Reduced;
use crate::arrays::{Column, Table};
use crate::finding::Finding;

/// A drive under one load. Print it for a summary; its angles are ``None`` where there is no solution.
#[pyclass(frozen, module = "cbpt._core")]
pub struct Solution {
    reducer: Reducer,
    input_angle_deg: f64,
    solution: cbpt_core::Solution,
}

impl Solution {
    pub fn solve(reducer: &Reducer, load: &Load, input_angle_deg: f64) -> Result<Self, InvalidInput> {
        let solution = solved(reducer, load)?;
        Ok(Self { reducer: reducer.clone(), input_angle_deg, solution })
    }

    fn again(&self) -> Self {
        let (reducer, solution) = (self.reducer.clone(), self.solution.clone());
        Self { reducer, input_angle_deg: self.input_angle_deg, solution }
    }

    fn pair(&self, name: &'static str, pair: Option<&RustPair>) -> Option<PairSolution> {
        pair.map(|pair| PairSolution { pair: pair.clone(), of: self.again(), name })
    }

    fn to_arcsec(rad: Option<f64>) -> Option<f64> {
        rad.map(|rad| rad * ARCSEC_PER_RAD)
    }
}

#[pymethods]
impl Solution {
    /// ``ok``, ``outside_small_displacements`` (the linear geometry no longer holds), ``beyond_hold``,
    /// ``undercut``, ``indeterminate`` (too few points touch) or ``not_converged``.
    #[getter]
    fn status(&self) -> &'static str {
        self.solution.status.name()
    }

    /// The status in words; for ``beyond_hold`` with the preload that would hold.
    #[getter]
    fn message(&self) -> String {
        self.solution.status.to_string()
    }

    /// Whether the load has a solution, so that the angles are numbers.
    #[getter]
    fn has_solution(&self) -> bool {
        self.solution.status.has_solution()
    }

    /// Preload at which the torque would just slip, N, if the status is ``beyond_hold``; ``None`` otherwise.
    #[getter]
    fn hold_preload_N(&self) -> Option<f64> {
        match self.solution.status {
            Status::BeyondHold { hold_preload_N } => Some(hold_preload_N),
            _ => None,
        }
    }

    /// Torque on the output, N m.
    #[getter]
    fn torque_Nm(&self) -> f64 {
        self.solution.load.torque_Nm()
    }

    /// Axial preload, N; ``None`` for a torsion spring without one.
    #[getter]
    fn preload_N(&self) -> Option<f64> {
        Some(self.solution.load.preload_N()).filter(|preload| *preload > 0.0)
    }

    /// Angle of the input crank, degrees.
    #[getter]
    fn input_angle_deg(&self) -> f64 {
        self.input_angle_deg
    }

    /// Elastic angle of the drive at its output, rad.
    #[getter]
    fn elastic_angle_rad(&self) -> Option<f64> {
        self.solution.elastic_angle_rad()
    }

    /// Elastic angle of the drive at its output, seconds of arc.
    #[getter]
    fn elastic_angle_arcsec(&self) -> Option<f64> {
        Self::to_arcsec(self.solution.elastic_angle_rad())
    }

    /// Part of the deceleration pair, seconds of arc.
    #[getter]
    fn alpha_deceleration_arcsec(&self) -> Option<f64> {
        Self::to_arcsec(
            self.solution.deceleration.as_ref().and(self.solution.angles).map(|a| a.deceleration_rad),
        )
    }

    /// Part of the equal-speed pair that reaches the output, seconds of arc.
    #[getter]
    fn alpha_equal_speed_arcsec(&self) -> Option<f64> {
        Self::to_arcsec(
            self.solution.equal_speed.as_ref().and(self.solution.angles).map(|a| a.equal_speed_rad),
        )
    }

    /// Torsional stiffness dM0/dalpha of the drive at this load and constant preload, N m/rad.
    #[getter]
    fn torsional_stiffness_Nm_per_rad(&self) -> Option<f64> {
        self.solution.torsional_stiffness_Nm_per_rad
    }

    /// Largest residual of the equations, scaled by the preload and by the torque that it can hold.
    #[getter]
    fn residual(&self) -> Option<f64> {
        self.solution.angles.map(|angles| angles.residual)
    }

    /// The deceleration pair with its meshing points.
    #[getter]
    fn deceleration(&self) -> Option<PairSolution> {
        self.pair("deceleration", self.solution.deceleration.as_ref())
    }

    /// The equal-speed pair with its meshing points, at the torque that it carries.
    #[getter]
    fn equal_speed(&self) -> Option<PairSolution> {
        self.pair("equal_speed", self.solution.equal_speed.as_ref())
    }

    /// Where the elastic angle lies for certain, rounding included, with the proof that there is no other solution; ``None``
    /// without a solution, where no proof was found, and for a torsion spring. It is worked out each time it is asked for.
    #[getter]
    fn enclosure(&self, py: Python<'_>) -> Option<Enclosure> {
        let drive = self.reducer.ball_drive()?;
        py.detach(|| drive.enclosure(&self.solution.load)).map(Enclosure::from)
    }

    /// Findings of the design under this load, the worst first.
    #[getter]
    fn findings(&self) -> Vec<Finding> {
        let drive = self.reducer.ball_drive();
        let findings = drive.map(|drive| drive.findings(Some(&self.solution.load))).unwrap_or_default();
        findings.iter().map(Finding::from).collect()
    }

    /// The whole solution as the JSON object that ``cbpt solve --json`` prints.
    fn to_json(&self) -> String {
        cbpt_cli::report::pretty(&report(&self.reducer, &self.solution, None, &Units::default()).json)
    }

    /// Pickled as drive and load; solving again gives the same numbers.
    fn __reduce__(slf: &Bound<'_, Self>) -> Reduced<(f64, Option<f64>, f64)> {
        let own = slf.get();
        let toml = cbpt_cli::case::Case::reducer_to_toml(&own.reducer);
        let drive = slf.py().import("cbpt._core")?.getattr("Drive")?.call_method1("from_toml", (toml,))?;
        let solve = drive.getattr("solve")?;
        Ok((solve.unbind(), (own.torque_Nm(), own.preload_N(), own.input_angle_deg)))
    }

    fn __repr__(&self) -> String {
        report(&self.reducer, &self.solution, None, &Units::default()).text
    }

    /// What a notebook shows.
    fn _repr_html_(&self) -> String {
        let of_drive = |drive: &cbpt_core::Drive| drive.findings(Some(&self.solution.load));
        let findings = self.reducer.ball_drive().map(of_drive).unwrap_or_default();
        html(&self.reducer, &self.solution, &findings, &Units::default())
    }
}

/// A solved pair. Arrays have one element for each diagonal of a ball (two meshing points that carry the same force), ball by
/// ball, plus before minus; arrays of the walls have two columns, first the wall of the driving plate.
#[pyclass(frozen, module = "cbpt._core")]
pub struct PairSolution {
    pair: RustPair,
    /// The solution that it is part of, and under which name.
    of: Solution,
    name: &'static str,
}

impl PairSolution {
    fn column<'py, T: numpy::Element>(
        &self,
        py: Python<'py>,
        of: impl Fn(&LoadedPoint) -> T,
    ) -> Column<'py, T> {
        Column::new(py, self.pair.points.iter().map(of))
    }

    fn walls<'py>(&self, py: Python<'py>, of: impl Fn(&LoadedContact) -> f64) -> PyResult<Table<'py, f64>> {
        let wall = |wall: &Option<LoadedContact>| wall.as_ref().map_or(f64::NAN, &of);
        let rows: Vec<Vec<f64>> =
            self.pair.points.iter().map(|p| p.walls.iter().map(wall).collect()).collect();
        Table::new(py, &rows)
    }
}

#[pymethods]
impl PairSolution {
    /// Elastic angle of the pair, rad.
    #[getter]
    fn angle_rad(&self) -> f64 {
        self.pair.rotation_rad
    }

    /// Elastic angle of the pair, seconds of arc.
    #[getter]
    fn angle_arcsec(&self) -> f64 {
        self.pair.rotation_rad * ARCSEC_PER_RAD
    }

    /// Torque that the pair carries, N m.
    #[getter]
    fn torque_Nm(&self) -> f64 {
        self.pair.torque_Nm
    }

    /// Axial approach of the plates (of one row), m.
    #[getter]
    fn approach_m(&self) -> f64 {
        self.pair.approach_m
    }

    /// Sideways shift of a floating plate, m.
    #[getter]
    fn sideways_m(&self) -> f64 {
        self.pair.sideways_m
    }

    /// Torsional stiffness dM0/dalpha at constant preload, N m/rad.
    #[getter]
    fn torsional_stiffness_Nm_per_rad(&self) -> f64 {
        self.pair.torsional_stiffness_Nm_per_rad
    }

    /// Force of the balls on the output plate along the line of centres, N.
    #[getter]
    fn in_plane_force_along_N(&self) -> f64 {
        self.pair.in_plane_force_N[0]
    }

    /// Force of the balls on the output plate across the line of centres, N: for the deceleration pair M0/(Zo e), what
    /// the eccentric bearing carries.
    #[getter]
    fn in_plane_force_across_N(&self) -> f64 {
        self.pair.in_plane_force_N[1]
    }

    /// Couple that tilts the plates, N m.
    #[getter]
    fn tilt_couple_Nm(&self) -> f64 {
        self.pair.tilt_couple_Nm
    }

    /// How many diagonals carry force.
    #[getter]
    fn carrying(&self) -> usize {
        self.pair.carrying
    }

    /// Highest peak pressure of any meshing point, Pa.
    #[getter]
    fn largest_peak_pressure_Pa(&self) -> f64 {
        self.pair.peak_pressure_Pa
    }

    /// Scaled residual.
    #[getter]
    fn residual(&self) -> f64 {
        self.pair.residual
    }

    /// Solver steps.
    #[getter]
    fn steps(&self) -> u32 {
        self.pair.steps
    }

    /// Number of the ball, shape (n,).
    #[getter]
    fn ball<'py>(&self, py: Python<'py>) -> Column<'py, u32> {
        self.column(py, |point| u32::try_from(point.ball).unwrap_or(u32::MAX))
    }

    /// +1 for the plus diagonal, -1 for the minus diagonal, shape (n,).
    #[getter]
    fn diagonal<'py>(&self, py: Python<'py>) -> Column<'py, f64> {
        self.column(py, |point| point.diagonal.sign())
    }

    /// ``FTMP``, ``NFTMP`` or ``neutral`` for each diagonal.
    #[getter]
    fn role(&self) -> Vec<&'static str> {
        self.pair.points.iter().map(|point| point.role.name()).collect()
    }

    /// ``loaded``, ``parted`` or ``wall_missing`` for each diagonal.
    #[getter]
    fn contact(&self) -> Vec<&'static str> {
        self.pair.points.iter().map(|point| point.contact.name()).collect()
    }

    /// Deformation of each diagonal, m, never below 0, shape (n,).
    #[getter]
    fn deformation_m<'py>(&self, py: Python<'py>) -> Column<'py, f64> {
        self.column(py, |point| point.deformation_m)
    }

    /// Gap of each diagonal, m, never below 0, shape (n,).
    #[getter]
    fn gap_m<'py>(&self, py: Python<'py>) -> Column<'py, f64> {
        self.column(py, |point| point.gap_m)
    }

    /// Normal force of each diagonal, N, shape (n,).
    #[getter]
    fn force_N<'py>(&self, py: Python<'py>) -> Column<'py, f64> {
        self.column(py, |point| point.force_N)
    }

    /// Approach at each meshing point, m, shape (n, 2); NaN where the wall is missing.
    #[getter]
    fn wall_approach_m<'py>(&self, py: Python<'py>) -> PyResult<Table<'py, f64>> {
        self.walls(py, |wall| wall.approach_m)
    }

    /// Major semi-axis of each contact ellipse, m, shape (n, 2); NaN where the wall is missing.
    #[getter]
    fn major_semi_axis_m<'py>(&self, py: Python<'py>) -> PyResult<Table<'py, f64>> {
        self.walls(py, |wall| wall.major_semi_axis_m)
    }

    /// Minor semi-axis of each contact ellipse, m, shape (n, 2); NaN where the wall is missing.
    #[getter]
    fn minor_semi_axis_m<'py>(&self, py: Python<'py>) -> PyResult<Table<'py, f64>> {
        self.walls(py, |wall| wall.minor_semi_axis_m)
    }

    /// Peak pressure at each meshing point, Pa, shape (n, 2); NaN where the wall is missing.
    #[getter]
    fn peak_pressure_Pa<'py>(&self, py: Python<'py>) -> PyResult<Table<'py, f64>> {
        self.walls(py, |wall| wall.peak_pressure_Pa)
    }

    /// Pickled as part of its solution.
    fn __reduce__(slf: &Bound<'_, Self>) -> Reduced<(Solution,)> {
        let own = slf.get();
        let getter = slf.py().import("operator")?.call_method1("attrgetter", (own.name,))?;
        Ok((getter.unbind(), (own.of.again(),)))
    }

    fn __repr__(&self) -> String {
        format!(
            "PairSolution(angle {:.6} arcsec, approach {:.6} um, {} of {} diagonals carry, peak pressure {:.3} GPa)",
            self.angle_arcsec(),
            self.pair.approach_m * 1e6,
            self.pair.carrying,
            self.pair.points.len(),
            self.pair.peak_pressure_Pa * 1e-9,
        )
    }
}

/// Lower and upper bound.
type Bounds = (f64, f64);

/// Intervals, lower and upper bound, in which the only solution of a drive's equations was proved to lie.
#[pyclass(frozen, eq, get_all, module = "cbpt._core")]
#[derive(Clone, PartialEq)]
pub struct Enclosure {
    /// Elastic angle of the drive at its output, rad.
    elastic_angle_rad: (f64, f64),
    /// Elastic angle of the drive at its output, seconds of arc.
    elastic_angle_arcsec: (f64, f64),
    /// Part of the deceleration pair, seconds of arc.
    alpha_deceleration_arcsec: (f64, f64),
    /// Part of the equal-speed pair that reaches the output, seconds of arc.
    alpha_equal_speed_arcsec: (f64, f64),
}

impl From<cbpt_core::Enclosure> for Enclosure {
    fn from(found: cbpt_core::Enclosure) -> Self {
        let bounds = |of: Interval| (of.lower(), of.upper());
        let arcsec = |of: Interval| bounds(of.times_rounded(ARCSEC_PER_RAD));
        Self {
            elastic_angle_rad: bounds(found.elastic_angle_rad),
            elastic_angle_arcsec: arcsec(found.elastic_angle_rad),
            alpha_deceleration_arcsec: arcsec(found.deceleration_rad),
            alpha_equal_speed_arcsec: arcsec(found.equal_speed_rad),
        }
    }
}

#[pymethods]
impl Enclosure {
    #[new]
    fn new(
        elastic_angle_rad: (f64, f64),
        elastic_angle_arcsec: (f64, f64),
        alpha_deceleration_arcsec: (f64, f64),
        alpha_equal_speed_arcsec: (f64, f64),
    ) -> Self {
        Self { elastic_angle_rad, elastic_angle_arcsec, alpha_deceleration_arcsec, alpha_equal_speed_arcsec }
    }

    fn __reduce__(slf: &Bound<'_, Self>) -> Reduced<(Bounds, Bounds, Bounds, Bounds)> {
        let own = slf.get();
        let fields = (
            own.elastic_angle_rad,
            own.elastic_angle_arcsec,
            own.alpha_deceleration_arcsec,
            own.alpha_equal_speed_arcsec,
        );
        Ok((slf.get_type().into_any().unbind(), fields))
    }

    fn __repr__(&self) -> String {
        let (lower, upper) = self.elastic_angle_arcsec;
        format!("Enclosure(elastic angle between {lower} and {upper} arcsec)")
    }
}

/// Largest elastic angle over a period of the drive.
#[pyclass(frozen, eq, get_all, module = "cbpt._core")]
#[derive(Clone, PartialEq)]
pub struct LargestAngle {
    /// Largest elastic angle, with the sign of the torque, seconds of arc.
    elastic_angle_arcsec: f64,
    /// Crank angle where it occurs, degrees.
    input_angle_deg: f64,
    /// Largest minus smallest size of the elastic angle, seconds of arc.
    amplitude_arcsec: f64,
    /// Crank angle after which the drive repeats, degrees.
    period_deg: f64,
}

impl From<cbpt_core::extremes::LargestAngle> for LargestAngle {
    fn from(largest: cbpt_core::extremes::LargestAngle) -> Self {
        Self {
            elastic_angle_arcsec: largest.elastic_angle_rad * ARCSEC_PER_RAD,
            input_angle_deg: largest.input_angle_rad.to_degrees(),
            amplitude_arcsec: largest.amplitude_rad * ARCSEC_PER_RAD,
            period_deg: largest.period_rad.to_degrees(),
        }
    }
}

#[pymethods]
impl LargestAngle {
    #[new]
    fn new(elastic_angle_arcsec: f64, input_angle_deg: f64, amplitude_arcsec: f64, period_deg: f64) -> Self {
        Self { elastic_angle_arcsec, input_angle_deg, amplitude_arcsec, period_deg }
    }

    fn __reduce__(slf: &Bound<'_, Self>) -> Reduced<(f64, f64, f64, f64)> {
        let own = slf.get();
        let fields = (own.elastic_angle_arcsec, own.input_angle_deg, own.amplitude_arcsec, own.period_deg);
        Ok((slf.get_type().into_any().unbind(), fields))
    }

    fn __repr__(&self) -> String {
        format!(
            "LargestAngle(largest elastic angle {:.6} arcsec at input angle {:.4} deg; ripple {:.3e} arcsec peak to peak, period {:.4} deg)",
            self.elastic_angle_arcsec, self.input_angle_deg, self.amplitude_arcsec, self.period_deg
        )
    }
}
