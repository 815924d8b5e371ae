//! The whole drive: pairs and load to elastic angles.
//!
//! Against the crank (angle theta) the balls turn backwards: Phi = -theta Z1/Z2 and psi = -theta Z1/Z3 with the
//! hypocycloid plate as output, Phi = theta Z3/Z2 and psi = theta Z3/Z1 with the epicycloid plate.
//!
//! - ring grooves:  `alpha_d` = alpha1(M0) + alpha2(M0);
//! - cross-slide:   `alpha_s` = alpha1(M0) + (Z1/Z3) alpha3(M0 Z1/Z3), because the cross-slide holds the planet, which
//!   carries M0 Z1/Z3, and the planet's turn reaches the output times Z1/Z3. alpha3 is the sum of both rows.

use crate::drive::{CrossSlide, CrossSlideForm, CrossSlideShare, Drive, EqualSpeed, Load, OutputPlate};
use crate::equilibrium::report::PairSolution;
use crate::equilibrium::solve::{PairState, solve_pair};
use crate::geometry::undercut::undercuts;
use crate::pair::{MeshingPoints, cross_slide, deceleration, offsets, ring_groove};
use crate::status::Status;

/// The meshing points of a drive at one angle of the input crank.
#[derive(Debug, Clone, PartialEq)]
pub struct DrivePoints {
    /// The deceleration pair.
    pub deceleration: MeshingPoints,
    /// The rows of the equal-speed pair that are solved one by one: one, or two in the paper's cross-slide form.
    pub equal_speed: Vec<MeshingPoints>,
    /// Torque of the equal-speed pair over M0, and the share of its angle that reaches the output.
    pub equal_speed_share: f64,
}

/// Angles alone, for sweeps and fits.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Angles {
    /// Part of the deceleration pair, rad.
    pub deceleration_rad: f64,
    /// Part of the equal-speed pair that reaches the output, rad.
    pub equal_speed_rad: f64,
    /// Largest scaled residual of the pairs.
    pub residual: f64,
    /// Solver steps, all pairs.
    pub steps: u32,
}

impl Angles {
    /// Elastic angle of the drive at its output, rad.
    pub fn elastic_angle_rad(&self) -> f64 {
        self.deceleration_rad + self.equal_speed_rad
    }
}

/// A drive under a load.
#[derive(Debug, Clone, PartialEq)]
pub struct Solution {
    /// How it ended; `angles` and the pairs are there exactly when [`Status::has_solution`].
    pub status: Status,
    /// The load.
    pub load: Load,
    /// Elastic angle and its two parts.
    pub angles: Option<Angles>,
    /// The deceleration pair in full.
    pub deceleration: Option<PairSolution>,
    /// The equal-speed pair in full, at the torque it carries; in the paper's cross-slide form its first row.
    pub equal_speed: Option<PairSolution>,
    /// Torsional stiffness dM0/dalpha of the drive at constant preload, N m/rad.
    pub torsional_stiffness_Nm_per_rad: Option<f64>,
}

impl Solution {
    /// A load without solution, and why.
    pub fn none(status: Status, load: Load) -> Self {
        Self {
            status,
            load,
            angles: None,
            deceleration: None,
            equal_speed: None,
            torsional_stiffness_Nm_per_rad: None,
        }
    }

    /// Elastic angle of the drive at its output, rad; `None` where there is no solution.
    pub fn elastic_angle_rad(&self) -> Option<f64> {
        self.angles.map(|angles| angles.elastic_angle_rad())
    }
}

impl Drive {
    /// Phase Phi of the deceleration pair at a crank angle, rad.
    pub fn deceleration_phase_rad(&self, input_angle_rad: f64) -> f64 {
        let pair = self.deceleration();
        let z2 = f64::from(pair.ball_count);
        match pair.output_plate {
            OutputPlate::Hypocycloid => -input_angle_rad * f64::from(pair.epicycloid_lobes()) / z2,
            OutputPlate::Epicycloid => input_angle_rad * f64::from(pair.hypocycloid_lobes()) / z2,
        }
    }

    /// Planet angle psi against the line of centres at a crank angle, rad.
    pub fn equal_speed_phase_rad(&self, input_angle_rad: f64) -> f64 {
        let pair = self.deceleration();
        let (z1, z3) = (f64::from(pair.epicycloid_lobes()), f64::from(pair.hypocycloid_lobes()));
        match pair.output_plate {
            OutputPlate::Hypocycloid => -input_angle_rad * z1 / z3,
            OutputPlate::Epicycloid => input_angle_rad * z3 / z1,
        }
    }

