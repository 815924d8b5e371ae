//! Readings one after the other: first their angles, then the sensitivities of these.
//!
//! Friction makes a run a history. The meshing points carry m = M0 - sum of Tf, each Tf = L z with the limit L and the
//! state z of [`dahl`] after the way of the total angle A = alpha(m) + series since the reading before. m is the root of
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
use crate::effect::friction_hysteresis::dahl;
use crate::effect::port::{Load, Row};
use crate::status::Status;

use super::chain::Chain;
use super::mesh::{Mesh, Site, Wanted, Warm};
use super::own::Added;

/// What is kept of a row from call to call, only to start from.
#[derive(Debug, Clone, Copy, Default)]
pub struct RowState {
    warm: Warm,
    /// Of the unloaded state before a run's first row.
    unloaded: Warm,
    /// Torque at the meshing points under friction, N m.
    mesh_torque_Nm: Option<f64>,
}

/// A solved row.
#[derive(Debug, Clone)]
pub struct Solved {
    pub status: Status,
    pub mesh: Option<Mesh>,
    /// Meshing points and what stands in series, rad.
    pub total_rad: f64,
    /// Torque (N m) and preload (N) that reach the meshing points.
    pub mesh_load: [f64; 2],
    /// The unloaded state before a run's first row, where friction acts.
    unloaded: Option<Mesh>,
}

impl Default for Solved {
    fn default() -> Self {
        Self {
            status: Status::Solved,
            mesh: None,
            total_rad: f64::NAN,
            mesh_load: [f64::NAN; 2],
            unloaded: None,
        }
    }
}

/// Neighbouring rows: a whole run where it has a memory.
#[derive(Debug, Clone, Copy)]
pub struct Block<'a> {
    pub chain: &'a Chain,
    pub sites: &'a [Site<'a>],
    pub rows: &'a [Row],
    /// What own effects and the torques before add to each row.
    pub added: &'a [Added],
    pub site_of: &'a [usize],
}

/// The friction's memory: the total angle of the reading before and the state of each friction.
#[derive(Debug, Clone, Default)]
struct Memory<T> {
    angle_rad: T,
    states: Vec<T>,
}

/// Steps for the torque at the meshing points; bisection alone would need 50.
const MOST_STEPS: u32 = 100;
/// Balance of the torques, as a share of them.
const TOLERANCE: f64 = 1e-12;

impl Block<'_> {
    /// Solves the rows.
    pub fn solve(
        &self,
        wanted: Option<Wanted>,
        friction: bool,
        states: &mut [RowState],
        solved: &mut [Solved],
    ) {
        let mut memory = Memory::default();
        for (i, row) in self.rows.iter().enumerate() {
            let (state, solved) = (&mut states[i], &mut solved[i]);
            let site = &self.sites[self.site_of[i]];
            let added = &self.added[i];
            let load = self.chain.load(row, added);
            let preload_N = load.preload_N.value;
            if friction && i == 0 {
                let unloaded = site.solve([0.0, preload_N], wanted, &mut state.unloaded).ok();
                let series = self.chain.series(row, load.torque_Nm * 0.0) + added.series_at_rest_rad;
                memory.angle_rad = unloaded.as_ref().map_or(0.0, |mesh| mesh.angle_rad) + series.value;
                memory.states = vec![0.0; load.friction.len()];
                solved.unloaded = unloaded;
            }
            if !added.finite {
                solved.status = Status::EffectNotFinite;
                continue;
            }
            let series = (self.chain.series(row, load.torque_Nm) + added.series_rad).value;
            let found = if load.friction.is_empty() {
                site.solve([load.torque_Nm.value, preload_N], wanted, &mut state.warm)
            } else {
                under_friction(site, &load, series, &memory, wanted, state)
            };
            match found {
                Ok(mesh) => {
                    let torque = if load.friction.is_empty() { None } else { state.mesh_torque_Nm };
                    solved.mesh_load = [torque.unwrap_or(load.torque_Nm.value), preload_N];
                    let total = mesh.angle_rad + series;
                    let way = total - memory.angle_rad;
                    for (z, friction) in memory.states.iter_mut().zip(&load.friction) {
                        *z = dahl(*z, way, friction.engagement_angle_rad.value).0;
                    }
                    memory.angle_rad = total;
                    (solved.status, solved.total_rad, solved.mesh) = (mesh.status, total, Some(mesh));
                }
                Err(status) => solved.status = status,
            }
        }
    }

    /// Total angles with their derivatives by the parameters that are seeded in the chain, from the solutions kept.
    pub fn differentiate(&self, gaps: &[Dual], friction: bool, solved: &[Solved], totals: &mut [Dual]) {
        let contact = self.chain.contact();
        let mesh_angle = |mesh: &Mesh, load: &Load| {
            let slopes = &mesh.slopes;
            let mut angle = Dual::constant(mesh.angle_rad);
            angle.add_slope(slopes.preload, &load.preload_N);
            angle.add_slope(slopes.spring, &load.spring_N_per_m);
            angle.add_slope(slopes.log_stiffness / contact.stiffness_scale.value, &contact.stiffness_scale);
            angle.add_slope(slopes.contact_angle, &contact.contact_angle_shift_rad);
            angle.add_slope(slopes.exponent, &contact.exponent);
            angle.add_slope(mesh.backlash[0], &contact.play_rad);
            angle.add_slope(mesh.backlash[1], &contact.transition_torque_Nm);
            for (slope, gap) in slopes.gaps.iter().zip(gaps) {
                angle.add_slope(*slope, gap);
            }
            angle
        };
        let mut memory = Memory { angle_rad: Dual::constant(0.0), states: Vec::new() };
        for (i, row) in self.rows.iter().enumerate() {
            let added = &self.added[i];
            let load = self.chain.load(row, added);
            if friction && i == 0 {
                let series = self.chain.series(row, load.torque_Nm * 0.0) + added.series_at_rest_rad;
                let mesh = solved[i].unloaded.as_ref().map(|mesh| mesh_angle(mesh, &load));
                memory.angle_rad = mesh.unwrap_or(Dual::constant(0.0)) + series;
                memory.states = vec![Dual::constant(0.0); load.friction.len()];
            }
            let Some(mesh) = &solved[i].mesh else { continue };
            let series = self.chain.series(row, load.torque_Nm) + added.series_rad;
            let at_torque = mesh_angle(mesh, &load) + series;
            totals[i] = with_torque(at_torque, mesh.slopes.torque, &load, &mut memory);
        }
    }
}

