//! What turns under the torque: a ball drive with its contacts, or any other reducer as a torsion spring.

use crate::drive::Drive;
use crate::effect::Spec;
use crate::torsion_spring::TorsionSpring;

/// A reducer of either kind.
#[derive(Debug, Clone, PartialEq)]
pub enum Reducer {
    /// A cycloid ball planetary transmission.
    BallDrive(Drive),
    /// Any other: gears, harmonic, pin cycloid.
    TorsionSpring(TorsionSpring),
}

impl Reducer {
    /// The ball drive, if it is one.
    pub fn ball_drive(&self) -> Option<&Drive> {
        match self {
            Self::BallDrive(drive) => Some(drive),
            Self::TorsionSpring(_) => None,
        }
    }

    /// The torsion spring, if it is one.
    pub fn torsion_spring(&self) -> Option<&TorsionSpring> {
        match self {
            Self::BallDrive(_) => None,
            Self::TorsionSpring(spring) => Some(spring),
        }
    }

    /// Why it cannot have an effect, if it cannot.
    pub fn unsuited(&self, spec: &Spec) -> Option<&'static str> {
        match self {
            Self::BallDrive(_) if spec.suits_ball_drives() => None,
            Self::BallDrive(_) => {
                Some("is for torsion springs only: the contacts of a ball drive already model their play")
            }
            Self::TorsionSpring(spring) if spec.suits_springs(spring.reference_radius_m().is_some()) => None,
            Self::TorsionSpring(_) if spec.suits_springs(true) => Some(
                "is a length that turns the output: give torsion_spring.reference_radius_mm, the radius at which it acts",
            ),
            Self::TorsionSpring(_) => Some(
                "is about the balls, grooves or axial preload of a ball drive, which a torsion spring does not have",
            ),
        }
    }
}

impl From<Drive> for Reducer {
    fn from(drive: Drive) -> Self {
        Self::BallDrive(drive)
    }
}

impl From<&Drive> for Reducer {
    fn from(drive: &Drive) -> Self {
        Self::BallDrive(drive.clone())
    }
}

impl From<TorsionSpring> for Reducer {
    fn from(spring: TorsionSpring) -> Self {
        Self::TorsionSpring(spring)
    }
}

impl From<&Self> for Reducer {
    fn from(reducer: &Self) -> Self {
        reducer.clone()
    }
}
