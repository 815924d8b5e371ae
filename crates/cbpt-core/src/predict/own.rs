//! Effects on all rows at once, stage by stage: the user's own, so that a function of Python is called once and not row by
//! row, and those of the library that need the torques before.
//!
//! Ahead of the meshing points: what is added to the load, and angles in series that need no angle. Behind them: angles that
//! do, then those of the reading.

use crate::effect::dual::Dual;
use crate::effect::own::{AddsTo, At, OwnEffect, Variable};
use crate::effect::port::{Load, Row};
use crate::error::InvalidInput;

use super::added::Added;
use super::chain::Chain;
use super::rows::Rows;

/// Whether an effect waits for the angle of the meshing points.
fn waits(effect: &dyn OwnEffect) -> bool {
    effect.adds_to() == AddsTo::Reading || effect.uses(Variable::Angle)
}

impl Chain {
    /// What own effects, then the torques before, add ahead of the meshing points; `rest`: also in series under no torque,
    /// from which friction counts. Before its first reading a run has no torques. Without entries where nothing is added.
    pub fn ahead(&self, table: &Rows, rest: bool) -> Result<Vec<Added>, InvalidInput> {
        if self.own.is_empty() && !self.has_history() {
            return Ok(Vec::new());
        }
        let rows = table.by_run();
        let mut added = vec![Added::NOTHING; rows.len()];
        for (effect, own) in &self.own {
            let adds_to = effect.adds_to();
            if adds_to == AddsTo::Series && waits(&**effect) || adds_to == AddsTo::Reading {
                continue;
            }
            let loads = self.loads(rows, &added);
            let angles = vec![Dual::constant(f64::NAN); rows.len()];
            let values = self.values(&**effect, own, rows, &loads, &angles)?;
            for (added, value) in added.iter_mut().zip(values) {
                match adds_to {
                    AddsTo::Torque => added.torque_Nm += value,
                    AddsTo::Preload => added.preload_N += value,
                    AddsTo::Series | AddsTo::Reading => added.series_rad += value,
                }
            }
            if rest && adds_to == AddsTo::Series {
                let mut unloaded = loads;
                for load in &mut unloaded {
                    load.torque_Nm = Dual::constant(0.0);
                }
                let values = self.values(&**effect, own, rows, &unloaded, &angles)?;
                for (added, value) in added.iter_mut().zip(values) {
                    added.series_at_rest_rad += value;
                }
            }
        }
        if self.has_history() {
            let torque_Nm: Vec<Dual> =
                self.loads(rows, &added).into_iter().map(|load| load.torque_Nm).collect();
            for run in (0..table.runs()).map(|number| table.run(number)) {
                let angles = self.history(&rows[run.clone()], &torque_Nm[run.clone()]);
                for (added, angle) in added[run].iter_mut().zip(angles) {
                    added.series_rad += angle;
                }
            }
        }
        Ok(added.into_iter().map(Added::checked).collect())
    }

    /// What the instrument shows of total angles: own effects in series that wait for the angle, the library's of the
    /// reading, own ones of the reading.
    pub fn behind(
        &self,
        table: &Rows,
        added: &[Added],
        totals: Vec<Dual>,
    ) -> Result<Vec<Dual>, InvalidInput> {
        let rows = table.by_run();
        let mut angles = totals;
        let waiting = || self.own.iter().filter(|(effect, _)| waits(&**effect));
        let loads = if waiting().next().is_some() { self.loads(rows, added) } else { Vec::new() };
        for port in [AddsTo::Series, AddsTo::Reading] {
            if port == AddsTo::Reading {
                angles = self.readings(table, added, angles);
            }
            for (effect, own) in waiting().filter(|(effect, _)| effect.adds_to() == port) {
                let values = self.values(&**effect, own, rows, &loads, &angles)?;
                for (angle, value) in angles.iter_mut().zip(values) {
                    *angle += value;
                }
            }
        }
        Ok(angles)
    }

    /// The load of every row, with what own effects have added so far.
    fn loads(&self, rows: &[Row], added: &[Added]) -> Vec<Load> {
        rows.iter().enumerate().map(|(place, row)| self.load(row, Added::to(place, added))).collect()
    }

    fn values(
        &self,
        effect: &dyn OwnEffect,
        own: &[Dual],
        rows: &[Row],
        loads: &[Load],
        angles: &[Dual],
    ) -> Result<Vec<Dual>, InvalidInput> {
        let at = |((row, load), angle): ((_, &Load), &Dual)| At {
            row,
            drive: &self.drive,
            torque_Nm: load.torque_Nm,
            preload_N: load.preload_N,
            alpha_rad: *angle,
        };
        let at: Vec<At<'_>> = rows.iter().zip(loads).zip(angles).map(at).collect();
        let values = effect.values(own, &at)?;
        if values.len() == rows.len() {
            return Ok(values);
        }
        let rule = format!("must be one for each of the {} rows", rows.len());
        Err(InvalidInput::new(effect.id(), format!("{} values", values.len()), rule))
    }
}
