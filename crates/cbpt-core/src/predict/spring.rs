//! A torsion spring in place of meshing points: alpha = f(m/s) + sum of h(m/s) + sum of j t(m), with the curve f, the h of each
//! `stiffness_curve`, the scale s of `contact_stiffness`, and the share t of the play j that each `backlash` takes up.
//!
//! As with contacts, whatever makes the curve: s times the torque at the same angle, which is what another modulus does.

use crate::effect::dual::values;
use crate::effect::port::{CURVE_NUMBERS, Contact, PLAY_NUMBERS};
use crate::effect::{backlash, stiffness_curve};
use crate::equilibrium::response::Slopes;
use crate::status::Status;
use crate::torsion_spring::TorsionSpring;

use super::mesh::{Mesh, Turned};

/// The spring as effects make it.
#[derive(Debug, Clone)]
pub struct Spring<'a> {
    curve: &'a TorsionSpring,
    scale: f64,
    plays: Vec<[f64; PLAY_NUMBERS]>,
    curves: Vec<[f64; CURVE_NUMBERS]>,
}

impl<'a> Spring<'a> {
    /// Applies the values of scale, plays and curves.
    pub fn new(curve: &'a TorsionSpring, contact: &Contact) -> Self {
        Self {
            curve,
            scale: contact.stiffness_scale.value,
            plays: contact.plays.iter().map(values).collect(),
            curves: contact.curves.iter().map(values).collect(),
        }
    }

    /// How far it turns under the torque that it carries.
    pub fn turned(&self, torque_Nm: f64) -> Turned {
        self.with_plays(self.elastic(torque_Nm).0, torque_Nm)
    }

    /// Without plays, and whether its curve says so.
    fn elastic(&self, torque_Nm: f64) -> (Turned, Status) {
        let at_Nm = torque_Nm / self.scale;
        let twist = self.curve.twist(at_Nm);
        let (mut angle_rad, mut compliance) = (twist.angle_rad, twist.compliance_rad_per_Nm);
        for own in &self.curves {
            let [further, by_torque] = stiffness_curve::turned(own, at_Nm);
            angle_rad += further;
            compliance += by_torque;
        }
        (Turned { angle_rad, by_torque: compliance / self.scale }, twist.status)
    }

    fn with_plays(&self, elastic: Turned, torque_Nm: f64) -> Turned {
        let mut turned = elastic;
        for own in &self.plays {
            let [angle_rad, by_torque] = backlash::turned(own, torque_Nm);
            turned.angle_rad += angle_rad;
            turned.by_torque += by_torque;
        }
        turned
    }

    /// The spring under the torque that it carries.
    pub fn solve(&self, torque_Nm: f64) -> Mesh {
        let (elastic, status) = self.elastic(torque_Nm);
        let Turned { angle_rad, by_torque } = self.with_plays(elastic, torque_Nm);
        Mesh {
            status,
            angle_rad,
            parts_rad: [angle_rad, 0.0],
            residual: 0.0,
            slopes: Slopes {
                torque: by_torque,
                log_stiffness: -torque_Nm * elastic.by_torque,
                ..Slopes::default()
            },
            torque_Nm,
            with_stops_Nm: torque_Nm,
            carried_share: 1.0,
            carrying: [0; 2],
            regime: None,
        }
    }
}
