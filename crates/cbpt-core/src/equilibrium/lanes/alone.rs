//! Newton's method on a homogeneous pair under one load, with a contact a lane; and how the solution answers.
//!
//! Beside S (see `kernel`) the answer to the contact angle needs what that changes of the equations at a state held, with
//! l' = dl/dbeta and kappa = dln k/dbeta of each contact:
//!
//!   g = d(S x)/dbeta = sum of k sqrt(delta) [(3/2 l' . x + kappa delta) l + delta l'].

use pulp::{Arch, Simd, WithSimd};

use super::contacts::BLOCK;
use super::kernel::{Contact, Contacts, Found, about_pivot, add, along, compliance, iterate};

/// At this residual the last digits are there: a load that is asked for again stays where it was, to the last bit.
const FLOOR: f64 = 1e-14;

/// Contacts side by side; a place that none fills has no stiffness.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Block {
    levers: [[f64; BLOCK]; 3],
    stiffness: [f64; BLOCK],
}

/// What the contact angle changes of the contacts of a block.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Turn {
    /// Of the levers, 1/rad.
    levers: [[f64; BLOCK]; 3],
    /// Of the logarithm of the stiffness, 1/rad.
    stiffness: [f64; BLOCK],
}

/// Contacts in blocks, `count` of them or fewer.
pub fn in_blocks(contacts: impl Iterator<Item = Contact>, count: usize) -> Vec<Block> {
    let columns = in_columns(contacts.map(|contact| (contact.levers, contact.stiffness)), count);
    columns.into_iter().map(|(levers, stiffness)| Block { levers, stiffness }).collect()
}

/// What the contact angle changes of the levers and of the logarithm of the stiffness, in blocks like the contacts.
pub fn turns_in_blocks(turns: impl Iterator<Item = ([f64; 3], f64)>, count: usize) -> Vec<Turn> {
    let columns = in_columns(turns, count);
    columns.into_iter().map(|(levers, stiffness)| Turn { levers, stiffness }).collect()
}

fn in_columns(
    contacts: impl Iterator<Item = ([f64; 3], f64)>,
    count: usize,
) -> Vec<([[f64; BLOCK]; 3], [f64; BLOCK])> {
    let mut columns = vec![([[0.0; BLOCK]; 3], [0.0; BLOCK]); count.div_ceil(BLOCK)];
    for (place, (levers, stiffness)) in contacts.take(count).enumerate() {
        let block = &mut columns[place / BLOCK];
        for (column, lever) in block.0.iter_mut().zip(levers) {
            column[place % BLOCK] = lever;
        }
        block.1[place % BLOCK] = stiffness;
    }
    columns
}

/// Solves one load.
pub fn run(blocks: &[Block], floats_sideways: bool, pivot: f64, start: [f64; 3]) -> Found {
    if floats_sideways {
        Arch::new().dispatch(Alone::<3> { blocks, pivot, start })
    } else {
        Arch::new().dispatch(Alone::<2> { blocks, pivot, start })
    }
}

/// A solved load, and how it answers.
#[derive(Debug, Clone, Copy)]
pub struct Answered {
    pub found: Found,
    /// The unknowns' answer to a torque about the pivot, which is held.
    pub compliance: [f64; 3],
    /// The rotation's to the contact angle, 1/rad; 0 where it is not asked for.
    pub by_contact_angle: f64,
    /// How many contacts carry.
    pub carrying: usize,
}

/// Solves one load and says how it answers: to the contact angle too where there are `turns`, a block for each of the
/// contacts. `None` where it is not solved.
pub fn answer(
    blocks: &[Block],
    turns: &[Turn],
    floats_sideways: bool,
    pivot: f64,
    start: [f64; 3],
) -> Option<Answered> {
    if floats_sideways {
        Arch::new().dispatch(Answer { solve: Alone::<3> { blocks, pivot, start }, turns })
    } else {
        Arch::new().dispatch(Answer { solve: Alone::<2> { blocks, pivot, start }, turns })
    }
}

struct Alone<'a, const N: usize> {
    blocks: &'a [Block],
    pivot: f64,
    start: [f64; 3],
}

impl<const N: usize> Alone<'_, N> {
    /// With S where the last step began.
    // A count of passes is a small whole number.
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    #[inline(always)]
    fn solve<S: Simd>(&self, simd: S) -> (Found, [[f64; N]; N]) {
        let start: [f64; N] = std::array::from_fn(|i| self.start[i]);
        let contacts = Blocks { simd, blocks: self.blocks };
        let stop = iterate(pulp::Scalar::new(), &contacts, self.pivot, start);
        let mut x = [0.0; 3];
        x[..N].copy_from_slice(&stop.x);
        (Found { pivot: self.pivot, x, residual: stop.residual, steps: stop.steps as u32 }, stop.sums)
    }
}

impl<const N: usize> WithSimd for Alone<'_, N> {
    type Output = Found;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Found {
        self.solve(simd).0
    }
}

struct Answer<'a, const N: usize> {
    solve: Alone<'a, N>,
    turns: &'a [Turn],
}

