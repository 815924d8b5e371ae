//! Values of the keys to a case, and a case back to values.

use std::collections::BTreeMap;

use cbpt_core::{
    CrossSlide, CrossSlideForm, CrossSlideShare, Deceleration, Drive, Elasticity, EqualSpeed, GrooveSection,
    InvalidInput, Load, Material, OutputPlate, Reducer, RingGroove, TorsionSpring, TrackCurvature,
};

use super::fields;
use super::keys::{self, Value};
use super::parts::{self, Lists};
use super::{
    Case, Friction, History, LoadDefaults, Measurement, Operation, Rating, TorqueTurns, Uncertainty, Zero,
};

/// Values in SI by their dotted names: `deceleration.ball_radius_m`.
#[derive(Debug, Clone, Default)]
pub(super) struct Values(BTreeMap<String, Value>);

/// Names that may be given by a more general one instead.
const GENERAL: [(&str, &str); 7] = [
    ("material.ball_youngs_modulus_Pa", "material.youngs_modulus_Pa"),
    ("material.ball_poissons_ratio", "material.poissons_ratio"),
    ("material.plate_youngs_modulus_Pa", "material.youngs_modulus_Pa"),
    ("material.plate_poissons_ratio", "material.poissons_ratio"),
    ("material.pressure_limit_Pa", "material.contact_pressure_limit_Pa"),
    ("equal_speed.outside_contact_angle_rad", "equal_speed.contact_angle_rad"),
    ("equal_speed.inside_contact_angle_rad", "equal_speed.contact_angle_rad"),
];

/// The names that stand before a more general one where they are given.
pub(super) fn special_of(general: &str) -> impl Iterator<Item = &'static str> {
    GENERAL.into_iter().filter(move |(_, known)| *known == general).map(|(special, _)| special)
}

/// The keys of the one setting that may stand in three places.
pub(super) const TRACK_CURVATURE: [&str; 3] =
    ["deceleration.track_curvature", "equal_speed.track_curvature", "track_curvature"];

impl Values {
    pub(super) fn has(&self, name: &str) -> bool {
        self.0.contains_key(name)
    }

    pub(super) fn set(&mut self, name: impl Into<String>, value: Value) {
        self.0.insert(name.into(), value);
    }

    pub(super) fn remove(&mut self, name: &str) {
        self.0.remove(name);
    }

    pub(super) fn get(&self, name: &str) -> Option<&Value> {
        self.0.get(name)
    }

    /// The name under which a value is given: itself, or the more general one.
    pub(super) fn given_as<'a>(&self, name: &'a str) -> &'a str {
        let general = GENERAL.iter().find(|(special, _)| *special == name && !self.has(name));
        general.map_or(name, |(_, general)| general)
    }

    pub(super) fn real(&self, name: &str) -> Option<f64> {
        match self.get(self.given_as(name)) {
            Some(Value::Real(value)) => Some(*value),
            _ => None,
        }
    }

    pub(super) fn text(&self, name: &str) -> Option<&str> {
        match self.get(name) {
            Some(Value::Text(text)) => Some(text),
            _ => None,
        }
    }

    fn number(&self, name: &str) -> Result<f64, InvalidInput> {
        self.real(name).ok_or_else(|| missing(name))
    }

    fn count(&self, name: &str) -> Result<u32, InvalidInput> {
        match self.get(name) {
            Some(Value::Count(count)) => Ok(*count),
            _ => Err(missing(name)),
        }
    }

    fn choice<T: Copy>(&self, name: &str, words: &[(&str, T)]) -> Result<T, InvalidInput> {
        let word = self.text(name).ok_or_else(|| missing(name))?;
        words.iter().find(|(known, _)| *known == word).map(|(_, meant)| *meant).ok_or_else(|| missing(name))
    }
}

impl Lists for Values {
    fn reals(&self, name: &str) -> Option<&[f64]> {
        match self.get(name) {
            Some(Value::Reals(list)) => Some(list),
            _ => None,
        }
    }
}

