//! All readings of a call: rows that carry the same are solved once, then each row's sensitivities follow, and what is told.

use crate::effect::dual::{Dual, WIDTH};
use crate::error::InvalidInput;
use crate::status::Status;

use super::chain::Chain;
use super::mesh::Wanted;
use super::run::{Alike, Block, RowState, Solved};
use super::{Prediction, Predictor, seeded};

/// Rows that a thread takes at a time where no history binds them.
const CHUNK: usize = 16;

/// What one call asks.
pub struct Call<'a> {
    pub values: &'a [f64],
    pub wanted: &'a [usize],
    /// Which effects are switched on.
    pub on: &'a dyn Fn(usize) -> bool,
    /// Which answers of the meshing points it needs.
    pub asked: Option<Wanted>,
    /// The effects without derivatives.
    pub plain: Chain,
    /// Sizes of effects on gaps that are not neutral or wanted.
    pub gap_slots: Vec<usize>,
    /// Place of the meshing points among the predictor's.
    pub at_shift: usize,
}

impl Predictor {
    /// Predicts all rows; `states` are solutions nearby, and become those found.
    pub(super) fn predicted(
        &self,
        call: &Call<'_>,
        states: &mut [RowState],
    ) -> Result<Prediction, InvalidInput> {
        let Call { values, wanted, asked, plain, gap_slots, .. } = call;
        let tables = &self.tables[call.at_shift].at_angle;
        let sites = self.sites(tables, plain, values, gap_slots, wanted);
        let friction = self.remembers(plain, wanted);
        let groups = self.groups(friction);
        let (rows, site_of) = (self.rows.by_run(), self.angle_of_row.as_slice());
        let added = plain.ahead(&self.rows, friction)?;
        let alike = if friction { Alike::none(rows.len()) } else { Alike::of(plain, rows, &added, site_of) };
        let whole = Block { chain: plain, sites: &sites, rows, added: &added, site_of, alike: &alike };
        let mut solved: Vec<Solved> = vec![Solved::default(); rows.len()];
        self.spread(in_groups(&groups, states, &mut solved), |(group, states, solved)| {
            let part = whole.part(group);
            if friction {
                part.solve_history(*asked, states, solved);
            } else {
                part.solve_apart(*asked, states, solved);
            }
        });
        for (row, &first) in alike.first.iter().enumerate().filter(|(row, first)| *row != **first) {
            (solved[row], states[row]) = (whole.like(row, &solved[first]), states[first]);
        }
        let angles = plain.behind(&self.rows, &added, totals(&solved))?;
        let mut sensitivities = vec![f64::NAN; rows.len() * wanted.len()];
        let wanted_gaps: Vec<usize> =
            gap_slots.iter().copied().filter(|slot| wanted.contains(slot)).collect();
        for (number, slots) in wanted.chunks(WIDTH).enumerate() {
            let chain = self.chain(values, slots, call.on);
            let added = chain.ahead(&self.rows, friction)?;
            let whole = Block { chain: &chain, added: &added, ..whole };
            let gaps: Vec<Dual> = wanted_gaps.iter().map(|slot| seeded(values, slots, *slot)).collect();
            let mut angles = vec![NOT_SOLVED; rows.len()];
            self.spread(in_groups(&groups, &mut solved, &mut angles), |(group, solved, angles)| {
                whole.part(group).differentiate(&gaps, friction, solved, angles);
            });
            for (row, angle) in chain.behind(&self.rows, &added, angles)?.iter().enumerate() {
                let first = row * wanted.len() + number * WIDTH;
                sensitivities[first..first + slots.len()].copy_from_slice(&angle.partials[..slots.len()]);
            }
        }
        Ok(self.prediction(&angles, &solved, &sensitivities, wanted.len()))
    }

    /// Rows that one thread takes: whole histories where they have a memory.
    fn groups(&self, friction: bool) -> Vec<std::ops::Range<usize>> {
        if friction {
            return self.rows.histories();
        }
        let count = self.rows.by_run().len();
        (0..count.div_ceil(CHUNK)).map(|i| i * CHUNK..((i + 1) * CHUNK).min(count)).collect()
    }

    fn prediction(
        &self,
        angles: &[Dual],
        solved: &[Solved],
        sensitivities: &[f64],
        width: usize,
    ) -> Prediction {
        // An angle that an own effect made not finite is no solution, whatever the meshing points say.
        let lost = |row: usize| solved[row].mesh.is_some() && !angles[row].value.is_finite();
        let of = |row: usize| solved[row].mesh.as_ref().filter(|_| !lost(row));
        let rows = 0..solved.len();
        let angle = |row: usize| of(row).map_or(f64::NAN, |_| angles[row].value);
        let angle_rad: Vec<f64> = rows.clone().map(angle).collect();
        let parts = |row: usize| of(row).map_or([f64::NAN; 2], |mesh| mesh.parts_rad);
        let parts_rad: Vec<f64> = rows.clone().flat_map(parts).collect();
        let mesh_load: Vec<f64> = solved.iter().flat_map(|row| row.mesh_load).collect();
        let told = self.rows.row_of_each(|row| of(row).is_none());
        let status = |row: usize| if lost(row) { Status::EffectNotFinite } else { solved[row].status };
        let residual = |row: usize| of(row).map_or(f64::NAN, |mesh| mesh.residual);
        Prediction {
            angle_rad: self.rows.means(&angle_rad, 1),
            status: told.iter().map(|row| status(*row)).collect(),
            sensitivities: self.rows.means(sensitivities, width),
            carrying: told.iter().map(|row| of(*row).map_or([0; 2], |mesh| mesh.carrying)).collect(),
            regime: told.iter().map(|row| of(*row).and_then(|mesh| mesh.regime)).collect(),
            parts_rad: in_pairs(&self.rows.means(&parts_rad, 2)),
            mesh_load: in_pairs(&self.rows.means(&mesh_load, 2)),
            residual: told.iter().map(|row| residual(*row)).collect(),
        }
    }

    /// No row has a solution.
    pub(super) fn nowhere(&self, status: Status, width: usize) -> Prediction {
        let count = self.rows.len();
        Prediction {
            angle_rad: vec![f64::NAN; count],
            status: vec![status; count],
            sensitivities: vec![f64::NAN; count * width],
            carrying: vec![[0; 2]; count],
            regime: vec![None; count],
            parts_rad: vec![[f64::NAN; 2]; count],
            mesh_load: vec![[f64::NAN; 2]; count],
            residual: vec![f64::NAN; count],
        }
    }
}

/// The angle of a row without solution.
const NOT_SOLVED: Dual = Dual { value: f64::NAN, partials: [f64::NAN; WIDTH] };

/// Total angles without derivatives.
fn totals(solved: &[Solved]) -> Vec<Dual> {
    solved.iter().map(|row| Dual::constant(row.total_rad)).collect()
}

fn in_pairs(values: &[f64]) -> Vec<[f64; 2]> {
    values.chunks_exact(2).map(|pair| [pair[0], pair[1]]).collect()
}

/// Two columns cut into the same groups.
fn in_groups<'a, A, B>(
    groups: &[std::ops::Range<usize>],
    mut first: &'a mut [A],
    mut second: &'a mut [B],
) -> Vec<(std::ops::Range<usize>, &'a mut [A], &'a mut [B])> {
    let mut parts = Vec::with_capacity(groups.len());
    for group in groups {
        let (a, rest_a) = first.split_at_mut(group.len());
        let (b, rest_b) = second.split_at_mut(group.len());
        parts.push((group.clone(), a, b));
        (first, second) = (rest_a, rest_b);
    }
    parts
}
