//! The curve on which all loads of a homogeneous pair lie: scaled unknowns against the scaled pivot A.
//!
//! Cubic Hermite pieces through solved points with their exact slopes, even in t = 1 - sqrt(1 - A/H) with the holding arm
//! H, which spreads out the steep end near the limit. Only a start: two passes of the iteration usually follow.

use super::kernel::{self, Batch, COLD, Contact};
use super::{BATCH, ReadyPair};
use crate::equilibrium::solve::balance;

/// Where in t the curve ends (A/H = 0.9999); beyond, the last piece is continued.
const LAST_T: f64 = 0.99;
/// Pieces of a first curve, whose points are sought from the cold start.
const FIRST_PIECES: usize = 64;
/// More pieces make better starts, up to what the caches hold; and a piece must serve so many loads to be worth it.
const MOST_PIECES: usize = 1024;
const LOADS_PER_PIECE: usize = 16;

/// The curve to one side.
#[derive(Debug)]
pub struct Curve {
    per_holding_arm: f64,
    pieces_per_t: f64,
    floats_sideways: bool,
    /// Coefficients in the place inside a piece (0 to 1), lowest power first, of each unknown.
    pieces: Vec<[[f64; 4]; 3]>,
}

impl Curve {
    /// The curve towards the side of `sign`, worth making for so many loads; `None` where nothing holds there or a point of
    /// it is not found.
    pub fn new(
        pair: &ReadyPair,
        contacts: &[Contact],
        sign: f64,
        torque_scale_m: f64,
        loads: usize,
    ) -> Option<Self> {
        let holding_arm = pair.holding_arm_m(sign) / torque_scale_m;
        if holding_arm <= 0.0 {
            return None;
        }
        let through = |pieces: usize, start: &dyn Fn(f64) -> [f64; 3]| -> Option<Self> {
            let step = LAST_T / pieces as f64;
            let nodes: Vec<f64> = (0..=pieces).map(|node| node as f64 * step).collect();
            let mut points = Vec::with_capacity(nodes.len());
            for some in nodes.chunks(BATCH) {
                let mut batch = Batch::<BATCH>::new();
                for (lane, t) in some.iter().enumerate() {
                    batch.set_pivot(lane, sign * holding_arm * t * (2.0 - t));
                }
                batch.start(some.len(), start);
                kernel::run(contacts, pair.floats_sideways, &mut batch, some.len());
                for (lane, t) in some.iter().enumerate() {
                    let found = batch.found(lane);
                    let by_scalar = || scalar(pair, found.pivot * torque_scale_m);
                    let x = if found.is_solved() { found.x } else { by_scalar()? };
                    let slope = kernel::slope(contacts, pair.floats_sideways, found.pivot, x)?;
                    let per_t = sign * holding_arm * 2.0 * (1.0 - t);
                    points.push((x, slope.map(|value| value * per_t * step)));
                }
            }
            Some(Self {
                per_holding_arm: 1.0 / holding_arm,
                pieces_per_t: 1.0 / step,
                floats_sideways: pair.floats_sideways,
                pieces: points.windows(2).map(|ends| hermite(ends[0], ends[1])).collect(),
            })
        };
        let first = through(FIRST_PIECES, &|_| COLD)?;
        let pieces = (loads / LOADS_PER_PIECE).min(MOST_PIECES);
        if pieces <= FIRST_PIECES { Some(first) } else { through(pieces, &|pivot| first.at(pivot)) }
    }

    /// Scaled unknowns near those at `pivot`.
    // The place is at least 0 and at most the number of pieces.
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    #[inline(always)]
    pub fn at(&self, pivot: f64) -> [f64; 3] {
        let left = (1.0 - pivot.abs() * self.per_holding_arm).max(0.0);
        let place = (1.0 - left.sqrt()) * self.pieces_per_t;
        let piece = (place as usize).min(self.pieces.len() - 1);
        let s = place - piece as f64;
        let cubic = |c: &[f64; 4]| c[0] + s * (c[1] + s * (c[2] + s * c[3]));
        let [approach, rotation, sideways] = &self.pieces[piece];
        [cubic(approach), cubic(rotation), if self.floats_sideways { cubic(sideways) } else { 0.0 }]
    }
}

/// The cubic through two points with their slopes, each per piece.
fn hermite((x0, s0): ([f64; 3], [f64; 3]), (x1, s1): ([f64; 3], [f64; 3])) -> [[f64; 4]; 3] {
    std::array::from_fn(|i| {
        let rise = x1[i] - x0[i];
        [x0[i], s0[i], 3.0 * rise - 2.0 * s0[i] - s1[i], s0[i] + s1[i] - 2.0 * rise]
    })
}

/// A point of the curve by the scalar solver, in the same scale.
fn scalar(pair: &ReadyPair, pivot_m: f64) -> Option<[f64; 3]> {
    if pair.floats_sideways {
        let x = balance::<3>(pair, pivot_m, 1.0, None, None).ok()?.x;
        Some([x[0], x[1], x[2]])
    } else {
        let x = balance::<2>(pair, pivot_m, 1.0, None, None).ok()?.x;
        Some([x[0], x[1], 0.0])
    }
}