impl<const N: usize> WithSimd for Answer<'_, N> {
    type Output = Option<Answered>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Option<Answered> {
        // The last step is far below what an answer shows.
        let (mut found, sums) = self.solve.solve(simd);
        if found.steps <= 1 && found.residual <= FLOOR {
            found.x = self.solve.start;
        }
        let compliance = Some(found).filter(Found::is_solved).and_then(|_| compliance(&sums))?;
        let x: [f64; N] = std::array::from_fn(|i| found.x[i]);
        let (carrying, by_angle) = if self.turns.is_empty() {
            (carrying(simd, self.solve.blocks, found.pivot, &x), 0.0)
        } else {
            let (carrying, turned) = turned(simd, self.solve.blocks, self.turns, found.pivot, &x);
            (carrying, (0..N).map(|i| turned[i] * compliance[i]).sum())
        };
        Some(Answered { found, compliance, by_contact_angle: -by_angle, carrying })
    }
}

/// A contact in each lane, all under one load.
struct Blocks<'a, S> {
    simd: S,
    blocks: &'a [Block],
}

impl<S: Simd> Contacts<pulp::Scalar> for Blocks<'_, S> {
    #[inline(always)]
    fn sums<const N: usize>(&self, _: pulp::Scalar, pivot: f64, x: &[f64; N]) -> [[f64; N]; N] {
        let simd = self.simd;
        let pivot = simd.splat_f64s(pivot);
        let x: [S::f64s; N] = std::array::from_fn(|i| simd.splat_f64s(x[i]));
        let mut sums = [[simd.splat_f64s(0.0); N]; N];
        for block in self.blocks {
            let levers = block.levers.each_ref().map(|lever| S::as_simd_f64s(lever).0);
            let stiffness = S::as_simd_f64s(&block.stiffness).0;
            for v in 0..stiffness.len() {
                add(simd, &mut sums, [levers[0][v], levers[1][v], levers[2][v]], stiffness[v], pivot, &x);
            }
        }
        // Plain loops: closures within closures are not inlined into the function that knows the instruction set.
        let mut totals = [[0.0; N]; N];
        for i in 0..N {
            for j in 0..N {
                totals[i][j] = simd.reduce_sum_f64s(sums[i][j]);
            }
        }
        totals
    }
}

/// How many contacts are pressed.
// A count of contacts is a small whole number.
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
#[inline(always)]
fn carrying<S: Simd, const N: usize>(simd: S, blocks: &[Block], pivot: f64, x: &[f64; N]) -> usize {
    let pivot = simd.splat_f64s(pivot);
    let x: [S::f64s; N] = std::array::from_fn(|i| simd.splat_f64s(x[i]));
    let mut count = simd.splat_f64s(0.0);
    for block in blocks {
        let levers = block.levers.each_ref().map(|lever| S::as_simd_f64s(lever).0);
        for v in 0..levers[0].len() {
            let levers = about_pivot::<S, N>(simd, [levers[0][v], levers[1][v], levers[2][v]], pivot);
            count = simd.add_f64s(count, pressed(simd, along(simd, &levers, &x)));
        }
    }
    simd.reduce_sum_f64s(count) as usize
}

/// The same, and g.
// A count of contacts is a small whole number.
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
#[inline(always)]
fn turned<S: Simd, const N: usize>(
    simd: S,
    blocks: &[Block],
    turns: &[Turn],
    pivot: f64,
    x: &[f64; N],
) -> (usize, [f64; N]) {
    let pivot = simd.splat_f64s(pivot);
    let x: [S::f64s; N] = std::array::from_fn(|i| simd.splat_f64s(x[i]));
    let (zero, exponent) = (simd.splat_f64s(0.0), simd.splat_f64s(1.5));
    let (mut count, mut sums) = (zero, [zero; N]);
    for (block, turn) in blocks.iter().zip(turns) {
        let levers = block.levers.each_ref().map(|lever| S::as_simd_f64s(lever).0);
        let turned = turn.levers.each_ref().map(|lever| S::as_simd_f64s(lever).0);
        let (stiffness, grown) = (S::as_simd_f64s(&block.stiffness).0, S::as_simd_f64s(&turn.stiffness).0);
        for v in 0..stiffness.len() {
            let levers = about_pivot::<S, N>(simd, [levers[0][v], levers[1][v], levers[2][v]], pivot);
            let turned = about_pivot::<S, N>(simd, [turned[0][v], turned[1][v], turned[2][v]], pivot);
            let deformation = along(simd, &levers, &x);
            count = simd.add_f64s(count, pressed(simd, deformation));
            let deformation = simd.max_f64s(deformation, zero);
            let weight = simd.mul_f64s(stiffness[v], simd.sqrt_f64s(deformation));
            let closing = simd.mul_f64s(exponent, along(simd, &turned, &x));
            let by_levers = simd.mul_f64s(weight, simd.mul_add_e_f64s(grown[v], deformation, closing));
            let force = simd.mul_f64s(weight, deformation);
            for i in 0..N {
                sums[i] = simd.mul_add_e_f64s(by_levers, levers[i], sums[i]);
                sums[i] = simd.mul_add_e_f64s(force, turned[i], sums[i]);
            }
        }
    }
    (simd.reduce_sum_f64s(count) as usize, sums.map(|sum| simd.reduce_sum_f64s(sum)))
}

/// 1 where the deformation is above 0, else 0.
#[inline(always)]
fn pressed<S: Simd>(simd: S, deformation: S::f64s) -> S::f64s {
    let zero = simd.splat_f64s(0.0);
    simd.select_f64s(simd.less_than_f64s(zero, deformation), simd.splat_f64s(1.0), zero)
}
