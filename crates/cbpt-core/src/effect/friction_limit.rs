//! The parameters of the largest friction torque, Tf0 = mu_T N_Z + T0 + c |M0|, which the effects of friction share;
//! [`super::port::Friction::limit_Nm`] computes it.

use super::spec::Parameter;
use crate::units::Quantity;

/// `mu_T`.
pub(super) const RADIUS: Parameter = Parameter::size(
    "friction_radius",
    Quantity::Length,
    "largest friction torque divided by the preload, mu_T",
)
.within(0.0, 1.0)
.likely(1e-6, 5e-3)
.log();

/// `T0`.
pub(super) const TORQUE: Parameter = Parameter::size(
    "friction_torque",
    Quantity::Torque,
    "largest friction torque without preload and load, T0",
)
.within(0.0, 1e6)
.likely(1e-4, 10.0)
.log();

/// c. What holds back all of the load never slides: a self-locking gear, which no load turns.
pub(super) const LOAD: Parameter = Parameter::size(
    "load_share",
    Quantity::Number,
    "share of the torque on the output that friction holds back beside that, c",
)
.within(0.0, 0.95)
.likely(0.01, 0.5);
