//! What a solved pair means: deformation, force and pressure at each meshing point, and the pair's resultants.

use super::ContactLaw;
use super::solve::PairState;
use crate::hertz::LoadedContact;
use crate::pair::{Diagonal, MeshingPoint, MeshingPoints};

/// What a torque does to a meshing point.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Role {
    /// Force-transmission meshing point (FTMP): the torque loads it.
    ForceTransmission,
    /// Non-force-transmission meshing point (NFTMP): the torque unloads it.
    NonForceTransmission,
    /// No torque, or no arm: the torque does not move it.
    Neutral,
}

impl Role {
    /// Short name as in tables: `FTMP`, `NFTMP`, `neutral`.
    pub fn name(self) -> &'static str {
        match self {
            Self::ForceTransmission => "FTMP",
            Self::NonForceTransmission => "NFTMP",
            Self::Neutral => "neutral",
        }
    }
}

/// Whether a meshing point touches.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Contact {
    /// It carries force.
    Loaded,
    /// Ball and wall have parted.
    Parted,
    /// One of its walls does not exist.
    WallMissing,
}

impl Contact {
    /// Short name as in tables: `loaded`, `parted`, `wall_missing`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Loaded => "loaded",
            Self::Parted => "parted",
            Self::WallMissing => "wall_missing",
        }
    }
}

/// One diagonal of one ball under load: the two meshing points at its ends carry the same force.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LoadedPoint {
    /// Number of the ball, from 0.
    pub ball: usize,
    /// Which diagonal.
    pub diagonal: Diagonal,
    /// What the torque does to it.
    pub role: Role,
    /// Whether it touches.
    pub contact: Contact,
    /// Deformation of the diagonal, both contacts together, m, never below 0.
    pub deformation_m: f64,
    /// How far ball and walls have parted, m, never below 0.
    pub gap_m: f64,
    /// Normal force N, never below 0.
    pub force_N: f64,
    /// Each end by Hertz: approach, ellipse, peak pressure; `None` where the wall is missing.
    pub walls: [Option<LoadedContact>; 2],
}

/// A solved pair: its angle, resultants and meshing points.
#[derive(Debug, Clone, PartialEq)]
pub struct PairSolution {
    /// Elastic angle of the pair (all its rows), rad.
    pub rotation_rad: f64,
    /// Torque that the pair carries, N m.
    pub torque_Nm: f64,
    /// Approach of its plates (of one row), m.
    pub approach_m: f64,
    /// Sideways shift of a floating plate, m.
    pub sideways_m: f64,
    /// Torsional stiffness dM0/dalpha of the pair at constant preload, N m/rad.
    pub torsional_stiffness_Nm_per_rad: f64,
    /// Force of the balls on the output plate in the plane: along and across the line of centres, N.
    ///
    /// Across is M0/(Zo e) for the deceleration pair: what the eccentric bearing carries.
    pub in_plane_force_N: [f64; 2],
    /// Couple that tilts the plates about the line of centres: sum of axial forces times arms, N m.
    pub tilt_couple_Nm: f64,
    /// How many diagonals carry force, of those in [`PairSolution::points`].
    pub carrying: usize,
    /// Highest peak pressure of any meshing point, Pa.
    pub peak_pressure_Pa: f64,
    /// Largest scaled residual.
    pub residual: f64,
    /// Solver steps.
    pub steps: u32,
    /// The diagonals of one row, ball by ball, plus before minus.
    pub points: Vec<LoadedPoint>,
}

impl PairSolution {
    /// Works out the meshing points and resultants of a solved state.
    pub fn new(points: &MeshingPoints, torque_Nm: f64, solved: &PairState) -> Self {
        let law = ContactLaw::new(points.exponent);
        let rows = f64::from(points.rows);
        let loaded: Vec<LoadedPoint> =
            points.points.iter().map(|point| load_point(point, law, torque_Nm, points, solved)).collect();
        let mut in_plane_force_N = [0.0; 2];
        let mut tilt_couple_Nm = 0.0;
        for (point, load) in points.points.iter().zip(&loaded) {
            let in_plane = point.diagonal.sign() * load.force_N * point.cos_beta;
            in_plane_force_N[0] -= in_plane * point.direction[0];
            in_plane_force_N[1] -= in_plane * point.direction[1];
            tilt_couple_Nm += load.force_N * point.sin_beta * point.arm_m;
        }
        let pressure = |load: &LoadedPoint| {
            load.walls.iter().flatten().map(|wall| wall.peak_pressure_Pa).fold(0.0, f64::max)
        };
        Self {
            rotation_rad: rows * solved.state.rotation_rad,
            torque_Nm,
            approach_m: solved.state.approach_m(),
            sideways_m: solved.state.sideways_m,
            torsional_stiffness_Nm_per_rad: solved.torsional_stiffness_Nm_per_rad / rows,
            in_plane_force_N,
            tilt_couple_Nm,
            carrying: loaded.iter().filter(|load| load.contact == Contact::Loaded).count(),
            peak_pressure_Pa: loaded.iter().map(pressure).fold(0.0, f64::max),
            residual: solved.residual,
            steps: solved.steps,
            points: loaded,
        }
    }
}

fn load_point(
    point: &MeshingPoint,
    law: ContactLaw,
    torque_Nm: f64,
    points: &MeshingPoints,
    solved: &PairState,
) -> LoadedPoint {
    let deformation = solved.state.deformation_m(point);
    let force_N = if point.exists() { law.force_N(point.stiffness, deformation) } else { 0.0 };
    // An arm of rounding size, as sin(pi) leaves it, is no arm.
    let lever = point.signed_arm_m() * torque_Nm.signum();
    let smallest_arm = 1e-12 * points.largest_arm_m();
    LoadedPoint {
        ball: point.ball,
        diagonal: point.diagonal,
        role: if torque_Nm == 0.0 || lever.abs() <= smallest_arm {
            Role::Neutral
        } else if lever > 0.0 {
            Role::ForceTransmission
        } else {
            Role::NonForceTransmission
        },
        contact: if !point.exists() {
            Contact::WallMissing
        } else if force_N > 0.0 {
            Contact::Loaded
        } else {
            Contact::Parted
        },
        deformation_m: if point.exists() { deformation.max(0.0) } else { 0.0 },
        gap_m: (-deformation).max(0.0),
        force_N,
        walls: point.walls.map(|wall| wall.map(|contact| contact.under(force_N))),
    }
}