    /// Turn of the planet's groove against the line of centres for one turn of the crank: Z1/Z3 with the hypocycloid plate
    /// as output, Z3/Z1 with the epicycloid plate.
    pub fn planet_turn(&self) -> f64 {
        self.equal_speed_phase_rad(1.0).abs()
    }

    /// Torque of the equal-speed pair over M0, which is also the share of its angle that reaches the output: 1 for
    /// ring grooves, Z1/Z3 for the cross-slide.
    pub fn equal_speed_share(&self) -> f64 {
        match self.equal_speed() {
            EqualSpeed::CrossSlide(CrossSlide { share: CrossSlideShare::Carried, .. }) => {
                let pair = self.deceleration();
                f64::from(pair.epicycloid_lobes()) / f64::from(pair.hypocycloid_lobes())
            }
            _ => 1.0,
        }
    }

    /// Meshing points of the deceleration pair at its own phase Phi, its parts nominal.
    pub fn deceleration_points(&self, phase_rad: f64) -> MeshingPoints {
        let modulus = self.material().contact_modulus_Pa();
        deceleration::meshing_points(self.deceleration(), modulus, self.track_curvature(), phase_rad)
    }

    /// Meshing points of the equal-speed pair at its own phase psi, row by row where the rows differ; its parts nominal.
    pub fn equal_speed_points(&self, phase_rad: f64, input_angle_rad: f64) -> Vec<MeshingPoints> {
        let modulus = self.material().contact_modulus_Pa();
        let e = self.deceleration().eccentricity_m();
        match self.equal_speed() {
            EqualSpeed::RingGroove(ring) => {
                vec![ring_groove::meshing_points(ring, e, modulus, self.track_curvature(), phase_rad)]
            }
            EqualSpeed::CrossSlide(slide) => {
                let row = |shift| cross_slide::meshing_points(slide, modulus, self.track_curvature(), shift);
                match slide.form {
                    CrossSlideForm::Balanced => vec![row(0.0)],
                    CrossSlideForm::Paper => {
                        vec![row(e * input_angle_rad.cos()), row(e * input_angle_rad.sin())]
                    }
                }
            }
        }
    }

    /// All meshing points at a crank angle, with the parts as they were made.
    pub fn points(&self, input_angle_rad: f64) -> DrivePoints {
        DrivePoints {
            deceleration: self.deceleration_as_made(input_angle_rad),
            equal_speed: self.equal_speed_as_made(input_angle_rad),
            equal_speed_share: self.equal_speed_share(),
        }
    }

    /// The deceleration pair at a crank angle, with the parts as they were made.
    pub(crate) fn deceleration_as_made(&self, input_angle_rad: f64) -> MeshingPoints {
        let phase_rad = self.deceleration_phase_rad(input_angle_rad);
        let mut points = self.deceleration_points(phase_rad);
        offsets::on_deceleration(self, &mut points, phase_rad, self.lines_rad(input_angle_rad));
        points
    }

    /// The rows of the equal-speed pair at a crank angle, with the parts as they were made.
    pub(crate) fn equal_speed_as_made(&self, input_angle_rad: f64) -> Vec<MeshingPoints> {
        let phase_rad = self.equal_speed_phase_rad(input_angle_rad);
        let mut rows = self.equal_speed_points(phase_rad, input_angle_rad);
        offsets::on_equal_speed(self, &mut rows, phase_rad);
        rows
    }

    /// Angles of the line of centres in the epicycloid and in the hypocycloid plate at a crank angle, rad.
    fn lines_rad(&self, input_angle_rad: f64) -> [f64; 2] {
        let planet_rad = -self.equal_speed_phase_rad(input_angle_rad);
        match self.deceleration().output_plate {
            OutputPlate::Hypocycloid => [input_angle_rad, planet_rad],
            OutputPlate::Epicycloid => [planet_rad, -input_angle_rad],
        }
    }

