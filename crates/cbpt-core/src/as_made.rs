//! The parts of a drive as they were made: what a measuring machine found, beside the nominal numbers.
//!
//! - [`Profile`]: deviation of a groove normal to its track, against the angle round the groove;
//! - [`Plate`]: offset and tilt of a plate; [`AsMade`]: all that was measured of a drive;
//! - [`Fault`]: a row of a table that cannot be.
//!
//! A deviation is above 0 where the groove lies further out, away from the centre of its plate or ring. The angle of a
//! cycloid groove is the t of its equation, the angle of the ball about the centre of the circle of balls, seen from the
//! plate; ball 0 stands at t = 0 of both grooves at crank angle 0. The angle of a ring groove is the one about the ring's
//! centre, seen from its plate, with ring 0 at angle 0 of the plate. Where the offsets act is said in
//! [`crate::pair::offsets`].

use std::f64::consts::{PI, TAU};

use crate::error::InvalidInput;

/// Deviations are errors of manufacture; what is larger is another unit.
const LARGEST_M: f64 = 1e-3;
/// The same of a tilt.
const LARGEST_RAD: f64 = 0.1;
/// So few rows cannot show a groove.
const FEWEST_ROWS: usize = 8;
/// A step so many times the usual one is a gap.
const GAP: f64 = 5.0;
/// A step at the closing of the turn so many times the largest other one is a jump, if it is larger than what machines
/// resolve.
const JUMP: f64 = 8.0;
const RESOLVED_M: f64 = 2e-7;
/// How far the same place may read differently at its second visit.
const CLOSED_RAD: f64 = 1e-9;

/// A row of a table that cannot be.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Fault {
    /// Its place, from 0.
    pub row: usize,
    /// What is there, in words with units.
    pub found: String,
    /// What is required, and what to do.
    pub required: String,
}

impl Fault {
    fn new(row: usize, found: impl Into<String>, required: impl Into<String>) -> Self {
        Self { row, found: found.into(), required: required.into() }
    }

    /// The same as bad input of a field.
    pub fn of(self, field: &str) -> InvalidInput {
        InvalidInput { field: format!("{field}[{}]", self.row), found: self.found, required: self.required }
    }
}

/// Deviation of a groove normal to its track, against the angle round the groove; one turn, closed.
#[derive(Debug, Clone, PartialEq)]
pub struct Profile {
    angle_rad: Vec<f64>,
    deviation_m: Vec<f64>,
}

impl Profile {
    /// From rows of rising angles (rad) that go once round, with their deviations (m); the last may repeat the first.
    ///
    /// # Errors
    /// [`Fault`] for the first row that cannot be: not a number, out of order, beyond one turn, a gap, a jump where the
    /// turn closes, a deviation that no groove has.
    pub fn new(angle_rad: &[f64], deviation_m: &[f64]) -> Result<Self, Fault> {
        if angle_rad.len() != deviation_m.len() {
            let row = angle_rad.len().min(deviation_m.len());
            let found = format!("{} angles and {} deviations", angle_rad.len(), deviation_m.len());
            return Err(Fault::new(row, found, "must be one deviation for each angle"));
        }
        check_numbers(angle_rad, deviation_m)?;
        let (mut angle_rad, mut deviation_m) = (angle_rad.to_vec(), deviation_m.to_vec());
        let last = angle_rad.len() - 1;
        let over_rad = angle_rad[last] - angle_rad[0] - TAU;
        if over_rad > CLOSED_RAD {
            let found = format!(
                "{} deg, {} deg from the first row",
                degrees(angle_rad[last]),
                degrees(TAU + over_rad)
            );
            return Err(Fault::new(last, found, "must stay within one turn of 360 deg from the first row"));
        }
        check_gaps(&angle_rad)?;
        check_closing(&angle_rad, &deviation_m)?;
        if over_rad.abs() <= CLOSED_RAD {
            angle_rad.pop();
            deviation_m.pop();
        }
        Ok(Self { angle_rad, deviation_m })
    }

