//! How a solve ended: a solution or a status with its reason, never a plausible number.

use std::fmt;

/// Outcome of a solve. Only [`Status::Solved`], [`Status::OutsideSmallDisplacements`] and
/// [`Status::OutsideTable`] come with numbers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Status {
    /// The equations hold to the tolerance.
    Solved,
    /// The equations hold, but the displacements are no longer small against the ball radius: the linear geometry
    /// behind them fails first, so the value is that of the equations, not of the drive.
    OutsideSmallDisplacements,
    /// The torque lies beyond the table of a torsion spring, whose curve goes on straight there.
    OutsideTable,
    /// The torque is at or beyond what this preload can hold: balls slip out of their grooves.
    BeyondHold {
        /// Preload at which this torque would just slip; more than this is needed, N. Infinite where no preload holds.
        hold_preload_N: f64,
    },
    /// A groove of the deceleration pair undercuts: part of a wall does not exist, so neither does the drive.
    Undercut,
    /// The equations hold, but so few points touch that they leave a motion free: the angle is not determined.
    Indeterminate,
    /// An effect of the user's own gave a number that is not finite at this reading.
    EffectNotFinite,
    /// The iteration stopped above the tolerance; the numbers are withheld.
    NotConverged {
        /// Scaled residual where it stopped.
        residual: f64,
    },
}

impl Status {
    /// Whether numbers come with this status.
    pub fn has_solution(&self) -> bool {
        matches!(self, Self::Solved | Self::OutsideSmallDisplacements | Self::OutsideTable)
    }

    /// Short stable name, as in tables and JSON.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Solved => "ok",
            Self::OutsideSmallDisplacements => "outside_small_displacements",
            Self::OutsideTable => "outside_table",
            Self::BeyondHold { .. } => "beyond_hold",
            Self::Undercut => "undercut",
            Self::Indeterminate => "indeterminate",
            Self::EffectNotFinite => "effect_not_finite",
            Self::NotConverged { .. } => "not_converged",
        }
    }

    /// The status of a whole from the statuses of its parts: the worse of the two.
    #[must_use]
    pub fn worse(self, other: Self) -> Self {
        let rank = |status: &Self| match status {
            Self::Solved => 0,
            Self::OutsideSmallDisplacements | Self::OutsideTable => 1,
            Self::NotConverged { .. } => 2,
            Self::Indeterminate => 3,
            Self::BeyondHold { .. } => 4,
            Self::Undercut => 5,
            Self::EffectNotFinite => 6,
        };
        if let (Self::BeyondHold { hold_preload_N: a }, Self::BeyondHold { hold_preload_N: b }) =
            (self, other)
        {
            return Self::BeyondHold { hold_preload_N: a.max(b) };
        }
        if rank(&self) >= rank(&other) { self } else { other }
    }
}

/// To five digits and never too low, as a bound that a value must exceed.
fn rounded_up(value: f64) -> f64 {
    if value <= 0.0 {
        return value;
    }
    // Powers of ten that are whole numbers, so that the result prints with no digits beyond those meant.
    let decimals = 4.0 - value.log10().floor();
    let (times, over) = (10f64.powf(decimals.max(0.0)), 10f64.powf((-decimals).max(0.0)));
    // A value that has five digits already stays as it is.
    let steps = value * times / over;
    let (near, up) = (steps.round(), steps.ceil());
    let whole = if (steps - near).abs() < 1e-6 { near } else { up };
    whole * over / times
}

impl fmt::Display for Status {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Solved => write!(f, "solved"),
            Self::OutsideSmallDisplacements => write!(
                f,
                "solved, but outside small displacements: approach or turn at the balls is more than 5 % of their radius, \
                 where the linear geometry fails; check the units of the load and of the case, and near the holding \
                 limit raise the preload"
            ),
            Self::OutsideTable => write!(
                f,
                "solved, but the torque lies beyond the table of the torsion spring, where the curve continues as a straight \
                 line; extend the table"
            ),
            Self::BeyondHold { hold_preload_N } if hold_preload_N.is_finite() => write!(
                f,
                "no solution: the torque is at or above the limit that this preload can hold; more than {} N of preload is \
                 needed",
                rounded_up(*hold_preload_N)
            ),
            Self::BeyondHold { .. } => {
                write!(
                    f,
                    "no solution: no preload can hold a torque in this direction, because its walls are missing"
                )
            }
            Self::Undercut => write!(
                f,
                "no solution: a groove of the deceleration pair has an undercut, so part of its wall does not exist; enlarge the \
                 rolling circle, lower the short-amplitude coefficient or the ball radius, or set \
                 track_curvature = \"neglect\" to treat the tracks as straight"
            ),
            Self::Indeterminate => write!(
                f,
                "no solution: so few meshing points touch that the plate is free to move; raise the preload or lower the \
                 offsets of the balls"
            ),
            Self::EffectNotFinite => write!(
                f,
                "no solution: an own effect gives a number that is not finite here; keep its divisions, logarithms, roots and \
                 powers away from where they have no value"
            ),
            Self::NotConverged { residual } => {
                write!(f, "no solution: the iteration stopped at a scaled residual of {residual:.2e}")
            }
        }
    }
}