    /// Solves the drive under one load: elastic angle (rad), and every meshing point of both pairs.
    ///
    /// Returns a solution, or a status with its reason where there is none; never a number that does not satisfy the
    /// equations.
    ///
    /// ```
    /// use cbpt_core::{Drive, Load, Status};
    ///
    /// let drive = Drive::paper_base_case();
    /// // Torque 5 N m, preload 600 N, input angle 0 rad.
    /// let solution = drive.solve(&Load::new(5.0, 600.0, 0.0)?);
    /// assert_eq!(solution.status, Status::Solved);
    /// assert!((solution.elastic_angle_rad().unwrap() - 60.4e-6).abs() < 0.1e-6);
    ///
    /// // 5 N of preload cannot hold this torque: the status says so, and there is no angle.
    /// let slips = drive.solve(&Load::new(5.0, 5.0, 0.0)?);
    /// assert!(matches!(slips.status, Status::BeyondHold { .. }));
    /// assert_eq!(slips.elastic_angle_rad(), None);
    /// # Ok::<(), cbpt_core::InvalidInput>(())
    /// ```
    pub fn solve(&self, load: &Load) -> Solution {
        if undercuts(self) {
            return Solution::none(Status::Undercut, *load);
        }
        self.points(load.input_angle_rad()).solution(load)
    }

    /// Elastic angle and its parts alone; cheaper than [`Drive::solve`] and the same numbers.
    pub fn angles(&self, load: &Load) -> (Status, Option<Angles>) {
        if undercuts(self) {
            return (Status::Undercut, None);
        }
        self.points(load.input_angle_rad()).angles(load.torque_Nm(), load.preload_N())
    }
}

/// Solved states of all rows of a drive.
struct DriveStates {
    deceleration: PairState,
    equal_speed: Vec<PairState>,
}

impl DriveStates {
    fn angles(&self, points: &DrivePoints) -> Angles {
        let all = || std::iter::once(&self.deceleration).chain(&self.equal_speed);
        let rows = self.equal_speed.iter().zip(&points.equal_speed);
        let rotation: f64 = rows.map(|(state, row)| f64::from(row.rows) * state.state.rotation_rad).sum();
        Angles {
            deceleration_rad: self.deceleration.state.rotation_rad,
            equal_speed_rad: points.equal_speed_share * rotation,
            residual: all().map(|state| state.residual).fold(0.0, f64::max),
            steps: all().map(|state| state.steps).sum(),
        }
    }
}

impl DrivePoints {
    /// Solves these meshing points: elastic angle, and each of them.
    pub fn solution(&self, load: &Load) -> Solution {
        let (status, states) = self.solve(load.torque_Nm(), load.preload_N());
        let Some(states) = states else { return Solution::none(status, *load) };
        let share = self.equal_speed_share;
        let deceleration = PairSolution::new(&self.deceleration, load.torque_Nm(), &states.deceleration);
        let compliance = 1.0 / deceleration.torsional_stiffness_Nm_per_rad
            + share
                * share
                * states
                    .equal_speed
                    .iter()
                    .zip(&self.equal_speed)
                    .map(|(state, row)| f64::from(row.rows) / state.torsional_stiffness_Nm_per_rad)
                    .sum::<f64>();
        let equal_speed = self
            .equal_speed
            .iter()
            .zip(&states.equal_speed)
            .next()
            .map(|(row, state)| PairSolution::new(row, load.torque_Nm() * share, state));
        Solution {
            status,
            load: *load,
            angles: Some(states.angles(self)),
            deceleration: Some(deceleration),
            equal_speed,
            torsional_stiffness_Nm_per_rad: Some(1.0 / compliance),
        }
    }

    /// Elastic angles at these meshing points.
    pub fn angles(&self, torque_Nm: f64, preload_N: f64) -> (Status, Option<Angles>) {
        let (status, states) = self.solve(torque_Nm, preload_N);
        (status, states.map(|states| states.angles(self)))
    }

    fn solve(&self, torque_Nm: f64, preload_N: f64) -> (Status, Option<DriveStates>) {
        let (mut status, deceleration) = solve_pair(&self.deceleration, torque_Nm, preload_N);
        let mut rows = Vec::with_capacity(self.equal_speed.len());
        for row in &self.equal_speed {
            let (row_status, state) = solve_pair(row, torque_Nm * self.equal_speed_share, preload_N);
            status = status.worse(row_status);
            rows.extend(state);
        }
        match deceleration {
            Some(deceleration) if rows.len() == self.equal_speed.len() => {
                (status, Some(DriveStates { deceleration, equal_speed: rows }))
            }
            _ => (status, None),
        }
    }
}
