//! Friction of a drive: torque at the input, efficiency, wear.

use cbpt_core::friction::period::{Backdriving, DriveOverPeriod};
use cbpt_core::friction::{DriveFriction, PairFriction as RustPair};
use cbpt_core::pair::Diagonal;
use pyo3::prelude::*;

/// One loaded contact of a ball with a groove, for each radian of the input.
#[pyclass(frozen, get_all, module = "cbpt._core")]
#[derive(Clone)]
pub struct FrictionContact {
    /// ``deceleration`` or ``equal_speed``.
    pair: &'static str,
    /// Row of the pair, from 0; only a cross-slide has two.
    row: usize,
    /// Number of the ball in its row, from 0.
    ball: usize,
    /// ``plus`` or ``minus``: the diagonal of the ball.
    diagonal: &'static str,
    /// 0 for the driving (epicycloid, planet) plate, 1 for the plate opposite.
    side: usize,
    /// Normal force, N.
    force_N: f64,
    /// Slip along the track, m for each radian of the input.
    slip_m_per_rad: f64,
    /// Turn of the ball about the contact normal against the plate, for each radian of the input.
    pivoting: f64,
    /// Part of the friction torque at the input, N m.
    torque_Nm: f64,
}

/// Friction torque of a pair at the input, N m.
#[pyclass(frozen, eq, get_all, module = "cbpt._core")]
#[derive(Clone, Copy, PartialEq)]
pub struct PairFriction {
    /// Friction torque at the input, N m: the mean over a period, or the value at the angle.
    torque_Nm: f64,
    /// Largest minus smallest value over a period, N m; 0 at one angle.
    ripple_Nm: f64,
    /// Archard's index for a turn of the input: friction work over the coefficient, N m.
    wear_Nm_per_turn: f64,
    /// Largest index for a turn of the input and a length of track, of the grooves of the driving plate and of the plate
    /// opposite, N m/mm.
    track_wear_Nm_per_mm: (f64, f64),
}

/// Friction of a drive under a load: over a period, or at one angle of the crank.
#[pyclass(frozen, get_all, module = "cbpt._core")]
#[derive(Clone)]
pub struct Friction {
    /// ``ok``, or why there is no solution.
    status: &'static str,
    /// Torque on the output, N m.
    torque_Nm: f64,
    /// Axial preload, N.
    preload_N: f64,
    /// Angle of the input crank, degrees; ``None`` for a period.
    input_angle_deg: Option<f64>,
    /// Friction coefficient.
    coefficient: f64,
    /// Transmission ratio.
    transmission_ratio: f64,
    /// Friction torque of the drive at the input, N m: the mean over a period, or the value at the angle. ``None`` without
    /// solution, as all below.
    friction_torque_Nm: Option<f64>,
    /// Largest minus smallest friction torque over a period, N m; 0 at one angle.
    ripple_Nm: Option<f64>,
    /// Work at the output over work at the input; 0 without torque.
    efficiency: Option<f64>,
    /// The deceleration pair.
    deceleration: Option<PairFriction>,
    /// The equal-speed pair.
    equal_speed: Option<PairFriction>,
    /// Every loaded contact; empty for a period.
    contacts: Vec<FrictionContact>,
    /// Largest relative distance of a ball's loss from its proved lower bound; ``None`` for a period.
    gap: Option<f64>,
}

const PER_MM: f64 = 1e-3;

fn at_angle(pair: &RustPair) -> PairFriction {
    PairFriction {
        torque_Nm: pair.torque_Nm,
        ripple_Nm: 0.0,
        wear_Nm_per_turn: pair.wear_Nm_per_turn,
        track_wear_Nm_per_mm: (pair.track_wear_N[0] * PER_MM, pair.track_wear_N[1] * PER_MM),
    }
}

fn over_period(pair: &cbpt_core::friction::period::PairOverPeriod) -> PairFriction {
    PairFriction {
        torque_Nm: pair.torque.mean_Nm,
        ripple_Nm: pair.torque.ripple_Nm(),
        wear_Nm_per_turn: pair.wear_Nm_per_turn,
        track_wear_Nm_per_mm: (pair.track_wear_N[0] * PER_MM, pair.track_wear_N[1] * PER_MM),
    }
}

