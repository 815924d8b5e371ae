//! Single loads with effects: many on all cores, and one with every meshing point.
//!
//! Each load is a run of one reading at time 0 and at the temperature of the start, loaded from rest; so what needs time
//! or a change of temperature adds nothing.

use super::mesh::{Tables, shifted};
use super::spring::Spring;
use super::{Contribution, Effect, Predictor, Rows};
use crate::drive::{Drive, Load};
use crate::effect::port::{Action, Ball};
use crate::error::InvalidInput;
use crate::geometry::undercut::undercuts;
use crate::pair::MeshingPoints;
use crate::reducer::Reducer;
use crate::status::Status;
use crate::sweep::{Progress, Row};
use crate::transmission::{Angles, DrivePoints, Solution};

/// Loads that are predicted together.
const BATCH: usize = 2048;

/// Effects with their numbers.
#[derive(Debug, Clone, Copy)]
pub struct Effects<'a> {
    /// Of the library, one as often as wanted, and of the user's own.
    pub effects: &'a [Effect],
    /// The numbers of all of them, in the order of [`Predictor::parameters`].
    pub values: &'a [f64],
}

/// One load's outcome.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LoadOutcome {
    /// How it ended.
    pub status: Status,
    /// Angle as the instrument shows it, rad; NaN where there is no solution.
    pub angle_rad: f64,
    /// Of the meshing points alone; `None` where there is no solution.
    pub mesh: Option<Angles>,
}

impl LoadOutcome {
    /// Without effects the instrument shows the meshing points' angle.
    pub fn of_mesh((status, mesh): Row) -> Self {
        let angle_rad = mesh.map_or(f64::NAN, |angles| angles.elastic_angle_rad());
        Self { status, angle_rad, mesh }
    }
}

/// A load in full.
#[derive(Debug, Clone, PartialEq)]
pub struct LoadDetail {
    /// The pairs, with the torque and preload that reach them; its load is the one asked for.
    pub solution: Solution,
    /// The meshing points as the effects make them; `None` of a torsion spring and where there is no solution.
    pub points: Option<DrivePoints>,
    /// Angle as the instrument shows it, rad; `None` where there is no solution.
    pub angle_rad: Option<f64>,
    /// Torque (N m) and preload (N) that reach the meshing points.
    pub mesh_load: [f64; 2],
    /// Named parts of the angle, one number each.
    pub contributions: Vec<Contribution>,
}

/// Predicts every load, in their order; `None` if it was cancelled.
///
/// # Errors
/// [`InvalidInput`] for an id or a value that cannot be.
pub fn solve_loads(
    reducer: impl Into<Reducer>,
    effects: Effects<'_>,
    loads: &[Load],
    progress: &Progress,
) -> Result<Option<Vec<LoadOutcome>>, InvalidInput> {
    let reducer = reducer.into();
    let mut outcomes = Vec::with_capacity(loads.len());
    for batch in loads.chunks(BATCH) {
        if progress.is_cancelled() {
            return Ok(None);
        }
        let rows = Rows::of_loads(batch);
        let mut predictor = Predictor::of(reducer.clone(), effects.effects.to_vec(), rows)?;
        let found = predictor.predict(effects.values, &[])?;
        for (row, status) in found.status.iter().enumerate() {
            let [deceleration_rad, equal_speed_rad] = found.parts_rad[row];
            let angles =
                Angles { deceleration_rad, equal_speed_rad, residual: found.residual[row], steps: 0 };
            outcomes.push(LoadOutcome {
                status: *status,
                angle_rad: found.angle_rad[row],
                mesh: status.has_solution().then_some(angles),
            });
        }
        progress.add(batch.len());
    }
    Ok(Some(outcomes))
}

