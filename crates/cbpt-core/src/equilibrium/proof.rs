//! Proof that a pair's equations have a solution, where it lies, and that there is no other.
//!
//! Krawczyk's test (1969; R. E. Moore, R. B. Kearfott, M. J. Cloud, Introduction to Interval Analysis, 2009, section 8.2): with
//! equations f, a point m, a box X, the hull H of X and 0, and any matrix C, if
//!
//! K = -C f(m) + (1 - C J(m + H)) X
//!
//! lies in the interior of X, then f has exactly one zero in m + X, and it lies in m + K. All of it in [`Interval`]s, so
//! rounding is in the bounds. The forces have a continuous derivative (contacts part smoothly), which is all that the test
//! needs; and the energy is convex, so a zero that is alone in a box is the only one anywhere.
//!
//! The equations are those at the head of [the module](super), with every number of the meshing points taken as exact. A pivot
//! A is a choice of unknowns and may be any number: that of the solver is taken, and M0 - A `N_Z` is an interval.

use nalgebra::SMatrix;

use super::State;
use super::solve::{PairState, solve_pair};
use crate::interval::Interval;
use crate::pair::{HERTZ_EXPONENT, MeshingPoint, MeshingPoints, REFERENCE_DEFORMATION_M};

/// Where the solution of one row of a pair lies for certain.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PairEnclosure {
    /// Rotation of the output plate, rad.
    pub rotation_rad: Interval,
    /// Axial approach d of the plates at their axis, m.
    pub approach_m: Interval,
    /// Sideways shift of a floating plate, m.
    pub sideways_m: Interval,
}

/// Boxes that are tried, each larger than what the one before led to.
const MOST_BOXES: u32 = 12;
/// How often a box that holds the solution is drawn tighter.
const TIGHTENINGS: u32 = 2;

type Vector<const N: usize> = [Interval; N];

/// Encloses the solution at a torque M0 (N m; that of the drive times a share may be rounded) and a preload `N_Z` (N).
///
/// `None` where there is no solution, or none was proved.
pub fn enclose_pair(points: &MeshingPoints, torque_Nm: Interval, preload_N: f64) -> Option<PairEnclosure> {
    let (_, solved) = solve_pair(points, torque_Nm.middle(), preload_N);
    let solved = solved?;
    if points.floats_sideways {
        enclose::<3>(points, torque_Nm, preload_N, &solved)
    } else {
        enclose::<2>(points, torque_Nm, preload_N, &solved)
    }
}

fn enclose<const N: usize>(
    points: &MeshingPoints,
    torque_Nm: Interval,
    preload_N: f64,
    solved: &PairState,
) -> Option<PairEnclosure> {
    let spring = if points.axial_spring_N_per_m > 0.0 {
        // d0 is the approach under the preload alone, itself an interval.
        let unsprung = MeshingPoints { axial_spring_N_per_m: 0.0, ..points.clone() };
        Some((points.axial_spring_N_per_m, enclose_pair(&unsprung, Interval::ZERO, preload_N)?.approach_m))
    } else {
        None
    };
    let equations = Equations::<N>::new(points, torque_Nm, preload_N, &solved.state, spring);
    let near = [solved.state.pivot_approach_m, solved.state.rotation_rad, solved.state.sideways_m];
    let found = equations.zero_near(std::array::from_fn(|i| near[i]))?;
    Some(PairEnclosure {
        rotation_rad: found[1],
        approach_m: found[0] - equations.pivot_m * found[1],
        sideways_m: if N > 2 { found[2] } else { Interval::ZERO },
    })
}

/// A diagonal: what its deformation gains per unit of each unknown, its deformation at rest (m), its stiffness times the
/// factor of the law.
struct Diagonal<const N: usize> {
    levers: Vector<N>,
    offset_m: Interval,
    stiffness: Interval,
}

/// The equations of a pair in w, alpha and t, in SI.
struct Equations<const N: usize> {
    diagonals: Vec<Diagonal<N>>,
    exponent: f64,
    pivot_m: Interval,
    /// Axial load (N), torque about the pivot (N m), sideways load (N).
    loads: Vector<N>,
    /// Stiffness (N/m) of the axial spring and the approach d0 (m) from which it is relaxed.
    spring: Option<(Interval, Interval)>,
    /// Per w, alpha and t, the approach at the axis.
    approach: Vector<N>,
}

