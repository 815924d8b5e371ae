//! The contacts of parts as made, at places spread over all turns after which the drive stands as before.
//!
//! Every place has its pressures under 1 N ready, so that a load costs the equilibrium alone. A limit of a load is looked for at
//! the few places that decide, and then tried at all; what is worse there decides from then on.

use rayon::prelude::*;

use super::bisected;
use crate::drive::Drive;
use crate::equilibrium::ContactLaw;
use crate::equilibrium::solve::solve_pair;
use crate::pair::{MeshingPoint, MeshingPoints};
use crate::preload::places_as_made_rad;

/// Highest peak pressure (Pa) and largest semi-axis (m) of the deceleration and of the equal-speed pair.
pub(super) type OfPairs = [[f64; 2]; 2];

/// A row of meshing points, and what 1 N makes at the worse end of each diagonal: peak pressure (Pa) and semi-axis (m). Both
/// grow with the cube root of the force.
struct Row {
    points: MeshingPoints,
    at_1N: Vec<[f64; 2]>,
}

impl Row {
    fn new(points: MeshingPoints) -> Self {
        let at_1N = |point: &MeshingPoint| {
            let loaded = point.walls.iter().flatten().map(|wall| wall.under(1.0));
            let each = loaded.map(|wall| [wall.peak_pressure_Pa, wall.major_semi_axis_m]);
            each.fold([0.0; 2], larger)
        };
        let at_1N = points.points.iter().map(at_1N).collect();
        Self { points, at_1N }
    }

    fn worst(&self, torque_Nm: f64, preload_N: f64) -> [f64; 2] {
        let (_, Some(solved)) = solve_pair(&self.points, torque_Nm, preload_N) else {
            return [f64::INFINITY; 2];
        };
        let law = ContactLaw::new(self.points.exponent);
        let existing = self.points.points.iter().zip(&self.at_1N).filter(|(point, _)| point.exists());
        existing.fold([0.0; 2], |found, (point, at_1N)| {
            let root = law.force_N(point.stiffness, solved.state.deformation_m(point)).cbrt();
            larger(found, at_1N.map(|one| root * one))
        })
    }
}

/// Both pairs at one angle of the crank.
struct Place {
    rows: [Vec<Row>; 2],
}

/// A drive with its parts as made at all places.
pub(super) struct MadeContacts {
    places: Vec<Place>,
    share: f64,
}

impl MadeContacts {
    pub fn new(drive: &Drive) -> Self {
        let place = |angle_rad: f64| {
            let rows = |rows: Vec<MeshingPoints>| rows.into_iter().map(Row::new).collect();
            Place {
                rows: [
                    rows(vec![drive.deceleration_as_made(angle_rad)]),
                    rows(drive.equal_speed_as_made(angle_rad)),
                ],
            }
        };
        let angles = places_as_made_rad(drive);
        Self { places: angles.into_par_iter().map(place).collect(), share: drive.equal_speed_share() }
    }

    fn at(&self, place: &Place, torque_Nm: f64, preload_N: f64) -> OfPairs {
        let of_pair = |rows: &[Row], torque_Nm: f64| {
            rows.iter().fold([0.0; 2], |found, row| larger(found, row.worst(torque_Nm, preload_N)))
        };
        [of_pair(&place.rows[0], torque_Nm), of_pair(&place.rows[1], torque_Nm * self.share)]
    }

    /// The worst of all places, and which of them has the highest pressure.
    pub fn worst(&self, torque_Nm: f64, preload_N: f64) -> (OfPairs, usize) {
        let found: Vec<OfPairs> =
            self.places.par_iter().map(|place| self.at(place, torque_Nm, preload_N)).collect();
        let highest = |place: usize| found[place][0][0].max(found[place][1][0]);
        let decides = (0..found.len()).max_by(|&a, &b| highest(a).total_cmp(&highest(b))).unwrap_or(0);
        let worst = |a: OfPairs, b: &OfPairs| [larger(a[0], b[0]), larger(a[1], b[1])];
        (found.iter().fold([[0.0; 2]; 2], worst), decides)
    }

    /// The last number from `low`, where all places are safe, to `high` up to which they are: `load` makes torque (N m) and
    /// preload (N) of it, and the highest pressure must not exceed `most_Pa`.
    pub fn last_safe(&self, [low, high]: [f64; 2], most_Pa: f64, load: impl Fn(f64) -> [f64; 2]) -> f64 {
        let mut deciding: Vec<usize> = Vec::new();
        loop {
            let safe = |number: f64| {
                let [torque_Nm, preload_N] = load(number);
                deciding.iter().all(|&place| {
                    let [first, second] = self.at(&self.places[place], torque_Nm, preload_N);
                    first[0].max(second[0]) <= most_Pa
                })
            };
            let found = if safe(high) { high } else { bisected(low, high, safe) };
            let [torque_Nm, preload_N] = load(found);
            let ([first, second], place) = self.worst(torque_Nm, preload_N);
            if first[0].max(second[0]) <= most_Pa || deciding.contains(&place) {
                return found;
            }
            deciding.push(place);
        }
    }
}

fn larger(a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
    [a[0].max(b[0]), a[1].max(b[1])]
}
