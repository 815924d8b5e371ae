//! The effects of a model along one row, port by port, in dual numbers; those of the user's own are in `own`.

use std::sync::Arc;

use crate::effect::Port;
use crate::effect::dual::Dual;
use crate::effect::own::OwnEffect;
use crate::effect::port::{Action, Contact, DriveNumbers, Load, Row};
use crate::pair::HERTZ_EXPONENT;

use super::added::Added;

/// An effect with numbers, some of them seeded with a partial.
#[derive(Debug, Clone)]
pub struct Link {
    pub port: Port,
    pub action: Action,
    pub own: Vec<Dual>,
}

/// An own effect with its numbers, some of them seeded with a partial.
pub type OwnLink = (Arc<dyn OwnEffect>, Vec<Dual>);

/// Effects that do something, in the order in which they act.
#[derive(Debug, Clone)]
pub struct Chain {
    pub links: Vec<Link>,
    /// Own effects, which act after the library's of their port.
    pub own: Vec<OwnLink>,
    pub drive: DriveNumbers,
}

impl Chain {
    /// The load of a row: the instruments' gains first, then what acts on its way to the meshing points, then what own
    /// effects have added.
    pub fn load(&self, row: &Row, added: &Added) -> Load {
        let mut load = Load {
            torque_Nm: Dual::constant(row.torque_Nm),
            preload_N: Dual::constant(row.preload_N),
            spring_N_per_m: Dual::constant(0.0),
            friction: Vec::new(),
        };
        for gain in [true, false] {
            for link in self.links.iter().filter(|link| (link.port == Port::Reading) == gain) {
                if let Action::Load(act) = link.action {
                    act(&link.own, row, &mut load);
                }
            }
        }
        load.torque_Nm += added.torque_Nm;
        load.preload_N += added.preload_N;
        load
    }

    /// What the contacts of all pairs become.
    pub fn contact(&self) -> Contact {
        let mut contact = Contact {
            stiffness_scale: Dual::constant(1.0),
            contact_angle_shift_rad: Dual::constant(0.0),
            exponent: Dual::constant(HERTZ_EXPONENT),
            play_rad: Dual::constant(0.0),
            transition_torque_Nm: Dual::constant(1.0),
        };
        for link in &self.links {
            if let Action::Contact(act) = link.action {
                act(&link.own, &mut contact);
            }
        }
        contact
    }

    /// The angle behind the meshing points under a torque on the output.
    pub fn series(&self, row: &Row, torque_Nm: Dual) -> Dual {
        let mut angle = Dual::constant(0.0);
        for link in &self.links {
            if let Action::Series(act) = link.action {
                angle += act(&link.own, row, &self.drive, torque_Nm);
            }
        }
        angle
    }

    /// What depends on the torques before adds to the angle behind the meshing points, at each reading of a run.
    pub fn history(&self, run: &[Row], torque_Nm: &[Dual]) -> Vec<Dual> {
        let mut angles = vec![Dual::constant(0.0); run.len()];
        for link in &self.links {
            if let Action::History(act) = link.action {
                for (angle, part) in angles.iter_mut().zip(act(&link.own, run, torque_Nm)) {
                    *angle += part;
                }
            }
        }
        angles
    }

    /// Whether anything depends on the torques before.
    pub fn has_history(&self) -> bool {
        self.links.iter().any(|link| matches!(link.action, Action::History(_)))
    }

    /// What the instrument shows of an angle.
    pub fn reading(&self, row: &Row, mut angle: Dual) -> Dual {
        for link in &self.links {
            if let Action::Reading(act) = link.action {
                angle = act(&link.own, row, angle);
            }
        }
        angle
    }
}
