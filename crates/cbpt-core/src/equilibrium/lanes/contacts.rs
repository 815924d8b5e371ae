//! The sums over the contacts of any pair under one load, with a contact a lane: those of its equations (see the parent's
//! parent), and those of how their solution answers (see [`response`]).
//!
//! Hertz's law needs a square root, which every width has; another exponent a power, which only a single number has: there
//! the same sums run in lanes of one. Everything here is in SI units. A place that no contact fills has no stiffness.
//!
//! [`response`]: crate::equilibrium::response

use pulp::{Arch, Scalar, Simd, WithSimd};

use super::kernel::{about_pivot, along};
use crate::equilibrium::{ContactLaw, Levers, State};
use crate::pair::REFERENCE_DEFORMATION_M;

/// Contacts in one go: a whole number of vectors of any width.
pub(super) const BLOCK: usize = 8;

/// Blocks whose contacts' parts in the answers are held at a time.
const HELD: usize = 8;

/// A number of each contact of a pair, by their places in its blocks; 0 where there is none.
pub type ByContact = Vec<[f64; BLOCK]>;

/// Numbers to the places of the contacts.
pub(in crate::equilibrium) fn by_contact(numbers: impl ExactSizeIterator<Item = f64>) -> ByContact {
    let mut places = vec![[0.0; BLOCK]; numbers.len().div_ceil(BLOCK)];
    for (place, number) in numbers.enumerate() {
        places[place / BLOCK][place % BLOCK] = number;
    }
    places
}

#[derive(Debug, Clone, Copy, Default)]
struct Block {
    /// With the rotation about the axis.
    levers: [[f64; BLOCK]; 3],
    offset_m: [f64; BLOCK],
    stiffness: [f64; BLOCK],
}

/// What the contact angle changes of a block, per rad.
#[derive(Debug, Clone, Copy, Default)]
struct Turn {
    levers: [[f64; BLOCK]; 3],
    offset_m: [f64; BLOCK],
}

/// The contacts of a pair side by side.
#[derive(Debug, Clone)]
pub struct Contacts {
    law: ContactLaw,
    blocks: Vec<Block>,
    turns: Vec<Turn>,
}

/// Sums of the equations.
pub(in crate::equilibrium) struct Sums<const N: usize> {
    /// Of N delta, N m.
    pub work: f64,
    /// Of N l.
    pub forces: [f64; N],
    /// Lower triangle of the sum of (dN/d delta) l l^T.
    pub slopes: [[f64; N]; N],
}

/// What of the answers is wanted beside that to the stiffness.
#[derive(Debug, Clone, Copy)]
pub(in crate::equilibrium) struct Wanted<'a> {
    /// d ln k / d beta, 1/rad.
    pub stiffness_slopes_per_rad: Option<&'a [[f64; BLOCK]]>,
    pub exponent: bool,
    /// What shapes of gaps add to the deformations.
    pub gaps: &'a [ByContact],
}

/// Sums of the answers but for those to gaps.
#[derive(Debug, Clone, Copy, Default)]
pub(in crate::equilibrium) struct Answers {
    pub log_stiffness: f64,
    pub contact_angle: f64,
    pub exponent: f64,
}

impl Contacts {
    pub(in crate::equilibrium) fn new(levers: &[Levers], law: ContactLaw) -> Self {
        let count = levers.len().div_ceil(BLOCK);
        let (mut blocks, mut turns) = (vec![Block::default(); count], vec![Turn::default(); count]);
        for (number, levers) in levers.iter().enumerate() {
            let (block, turn, place) =
                (&mut blocks[number / BLOCK], &mut turns[number / BLOCK], number % BLOCK);
            let turned = levers.per_contact_angle(0.0);
            for (i, lever) in levers.per_unknown(0.0).into_iter().enumerate() {
                (block.levers[i][place], turn.levers[i][place]) = (lever, turned[i]);
            }
            block.offset_m[place] = levers.offset_m;
            block.stiffness[place] = levers.stiffness;
            turn.offset_m[place] = turned[0] * levers.axial_offset_m + turned[2] * levers.in_plane_offset_m;
        }
        Self { law, blocks, turns }
    }

