//! A reducer and what can be asked of it.

use cbpt_cli::case::Case as RustCase;
use cbpt_core::cost::Rubbing;
use cbpt_core::friction::period::FrictionPeriod;
use cbpt_core::sweep::Progress;
use cbpt_core::{Load, Reducer, Severity, TorsionSpring};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyString};

use crate::Reduced;
use crate::error::{about_ball_drives, drive_with_effect, half_a_load, invalid_input};
use crate::finding::Finding;
use crate::friction::{Friction, backdriving_torque_Nm};
use crate::given::{CasePath, case_from_dict, case_from_file, case_from_toml};
use crate::interrupt::without_gil;
use crate::preload::{PreloadThresholds, Thresholds};
use crate::sensitivity::Sensitivities;
use crate::solution::{LargestAngle, Solution};

/// A cycloid ball planetary transmission, checked and frozen; or any other reducer as a torsion spring, which has
/// ``solve``, but no pairs, findings and thresholds of the preload.
///
/// Make one with :meth:`Drive.from_file`, :meth:`Drive.from_toml` or :meth:`Drive.from_dict`; the keys are those of a
/// case file.
#[pyclass(frozen, eq, module = "cbpt._core")]
#[derive(Clone, PartialEq)]
pub struct Drive {
    pub reducer: Reducer,
}

impl Drive {
    pub fn rust(&self) -> &Reducer {
        &self.reducer
    }

    /// The ball drive that a question is about.
    pub fn ball_drive(&self, py: Python<'_>, asked: &str) -> PyResult<&cbpt_core::Drive> {
        self.reducer.ball_drive().ok_or_else(|| about_ball_drives(py, asked))
    }

    /// The drive of a case that has nothing else to compute.
    fn new(py: Python<'_>, case: RustCase) -> PyResult<Self> {
        match case.effects.first() {
            None => Ok(Self { reducer: case.reducer }),
            Some(effect) => Err(drive_with_effect(py, &effect.id)),
        }
    }
}

#[pymethods]
impl Drive {
    /// Reads the drive of a case file.
    ///
    /// Raises ``CaseError`` with file, line, key, what was found and what is allowed.
    #[staticmethod]
    fn from_file(py: Python<'_>, path: CasePath) -> PyResult<Self> {
        Self::new(py, case_from_file(py, &path)?)
    }

    /// Reads the drive of a case given as TOML text.
    ///
    /// Raises ``CaseError`` with line, key, what was found and what is allowed.
    #[staticmethod]
    fn from_toml(py: Python<'_>, text: &Bound<'_, PyString>) -> PyResult<Self> {
        Self::new(py, case_from_toml(text, "<text>")?)
    }

    /// Makes a drive from a dict with the sections and keys of a case file, for example
    /// ``{"deceleration": {"ball_count": 20, "rolling_circle_radius_mm": 4, ...}, "equal_speed": {...}}``.
    ///
    /// Raises ``CaseError`` with key, what was found and what is allowed.
    #[staticmethod]
    #[pyo3(signature = (case: "dict[str, Any]"))]
    fn from_dict(py: Python<'_>, case: &Bound<'_, PyDict>) -> PyResult<Self> {
        Self::new(py, case_from_dict(py, case)?)
    }

    /// The drive as a case file in SI units; ``from_toml`` of it gives the same drive to the last bit.
    fn to_toml(&self) -> String {
        RustCase::reducer_to_toml(&self.reducer)
    }

