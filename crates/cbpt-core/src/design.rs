//! The numbers that a designer chooses, by their names in a case file, and drives with other values of them.
//!
//! - [`NUMBERS`]: the table of them; [`numbers_of`]: those that a drive has;
//! - [`Design`]: a drive and its load with all of them laid open, to be changed and built again;
//! - [`Sizes`]: what of a design is seen without a load: its outer radius, margins of walls and spacings.
//!
//! A name such as `material.youngs_modulus_Pa` or `equal_speed.contact_angle_rad` stands for two numbers that are the same
//! (ball and plate, outside and inside); each of the two has a name of its own.

use std::f64::consts::PI;

use crate::drive::{
    CrossSlide, Deceleration, Drive, Elasticity, EqualSpeed, GrooveSection, Load, Material, RingGroove,
};
use crate::error::{InvalidInput, require};
use crate::geometry::undercut::smallest_room;
use crate::geometry::wall::remaining_room;

/// How many numbers lie open.
pub(crate) const PLACES: usize = 19;
pub(crate) const BALL: [usize; 2] = [0, 1];
pub(crate) const PLATE: [usize; 2] = [2, 3];
pub(crate) const SHORT_AMPLITUDE: usize = 4;
pub(crate) const ROLLING_CIRCLE: usize = 5;
/// Ball radius and conformity.
pub(crate) const DECELERATION_GROOVE: [usize; 2] = [6, 7];
pub(crate) const DECELERATION_ANGLE: usize = 8;
pub(crate) const PITCH_RADIUS: usize = 9;
/// Ball radius and conformity.
pub(crate) const EQUAL_SPEED_GROOVE: [usize; 2] = [10, 11];
/// Outside and inside.
pub(crate) const EQUAL_SPEED_ANGLES: [usize; 2] = [12, 13];
pub(crate) const TORQUE: usize = 14;
pub(crate) const PRELOAD: usize = 15;
pub(crate) const INPUT_ANGLE: usize = 16;
const BALL_COUNTS: [usize; 2] = [17, 18];

/// A number of a drive or of its load.
#[derive(Debug, PartialEq, Eq)]
pub struct DesignNumber {
    /// Name in SI, as in a case file: `deceleration.ball_radius_m`.
    pub name: &'static str,
    /// Whether it is a whole number, by which nothing has a derivative.
    pub whole: bool,
    pub(crate) places: &'static [usize],
}

const fn number(name: &'static str, places: &'static [usize]) -> DesignNumber {
    DesignNumber { name, whole: false, places }
}

/// Every number, a common one before the two that it stands for.
pub static NUMBERS: [DesignNumber; 22] = [
    number("material.youngs_modulus_Pa", &[BALL[0], PLATE[0]]),
    number("material.ball_youngs_modulus_Pa", &[BALL[0]]),
    number("material.plate_youngs_modulus_Pa", &[PLATE[0]]),
    number("material.poissons_ratio", &[BALL[1], PLATE[1]]),
    number("material.ball_poissons_ratio", &[BALL[1]]),
    number("material.plate_poissons_ratio", &[PLATE[1]]),
    number("deceleration.short_amplitude_coefficient", &[SHORT_AMPLITUDE]),
    number("deceleration.rolling_circle_radius_m", &[ROLLING_CIRCLE]),
    number("deceleration.ball_radius_m", &[DECELERATION_GROOVE[0]]),
    number("deceleration.groove_conformity", &[DECELERATION_GROOVE[1]]),
    number("deceleration.contact_angle_rad", &[DECELERATION_ANGLE]),
    number("equal_speed.pitch_radius_m", &[PITCH_RADIUS]),
    number("equal_speed.ball_radius_m", &[EQUAL_SPEED_GROOVE[0]]),
    number("equal_speed.groove_conformity", &[EQUAL_SPEED_GROOVE[1]]),
    number("equal_speed.contact_angle_rad", &EQUAL_SPEED_ANGLES),
    number("equal_speed.outside_contact_angle_rad", &[EQUAL_SPEED_ANGLES[0]]),
    number("equal_speed.inside_contact_angle_rad", &[EQUAL_SPEED_ANGLES[1]]),
    number("load.torque_Nm", &[TORQUE]),
    number("load.preload_N", &[PRELOAD]),
    number("load.input_angle_rad", &[INPUT_ANGLE]),
    DesignNumber { name: "deceleration.ball_count", whole: true, places: &[BALL_COUNTS[0]] },
    DesignNumber { name: "equal_speed.ball_count", whole: true, places: &[BALL_COUNTS[1]] },
];

