//! Any other reducer as a torsion spring: alpha = M0/k, or a smooth curve through a table of torque and angle.
//!
//! The curve is a cubic of Hermite's form between the points, its slopes those of Fritsch and Carlson (SIAM J. Numer. Anal.
//! 17, 1980) with Brodlie's weighted harmonic mean, at the ends that of the parabola through three points: it is as
//! monotone as the points, and its own slope is continuous. Beyond the table it goes on straight, which the status says.
//! A table from torque 0 at angle 0 on holds both ways.

use crate::error::{InvalidInput, require, require_positive};
use crate::status::Status;

/// More points than this are no curve of a data sheet.
const MOST_POINTS: usize = 10_000;

/// A reducer of which only torque and angle are known.
#[derive(Debug, Clone, PartialEq)]
pub struct TorsionSpring {
    law: Law,
    reference_radius_m: Option<f64>,
}

#[derive(Debug, Clone, PartialEq)]
enum Law {
    Linear { stiffness_Nm_per_rad: f64 },
    Table { stated: Vec<[f64; 2]>, knots: Vec<Knot> },
}

/// A point of the curve and the slope there.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Knot {
    torque_Nm: f64,
    angle_rad: f64,
    slope: f64,
}

/// The spring under a torque.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Twist {
    /// Angle, rad.
    pub angle_rad: f64,
    /// dalpha/dM, rad/(N m).
    pub compliance_rad_per_Nm: f64,
    /// Whether the table says so.
    pub status: Status,
}

impl TorsionSpring {
    /// A spring of one stiffness.
    ///
    /// # Errors
    /// [`InvalidInput`] for a number that is not above 0.
    pub fn linear(
        torsional_stiffness_Nm_per_rad: f64,
        reference_radius_m: Option<f64>,
    ) -> Result<Self, InvalidInput> {
        require_positive("torsion_spring.torsional_stiffness_Nm_per_rad", torsional_stiffness_Nm_per_rad)?;
        Self::of(Law::Linear { stiffness_Nm_per_rad: torsional_stiffness_Nm_per_rad }, reference_radius_m)
    }

    /// A spring with a curve through these points, both columns rising.
    ///
    /// # Errors
    /// [`InvalidInput`] where the columns differ in length, have fewer than two points or do not rise.
    pub fn table(
        torque_Nm: &[f64],
        elastic_angle_rad: &[f64],
        reference_radius_m: Option<f64>,
    ) -> Result<Self, InvalidInput> {
        let (torque, angle) = ("torsion_spring.torque_Nm", "torsion_spring.elastic_angle_rad");
        let count = torque_Nm.len();
        require(
            (2..=MOST_POINTS).contains(&count),
            torque,
            format!("{count} entries"),
            "a table needs from 2 to 10000 points",
        )?;
        let rule = format!("must have as many entries as the torques, {count}");
        require(
            elastic_angle_rad.len() == count,
            angle,
            format!("{} entries", elastic_angle_rad.len()),
            &rule,
        )?;
        for (field, column) in [(torque, torque_Nm), (angle, elastic_angle_rad)] {
            for (index, value) in column.iter().enumerate() {
                require(value.is_finite(), field, value, &format!("entry {} must be finite", index + 1))?;
            }
            for (index, pair) in column.windows(2).enumerate() {
                let rule = format!(
                    "must rise from entry to entry, and entry {} is not above the one before",
                    index + 2
                );
                require(pair[1] > pair[0], field, pair[1], &rule)?;
            }
        }
        let stated: Vec<[f64; 2]> =
            torque_Nm.iter().zip(elastic_angle_rad).map(|(torque, angle)| [*torque, *angle]).collect();
        let knots = knots(&mirrored(&stated));
        Self::of(Law::Table { stated, knots }, reference_radius_m)
    }

    fn of(law: Law, reference_radius_m: Option<f64>) -> Result<Self, InvalidInput> {
        if let Some(radius) = reference_radius_m {
            require_positive("torsion_spring.reference_radius_m", radius)?;
        }
        Ok(Self { law, reference_radius_m })
    }

    /// The one stiffness, N m/rad; `None` where a table says it.
    pub fn torsional_stiffness_Nm_per_rad(&self) -> Option<f64> {
        match &self.law {
            Law::Linear { stiffness_Nm_per_rad } => Some(*stiffness_Nm_per_rad),
            Law::Table { .. } => None,
        }
    }

