//! A reducer with effects on a table of readings: what an ideal instrument would show, row by row.
//!
//! - [`rows`]: the readings' columns, checked once; `turns`: where the torque turned back between readings;
//! - `chain`: the effects along one row, port by port; `own`: those of the user's own, on all rows at once; `added`: what
//!   these add to a row ahead of its meshing points;
//! - [`mesh`]: the pairs at one input angle under a load, and how their angle answers to each number;
//! - `spring`: a torsion spring in their place; `site`: either of the two;
//! - `run`: readings of a run one after the other, their angles and the sensitivities of these;
//! - `table`: all of them, and what is told;
//! - `friction`: the torque at the meshing points where friction makes a run a history;
//! - [`slots`]: effects of both kinds and their numbers; `check`: values that cannot be;
//! - [`loads`]: single loads instead of a table;
//! - here: [`Predictor`], which keeps meshing points and solutions from call to call, so that a fit pays for changes only.
//!
//! An answer does not depend on earlier calls beyond the tolerance of the equations, and after [`Predictor::cold`] not at all.

mod added;
mod chain;
mod check;
mod friction;
pub mod loads;
pub mod mesh;
mod own;
pub mod rows;
mod run;
mod site;
pub mod slots;
mod spring;
mod table;
mod turns;

use std::sync::Arc;

use rayon::prelude::*;

use crate::effect;
use crate::effect::dual::{Dual, WIDTH};
use crate::effect::port::{Action, Contact, DriveNumbers};
use crate::error::{InvalidInput, require};
use crate::geometry::undercut::undercuts;
use crate::reducer::Reducer;
use crate::status::Status;

use added::Added;
use chain::{Chain, Link};
pub use mesh::Regime;
use mesh::{Gap, Pairs, Tables, Wanted, shifted};
pub use rows::{Columns, History, Rows};
use run::RowState;
use site::{Carrier, Site};
pub use slots::{Effect, Number, Slot};
use spring::Spring;
use table::Call;
pub use turns::TorqueTurns;

/// A reducer with effects on a table of readings.
///
/// ```
/// use cbpt_core::Drive;
/// use cbpt_core::predict::{Columns, Predictor, Rows};
///
/// let rows = Rows::new(Columns {
///     run: &[1, 1, 1],
///     time_s: &[0.0, 10.0, 20.0],
///     torque_Nm: &[0.0, 5.0, 10.0],
///     preload_N: Some(&[600.0; 3]),
///     input_angle_rad: &[0.0; 3],
///     temperature_K: None,
///     cycle: None,
/// })?;
/// let mut predictor = Predictor::new(Drive::paper_base_case(), &["contact_stiffness"], rows)?;
/// // One value for each of `parameters()`, SI; here the scale of the contact stiffness. Its derivative is wanted as well.
/// let nominal = predictor.predict(&[1.0], &[])?;
/// let stiffer = predictor.predict(&[1.1], &[0])?;
/// assert!(stiffer.angle_rad[2] < nominal.angle_rad[2]);
/// assert!(stiffer.sensitivities[2] < 0.0); // rad for a unit of the scale, row by row
/// # Ok::<(), cbpt_core::InvalidInput>(())
/// ```
#[derive(Debug, Clone)]
pub struct Predictor {
    reducer: Reducer,
    numbers: DriveNumbers,
    effects: Vec<Effect>,
    /// Numbers of all effects, effect by effect.
    slots: Vec<Slot>,
    /// First slot of each effect.
    first_slots: Vec<usize>,
    /// Effects in the order in which they act.
    order: Vec<usize>,
    rows: Rows,
    /// Distinct input angles, rad, and which of them each row has.
    angles_rad: Vec<f64>,
    angle_of_row: Vec<usize>,
    tables: Vec<TablesAtShift>,
    gaps: Vec<GapsOfSlot>,
    states: Vec<RowState>,
}

/// Meshing points at all input angles, with all contact angles shifted.
#[derive(Debug, Clone)]
struct TablesAtShift {
    shift_rad: f64,
    with_slopes: bool,
    undercuts: bool,
    at_angle: Vec<Tables>,
}

/// Shapes at all input angles of a size of an effect on gaps.
#[derive(Debug, Clone)]
struct GapsOfSlot {
    slot: usize,
    /// The effect's numbers that are chosen, not fitted, for which they hold.
    chosen: Vec<f64>,
    at_angle: Vec<Gap>,
}

