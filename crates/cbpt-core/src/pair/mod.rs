//! From a pair of grooved plates to its meshing points.
//!
//! - [`deceleration`], [`ring_groove`], [`cross_slide`]: geometry and contact of each kind of pair at one phase;
//! - [`offsets`]: what the parts as made shift;
//! - here: what they all make, [`MeshingPoints`].
//!
//! Every ball touches four walls. A wall of one plate and the opposite wall of the other squeeze the ball along one
//! line, a *diagonal*: two contacts in series that carry the same force. Each ball has two, `Plus` and `Minus`. The
//! deformation of a diagonal is a linear function of the pair's unknowns, approach d, rotation alpha and, where the
//! plate may shift sideways, t:
//!
//! delta = (d + zeta) sin(beta) + g +- (a alpha + p + t) cos(beta), N = k max(delta, 0)^1.5.
//!
//! zeta, g, p and a law other than the 1.5th power are where effects act (tilt, ball size, groove pitch, roughness);
//! they are neutral by default.

pub mod cross_slide;
pub mod deceleration;
pub mod offsets;
pub mod ring_groove;

use crate::drive::{GrooveSection, TrackCurvature};
use crate::geometry::wall;
use crate::hertz::{HertzContact, in_series};

/// Hertz's exponent of a point contact.
pub const HERTZ_EXPONENT: f64 = 1.5;

/// Deformation at which a law with another exponent keeps Hertz's force: N = k delta_0^1.5 (delta/delta_0)^n.
pub const REFERENCE_DEFORMATION_M: f64 = 1e-6;

/// Which of a ball's two diagonals: a positive rotation squeezes `Plus` where the arm is positive.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Diagonal {
    /// delta grows with + a alpha.
    Plus,
    /// delta grows with - a alpha.
    Minus,
}

impl Diagonal {
    /// +1 or -1.
    pub fn sign(self) -> f64 {
        match self {
            Self::Plus => 1.0,
            Self::Minus => -1.0,
        }
    }
}

/// One diagonal of one ball: the two meshing points at its ends and the place where they act.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MeshingPoint {
    /// Number of the ball, from 0.
    pub ball: usize,
    /// Which diagonal of the ball.
    pub diagonal: Diagonal,
    /// Signed arm a about the centre of the output plate, m.
    pub arm_m: f64,
    /// Sine of the contact angle of this diagonal.
    pub sin_beta: f64,
    /// Cosine of the contact angle of this diagonal.
    pub cos_beta: f64,
    /// Stiffness k of the diagonal (two contacts in series), N/m^1.5; 0 where a wall is missing.
    pub stiffness: f64,
    /// The contacts at the two ends, first the wall of the driving (epicycloid, planet) plate; `None`: wall missing.
    pub walls: [Option<HertzContact>; 2],
    /// Curvature of the track as each of the walls sees it, 1/m.
    pub track_curvatures_per_m: [f64; 2],
    /// Unit vector in which the output plate pushes the ball along its plus diagonal: along and across the line of
    /// centres. The minus diagonal is pushed the other way.
    pub direction: [f64; 2],
    /// Axial gap closed at this ball beyond the approach (tilt): zeta, m.
    pub axial_offset_m: f64,
    /// Interference along the normal (ball size): g, m.
    pub normal_offset_m: f64,
    /// Shift in the plane of the plates (groove pitch): p, m.
    pub in_plane_offset_m: f64,
}

impl MeshingPoint {
    /// A meshing point without offsets. Its walls are missing until [`Self::with_walls`] adds them.
    pub fn new(
        ball: usize,
        diagonal: Diagonal,
        arm_m: f64,
        [sin_beta, cos_beta]: [f64; 2],
        track_curvatures_per_m: [f64; 2],
        direction: [f64; 2],
    ) -> Self {
        Self {
            ball,
            diagonal,
            arm_m,
            sin_beta,
            cos_beta,
            stiffness: 0.0,
            walls: [None; 2],
            track_curvatures_per_m,
            direction,
            axial_offset_m: 0.0,
            normal_offset_m: 0.0,
            in_plane_offset_m: 0.0,
        }
    }

    /// The point with the contacts at its two ends; its stiffness is that of both in series.
    #[must_use]
    pub fn with_walls(mut self, walls: [Option<HertzContact>; 2]) -> Self {
        self.set_walls(walls);
        self
    }

    /// Puts the contacts at its two ends, which make its stiffness.
    pub(crate) fn set_walls(&mut self, walls: [Option<HertzContact>; 2]) {
        self.stiffness = in_series(walls);
        self.walls = walls;
    }

    /// Whether the ball and its grooves are nominal here.
    // Neutral values are set, never computed.
    #[allow(clippy::float_cmp)]
    pub fn has_no_offset(&self) -> bool {
        [self.axial_offset_m, self.normal_offset_m, self.in_plane_offset_m] == [0.0; 3]
    }

