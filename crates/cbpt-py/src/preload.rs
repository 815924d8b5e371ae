//! Preload thresholds.

use cbpt_cli::commands::{Units, preload::report};
use pyo3::prelude::*;

use crate::Reduced;

/// The three preloads that a torque needs, N; infinite if no preload is enough.
#[pyclass(frozen, eq, get_all, from_py_object, module = "cbpt._core")]
#[derive(Clone, Copy, PartialEq)]
pub struct Thresholds {
    /// The drive holds the torque at preloads above this one.
    hold_N: f64,
    /// At this preload and above, no ball comes loose (the paper's minimum APF).
    continuous_N: f64,
    /// At this preload and above, every meshing point stays in contact.
    zero_backlash_N: f64,
}

impl From<cbpt_core::PreloadThresholds> for Thresholds {
    fn from(t: cbpt_core::PreloadThresholds) -> Self {
        Self { hold_N: t.hold_N, continuous_N: t.continuous_N, zero_backlash_N: t.zero_backlash_N }
    }
}

impl From<Thresholds> for cbpt_core::PreloadThresholds {
    fn from(t: Thresholds) -> Self {
        Self { hold_N: t.hold_N, continuous_N: t.continuous_N, zero_backlash_N: t.zero_backlash_N }
    }
}

#[pymethods]
impl Thresholds {
    #[new]
    fn new(hold_N: f64, continuous_N: f64, zero_backlash_N: f64) -> Self {
        Self { hold_N, continuous_N, zero_backlash_N }
    }

    fn __reduce__(slf: &Bound<'_, Self>) -> Reduced<(f64, f64, f64)> {
        let t = slf.get();
        Ok((slf.get_type().into_any().unbind(), (t.hold_N, t.continuous_N, t.zero_backlash_N)))
    }

    fn __repr__(&self) -> String {
        format!(
            "Thresholds(hold_N={:.4}, continuous_N={:.4}, zero_backlash_N={:.4})",
            self.hold_N, self.continuous_N, self.zero_backlash_N
        )
    }
}

/// Thresholds of both pairs and of the drive, in terms of the torque on the drive's output.
#[pyclass(frozen, eq, get_all, module = "cbpt._core")]
#[derive(Clone, PartialEq)]
pub struct PreloadThresholds {
    /// Torque on the output, N m.
    torque_Nm: f64,
    /// Angle of the input crank, degrees; ``None`` for maxima over a period.
    input_angle_deg: Option<f64>,
    /// Of the deceleration pair.
    deceleration: Thresholds,
    /// Of the equal-speed pair.
    equal_speed: Thresholds,
}

impl PreloadThresholds {
    fn rust(&self) -> cbpt_core::DriveThresholds {
        cbpt_core::DriveThresholds {
            deceleration: self.deceleration.into(),
            equal_speed: self.equal_speed.into(),
        }
    }
}

#[pymethods]
impl PreloadThresholds {
    #[new]
    pub fn new(
        torque_Nm: f64,
        input_angle_deg: Option<f64>,
        deceleration: Thresholds,
        equal_speed: Thresholds,
    ) -> Self {
        Self { torque_Nm, input_angle_deg, deceleration, equal_speed }
    }

    /// Of the drive: the larger of each.
    #[getter]
    fn drive(&self) -> Thresholds {
        self.rust().drive().into()
    }

    fn __reduce__(slf: &Bound<'_, Self>) -> Reduced<(f64, Option<f64>, Thresholds, Thresholds)> {
        let t = slf.get();
        Ok((
            slf.get_type().into_any().unbind(),
            (t.torque_Nm, t.input_angle_deg, t.deceleration, t.equal_speed),
        ))
    }

    fn __repr__(&self) -> String {
        report(&self.rust(), self.torque_Nm, self.input_angle_deg, &Units::default()).text
    }
}
