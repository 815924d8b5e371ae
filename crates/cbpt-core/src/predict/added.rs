//! What own effects, and the torques of the readings before, add to a row ahead of its meshing points.

use crate::effect::dual::Dual;

/// What is added to a row ahead of its meshing points.
#[derive(Debug, Clone, Copy)]
pub struct Added {
    pub torque_Nm: Dual,
    pub preload_N: Dual,
    /// In series, under the row's torque and under none.
    pub series_rad: Dual,
    pub series_at_rest_rad: Dual,
    /// Whether all of it is finite; where not, nothing is added and the row has no solution.
    pub finite: bool,
}

impl Added {
    pub const NOTHING: Self = Self {
        torque_Nm: Dual::constant(0.0),
        preload_N: Dual::constant(0.0),
        series_rad: Dual::constant(0.0),
        series_at_rest_rad: Dual::constant(0.0),
        finite: true,
    };

    /// What is added to a row; a list without entries adds nothing to any.
    pub fn to(row: usize, added: &[Self]) -> &Self {
        added.get(row).unwrap_or(&Self::NOTHING)
    }

    /// The same; nothing where a number is not finite.
    pub fn checked(self) -> Self {
        let all = [self.torque_Nm, self.preload_N, self.series_rad, self.series_at_rest_rad];
        let finite = all.iter().all(|number| number.value.is_finite());
        if finite { self } else { Self { finite, ..Self::NOTHING } }
    }
}