/// What an ideal instrument would show, in the order of the table.
#[derive(Debug, Clone, PartialEq)]
pub struct Prediction {
    /// Elastic angle as the instrument shows it, rad; NaN where there is no solution.
    pub angle_rad: Vec<f64>,
    /// How each row ended.
    pub status: Vec<Status>,
    /// Derivative of the angle by each of the wanted parameters, row by row; NaN where there is no solution.
    pub sensitivities: Vec<f64>,
    /// Diagonals that carry in one row of the deceleration and of the equal-speed pair; 0 where there is no solution.
    pub carrying: Vec<[usize; 2]>,
    /// Which contacts carry.
    pub regime: Vec<Option<Regime>>,
    /// Parts of the meshing points: of the deceleration pair, and what of the equal-speed pair reaches the output, rad;
    /// NaN where there is no solution.
    pub parts_rad: Vec<[f64; 2]>,
    /// Torque (N m) and preload (N) that reach the meshing points.
    pub mesh_load: Vec<[f64; 2]>,
    /// Largest scaled residual; NaN where there is no solution.
    pub residual: Vec<f64>,
}

/// A named part of the angle.
#[derive(Debug, Clone, PartialEq)]
pub struct Contribution {
    /// `model`, or the id of an effect; `id#2` where it is the second of its kind.
    pub name: String,
    /// Which of the predictor's effects; `None` for the model without effects.
    pub effect: Option<usize>,
    /// The part, rad, in the order of the table; NaN where there is no solution.
    pub angle_rad: Vec<f64>,
}

/// How many shifts of the contact angle are kept: that of the fit and none.
const KEPT_SHIFTS: usize = 2;
/// Readings from which threads are worth waking: fewer are predicted within a millisecond or two, and where the machine has
/// other work too, a thread that has to be waited for takes longer than that.
const WORTH_THREADS: usize = 2000;

/// Which of the angles each row has.
fn places_of_angles(rows: &Rows, angles_rad: &[f64]) -> Vec<usize> {
    let place = |angle: f64| angles_rad.partition_point(|known| known.total_cmp(&angle).is_lt());
    rows.by_run().iter().map(|row| place(row.input_angle_rad)).collect()
}

impl Predictor {
    /// A predictor of a reducer with the effects of these ids, on these rows. An id may stand more than once.
    ///
    /// # Errors
    /// [`InvalidInput`] for an id that is not in the library or that the reducer cannot have, and for rows without the
    /// preload that a ball drive needs.
    pub fn new(
        reducer: impl Into<Reducer>,
        effects: &[impl AsRef<str>],
        rows: Rows,
    ) -> Result<Self, InvalidInput> {
        let known = effects.iter().enumerate().map(|(i, id)| slots::known(i, id.as_ref()));
        Self::of(reducer, known.map(|spec| spec.map(Effect::Library)).collect::<Result<_, _>>()?, rows)
    }

    /// The same with effects of the user's own among them.
    ///
    /// # Errors
    /// As [`Self::new`]; and for an own effect that has the id of one of the library, or that needs a temperature where
    /// none was read.
    pub fn of(reducer: impl Into<Reducer>, found: Vec<Effect>, rows: Rows) -> Result<Self, InvalidInput> {
        let reducer = reducer.into();
        let has_it = rows.has_preload() || reducer.torsion_spring().is_some();
        require(has_it, "preload_N", "nothing", "a ball drive needs a preload above 0 at every reading")?;
        for (place, effect) in found.iter().enumerate() {
            check::suited(&reducer, place, effect, &rows)?;
        }
        let mut slots = Vec::new();
        let mut first_slots = Vec::new();
        for (effect, what) in found.iter().enumerate() {
            first_slots.push(slots.len());
            slots.extend(what.numbers().into_iter().map(|parameter| Slot { effect, parameter }));
        }
        let mut order: Vec<usize> = (0..found.len()).collect();
        // What the library does not hold comes after it.
        let place = |id: &str| effect::LIBRARY.iter().position(|spec| spec.id == id).unwrap_or(usize::MAX);
        order.sort_by_key(|&i| (found[i].port(), place(found[i].id())));
        let mut angles_rad: Vec<f64> = rows.by_run().iter().map(|row| row.input_angle_rad).collect();
        angles_rad.sort_by(f64::total_cmp);
        angles_rad.dedup_by_key(|angle| angle.to_bits());
        let angle_of_row = places_of_angles(&rows, &angles_rad);
        let numbers = match &reducer {
            Reducer::BallDrive(drive) => DriveNumbers {
                pitch_arm_m: f64::from(drive.deceleration().output_lobes())
                    * drive.deceleration().eccentricity_m(),
                planet_turn: drive.planet_turn(),
            },
            // Without a radius no effect asks for it.
            Reducer::TorsionSpring(spring) => DriveNumbers {
                pitch_arm_m: spring.reference_radius_m().unwrap_or(f64::INFINITY),
                planet_turn: 0.0,
            },
        };
        let states = vec![RowState::default(); rows.by_run().len()];
        Ok(Self {
            reducer,
            numbers,
            effects: found,
            slots,
            first_slots,
            order,
            rows,
            angles_rad,
            angle_of_row,
            tables: Vec::new(),
            gaps: Vec::new(),
            states,
        })
    }