    /// What the equations are made of at a state.
    pub(in crate::equilibrium) fn sums<const N: usize>(&self, state: &State) -> Sums<N> {
        self.run(Equations { blocks: &self.blocks, state })
    }

    /// How many contacts are pressed at a state.
    pub(in crate::equilibrium) fn carrying<const N: usize>(&self, state: &State) -> usize {
        Arch::new().dispatch(Carrying::<N> { blocks: &self.blocks, state })
    }

    /// The sums over the contacts of the answers of an unknown whose `lambda` is known; those to gaps are added to `gaps`.
    pub(in crate::equilibrium) fn answers<const N: usize>(
        &self,
        state: &State,
        lambda: [f64; N],
        wanted: Wanted<'_>,
        gaps: &mut [f64],
    ) -> Answers {
        self.run(Answering { contacts: self, state, lambda, wanted, gaps })
    }

    fn run<P: Pass>(&self, pass: P) -> P::Output {
        if self.law.is_hertz() {
            Arch::new().dispatch(InLanes(pass))
        } else {
            pass.over(Scalar::new(), self.law)
        }
    }
}

/// k delta^(n - 1) of contacts by stiffness and deformation, which is 0 where they have parted.
trait Law<S: Simd>: Copy {
    fn force_per_m(self, simd: S, stiffness: S::f64s, pressed_m: S::f64s) -> S::f64s;
    fn exponent(self) -> f64;
}

#[derive(Clone, Copy)]
struct Hertz;

impl<S: Simd> Law<S> for Hertz {
    #[inline(always)]
    fn force_per_m(self, simd: S, stiffness: S::f64s, pressed_m: S::f64s) -> S::f64s {
        simd.mul_f64s(stiffness, simd.sqrt_f64s(pressed_m))
    }

    #[inline(always)]
    fn exponent(self) -> f64 {
        crate::pair::HERTZ_EXPONENT
    }
}

impl Law<Scalar> for ContactLaw {
    #[inline(always)]
    fn force_per_m(self, _: Scalar, stiffness: f64, pressed_m: f64) -> f64 {
        if pressed_m > 0.0 { ContactLaw::force_per_m(&self, stiffness, pressed_m) } else { 0.0 }
    }

    #[inline(always)]
    fn exponent(self) -> f64 {
        self.exponent
    }
}

/// A pass over the contacts, in lanes of any width that knows their law.
trait Pass {
    type Output;
    fn over<S: Simd, L: Law<S>>(self, simd: S, law: L) -> Self::Output;
}

struct InLanes<P>(P);

impl<P: Pass> WithSimd for InLanes<P> {
    type Output = P::Output;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> P::Output {
        self.0.over(simd, Hertz)
    }
}

/// A state in every lane.
struct At<S: Simd, const N: usize> {
    simd: S,
    pivot_m: S::f64s,
    x: [S::f64s; N],
}

impl<S: Simd, const N: usize> At<S, N> {
    #[inline(always)]
    fn new(simd: S, state: &State) -> Self {
        let x = [state.pivot_approach_m, state.rotation_rad, state.sideways_m];
        Self {
            simd,
            pivot_m: simd.splat_f64s(state.pivot_m),
            x: std::array::from_fn(|i| simd.splat_f64s(x[i])),
        }
    }

    /// Levers of the v-th vector of a block about the pivot, and the deformation.
    #[inline(always)]
    fn deformed(
        &self,
        levers: &[[f64; BLOCK]; 3],
        offset_m: &[f64; BLOCK],
        v: usize,
    ) -> ([S::f64s; N], S::f64s) {
        let simd = self.simd;
        let levers = about_pivot::<S, N>(simd, levers.each_ref().map(|l| vector::<S>(l, v)), self.pivot_m);
        let deformation = simd.add_f64s(along(simd, &levers, &self.x), vector::<S>(offset_m, v));
        (levers, deformation)
    }
}

