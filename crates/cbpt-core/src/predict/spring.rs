//! A torsion spring in place of meshing points: alpha = f(m)/s + j t(m) + h(m), with the curve f, the scale s of
//! `contact_stiffness`, the share t of the play j that `backlash` takes up, and the h of `stiffness_curve`, each with its
//! slopes in closed form.

use crate::effect::backlash::taken_up;
use crate::effect::port::Contact;
use crate::effect::stiffness_curve;
use crate::equilibrium::response::Slopes;
use crate::torsion_spring::TorsionSpring;

use super::mesh::Mesh;

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

    /// The spring under the torque that it carries.
    pub fn solve(&self, torque_Nm: f64) -> Mesh {
        let twist = self.curve.twist(torque_Nm);
        let (share, [by_torque, by_transition]) = taken_up(torque_Nm, self.transition_Nm);
        let elastic_rad = twist.angle_rad / self.scale;
        let (parts, slopes) = stiffness_curve::parts(torque_Nm, self.reference_Nm);
        let sum = |of: [f64; 3]| self.curve_rad.iter().zip(of).map(|(size, one)| size * one).sum::<f64>();
        let by_curve = sum(slopes);
        let [first, second] = self.break_Nm.map(|at| stiffness_curve::up_to(torque_Nm, at));
        let [c1, c2] = self.added_rad_per_Nm;
        let angle_rad =
            elastic_rad + self.play_rad * share + sum(parts) + c1 * first.carried + c2 * second.carried;
        let [squared, cubed, skewed] = parts;
        Mesh {
            status: twist.status,
            angle_rad,
            parts_rad: [angle_rad, 0.0],
            residual: 0.0,
            slopes: Slopes {
                torque: twist.compliance_rad_per_Nm / self.scale
                    + self.play_rad * by_torque
                    + by_curve
                    + c1 * first.by_torque
                    + c2 * second.by_torque,
                log_stiffness: -elastic_rad,
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