    /// ``ball_drive`` or ``torsion_spring``.
    #[getter]
    fn kind(&self) -> &'static str {
        match self.reducer {
            Reducer::BallDrive(_) => "ball_drive",
            Reducer::TorsionSpring(_) => "torsion_spring",
        }
    }

    /// Input turns for one turn of the output; negative if they turn in opposite directions.
    #[getter]
    fn transmission_ratio(&self, py: Python<'_>) -> PyResult<f64> {
        Ok(self.ball_drive(py, "transmission_ratio")?.transmission_ratio())
    }

    /// Eccentricity e = K r0, m.
    #[getter]
    fn eccentricity_m(&self, py: Python<'_>) -> PyResult<f64> {
        Ok(self.ball_drive(py, "eccentricity_m")?.deceleration().eccentricity_m())
    }

    /// Number of deceleration balls.
    #[getter]
    fn deceleration_ball_count(&self, py: Python<'_>) -> PyResult<u32> {
        Ok(self.ball_drive(py, "deceleration_ball_count")?.deceleration().ball_count)
    }

    /// Number of equal-speed balls (of one row of a cross-slide).
    #[getter]
    fn equal_speed_ball_count(&self, py: Python<'_>) -> PyResult<u32> {
        Ok(self.ball_drive(py, "equal_speed_ball_count")?.equal_speed().ball_count())
    }

    /// Whether the drive has tables of its parts as they were made.
    #[getter]
    fn has_parts_as_made(&self) -> bool {
        self.reducer.ball_drive().is_some_and(|drive| drive.as_made().is_some())
    }

    /// The same drive with nominal parts.
    fn nominal(&self) -> Self {
        match &self.reducer {
            Reducer::BallDrive(drive) => Self { reducer: drive.nominal().into() },
            Reducer::TorsionSpring(_) => self.clone(),
        }
    }

    /// Turns of the input after which the drive, with its parts as they were made, stands as before.
    #[getter]
    fn repetition_turns(&self, py: Python<'_>) -> PyResult<u32> {
        Ok(self.ball_drive(py, "repetition_turns")?.repetition_turns())
    }

    /// Turns of the planet, then of the deceleration balls, against the line of centres, each as (turns, turns of the
    /// input).
    #[getter]
    fn turns_of_parts(&self, py: Python<'_>) -> PyResult<Vec<(u32, u32)>> {
        let turns = self.ball_drive(py, "turns_of_parts")?.turns_of_parts();
        Ok(turns.map(|[turns, of_input]| (turns, of_input)).to_vec())
    }

    /// Solves the drive under one load.
    ///
    /// Parameters
    /// ----------
    /// torque_Nm : float
    ///     Resistance torque on the output, N m, of either sign.
    /// preload_N : float, optional
    ///     Axial preload, N, above 0. A ball drive needs one; a torsion spring does not.
    /// input_angle_deg : float, optional
    ///     Angle of the input crank from the line of centres, degrees.
    ///
    /// Returns
    /// -------
    /// Solution
    ///     Its ``status`` says whether the load has a solution; its angles are ``None`` if there is none.
    ///
    /// Raises
    /// ------
    /// InvalidInputError
    ///     For an invalid number; names the number and the rule.
    #[pyo3(signature = (torque_Nm, preload_N = None, input_angle_deg = 0.0))]
    fn solve(
        &self,
        py: Python<'_>,
        torque_Nm: f64,
        preload_N: Option<f64>,
        input_angle_deg: f64,
    ) -> PyResult<Solution> {
        let load = match preload_N {
            Some(preload_N) => Load::new(torque_Nm, preload_N, input_angle_deg.to_radians()),
            None => Load::without_preload(torque_Nm, input_angle_deg.to_radians()),
        };
        load.and_then(|load| py.detach(|| Solution::solve(&self.reducer, &load, input_angle_deg)))
            .map_err(|error| invalid_input(py, &error))
    }

    /// Preload that a torque (N m) needs: to hold, for continuous transmission, for zero backlash, of each pair and of
    /// the drive; maxima over a period, or the values at ``input_angle_deg`` if it is given.
    #[pyo3(signature = (torque_Nm, input_angle_deg = None))]
    fn preload(
        &self,
        py: Python<'_>,
        torque_Nm: f64,
        input_angle_deg: Option<f64>,
    ) -> PyResult<PreloadThresholds> {
        Load::new(torque_Nm, 1.0, input_angle_deg.unwrap_or(0.0))
            .map_err(|error| invalid_input(py, &error))?;
        let drive = self.ball_drive(py, "preload")?;
        let found = py.detach(|| match input_angle_deg {
            Some(angle) => drive.preload_thresholds_at(torque_Nm, angle.to_radians()),
            None => drive.preload_thresholds(torque_Nm),
        });
        Ok(PreloadThresholds::new(
            torque_Nm,
            input_angle_deg,
            Thresholds::from(found.deceleration),
            Thresholds::from(found.equal_speed),
        ))
    }

    /// Friction under a load: torque at the input, efficiency, wear.
    ///
    /// Parameters
    /// ----------
    /// torque_Nm : float
    ///     Resistance torque on the output, N m, of either sign.
    /// preload_N : float
    ///     Axial preload, N.
    /// input_angle_deg : float, optional
    ///     Angle of the input crank, degrees: every contact there. Without it, mean and ripple over a period.
    /// coefficient : float, optional
    ///     Friction coefficient of the contacts.
    ///
    /// Returns
    /// -------
    /// Friction
    ///     Its ``status`` says whether the load has a solution; its numbers are ``None`` if there is none.
    ///
    /// Raises
    /// ------
    /// InvalidInputError
    ///     For an invalid number, and for a torsion spring.
    #[pyo3(signature = (torque_Nm, preload_N, input_angle_deg = None, coefficient = 0.1))]
    fn friction(
        &self,
        py: Python<'_>,
        torque_Nm: f64,
        preload_N: f64,
        input_angle_deg: Option<f64>,
        coefficient: f64,
    ) -> PyResult<Friction> {
        let drive = self.ball_drive(py, "friction")?;
        let found = py.detach(|| {
            let load = Load::new(torque_Nm, preload_N, input_angle_deg.unwrap_or(0.0).to_radians())?;
            if input_angle_deg.is_some() {
                return drive.friction(&load, coefficient).map(|found| Friction::at_angle(&found));
            }
            let (status, found) = FrictionPeriod::new(drive).at(torque_Nm, preload_N, coefficient)?;
            let ratio = drive.transmission_ratio();
            Ok(Friction::over_period(status, &load, coefficient, ratio, found.as_ref()))
        });
        found.map_err(|error| invalid_input(py, &error))
    }

    /// Torque at the output, N m, that turns a free input at every angle against the friction; ``None`` if the drive locks
    /// up to the torque that its preload holds.
    #[pyo3(signature = (preload_N, coefficient = 0.1))]
    fn backdriving_torque_Nm(
        &self,
        py: Python<'_>,
        preload_N: f64,
        coefficient: f64,
    ) -> PyResult<Option<f64>> {
        let drive = self.ball_drive(py, "backdriving_torque_Nm")?;
        let found = py.detach(|| FrictionPeriod::new(drive).backdriving(preload_N, coefficient));
        found.map(backdriving_torque_Nm).map_err(|error| invalid_input(py, &error))
    }

    /// Exact derivatives of the elastic angle and of the preload thresholds by every design number.
    ///
    /// Parameters
    /// ----------
    /// torque_Nm : float
    ///     Torque on the output, N m.
    /// preload_N : float
    ///     Axial preload, N.
    /// input_angle_deg : float, optional
    ///     Angle of the input crank, degrees. The thresholds are those over a period.
    /// also : list of str, optional
    ///     Names of single numbers that are otherwise combined with an equal one, such as
    ///     ``material.ball_youngs_modulus_Pa``.
    /// coefficient : float, optional
    ///     Friction coefficient. With it, friction torque, efficiency, wear and static safety at the input angle too, by central
    ///     differences: least dissipation has kinks, and ``one_sided`` names the numbers at which the slopes to both sides differ.
    /// output_inertia_kg_m2 : float, optional
    ///     Moment of inertia at the output, kg m^2, for the natural frequency beside them.
    ///
    /// Returns
    /// -------
    /// Sensitivities
    ///     One entry for the elastic angle, one for each threshold, and those of friction where they were asked for.
    ///
    /// Raises
    /// ------
    /// InvalidInputError
    ///     For an invalid load or an unknown name, and for a torsion spring.
    #[pyo3(signature = (torque_Nm, preload_N, input_angle_deg = 0.0, also = Vec::new(), coefficient = None, output_inertia_kg_m2 = None))]
    #[expect(clippy::too_many_arguments, reason = "a load, and what is wanted beside the angle")]
    fn sensitivities(
        &self,
        py: Python<'_>,
        torque_Nm: f64,
        preload_N: f64,
        input_angle_deg: f64,
        also: Vec<String>,
        coefficient: Option<f64>,
        output_inertia_kg_m2: Option<f64>,
    ) -> PyResult<Sensitivities> {
        let drive = self.ball_drive(py, "sensitivities")?;
        let rubbing = coefficient.map(|coefficient| Rubbing { coefficient, output_inertia_kg_m2 });
        let found = Load::new(torque_Nm, preload_N, input_angle_deg.to_radians())
            .and_then(|load| py.detach(|| Sensitivities::solve(drive, &load, &also, rubbing.as_ref())));
        found.map_err(|error| invalid_input(py, &error))
    }

    /// Largest elastic angle over a period of the drive at a torque (N m) and preload (N); ``None`` if some angle of
    /// the crank has no solution. Ctrl-C stops it.
    fn largest_elastic_angle(
        &self,
        py: Python<'_>,
        torque_Nm: f64,
        preload_N: f64,
    ) -> PyResult<Option<LargestAngle>> {
        let drive = self.ball_drive(py, "largest_elastic_angle")?;
        let work = |progress: &Progress| drive.largest_elastic_angle_watched(torque_Nm, preload_N, progress);
        let found = without_gil(py, None, work)?;
        Ok(found.map_err(|error| invalid_input(py, &error))?.1.map(LargestAngle::from))
    }

    /// Findings about the design, the worst first.
    ///
    /// Parameters
    /// ----------
    /// torque_Nm, preload_N : float, optional
    ///     A load, N m and N. With both, the contacts under this load are checked too.
    /// input_angle_deg : float, optional
    ///     Angle of the input crank, degrees.
    ///
    /// Returns
    /// -------
    /// list of Finding
    ///     Each with code, severity, pair, message and remedy.
    ///
    /// Raises
    /// ------
    /// InvalidInputError
    ///     For an invalid load, for a torque without a preload or the reverse, and for a torsion spring.
    #[pyo3(signature = (torque_Nm = None, preload_N = None, input_angle_deg = 0.0))]
    fn findings(
        &self,
        py: Python<'_>,
        torque_Nm: Option<f64>,
        preload_N: Option<f64>,
        input_angle_deg: f64,
    ) -> PyResult<Vec<Finding>> {
        let load = match (torque_Nm, preload_N) {
            (Some(torque), Some(preload)) => Some(
                Load::new(torque, preload, input_angle_deg.to_radians())
                    .map_err(|error| invalid_input(py, &error))?,
            ),
            (None, None) => None,
            _ => return Err(half_a_load(py)),
        };
        Ok(self.ball_drive(py, "findings")?.findings(load.as_ref()).iter().map(Finding::from).collect())
    }

    fn __reduce__(slf: &Bound<'_, Self>) -> Reduced<(String,)> {
        Ok((slf.get_type().getattr("from_toml")?.unbind(), (slf.get().to_toml(),)))
    }

    fn __hash__(&self) -> u64 {
        hash(&self.to_toml())
    }

    pub fn __repr__(&self) -> String {
        let drive = match &self.reducer {
            Reducer::BallDrive(drive) => drive,
            Reducer::TorsionSpring(spring) => return repr_of_spring(spring),
        };
        let (pair, equal) = (drive.deceleration(), drive.equal_speed());
        let kind = match equal {
            cbpt_core::EqualSpeed::RingGroove(_) => "ring grooves",
            cbpt_core::EqualSpeed::CrossSlide(_) => "cross-slide",
        };
        let findings = drive.findings(None);
        let worst = findings.iter().map(|f| f.severity).max().filter(|s| *s > Severity::Note);
        format!(
            "Drive(ratio {}, {} deceleration balls of radius {:.4} mm, eccentricity {:.4} mm; {kind} with {} balls on {:.4} mm{})",
            drive.transmission_ratio(),
            pair.ball_count,
            pair.groove.ball_radius_m * 1e3,
            pair.eccentricity_m() * 1e3,
            equal.ball_count(),
            equal.pitch_radius_m() * 1e3,
            worst.map_or(String::new(), |s| format!("; {} finding: see findings()", s.name())),
        )
    }
}

fn repr_of_spring(spring: &TorsionSpring) -> String {
    match (spring.torsional_stiffness_Nm_per_rad(), spring.points()) {
        (Some(stiffness), _) => format!("Drive(torsion spring of {stiffness} N m/rad)"),
        (None, points) => {
            let [first, .., last] = points else { return "Drive(torsion spring)".into() };
            format!("Drive(torsion spring, {} points from {} to {} N m)", points.len(), first[0], last[0])
        }
    }
}

/// A hash of a drive or a case by its text.
pub fn hash(text: &str) -> u64 {
    use std::hash::{DefaultHasher, Hash, Hasher};
    let mut hasher = DefaultHasher::new();
    text.hash(&mut hasher);
    hasher.finish()
}
