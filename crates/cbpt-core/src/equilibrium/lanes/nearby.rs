//! A homogeneous pair under one load, from a solution nearby, and how its rotation answers: what [`respond`] says of any pair.
//!
//! All loads of a pair lie on one curve x(A), whatever its stiffness, so a point of it with its slope is a start for any load
//! nearby, from which a pass or two are left. With lambda = 2/3 S^-1 (0, 1, 0) (see `kernel`) and everything scaled,
//! the rotation answers to
//! - the torque by lambda_1, to the preload by lambda_0 - A lambda_1, to a force sideways by lambda_2;
//! - the stiffness by -2/3 x_1, as alpha = (N_Z/k)^(2/3) x_1(A);
//! - the contact angle by -g . lambda (see `alone`).
//!
//! [`respond`]: crate::equilibrium::response::respond

use super::alone::{self, Block, Turn};
use super::kernel::{COLD, along_curve};
use super::powers::two_thirds_power;
use super::{Scale, homogeneous};
use crate::equilibrium::response::{Response, Slopes};
use crate::equilibrium::solve::smallness;
use crate::equilibrium::{Levers, ReadyPair};

/// The contacts of a pair side by side: the same for any stiffness that all share.
#[derive(Debug, Clone, PartialEq)]
pub struct SideBySide {
    blocks: Vec<Block>,
    /// Empty where no answer to the contact angle will be asked for.
    turns: Vec<Turn>,
}

impl SideBySide {
    /// Contacts of a pair, with d ln k / d beta of every diagonal (1/rad) or none of these.
    pub fn new(pair: &ReadyPair, stiffness_slopes_per_rad: &[f64]) -> Self {
        let scale = Scale::of(pair);
        let turn = |levers: &Levers| {
            let [axial, turning_m, in_plane] = levers.per_contact_angle(0.0);
            let turned = [axial, turning_m * scale.per_torque_scale, in_plane / scale.largest_cot];
            (turned, stiffness_slopes_per_rad[levers.index])
        };
        let count = pair.levers.len();
        let turning = if stiffness_slopes_per_rad.is_empty() { 0 } else { count };
        Self {
            blocks: alone::in_blocks(scale.contacts(pair), count),
            turns: alone::turns_in_blocks(pair.levers.iter().take(turning).map(turn), turning),
        }
    }

    /// Ready for loads on the same contacts as a pair now has them; `None` where that is not homogeneous.
    pub fn of<'a>(&'a self, pair: &ReadyPair) -> Option<Homogeneous<'a>> {
        let able = homogeneous(pair) && pair.largest_torque_per_preload_m > 0.0;
        able.then(|| Homogeneous { contacts: self, scale: Scale::of(pair) })
    }
}

/// A homogeneous pair, ready for one load after the other.
#[derive(Debug, Clone)]
pub struct Homogeneous<'a> {
    contacts: &'a SideBySide,
    scale: Scale,
}

/// A solved load's place on the curve of its pair, all scaled.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Place {
    pivot: f64,
    x: [f64; 3],
    /// dx/dA.
    slope: [f64; 3],
}

impl Place {
    /// The unknowns at another pivot, as far as the slope leads.
    fn at(&self, pivot: f64) -> [f64; 3] {
        std::array::from_fn(|i| self.x[i] + self.slope[i] * (pivot - self.pivot))
    }
}

impl Homogeneous<'_> {
    /// Solves the pair under a torque (N m) and preload (N) from a place nearby or from the cold start; answers to torque,
    /// preload and stiffness are always there, that to the contact angle where it is asked for. `None` where the load is not
    /// held or not solved in a few passes: the scalar solver then says what it is.
    pub fn respond(
        &self,
        pair: &ReadyPair,
        [torque_Nm, preload_N]: [f64; 2],
        near: Option<&Place>,
        contact_angle: bool,
    ) -> Option<(Response, Place)> {
        if !Scale::holds(pair, torque_Nm, preload_N) {
            return None;
        }
        let pivot = self.scale.pivot(torque_Nm, preload_N);
        let turns = if contact_angle { self.contacts.turns.as_slice() } else { &[] };
        let from = |start| alone::answer(&self.contacts.blocks, turns, pair.floats_sideways, pivot, start);
        let solved = near.and_then(|place| from(place.at(pivot))).or_else(|| from(COLD))?;

        let approach_m = self.scale.approach_at_1N_m * two_thirds_power(preload_N);
        let state = self.scale.state(&solved.found, approach_m);
        // Rotation for one of its scale, and that for a torque of one of its scale.
        let turn_rad = approach_m * self.scale.per_torque_scale;
        let per_torque = turn_rad * self.scale.per_torque_scale / preload_N;
        let lambda = &solved.compliance;
        let rotation = Slopes {
            torque: lambda[1] * per_torque,
            preload: (lambda[0] - pivot * lambda[1]) * turn_rad / preload_N,
            sideways: lambda[2] * turn_rad / (preload_N * self.scale.largest_cot),
            log_stiffness: -2.0 / 3.0 * state.rotation_rad,
            contact_angle: solved.by_contact_angle * turn_rad,
            ..Slopes::default()
        };
        let response = Response {
            status: smallness(pair, &state),
            state,
            unloaded: None,
            rotation,
            residual: solved.found.residual,
            carrying: solved.carrying,
            parted: pair.levers.len() - solved.carrying,
        };
        let x = solved.found.x;
        Some((response, Place { pivot, x, slope: along_curve(&x, lambda) }))
    }
}
