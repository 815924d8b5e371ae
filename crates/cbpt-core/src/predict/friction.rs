//! Friction makes a run a history. The meshing points carry m = M0 - sum of Tf, each Tf = L z with the limit L and the
//! state z of its law after the way of the total angle A = alpha(m) + series since the reading before. m is the root of
//!
//!   m - M0 + sum L z(A(m)) = 0, which grows with m;
//!
//! a run starts unloaded, M0 = 0, z = 0, unless it goes on from the one before it (`rows`). Sensitivities follow by the
//! implicit function theorem: with a = dalpha/dm and a dot for a derivative at m held,
//!
//!   dm (1 + a sum L z_A) = dM0 - sum [z dL + L (z_A (dA' - dA_before) + z_before dz_before + z_p dp)],
//!
//! dA' = dalpha' + dseries.
//!
//! Where a part H z of the friction helps the rotation on (`breakaway_friction`), the balance P(m) - H z(A(m)) = 0, P being the
//! sum above of all others, may have several roots. The torque changes one way from reading to reading, slowly, and the
//! rotation follows it: it reaches the first root on its way from where it was, and jumps there where roots meet and vanish. From
//! the help at rest on the steps P(`m_{n + 1}`) = H z(A(`m_n`)) go that way and never past that root, as both sides grow with m.
//! They crawl by a place that is almost a root; what is not reached in [`MOST_SLIPS`] of them has no solution. Newton's method
//! ends the search within a way over which no friction changes much ([`STRAIGHT`]).

use crate::effect::dual::Dual;
use crate::effect::port::{Friction, Load};
use crate::status::Status;

use super::mesh::{Mesh, Turned, Wanted, Warm};
use super::site::Site;

/// Steps for the torque at the meshing points; bisection alone would need 50, and every other step may be one.
const MOST_STEPS: u32 = 200;
/// Balance of the torques, as a share of them.
const TOLERANCE: f64 = 1e-12;
/// Steps to the first root where a part of the friction helps.
const MOST_SLIPS: u32 = 5000;
/// Share of the shortest engagement angle over which friction is straight enough for Newton's method.
const STRAIGHT: f64 = 0.02;

/// The friction's memory.
#[derive(Debug, Clone, Default)]
pub struct Memory {
    /// Total angle of the reading before, rad.
    angle_rad: Dual,
    /// State of each friction.
    states: Vec<Dual>,
    /// The derivative of each by the way since the reading before, 1/rad.
    by_way: Vec<f64>,
}

impl Memory {
    /// At an angle (rad), and so many frictions at rest.
    pub fn begin(&mut self, angle_rad: Dual, frictions: usize) {
        self.angle_rad = angle_rad;
        self.states = vec![Dual::constant(0.0); frictions];
    }

    /// The total angle from the one at the meshing points' torque held; moves on to it.
    pub fn after(&mut self, at_torque: Dual, per_torque: f64, torque_Nm: Dual, rubs: &Rubs) -> Dual {
        let way = at_torque.value - self.angle_rad.value;
        let mut torque = torque_Nm;
        let mut per_way = 0.0;
        // The states without what the way adds to their derivatives.
        self.by_way.clear();
        for ((state, friction), limit) in self.states.iter_mut().zip(&rubs.friction).zip(&rubs.limits_Nm) {
            let (z, [by_way, by_before, by_angle, by_exponent]) = friction.after(state.value, way);
            if z.abs() >= 1.0 && by_before == 0.0 {
                // It slips: of all that came before nothing is left, but for the last digits of a law that nears its limit for ever.
                *state = Dual::constant(z);
                torque.value -= limit.value * z;
                torque.add_slope(-z, limit);
                self.by_way.push(0.0);
                continue;
            }
            *state = state.chain(z, by_before);
            state.add_slope(by_angle, &friction.engagement_angle_rad);
            state.add_slope(by_exponent, &friction.exponent);
            state.add_slope(-by_way, &self.angle_rad);
            torque.add_product(-1.0, limit, state);
            per_way += limit.value * by_way;
            self.by_way.push(by_way);
        }
        torque.add_slope(-per_way, &at_torque);
        let mut total = at_torque;
        total.add_slope(per_torque / (1.0 + per_torque * per_way), &torque);
        for (state, by_way) in self.states.iter_mut().zip(&self.by_way).filter(|(_, by_way)| **by_way != 0.0)
        {
            state.add_slope(*by_way, &total);
        }
        self.angle_rad = total;
        total
    }
}

