//! Lists of the section of parts as made to what the core takes, and back.

use std::collections::BTreeMap;

use cbpt_core::as_made::{AsMade, Fault, Plate, Profile};
use cbpt_core::geometry::trochoid::{Groove, groove_angle_rad};
use cbpt_core::{Deceleration, InvalidInput};

use super::fields::AS_MADE;
use super::keys::dotted;

pub(super) const EPICYCLOID: [&str; 3] =
    ["epicycloid_groove_angle_rad", "epicycloid_polar_angle_rad", "epicycloid_deviation_m"];
pub(super) const HYPOCYCLOID: [&str; 3] =
    ["hypocycloid_groove_angle_rad", "hypocycloid_polar_angle_rad", "hypocycloid_deviation_m"];
pub(super) const PLANET_RINGS: [&str; 3] =
    ["planet_ring", "planet_ring_angle_rad", "planet_ring_deviation_m"];
pub(super) const FACING_RINGS: [&str; 3] =
    ["facing_ring", "facing_ring_angle_rad", "facing_ring_deviation_m"];
pub(super) const BALLS: [&str; 2] = ["deceleration_ball_diameter_m", "equal_speed_ball_diameter_m"];

/// The lists of a case by their names.
pub(super) trait Lists {
    /// The list of this name, if there is one.
    fn reals(&self, name: &str) -> Option<&[f64]>;
}

/// The parts of the lists.
pub(super) fn as_made(values: &impl Lists, pair: &Deceleration) -> Result<AsMade, InvalidInput> {
    let balls = |list| values.reals(&dotted(AS_MADE, list)).unwrap_or_default().to_vec();
    Ok(AsMade {
        epicycloid: groove(values, &EPICYCLOID, Groove::Epicycloid, pair)?,
        hypocycloid: groove(values, &HYPOCYCLOID, Groove::Hypocycloid, pair)?,
        planet_rings: rings(values, &PLANET_RINGS)?,
        facing_rings: rings(values, &FACING_RINGS)?,
        deceleration_balls_m: balls(BALLS[0]),
        equal_speed_balls_m: balls(BALLS[1]),
        epicycloid_plate: plate(values, "epicycloid_plate")?,
        hypocycloid_plate: plate(values, "hypocycloid_plate")?,
        ring_plate: plate(values, "ring_plate")?,
    })
}