/// Predicts one load, with every meshing point.
///
/// # Errors
/// [`InvalidInput`] for an id or a value that cannot be.
pub fn solve_load(
    reducer: impl Into<Reducer>,
    effects: Effects<'_>,
    load: &Load,
) -> Result<LoadDetail, InvalidInput> {
    let mut predictor = Predictor::of(reducer, effects.effects.to_vec(), Rows::of_loads(&[*load]))?;
    let contributions = predictor.contributions(effects.values)?;
    let found = predictor.predict(effects.values, &[])?;
    let mesh_load = found.mesh_load[0];
    let (solution, points) = if found.status[0].has_solution() {
        predictor.meshing(effects.values, load, mesh_load)?
    } else {
        (Solution::none(found.status[0], *load), None)
    };
    Ok(LoadDetail {
        points,
        angle_rad: solution.angles.map(|_| found.angle_rad[0]),
        solution,
        mesh_load,
        contributions,
    })
}

/// A torsion spring under the torque that it carries.
fn twisted(spring: &Spring<'_>, load: &Load, torque_Nm: f64) -> Solution {
    let mesh = spring.solve(torque_Nm);
    let [deceleration_rad, equal_speed_rad] = mesh.parts_rad;
    Solution {
        status: mesh.status,
        load: *load,
        angles: Some(Angles { deceleration_rad, equal_speed_rad, residual: mesh.residual, steps: 0 }),
        deceleration: None,
        equal_speed: None,
        torsional_stiffness_Nm_per_rad: Some(1.0 / mesh.by_torque()),
    }
}

impl Predictor {
    /// Pairs or spring as the effects make them, under the torque and preload that reach them.
    fn meshing(
        &self,
        values: &[f64],
        load: &Load,
        mesh_load: [f64; 2],
    ) -> Result<(Solution, Option<DrivePoints>), InvalidInput> {
        let contact = self.chain(values, &[], &|_| true).contact();
        match &self.reducer {
            Reducer::TorsionSpring(curve) => {
                Ok((twisted(&Spring::new(curve, &contact), load, mesh_load[0]), None))
            }
            Reducer::BallDrive(drive) => {
                let at_mesh = Load::new(mesh_load[0], mesh_load[1], load.input_angle_rad())?;
                let points = self.pairs(drive, values, &at_mesh)?;
                let solution = match &points {
                    Some(points) => points.solution(&at_mesh),
                    None => Solution::none(Status::Undercut, at_mesh),
                };
                Ok((Solution { load: *load, ..solution }, points))
            }
        }
    }

    /// The pairs with contacts and gaps as the effects make them at the angle of a load; `None` where they undercut.
    fn pairs(
        &self,
        nominal: &Drive,
        values: &[f64],
        at_mesh: &Load,
    ) -> Result<Option<DrivePoints>, InvalidInput> {
        let chain = self.chain(values, &[], &|_| true);
        let contact = chain.contact();
        let shift_rad = contact.contact_angle_shift_rad.value;
        let drive = if shift_rad == 0.0 { nominal.clone() } else { shifted(nominal, shift_rad)? };
        if undercuts(&drive) {
            return Ok(None);
        }
        let angle_rad = at_mesh.input_angle_rad();
        let mut points = drive.points(angle_rad);
        let spring = self.spring(&chain);
        let change = |pair: &mut MeshingPoints, number: usize| {
            pair.exponent = contact.exponent.value;
            pair.axial_spring_N_per_m = spring;
            for point in &mut pair.points {
                point.stiffness *= contact.stiffness_scale.value;
            }
            for slot in self.gap_slots(values, &[], &|_| true) {
                let effect = self.slots[slot].effect;
                let own = self.own_slots(effect);
                let Some(Action::Gap(shape)) = self.effects[effect].action() else { continue };
                let gap = |ball: &Ball| shape(&values[own.clone()], slot - own.start, ball);
                let shapes = Tables::gap_shapes(nominal, angle_rad, &gap);
                for (point, [axial, normal, in_plane]) in pair.points.iter_mut().zip(&shapes[number]) {
                    point.axial_offset_m += values[slot] * axial;
                    point.normal_offset_m += values[slot] * normal;
                    point.in_plane_offset_m += values[slot] * in_plane;
                }
            }
        };
        change(&mut points.deceleration, 0);
        for (number, row) in points.equal_speed.iter_mut().enumerate() {
            change(row, number + 1);
        }
        Ok(Some(points))
    }
}