    /// A profile from a function of the angle, at so many rows of equal distance.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn sampled(rows: usize, deviation_m: impl Fn(f64) -> f64) -> Result<Self, Fault> {
        let angles: Vec<f64> = (0..rows).map(|row| TAU * row as f64 / rows as f64).collect();
        let deviations: Vec<f64> = angles.iter().map(|angle| deviation_m(*angle)).collect();
        Self::new(&angles, &deviations)
    }

    /// The angles of its rows, rad.
    pub fn angle_rad(&self) -> &[f64] {
        &self.angle_rad
    }

    /// The deviations of its rows, m.
    pub fn deviation_m(&self) -> &[f64] {
        &self.deviation_m
    }

    /// Deviation at an angle, m: cubic between the two rows, with the slopes of the parabolas through three rows.
    pub fn at_m(&self, angle_rad: f64) -> f64 {
        let count = self.angle_rad.len();
        let turned = self.angle_rad[0] + (angle_rad - self.angle_rad[0]).rem_euclid(TAU);
        let after = self.angle_rad.partition_point(|angle| *angle <= turned);
        let before = after + count - 1;
        // Rows from the one before the interval to the one behind it, on a line that does not wrap.
        let row = |step: usize| {
            let place = before - 1 + step;
            let turns = (place / count) as f64 - 1.0;
            (self.angle_rad[place % count] + turns * TAU, self.deviation_m[place % count])
        };
        let [(x0, y0), (x1, y1), (x2, y2), (x3, y3)] = [row(0), row(1), row(2), row(3)];
        let slope = |(xa, ya): (f64, f64), (xb, yb): (f64, f64), (xc, yc): (f64, f64)| {
            let (left, right) = ((yb - ya) / (xb - xa), (yc - yb) / (xc - xb));
            (left * (xc - xb) + right * (xb - xa)) / (xc - xa)
        };
        let (first, second) = (slope((x0, y0), (x1, y1), (x2, y2)), slope((x1, y1), (x2, y2), (x3, y3)));
        let width = x2 - x1;
        let s = (turned - x1) / width;
        let r = 1.0 - s;
        y1 * r * r * (1.0 + 2.0 * s) + y2 * s * s * (1.0 + 2.0 * r) + width * s * r * (first * r - second * s)
    }
}

fn degrees(angle_rad: f64) -> f64 {
    (angle_rad * 180.0 / PI * 1e6).round() / 1e6
}

fn micrometres(length_m: f64) -> f64 {
    (length_m * 1e9).round() / 1e3
}

fn check_numbers(angle_rad: &[f64], deviation_m: &[f64]) -> Result<(), Fault> {
    if angle_rad.len() < FEWEST_ROWS {
        let found = format!("{} rows", angle_rad.len());
        let required = format!("must be {FEWEST_ROWS} rows or more, several for each wave of the groove");
        return Err(Fault::new(angle_rad.len().saturating_sub(1), found, required));
    }
    for (row, (angle, deviation)) in angle_rad.iter().zip(deviation_m).enumerate() {
        if !angle.is_finite() || !deviation.is_finite() {
            let found = if angle.is_finite() { deviation } else { angle }.to_string();
            return Err(Fault::new(
                row,
                found,
                "must be a finite number; leave out a row that was not measured",
            ));
        }
        if deviation.abs() > LARGEST_M {
            let found = format!("a deviation of {} um", micrometres(*deviation));
            let required = "must be 1000 um or less; check the unit of the deviations";
            return Err(Fault::new(row, found, required));
        }
        let before = row.checked_sub(1).map(|before| angle_rad[before]);
        if let Some(before) = before.filter(|before| angle <= before) {
            let found = format!("{} deg after {} deg", degrees(*angle), degrees(before));
            return Err(Fault::new(
                row,
                found,
                "angles must rise from row to row; sort the rows, each angle once",
            ));
        }
    }
    Ok(())
}

/// The deviation must come back to where it began: a drift of the measurement shows as a jump there.
fn check_closing(angle_rad: &[f64], deviation_m: &[f64]) -> Result<(), Fault> {
    let last = angle_rad.len() - 1;
    let step = |row: usize| (deviation_m[row + 1] - deviation_m[row]).abs();
    let largest = (0..last).map(step).fold(0.0, f64::max);
    let jump = (deviation_m[0] - deviation_m[last]).abs();
    if jump > RESOLVED_M && jump > JUMP * largest {
        let found = format!(
            "{} um at {} deg and {} um at {} deg, where the turn closes",
            micrometres(deviation_m[last]),
            degrees(angle_rad[last]),
            micrometres(deviation_m[0]),
            degrees(angle_rad[0]),
        );
        let required = "the profile must close after 360 deg; take the drift of the measurement out of it";
        return Err(Fault::new(last, found, required));
    }
    Ok(())
}

