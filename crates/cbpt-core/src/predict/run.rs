//! Readings one after the other: first their angles, then the sensitivities of these.

use std::collections::HashMap;
use std::hash::{BuildHasherDefault, Hasher};
use std::ops::Range;
use std::sync::Arc;

use crate::effect::dual::Dual;
use crate::effect::port::{Load, Row};
use crate::status::Status;

use super::added::Added;
use super::chain::Chain;
use super::friction::{Held, Memory, with_torque};
use super::mesh::{Mesh, Wanted, Warm};
use super::site::Site;

/// What is kept of a row from call to call, only to start from.
#[derive(Debug, Clone, Copy, Default)]
pub struct RowState {
    warm: Warm,
    /// Torque at the meshing points under friction, N m.
    mesh_torque_Nm: Option<f64>,
}

/// A solved row.
#[derive(Debug, Clone)]
pub struct Solved {
    pub status: Status,
    /// Shared by rows that carry the same.
    pub mesh: Option<Arc<Mesh>>,
    /// Meshing points and what stands in series, rad.
    pub total_rad: f64,
    /// Torque (N m) and preload (N) that reach the meshing points.
    pub mesh_load: [f64; 2],
    /// The unloaded state before a history's first row, where friction acts.
    unloaded: Option<Arc<Mesh>>,
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

/// Neighbouring rows: a whole history where they have a memory.
#[derive(Debug, Clone, Copy)]
pub struct Block<'a> {
    pub chain: &'a Chain,
    pub sites: &'a [Site<'a>],
    pub rows: &'a [Row],
    /// What own effects and the torques before add to each row; without entries where that is nothing.
    pub added: &'a [Added],
    pub site_of: &'a [usize],
    /// Of the whole table.
    pub alike: &'a Alike,
}

/// Which rows carry the same, by [`Row::place`]. Where rows have a memory, each is its own: a loading and an unloading
/// curve through the same torques then differ.
#[derive(Debug)]
pub struct Alike {
    /// The first row that carries the same at the same input angle. Only that is solved.
    pub first: Vec<usize>,
    /// Torque (N m) and preload (N) of each row; empty where rows have a memory.
    loads: Vec<[f64; 2]>,
}

impl Alike {
    /// Each row for itself.
    pub fn none(rows: usize) -> Self {
        Self { first: (0..rows).collect(), loads: Vec::new() }
    }

    /// Of rows without a memory.
    pub fn of(chain: &Chain, rows: &[Row], added: &[Added], site_of: &[usize]) -> Self {
        let mut firsts: HashMap<(usize, u64, u64), usize, BuildHasherDefault<Mixed>> =
            HashMap::with_capacity_and_hasher(rows.len(), BuildHasherDefault::default());
        let (mut first, mut loads) = (Vec::with_capacity(rows.len()), Vec::with_capacity(rows.len()));
        for (place, row) in rows.iter().enumerate() {
            let added = Added::to(place, added);
            let load = chain.load(row, added);
            let [torque_Nm, preload_N] = [load.torque_Nm.value, load.preload_N.value];
            let carried = (site_of[place], torque_Nm.to_bits(), preload_N.to_bits());
            first.push(if added.finite { *firsts.entry(carried).or_insert(place) } else { place });
            loads.push([torque_Nm, preload_N]);
        }
        Self { first, loads }
    }
}

/// A hash of few numbers that no one chooses to collide: the standard one costs as much as the loads themselves.
#[derive(Debug, Default)]
struct Mixed(u64);

impl Hasher for Mixed {
    fn write(&mut self, bytes: &[u8]) {
        for byte in bytes {
            self.write_u64(u64::from(*byte));
        }
    }

    fn write_u64(&mut self, number: u64) {
        // The golden ratio's odd multiple; what it gathers at the upper end is turned to where tables look first.
        self.0 = (self.0 ^ number).wrapping_mul(0x9e37_79b9_7f4a_7c15).rotate_left(26);
    }

    fn write_usize(&mut self, number: usize) {
        self.write_u64(number as u64);
    }

    fn finish(&self) -> u64 {
        self.0
    }
}