fn missing(name: &str) -> InvalidInput {
    InvalidInput::new(name, "nothing", "is required")
}

const TRACK_CURVATURES: [(&str, TrackCurvature); 2] =
    [("exact", TrackCurvature::Exact), ("neglect", TrackCurvature::Neglect)];
const OUTPUT_PLATES: [(&str, OutputPlate); 2] =
    [("hypocycloid", OutputPlate::Hypocycloid), ("epicycloid", OutputPlate::Epicycloid)];
const FORMS: [(&str, CrossSlideForm); 2] =
    [("balanced", CrossSlideForm::Balanced), ("paper", CrossSlideForm::Paper)];
const SHARES: [(&str, CrossSlideShare); 2] =
    [("carried", CrossSlideShare::Carried), ("paper", CrossSlideShare::Paper)];
const ZEROS: [(&str, Zero); 2] = [("common", Zero::Common), ("per_run", Zero::PerRun)];

/// The case without its effects. The mechanics check its numbers and name the first that cannot be.
pub(super) fn case(values: &Values) -> Result<Case, InvalidInput> {
    Ok(Case {
        reducer: reducer(values)?,
        load: load(values)?,
        measurement: Measurement {
            zero: values.choice("measurement.zero", &ZEROS)?,
            lever_arm_m: values.real("measurement.lever_arm_m"),
            friction_between_runs: values.choice("measurement.friction_between_runs", &History::WORDS)?,
            torque_turns: values.choice("measurement.torque_turns", &TorqueTurns::WORDS)?,
        },
        rating: Rating { rated_torque_Nm: values.real("rating.rated_torque_Nm") },
        friction: Friction {
            coefficient: values.number("friction.coefficient")?,
            coefficient_uncertainty: values.number("friction.coefficient_uncertainty")?,
        },
        operation: Operation {
            input_speed_rad_per_s: values.real(INPUT_SPEED),
            output_inertia_kg_m2: values.real(OUTPUT_INERTIA),
            planet_mass_kg: values.real(PLANET_MASS),
            static_safety: values.number("operation.static_safety")?,
        },
        uncertainty: uncertainty(values)?,
        tolerance: tolerance(values),
        effects: Vec::new(),
    })
}

const INPUT_SPEED: &str = "operation.input_speed_rad_per_s";
const OUTPUT_INERTIA: &str = "operation.output_inertia_kg_m2";
const PLANET_MASS: &str = "operation.planet_mass_kg";

/// The reducer alone.
pub(super) fn reducer(values: &Values) -> Result<Reducer, InvalidInput> {
    Ok(if values.has(SPRING_TORQUE) || values.has(SPRING_STIFFNESS) {
        torsion_spring(values)?.into()
    } else {
        ball_drive(values)?.into()
    })
}

const SPRING_STIFFNESS: &str = "torsion_spring.torsional_stiffness_Nm_per_rad";
const SPRING_TORQUE: &str = "torsion_spring.torque_Nm";
const SPRING_ANGLE: &str = "torsion_spring.elastic_angle_rad";
const SPRING_RADIUS: &str = "torsion_spring.reference_radius_m";

fn torsion_spring(values: &Values) -> Result<TorsionSpring, InvalidInput> {
    let radius = values.real(SPRING_RADIUS);
    let list = |name: &str| values.reals(name).ok_or_else(|| missing(name));
    match values.real(SPRING_STIFFNESS) {
        Some(stiffness) => TorsionSpring::linear(stiffness, radius),
        None => TorsionSpring::table(list(SPRING_TORQUE)?, list(SPRING_ANGLE)?, radius),
    }
}

fn ball_drive(values: &Values) -> Result<Drive, InvalidInput> {
    let track_curvature = TRACK_CURVATURE.into_iter().find(|name| values.has(name)).unwrap_or_default();
    let deceleration = deceleration(values)?;
    let curvature = values.choice(track_curvature, &TRACK_CURVATURES)?;
    let made = parts::as_made(values, &deceleration)?;
    Drive::new(material(values)?, deceleration, equal_speed(values)?, curvature)?.with_as_made(made)
}