/// What rubs at a row.
#[derive(Debug, Clone, Default)]
pub struct Rubs {
    /// Those that are alike at every row first.
    friction: Vec<Friction>,
    /// The largest torques of these where they are one under every load, N m.
    lasting_Nm: Vec<Option<Dual>>,
    /// The largest torque of each under the load of the row, N m.
    limits_Nm: Vec<Dual>,
}

impl Rubs {
    /// What rubs at every row alike.
    pub fn lasting(friction: Vec<Friction>) -> Self {
        let lasting_Nm: Vec<_> = friction.iter().map(Friction::lasting_limit_Nm).collect();
        let limits_Nm = lasting_Nm.iter().map(|limit| limit.unwrap_or_default()).collect();
        Self { friction, lasting_Nm, limits_Nm }
    }

    /// Goes to a row with its load.
    pub fn under(&mut self, load: &Load) {
        self.friction.truncate(self.lasting_Nm.len());
        self.friction.extend_from_slice(&load.friction);
        self.limits_Nm.resize(self.friction.len(), Dual::default());
        for (i, (limit, friction)) in self.limits_Nm.iter_mut().zip(&self.friction).enumerate() {
            if self.lasting_Nm.get(i).is_none_or(Option::is_none) {
                *limit = friction.limit_Nm(load);
            }
        }
    }

    /// How many frictions there are.
    pub fn count(&self) -> usize {
        self.friction.len()
    }
}

/// A row whose meshing points carry what friction leaves of its torque.
pub struct Held<'a> {
    pub site: &'a Site<'a>,
    pub load: &'a Load,
    /// Under that load.
    pub rubs: &'a Rubs,
    /// What stands in series, rad.
    pub series_rad: f64,
    pub memory: &'a Memory,
    pub wanted: Option<Wanted>,
}