    /// Whether both walls exist.
    pub fn exists(&self) -> bool {
        self.stiffness > 0.0
    }

    /// d ln k / d beta of the diagonal, 1/rad; 0 where it does not exist.
    ///
    /// Its compliances k^(-2/3) add, so each contact's own slope counts with its share of them.
    pub fn stiffness_slope_per_rad(&self, groove: &GrooveSection, track: TrackCurvature) -> f64 {
        let contact_angle_rad = self.sin_beta.atan2(self.cos_beta);
        let (mut compliance, mut slope) = (0.0, 0.0);
        for (wall, curvature) in self.walls.iter().zip(self.track_curvatures_per_m) {
            let Some(contact) = wall else { return 0.0 };
            let share = contact.compliance;
            compliance += share;
            slope +=
                share * wall::stiffness_slope_per_rad(groove, curvature, contact_angle_rad, contact, track);
        }
        slope / compliance
    }

    /// Arm with the sign of the diagonal, m: above 0 where a positive rotation squeezes.
    pub fn signed_arm_m(&self) -> f64 {
        self.diagonal.sign() * self.arm_m
    }

    /// Torque held per newton of preload by this point alone: signed arm times cot(beta), m.
    pub fn torque_per_preload_m(&self) -> f64 {
        self.signed_arm_m() * self.cos_beta / self.sin_beta
    }
}

/// All meshing points of a pair at one phase, and what its plates may do.
#[derive(Debug, Clone, PartialEq)]
pub struct MeshingPoints {
    /// The diagonals, ball by ball, plus before minus.
    pub points: Vec<MeshingPoint>,
    /// Exponent n of the contact law, 1.5 by Hertz.
    pub exponent: f64,
    /// Stiffness of what holds the preload: the preload that reaches the points is N_Z - k_c (d - d0), N/m.
    pub axial_spring_N_per_m: f64,
    /// Whether a plate is held across its grooves by the balls alone, so that it shifts until it is in balance.
    pub floats_sideways: bool,
    /// How many equal copies of this row are in series; their angles add.
    pub rows: u32,
    /// Ball radius, m: the scale of what "small displacement" means.
    pub ball_radius_m: f64,
}

impl MeshingPoints {
    /// Points of a pair by Hertz's law with a constant preload.
    pub fn new(points: Vec<MeshingPoint>, ball_radius_m: f64) -> Self {
        Self {
            points,
            exponent: HERTZ_EXPONENT,
            axial_spring_N_per_m: 0.0,
            floats_sideways: false,
            rows: 1,
            ball_radius_m,
        }
    }

    /// Largest distance of a meshing point's normal from the axis, m.
    pub fn largest_arm_m(&self) -> f64 {
        self.points.iter().map(|point| point.arm_m.abs()).fold(0.0, f64::max)
    }

    /// Torque that a preload of 1 N can hold in the direction of `torque_sign`, m; 0 where nothing holds.
    pub fn holding_arm_m(&self, torque_sign: f64) -> f64 {
        self.holding_arms_m()[usize::from(torque_sign.is_sign_positive())]
    }

    /// The same to the negative and to the positive side.
    pub fn holding_arms_m(&self) -> [f64; 2] {
        self.holding_arms_of_m(&self.torque_per_preload_m())
    }

    /// The same of what [`MeshingPoints::torque_per_preload_m`] found.
    ///
    /// One contact carries all: max of the signed arm times cot(beta) over the existing points. A plate that floats
    /// sideways must also balance across its grooves, so a plus and a minus point share the load half and half.
    pub(crate) fn holding_arms_of_m(&self, [plus, minus]: &[[f64; 2]; 2]) -> [f64; 2] {
        [(-plus[0], -minus[0]), (plus[1], minus[1])].map(|(plus, minus)| {
            let arm = if self.floats_sideways { 0.5 * (plus + minus) } else { plus.max(minus) };
            arm.max(0.0)
        })
    }

    /// Least and largest torque per preload of the existing plus, then of the existing minus diagonals, m.
    // Comparisons: `f64::min` asks each time whether its numbers are numbers.
    pub(crate) fn torque_per_preload_m(&self) -> [[f64; 2]; 2] {
        let (mut plus, mut minus) = ([f64::INFINITY, f64::NEG_INFINITY], [f64::INFINITY, f64::NEG_INFINITY]);
        for point in self.points.iter().filter(|point| point.exists()) {
            let held = point.torque_per_preload_m();
            let [least, largest] = match point.diagonal {
                Diagonal::Plus => &mut plus,
                Diagonal::Minus => &mut minus,
            };
            if held < *least {
                *least = held;
            }
            if held > *largest {
                *largest = held;
            }
        }
        [plus, minus]
    }
}