fn material(values: &Values) -> Result<Material, InvalidInput> {
    Ok(Material {
        ball: Elasticity {
            youngs_modulus_Pa: values.number("material.ball_youngs_modulus_Pa")?,
            poissons_ratio: values.number("material.ball_poissons_ratio")?,
        },
        plate: Elasticity {
            youngs_modulus_Pa: values.number("material.plate_youngs_modulus_Pa")?,
            poissons_ratio: values.number("material.plate_poissons_ratio")?,
        },
        pressure_limit_Pa: values.number("material.pressure_limit_Pa")?,
    })
}

fn groove(values: &Values, pair: &str) -> Result<GrooveSection, InvalidInput> {
    Ok(GrooveSection {
        ball_radius_m: values.number(&format!("{pair}.ball_radius_m"))?,
        groove_conformity: values.number(&format!("{pair}.groove_conformity"))?,
        groove_depth_m: values.real(&format!("{pair}.groove_depth_m")),
    })
}

fn deceleration(values: &Values) -> Result<Deceleration, InvalidInput> {
    Ok(Deceleration {
        ball_count: values.count("deceleration.ball_count")?,
        short_amplitude_coefficient: values.number("deceleration.short_amplitude_coefficient")?,
        rolling_circle_radius_m: values.number("deceleration.rolling_circle_radius_m")?,
        contact_angle_rad: values.number("deceleration.contact_angle_rad")?,
        groove: groove(values, "deceleration")?,
        output_plate: values.choice("deceleration.output_plate", &OUTPUT_PLATES)?,
    })
}

fn equal_speed(values: &Values) -> Result<EqualSpeed, InvalidInput> {
    let ball_count = values.count("equal_speed.ball_count")?;
    let pitch_radius_m = values.number("equal_speed.pitch_radius_m")?;
    let groove = groove(values, "equal_speed")?;
    Ok(match values.text("equal_speed.kind") {
        Some("cross_slide") => EqualSpeed::CrossSlide(CrossSlide {
            ball_count,
            pitch_radius_m,
            contact_angle_rad: values.number("equal_speed.contact_angle_rad")?,
            groove,
            form: values.choice("equal_speed.form", &FORMS)?,
            share: values.choice("equal_speed.torque_share", &SHARES)?,
        }),
        _ => EqualSpeed::RingGroove(RingGroove {
            ball_count,
            pitch_radius_m,
            outside_contact_angle_rad: values.number("equal_speed.outside_contact_angle_rad")?,
            inside_contact_angle_rad: values.number("equal_speed.inside_contact_angle_rad")?,
            groove,
        }),
    })
}

/// Each default may be absent; those that are given must be a load that can be.
fn load(values: &Values) -> Result<LoadDefaults, InvalidInput> {
    let torque_Nm = values.real("load.torque_Nm");
    let preload_N = values.real("load.preload_N");
    let input_angle_rad = values.real("load.input_angle_rad");
    Load::new(torque_Nm.unwrap_or(0.0), preload_N.unwrap_or(1.0), input_angle_rad.unwrap_or(0.0))
        .map_err(|invalid| InvalidInput { field: format!("load.{}", invalid.field), ..invalid })?;
    Ok(LoadDefaults { torque_Nm, preload_N, input_angle_rad })
}

fn uncertainty(values: &Values) -> Result<Uncertainty, InvalidInput> {
    let of_drive = fields::uncertain().filter_map(|(section, key)| {
        let name = section.si_name(key);
        let value = values.real(&format!("uncertainty.{}", fields::uncertainty_of(&name)))?;
        Some((name, value))
    });
    Ok(Uncertainty {
        contact_stiffness_rel: values.number("uncertainty.contact_stiffness_rel")?,
        contact_angle_rad: values.number("uncertainty.contact_angle_rad")?,
        torque_gain_rel: values.number("uncertainty.torque_gain_rel")?,
        preload_gain_rel: values.number("uncertainty.preload_gain_rel")?,
        sensor_gain_rel: values.number("uncertainty.sensor_gain_rel")?,
        of_drive: of_drive.collect(),
    })
}

