//! A torsion spring in place of meshing points: alpha = f(m)/s + j t(m) + h(m), with the curve f, the scale s of
//! `contact_stiffness`, the share t of the play j that `backlash` takes up, and the h of `stiffness_curve`, each with its
//! slopes in closed form.

use crate::effect::backlash::taken_up;
use crate::effect::port::Contact;
use crate::effect::stiffness_curve::{self, UpTo};
use crate::equilibrium::response::Slopes;
use crate::torsion_spring::{TorsionSpring, Twist};

use super::mesh::{Mesh, Turned};

/// What adds up to the angle under one torque.
struct Parts {
    twist: Twist,
    taken_up: (f64, [f64; 2]),
    curve: ([f64; 3], [f64; 3]),
    pieces: [UpTo; 2],
}

impl Parts {
    fn turned(&self, spring: &Spring<'_>) -> Turned {
        let Self { twist, taken_up: (share, [by_torque, _]), curve, pieces: [first, second] } = self;
        let [c1, c2] = spring.added_rad_per_Nm;
        Turned {
            angle_rad: twist.angle_rad / spring.scale
                + spring.play_rad * share
                + spring.of_curve(curve.0)
                + c1 * first.carried
                + c2 * second.carried,
            by_torque: twist.compliance_rad_per_Nm / spring.scale
                + spring.play_rad * by_torque
                + spring.of_curve(curve.1)
                + c1 * first.by_torque
                + c2 * second.by_torque,
        }
    }
}

/// The spring as effects make it.
#[derive(Debug, Clone)]
pub struct Spring<'a> {
    curve: &'a TorsionSpring,
    scale: f64,
    play_rad: f64,
    transition_Nm: f64,
    curve_rad: [f64; 3],
    reference_Nm: f64,
    added_rad_per_Nm: [f64; 2],
    break_Nm: [f64; 2],
}

impl<'a> Spring<'a> {
    /// Applies the values of scale, play and curve.
    pub fn new(curve: &'a TorsionSpring, contact: &Contact) -> Self {
        Self {
            curve,
            scale: contact.stiffness_scale.value,
            play_rad: contact.play_rad.value,
            transition_Nm: contact.transition_torque_Nm.value,
            curve_rad: contact.curve_rad.map(|part| part.value),
            reference_Nm: contact.reference_torque_Nm.value,
            added_rad_per_Nm: contact.added_compliance_rad_per_Nm.map(|added| added.value),
            break_Nm: contact.break_torque_Nm.map(|at| at.value),
        }
    }

    /// The parts of the curve by their sizes.
    fn of_curve(&self, parts: [f64; 3]) -> f64 {
        self.curve_rad.iter().zip(parts).map(|(size, one)| size * one).sum()
    }

    /// How far it turns under the torque that it carries.
    pub fn turned(&self, torque_Nm: f64) -> Turned {
        self.parts(torque_Nm).turned(self)
    }

    fn parts(&self, torque_Nm: f64) -> Parts {
        Parts {
            twist: self.curve.twist(torque_Nm),
            taken_up: taken_up(torque_Nm, self.transition_Nm),
            curve: stiffness_curve::parts(torque_Nm, self.reference_Nm),
            pieces: self.break_Nm.map(|at| stiffness_curve::up_to(torque_Nm, at)),
        }
    }

    /// The spring under the torque that it carries.
    pub fn solve(&self, torque_Nm: f64) -> Mesh {
        let parts = self.parts(torque_Nm);
        let Turned { angle_rad, by_torque } = parts.turned(self);
        let Parts { twist, taken_up: (share, [_, by_transition]), curve, pieces: [first, second] } = parts;
        let [squared, cubed, skewed] = curve.0;
        let by_curve = self.of_curve(curve.1);
        let [c1, c2] = self.added_rad_per_Nm;
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
            spring: [
                share,
                self.play_rad * by_transition,
                squared,
                cubed,
                skewed,
                -by_curve * torque_Nm / self.reference_Nm,
                first.carried,
                second.carried,
                c1 * first.by_break,
                c2 * second.by_break,
            ],
            torque_Nm,
            stop: [0.0; 2],
            carrying: [0; 2],
            regime: None,
        }
    }
}
