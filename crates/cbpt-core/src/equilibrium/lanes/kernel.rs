//! Newton's method on a homogeneous pair, one load a lane; `alone` has one load with a contact a lane.
//!
//! With deformations delta = l . x, l = (sin(beta), +- a cos(beta) - A sin(beta), +- cos(beta)), all scaled, and
//! S = sum of k sqrt(delta) l l^T over the contacts that touch:
//! - equations: S x = (1, 0, 0), for k delta^1.5 = (k sqrt(delta) l) . x;
//! - Hessian: 3/2 S, so Newton's step is x <- x - 2/3 S^-1 (S x - (1, 0, 0)).
//!
//! S is all that is summed: one square root a contact, which is what bounds the speed. A lane whose equations hold takes
//! the step that belongs to them, which S gives for nothing, and then rests while its neighbours go on.

use pulp::{Arch, Simd, WithSimd};

/// Largest scaled residual that counts as solved.
const TOLERANCE: f64 = 1e-11;
/// Passes over the contacts before a load is left to the scalar solver.
const MOST_PASSES: usize = 12;
/// A pivot of S below this share of its diagonal element tells a motion that is nearly free.
const SMALLEST_PIVOT: f64 = 1e-12;

/// The cold start: plates pressed together, no rotation.
pub const COLD: [f64; 3] = [1.0, 0.0, 0.0];

/// A contact, scaled: what its deformation gains per approach, rotation about the axis and shift; and its stiffness.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Contact {
    pub levers: [f64; 3],
    pub stiffness: f64,
}

/// Contacts with the same levers deform alike, so their stiffnesses add (inside and outside walls of opposite balls of
/// a ring-groove pair, for instance).
pub fn merged(mut contacts: Vec<Contact>) -> Vec<Contact> {
    // Arms of opposite balls differ by the rounding of their angles; largest arms are of order 1 here.
    const SAME: f64 = 1e-15;
    contacts.sort_by(|a, b| {
        let key = |contact: &Contact| [contact.levers[0], contact.levers[2], contact.levers[1]];
        key(a).partial_cmp(&key(b)).unwrap_or(std::cmp::Ordering::Equal)
    });
    let mut merged: Vec<Contact> = Vec::with_capacity(contacts.len());
    for contact in contacts {
        match merged.last_mut() {
            Some(last) if (0..3).all(|i| (last.levers[i] - contact.levers[i]).abs() <= SAME) => {
                last.stiffness += contact.stiffness;
            }
            _ => merged.push(contact),
        }
    }
    merged
}

/// At most B loads in lanes, a whole number of vectors of any width: pivots and starts in, states out.
pub struct Batch<const B: usize> {
    pivot: [f64; B],
    x: [[f64; B]; 3],
    residual: [f64; B],
    steps: [f64; B],
}

/// What a lane holds in the end.
#[derive(Debug, Clone, Copy)]
pub struct Found {
    pub pivot: f64,
    pub x: [f64; 3],
    pub residual: f64,
    pub steps: u32,
}

impl Found {
    /// Whether the equations hold; not so where they gave no number.
    pub fn is_solved(&self) -> bool {
        self.residual <= TOLERANCE
    }
}

impl<const B: usize> Batch<B> {
    pub fn new() -> Self {
        Self {
            pivot: [0.0; B],
            x: COLD.map(|value| [value; B]),
            residual: [f64::INFINITY; B],
            steps: [0.0; B],
        }
    }

    pub fn set_pivot(&mut self, lane: usize, pivot: f64) {
        self.pivot[lane] = pivot;
    }

    /// Starts the first `count` lanes.
    #[inline(always)]
    pub fn start(&mut self, count: usize, from: impl Fn(f64) -> [f64; 3]) {
        for lane in 0..count {
            let start = from(self.pivot[lane]);
            for i in 0..3 {
                self.x[i][lane] = start[i];
            }
        }
    }

    // A count of passes is a small whole number.
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    pub fn found(&self, lane: usize) -> Found {
        Found {
            pivot: self.pivot[lane],
            x: [self.x[0][lane], self.x[1][lane], self.x[2][lane]],
            residual: self.residual[lane],
            steps: self.steps[lane] as u32,
        }
    }
}

/// Solves the first `count` lanes with the widest vectors that the processor has.
pub fn run<const B: usize>(contacts: &[Contact], floats_sideways: bool, batch: &mut Batch<B>, count: usize) {
    if floats_sideways {
        Arch::new().dispatch(Lanes::<3, B> { contacts, batch, count });
    } else {
        Arch::new().dispatch(Lanes::<2, B> { contacts, batch, count });
    }
}

struct Lanes<'a, const N: usize, const B: usize> {
    contacts: &'a [Contact],
    batch: &'a mut Batch<B>,
    count: usize,
}

