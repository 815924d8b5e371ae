//! All readings of a call: histories row by row with their sensitivities; of other rows those that carry the same once, then
//! the sensitivities of each; and what is told.

use std::ops::Range;

use crate::effect::dual::{Dual, WIDTH};
use crate::effect::port::Contact;
use crate::error::InvalidInput;
use crate::status::Status;

use super::chain::Chain;
use super::mesh::Wanted;
use super::run::{Alike, Block, RowState, Solved};
use super::{Prediction, Predictor, first_of, seeded};

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
    /// The effects, with derivatives by the first [`WIDTH`] that are wanted.
    pub chain: Chain,
    /// What the contacts become.
    pub contact: Contact,
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
        let Call { values, wanted, asked, chain, gap_slots, .. } = call;
        let tables = &self.tables[call.at_shift].at_angle;
        let sites = self.sites(tables, call);
        let friction = self.remembers(chain, wanted);
        let groups = self.groups(friction);
        let (rows, site_of) = (self.rows.by_run(), self.angle_of_row.as_slice());
        let added = chain.ahead(&self.rows, friction)?;
        let alike = if friction { Alike::none(rows.len()) } else { Alike::of(chain, rows, &added, site_of) };
        let whole = Block { chain, sites: &sites, rows, added: &added, site_of, alike: &alike };
        let wanted_gaps: Vec<usize> =
            gap_slots.iter().copied().filter(|slot| wanted.contains(slot)).collect();
        let gaps = |slots: &[usize]| -> Vec<Dual> {
            wanted_gaps.iter().map(|slot| seeded(values, slots, *slot)).collect()
        };
        let of_first = gaps(first_of(wanted));
        let (solved, totals) = if friction {
            self.histories(&whole, &groups, &of_first, *asked, states)
        } else {
            let solved = self.apart(&whole, &groups, *asked, states);
            let slopes = || self.differentiated(&whole, &groups, &of_first, &solved);
            let totals = if wanted.is_empty() { totals(&solved) } else { slopes() };
            (solved, totals)
        };
        let angles = chain.behind(&self.rows, &added, totals)?;
        let mut sensitivities = vec![f64::NAN; rows.len() * wanted.len()];
        let mut tell = |number: usize, slots: &[usize], angles: &[Dual]| {
            for (row, angle) in angles.iter().enumerate() {
                let first = row * wanted.len() + number * WIDTH;
                sensitivities[first..first + slots.len()].copy_from_slice(&angle.partials[..slots.len()]);
            }
        };
        tell(0, first_of(wanted), &angles);
        for (number, slots) in wanted.chunks(WIDTH).enumerate().skip(1) {
            let chain = self.chain(values, slots, call.on);
            let added = chain.ahead(&self.rows, friction)?;
            let whole = Block { chain: &chain, added: &added, ..whole };
            let totals = self.differentiated(&whole, &groups, &gaps(slots), &solved);
            tell(number, slots, &chain.behind(&self.rows, &added, totals)?);
        }
        Ok(self.prediction(&angles, &solved, &sensitivities, wanted.len()))
    }

    /// Histories, and their total angles with derivatives.
    fn histories(
        &self,
        whole: &Block<'_>,
        groups: &[Range<usize>],
        gaps: &[Dual],
        asked: Option<Wanted>,
        states: &mut [RowState],
    ) -> (Vec<Solved>, Vec<Dual>) {
        let count = whole.rows.len();
        let (mut solved, mut totals) = (vec![Solved::default(); count], vec![NOT_SOLVED; count]);
        let parts = in_groups(groups, states).zip(in_groups(groups, &mut solved));
        let parts = parts.zip(in_groups(groups, &mut totals)).zip(groups);
        self.spread(parts.collect(), |(((states, solved), totals), group)| {
            whole.part(group.clone()).solve_history(gaps, asked, states, solved, totals);
        });
        (solved, totals)
    }

    /// Rows without a memory.
    fn apart(
        &self,
        whole: &Block<'_>,
        groups: &[Range<usize>],
        asked: Option<Wanted>,
        states: &mut [RowState],
    ) -> Vec<Solved> {
        let mut solved = vec![Solved::default(); whole.rows.len()];
        let parts = in_groups(groups, states).zip(in_groups(groups, &mut solved)).zip(groups);
        self.spread(parts.collect(), |((states, solved), group)| {
            whole.part(group.clone()).solve_apart(asked, states, solved);
        });
        let first = &whole.alike.first;
        for (row, &first) in first.iter().enumerate().filter(|(row, first)| *row != **first) {
            (solved[row], states[row]) = (whole.like(row, &solved[first]), states[first]);
        }
        solved
    }

    /// Total angles with derivatives, from the solutions kept.
    fn differentiated(
        &self,
        whole: &Block<'_>,
        groups: &[Range<usize>],
        gaps: &[Dual],
        solved: &[Solved],
    ) -> Vec<Dual> {
        let mut totals = vec![NOT_SOLVED; solved.len()];
        self.spread(in_groups(groups, &mut totals).zip(groups).collect(), |(totals, group)| {
            whole.part(group.clone()).differentiate(gaps, &solved[group.clone()], totals);
        });
        totals
    }

    /// Rows that one thread takes: whole histories where they have a memory.
    fn groups(&self, friction: bool) -> Vec<Range<usize>> {
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

/// A column cut into groups.
fn in_groups<'a, A>(
    groups: &'a [Range<usize>],
    mut column: &'a mut [A],
) -> impl Iterator<Item = &'a mut [A]> {
    groups.iter().map(move |group| {
        let (part, rest) = std::mem::take(&mut column).split_at_mut(group.len());
        column = rest;
        part
    })
}