fn tolerance(values: &Values) -> BTreeMap<String, f64> {
    let limit = |(section, key): (&keys::Section, &keys::Key)| {
        let name = section.si_name(key);
        let value = values.real(&format!("tolerance.{}", fields::uncertainty_of(&name)))?;
        Some((name, value))
    };
    fields::tolerated().filter_map(limit).collect()
}

/// The inverse of [`case`]: the fewest values that give the case, its defaults spelled out.
pub(super) fn values(case: &Case) -> Values {
    let mut values = reducer_values(&case.reducer);
    values.set_some("load.torque_Nm", case.load.torque_Nm);
    values.set_some("load.preload_N", case.load.preload_N);
    values.set_some("load.input_angle_rad", case.load.input_angle_rad);
    values.set_word("measurement.zero", case.measurement.zero, &ZEROS);
    let between = case.measurement.friction_between_runs;
    values.set_word("measurement.friction_between_runs", between, &History::WORDS);
    values.set_word("measurement.torque_turns", case.measurement.torque_turns, &TorqueTurns::WORDS);
    values.set_some("measurement.lever_arm_m", case.measurement.lever_arm_m);
    values.set_some("rating.rated_torque_Nm", case.rating.rated_torque_Nm);
    values.set_real("friction.coefficient", case.friction.coefficient);
    values.set_real("friction.coefficient_uncertainty", case.friction.coefficient_uncertainty);
    values.set_some(INPUT_SPEED, case.operation.input_speed_rad_per_s);
    values.set_some(OUTPUT_INERTIA, case.operation.output_inertia_kg_m2);
    values.set_some(PLANET_MASS, case.operation.planet_mass_kg);
    values.set_real("operation.static_safety", case.operation.static_safety);
    values.set_uncertainty(&case.uncertainty);
    for (name, value) in &case.tolerance {
        values.set_real(format!("tolerance.{}", fields::uncertainty_of(name)), *value);
    }
    values
}

/// The part of [`values`] that the reducer alone needs.
pub(super) fn reducer_values(reducer: &Reducer) -> Values {
    match reducer {
        Reducer::BallDrive(drive) => drive_values(drive),
        Reducer::TorsionSpring(spring) => spring_values(spring),
    }
}

fn spring_values(spring: &TorsionSpring) -> Values {
    let mut values = Values::default();
    values.set_some(SPRING_STIFFNESS, spring.torsional_stiffness_Nm_per_rad());
    values.set_some(SPRING_RADIUS, spring.reference_radius_m());
    let points = spring.points();
    if !points.is_empty() {
        for (column, name) in [SPRING_TORQUE, SPRING_ANGLE].into_iter().enumerate() {
            values.set(name, Value::Reals(points.iter().map(|point| point[column]).collect()));
        }
    }
    values
}

fn drive_values(drive: &Drive) -> Values {
    let mut values = Values::default();
    values.set_word("track_curvature", drive.track_curvature(), &TRACK_CURVATURES);
    values.set_material(drive.material());
    values.set_deceleration(drive.deceleration());
    values.set_equal_speed(drive.equal_speed());
    for (name, list) in drive.as_made().map(parts::lists).unwrap_or_default() {
        values.set(name, Value::Reals(list));
    }
    values
}

impl Values {
    fn set_real(&mut self, name: impl Into<String>, value: f64) {
        self.set(name, Value::Real(value));
    }

    fn set_some(&mut self, name: impl Into<String>, value: Option<f64>) {
        if let Some(value) = value {
            self.set_real(name, value);
        }
    }

    fn set_word<T: Copy + PartialEq>(&mut self, name: &str, meant: T, words: &[(&str, T)]) {
        if let Some((word, _)) = words.iter().find(|(_, known)| *known == meant) {
            self.set(name, Value::Text((*word).into()));
        }
    }