impl<const N: usize, const B: usize> WithSimd for Lanes<'_, N, B> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let pivots = S::as_simd_f64s(&self.batch.pivot).0;
        let [x0, x1, x2] = self.batch.x.each_mut().map(|values| S::as_mut_simd_f64s(values).0);
        let unknowns = [x0, x1, x2];
        let residuals = S::as_mut_simd_f64s(&mut self.batch.residual).0;
        let steps = S::as_mut_simd_f64s(&mut self.batch.steps).0;
        for v in 0..self.count.div_ceil(S::F64_LANES) {
            let start: [S::f64s; N] = std::array::from_fn(|i| unknowns[i][v]);
            let stop = iterate(simd, &OneByOne(self.contacts), pivots[v], start);
            for i in 0..N {
                unknowns[i][v] = stop.x[i];
            }
            (residuals[v], steps[v]) = (stop.residual, stop.steps);
        }
    }
}

/// Where the iteration ended, in each lane.
pub struct Stop<F, const N: usize> {
    pub x: [F; N],
    /// Largest residual before the last step, within the tolerance exactly where solved.
    pub residual: F,
    /// Steps taken.
    pub steps: F,
    /// The lower triangle of S in the last pass; of a load that had solved before, it is not where that rests.
    pub sums: [[F; N]; N],
}

/// Newton's method from a start.
#[inline(always)]
pub fn iterate<S: Simd, const N: usize>(
    simd: S,
    contacts: &impl Contacts<S>,
    pivot: S::f64s,
    start: [S::f64s; N],
) -> Stop<S::f64s, N> {
    let (tolerance, one) = (simd.splat_f64s(TOLERANCE), simd.splat_f64s(1.0));
    let mut x = start;
    let mut residual = simd.splat_f64s(f64::INFINITY);
    let mut steps = simd.splat_f64s(0.0);
    let mut sums = [[simd.splat_f64s(0.0); N]; N];
    for _ in 0..MOST_PASSES {
        sums = contacts.sums(simd, pivot, &x);
        let (next, before) = newton(simd, &sums, pivot, &x);
        let rests = simd.less_than_or_equal_f64s(residual, tolerance);
        for i in 0..N {
            x[i] = simd.select_f64s(rests, x[i], next[i]);
        }
        steps = simd.select_f64s(rests, steps, simd.add_f64s(steps, one));
        residual = simd.select_f64s(rests, residual, before);
        if simd.reduce_max_f64s(residual) <= TOLERANCE {
            break;
        }
    }
    Stop { x, residual, steps, sums }
}

/// What S is summed over.
pub trait Contacts<S: Simd> {
    /// The lower triangle of S.
    fn sums<const N: usize>(&self, simd: S, pivot: S::f64s, x: &[S::f64s; N]) -> [[S::f64s; N]; N];
}

/// Contacts one by one, each in all lanes, whose loads differ.
struct OneByOne<'a>(&'a [Contact]);

impl<S: Simd> Contacts<S> for OneByOne<'_> {
    #[inline(always)]
    fn sums<const N: usize>(&self, simd: S, pivot: S::f64s, x: &[S::f64s; N]) -> [[S::f64s; N]; N] {
        let mut sums = [[simd.splat_f64s(0.0); N]; N];
        for contact in self.0 {
            let levers = contact.levers.map(|lever| simd.splat_f64s(lever));
            add(simd, &mut sums, levers, simd.splat_f64s(contact.stiffness), pivot, x);
        }
        sums
    }
}

/// Adds a contact's share k sqrt(delta) l l^T to the lower triangle of S.
#[inline(always)]
pub fn add<S: Simd, const N: usize>(
    simd: S,
    sums: &mut [[S::f64s; N]; N],
    levers: [S::f64s; 3],
    stiffness: S::f64s,
    pivot: S::f64s,
    x: &[S::f64s; N],
) {
    let levers = about_pivot::<S, N>(simd, levers, pivot);
    let deformation = along(simd, &levers, x);
    let root = simd.sqrt_f64s(simd.max_f64s(deformation, simd.splat_f64s(0.0)));
    let weight = simd.mul_f64s(stiffness, root);
    for i in 0..N {
        let weighted = simd.mul_f64s(weight, levers[i]);
        for j in 0..=i {
            sums[i][j] = simd.mul_add_e_f64s(weighted, levers[j], sums[i][j]);
        }
    }
}

/// Levers on approach, rotation about the pivot and shift, from those with the rotation about the axis.
#[inline(always)]
pub fn about_pivot<S: Simd, const N: usize>(
    simd: S,
    [axial, turning, sideways]: [S::f64s; 3],
    pivot: S::f64s,
) -> [S::f64s; N] {
    let turning = simd.negate_mul_add_e_f64s(axial, pivot, turning);
    std::array::from_fn(|i| [axial, turning, sideways][i])
}

/// l . x.
#[inline(always)]
pub fn along<S: Simd, const N: usize>(simd: S, levers: &[S::f64s; N], x: &[S::f64s; N]) -> S::f64s {
    let mut sum = simd.mul_f64s(levers[0], x[0]);
    for i in 1..N {
        sum = simd.mul_add_e_f64s(levers[i], x[i], sum);
    }
    sum
}