impl Block<'_> {
    /// Some of the rows of a whole table.
    pub fn part(&self, of: Range<usize>) -> Self {
        let added = self.added.get(of.clone()).unwrap_or_default();
        let (rows, site_of) = (&self.rows[of.clone()], &self.site_of[of]);
        Self { rows, added, site_of, ..*self }
    }

    /// Solves the rows, which have no memory, but for those that carry the same as one before.
    pub fn solve_apart(&self, wanted: Option<Wanted>, states: &mut [RowState], solved: &mut [Solved]) {
        for (i, row) in
            self.rows.iter().enumerate().filter(|(_, row)| self.alike.first[row.place] == row.place)
        {
            if !Added::to(i, self.added).finite {
                solved[i].status = Status::EffectNotFinite;
                continue;
            }
            let load @ [_, preload_N] = self.alike.loads[row.place];
            match self.sites[self.site_of[i]].solve(load, wanted, &mut states[i].warm) {
                Ok(mesh) => {
                    solved[i] = Solved {
                        status: mesh.status,
                        total_rad: mesh.angle_rad + self.series_rad(i),
                        mesh_load: [mesh.torque_Nm, preload_N],
                        mesh: Some(Arc::new(mesh)),
                        unloaded: None,
                    };
                }
                Err(status) => solved[i].status = status,
            }
        }
    }

    /// A row that carries the same as a solved one: what stands in series is its own.
    pub fn like(&self, i: usize, first: &Solved) -> Solved {
        let total_rad = first.mesh.as_ref().map_or(f64::NAN, |mesh| mesh.angle_rad + self.series_rad(i));
        Solved { total_rad, ..first.clone() }
    }

    /// What stands in series at a row without a memory, rad.
    fn series_rad(&self, i: usize) -> f64 {
        let row = &self.rows[i];
        let torque_Nm = Dual::constant(self.alike.loads[row.place][0]);
        (self.chain.series(row, torque_Nm) + Added::to(i, self.added).series_rad).value
    }

    /// Solves a history, one row after the other.
    pub fn solve_history(&self, wanted: Option<Wanted>, states: &mut [RowState], solved: &mut [Solved]) {
        let mut memory = Memory::default();
        for (i, row) in self.rows.iter().enumerate() {
            let (state, solved) = (&mut states[i], &mut solved[i]);
            let site = &self.sites[self.site_of[i]];
            let added = Added::to(i, self.added);
            let load = self.chain.load(row, added);
            let preload_N = load.preload_N.value;
            if i == 0 {
                let unloaded = site.solve([0.0, preload_N], wanted, &mut Warm::default()).ok();
                let series = self.chain.series(row, load.torque_Nm * 0.0) + added.series_at_rest_rad;
                memory.angle_rad = unloaded.as_ref().map_or(0.0, |mesh| mesh.angle_rad) + series.value;
                memory.states = vec![0.0; load.friction.len()];
                solved.unloaded = unloaded.map(Arc::new);
            }
            if !added.finite {
                solved.status = Status::EffectNotFinite;
                continue;
            }
            let series = (self.chain.series(row, load.torque_Nm) + added.series_rad).value;
            let found = if load.friction.is_empty() {
                site.solve([load.torque_Nm.value, preload_N], wanted, &mut state.warm)
            } else {
                let held = Held { site, load: &load, series_rad: series, memory: &memory, wanted };
                held.solve(&mut state.warm, &mut state.mesh_torque_Nm)
            };
            match found {
                Ok(mesh) => {
                    solved.mesh_load = [mesh.torque_Nm, preload_N];
                    let total = mesh.angle_rad + series;
                    let way = total - memory.angle_rad;
                    for (z, friction) in memory.states.iter_mut().zip(&load.friction) {
                        *z = friction.after(*z, way).0;
                    }
                    memory.angle_rad = total;
                    (solved.status, solved.total_rad, solved.mesh) =
                        (mesh.status, total, Some(Arc::new(mesh)));
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
            for (slope, number) in mesh.spring.iter().zip(contact.of_spring()) {
                angle.add_slope(*slope, number);
            }
            for (slope, number) in mesh.stop.iter().zip([&contact.stop_share, &contact.stop_torque_Nm]) {
                angle.add_slope(*slope, number);
            }
            for (slope, gap) in slopes.gaps.iter().zip(gaps) {
                angle.add_slope(*slope, gap);
            }
            angle
        };
        let mut memory = Memory { angle_rad: Dual::constant(0.0), states: Vec::new() };
        for (i, row) in self.rows.iter().enumerate() {
            let added = Added::to(i, self.added);
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