/// The total angle from the one at the meshing points' torque held; moves the memory on.
fn with_torque(at_torque: Dual, per_torque: f64, load: &Load, memory: &mut Memory<Dual>) -> Dual {
    let way = at_torque.value - memory.angle_rad.value;
    let mut torque = load.torque_Nm;
    let mut resistance = 1.0;
    // Each friction: its state now, and its derivatives by the way and by what it was.
    let mut after = Vec::with_capacity(memory.states.len());
    for (before, friction) in memory.states.iter().zip(&load.friction) {
        let angle = friction.engagement_angle_rad;
        let limit = friction.limit_Nm(load);
        let (z, [by_way, by_before, by_angle]) = dahl(before.value, way, angle.value);
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

/// The torque at the meshing points by Newton's method between bounds, which bisection narrows where it would leave them.
fn under_friction(
    site: &Site<'_>,
    load: &Load,
    series_rad: f64,
    memory: &Memory<f64>,
    wanted: Option<Wanted>,
    state: &mut RowState,
) -> Result<Mesh, Status> {
    let (torque_Nm, preload_N) = (load.torque_Nm.value, load.preload_N.value);
    let limit = |friction: &crate::effect::port::Friction| friction.limit_Nm(load).value.max(0.0);
    let most: f64 = load.friction.iter().map(limit).sum();
    // Friction before the way, in the order of the frictions.
    let frictions = || memory.states.iter().zip(&load.friction);
    let now: f64 = frictions().map(|(z, friction)| limit(friction) * z).sum();
    let (mut low, mut high) = (torque_Nm - most, torque_Nm + most);
    let mut m = state.mesh_torque_Nm.unwrap_or(torque_Nm - now).clamp(low, high);
    let size = torque_Nm.abs() + most;
    let mut last = Status::NotConverged { residual: f64::INFINITY };
    for _ in 0..MOST_STEPS {
        let mesh = match site.solve([m, preload_N], None, &mut state.warm) {
            Ok(mesh) => mesh,
            Err(status) => {
                // Too much to hold: less of it, as far as the friction reaches.
                last = status;
                if m > 0.0 {
                    high = m;
                } else {
                    low = m;
                }
                let middle = 0.5 * (low + high);
                if middle <= low || middle >= high {
                    return Err(last);
                }
                m = middle;
                continue;
            }
        };
        let way = mesh.angle_rad + series_rad - memory.angle_rad;
        let (mut unbalanced, mut slope) = (m - torque_Nm, 1.0);
        for (z, friction) in frictions() {
            let (z, [by_way, ..]) = dahl(*z, way, friction.engagement_angle_rad.value);
            unbalanced += limit(friction) * z;
            slope += limit(friction) * by_way * mesh.slopes.torque;
        }
        if unbalanced.abs() <= TOLERANCE * size {
            state.mesh_torque_Nm = Some(m);
            return if wanted.is_some() {
                site.solve([m, preload_N], wanted, &mut state.warm)
            } else {
                Ok(mesh)
            };
        }
        last = Status::NotConverged { residual: unbalanced.abs() / size };
        if unbalanced > 0.0 {
            high = m;
        } else {
            low = m;
        }
        let newton = m - unbalanced / slope;
        m = if newton > low && newton < high { newton } else { 0.5 * (low + high) };
    }
    Err(last)
}
