//! How the three preload thresholds of a pair answer to the design numbers.
//!
//! Hold rests on one contact, zero backlash on the contact that parts first, and each on the phase where it is worst over
//! a period. Where one contact and one phase decide, the derivative is theirs: the phase is a maximum, so its own move does
//! not count. Hold is worst where two contacts hold alike, one more and one less as the phase moves on; there
//! the threshold's derivative is the mean of theirs that does not depend on the phase (the envelope of a maximum of minima).
//! Where contacts that decide alike answer differently, the first is told and marked as tied.

use crate::effect::dual::{Dual, WIDTH};
use crate::pair::MeshingPoints;
use crate::preload::Row;

use super::{PHASE, SHIFT, Sensitivity};

/// Contacts whose numbers agree to this part decide alike.
const ALIKE: f64 = 1e-8;
/// A number that changes by more than this part of the threshold over a radian of the phase has no smooth maximum there.
const SLOPING: f64 = 1e-4;
/// Partials that differ by more than this part of the largest are not the same.
const DIFFERENT: f64 = 1e-6;

/// One threshold (0: hold, 1: continuous, 2: zero backlash) per torque (1/m) of the rows of a pair at its worst phase;
/// `None` where no preload does it.
pub fn decided(rows: &[(MeshingPoints, Row<Dual>)], kind: usize) -> Option<Sensitivity> {
    let mut found = Vec::new();
    for (points, row) in rows {
        let deciding = per_torque(points, row, kind);
        if deciding.is_empty() {
            return None;
        }
        found.extend(deciding);
    }
    let deciding: Vec<Dual> = alike(found.into_iter().enumerate()).into_iter().map(|(_, one)| one).collect();
    smooth(&deciding)
}

/// A threshold per torque of a row, one for each contact that decides alike; none where no preload does it.
fn per_torque(points: &MeshingPoints, row: &Row<Dual>, kind: usize) -> Vec<Dual> {
    let plain = Row::new(points, row.torque_sign);
    match kind {
        0 => holding_arms(row).into_iter().filter(|arm| arm.value > 0.0).map(|arm| arm.recip()).collect(),
        1 => {
            let shift = plain.balanced_shift_m(&|_| 0.0);
            ray(row, shift, |_| Dual::constant(0.0)).into_iter().collect()
        }
        _ => {
            let shift = plain.balanced_shift_m(&|shift| plain.touching_ratio(shift));
            let deciding = alike(row.parting_ratios_m(Dual::constant(shift)).enumerate());
            let state =
                |(index, _)| ray(row, shift, |shift| row.parting_ratios_m(shift).nth(index).unwrap_or(shift));
            deciding.into_iter().filter_map(state).collect()
        }
    }
}

fn holding_arms(row: &Row<Dual>) -> Vec<Dual> {
    let best = |sign| alike(row.torques_per_preload_m(sign).enumerate()).into_iter().map(|(_, arm)| arm);
    if !row.floats_sideways {
        return best(None).collect();
    }
    let minus: Vec<Dual> = best(Some(-1.0)).collect();
    best(Some(1.0)).flat_map(|plus| minus.iter().map(move |minus| (plus + *minus) * 0.5)).collect()
}

/// The largest, and what is as good as it.
fn alike(found: impl Iterator<Item = (usize, Dual)>) -> Vec<(usize, Dual)> {
    let found: Vec<(usize, Dual)> = found.collect();
    let size = found.iter().map(|(_, number)| number.value.abs()).fold(0.0, f64::max);
    let most = found.iter().map(|(_, number)| number.value).fold(f64::NEG_INFINITY, f64::max);
    found.into_iter().filter(|(_, number)| number.value >= most - ALIKE * size).collect()
}

/// N_Z/|M0| of the state with approach per rotation `ratio(shift)`, the plate in balance at `shift_m`; `None` where that
/// state carries no torque.
fn ray(row: &Row<Dual>, shift_m: f64, ratio: impl Fn(Dual) -> Dual) -> Option<Dual> {
    let mut shift = Dual::constant(shift_m);
    if row.floats_sideways {
        // The shift answers so that the balance across the grooves stays.
        let open = Dual::parameter(shift_m, SHIFT);
        let [.., sideways] = row.sums(ratio(open), open);
        let slope = sideways.partials[SHIFT];
        if slope != 0.0 {
            shift = sideways.chain(shift_m, -1.0 / slope);
        }
        shift.partials[SHIFT] = 0.0;
    }
    let [axial, torque, _] = row.sums(ratio(shift), shift);
    (torque.value > 0.0).then(|| axial * torque.recip())
}

/// A threshold from the contacts that decide alike, at their worst phase.
fn smooth(deciding: &[Dual]) -> Option<Sensitivity> {
    let most = deciding.iter().map(|number| number.value).fold(f64::NEG_INFINITY, f64::max);
    let slope = |number: &&Dual| number.partials[PHASE];
    let steep = |number: &&Dual| slope(number).abs() > SLOPING * most.abs();
    let (rising, falling): (Vec<&Dual>, Vec<&Dual>) =
        deciding.iter().filter(steep).partition(|number| slope(number) > 0.0);
    let mean = |up: &Dual, down: &Dual| {
        let weight = slope(&down) / (slope(&down) - slope(&up));
        *up * weight + *down * (1.0 - weight)
    };
    let mut branches: Vec<Dual> =
        rising.iter().flat_map(|up| falling.iter().map(move |down| mean(up, down))).collect();
    if branches.is_empty() {
        branches = deciding.to_vec();
    }
    let first = *branches.first()?;
    Some(Sensitivity::of(first, |slot| {
        let partials = || branches.iter().map(|branch| branch.partials[slot]);
        let size = partials().map(f64::abs).fold(0.0, f64::max);
        partials().any(|partial| (partial - first.partials[slot]).abs() > DIFFERENT * size)
    }))
}

/// Of two thresholds the larger; where they are alike, a number to which they answer differently is tied.
pub fn larger(a: &Sensitivity, b: &Sensitivity) -> Sensitivity {
    let mut larger = if a.value >= b.value { a.clone() } else { b.clone() };
    if (a.value - b.value).abs() <= ALIKE * a.value.abs() {
        for (slot, tied) in larger.tied.iter_mut().enumerate() {
            let (one, other) = (a.slopes[slot], b.slopes[slot]);
            *tied |= (one - other).abs() > DIFFERENT * one.abs().max(other.abs());
        }
    }
    larger
}

const _: () = assert!(PHASE < WIDTH && SHIFT < WIDTH);