fn check_gaps(angle_rad: &[f64]) -> Result<(), Fault> {
    let count = angle_rad.len();
    let step = |row: usize| {
        if row + 1 < count {
            angle_rad[row + 1] - angle_rad[row]
        } else {
            angle_rad[0] + TAU - angle_rad[row]
        }
    };
    let mut steps: Vec<f64> = (0..count).map(step).collect();
    steps.sort_by(f64::total_cmp);
    let usual = steps[count / 2];
    match (0..count).find(|row| step(*row) > GAP * usual) {
        None => Ok(()),
        Some(row) => {
            let found = format!(
                "a gap from {} to {} deg, where rows are usually {} deg apart",
                degrees(angle_rad[row]),
                degrees(angle_rad[row] + step(row)),
                degrees(usual),
            );
            Err(Fault::new(
                row,
                found,
                "must go all the way round the groove; measure or fill in what is missing",
            ))
        }
    }
}

/// Offset and tilt of a plate, both fixed in the plate and turning with it.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Plate {
    /// Shift of its grooves from the axis that it turns about, along its angles 0 and 90 deg, m.
    pub offset_m: [f64; 2],
    /// Tilt that lifts it towards the deceleration balls at its angles 0 and 90 deg, rad; of the ring plate towards its own
    /// balls.
    pub tilt_rad: [f64; 2],
}

impl Plate {
    fn check(&self, name: &str) -> Result<(), InvalidInput> {
        let numbers = [("offset_m", self.offset_m, LARGEST_M), ("tilt_rad", self.tilt_rad, LARGEST_RAD)];
        for (what, pair, limit) in numbers {
            for (place, value) in pair.iter().enumerate() {
                if !value.is_finite() || value.abs() > limit {
                    let rule = format!("must lie between {} and {limit}; check its unit", -limit);
                    return Err(InvalidInput::new(format!("as_made.{name}_{what}[{place}]"), value, rule));
                }
            }
        }
        Ok(())
    }
}

/// What was measured of the parts of a drive; what is absent is nominal.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct AsMade {
    /// Profile of the epicycloid groove.
    pub epicycloid: Option<Profile>,
    /// Profile of the hypocycloid groove.
    pub hypocycloid: Option<Profile>,
    /// Profiles of the planet's ring grooves, ring by ring; empty: nominal.
    pub planet_rings: Vec<Profile>,
    /// Profiles of the ring grooves that face them, ring by ring; empty: nominal.
    pub facing_rings: Vec<Profile>,
    /// Diameters of the deceleration balls, m; empty: nominal.
    pub deceleration_balls_m: Vec<f64>,
    /// Diameters of the equal-speed balls, m, of a cross-slide row after row; empty: nominal.
    pub equal_speed_balls_m: Vec<f64>,
    /// The plate with the epicycloid groove.
    pub epicycloid_plate: Plate,
    /// The plate with the hypocycloid groove.
    pub hypocycloid_plate: Plate,
    /// The plate whose ring grooves face the planet's.
    pub ring_plate: Plate,
}

/// How many of each the drive has.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Counts {
    /// Deceleration balls.
    pub deceleration: u32,
    /// Equal-speed balls, of all rows.
    pub equal_speed: u32,
    /// Ring grooves of a plate; 0 of a cross-slide.
    pub rings: u32,
    /// Nominal diameters of the balls, m.
    pub diameters_m: [f64; 2],
}

impl AsMade {
    /// Whether every part is nominal.
    pub fn is_nominal(&self) -> bool {
        *self == Self::default()
    }

    /// Checks that the tables fit a drive.
    pub(crate) fn check(&self, counts: &Counts) -> Result<(), InvalidInput> {
        let tables = [
            ("deceleration_ball_diameter_m", &self.deceleration_balls_m, counts.deceleration, 0),
            ("equal_speed_ball_diameter_m", &self.equal_speed_balls_m, counts.equal_speed, 1),
        ];
        for (name, diameters, count, pair) in tables {
            check_balls(&format!("as_made.{name}"), diameters, count, counts.diameters_m[pair])?;
        }
        for (name, rings) in [("planet_ring", &self.planet_rings), ("facing_ring", &self.facing_rings)] {
            if !rings.is_empty() && rings.len() != counts.rings as usize {
                let rule = match counts.rings {
                    0 => "this drive has no ring grooves; leave out the table".to_owned(),
                    count => format!("must be one profile for each of the {count} rings"),
                };
                return Err(InvalidInput::new(
                    format!("as_made.{name}"),
                    format!("{} rings", rings.len()),
                    rule,
                ));
            }
        }
        self.epicycloid_plate.check("epicycloid_plate")?;
        self.hypocycloid_plate.check("hypocycloid_plate")?;
        self.ring_plate.check("ring_plate")?;
        if counts.rings == 0 && self.ring_plate != Plate::default() {
            let rule = "this drive has no ring grooves; leave out the plate";
            return Err(InvalidInput::new("as_made.ring_plate_offset_m", "an offset or tilt", rule));
        }
        Ok(())
    }
}

