//! Friction makes a run a history. The meshing points carry m = M0 - sum of Tf, each Tf = L z with the limit L and the
//! state z of its law after the way of the total angle A = alpha(m) + series since the reading before. m is the root of
//!
//!   m - M0 + sum L z(A(m)) = 0, which grows with m;
//!
//! a run starts unloaded: M0 = 0, z = 0. Sensitivities follow by the implicit function theorem: with a = dalpha/dm and
//! a dot for a derivative at m held,
//!
//!   dm (1 + a sum L z_A) = dM0 - sum [z dL + L (z_A (dA' - dA_before) + z_before dz_before + z_p dalpha_p)],
//!
//! dA' = dalpha' + dseries.

use crate::effect::dual::Dual;
use crate::effect::port::{Friction, Load};
use crate::status::Status;

use super::mesh::{Mesh, Wanted, Warm};
use super::site::Site;

/// The friction's memory: the total angle of the reading before and the state of each friction.
#[derive(Debug, Clone, Default)]
pub struct Memory<T> {
    /// Total angle of the reading before, rad.
    pub angle_rad: T,
    /// State of each friction.
    pub states: Vec<T>,
}

/// Steps for the torque at the meshing points; bisection alone would need 50, and every other step may be one.
const MOST_STEPS: u32 = 200;
/// Balance of the torques, as a share of them.
const TOLERANCE: f64 = 1e-12;

/// The total angle from the one at the meshing points' torque held; moves the memory on.
pub fn with_torque(at_torque: Dual, per_torque: f64, load: &Load, memory: &mut Memory<Dual>) -> Dual {
    let way = at_torque.value - memory.angle_rad.value;
    let mut torque = load.torque_Nm;
    let mut resistance = 1.0;
    // Each friction: its state now, and its derivatives by the way and by what it was.
    let mut after = Vec::with_capacity(memory.states.len());
    for (before, friction) in memory.states.iter().zip(&load.friction) {
        let angle = friction.engagement_angle_rad;
        let limit = friction.limit_Nm(load);
        let (z, [by_way, by_before, by_angle]) = (friction.law)(before.value, way, angle.value);
        let mut state = Dual::constant(z);
        state.add_slope(by_before, before);
        state.add_slope(by_angle, &angle);
        state.add_slope(-by_way, &memory.angle_rad);
        let mut held = state;
        held.add_slope(by_way, &at_torque);
        torque = torque - limit * held;
        resistance += per_torque * limit.value * by_way;
        after.push((state, by_way));
    }
    let mut total = at_torque;
    total.add_slope(per_torque / resistance, &torque);
    for (state, (mut z, by_way)) in memory.states.iter_mut().zip(after) {
        z.add_slope(by_way, &total);
        *state = z;
    }
    memory.angle_rad = total;
    total
}

/// A row whose meshing points carry what friction leaves of its torque.
pub struct Held<'a> {
    pub site: &'a Site<'a>,
    pub load: &'a Load,
    /// What stands in series, rad.
    pub series_rad: f64,
    pub memory: &'a Memory<f64>,
    pub wanted: Option<Wanted>,
}

impl Held<'_> {
    /// Solves the row by Newton's method for the torque at the meshing points, between bounds, which bisection narrows where
    /// Newton would leave them or does not halve its steps: across a play the balance is a steep step between flat parts, from
    /// one of which Newton jumps to the other. `warm` and `mesh_torque_Nm` are a solution nearby, and become the one found.
    ///
    /// # Errors
    /// The status, where there is no solution.
    pub fn solve(&self, warm: &mut Warm, mesh_torque_Nm: &mut Option<f64>) -> Result<Mesh, Status> {
        let (torque_Nm, preload_N) = (self.load.torque_Nm.value, self.load.preload_N.value);
        let most: f64 = self.load.friction.iter().map(|friction| self.limit_Nm(friction)).sum();
        // Friction before the way.
        let now: f64 = self.frictions().map(|(z, friction)| self.limit_Nm(friction) * z).sum();
        let (mut low, mut high) = (torque_Nm - most, torque_Nm + most);
        let mut m = mesh_torque_Nm.unwrap_or(torque_Nm - now).clamp(low, high);
        let size = torque_Nm.abs() + most;
        let mut step = high - low;
        let mut last = Status::NotConverged { residual: f64::INFINITY };
        for _ in 0..MOST_STEPS {
            let mesh = match self.site.solve([m, preload_N], None, warm) {
                Ok(mesh) => mesh,
                Err(status) => {
                    // Too much to hold: less of it, as far as the friction reaches.
                    last = status;
                    narrow(&mut low, &mut high, m, m > 0.0);
                    m = 0.5 * (low + high);
                    if m <= low || m >= high {
                        return Err(last);
                    }
                    continue;
                }
            };
            let (unbalanced_Nm, slope) = self.unbalanced(m, &mesh);
            // Across a steep step the torque's last digit may be more than the tolerance of the balance.
            if unbalanced_Nm.abs() <= TOLERANCE * size
                || (unbalanced_Nm / slope).abs() <= f64::EPSILON * m.abs()
            {
                *mesh_torque_Nm = Some(m);
                let again = |wanted| self.site.solve([m, preload_N], Some(wanted), warm);
                return self.wanted.map_or(Ok(mesh), again);
            }
            last = Status::NotConverged { residual: unbalanced_Nm.abs() / size };
            narrow(&mut low, &mut high, m, unbalanced_Nm > 0.0);
            let newton = m - unbalanced_Nm / slope;
            let quick = (newton - m).abs() <= 0.5 * step;
            let next = if newton > low && newton < high && quick { newton } else { 0.5 * (low + high) };
            step = (next - m).abs();
            m = next;
        }
        Err(last)
    }

    /// m - M0 + sum L z under a torque m at the meshing points, and its derivative by m.
    fn unbalanced(&self, m: f64, mesh: &Mesh) -> (f64, f64) {
        let way = mesh.angle_rad + self.series_rad - self.memory.angle_rad;
        let (mut unbalanced_Nm, mut slope) = (m - self.load.torque_Nm.value, 1.0);
        for (z, friction) in self.frictions() {
            let (z, [by_way, ..]) = (friction.law)(*z, way, friction.engagement_angle_rad.value);
            unbalanced_Nm += self.limit_Nm(friction) * z;
            slope += self.limit_Nm(friction) * by_way * mesh.slopes.torque;
        }
        (unbalanced_Nm, slope)
    }

    /// The frictions with their states before the way.
    fn frictions(&self) -> impl Iterator<Item = (&f64, &Friction)> {
        self.memory.states.iter().zip(&self.load.friction)
    }

    fn limit_Nm(&self, friction: &Friction) -> f64 {
        friction.limit_Nm(self.load).value.max(0.0)
    }
}

/// Moves the bound to `m` beyond which the root does not lie.
fn narrow(low: &mut f64, high: &mut f64, m: f64, root_is_below: bool) {
    *(if root_is_below { high } else { low }) = m;
}
