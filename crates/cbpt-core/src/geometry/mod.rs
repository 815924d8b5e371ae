//! Geometry of the grooves.
//!
//! - [`trochoid`]: the tracks of the deceleration balls: arms, directions and curvatures at a ball;
//! - [`wall`]: a groove wall as a contact: relative curvatures, missing walls, Hertz contact;
//! - [`undercut`]: the tightest place anywhere round the grooves.

pub mod trochoid;
pub mod undercut;
pub mod wall;