/// The number of a name in SI.
///
/// # Errors
/// [`InvalidInput`] lists the names that there are.
pub fn find(name: &str) -> Result<&'static DesignNumber, InvalidInput> {
    NUMBERS.iter().find(|number| number.name == name).ok_or_else(|| {
        let names: Vec<&str> = NUMBERS.iter().map(|number| number.name).collect();
        InvalidInput::new("number", name, format!("must be one of {}", names.join(", ")))
    })
}

/// The numbers of a drive under a load, whole ones apart: a common one where both of its two are the same, else the two.
pub fn numbers_of(drive: &Drive, load: &Load) -> Vec<&'static DesignNumber> {
    let design = Design::of(drive, load);
    let mut found: Vec<&'static DesignNumber> = Vec::new();
    for number in NUMBERS.iter().filter(|number| !number.whole && design.get(number).is_some()) {
        let told = |place| found.iter().any(|known| known.places.contains(place));
        if !number.places.iter().all(told) {
            found.push(number);
        }
    }
    found
}

/// A drive and its load with their numbers laid open.
#[derive(Debug, Clone)]
pub struct Design {
    drive: Drive,
    pub(crate) values: [f64; PLACES],
}

impl Design {
    /// Of a drive under a load.
    pub fn of(drive: &Drive, load: &Load) -> Self {
        let (material, pair, equal) = (drive.material(), drive.deceleration(), drive.equal_speed());
        let angles = match equal {
            EqualSpeed::RingGroove(ring) => [ring.outside_contact_angle_rad, ring.inside_contact_angle_rad],
            EqualSpeed::CrossSlide(slide) => [slide.contact_angle_rad; 2],
        };
        let values = [
            material.ball.youngs_modulus_Pa,
            material.ball.poissons_ratio,
            material.plate.youngs_modulus_Pa,
            material.plate.poissons_ratio,
            pair.short_amplitude_coefficient,
            pair.rolling_circle_radius_m,
            pair.groove.ball_radius_m,
            pair.groove.groove_conformity,
            pair.contact_angle_rad,
            equal.pitch_radius_m(),
            equal.groove().ball_radius_m,
            equal.groove().groove_conformity,
            angles[0],
            angles[1],
            load.torque_Nm(),
            load.preload_N(),
            load.input_angle_rad(),
            f64::from(pair.ball_count),
            f64::from(equal.ball_count()),
        ];
        Self { drive: drive.clone(), values }
    }

    /// The value of a number; `None` where the two that it stands for differ.
    // Only the very same number is one.
    #[allow(clippy::float_cmp)]
    pub fn get(&self, number: &DesignNumber) -> Option<f64> {
        let value = self.values[number.places[0]];
        number.places.iter().all(|&place| self.values[place] == value).then_some(value)
    }

    /// Gives a number another value; a whole one is rounded.
    pub fn set(&mut self, number: &DesignNumber, value: f64) {
        for &place in number.places {
            self.values[place] = if number.whole { value.round() } else { value };
        }
    }

    /// Checks the number for the drive: one of a pair that it does not have cannot be changed by itself.
    ///
    /// # Errors
    /// [`InvalidInput`] says which name to take.
    pub fn suits(&self, number: &DesignNumber) -> Result<(), InvalidInput> {
        let of_walls = number.places.len() == 1 && EQUAL_SPEED_ANGLES.contains(&number.places[0]);
        let rule = "a cross-slide has one contact angle; name it equal_speed.contact_angle_rad";
        let rings = matches!(self.drive.equal_speed(), EqualSpeed::RingGroove(_));
        require(rings || !of_walls, "number", number.name, rule)
    }

