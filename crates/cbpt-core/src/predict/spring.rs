//! A torsion spring in place of meshing points: alpha = f(m)/s + sum of j t(m) + sum of h(m), with the curve f, the scale s of
//! `contact_stiffness`, the share t of the play j that each `backlash` takes up, and the h of each `stiffness_curve`.

use crate::effect::dual::values;
use crate::effect::port::{CURVE_NUMBERS, Contact, PLAY_NUMBERS};
use crate::effect::{backlash, stiffness_curve};
use crate::equilibrium::response::Slopes;
use crate::torsion_spring::{TorsionSpring, Twist};

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
        self.with_effects(self.curve.twist(torque_Nm), torque_Nm)
    }

    fn with_effects(&self, twist: Twist, torque_Nm: f64) -> Turned {
        let mut turned = Turned {
            angle_rad: twist.angle_rad / self.scale,
            by_torque: twist.compliance_rad_per_Nm / self.scale,
        };
        let plays = self.plays.iter().map(|own| backlash::turned(own, torque_Nm));
        let curves = self.curves.iter().map(|own| stiffness_curve::turned(own, torque_Nm));
        for [angle_rad, by_torque] in plays.chain(curves) {
            turned.angle_rad += angle_rad;
            turned.by_torque += by_torque;
        }
        turned
    }

    /// The spring under the torque that it carries.
    pub fn solve(&self, torque_Nm: f64) -> Mesh {
        let twist = self.curve.twist(torque_Nm);
        let Turned { angle_rad, by_torque } = self.with_effects(twist, torque_Nm);
        Mesh {
            status: twist.status,
            angle_rad,
            parts_rad: [angle_rad, 0.0],
            residual: 0.0,
            slopes: Slopes {
                torque: by_torque,
                log_stiffness: -twist.angle_rad / self.scale,
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