    /// The points as stated, torque (N m) and angle (rad); empty where there is one stiffness.
    pub fn points(&self) -> &[[f64; 2]] {
        match &self.law {
            Law::Linear { .. } => &[],
            Law::Table { stated, .. } => stated,
        }
    }

    /// Radius at which effects act that are lengths, m.
    pub fn reference_radius_m(&self) -> Option<f64> {
        self.reference_radius_m
    }

    /// The angle under a torque (N m).
    pub fn twist(&self, torque_Nm: f64) -> Twist {
        match &self.law {
            Law::Linear { stiffness_Nm_per_rad } => Twist {
                angle_rad: torque_Nm / stiffness_Nm_per_rad,
                compliance_rad_per_Nm: 1.0 / stiffness_Nm_per_rad,
                status: Status::Solved,
            },
            Law::Table { knots, .. } => on_curve(knots, torque_Nm),
        }
    }
}

/// A table from (0, 0) on, for torques of both signs.
fn mirrored(stated: &[[f64; 2]]) -> Vec<[f64; 2]> {
    if stated.first() == Some(&[0.0, 0.0]) {
        let other_side = stated[1..].iter().rev().map(|[torque, angle]| [-torque, -angle]);
        other_side.chain(stated.iter().copied()).collect()
    } else {
        stated.to_vec()
    }
}

fn knots(points: &[[f64; 2]]) -> Vec<Knot> {
    let widths: Vec<f64> = points.windows(2).map(|pair| pair[1][0] - pair[0][0]).collect();
    let secants: Vec<f64> =
        points.windows(2).zip(&widths).map(|(pair, width)| (pair[1][1] - pair[0][1]) / width).collect();
    let last = secants.len();
    let end = |outer: usize, inner: usize| {
        end_slope([widths[outer], widths[inner]], [secants[outer], secants[inner]])
    };
    let slope = |i: usize| match i {
        0 => end(0, 1.min(last - 1)),
        i if i == last => end(last - 1, last.saturating_sub(2)),
        i => {
            let (before, after) = (widths[i - 1], widths[i]);
            let (first, second) = (2.0 * after + before, after + 2.0 * before);
            (first + second) / (first / secants[i - 1] + second / secants[i])
        }
    };
    let knot = |(i, [torque_Nm, angle_rad]): (usize, &[f64; 2])| Knot {
        torque_Nm: *torque_Nm,
        angle_rad: *angle_rad,
        slope: slope(i),
    };
    points.iter().enumerate().map(knot).collect()
}

/// Slope at the end of a curve from the widths and the secants of its last interval and the one before: that of the parabola
/// through three points, but no less than a third of the secant, so that what lies beyond is no rigid reducer.
fn end_slope([width, inner]: [f64; 2], [secant, before]: [f64; 2]) -> f64 {
    (secant + (secant - before) * width / (width + inner)).max(secant / 3.0)
}

fn on_curve(knots: &[Knot], torque_Nm: f64) -> Twist {
    let above = knots.partition_point(|knot| knot.torque_Nm <= torque_Nm);
    let end = if above == 0 { Some(&knots[0]) } else { knots.last().filter(|_| above == knots.len()) };
    if let Some(end) = end {
        let beyond = torque_Nm - end.torque_Nm;
        return Twist {
            angle_rad: end.angle_rad + end.slope * beyond,
            compliance_rad_per_Nm: end.slope,
            status: if beyond == 0.0 { Status::Solved } else { Status::OutsideTable },
        };
    }
    let (a, b) = (knots[above - 1], knots[above]);
    let width = b.torque_Nm - a.torque_Nm;
    let t = (torque_Nm - a.torque_Nm) / width;
    let rise = b.angle_rad - a.angle_rad;
    let (first, last) = (a.slope * width, b.slope * width);
    // a + first t + (3 rise - 2 first - last) t^2 + (first + last - 2 rise) t^3
    let (square, cube) = (3.0 * rise - 2.0 * first - last, first + last - 2.0 * rise);
    Twist {
        angle_rad: a.angle_rad + t * (first + t * (square + t * cube)),
        compliance_rad_per_Nm: (first + t * (2.0 * square + 3.0 * t * cube)) / width,
        status: Status::Solved,
    }
}
