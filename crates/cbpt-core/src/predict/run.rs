//! Readings one after the other: their angles, with the sensitivities of these.
//!
//! A row with a memory has both at once; rows without one share solutions, so their sensitivities come after. Of parameters
//! beyond those that are carried along together sensitivities follow from the solutions kept.

use std::collections::HashMap;
use std::hash::{BuildHasherDefault, Hasher};
use std::ops::Range;
use std::sync::Arc;

use crate::effect::dual::{Dual, values};
use crate::effect::port::{CURVE_NUMBERS, Contact, Load, PLAY_NUMBERS, Row, STOP_NUMBERS};
use crate::effect::{backlash, hard_stop, stiffness_curve};
use crate::status::Status;

use super::added::Added;
use super::chain::Chain;
use super::friction::{Held, Memory, Rubs};
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

    /// Solves a history, one row after the other, with the derivatives of its total angles by the seeded parameters.
    pub fn solve_history(
        &self,
        gaps: &[Dual],
        wanted: Option<Wanted>,
        states: &mut [RowState],
        solved: &mut [Solved],
        totals: &mut [Dual],
    ) {
        let answers = Answers::new(&self.chain.contact(), gaps);
        let mut history = self.history(&answers);
        for (i, row) in self.rows.iter().enumerate() {
            let (state, solved) = (&mut states[i], &mut solved[i]);
            let site = &self.sites[self.site_of[i]];
            history.load(i, row);
            let preload_N = history.load.preload_N.value;
            if i == 0 {
                let unloaded = site.solve([0.0, preload_N], wanted, &mut Warm::default()).ok();
                solved.unloaded = unloaded.map(Arc::new);
                history.begin(row, solved.unloaded.as_deref());
            }
            if !Added::to(i, self.added).finite {
                solved.status = Status::EffectNotFinite;
                continue;
            }
            let load = &history.load;
            let found = if history.rubs.count() == 0 {
                site.solve([load.torque_Nm.value, preload_N], wanted, &mut state.warm)
            } else {
                let SoFar { rubs, memory, series_rad, .. } = &history;
                let held = Held { site, load, rubs, series_rad: series_rad.value, memory, wanted };
                held.solve(&mut state.warm, &mut state.mesh_torque_Nm)
            };
            match found {
                Ok(mesh) => {
                    solved.mesh_load = [mesh.torque_Nm, preload_N];
                    totals[i] = history.total(&mesh);
                    (solved.status, solved.total_rad, solved.mesh) =
                        (mesh.status, totals[i].value, Some(Arc::new(mesh)));
                }
                Err(status) => solved.status = status,
            }
        }
    }

    /// Total angles with their derivatives by the parameters that are seeded in the chain, from the solutions kept.
    pub fn differentiate(&self, gaps: &[Dual], solved: &[Solved], totals: &mut [Dual]) {
        let answers = Answers::new(&self.chain.contact(), gaps);
        let mut history = self.history(&answers);
        for (i, row) in self.rows.iter().enumerate() {
            history.load(i, row);
            if i == 0 {
                history.begin(row, solved[i].unloaded.as_deref());
            }
            let Some(mesh) = &solved[i].mesh else { continue };
            totals[i] = history.total(mesh);
        }
    }

    fn history<'a>(&'a self, answers: &'a Answers<'a>) -> SoFar<'a> {
        SoFar {
            block: self,
            answers,
            memory: Memory::default(),
            load: Load::default(),
            rubs: Rubs::lasting(self.chain.friction().copied().collect()),
            series_rad: NOTHING,
        }
    }
}

const NOTHING: Dual = Dual::constant(0.0);

/// What the angle of the meshing points answers to, of that which depends on a seeded parameter.
struct Answers<'a> {
    contact: Vec<(Answer, Dual)>,
    stops: Vec<[f64; STOP_NUMBERS]>,
    gaps: &'a [Dual],
}

/// A number of the contacts; of an effect that may stand more than once, its place among the numbers of one of them.
#[derive(Debug, Clone, Copy)]
enum Answer {
    LogStiffness,
    ContactAngle,
    Exponent,
    Play([f64; PLAY_NUMBERS], usize),
    Curve([f64; CURVE_NUMBERS], usize),
    /// Which of the stops, and which number of it.
    Stop(usize, usize),
}

