//! What a designer should know before building: each finding with its numbers and the remedy.

use crate::design::{Sizes, spacing_m};
use crate::drive::{Drive, EqualSpeed, GrooveSection, Load, RingGroove, TrackCurvature};
use crate::equilibrium::report::PairSolution;
use crate::geometry::undercut::largest_curvature_per_m;
use crate::status::Status;
use crate::transmission::Solution;

/// How bad a finding is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Severity {
    /// Worth knowing; the model has been told to look past it.
    Note,
    /// The drive works, under conditions that are stated.
    Warning,
    /// The drive cannot be built or will fail.
    Error,
}

impl Severity {
    /// `note`, `warning` or `error`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Note => "note",
            Self::Warning => "warning",
            Self::Error => "error",
        }
    }
}

/// One finding.
#[derive(Debug, Clone, PartialEq)]
pub struct Finding {
    /// Stable name: `undercut`, `inside_wall_missing`, `balls_touch`, `rings_overlap`, `edge_contact`, `peak_pressure`,
    /// or the name of a status.
    pub code: &'static str,
    /// How bad it is.
    pub severity: Severity,
    /// `deceleration`, `equal_speed` or `drive`.
    pub pair: &'static str,
    /// What was found, with the numbers.
    pub message: String,
    /// What to change.
    pub remedy: String,
}

/// Codes of the findings without a load that are errors: the drive cannot be built.
pub const UNBUILDABLE: [&str; 3] = ["undercut", "rings_overlap", "balls_touch"];

impl Drive {
    /// Why the drive cannot be built, first of [`UNBUILDABLE`]; `None` where it can.
    pub fn unbuildable(&self) -> Option<Finding> {
        self.findings(None).into_iter().find(|finding| finding.severity == Severity::Error)
    }

    /// Findings of the design; with a load also of the contacts under it (peak pressure, contact at the groove's edge).
    ///
    /// Sorted with the worst first.
    pub fn findings(&self, load: Option<&Load>) -> Vec<Finding> {
        let mut found = Vec::new();
        let sizes = Sizes::of(self);
        found.extend(undercut(self, &sizes));
        if let EqualSpeed::RingGroove(ring) = self.equal_speed() {
            found.extend(inside_wall(self, ring, &sizes));
            found.extend(rings_overlap(self, ring, &sizes));
        }
        let decelerating = self.deceleration();
        found.extend(balls_touch(
            "deceleration",
            decelerating.ball_count,
            decelerating.pitch_radius_m(),
            &decelerating.groove,
            sizes.ball_clearances_m[0],
        ));
        let equal = self.equal_speed();
        let (count, pitch) = (equal.ball_count(), equal.pitch_radius_m());
        found.extend(balls_touch("equal_speed", count, pitch, equal.groove(), sizes.ball_clearances_m[1]));
        if let Some(load) = load {
            let solution = self.solve(load);
            found.extend(unsolved(&solution));
            if let Some(pair) = &solution.deceleration {
                found.extend(under_load(
                    self,
                    "deceleration",
                    &decelerating.groove,
                    pair,
                    &[decelerating.contact_angle_rad; 2],
                ));
            }
            if let Some(pair) = &solution.equal_speed {
                let angles = match equal {
                    EqualSpeed::RingGroove(ring) => {
                        [ring.outside_contact_angle_rad, ring.inside_contact_angle_rad]
                    }
                    EqualSpeed::CrossSlide(slide) => [slide.contact_angle_rad; 2],
                };
                found.extend(under_load(self, "equal_speed", equal.groove(), pair, &angles));
            }
        }
        found.sort_by_key(|finding| std::cmp::Reverse(finding.severity));
        found
    }
}

fn undercut(drive: &Drive, sizes: &Sizes) -> Option<Finding> {
    let pair = drive.deceleration();
    if sizes.undercut_margin > 0.0 {
        return None;
    }
    let smallest_radius = 1.0 / largest_curvature_per_m(pair);
    let needed = pair.groove.ball_radius_m * pair.contact_angle_rad.cos();
    let counted = drive.track_curvature() == TrackCurvature::Exact;
    Some(Finding {
        code: "undercut",
        severity: if counted { Severity::Error } else { Severity::Note },
        pair: "deceleration",
        message: format!(
            "the smallest radius of the groove's centreline is {:.3} mm, below the {:.3} mm (ball radius times cosine of \
             the contact angle) that its walls need: part of a wall is cut away{}",
            smallest_radius * 1e3,
            needed * 1e3,
            if counted {
                ""
            } else {
                "; the model treats the tracks as straight (track_curvature = \"neglect\")"
            },
        ),
        remedy:
            "enlarge the rolling-circle radius, or lower the short-amplitude coefficient or the ball radius"
                .into(),
    })
}

fn inside_wall(drive: &Drive, ring: &RingGroove, sizes: &Sizes) -> Option<Finding> {
    let e = drive.deceleration().eccentricity_m();
    if sizes.inside_wall_margin > 0.0 {
        return None;
    }
    let needed = ring.groove.ball_radius_m * ring.inside_contact_angle_rad.cos();
    let counted = drive.track_curvature() == TrackCurvature::Exact;
    let consequence = if counted {
        "the inside meshing points carry nothing; the pair still transmits on its outside walls, but only if bearings \
         take the in-plane force N_Z cot(beta) and the tilt couple M0 tan(beta)"
    } else {
        "the model treats the walls as straight nevertheless (track_curvature = \"neglect\")"
    };
    Some(Finding {
        code: "inside_wall_missing",
        severity: if counted { Severity::Warning } else { Severity::Note },
        pair: "equal_speed",
        message: format!(
            "the ring radius e = {:.3} mm is not above {:.3} mm (ball radius times cosine of the contact angle): the ring \
             grooves have no inside wall; {consequence}",
            e * 1e3,
            needed * 1e3,
        ),
        remedy: "enlarge the eccentricity (short-amplitude coefficient times rolling-circle radius) or take smaller balls"
            .into(),
    })
}