impl Held<'_> {
    /// Solves the row. `warm` and `mesh_torque_Nm` are a solution nearby, and become the one found.
    ///
    /// # Errors
    /// The status, where there is no solution.
    pub fn solve(&self, warm: &mut Warm, mesh_torque_Nm: &mut Option<f64>) -> Result<Mesh, Status> {
        let helped = self.frictions(true).any(|(_, limit_Nm, _)| limit_Nm != 0.0);
        let m = if helped {
            self.first_reached(warm, mesh_torque_Nm)?
        } else {
            self.balanced(0.0, warm, mesh_torque_Nm)?.0
        };
        self.site.solve([m, self.load.preload_N.value], self.wanted, warm)
    }

    /// The first root on the way, where a part of the friction helps.
    fn first_reached(&self, warm: &mut Warm, mesh_torque_Nm: &mut Option<f64>) -> Result<f64, Status> {
        let size = self.load.torque_Nm.value.abs() + self.most_Nm(false) + self.most_Nm(true);
        let straight_rad = STRAIGHT * self.shortest_rad();
        let mut help_Nm = self.helps(0.0)[0];
        let mut left_Nm = f64::INFINITY;
        for _ in 0..MOST_SLIPS {
            let (m, turned) = self.balanced(help_Nm, warm, mesh_torque_Nm)?;
            let [there_Nm, by_way] = self.helps(self.way_rad(turned));
            left_Nm = there_Nm - help_Nm;
            if left_Nm.abs() <= TOLERANCE * size {
                return Ok(m);
            }
            // What the rotation turns for each newton metre of help, and the help that this brings in its turn.
            let rad_per_Nm = turned.by_torque / self.unbalanced(m, turned, help_Nm).1;
            let again = by_way * rad_per_Nm;
            let newton = left_Nm / (1.0 - again);
            let near = again < 1.0 && (newton * rad_per_Nm).abs() <= straight_rad;
            help_Nm += if near { newton } else { left_Nm };
        }
        Err(Status::NotConverged { residual: left_Nm.abs() / size })
    }

    /// The one root where parts that help do so by a given torque, by Newton's method for the torque at the meshing points,
    /// between bounds, which bisection narrows where Newton would leave them or does not halve its steps: across a play the
    /// balance is a steep step between flat parts, from one of which Newton jumps to the other.
    fn balanced(
        &self,
        help_Nm: f64,
        warm: &mut Warm,
        mesh_torque_Nm: &mut Option<f64>,
    ) -> Result<(f64, Turned), Status> {
        let (torque_Nm, preload_N) = (self.load.torque_Nm.value + help_Nm, self.load.preload_N.value);
        let most = self.most_Nm(false);
        // Friction before the way.
        let now: f64 = self.frictions(false).map(|(z, limit_Nm, _)| limit_Nm * z).sum();
        let (mut low, mut high) = (torque_Nm - most, torque_Nm + most);
        let mut m = mesh_torque_Nm.unwrap_or(torque_Nm - now).clamp(low, high);
        let size = torque_Nm.abs() + most;
        let mut step = high - low;
        let mut last = Status::NotConverged { residual: f64::INFINITY };
        for _ in 0..MOST_STEPS {
            let turned = match self.site.turned([m, preload_N], warm) {
                Ok(turned) => turned,
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
            let (unbalanced_Nm, slope) = self.unbalanced(m, turned, help_Nm);
            // Across a steep step the torque's last digit may be more than the tolerance of the balance.
            if unbalanced_Nm.abs() <= TOLERANCE * size
                || (unbalanced_Nm / slope).abs() <= f64::EPSILON * m.abs()
            {
                *mesh_torque_Nm = Some(m);
                return Ok((m, turned));
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

    /// m - M0 - help + sum L z of what does not help, under a torque m at the meshing points, and its derivative by m.
    fn unbalanced(&self, m: f64, turned: Turned, help_Nm: f64) -> (f64, f64) {
        let way = self.way_rad(turned);
        let (mut unbalanced_Nm, mut slope) = (m - (self.load.torque_Nm.value + help_Nm), 1.0);
        for (z, limit_Nm, friction) in self.frictions(false) {
            let (z, [by_way, ..]) = friction.after(z, way);
            unbalanced_Nm += limit_Nm * z;
            slope += limit_Nm * by_way * turned.by_torque;
        }
        (unbalanced_Nm, slope)
    }

    /// What it has turned since the reading before, rad.
    fn way_rad(&self, turned: Turned) -> f64 {
        turned.angle_rad + self.series_rad - self.memory.angle_rad.value
    }

    /// The torque by which frictions help after a way, and its derivative by the way.
    fn helps(&self, way_rad: f64) -> [f64; 2] {
        let mut sum = [0.0; 2];
        for (z, limit_Nm, friction) in self.frictions(true) {
            let (z, [by_way, ..]) = friction.after(z, way_rad);
            sum = [sum[0] - limit_Nm * z, sum[1] - limit_Nm * by_way];
        }
        sum
    }

    fn most_Nm(&self, helps: bool) -> f64 {
        self.frictions(helps).map(|(_, limit_Nm, _)| limit_Nm.abs()).sum()
    }

    /// The shortest angle over which a friction builds up, rad.
    fn shortest_rad(&self) -> f64 {
        let both = self.frictions(true).chain(self.frictions(false));
        both.map(|(_, _, friction)| friction.engagement_angle_rad.value).fold(f64::INFINITY, f64::min)
    }

    /// The frictions that help, or the others, with their states before the way and their limits (N m); without those of which
    /// only the sensitivity is wanted.
    fn frictions(&self, helps: bool) -> impl Iterator<Item = (f64, f64, &Friction)> {
        let all = self.memory.states.iter().zip(&self.rubs.limits_Nm).zip(&self.rubs.friction);
        all.filter(move |((_, limit), friction)| friction.helps == helps && limit.value != 0.0).map(
            move |((z, limit), friction)| {
                let limit_Nm = if helps { limit.value.min(0.0) } else { limit.value.max(0.0) };
                (z.value, limit_Nm, friction)
            },
        )
    }
}

/// Moves the bound to `m` beyond which the root does not lie.
fn narrow(low: &mut f64, high: &mut f64, m: f64, root_is_below: bool) {
    *(if root_is_below { high } else { low }) = m;
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Limits that are kept from row to row are those under the load of the row, whatever rubbed at the rows before.
    #[test]
    fn limits_are_those_of_the_row() {
        let none = Dual::constant(0.0);
        let friction = |torque_Nm: f64, load_share: f64| Friction {
            law: |before, _, _, _| (before, [0.0, 1.0, 0.0, 0.0]),
            radius_m: none,
            torque_Nm: Dual::parameter(torque_Nm, 0),
            load_share: Dual::constant(load_share),
            engagement_angle_rad: Dual::constant(1.0),
            exponent: none,
            helps: false,
        };
        let mut rubs = Rubs::lasting(vec![friction(1.0, 0.0), friction(2.0, 0.1), friction(3.0, 0.0)]);
        for (torque_Nm, of_row) in [(5.0, vec![friction(4.0, 0.0)]), (-7.0, vec![friction(6.0, 0.2)])] {
            let load = Load {
                torque_Nm: Dual::constant(torque_Nm),
                preload_N: none,
                spring_N_per_m: none,
                friction: of_row,
            };
            rubs.under(&load);
            assert_eq!(rubs.count(), 4);
            let afresh: Vec<Dual> = rubs.friction.iter().map(|friction| friction.limit_Nm(&load)).collect();
            assert_eq!(rubs.limits_Nm, afresh);
        }
    }
}