fn groove(
    values: &impl Lists,
    [along, polar, deviation]: &[&'static str; 3],
    groove: Groove,
    pair: &Deceleration,
) -> Result<Option<Profile>, InvalidInput> {
    let [along, polar, deviation] = [along, polar, deviation].map(|name| dotted(AS_MADE, name));
    let angles = match (values.reals(&along), values.reals(&polar)) {
        (Some(_), Some(_)) => {
            return Err(InvalidInput::new(
                polar,
                "a second list of angles",
                "keep the groove angles or the polar ones",
            ));
        }
        (Some(along), None) => Some(along.to_vec()),
        (None, Some(polar)) => {
            Some(polar.iter().map(|angle| groove_angle_rad(pair, groove, *angle)).collect())
        }
        (None, None) => None,
    };
    match (angles, values.reals(&deviation)) {
        (None, None) => Ok(None),
        (Some(angles), Some(deviations)) => {
            Profile::new(&angles, deviations).map(Some).map_err(|fault| fault.of(&deviation))
        }
        (None, Some(_)) => {
            Err(InvalidInput::new(deviation, "deviations alone", format!("needs {along} as well")))
        }
        (Some(_), None) => {
            Err(InvalidInput::new(along, "angles alone", format!("needs {deviation} as well")))
        }
    }
}

fn rings(values: &impl Lists, names: &[&'static str; 3]) -> Result<Vec<Profile>, InvalidInput> {
    let names = names.map(|name| dotted(AS_MADE, name));
    let lists: Vec<&[f64]> = names.iter().filter_map(|name| values.reals(name)).collect();
    let [numbers, angles, deviations] = lists[..] else {
        let given = names.iter().find(|name| values.reals(name).is_some());
        return given.map_or(Ok(Vec::new()), |given| {
            Err(InvalidInput::new(given, "one list", format!("needs all of {}", names.join(", "))))
        });
    };
    if numbers.len() != angles.len() || numbers.len() != deviations.len() {
        let found = format!("{}, {} and {} entries", numbers.len(), angles.len(), deviations.len());
        return Err(InvalidInput::new(&names[0], found, "must be three lists of one length"));
    }
    let by_ring = by_ring(numbers).map_err(|fault| fault.of(&names[0]))?;
    let profile = |places: Vec<usize>| {
        let pick = |list: &[f64]| places.iter().map(|place| list[*place]).collect::<Vec<_>>();
        let at_place = |fault: Fault| Fault { row: places[fault.row.min(places.len() - 1)], ..fault };
        Profile::new(&pick(angles), &pick(deviations)).map_err(|fault| at_place(fault).of(&names[2]))
    };
    by_ring.into_values().map(profile).collect()
}

fn plate(values: &impl Lists, name: &str) -> Result<Plate, InvalidInput> {
    let two = |what: &str| {
        let name = dotted(AS_MADE, &format!("{name}_{what}"));
        match values.reals(&name) {
            None => Ok([0.0; 2]),
            Some([x, y]) => Ok([*x, *y]),
            Some(others) => {
                Err(InvalidInput::new(name, format!("{} numbers", others.len()), "must be two numbers"))
            }
        }
    };
    Ok(Plate { offset_m: two("offset_m")?, tilt_rad: two("tilt_rad")? })
}

/// The inverse of [`as_made`]: every list that is not empty, by its name.
pub(super) fn lists(parts: &AsMade) -> Vec<(String, Vec<f64>)> {
    let mut found = Vec::new();
    let mut list = |name: &str, list: Vec<f64>| {
        if !list.is_empty() {
            found.push((dotted(AS_MADE, name), list));
        }
    };
    for ([angle, _, deviation], profile) in
        [(EPICYCLOID, &parts.epicycloid), (HYPOCYCLOID, &parts.hypocycloid)]
    {
        if let Some(profile) = profile {
            list(angle, profile.angle_rad().to_vec());
            list(deviation, profile.deviation_m().to_vec());
        }
    }
    for ([number, angle, deviation], rings) in
        [(PLANET_RINGS, &parts.planet_rings), (FACING_RINGS, &parts.facing_rings)]
    {
        let of_ring = |(ring, profile): (usize, &Profile)| vec![ring as f64; profile.angle_rad().len()];
        list(number, rings.iter().enumerate().flat_map(of_ring).collect());
        list(angle, rings.iter().flat_map(|profile| profile.angle_rad().to_vec()).collect());
        list(deviation, rings.iter().flat_map(|profile| profile.deviation_m().to_vec()).collect());
    }
    list(BALLS[0], parts.deceleration_balls_m.clone());
    list(BALLS[1], parts.equal_speed_balls_m.clone());
    let plates = [
        ("epicycloid_plate", &parts.epicycloid_plate),
        ("hypocycloid_plate", &parts.hypocycloid_plate),
        ("ring_plate", &parts.ring_plate),
    ];
    for (name, plate) in plates {
        for (what, numbers) in [("offset_m", plate.offset_m), ("tilt_rad", plate.tilt_rad)] {
            if numbers.iter().any(|number| *number != 0.0) {
                list(&format!("{name}_{what}"), numbers.to_vec());
            }
        }
    }
    found
}

/// Places of the rows of each ring, from ring 0.
pub(super) fn by_ring(numbers: &[f64]) -> Result<BTreeMap<usize, Vec<usize>>, Fault> {
    let mut rings: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
    for (place, number) in numbers.iter().enumerate() {
        let Some(ring) = whole(*number) else {
            let (found, required) =
                (format!("ring = {number}"), "must be the number of a ring, from 0".into());
            return Err(Fault { row: place, found, required });
        };
        rings.entry(ring).or_default().push(place);
    }
    match (0..rings.len()).find(|ring| !rings.contains_key(ring)) {
        Some(missing) => {
            let required = format!("ring {missing} has no row; number the rings from 0, without gaps");
            Err(Fault { row: 0, found: format!("{} rings", rings.len()), required })
        }
        None => Ok(rings),
    }
}

/// A number that counts parts.
pub(super) fn whole(number: f64) -> Option<usize> {
    format!("{number}").parse().ok().filter(|number| *number < 10_000)
}