fn check_balls(field: &str, diameters_m: &[f64], count: u32, nominal_m: f64) -> Result<(), InvalidInput> {
    if diameters_m.is_empty() {
        return Ok(());
    }
    if diameters_m.len() != count as usize {
        let rule = format!("must be one diameter for each of the {count} balls");
        return Err(InvalidInput::new(field, format!("{} diameters", diameters_m.len()), rule));
    }
    for (row, diameter) in diameters_m.iter().enumerate() {
        if !diameter.is_finite() || (diameter - nominal_m).abs() > LARGEST_M.min(0.1 * nominal_m) {
            let required = format!(
                "must be near the nominal diameter of {} mm, twice ball_radius; check the unit, and that it is no radius",
                degrees(nominal_m * PI / 180.0 * 1e3)
            );
            return Err(Fault::new(row, format!("{} mm", diameter * 1e3), required).of(field));
        }
    }
    Ok(())
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    fn angles(count: usize) -> Vec<f64> {
        (0..count).map(|row| TAU * row as f64 / count as f64).collect()
    }

    #[test]
    fn it_goes_through_its_rows_and_follows_a_wave_between_them() {
        let wave = |t: f64| 3e-6 * (5.0 * t + 0.4).cos();
        let profile = Profile::sampled(720, wave).unwrap();
        for row in [0, 1, 359, 719] {
            let angle = profile.angle_rad()[row];
            assert!((profile.at_m(angle) - profile.deviation_m()[row]).abs() < 1e-20);
        }
        for step in 0..1000 {
            let angle = -9.0 + 0.0317 * f64::from(step);
            assert!((profile.at_m(angle) - wave(angle)).abs() < 3e-6 * 1e-5, "{angle}");
        }
    }

    #[test]
    fn the_last_row_may_repeat_the_first() {
        let mut with_end = angles(36);
        with_end.push(TAU);
        let mut deviations: Vec<f64> = with_end.iter().map(|t| 1e-6 * t.sin()).collect();
        deviations[36] = deviations[0];
        assert_eq!(Profile::new(&with_end, &deviations), Profile::new(&with_end[..36], &deviations[..36]));
    }

    #[test]
    fn unequal_steps_are_no_matter() {
        let uneven: Vec<f64> = angles(400).iter().map(|t| t + 0.002 * (7.0 * t).sin()).collect();
        let deviations: Vec<f64> = uneven.iter().map(|t| 1e-6 * (3.0 * t).sin()).collect();
        let profile = Profile::new(&uneven, &deviations).unwrap();
        for step in 0..500 {
            let angle = 0.0126 * f64::from(step);
            assert!((profile.at_m(angle) - 1e-6 * (3.0 * angle).sin()).abs() < 1e-11, "{angle}");
        }
    }

    #[test]
    fn bad_tables_name_their_row() {
        let good = angles(100);
        let flat = vec![0.0; 100];
        let changed = |row: usize, value: f64| {
            let mut values = flat.clone();
            values[row] = value;
            values
        };
        let fault = |angles: &[f64], deviations: &[f64]| Profile::new(angles, deviations).unwrap_err();
        assert_eq!(fault(&good, &changed(7, f64::NAN)).row, 7);
        assert_eq!(fault(&good, &changed(8, 0.012)).row, 8);
        assert_eq!(fault(&good, &flat[..99]).row, 99);
        let mut unsorted = good.clone();
        unsorted.swap(40, 41);
        assert_eq!(fault(&unsorted, &flat).row, 41);
        let hole: Vec<f64> = good.iter().copied().filter(|t| !(1.0..2.0).contains(t)).collect();
        let found = fault(&hole, &flat[..hole.len()]);
        assert!(found.row == 15 && found.found.contains("gap"), "{found:?}");
        let half = fault(&good[..50], &flat[..50]);
        assert!(half.row == 49 && half.found.contains("gap"), "{half:?}");
        let drift: Vec<f64> = good.iter().map(|t| 1e-6 * t).collect();
        let found = fault(&good, &drift);
        assert!(found.row == 99 && found.required.contains("360 deg"), "{found:?}");
        let in_degrees: Vec<f64> = good.iter().map(|t| t.to_degrees()).collect();
        assert!(fault(&in_degrees, &flat).required.contains("one turn"));
        assert!(fault(&good[..3], &flat[..3]).required.contains("8 rows"));
    }
}