#[inline(always)]
fn vector<S: Simd>(numbers: &[f64; BLOCK], v: usize) -> S::f64s {
    S::as_simd_f64s(numbers).0[v]
}

/// Vectors of a block.
#[inline(always)]
fn vectors<S: Simd>() -> usize {
    BLOCK / S::F64_LANES
}

struct Equations<'a, const N: usize> {
    blocks: &'a [Block],
    state: &'a State,
}

impl<const N: usize> Pass for Equations<'_, N> {
    type Output = Sums<N>;

    #[inline(always)]
    fn over<S: Simd, L: Law<S>>(self, simd: S, law: L) -> Sums<N> {
        let at = At::<S, N>::new(simd, self.state);
        let zero = simd.splat_f64s(0.0);
        let (mut work, mut forces, mut slopes) = (zero, [zero; N], [[zero; N]; N]);
        for block in self.blocks {
            for v in 0..vectors::<S>() {
                let (levers, deformation) = at.deformed(&block.levers, &block.offset_m, v);
                let pressed = simd.max_f64s(deformation, zero);
                let per_m = law.force_per_m(simd, vector::<S>(&block.stiffness, v), pressed);
                let force = simd.mul_f64s(per_m, pressed);
                work = simd.mul_add_e_f64s(force, pressed, work);
                for i in 0..N {
                    forces[i] = simd.mul_add_e_f64s(force, levers[i], forces[i]);
                    let weighted = simd.mul_f64s(per_m, levers[i]);
                    for j in 0..=i {
                        slopes[i][j] = simd.mul_add_e_f64s(weighted, levers[j], slopes[i][j]);
                    }
                }
            }
        }
        let sum = |lanes| simd.reduce_sum_f64s(lanes);
        Sums {
            work: sum(work),
            forces: forces.map(sum),
            slopes: slopes.map(|row| row.map(|lanes| law.exponent() * sum(lanes))),
        }
    }
}

struct Carrying<'a, const N: usize> {
    blocks: &'a [Block],
    state: &'a State,
}

impl<const N: usize> WithSimd for Carrying<'_, N> {
    type Output = usize;

    // A count of contacts is a small whole number.
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> usize {
        let at = At::<S, N>::new(simd, self.state);
        let (zero, one) = (simd.splat_f64s(0.0), simd.splat_f64s(1.0));
        let mut count = zero;
        for block in self.blocks {
            for v in 0..vectors::<S>() {
                let (_, deformation) = at.deformed(&block.levers, &block.offset_m, v);
                let pressed = simd.less_than_f64s(zero, deformation);
                count = simd.add_f64s(count, simd.select_f64s(pressed, one, zero));
            }
        }
        simd.reduce_sum_f64s(count) as usize
    }
}

struct Answering<'a, const N: usize> {
    contacts: &'a Contacts,
    state: &'a State,
    lambda: [f64; N],
    wanted: Wanted<'a>,
    gaps: &'a mut [f64],
}

/// Of the contacts of some blocks.
#[derive(Default)]
struct Parts {
    deformation_m: [[f64; BLOCK]; HELD],
    /// N w.
    by_force: [[f64; BLOCK]; HELD],
    /// (dN/d delta) w.
    by_slope: [[f64; BLOCK]; HELD],
}

impl<const N: usize> Pass for Answering<'_, N> {
    type Output = Answers;

    #[inline(always)]
    fn over<S: Simd, L: Law<S>>(self, simd: S, law: L) -> Answers {
        let mut answers = Answers::default();
        let mut parts = Parts::default();
        for first in (0..self.contacts.blocks.len()).step_by(HELD) {
            let (by_stiffness, by_angle) = self.parts(simd, law, first, &mut parts);
            answers.log_stiffness -= by_stiffness;
            answers.contact_angle -= by_angle;
            if self.wanted.exponent {
                let last = HELD.min(self.contacts.blocks.len() - first);
                answers.exponent -= by_exponent(&parts, last);
            }
            for (sum, gap) in self.gaps.iter_mut().zip(self.wanted.gaps) {
                let mut lanes = simd.splat_f64s(0.0);
                for (slope, gap) in parts.by_slope.iter().zip(&gap[first..]) {
                    for v in 0..vectors::<S>() {
                        lanes = simd.mul_add_e_f64s(vector::<S>(slope, v), vector::<S>(gap, v), lanes);
                    }
                }
                *sum -= simd.reduce_sum_f64s(lanes);
            }
        }
        answers
    }
}