    /// The effects, in the order given.
    pub fn effects(&self) -> &[Effect] {
        &self.effects
    }

    /// The numbers of all effects, in the order of `values`.
    pub fn parameters(&self) -> &[Slot] {
        &self.slots
    }

    /// The readings.
    pub fn rows(&self) -> &Rows {
        &self.rows
    }

    /// Values at which every effect of the library vanishes; own effects have theirs.
    pub fn neutral(&self) -> Vec<f64> {
        self.slots.iter().map(|slot| slot.parameter.neutral()).collect()
    }

    /// From now on runs have another history.
    pub fn take_history(&mut self, history: History) {
        self.rows = self.rows.with_history(history);
        self.angle_of_row = places_of_angles(&self.rows, &self.angles_rad);
        self.states = vec![RowState::default(); self.rows.by_run().len()];
    }

    /// Forgets the solutions of earlier calls: what follows is to the last bit what a new predictor would say. Meshing points
    /// and shapes of gaps stay; they are the same whatever was asked.
    pub fn cold(&mut self) {
        self.states.fill(RowState::default());
    }

    /// Predicts all rows, and the derivatives by the `wanted` parameters.
    ///
    /// # Errors
    /// [`InvalidInput`] for a value that cannot be, and for a wanted parameter that is chosen, not fitted.
    pub fn predict(&mut self, values: &[f64], wanted: &[usize]) -> Result<Prediction, InvalidInput> {
        self.predict_with(values, wanted, &|_| true)
    }

    /// The same with those effects only that are switched `on`.
    fn predict_with(
        &mut self,
        values: &[f64],
        wanted: &[usize],
        on: &dyn Fn(usize) -> bool,
    ) -> Result<Prediction, InvalidInput> {
        self.check_values(values)?;
        self.check_wanted(wanted)?;
        let contact = self.contact(values, on);
        let shift_rad = contact.contact_angle_shift_rad.value;
        let asked = self.asked(wanted);
        let at_shift = self.tables_at(shift_rad, asked.is_some_and(|asked| asked.contact_angle))?;
        if self.tables[at_shift].undercuts {
            return Ok(self.nowhere(Status::Undercut, wanted.len()));
        }
        let gap_slots = self.gap_slots(values, wanted, on);
        self.renew_gaps(values, &gap_slots);
        let chain = self.chain(values, first_of(wanted), on);
        let call = Call { values, wanted, on, asked, chain, contact, gap_slots, at_shift };
        // Kept whatever becomes of the call: they are solutions even where an own effect fails behind them. They are there
        // again where a call before this one was unwound.
        let mut states = std::mem::take(&mut self.states);
        states.resize(self.rows.by_run().len(), RowState::default());
        let found = self.predicted(&call, &mut states);
        self.states = states;
        found
    }

    /// The named parts of the angle: the model without effects, then what each effect adds as they are switched on in the
    /// order of the ports. They add up to the angle.
    ///
    /// # Errors
    /// As [`Self::predict`].
    pub fn contributions(&mut self, values: &[f64]) -> Result<Vec<Contribution>, InvalidInput> {
        self.check_values(values)?;
        let mut on = vec![false; self.effects.len()];
        let mut before = self.predict_with(values, &[], &|_| false)?.angle_rad;
        let mut parts =
            vec![Contribution { name: "model".to_owned(), effect: None, angle_rad: before.clone() }];
        for effect in self.order.clone() {
            on[effect] = true;
            let after = self.predict_with(values, &[], &|effect| on[effect])?.angle_rad;
            let angle_rad = after.iter().zip(&before).map(|(after, before)| after - before).collect();
            parts.push(Contribution { name: self.name(effect), effect: Some(effect), angle_rad });
            before = after;
        }
        Ok(parts)
    }

    /// The id of an effect, with its number where it is not the first of its kind.
    pub fn name(&self, effect: usize) -> String {
        let id = self.effects[effect].id();
        let before = self.effects[..effect].iter().filter(|other| other.id() == id).count();
        if before == 0 { id.to_owned() } else { format!("{id}#{}", before + 1) }
    }

