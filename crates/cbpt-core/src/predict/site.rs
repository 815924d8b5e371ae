//! What carries a load at one input angle: the pairs of a ball drive, or a torsion spring in their place; and stops beside it.

use crate::effect::dual::values;
use crate::effect::hard_stop;
use crate::effect::port::{Contact, STOP_NUMBERS};
use crate::status::Status;

use super::mesh::{Mesh, Pairs, Turned, Wanted, Warm};
use super::spring::Spring;

/// What carries a load at one input angle, and the stops beside it.
#[derive(Debug, Clone)]
pub struct Site<'a> {
    carrier: Carrier<'a>,
    stops: Vec<[f64; STOP_NUMBERS]>,
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
    /// A carrier with the stops of these contacts.
    pub fn new(carrier: Carrier<'a>, contact: &Contact) -> Self {
        Self { carrier, stops: contact.stops.iter().map(values).collect() }
    }

    /// What the stops leave to the carrier, N m, and how much of a further torque.
    fn carried(&self, torque_Nm: f64) -> (f64, f64) {
        self.stops.iter().fold((torque_Nm, 1.0), |(torque_Nm, share), own| {
            let (torque_Nm, by_torque, _) = hard_stop::carried(torque_Nm, own);
            (torque_Nm, share * by_torque)
        })
    }

    /// Solves it under a torque (N m) and a preload (N); see [`Pairs::solve`].
    ///
    /// # Errors
    /// The status, where there is no solution.
    pub fn solve(&self, load: [f64; 2], wanted: Option<Wanted>, warm: &mut Warm) -> Result<Mesh, Status> {
        let (torque_Nm, carried_share) = self.carried(load[0]);
        let mut mesh = match &self.carrier {
            Carrier::Pairs(pairs) => pairs.solve([torque_Nm, load[1]], wanted, warm)?,
            Carrier::Spring(spring) => spring.solve(torque_Nm),
        };
        (mesh.with_stops_Nm, mesh.carried_share) = (load[0], carried_share);
        Ok(mesh)
    }

    /// The angle alone, as [`Self::solve`] finds it.
    ///
    /// # Errors
    /// The status, where there is no solution.
    pub fn turned(&self, load: [f64; 2], warm: &mut Warm) -> Result<Turned, Status> {
        let (torque_Nm, carried_share) = self.carried(load[0]);
        let turned = match &self.carrier {
            Carrier::Pairs(pairs) => {
                let mesh = pairs.solve([torque_Nm, load[1]], None, warm)?;
                Turned { angle_rad: mesh.angle_rad, by_torque: mesh.slopes.torque }
            }
            Carrier::Spring(spring) => spring.turned(torque_Nm),
        };
        Ok(Turned { by_torque: turned.by_torque * carried_share, ..turned })
    }
}