impl<const N: usize> Answering<'_, N> {
    /// The parts of the blocks from a first one on, and the sums of these for the stiffness and the contact angle.
    #[inline(always)]
    fn parts<S: Simd, L: Law<S>>(&self, simd: S, law: L, first: usize, parts: &mut Parts) -> (f64, f64) {
        let at = At::<S, N>::new(simd, self.state);
        let lambda: [S::f64s; N] = std::array::from_fn(|i| simd.splat_f64s(self.lambda[i]));
        let (zero, exponent) = (simd.splat_f64s(0.0), simd.splat_f64s(law.exponent()));
        let (mut by_stiffness, mut by_angle) = (zero, zero);
        for (held, block) in self.contacts.blocks[first..].iter().take(HELD).enumerate() {
            for v in 0..vectors::<S>() {
                let (levers, deformation) = at.deformed(&block.levers, &block.offset_m, v);
                let pressed = simd.max_f64s(deformation, zero);
                let per_m = law.force_per_m(simd, vector::<S>(&block.stiffness, v), pressed);
                let (force, slope) = (simd.mul_f64s(per_m, pressed), simd.mul_f64s(exponent, per_m));
                let w = along(simd, &levers, &lambda);
                let (by_force, by_slope) = (simd.mul_f64s(force, w), simd.mul_f64s(slope, w));
                by_stiffness = simd.add_f64s(by_stiffness, by_force);
                S::as_mut_simd_f64s(&mut parts.deformation_m[held]).0[v] = deformation;
                S::as_mut_simd_f64s(&mut parts.by_force[held]).0[v] = by_force;
                S::as_mut_simd_f64s(&mut parts.by_slope[held]).0[v] = by_slope;
                if let Some(grown) = self.wanted.stiffness_slopes_per_rad {
                    let turn = &self.contacts.turns[first + held];
                    let (turned, closing) = at.deformed(&turn.levers, &turn.offset_m, v);
                    let grown = vector::<S>(&grown[first + held], v);
                    by_angle = simd.mul_add_e_f64s(by_slope, closing, by_angle);
                    by_angle = simd.mul_add_e_f64s(by_force, grown, by_angle);
                    by_angle = simd.mul_add_e_f64s(force, along(simd, &turned, &lambda), by_angle);
                }
            }
        }
        (simd.reduce_sum_f64s(by_stiffness), simd.reduce_sum_f64s(by_angle))
    }
}

