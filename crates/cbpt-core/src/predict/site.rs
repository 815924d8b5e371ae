//! What carries a load at one input angle: the pairs of a ball drive, or a torsion spring in their place; and a stop beside it.

use crate::effect::hard_stop;
use crate::effect::port::Contact;
use crate::status::Status;

use super::mesh::{Mesh, Pairs, Turned, Wanted, Warm};
use super::spring::Spring;

/// What carries a load at one input angle, and the stop beside it.
#[derive(Debug, Clone)]
pub struct Site<'a> {
    carrier: Carrier<'a>,
    /// Share of the stop, and the torque at which it is reached, N m.
    stop: [f64; 2],
}

/// What carries a load.
#[derive(Debug, Clone)]
pub enum Carrier<'a> {
    /// The pairs of a ball drive.
    Pairs(Pairs<'a>),
    /// A torsion spring, the same at every angle.
    Spring(Spring<'a>),
}

impl<'a> Site<'a> {
    /// A carrier with the stop of these contacts.
    pub fn new(carrier: Carrier<'a>, contact: &Contact) -> Self {
        Self { carrier, stop: [contact.stop_share.value, contact.stop_torque_Nm.value] }
    }

    /// Solves it under a torque (N m) and a preload (N); see [`Pairs::solve`].
    ///
    /// # Errors
    /// The status, where there is no solution.
    pub fn solve(&self, load: [f64; 2], wanted: Option<Wanted>, warm: &mut Warm) -> Result<Mesh, Status> {
        let [share, stop_Nm] = self.stop;
        let (torque_Nm, [by_torque, by_share, by_stop]) = hard_stop::carried(load[0], share, stop_Nm);
        let mut mesh = match &self.carrier {
            Carrier::Pairs(pairs) => pairs.solve([torque_Nm, load[1]], wanted, warm)?,
            Carrier::Spring(spring) => spring.solve(torque_Nm),
        };
        mesh.stop = [mesh.slopes.torque * by_share, mesh.slopes.torque * by_stop];
        mesh.slopes.torque *= by_torque;
        Ok(mesh)
    }

    /// The angle alone, as [`Self::solve`] finds it.
    ///
    /// # Errors
    /// The status, where there is no solution.
    pub fn turned(&self, load: [f64; 2], warm: &mut Warm) -> Result<Turned, Status> {
        let [share, stop_Nm] = self.stop;
        let (torque_Nm, [by_torque, ..]) = hard_stop::carried(load[0], share, stop_Nm);
        let turned = match &self.carrier {
            Carrier::Pairs(pairs) => {
                let mesh = pairs.solve([torque_Nm, load[1]], None, warm)?;
                Turned { angle_rad: mesh.angle_rad, by_torque: mesh.slopes.torque }
            }
            Carrier::Spring(spring) => spring.turned(torque_Nm),
        };
        Ok(Turned { by_torque: turned.by_torque * by_torque, ..turned })
    }
}