impl<const N: usize> Equations<N> {
    fn new(
        points: &MeshingPoints,
        torque_Nm: Interval,
        preload_N: f64,
        near: &State,
        spring: Option<(f64, Interval)>,
    ) -> Self {
        let pivot_m = Interval::from(near.pivot_m);
        let factor = contact_factor(points.exponent);
        let diagonal = |point: &MeshingPoint| {
            let axial = Interval::from(point.sin_beta);
            let in_plane = Interval::from(point.diagonal.sign() * point.cos_beta);
            let levers = [axial, in_plane * Interval::from(point.arm_m) - pivot_m * axial, in_plane];
            let [zeta, g, p] = [point.axial_offset_m, point.normal_offset_m, point.in_plane_offset_m];
            Diagonal {
                levers: std::array::from_fn(|i| levers[i]),
                offset_m: Interval::from(zeta) * axial + Interval::from(g) + Interval::from(p) * in_plane,
                stiffness: Interval::from(point.stiffness) * factor,
            }
        };
        let preload = Interval::from(preload_N);
        let loads = [preload, torque_Nm - pivot_m * preload, Interval::ZERO];
        let approach = [Interval::from(1.0), -pivot_m, Interval::ZERO];
        Self {
            diagonals: points.points.iter().filter(|point| point.exists()).map(diagonal).collect(),
            exponent: points.exponent,
            pivot_m,
            loads: std::array::from_fn(|i| loads[i]),
            spring: spring.map(|(stiffness, relaxed)| (Interval::from(stiffness), relaxed)),
            approach: std::array::from_fn(|i| approach[i]),
        }
    }

    /// The residuals and their derivatives anywhere in a box.
    fn evaluate(&self, x: &Vector<N>) -> (Vector<N>, [Vector<N>; N]) {
        let mut residual = self.loads.map(|load| -load);
        let mut jacobian = [[Interval::ZERO; N]; N];
        for diagonal in &self.diagonals {
            let deformation = (along(&diagonal.levers, x) + diagonal.offset_m).at_least_0();
            if deformation.upper() <= 0.0 {
                continue;
            }
            #[allow(clippy::float_cmp)]
            let root = if self.exponent == HERTZ_EXPONENT {
                deformation.sqrt()
            } else {
                deformation.powf(self.exponent - 1.0)
            };
            let per_m = diagonal.stiffness * root;
            let force = per_m * deformation;
            let slope = Interval::from(self.exponent) * per_m;
            add(&mut residual, &mut jacobian, force, slope, &diagonal.levers);
        }
        if let Some((stiffness, relaxed)) = self.spring {
            let force = stiffness * (along(&self.approach, x) - relaxed);
            add(&mut residual, &mut jacobian, force, stiffness, &self.approach);
        }
        (residual, jacobian)
    }

    /// The one zero, from a point near it.
    fn zero_near(&self, near: [f64; N]) -> Option<Vector<N>> {
        let (newton, centre) = self.newton(near)?;
        let mut tried = [Interval::ZERO; N];
        for _ in 0..MOST_BOXES {
            let image = self.krawczyk(&newton, &centre, &tried);
            if (0..N).all(|i| image[i].is_inside(tried[i])) {
                return self.tightened(&newton, &centre, image);
            }
            // A tenth more to either side, so that an image that shrinks lies inside; and the unit in the last place.
            tried = std::array::from_fn(|i| {
                let more = 0.1 * image[i].width() + f64::EPSILON * centre[i].abs() + f64::MIN_POSITIVE;
                Interval::new(image[i].lower() - more, image[i].upper() + more)
            });
        }
        None
    }

    /// A Newton step from a point: C, the inverse of the Jacobian there, and the point that the step leads to.
    fn newton(&self, at: [f64; N]) -> Option<(SMatrix<f64, N, N>, [f64; N])> {
        let (residual, jacobian) = self.evaluate(&at.map(Interval::from));
        // Scaled to a unit diagonal: the unknowns have different units.
        let scale: [f64; N] = std::array::from_fn(|i| jacobian[i][i].middle().sqrt().recip());
        let scaled = SMatrix::<f64, N, N>::from_fn(|i, j| jacobian[i][j].middle() * scale[i] * scale[j])
            .try_inverse()?;
        let inverse = SMatrix::<f64, N, N>::from_fn(|i, j| scaled[(i, j)] * scale[i] * scale[j]);
        let step: [f64; N] =
            std::array::from_fn(|i| (0..N).map(|j| inverse[(i, j)] * residual[j].middle()).sum());
        Some((inverse, std::array::from_fn(|i| at[i] - step[i])))
    }

