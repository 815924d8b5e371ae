//! Where the elastic angle of a drive lies for certain: the proofs of its pairs, added up.

use crate::drive::{Drive, Load};
use crate::equilibrium::proof::enclose_pair;
use crate::geometry::undercut::undercuts;
use crate::interval::Interval;
use crate::transmission::DrivePoints;

/// Intervals in which a drive's equations have their only solution.
///
/// The proof is about the equations at the given meshing points, whose numbers (arms, contact angles, stiffnesses) it takes as
/// exact; they themselves are rounded in the last digits.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Enclosure {
    /// Elastic angle of the drive at its output, rad.
    pub elastic_angle_rad: Interval,
    /// Part of the deceleration pair, rad.
    pub deceleration_rad: Interval,
    /// Part of the equal-speed pair that reaches the output, rad.
    pub equal_speed_rad: Interval,
}

impl DrivePoints {
    /// Proves the solution at these meshing points, torque (N m) and preload (N); `None` where there is none or the proof
    /// does not succeed.
    pub fn enclosure(&self, torque_Nm: f64, preload_N: f64) -> Option<Enclosure> {
        let (torque, share) = (Interval::from(torque_Nm), Interval::from(self.equal_speed_share));
        let deceleration_rad = enclose_pair(&self.deceleration, torque, preload_N)?.rotation_rad;
        let mut rotation = Interval::ZERO;
        for row in &self.equal_speed {
            let of_row = enclose_pair(row, torque * share, preload_N)?.rotation_rad;
            rotation = rotation + Interval::from(f64::from(row.rows)) * of_row;
        }
        let equal_speed_rad = share * rotation;
        let elastic_angle_rad = deceleration_rad + equal_speed_rad;
        let found = Enclosure { elastic_angle_rad, deceleration_rad, equal_speed_rad };
        elastic_angle_rad.is_finite().then_some(found)
    }
}

impl Drive {
    /// Proves the solution under a load: intervals in which its only solution lies; `None` where there is no solution, or
    /// where the proof does not succeed.
    ///
    /// ```
    /// use cbpt_core::{Drive, Load};
    ///
    /// let (drive, load) = (Drive::paper_base_case(), Load::new(5.0, 600.0, 0.0)?);
    /// let angle = drive.enclosure(&load).unwrap().elastic_angle_rad;
    /// assert!(angle.contains(drive.solve(&load).elastic_angle_rad().unwrap()));
    /// assert!(angle.width() < 1e-13 * angle.magnitude());
    /// # Ok::<(), cbpt_core::InvalidInput>(())
    /// ```
    pub fn enclosure(&self, load: &Load) -> Option<Enclosure> {
        if undercuts(self) {
            return None;
        }
        self.points(load.input_angle_rad()).enclosure(load.torque_Nm(), load.preload_N())
    }
}