fn contacts<'a>(name: &'static str, pair: &'a RustPair) -> impl Iterator<Item = FrictionContact> + 'a {
    pair.contacts.iter().map(move |contact| FrictionContact {
        pair: name,
        row: contact.row,
        ball: contact.ball,
        diagonal: if contact.diagonal == Diagonal::Plus { "plus" } else { "minus" },
        side: contact.side,
        force_N: contact.force_N,
        slip_m_per_rad: contact.slip_m,
        pivoting: contact.pivoting,
        torque_Nm: contact.torque_Nm,
    })
}

impl Friction {
    pub fn at_angle(found: &DriveFriction) -> Self {
        let pairs = [("deceleration", &found.deceleration), ("equal_speed", &found.equal_speed)];
        let listed = pairs.iter().filter_map(|(name, pair)| Some((*name, pair.as_ref()?)));
        Self {
            status: found.status.name(),
            torque_Nm: found.load.torque_Nm(),
            preload_N: found.load.preload_N(),
            input_angle_deg: Some(found.load.input_angle_rad().to_degrees()),
            coefficient: found.coefficient,
            transmission_ratio: found.transmission_ratio,
            friction_torque_Nm: found.torque_Nm(),
            ripple_Nm: found.torque_Nm().map(|_| 0.0),
            efficiency: found.efficiency(),
            deceleration: found.deceleration.as_ref().map(at_angle),
            equal_speed: found.equal_speed.as_ref().map(at_angle),
            gap: listed.clone().map(|(_, pair)| pair.gap).reduce(f64::max),
            contacts: listed.flat_map(|(name, pair)| contacts(name, pair)).collect(),
        }
    }

    pub fn over_period(
        status: cbpt_core::Status,
        load: &cbpt_core::Load,
        coefficient: f64,
        transmission_ratio: f64,
        found: Option<&DriveOverPeriod>,
    ) -> Self {
        Self {
            status: status.name(),
            torque_Nm: load.torque_Nm(),
            preload_N: load.preload_N(),
            input_angle_deg: None,
            coefficient,
            transmission_ratio,
            friction_torque_Nm: found.map(|found| found.torque.mean_Nm),
            ripple_Nm: found.map(|found| found.torque.ripple_Nm()),
            efficiency: found.map(DriveOverPeriod::efficiency),
            deceleration: found.map(|found| over_period(&found.deceleration)),
            equal_speed: found.map(|found| over_period(&found.equal_speed)),
            contacts: Vec::new(),
            gap: None,
        }
    }
}

#[pymethods]
impl Friction {
    /// Whether the load has a solution, so that the friction is a number.
    #[getter]
    fn has_solution(&self) -> bool {
        self.friction_torque_Nm.is_some()
    }

    /// Torque at the input that drives the load, N m.
    #[getter]
    fn input_torque_Nm(&self) -> Option<f64> {
        self.friction_torque_Nm.map(|friction| (self.torque_Nm / self.transmission_ratio).abs() + friction)
    }

    /// Archard's index of both pairs for a turn of the input: friction work over the coefficient, N m.
    #[getter]
    fn wear_Nm_per_turn(&self) -> Option<f64> {
        Some(self.deceleration?.wear_Nm_per_turn + self.equal_speed?.wear_Nm_per_turn)
    }

    /// Friction torque at the input, N m, with another coefficient: it is proportional to the coefficient.
    fn with_coefficient(&self, coefficient: f64) -> Option<f64> {
        let at_one = self.wear_Nm_per_turn()? / std::f64::consts::TAU;
        Some(at_one * coefficient)
    }

    /// Heat of the contacts, W, at a speed of the input (turns for each minute).
    fn heat_W(&self, input_speed_rpm: f64) -> Option<f64> {
        self.friction_torque_Nm
            .map(|friction| friction * input_speed_rpm.abs() * std::f64::consts::TAU / 60.0)
    }

    fn __repr__(&self) -> String {
        match (self.friction_torque_Nm, self.efficiency) {
            (Some(torque), Some(efficiency)) => format!(
                "Friction({torque:.5} N m at the input, efficiency {efficiency:.4}, coefficient {})",
                self.coefficient
            ),
            _ => format!("Friction({})", self.status),
        }
    }
}

/// Torque at the output, N m, that turns a free input, and whether there is one.
pub fn backdriving_torque_Nm(found: Backdriving) -> Option<f64> {
    match found {
        Backdriving::From { torque_Nm } => Some(torque_Nm),
        Backdriving::Locks { .. } => None,
    }
}