    /// The drive and the load that these numbers make.
    ///
    /// # Errors
    /// [`InvalidInput`] names the first number that cannot be.
    pub fn build(&self) -> Result<(Drive, Load), InvalidInput> {
        let v = &self.values;
        let elasticity = |[modulus, ratio]: [usize; 2]| Elasticity {
            youngs_modulus_Pa: v[modulus],
            poissons_ratio: v[ratio],
        };
        let groove = |[radius, conformity]: [usize; 2], was: &GrooveSection| GrooveSection {
            ball_radius_m: v[radius],
            groove_conformity: v[conformity],
            ..*was
        };
        let deceleration = Deceleration {
            ball_count: count(v[BALL_COUNTS[0]]),
            short_amplitude_coefficient: v[SHORT_AMPLITUDE],
            rolling_circle_radius_m: v[ROLLING_CIRCLE],
            contact_angle_rad: v[DECELERATION_ANGLE],
            groove: groove(DECELERATION_GROOVE, &self.drive.deceleration().groove),
            ..*self.drive.deceleration()
        };
        let (ball_count, pitch_radius_m) = (count(v[BALL_COUNTS[1]]), v[PITCH_RADIUS]);
        let [outside, inside] = EQUAL_SPEED_ANGLES.map(|place| v[place]);
        let equal_groove = groove(EQUAL_SPEED_GROOVE, self.drive.equal_speed().groove());
        let equal_speed = match *self.drive.equal_speed() {
            EqualSpeed::RingGroove(_) => EqualSpeed::RingGroove(RingGroove {
                ball_count,
                pitch_radius_m,
                outside_contact_angle_rad: outside,
                inside_contact_angle_rad: inside,
                groove: equal_groove,
            }),
            EqualSpeed::CrossSlide(slide) => EqualSpeed::CrossSlide(CrossSlide {
                ball_count,
                pitch_radius_m,
                contact_angle_rad: outside,
                groove: equal_groove,
                ..slide
            }),
        };
        let material =
            Material { ball: elasticity(BALL), plate: elasticity(PLATE), ..*self.drive.material() };
        let drive = Drive::new(material, deceleration, equal_speed, self.drive.track_curvature())?;
        Ok((drive.with_parts_of(&self.drive)?, Load::new(v[TORQUE], v[PRELOAD], v[INPUT_ANGLE])?))
    }
}

/// A count of balls; what is none becomes one that is refused.
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // a cast of a float saturates
fn count(value: f64) -> u32 {
    value as u32
}

/// What of a design is seen without a load: sizes and margins. Below 0 a margin is missing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sizes {
    /// Largest distance of a groove's edge from the centre of its own plate, m: pitch radius, eccentricity and a ball radius
    /// for the groove's half width.
    pub outer_radius_m: f64,
    /// Smallest 1 - kappa r cos(beta) of any wall of the deceleration grooves; 0 or less: they undercut.
    pub undercut_margin: f64,
    /// The same of the inside wall of a ring groove; infinite for a cross-slide, whose grooves are straight.
    pub inside_wall_margin: f64,
    /// Clear distance between neighbouring balls: of the deceleration pair and of the equal-speed pair, m.
    pub ball_clearances_m: [f64; 2],
    /// Clear distance between neighbouring ring grooves, m; infinite for a cross-slide.
    pub ring_clearance_m: f64,
}

impl Sizes {
    /// Of a drive.
    pub fn of(drive: &Drive) -> Self {
        let (pair, equal, e) =
            (drive.deceleration(), drive.equal_speed(), drive.deceleration().eccentricity_m());
        let edge = |pitch_radius_m: f64, ball_radius_m: f64| pitch_radius_m + e + ball_radius_m;
        let (inside_wall_margin, ring_clearance_m) = match equal {
            EqualSpeed::RingGroove(ring) => (
                remaining_room(&ring.groove, 1.0 / e, ring.inside_contact_angle_rad),
                clearance_m(ring.ball_count, ring.pitch_radius_m, 2.0 * (e + ring.groove.ball_radius_m)),
            ),
            EqualSpeed::CrossSlide(_) => (f64::INFINITY, f64::INFINITY),
        };
        let balls = |count: u32, pitch_radius_m: f64, groove: &GrooveSection| {
            clearance_m(count, pitch_radius_m, 2.0 * groove.ball_radius_m)
        };
        Self {
            outer_radius_m: edge(pair.pitch_radius_m(), pair.groove.ball_radius_m)
                .max(edge(equal.pitch_radius_m(), equal.groove().ball_radius_m)),
            undercut_margin: smallest_room(pair),
            inside_wall_margin,
            ball_clearances_m: [
                balls(pair.ball_count, pair.pitch_radius_m(), &pair.groove),
                balls(equal.ball_count(), equal.pitch_radius_m(), equal.groove()),
            ],
            ring_clearance_m,
        }
    }
}

/// Distance between the centres of neighbours of so many on a circle, m.
pub(crate) fn spacing_m(count: u32, pitch_radius_m: f64) -> f64 {
    2.0 * pitch_radius_m * (PI / f64::from(count)).sin()
}

/// Clear distance between neighbours of a width, m; below 0 they overlap.
fn clearance_m(count: u32, pitch_radius_m: f64, width_m: f64) -> f64 {
    spacing_m(count, pitch_radius_m) - width_m
}
