//! What preload and torque cost in friction: torque at the input, efficiency, wear.
//!
//! - [`kinematics`]: how balls and plates move; [`spin`]: the spin of a ball that dissipates least;
//! - [`row`]: a row of balls under a load; here: the drive at one angle of the crank, [`Drive::friction`];
//! - [`period`]: mean and ripple over a period, the torque that drives it backwards, maps over loads.
//!
//! Coulomb friction acts at every contact under the normal forces of the frictionless equilibrium (first order in mu). The
//! loss of a contact is mu Q (|s| + (3/8) a E(m) |psi|): slip and pivoting added, which is an upper bound, at most about 1.3
//! times the integral over the ellipse (Johnson, Contact Mechanics, 1985, section 8.5; Jung and Lee 1993 for the sum).
//! Parts as made count by their normal forces; the motion is the nominal one. Lubricant, cage, seals and bearings are not in it. Friction torque at the input: the sum of all losses for one radian of
//! the input.

pub mod kinematics;
pub mod period;
pub mod row;
pub mod spin;

use std::f64::consts::TAU;

use crate::drive::{Drive, Load};
use crate::error::{InvalidInput, require};
use crate::geometry::undercut::undercuts;
use crate::status::Status;

pub use row::{ContactFriction, RowFriction};
use row::{PairRows, deceleration_rows, equal_speed_rows};

/// Friction coefficient where none is given.
pub const COEFFICIENT: f64 = 0.1;
/// Relative distance to the proved bound up to which a spin is solved.
pub const LARGEST_GAP: f64 = 1e-8;

/// Friction of a pair at one angle of the crank.
#[derive(Debug, Clone, PartialEq)]
pub struct PairFriction {
    /// Part of the friction torque at the input, N m.
    pub torque_Nm: f64,
    /// Archard's index: sum of Q (|s| + (3/8) a E |psi|) for a turn of the input at this rate, N m.
    pub wear_Nm_per_turn: f64,
    /// Largest such index for a length of track, for a turn of the input: of the grooves of the driving (epicycloid, planet)
    /// plates and of the plates opposite, N (that is N m for each m).
    pub track_wear_N: [f64; 2],
    /// Largest relative distance of a ball's loss from its proved lower bound.
    pub gap: f64,
    /// Every loaded contact, row by row and ball by ball.
    pub contacts: Vec<ContactFriction>,
}

/// Friction of a drive at one angle of the crank.
#[derive(Debug, Clone, PartialEq)]
pub struct DriveFriction {
    /// How it ended; the pairs are there exactly when [`Status::has_solution`].
    pub status: Status,
    /// The load.
    pub load: Load,
    /// Friction coefficient mu.
    pub coefficient: f64,
    /// Transmission ratio i.
    pub transmission_ratio: f64,
    /// The deceleration pair.
    pub deceleration: Option<PairFriction>,
    /// The equal-speed pair, all its rows.
    pub equal_speed: Option<PairFriction>,
}

impl DriveFriction {
    /// Friction torque at the input, N m.
    pub fn torque_Nm(&self) -> Option<f64> {
        Some(self.deceleration.as_ref()?.torque_Nm + self.equal_speed.as_ref()?.torque_Nm)
    }

    /// Archard's index of both pairs for a turn of the input at this rate, N m.
    pub fn wear_Nm_per_turn(&self) -> Option<f64> {
        Some(self.deceleration.as_ref()?.wear_Nm_per_turn + self.equal_speed.as_ref()?.wear_Nm_per_turn)
    }

    /// Power at the output over power at the input; 0 without torque.
    pub fn efficiency(&self) -> Option<f64> {
        self.torque_Nm().map(|friction| efficiency(&self.load, self.transmission_ratio, friction))
    }
}

/// (|M0/i|)/(|M0/i| + T).
pub(crate) fn efficiency(load: &Load, transmission_ratio: f64, friction_Nm: f64) -> f64 {
    let useful = (load.torque_Nm() / transmission_ratio).abs();
    if useful > 0.0 { useful / (useful + friction_Nm) } else { 0.0 }
}

pub(crate) fn check_coefficient(coefficient: f64) -> Result<(), InvalidInput> {
    require(
        (0.0..=10.0).contains(&coefficient),
        "friction.coefficient",
        coefficient,
        "must lie between 0 and 10, 0.05 to 0.15 for lubricated steel",
    )
}

impl Drive {
    /// Friction of every contact under a load, with the coefficient mu.
    ///
    /// ```
    /// use cbpt_core::{Drive, Load};
    ///
    /// let found = Drive::paper_base_case().friction(&Load::new(5.0, 600.0, 0.0)?, 0.1)?;
    /// assert!((found.efficiency().unwrap_or(0.0) - 0.846).abs() < 1e-3);
    /// # Ok::<(), cbpt_core::InvalidInput>(())
    /// ```
    ///
    /// # Errors
    /// [`InvalidInput`] for a coefficient that cannot be.
    pub fn friction(&self, load: &Load, coefficient: f64) -> Result<DriveFriction, InvalidInput> {
        check_coefficient(coefficient)?;
        let none = |status| DriveFriction {
            status,
            load: *load,
            coefficient,
            transmission_ratio: self.transmission_ratio(),
            deceleration: None,
            equal_speed: None,
        };
        if undercuts(self) {
            return Ok(none(Status::Undercut));
        }
        let angle = load.input_angle_rad();
        let pair = |rows: PairRows| pair_friction(&rows, load, coefficient);
        let (first, deceleration) = pair(deceleration_rows(self, angle));
        let (second, equal_speed) = pair(equal_speed_rows(self, angle));
        let status = first.worse(second);
        if !status.has_solution() {
            return Ok(none(status));
        }
        Ok(DriveFriction { deceleration, equal_speed, ..none(status) })
    }
}

fn pair_friction(rows: &PairRows, load: &Load, coefficient: f64) -> (Status, Option<PairFriction>) {
    let (status, found) = rows.at(load.torque_Nm(), load.preload_N(), true);
    let pair = found.map(|row| PairFriction {
        torque_Nm: coefficient * row.loss_Nm,
        wear_Nm_per_turn: TAU * row.loss_Nm,
        track_wear_N: row.track_wear_N,
        gap: row.gap,
        contacts: row.contacts.into_iter().map(|contact| contact.with(coefficient)).collect(),
    });
    (status, pair)
}