    /// K of a box X, seen from the centre m.
    fn krawczyk(&self, c: &SMatrix<f64, N, N>, centre: &[f64; N], x: &Vector<N>) -> Vector<N> {
        let (residual, _) = self.evaluate(&centre.map(Interval::from));
        let (_, jacobian) =
            self.evaluate(&std::array::from_fn(|i| Interval::from(centre[i]) + x[i].with_0()));
        let c = |i: usize, j: usize| Interval::from(c[(i, j)]);
        std::array::from_fn(|i| {
            let newton: Interval = (0..N).map(|j| c(i, j) * residual[j]).sum();
            let rest: Interval = (0..N)
                .map(|j| {
                    let product: Interval = (0..N).map(|k| c(i, k) * jacobian[k][j]).sum();
                    (Interval::from(f64::from(u8::from(i == j))) - product) * x[j]
                })
                .sum();
            rest - newton
        })
    }

    /// A box that holds the zero, drawn tighter: the zero lies in K of it too.
    fn tightened(&self, c: &SMatrix<f64, N, N>, centre: &[f64; N], mut x: Vector<N>) -> Option<Vector<N>> {
        for _ in 0..TIGHTENINGS {
            let image = self.krawczyk(c, centre, &x);
            for i in 0..N {
                x[i] = x[i].common(image[i])?;
            }
        }
        Some(std::array::from_fn(|i| Interval::from(centre[i]) + x[i]))
    }
}

/// `delta_0`^(1.5 - n), exactly 1 for Hertz.
#[allow(clippy::float_cmp)]
fn contact_factor(exponent: f64) -> Interval {
    if exponent == HERTZ_EXPONENT {
        return Interval::from(1.0);
    }
    // The difference is rounded; a base below 1 falls with its exponent.
    let difference = Interval::from(HERTZ_EXPONENT) - Interval::from(exponent);
    let bound = |exponent| Interval::power(REFERENCE_DEFORMATION_M, exponent);
    Interval::new(bound(difference.upper()).lower(), bound(difference.lower()).upper())
}

/// Adds a force, and its derivative with the deformation, at its levers.
fn add<const N: usize>(
    residual: &mut Vector<N>,
    jacobian: &mut [Vector<N>; N],
    force: Interval,
    slope: Interval,
    levers: &Vector<N>,
) {
    for ((residual, row), lever) in residual.iter_mut().zip(jacobian).zip(levers) {
        *residual = *residual + force * *lever;
        for (entry, other) in row.iter_mut().zip(levers) {
            *entry = *entry + slope * *lever * *other;
        }
    }
}

/// Sum of products.
fn along<const N: usize>(levers: &Vector<N>, x: &Vector<N>) -> Interval {
    (0..N).map(|i| levers[i] * x[i]).sum()
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::pair::Diagonal as Side;

    /// Sine and cosine 1/2 and deformations 81 and 16 m: forces 729 and 64 N, and nothing is rounded.
    #[test]
    fn from_a_poor_start_nothing_wrong_is_proved() {
        let point = |side, arm_m| MeshingPoint {
            stiffness: 1.0,
            ..MeshingPoint::new(0, side, arm_m, [0.5, 0.5], [0.0; 2], [0.0, 1.0])
        };
        let points = MeshingPoints::new(vec![point(Side::Plus, 3.0), point(Side::Minus, 5.0)], 1e9);
        let (torque_Nm, preload_N) = (0.5 * (3.0 * 729.0 - 5.0 * 64.0), 0.5 * (729.0 + 64.0));
        let rotation_rad = 2.0 * (81.0 - 16.0) / 8.0;
        let state = solve_pair(&points, torque_Nm, preload_N).1.unwrap().state;
        let equations = Equations::<2>::new(&points, Interval::from(torque_Nm), preload_N, &state, None);
        // Near and far: from some of them the box of a step of Newton's all but holds the zero.
        let offs = (0..400).map(|i| 10_f64.powf(1.0 - 0.02 * f64::from(i)));
        for off in offs.flat_map(|off| [off, -off]).chain([0.0]) {
            let near = [state.pivot_approach_m * (1.0 + off), state.rotation_rad * (1.0 - 0.5 * off)];
            let found = equations.zero_near(near);
            assert!(found.is_some() || off != 0.0);
            assert!(found.is_none_or(|found| found[1].contains(rotation_rad)), "{off}");
        }
    }
}