impl<'a> Answers<'a> {
    fn new(contact: &Contact, gaps: &'a [Dual]) -> Self {
        let scale = contact.stiffness_scale;
        let mut of_all = vec![
            (Answer::LogStiffness, scale.chain(scale.value.ln(), 1.0 / scale.value)),
            (Answer::ContactAngle, contact.contact_angle_shift_rad),
            (Answer::Exponent, contact.exponent),
        ];
        for own in &contact.plays {
            of_all.extend(own.iter().enumerate().map(|(place, n)| (Answer::Play(values(own), place), *n)));
        }
        for own in &contact.curves {
            of_all.extend(own.iter().enumerate().map(|(place, n)| (Answer::Curve(values(own), place), *n)));
        }
        for (stop, own) in contact.stops.iter().enumerate() {
            of_all.extend(own.iter().enumerate().map(|(place, n)| (Answer::Stop(stop, place), *n)));
        }
        of_all.retain(|(_, number)| number.depends());
        Self { contact: of_all, stops: contact.stops.iter().map(values).collect(), gaps }
    }

    /// The angle of the meshing points under a load, rad.
    fn angle(&self, mesh: &Mesh, load: &Load) -> Dual {
        let mut angle = Dual::constant(mesh.angle_rad);
        angle.add_slope(mesh.slopes.preload, &load.preload_N);
        angle.add_slope(mesh.slopes.spring, &load.spring_N_per_m);
        for (answer, number) in &self.contact {
            angle.add_slope(self.to(*answer, mesh), number);
        }
        for (slope, gap) in mesh.slopes.gaps.iter().zip(self.gaps) {
            angle.add_slope(*slope, gap);
        }
        angle
    }

    /// How the angle answers to a number.
    fn to(&self, answer: Answer, mesh: &Mesh) -> f64 {
        match answer {
            Answer::LogStiffness => mesh.slopes.log_stiffness,
            Answer::ContactAngle => mesh.slopes.contact_angle,
            Answer::Exponent => mesh.slopes.exponent,
            Answer::Play(own, place) => backlash::slopes(&own, mesh.torque_Nm)[place],
            Answer::Curve(own, place) => stiffness_curve::slopes(&own, mesh.torque_Nm)[place],
            Answer::Stop(stop, place) => {
                mesh.slopes.torque * self.carried_by(stop, place, mesh.with_stops_Nm)
            }
        }
    }

    /// How the torque that the stops leave answers to a number of one of them.
    fn carried_by(&self, stop: usize, place: usize, mut torque_Nm: f64) -> f64 {
        let mut by_number = 0.0;
        for (other, own) in self.stops.iter().enumerate() {
            let (left_Nm, by_torque, by_own) = hard_stop::carried(torque_Nm, own);
            by_number = if other == stop { by_own[place] } else { by_number * by_torque };
            torque_Nm = left_Nm;
        }
        by_number
    }
}

/// A history up to one of its rows.
struct SoFar<'a> {
    block: &'a Block<'a>,
    answers: &'a Answers<'a>,
    memory: Memory,
    /// Of the row.
    load: Load,
    rubs: Rubs,
    /// What stands in series at the row, rad.
    series_rad: Dual,
}

impl SoFar<'_> {
    /// Goes to a row.
    fn load(&mut self, i: usize, row: &Row) {
        let (chain, added) = (self.block.chain, Added::to(i, self.block.added));
        chain.load_into(&mut self.load, row, added);
        self.rubs.under(&self.load);
        self.series_rad = chain.series(row, self.load.torque_Nm) + added.series_rad;
    }

    /// Begins at the first row, from the unloaded state.
    fn begin(&mut self, row: &Row, unloaded: Option<&Mesh>) {
        let mesh = unloaded.map_or(NOTHING, |mesh| self.answers.angle(mesh, &self.load));
        let added = Added::to(0, self.block.added);
        let series = self.block.chain.series(row, self.load.torque_Nm * 0.0) + added.series_at_rest_rad;
        self.memory.begin(mesh + series, self.rubs.count());
    }

    /// The total angle of a solution, rad; moves the memory on.
    fn total(&mut self, mesh: &Mesh) -> Dual {
        let at_torque = self.answers.angle(mesh, &self.load) + self.series_rad;
        self.memory.after(at_torque, mesh.by_torque(), self.load.torque_Nm, &self.rubs)
    }
}
