//! Rows of a plan, solved: those that share reducer and effects together, so that loads of one geometry run side by side.

use std::ops::Range;

use cbpt_core::cost::Cost;
use cbpt_core::findings::UNBUILDABLE;
use cbpt_core::predict::Effect;
use cbpt_core::predict::loads::{Effects, LoadOutcome, solve_loads};
use cbpt_core::sweep::{Progress, solve_all};
use cbpt_core::{Drive, Finding, InvalidInput, Load, Reducer, Status};
use rayon::prelude::*;

use super::{BLOCK_ROWS, Plan};
use crate::case::parameter::{ActsOn, Setting};
use crate::case::{Case, EffectEntry};

/// Names of how a row can end, by their codes.
pub const STATUSES: [&str; 9] = [
    "ok",
    "outside_small_displacements",
    "outside_table",
    "beyond_hold",
    "undercut",
    "indeterminate",
    "effect_not_finite",
    "not_converged",
    INVALID_INPUT,
];

/// Numbers that each may be, but not together; `Plan::reason` says which.
pub(super) const INVALID_INPUT: &str = "invalid_input";

/// Solved rows, column by column; NaN where a row has no solution.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Rows {
    /// The numbers of each axis in its unit; of words their places.
    pub axes: Vec<Vec<f64>>,
    /// Elastic angle at the output as the instrument shows it, rad.
    pub elastic_angle_rad: Vec<f64>,
    /// Part of the deceleration pair, rad.
    pub alpha_deceleration_rad: Vec<f64>,
    /// Part of the equal-speed pair that reaches the output, rad.
    pub alpha_equal_speed_rad: Vec<f64>,
    /// Largest scaled residual.
    pub residual: Vec<f64>,
    /// Preload at which the torque would just slip, N, where the status is `beyond_hold`.
    pub hold_preload_N: Vec<f64>,
    /// The further columns of the plan, in their order.
    pub costs: Vec<Vec<f64>>,
    /// Why the drive of a row cannot be built: 0 where it can, else one more than the place in [`UNBUILDABLE`]. Only where
    /// [`Plan::has_findings`].
    pub finding: Vec<u8>,
    /// Place of the status in [`STATUSES`].
    pub status: Vec<u8>,
}

impl Rows {
    fn set(&mut self, row: usize, outcome: &LoadOutcome) {
        let LoadOutcome { status, angle_rad, mesh } = outcome;
        let solved = status.has_solution();
        self.elastic_angle_rad[row] = if solved { *angle_rad } else { f64::NAN };
        if let Some(mesh) = mesh.filter(|_| solved) {
            self.alpha_deceleration_rad[row] = mesh.deceleration_rad;
            self.alpha_equal_speed_rad[row] = mesh.equal_speed_rad;
            self.residual[row] = mesh.residual;
        }
        if let Status::BeyondHold { hold_preload_N } = status {
            self.hold_preload_N[row] = *hold_preload_N;
        }
        self.status[row] = code(status.name());
    }
}

fn code(name: &str) -> u8 {
    let place = STATUSES.iter().position(|known| *known == name);
    // There are nine.
    #[allow(clippy::cast_possible_truncation)]
    place.map_or(u8::MAX, |place| place as u8)
}

/// As [`Rows::finding`] has it.
fn finding_code(found: Option<&Finding>) -> u8 {
    let place = found.map(|finding| UNBUILDABLE.iter().position(|known| *known == finding.code));
    // There are three.
    #[allow(clippy::cast_possible_truncation)]
    place.map_or(0, |place| place.map_or(u8::MAX, |place| place as u8 + 1))
}

/// The warning of a sweep whose one drive cannot be built: its rows have no column for it.
pub fn warn_unbuildable(case: &Case) -> Option<String> {
    let finding = case.drive()?.unbuildable()?;
    Some(format!(
        "warning: the drive of the case cannot be built ({}): {}; the sweep goes on all the same. Remedy: {}",
        finding.code, finding.message, finding.remedy
    ))
}

/// What is said of further columns where the case has effects, which they leave out.
pub fn note_bare_columns(case: &Case, columns: &[Cost]) -> Option<String> {
    if columns.is_empty() || case.effects.is_empty() {
        return None;
    }
    let names: Vec<&str> = columns.iter().map(|cost| cost.name()).collect();
    let ids: Vec<&str> = case.effects.iter().map(|effect| &*effect.id).collect();
    Some(format!(
        "note: {} are of the drive alone, without the effects of the case: {}",
        names.join(", "),
        ids.join(", ")
    ))
}

/// What a group of rows comes to: an outcome for each, and why their drive cannot be built.
#[derive(Default)]
struct Solved {
    outcomes: Vec<Option<LoadOutcome>>,
    /// The further columns of each row; empty where there are none.
    costs: Vec<Vec<f64>>,
    finding: u8,
}