    /// One value under the general name where both are the same.
    #[expect(clippy::float_cmp, reason = "only the very same number may be written once for both")]
    fn set_pair(&mut self, general: &str, (first, a): (&str, f64), (second, b): (&str, f64)) {
        if a == b {
            self.set_real(general, a);
        } else {
            self.set_real(first, a);
            self.set_real(second, b);
        }
    }

    fn set_material(&mut self, material: &Material) {
        let Material { ball, plate, pressure_limit_Pa } = material;
        self.set_pair(
            "material.youngs_modulus_Pa",
            ("material.ball_youngs_modulus_Pa", ball.youngs_modulus_Pa),
            ("material.plate_youngs_modulus_Pa", plate.youngs_modulus_Pa),
        );
        self.set_pair(
            "material.poissons_ratio",
            ("material.ball_poissons_ratio", ball.poissons_ratio),
            ("material.plate_poissons_ratio", plate.poissons_ratio),
        );
        self.set_real("material.contact_pressure_limit_Pa", *pressure_limit_Pa);
    }

    fn set_groove(&mut self, pair: &str, groove: &GrooveSection) {
        self.set_real(format!("{pair}.ball_radius_m"), groove.ball_radius_m);
        self.set_real(format!("{pair}.groove_conformity"), groove.groove_conformity);
        self.set_some(format!("{pair}.groove_depth_m"), groove.groove_depth_m);
    }

    fn set_deceleration(&mut self, pair: &Deceleration) {
        self.set("deceleration.ball_count", Value::Count(pair.ball_count));
        self.set_real("deceleration.short_amplitude_coefficient", pair.short_amplitude_coefficient);
        self.set_real("deceleration.rolling_circle_radius_m", pair.rolling_circle_radius_m);
        self.set_real("deceleration.contact_angle_rad", pair.contact_angle_rad);
        self.set_groove("deceleration", &pair.groove);
        self.set_word("deceleration.output_plate", pair.output_plate, &OUTPUT_PLATES);
    }

    fn set_equal_speed(&mut self, pair: &EqualSpeed) {
        self.set("equal_speed.ball_count", Value::Count(pair.ball_count()));
        self.set_real("equal_speed.pitch_radius_m", pair.pitch_radius_m());
        self.set_groove("equal_speed", pair.groove());
        match pair {
            EqualSpeed::RingGroove(ring) => {
                self.set("equal_speed.kind", Value::Text("ring_groove".into()));
                self.set_pair(
                    "equal_speed.contact_angle_rad",
                    ("equal_speed.outside_contact_angle_rad", ring.outside_contact_angle_rad),
                    ("equal_speed.inside_contact_angle_rad", ring.inside_contact_angle_rad),
                );
            }
            EqualSpeed::CrossSlide(slide) => {
                self.set("equal_speed.kind", Value::Text("cross_slide".into()));
                self.set_real("equal_speed.contact_angle_rad", slide.contact_angle_rad);
                self.set_word("equal_speed.form", slide.form, &FORMS);
                self.set_word("equal_speed.torque_share", slide.share, &SHARES);
            }
        }
    }

    fn set_uncertainty(&mut self, uncertainty: &Uncertainty) {
        self.set_real("uncertainty.contact_stiffness_rel", uncertainty.contact_stiffness_rel);
        self.set_real("uncertainty.contact_angle_rad", uncertainty.contact_angle_rad);
        self.set_real("uncertainty.torque_gain_rel", uncertainty.torque_gain_rel);
        self.set_real("uncertainty.preload_gain_rel", uncertainty.preload_gain_rel);
        self.set_real("uncertainty.sensor_gain_rel", uncertainty.sensor_gain_rel);
        for (name, value) in &uncertainty.of_drive {
            self.set_real(format!("uncertainty.{}", fields::uncertainty_of(name)), *value);
        }
    }
}