fn rings_overlap(drive: &Drive, ring: &RingGroove, sizes: &Sizes) -> Option<Finding> {
    let e = drive.deceleration().eccentricity_m();
    let width = 2.0 * (e + ring.groove.ball_radius_m);
    let pitch = spacing_m(ring.ball_count, ring.pitch_radius_m);
    (sizes.ring_clearance_m <= 0.0).then(|| Finding {
        code: "rings_overlap",
        severity: Severity::Error,
        pair: "equal_speed",
        message: format!(
            "neighbouring ring grooves overlap: each is {:.3} mm wide, their centres are {:.3} mm apart",
            width * 1e3,
            pitch * 1e3
        ),
        remedy: "take fewer or smaller balls, a larger pitch radius or a smaller eccentricity".into(),
    })
}

/// The load itself, where the drive cannot carry it or only beyond what the model is made for.
fn unsolved(solution: &Solution) -> Option<Finding> {
    let (severity, remedy) = match solution.status {
        // Undercut has a finding of its own.
        Status::Solved | Status::Undercut => return None,
        Status::OutsideTable => (Severity::Warning, "extend the table"),
        Status::OutsideSmallDisplacements => (Severity::Warning, "lower the load or raise the preload"),
        _ => (Severity::Error, "lower the torque or raise the preload"),
    };
    Some(Finding {
        code: solution.status.name(),
        severity,
        pair: "drive",
        message: format!(
            "at {} N m and {} N: {}",
            solution.load.torque_Nm(),
            solution.load.preload_N(),
            solution.status
        ),
        remedy: remedy.into(),
    })
}

fn balls_touch(
    pair: &'static str,
    count: u32,
    pitch_radius_m: f64,
    groove: &GrooveSection,
    clearance_m: f64,
) -> Option<Finding> {
    let diameter = 2.0 * groove.ball_radius_m;
    let pitch = spacing_m(count, pitch_radius_m);
    (clearance_m <= 0.0).then(|| Finding {
        code: "balls_touch",
        severity: Severity::Error,
        pair,
        message: format!(
            "neighbouring balls touch: their diameter is {:.3} mm, their centres are {:.3} mm apart",
            diameter * 1e3,
            pitch * 1e3
        ),
        remedy: "take fewer or smaller balls, or a larger pitch radius".into(),
    })
}

fn under_load(
    drive: &Drive,
    name: &'static str,
    groove: &GrooveSection,
    pair: &PairSolution,
    contact_angles_rad: &[f64],
) -> Vec<Finding> {
    let mut found = Vec::new();
    let limit = drive.material().pressure_limit_Pa;
    if pair.peak_pressure_Pa > limit {
        found.push(Finding {
            code: "peak_pressure",
            severity: Severity::Warning,
            pair: name,
            message: format!(
                "the peak contact pressure is {:.2} GPa, above the limit of {:.2} GPa",
                pair.peak_pressure_Pa * 1e-9,
                limit * 1e-9
            ),
            remedy: "lower the preload or the torque, or take more or larger balls or a closer conformity"
                .into(),
        });
    }
    if let Some(depth) = groove.groove_depth_m {
        let semi_axis = pair
            .points
            .iter()
            .flat_map(|point| point.walls.iter().flatten())
            .map(|wall| wall.major_semi_axis_m)
            .fold(0.0, f64::max);
        let room = contact_angles_rad
            .iter()
            .map(|angle| distance_to_edge_m(groove, depth, *angle))
            .fold(f64::INFINITY, f64::min);
        if semi_axis >= room {
            found.push(Finding {
                code: "edge_contact",
                severity: Severity::Warning,
                pair: name,
                message: format!(
                    "the contact ellipse reaches {:.3} mm from its centre, the edge of the groove is {:.3} mm away",
                    semi_axis * 1e3,
                    room.max(0.0) * 1e3
                ),
                remedy: "deepen the groove, lower the contact angle or lower the load".into(),
            });
        }
    }
    found
}

/// Distance along the wall from the middle of the contact to the groove's edge, m; below 0 past the edge.
///
/// The two walls of a groove are arcs of radius g = beta* r whose centres lie (g - r) beyond the ball's centre along
/// each contact normal; they meet in the groove's bottom, and the face of the plate is `depth` above that.
pub(crate) fn distance_to_edge_m(groove: &GrooveSection, depth_m: f64, contact_angle_rad: f64) -> f64 {
    let r = groove.ball_radius_m;
    let g = groove.groove_conformity * r;
    let (sin, cos) = contact_angle_rad.sin_cos();
    // Heights from the arc's centre, downwards.
    let bottom = (g * g - ((g - r) * cos).powi(2)).sqrt();
    let face = bottom - depth_m;
    let edge_angle = (face / g).clamp(-1.0, 1.0).asin();
    debug_assert!(sin >= 0.0);
    g * (contact_angle_rad - edge_angle)
}
