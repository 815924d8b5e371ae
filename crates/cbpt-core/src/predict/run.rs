//! Readings one after the other: first their angles, then the sensitivities of these.

use std::collections::HashMap;
use std::ops::Range;

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
    /// Of the unloaded state before a history's first row.
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
    /// The unloaded state before a history's first row, where friction acts.
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

/// Neighbouring rows: a whole history where they have a memory.
#[derive(Debug, Clone, Copy)]
pub struct Block<'a> {
    pub chain: &'a Chain,
    pub sites: &'a [Site<'a>],
    pub rows: &'a [Row],
    /// What own effects and the torques before add to each row; without entries where that is nothing.
    pub added: &'a [Added],
    pub site_of: &'a [usize],
    /// Of the whole table, by [`Row::place`]: the first row that carries the same at the same input angle. Only that is solved.
    pub alike: &'a [usize],
}

/// The first row that carries the same at the same input angle, for each row. Where rows have a memory, each is its own: a
/// loading and an unloading curve through the same torques then differ.
pub fn alike(chain: &Chain, rows: &[Row], added: &[Added], site_of: &[usize]) -> Vec<usize> {
    let mut firsts: HashMap<(usize, u64, u64), usize> = HashMap::with_capacity(rows.len());
    let first = |(place, row): (usize, &Row)| {
        let added = Added::to(place, added);
        if !added.finite {
            return place;
        }
        let load = chain.load(row, added);
        let carried = (site_of[place], load.torque_Nm.value.to_bits(), load.preload_N.value.to_bits());
        *firsts.entry(carried).or_insert(place)
    };
    rows.iter().enumerate().map(first).collect()
}

impl Block<'_> {
    /// Some of the rows of a whole table.
    pub fn part(&self, of: Range<usize>) -> Self {
        let added = self.added.get(of.clone()).unwrap_or_default();
        let (rows, site_of) = (&self.rows[of.clone()], &self.site_of[of]);
        Self { rows, added, site_of, ..*self }
    }

    /// Solves the rows.
    pub fn solve(
        &self,
        wanted: Option<Wanted>,
        friction: bool,
        states: &mut [RowState],
        solved: &mut [Solved],
    ) {
        let mut memory = Memory::default();
        for (i, row) in self.rows.iter().enumerate().filter(|(_, row)| self.alike[row.place] == row.place) {
            let (state, solved) = (&mut states[i], &mut solved[i]);
            let site = &self.sites[self.site_of[i]];
            let added = Added::to(i, self.added);
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
                let held = Held { site, load: &load, series_rad: series, memory: &memory, wanted };
                held.solve(&mut state.warm, &mut state.mesh_torque_Nm)
            };
            match found {
                Ok(mesh) => {
                    solved.mesh_load = [mesh.torque_Nm, preload_N];
                    let total = mesh.angle_rad + series;
                    let way = total - memory.angle_rad;
                    for (z, friction) in memory.states.iter_mut().zip(&load.friction) {
                        *z = (friction.law)(*z, way, friction.engagement_angle_rad.value).0;
                    }
                    memory.angle_rad = total;
                    (solved.status, solved.total_rad, solved.mesh) = (mesh.status, total, Some(mesh));
                }
                Err(status) => solved.status = status,
            }
        }
    }

    /// A row that carries the same as a solved one: what stands in series is its own.
    pub fn like(&self, i: usize, first: &Solved) -> Solved {
        let (row, added) = (&self.rows[i], Added::to(i, self.added));
        let load = self.chain.load(row, added);
        let series = (self.chain.series(row, load.torque_Nm) + added.series_rad).value;
        let total_rad = first.mesh.as_ref().map_or(f64::NAN, |mesh| mesh.angle_rad + series);
        Solved { total_rad, ..first.clone() }
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
            let [squared, cubed] = &contact.curve_rad;
            let spring = [
                &contact.play_rad,
                &contact.transition_torque_Nm,
                squared,
                cubed,
                &contact.reference_torque_Nm,
            ];
            for (slope, number) in mesh.spring.iter().zip(spring) {
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