impl Plan {
    /// The blocks that these rows touch, each as far as it is asked for.
    pub(super) fn blocks(&self, rows: &Range<u64>) -> Vec<Range<u64>> {
        let rows = rows.start..rows.end.min(self.rows());
        let first = rows.start / BLOCK_ROWS;
        (first..rows.end.div_ceil(BLOCK_ROWS))
            .map(|block| (block * BLOCK_ROWS).max(rows.start)..((block + 1) * BLOCK_ROWS).min(rows.end))
            .collect()
    }

    /// Solves these rows on the threads of the pool it is called in; `None` if it was cancelled.
    pub fn solve(&self, rows: &Range<u64>, progress: &Progress) -> Option<Rows> {
        let blocks: Option<Vec<Rows>> =
            self.blocks(rows).into_par_iter().map(|block| self.solve_block(&block, progress)).collect();
        let mut blocks = blocks?.into_iter();
        let mut all = blocks.next()?;
        for block in blocks {
            for (all, block) in all.axes.iter_mut().zip(block.axes) {
                all.extend(block);
            }
            all.elastic_angle_rad.extend(block.elastic_angle_rad);
            all.alpha_deceleration_rad.extend(block.alpha_deceleration_rad);
            all.alpha_equal_speed_rad.extend(block.alpha_equal_speed_rad);
            all.residual.extend(block.residual);
            all.hold_preload_N.extend(block.hold_preload_N);
            for (all, block) in all.costs.iter_mut().zip(block.costs) {
                all.extend(block);
            }
            all.finding.extend(block.finding);
            all.status.extend(block.status);
        }
        Some(all)
    }

    /// Solves rows of one block.
    pub(super) fn solve_block(&self, rows: &Range<u64>, progress: &Progress) -> Option<Rows> {
        let axes: Vec<Vec<f64>> =
            (0..self.axes().len()).map(|axis| self.column(axis, rows.clone())).collect();
        let count = usize::try_from(rows.end - rows.start).ok()?;
        let mut found = Rows {
            elastic_angle_rad: vec![f64::NAN; count],
            alpha_deceleration_rad: vec![f64::NAN; count],
            alpha_equal_speed_rad: vec![f64::NAN; count],
            residual: vec![f64::NAN; count],
            hold_preload_N: vec![f64::NAN; count],
            costs: vec![vec![f64::NAN; count]; self.columns().len()],
            finding: if self.has_findings() { vec![0; count] } else { Vec::new() },
            status: vec![code(INVALID_INPUT); count],
            axes,
        };
        let groups = self.groups(&found.axes, count);
        let solved: Vec<Solved> = groups
            .par_iter()
            .map(|group| {
                let cancelled = progress.is_cancelled();
                let solved = if cancelled { Solved::default() } else { self.solve_group(&found.axes, group) };
                progress.add(group.len());
                solved
            })
            .collect();
        for (group, solved) in groups.iter().zip(&solved) {
            for row in group.iter().filter(|_| solved.finding > 0) {
                found.finding[*row] = solved.finding;
            }
            for (row, costs) in group.iter().zip(&solved.costs) {
                for (column, cost) in found.costs.iter_mut().zip(costs) {
                    column[*row] = *cost;
                }
            }
            for (row, outcome) in group.iter().zip(&solved.outcomes) {
                if let Some(outcome) = outcome {
                    found.set(*row, outcome);
                }
            }
        }
        (!progress.is_cancelled()).then_some(found)
    }

    /// Rows that share reducer and effects.
    fn groups(&self, axes: &[Vec<f64>], count: usize) -> Vec<Vec<usize>> {
        let shared: Vec<&Vec<f64>> = self
            .axes()
            .iter()
            .zip(axes)
            .filter(|(axis, _)| axis.parameter.acts_on <= ActsOn::Effects)
            .map(|(_, numbers)| numbers)
            .collect();
        let key = |row: usize| shared.iter().map(move |numbers| numbers[row].to_bits());
        let mut order: Vec<usize> = (0..count).collect();
        order.sort_by(|&a, &b| key(a).cmp(key(b)));
        order.chunk_by(|&a, &b| key(a).eq(key(b))).map(<[usize]>::to_vec).collect()
    }