    fn own_slots(&self, effect: usize) -> std::ops::Range<usize> {
        let first = self.first_slots[effect];
        first..self.first_slots.get(effect + 1).copied().unwrap_or(self.slots.len())
    }

    /// The effects that are on and do something at these values, or whose numbers are seeded.
    fn chain(&self, values: &[f64], seeds: &[usize], on: &dyn Fn(usize) -> bool) -> Chain {
        let acts = |effect: usize| {
            self.own_slots(effect).any(|slot| self.is_sized(values, slot) || seeds.contains(&slot))
        };
        let (mut links, mut own) = (Vec::new(), Vec::new());
        for &effect in self.order.iter().filter(|effect| on(**effect)) {
            let numbers =
                || -> Vec<Dual> { self.own_slots(effect).map(|slot| seeded(values, seeds, slot)).collect() };
            match &self.effects[effect] {
                Effect::Library(spec) if acts(effect) => {
                    links.push(Link::new(spec, numbers(), &self.rows));
                }
                Effect::Library(_) => {}
                Effect::Own(formula) => own.push((Arc::clone(formula), numbers())),
            }
        }
        Chain { links, own, drive: self.numbers }
    }

    /// What the contacts become by the effects that do something: shapes of others are no matter, even where their sensitivity
    /// is wanted.
    fn contact(&self, values: &[f64], on: &dyn Fn(usize) -> bool) -> Contact {
        let mut contact = Contact::unchanged();
        for &effect in self.order.iter().filter(|effect| on(**effect)) {
            let Some(Action::Contact(act)) = self.effects[effect].action() else { continue };
            let own = self.own_slots(effect);
            if own.clone().any(|slot| self.is_sized(values, slot)) {
                let numbers: Vec<Dual> = own.map(|slot| Dual::constant(values[slot])).collect();
                act(&numbers, &mut contact);
            }
        }
        contact
    }

    /// Whether a number is a size that is not neutral.
    fn is_sized(&self, values: &[f64], slot: usize) -> bool {
        let parameter = &self.slots[slot].parameter;
        #[allow(clippy::float_cmp)] // neutral is neutral to the last bit
        let sized = parameter.is_size() && values[slot] != parameter.neutral();
        sized
    }

    /// Whether rows of a run depend on each other: friction acts, or its sensitivity is wanted.
    fn remembers(&self, chain: &Chain, wanted: &[usize]) -> bool {
        let acts = || self.rows.by_run().first().map(|row| chain.load(row, &Added::NOTHING));
        let rubs = chain.friction().next().is_some() || acts().is_some_and(|load| !load.friction.is_empty());
        rubs || wanted.iter().any(|slot| effect::RUBS.contains(&self.effects[self.slots[*slot].effect].id()))
    }

    /// Which answers of the meshing points the wanted parameters need.
    fn asked(&self, wanted: &[usize]) -> Option<Wanted> {
        let of = |id: &str| wanted.iter().any(|slot| self.effects[self.slots[*slot].effect].id() == id);
        (!wanted.is_empty()).then(|| Wanted {
            stiffness: of(effect::contact_stiffness::SPEC.id),
            exponent: of(effect::rough_contact::SPEC.id),
            contact_angle: of(effect::contact_angle::SPEC.id),
            spring: of(effect::preload_spring::SPEC.id),
        })
    }

    /// Place in `self.tables` of those at a shift, which are made where they are missing.
    fn tables_at(&mut self, shift_rad: f64, with_slopes: bool) -> Result<usize, InvalidInput> {
        let here = |tables: &TablesAtShift| tables.shift_rad.to_bits() == shift_rad.to_bits();
        let found = self.tables.iter().position(here);
        if let Some(place) = found {
            if self.tables[place].with_slopes || !with_slopes {
                return Ok(place);
            }
            self.tables.remove(place);
        }
        let (mut undercut, mut at_angle) = (false, Vec::new());
        if let Reducer::BallDrive(nominal) = &self.reducer {
            let drive = if shift_rad == 0.0 { nominal.clone() } else { shifted(nominal, shift_rad)? };
            undercut = undercuts(&drive);
            if !undercut {
                let at = |&angle: &f64| Tables::new(&drive, angle, with_slopes);
                at_angle = self.spread(self.angles_rad.iter().collect(), at);
            }
        }
        if self.tables.len() == KEPT_SHIFTS {
            let oldest = self.tables.iter().position(|tables| tables.shift_rad != 0.0).unwrap_or(0);
            self.tables.remove(oldest);
        }
        self.tables.push(TablesAtShift { shift_rad, with_slopes, undercuts: undercut, at_angle });
        Ok(self.tables.len() - 1)
    }