/// The state after Newton's step, and the largest residual before it; infinite where a motion is nearly free.
#[inline(always)]
fn newton<S: Simd, const N: usize>(
    simd: S,
    sums: &[[S::f64s; N]; N],
    pivot: S::f64s,
    x: &[S::f64s; N],
) -> ([S::f64s; N], S::f64s) {
    let mut equations = [simd.splat_f64s(0.0); N];
    equations[0] = simd.splat_f64s(-1.0);
    for i in 0..N {
        for j in 0..N {
            equations[i] = simd.mul_add_e_f64s(sums[i.max(j)][i.min(j)], x[j], equations[i]);
        }
    }
    let mut largest = simd.abs_f64s(equations[0]);
    for equation in &equations[1..] {
        largest = simd.max_f64s(largest, simd.abs_f64s(*equation));
    }
    let about_axis = simd.mul_add_e_f64s(pivot, equations[0], equations[1]);
    largest = simd.max_f64s(largest, simd.abs_f64s(about_axis));

    let (solution, determined) = solve(simd, sums, &equations);
    let share = simd.splat_f64s(2.0 / 3.0);
    let next = std::array::from_fn(|i| simd.negate_mul_add_e_f64s(share, solution[i], x[i]));
    (next, simd.select_f64s(determined, largest, simd.splat_f64s(f64::INFINITY)))
}

/// S^-1 b by Cholesky's method without roots (S = L D L^T), and where S is far enough from singular.
#[inline(always)]
fn solve<S: Simd, const N: usize>(
    simd: S,
    matrix: &[[S::f64s; N]; N],
    right: &[S::f64s; N],
) -> ([S::f64s; N], S::m64s) {
    let mut lower = *matrix;
    let mut inverse_pivot = [simd.splat_f64s(0.0); N];
    let mut determined = simd.less_than_f64s(simd.splat_f64s(0.0), matrix[0][0]);
    for j in 0..N {
        let mut pivot = matrix[j][j];
        for k in 0..j {
            // lower[j][k] still holds L D here; L is that over the pivot.
            let scaled = simd.mul_f64s(lower[j][k], inverse_pivot[k]);
            pivot = simd.negate_mul_add_e_f64s(scaled, lower[j][k], pivot);
            for i in j + 1..N {
                lower[i][j] = simd.negate_mul_add_e_f64s(scaled, lower[i][k], lower[i][j]);
            }
        }
        let smallest = simd.mul_f64s(simd.splat_f64s(SMALLEST_PIVOT), matrix[j][j]);
        determined = simd.and_m64s(determined, simd.less_than_f64s(smallest, pivot));
        inverse_pivot[j] = simd.div_f64s(simd.splat_f64s(1.0), pivot);
    }
    let mut x = *right;
    for i in 0..N {
        for k in 0..i {
            x[i] = simd.negate_mul_add_e_f64s(simd.mul_f64s(lower[i][k], inverse_pivot[k]), x[k], x[i]);
        }
    }
    for i in (0..N).rev() {
        let mut rest = x[i];
        for k in i + 1..N {
            rest = simd.negate_mul_add_e_f64s(lower[k][i], x[k], rest);
        }
        x[i] = simd.mul_f64s(rest, inverse_pivot[i]);
    }
    (x, determined)
}

/// How a solved state moves with its scaled pivot; `None` where a motion is nearly free.
pub fn slope(contacts: &[Contact], floats_sideways: bool, pivot: f64, x: [f64; 3]) -> Option<[f64; 3]> {
    if floats_sideways { slope_in::<3>(contacts, pivot, x) } else { slope_in::<2>(contacts, pivot, x) }
}

fn slope_in<const N: usize>(contacts: &[Contact], pivot: f64, x: [f64; 3]) -> Option<[f64; 3]> {
    let state: [f64; N] = std::array::from_fn(|i| x[i]);
    let sums = OneByOne(contacts).sums(pulp::Scalar::new(), pivot, &state);
    Some(along_curve(&x, &compliance(&sums)?))
}

/// How the unknowns answer to a torque about the pivot, which is held: 2/3 S^-1 (0, 1, 0), from the Hessian 3/2 S.
pub fn compliance<const N: usize>(sums: &[[f64; N]; N]) -> Option<[f64; 3]> {
    let torque = std::array::from_fn(|i| if i == 1 { 2.0 / 3.0 } else { 0.0 });
    let (found, determined) = solve(pulp::Scalar::new(), sums, &torque);
    let mut compliance = [0.0; 3];
    compliance[..N].copy_from_slice(&found);
    determined.then_some(compliance)
}

/// dx/dA = (x1, 0, 0) + the compliance, from S x = (1, 0, 0) with dl/dA = (0, -sin(beta), 0).
pub fn along_curve(x: &[f64; 3], compliance: &[f64; 3]) -> [f64; 3] {
    [compliance[0] + x[1], compliance[1], compliance[2]]
}