    /// Solves rows of one reducer with one set of effects; nothing where its numbers cannot be.
    fn solve_group(&self, axes: &[Vec<f64>], group: &[usize]) -> Solved {
        let settings = |row: usize| -> Vec<Setting<'_>> {
            self.axes().iter().zip(axes).map(|(axis, numbers)| axis.setting(numbers[row])).collect()
        };
        let Ok(reducer) = self.reducer(&settings(group[0])) else { return Solved::default() };
        let checked = reducer.ball_drive().filter(|_| self.has_findings());
        let finding = finding_code(checked.and_then(Drive::unbuildable).as_ref());
        let loads: Vec<Option<Load>> = group.iter().map(|&row| self.load(axes, row).ok()).collect();
        let whole: Vec<Load> = loads.iter().flatten().copied().collect();
        let progress = Progress::default();
        let outcomes = if let (Some(drive), true) = (reducer.ball_drive(), self.case().effects.is_empty()) {
            let rows = solve_all(drive, &whole, &progress);
            rows.map(|rows| rows.into_iter().map(LoadOutcome::of_mesh).collect())
        } else {
            let effects: Vec<Effect> = self.case().effects.iter().filter_map(EffectEntry::core).collect();
            let values = self.variants.numbers(&settings(group[0]));
            let effects = Effects { effects: &effects, values: &values };
            solve_loads(&reducer, effects, &whole, &progress).ok().flatten()
        };
        let Some(outcomes) = outcomes else { return Solved { finding, ..Solved::default() } };
        let mut outcomes = outcomes.into_iter();
        let outcomes = loads.iter().map(|load| load.and_then(|_| outcomes.next())).collect();
        Solved { outcomes, costs: self.costs(&reducer, &loads), finding }
    }

    /// The further columns of rows of one reducer.
    fn costs(&self, reducer: &Reducer, loads: &[Option<Load>]) -> Vec<Vec<f64>> {
        let Some(drive) = reducer.ball_drive().filter(|_| !self.columns().is_empty()) else {
            return Vec::new();
        };
        let rubbing = self.case().rubbing();
        let of = |load: &Option<Load>| drive.costs(load.as_ref()?, &rubbing, self.columns()).ok();
        loads.par_iter().map(|load| of(load).unwrap_or_default()).collect()
    }

    /// Why the numbers of a row contradict each other; `None` if they do not. The row is looked at anew, so that solving need
    /// not keep a sentence for each.
    pub fn reason(&self, row: u64) -> Option<InvalidInput> {
        let axes = self.row(row);
        let settings = self.settings(&axes);
        let effects: Vec<Effect> = self.case().effects.iter().filter_map(EffectEntry::core).collect();
        let values = self.variants.numbers(&settings);
        let effects = Effects { effects: &effects, values: &values };
        let solved = self.reducer(&settings).and_then(|reducer| {
            let load = self.load(&axes, 0)?;
            solve_loads(&reducer, effects, &[load], &Progress::default())
        });
        solved.err()
    }

    /// Why the drive of a row cannot be built; `None` where it can, or the row has none.
    pub fn finding(&self, row: u64) -> Option<Finding> {
        let reducer = self.reducer(&self.settings(&self.row(row))).ok()?;
        reducer.ball_drive()?.unbuildable()
    }

    /// What to know before: a range whose steps do not meet its end, that the one drive of all rows cannot be built, or that
    /// columns leave out the effects.
    pub fn remarks(&self) -> Vec<String> {
        let notes = self.notes.iter().map(|note| format!("note: {note}"));
        let one_drive = Some(self.case()).filter(|_| !self.has_findings());
        let bare = note_bare_columns(self.case(), self.columns());
        notes.chain(one_drive.and_then(warn_unbuildable)).chain(bare).collect()
    }

    /// Whether the drive varies, so that each row tells whether its own can be built.
    pub fn has_findings(&self) -> bool {
        self.case().drive().is_some() && self.varies_reducer()
    }

    fn varies_reducer(&self) -> bool {
        self.axes().iter().any(|axis| axis.parameter.acts_on == ActsOn::Reducer)
    }

    /// Each axis at one row.
    fn row(&self, row: u64) -> Vec<Vec<f64>> {
        (0..self.axes().len()).map(|axis| self.column(axis, row..row + 1)).collect()
    }

    fn settings(&self, axes: &[Vec<f64>]) -> Vec<Setting<'_>> {
        self.axes().iter().zip(axes).map(|(axis, numbers)| axis.setting(numbers[0])).collect()
    }

    fn reducer(&self, settings: &[Setting<'_>]) -> Result<Reducer, InvalidInput> {
        if self.varies_reducer() { self.variants.reducer(settings) } else { Ok(self.case().reducer.clone()) }
    }

    /// The load of a row.
    fn load(&self, axes: &[Vec<f64>], row: usize) -> Result<Load, InvalidInput> {
        let of_axis = |acts_on: ActsOn| {
            let axis = self.axes().iter().position(|axis| axis.parameter.acts_on == acts_on)?;
            Some(self.axes()[axis].parameter.to_si(axes[axis][row]))
        };
        let defaults = &self.case().load;
        // A plan without a torque is refused before.
        let torque = of_axis(ActsOn::Torque).or(defaults.torque_Nm).unwrap_or(f64::NAN);
        let angle = of_axis(ActsOn::InputAngle).or(defaults.input_angle_rad).unwrap_or(0.0);
        match of_axis(ActsOn::Preload).or(defaults.preload_N) {
            Some(preload) => Load::new(torque, preload, angle),
            None => Load::without_preload(torque, angle),
        }
    }
}