/// Of N ln(delta/delta_0) w over the first blocks that are held.
fn by_exponent(parts: &Parts, blocks: usize) -> f64 {
    let deformations = parts.deformation_m[..blocks].iter().flatten();
    deformations
        .zip(parts.by_force.iter().flatten())
        .filter(|(deformation, _)| **deformation > 0.0)
        .map(|(deformation, by_force)| by_force * (deformation / REFERENCE_DEFORMATION_M).ln())
        .sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pair::HERTZ_EXPONENT;

    /// More contacts than are held at a time, the last block not full; some of them parted.
    fn levers() -> Vec<Levers> {
        let contact = |index: usize| {
            let angle = index as f64;
            let side = if index.is_multiple_of(2) { 1.0 } else { -1.0 };
            let (axial, in_plane) = (0.6 + 0.1 * angle.sin(), side * (0.6 + 0.1 * angle.cos()));
            let arm_m = 0.02 * (1.3 * angle).sin();
            let mut levers = Levers {
                index,
                axial,
                turning_m: in_plane * arm_m,
                in_plane,
                arm_m,
                axial_offset_m: 0.0,
                in_plane_offset_m: 0.0,
                offset_m: 0.0,
                stiffness: 1e10 * (1.0 + 0.2 * (0.7 * angle).cos()),
            };
            levers.add_offset([1e-6 * angle.cos(), 1e-6 * (2.0 * angle).sin(), 1e-6 * (3.0 * angle).cos()]);
            levers
        };
        (0..2 * HELD * BLOCK + 3).map(contact).collect()
    }

    const STATE: State =
        State { rotation_rad: 5e-5, sideways_m: 3e-7, pivot_approach_m: 1e-6, pivot_m: 4e-3 };

    #[track_caller]
    fn same(found: f64, exact: f64, size: f64) {
        assert!((found - exact).abs() <= 1e-13 * size, "{found} {exact} of {size}");
    }

    /// Against the definitions, contact by contact.
    #[test]
    fn sums_of_equations_are_those_of_the_contacts() {
        let (levers, law) = (levers(), ContactLaw::new(HERTZ_EXPONENT));
        let contacts = Contacts::new(&levers, law);
        let found = contacts.sums::<3>(&STATE);
        let part = |levers: &Levers| {
            let deformation = levers.deformation_m(&STATE);
            (law.force_N(levers.stiffness, deformation), deformation, levers.per_unknown(STATE.pivot_m))
        };
        let sum = |of: &dyn Fn(f64, f64, [f64; 3]) -> f64| -> [f64; 2] {
            let parts = levers.iter().map(part).filter(|(force, ..)| *force > 0.0);
            let parts: Vec<f64> = parts.map(|(force, deformation, l)| of(force, deformation, l)).collect();
            [parts.iter().sum(), parts.iter().map(|part| part.abs()).sum()]
        };
        let [work, size] = sum(&|force, deformation, _| force * deformation);
        same(found.work, work, size);
        for i in 0..3 {
            let [along, size] = sum(&|force, _, l| force * l[i]);
            same(found.forces[i], along, size);
            for j in 0..=i {
                let [slope, size] = sum(&|force, deformation, l| 1.5 * force / deformation * l[i] * l[j]);
                same(found.slopes[i][j], slope, size);
            }
        }
        let pressed = levers.iter().filter(|levers| levers.deformation_m(&STATE) > 0.0).count();
        assert!(pressed > 0 && pressed < levers.len());
        assert_eq!(contacts.carrying::<3>(&STATE), pressed);
    }

    /// Lanes of any width have the same sums as lanes of one, where another exponent would be.
    #[test]
    fn answers_do_not_depend_on_the_width() {
        let (levers, law) = (levers(), ContactLaw::new(HERTZ_EXPONENT));
        let contacts = Contacts::new(&levers, law);
        let numbers = |phase: f64| by_contact((0..levers.len()).map(|place| (phase + place as f64).sin()));
        let (grown, shapes) = (numbers(0.1), [numbers(0.2), numbers(0.3)]);
        let wanted = Wanted { stiffness_slopes_per_rad: Some(&grown), exponent: true, gaps: &shapes };
        let lambda = [2e-9, 3e-6, 1e-9];
        let (mut gaps, mut gaps_of_one) = ([0.0; 2], [0.0; 2]);
        let found = contacts.answers(&STATE, lambda, wanted, &mut gaps);
        let one = Answering { contacts: &contacts, state: &STATE, lambda, wanted, gaps: &mut gaps_of_one };
        let exact = one.over(Scalar::new(), law);
        for (found, exact) in [
            (found.log_stiffness, exact.log_stiffness),
            (found.contact_angle, exact.contact_angle),
            (found.exponent, exact.exponent),
            (gaps[0], gaps_of_one[0]),
            (gaps[1], gaps_of_one[1]),
        ] {
            assert!((found / exact - 1.0).abs() <= 1e-12, "{found} {exact}");
        }
    }
}
