//! What of a pair's equations does not depend on the load: made once, solved for many loads.

use std::sync::OnceLock;

use super::lanes::contacts::{ByContact, Contacts, by_contact};
use super::{ContactLaw, Levers};
use crate::pair::MeshingPoints;

/// A pair whose meshing points are known.
#[derive(Debug, Clone)]
pub struct ReadyPair {
    /// Of the diagonals that exist.
    pub(super) levers: Vec<Levers>,
    /// The same side by side, made when first asked for: most pairs never are.
    contacts: OnceLock<Contacts>,
    pub(super) law: ContactLaw,
    pub(super) axial_spring_N_per_m: f64,
    pub(super) largest_torque_per_preload_m: f64,
    pub(super) largest_cot: f64,
    pub(super) largest_arm_m: f64,
    pub(super) ball_radius_m: f64,
    pub(super) floats_sideways: bool,
    /// Torque per preload that is held, to the negative and to the positive side, m.
    holding_arms_m: [f64; 2],
    /// Axial force at an approach of 1 m, N.
    pub(super) axial_force_at_1m_N: f64,
    rows: u32,
}

/// What effects make of the contacts of a pair.
#[derive(Debug, Clone, Copy)]
pub struct Changes<'a> {
    /// Factor on every stiffness.
    pub stiffness_scale: f64,
    /// Exponent of the contact law.
    pub exponent: f64,
    /// Axial spring, N/m.
    pub axial_spring_N_per_m: f64,
    /// Gaps: a value, and zeta, g and p of every diagonal for a value of 1, m.
    pub gaps: &'a [(f64, &'a [[f64; 3]])],
}

impl ReadyPair {
    /// From the meshing points of a pair.
    pub fn new(points: &MeshingPoints) -> Self {
        let torque_per_preload_m = points.torque_per_preload_m();
        let mut pair = Self {
            levers: Vec::with_capacity(points.points.len()),
            contacts: OnceLock::new(),
            law: ContactLaw::new(points.exponent),
            axial_spring_N_per_m: points.axial_spring_N_per_m,
            largest_torque_per_preload_m: largest(
                torque_per_preload_m.iter().map(|[least, largest]| largest.max(-least)),
            ),
            largest_cot: largest(points.points.iter().map(|point| point.cos_beta / point.sin_beta)),
            largest_arm_m: points.largest_arm_m(),
            ball_radius_m: points.ball_radius_m,
            floats_sideways: points.floats_sideways,
            holding_arms_m: points.holding_arms_of_m(&torque_per_preload_m),
            axial_force_at_1m_N: 0.0,
            rows: points.rows,
        };
        for (index, point) in points.points.iter().enumerate() {
            if point.exists() {
                pair.levers.push(Levers::new(index, point));
            }
        }
        pair.weigh();
        pair
    }

    /// The same pair with other contacts.
    #[must_use]
    pub fn changed(&self, changes: &Changes<'_>) -> Self {
        let mut pair = self.clone();
        pair.law = ContactLaw::new(changes.exponent);
        pair.axial_spring_N_per_m = changes.axial_spring_N_per_m;
        for levers in &mut pair.levers {
            levers.stiffness *= changes.stiffness_scale;
            for (value, shape) in changes.gaps {
                levers.add_offset(shape[levers.index].map(|offset| value * offset));
            }
        }
        pair.weigh();
        pair
    }

    /// How many equal copies of this row are in series; their angles add.
    pub fn rows(&self) -> u32 {
        self.rows
    }

    /// Torque that a preload of 1 N can hold in the direction of a torque, m.
    pub fn holding_arm_m(&self, torque_Nm: f64) -> f64 {
        self.holding_arms_m[usize::from(torque_Nm.is_sign_positive())]
    }

    /// Approach of the plates under a preload alone if they could not rotate and no point had an offset, m.
    pub(super) fn rigid_approach_m(&self, preload_N: f64) -> f64 {
        (preload_N / self.axial_force_at_1m_N).powf(1.0 / self.law.exponent)
    }

    /// A number of each diagonal, by the contacts that exist.
    #[must_use]
    pub fn by_contact(&self, number: &[f64]) -> ByContact {
        by_contact(self.levers.iter().map(|levers| number[levers.index]))
    }

    /// What zeta, g and p of every diagonal add to the deformations of its contacts.
    #[must_use]
    pub fn closing(&self, shape: &[[f64; 3]]) -> ByContact {
        by_contact(self.levers.iter().map(|levers| levers.closing(shape[levers.index])))
    }

    pub(super) fn contacts(&self) -> &Contacts {
        self.contacts.get_or_init(|| Contacts::new(&self.levers, self.law))
    }

    fn weigh(&mut self) {
        self.contacts = OnceLock::new();
        let force = |levers: &Levers| self.law.force_N(levers.stiffness, levers.axial) * levers.axial;
        self.axial_force_at_1m_N = self.levers.iter().map(force).sum();
    }
}

/// The largest of what is above 0, else 0.
// Comparisons: `f64::max` asks each time whether its numbers are numbers.
fn largest(values: impl Iterator<Item = f64>) -> f64 {
    values.fold(0.0, |largest, value| if value > largest { value } else { largest })
}