    /// Sizes of effects on gaps that are not neutral or wanted.
    fn gap_slots(&self, values: &[f64], wanted: &[usize], on: &dyn Fn(usize) -> bool) -> Vec<usize> {
        let gap = |slot: &Slot| {
            on(slot.effect)
                && slot.parameter.is_size()
                && matches!(self.effects[slot.effect].action(), Some(Action::Gap(_)))
        };
        let slots = self.slots.iter().enumerate().filter(|(_, slot)| gap(slot)).map(|(place, _)| place);
        slots.filter(|place| values[*place] != 0.0 || wanted.contains(place)).collect()
    }

    /// Makes the shapes that are missing or belong to other chosen numbers.
    fn renew_gaps(&mut self, values: &[f64], slots: &[usize]) {
        for &slot in slots {
            let effect = self.slots[slot].effect;
            let own = self.own_slots(effect);
            let chosen = values[own.clone()].to_vec();
            let fixed = |values: &[f64]| -> Vec<f64> {
                let slots = self.slots[own.clone()].iter().zip(values);
                slots.filter(|(slot, _)| !slot.parameter.is_size()).map(|(_, value)| *value).collect()
            };
            let known = self.gaps.iter().position(|gaps| gaps.slot == slot);
            if known.is_some_and(|place| self.gaps[place].chosen == fixed(&chosen)) {
                continue;
            }
            let Some(Action::Gap(shape)) = self.effects[effect].action() else { continue };
            let size = slot - own.start;
            let gap = |ball: &effect::port::Ball| shape(&chosen, size, ball);
            let Some(drive) = self.reducer.ball_drive() else { continue };
            let at = |angle: &f64| Gap { shapes: Tables::gap_shapes(drive, *angle, &gap) };
            let at_angle = self.spread(self.angles_rad.iter().collect(), at);
            let made = GapsOfSlot { slot, chosen: fixed(&chosen), at_angle };
            match known {
                Some(place) => self.gaps[place] = made,
                None => self.gaps.push(made),
            }
        }
    }

    /// The axial spring is one number for all rows.
    fn spring(&self, chain: &Chain) -> f64 {
        self.rows.by_run().first().map_or(0.0, |row| chain.load(row, &Added::NOTHING).spring_N_per_m.value)
    }

    fn sites<'t>(&'t self, tables: &'t [Tables], call: &Call<'_>) -> Vec<Site<'t>> {
        let Call { chain, contact, values, gap_slots, wanted, .. } = call;
        if let Reducer::TorsionSpring(curve) = &self.reducer {
            let spring = Carrier::Spring(Spring::new(curve, contact));
            return vec![Site::new(spring, contact); self.angles_rad.len()];
        }
        let spring_N_per_m = self.spring(chain);
        let gaps_of = |slot: usize| self.gaps.iter().find(|gaps| gaps.slot == slot);
        self.spread(tables.iter().enumerate().collect(), |(angle, tables)| {
            let gap = |&slot: &usize| Some((slot, &gaps_of(slot)?.at_angle[angle]));
            let all: Vec<(usize, &Gap)> = gap_slots.iter().filter_map(gap).collect();
            let valued: Vec<(f64, &Gap)> = all.iter().map(|(slot, gap)| (values[*slot], *gap)).collect();
            let asked: Vec<&Gap> =
                all.iter().filter(|(slot, _)| wanted.contains(slot)).map(|(_, gap)| *gap).collect();
            let pairs = Pairs::new(tables, contact, spring_N_per_m, &valued, &asked);
            Site::new(Carrier::Pairs(pairs), contact)
        })
    }

    /// What becomes of each of some parts of the work, on all threads where that is worth it.
    fn spread<T: Send, R: Send>(&self, parts: Vec<T>, of: impl Fn(T) -> R + Send + Sync) -> Vec<R> {
        if self.rows.len() < WORTH_THREADS {
            parts.into_iter().map(of).collect()
        } else {
            parts.into_par_iter().map(of).collect()
        }
    }
}

/// The wanted parameters that are carried along with the values.
fn first_of(wanted: &[usize]) -> &[usize] {
    wanted.chunks(WIDTH).next().unwrap_or_default()
}

/// A number, seeded where it is one of the block.
fn seeded(values: &[f64], seeds: &[usize], slot: usize) -> Dual {
    match seeds.iter().position(|seed| *seed == slot) {
        Some(place) => Dual::parameter(values[slot], place),
        None => Dual::constant(values[slot]),
    }
}
