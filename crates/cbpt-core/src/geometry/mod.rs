//! Geometry of the grooves.
//!
//! - [`trochoid`]: the tracks of the deceleration balls: arms, directions and curvatures at a ball;
//! - [`wall`]: a groove wall as a contact: relative curvatures, missing walls, Hertz contact;
//! - [`findings`]: what a designer should know before building: undercut, missing walls, touching balls.

pub mod findings;
pub mod trochoid;
pub mod wall;
