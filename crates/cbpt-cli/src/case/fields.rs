//! The table of sections and keys. Reading, messages, JSON Schema, reference and writing all follow it.
//!
//! First how a section is found and which numbers may scatter, then each section in the order of the file; what sections and
//! keys are is said in `keys`.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};
use std::ops::Bound::{Excluded, Included, Unbounded};
use std::sync::LazyLock;

use cbpt_core::units::Quantity;
use cbpt_core::{Elasticity, Material};

use super::keys::{ANY, Key, Kind, Need, PORTS, Range, Section, Value, dotted};
use super::{Friction, Operation, library};

const NOT_NEGATIVE: Range = (Included(0.0), Unbounded);
const ACUTE: Range = (Excluded(0.0), Excluded(FRAC_PI_2));

/// The section of any other reducer, which stands in place of those.
pub(super) const SPRING: &str = "torsion_spring";

/// All sections in the order in which they are written.
pub(super) fn sections() -> &'static [Section] {
    &SECTIONS
}

/// The keys above the first section.
pub(super) fn top() -> &'static Section {
    &SECTIONS[0]
}

/// A section by its name.
pub(super) fn section(name: &str) -> Option<&'static Section> {
    SECTIONS.iter().find(|section| section.name == name && !name.is_empty())
}

/// The section of each effect.
pub(super) fn effect() -> &'static Section {
    &SECTIONS[SECTIONS.len() - 1]
}

/// One parameter of the user's own effect.
pub(super) fn parameter() -> &'static Section {
    &PARAMETER
}

/// The numbers of the drive whose standard uncertainty can be stated, with their sections.
pub(super) fn uncertain() -> impl Iterator<Item = (&'static Section, &'static Key)> {
    let numbers = |section: &'static Section| section.keys.iter().map(move |key| (section, key));
    SECTIONS
        .iter()
        .filter(|section| DRIVE.contains(&section.name))
        .flat_map(numbers)
        .filter(|(_, key)| uncertain_key(key))
}

/// The sections of a ball drive.
pub(super) const DRIVE: [&str; 4] = ["material", "deceleration", "equal_speed", AS_MADE];

/// The section of the parts as they were made.
pub(super) const AS_MADE: &str = "as_made";

/// Limits of checks have no part in the elastic angle, so nothing is lost by their uncertainty.
const LIMITS: [&str; 2] = ["contact_pressure_limit", "groove_depth"];

/// The numbers that a drawing or an assembly sheet gives limits for: those of the drive, torque and preload.
pub(super) fn tolerated() -> impl Iterator<Item = (&'static Section, &'static Key)> {
    let load = SECTIONS.iter().filter(|section| section.name == "load");
    uncertain()
        .chain(load.flat_map(|section| section.keys.iter().map(move |key| (section, key))))
        .filter(|(_, key)| tolerated_key(key))
}

fn tolerated_key(key: &Key) -> bool {
    uncertain_key(key) && key.stem != "input_angle"
}

fn uncertain_key(key: &Key) -> bool {
    matches!(key.kind, Kind::Quantity(..) | Kind::Number) && !LIMITS.contains(&&*key.stem)
}

/// Name in [uncertainty] and [tolerance] of a number.
pub(super) fn uncertainty_of(dotted: &str) -> String {
    dotted.replacen('.', "_", 1)
}

static SECTIONS: LazyLock<Vec<Section>> = LazyLock::new(|| {
    let drive = [material(), deceleration(), equal_speed()];
    let uncertainty = uncertainty(&drive);
    let load = load();
    let tolerance = tolerance(drive.iter().chain([&load]));
    let top = Section {
        name: "",
        required: false,
        mechanics: true,
        meaning: "A setting of the whole drive; [deceleration] or [equal_speed] may hold it instead.",
        keys: vec![track_curvature().by_default()],
    };
    let [material, deceleration, equal_speed] = drive;
    vec![
        top,
        material,
        deceleration,
        equal_speed,
        as_made(),
        torsion_spring(),
        load,
        measurement(),
        rating(),
        friction(),
        operation(),
        uncertainty,
        tolerance,
        effects(),
    ]
});

fn track_curvature() -> Key {
    let meaning = "whether the model includes the curvature of the grooves along their tracks; \"neglect\" treats every wall \
                   as straight, which designs with undercut need";
    Key::choice("track_curvature", &["exact", "neglect"], meaning)
}

fn material() -> Section {
    let modulus = |stem, meaning| {
        let steel = Elasticity::BEARING_STEEL.youngs_modulus_Pa;
        Key::quantity(stem, Quantity::Stress, "GPa", steel, meaning).optional()
    };
    let ratio = |stem, meaning| {
        let steel = Elasticity::BEARING_STEEL.poissons_ratio;
        Key::number(stem, steel, meaning).within((Excluded(-1.0), Excluded(0.5))).optional()
    };
    let limit = Material::default().pressure_limit_Pa;
    Section {
        name: "material",
        required: false,
        mechanics: true,
        meaning: "Material of balls and plates; bearing steel by default.",
        keys: vec![
            modulus("youngs_modulus", "Young's modulus of balls and plates").by_default(),
            ratio("poissons_ratio", "Poisson's ratio of balls and plates").by_default(),
            modulus("ball_youngs_modulus", "Young's modulus of the balls, if it differs"),
            ratio("ball_poissons_ratio", "Poisson's ratio of the balls, if it differs"),
            modulus("plate_youngs_modulus", "Young's modulus of the plates, if it differs"),
            ratio("plate_poissons_ratio", "Poisson's ratio of the plates, if it differs"),
            Key::quantity(
                "contact_pressure_limit",
                Quantity::Stress,
                "GPa",
                limit,
                "peak contact pressure above which a finding is reported (ISO 76)",
            )
            .by_default(),
        ],
    }
}

/// Keys of the ball and of the section of its groove.
fn groove(radius: &'static str) -> [Key; 3] {
    let conformity = "groove conformity beta*: groove-arc radius over ball radius, typically 1.03 to 1.1";
    let depth =
        "depth of the groove below the face of the plate; only the check of the groove's edge needs it";
    [
        Key::quantity("ball_radius", Quantity::Length, "mm", 1.5e-3, radius),
        Key::number("groove_conformity", 1.08, conformity).within((Excluded(1.0), Unbounded)),
        Key::quantity("groove_depth", Quantity::Length, "mm", 1e-3, depth).optional(),
    ]
}

fn contact_angle(stem: &'static str, meaning: &'static str) -> Key {
    Key::quantity(stem, Quantity::Angle, "deg", FRAC_PI_4, meaning).within(ACUTE)
}

fn deceleration() -> Section {
    let [ball_radius, groove_conformity, groove_depth] = groove("ball radius rd");
    Section {
        name: "deceleration",
        required: true,
        mechanics: true,
        meaning: "The pair with the cycloid grooves.",
        keys: vec![
            Key::balls(20, "number of balls Z2"),
            Key::number("short_amplitude_coefficient", 0.5, "short-amplitude coefficient K")
                .within((Excluded(0.0), Excluded(1.0))),
            Key::quantity("rolling_circle_radius", Quantity::Length, "mm", 4e-3, "rolling-circle radius r0"),
            ball_radius,
            groove_conformity,
            contact_angle("contact_angle", "angle beta between a contact normal and the plane of the plates"),
            groove_depth,
            Key::choice(
                "output_plate",
                &["hypocycloid", "epicycloid"],
                "the plate that drives the output; a cross-slide needs the hypocycloid plate",
            )
            .by_default(),
            track_curvature().optional(),
        ],
    }
}

fn equal_speed() -> Section {
    let [ball_radius, groove_conformity, groove_depth] = groove("ball radius, rq or rs");
    Section {
        name: "equal_speed",
        required: true,
        mechanics: true,
        meaning: "The pair that passes the rotation of the planet to the output (ring grooves) or prevents it (cross-slide).",
        keys: vec![
            Key::choice("kind", &["ring_groove", "cross_slide"], "the kind of the pair"),
            Key::balls(14, "number of balls, Zd or ZS; for a cross-slide, of one row"),
            Key::quantity(
                "pitch_radius",
                Quantity::Length,
                "mm",
                40e-3,
                "radius of the circle of balls, Rw or RS",
            ),
            ball_radius,
            groove_conformity,
            contact_angle("contact_angle", "angle between a contact normal and the plane of the plates")
                .unless(&["outside_contact_angle", "inside_contact_angle"]),
            contact_angle("outside_contact_angle", "contact angle at the outside walls, if it differs")
                .optional()
                .only("ring_groove"),
            contact_angle("inside_contact_angle", "contact angle at the inside walls, if it differs")
                .optional()
                .only("ring_groove"),
            groove_depth,
            Key::choice(
                "form",
                &["balanced", "paper"],
                "lever arms: from statics (balanced), or as in the 2017 paper, for comparison with it",
            )
            .by_default()
            .only("cross_slide"),
            Key::choice(
                "torque_share",
                &["carried", "paper"],
                "torque and angle: from statics (carried), or as in the 2017 paper, for comparison with it",
            )
            .by_default()
            .only("cross_slide"),
            track_curvature().optional(),
        ],
    }
}

fn torsion_spring() -> Section {
    let stiffness = Key::quantity(
        "torsional_stiffness",
        Quantity::TorquePerAngle,
        "Nm_per_arcmin",
        1e5,
        "torsional stiffness k_t at the output, if it is constant",
    );
    let list = |stem, quantity, usual, example: [f64; 2], meaning| {
        Key::new(stem, Kind::Quantities(quantity, usual), Value::Reals(example.to_vec()), meaning).optional()
    };
    let radius = "radius at which effects given as lengths act; those effects need it";
    Section {
        name: SPRING,
        required: false,
        mechanics: true,
        meaning: "Any other reducer (gears, harmonic, pin cycloid) as a torsion spring, in place of [material], \
                  [deceleration] and [equal_speed]: one stiffness, or a smooth curve through a table of torque and angle. \
                  A table that starts at torque 0 and angle 0 holds for both directions; beyond the table the curve continues \
                  as a straight line, with the status `outside_table`.",
        keys: vec![
            stiffness.unless(&["torque", "elastic_angle"]),
            list("torque", Quantity::Torque, "Nm", [0.0, 10.0], "torques of the table, in rising order"),
            list(
                "elastic_angle",
                Quantity::Angle,
                "arcsec",
                [0.0, 1e-4],
                "elastic angles of the table, in rising order, one for each torque",
            ),
            Key::quantity("reference_radius", Quantity::Length, "mm", 0.05, radius).optional(),
        ],
    }
}

/// Tables in files beside the case, or as lists.
fn as_made() -> Section {
    let file = |stem, example: &'static str, meaning| Key::text(stem, example, meaning).optional();
    let list = |stem, quantity, usual, meaning| {
        Key::new(stem, Kind::Quantities(quantity, usual), Value::Reals(Vec::new()), meaning).optional()
    };
    let angles = |stem, meaning| list(stem, Quantity::Angle, "deg", meaning);
    let lengths = |stem, meaning| list(stem, Quantity::Length, "um", meaning);
    let groove = "angle t of the groove's equation: of the ball about the centre of the circle of balls";
    let polar = "polar angle about the centre of the plate, in place of the groove angle";
    let out = "deviation normal to the track at each angle, above 0 where the groove lies further out";
    let rings = "number of the ring of each row, from 0";
    let about = "angle about the ring's centre, seen from its plate";
    let diameter = "diameter of each ball, from ball 0";
    let shift = "[x, y]: shift of the plate's grooves along its angles 0 and 90 deg";
    let tilt = "[c, s]: tilt that lifts the plate towards the balls at its angles 0 and 90 deg";
    let of_plate = |offset, angle| [lengths(offset, shift), list(angle, Quantity::Angle, "urad", tilt)];
    let mut keys = vec![
        file("epicycloid_profile", "epicycloid.csv", "CSV: groove_angle or polar_angle, deviation"),
        angles("epicycloid_groove_angle", groove),
        angles("epicycloid_polar_angle", polar),
        lengths("epicycloid_deviation", out),
        file("hypocycloid_profile", "hypocycloid.csv", "the same of the hypocycloid groove"),
        angles("hypocycloid_groove_angle", groove),
        angles("hypocycloid_polar_angle", polar),
        lengths("hypocycloid_deviation", out),
        file(
            "planet_rings",
            "planet_rings.csv",
            "CSV of the planet's ring grooves: ring, ring_angle, deviation",
        ),
        list("planet_ring", Quantity::Number, "", rings),
        angles("planet_ring_angle", about),
        lengths("planet_ring_deviation", out),
        file("facing_rings", "facing_rings.csv", "the same of the ring grooves that face them"),
        list("facing_ring", Quantity::Number, "", rings),
        angles("facing_ring_angle", about),
        lengths("facing_ring_deviation", out),
        file("deceleration_balls", "balls.csv", "CSV of the deceleration balls: ball, diameter"),
        list("deceleration_ball_diameter", Quantity::Length, "mm", diameter),
        file(
            "equal_speed_balls",
            "ring_balls.csv",
            "the same of the equal-speed balls, of a cross-slide row after row",
        ),
        list("equal_speed_ball_diameter", Quantity::Length, "mm", diameter),
    ];
    keys.extend(of_plate("epicycloid_plate_offset", "epicycloid_plate_tilt"));
    keys.extend(of_plate("hypocycloid_plate_offset", "hypocycloid_plate_tilt"));
    keys.extend(of_plate("ring_plate_offset", "ring_plate_tilt"));
    Section {
        name: AS_MADE,
        required: false,
        mechanics: true,
        meaning: "The parts as they were made; what is absent is nominal. A table is a CSV file, its path relative to the \
                  case file, or the lists of the same names. Columns carry their unit, for example `deviation_um`.",
        keys,
    }
}

fn load() -> Section {
    let torque = "resistance torque M0 on the output, either sign";
    let angle = "angle of the input crank, 0 on the line of centres";
    Section {
        name: "load",
        required: false,
        mechanics: true,
        meaning: "The load, unless the command line or the table of readings gives another.",
        keys: vec![
            Key::quantity("torque", Quantity::Torque, "Nm", 5.0, torque).within(ANY).optional(),
            Key::quantity("preload", Quantity::Force, "N", 600.0, "axial preload").optional(),
            Key::quantity("input_angle", Quantity::Angle, "deg", 0.0, angle).within(ANY).optional(),
        ],
    }
}

fn measurement() -> Section {
    let zero = "whether all runs share one zero of the angle or each run has its own";
    let between = "where a run begins as the one before it ended: whether friction goes on if both have one clock \
                   (time_s goes on), was released, or goes on whatever the clocks; carried_from_above and \
                   carried_from_below: as carried, but a run that no other leads to begins after loops that were not measured, from \
                   which the torque came down or up to its first reading";
    let turns = "where the torque of a table with time_s reverses; where_ramps_meet: where the straight ramps before and \
                 after meet, between readings that may be means, but at the readings if every reversal falls at the same \
                 share of the time between two readings; between_readings: there even then, for ramps that a clock logged; \
                 at_readings: for torques that were set and held";
    let lever = "radius at which the displacement sensor measures; readings of displacement need it";
    Section {
        name: "measurement",
        required: false,
        mechanics: false,
        meaning: "How the readings were taken.",
        keys: vec![
            Key::choice("zero", &["common", "per_run"], zero).by_default(),
            Key::quantity("lever_arm", Quantity::Length, "mm", 0.1, lever).optional(),
            Key::choice(
                "friction_between_runs",
                &["by_clock", "released", "carried", "carried_from_above", "carried_from_below"],
                between,
            )
            .by_default(),
            Key::choice("torque_turns", &["where_ramps_meet", "between_readings", "at_readings"], turns)
                .by_default(),
        ],
    }
}

fn rating() -> Section {
    let torque =
        "rated torque of the output; `cbpt characterise` reads lost motion and rigidity at shares of it";
    Section {
        name: "rating",
        required: false,
        mechanics: false,
        meaning: "What the maker states of the reducer.",
        keys: vec![Key::quantity("rated_torque", Quantity::Torque, "Nm", 5.0, torque).optional()],
    }
}

fn friction() -> Section {
    let coefficient = "friction coefficient mu of every contact; 0.05 to 0.15 for lubricated steel";
    let spread = "standard uncertainty of the coefficient";
    Section {
        name: "friction",
        required: false,
        mechanics: false,
        meaning: "Friction between balls and grooves, for `cbpt friction`.",
        keys: vec![
            Key::number("coefficient", Friction::default().coefficient, coefficient)
                .within((Included(0.0), Included(10.0)))
                .by_default(),
            Key::number("coefficient_uncertainty", Friction::default().coefficient_uncertainty, spread)
                .within(NOT_NEGATIVE)
                .by_default(),
        ],
    }
}

fn operation() -> Section {
    let quantity = |stem, quantity, usual, example, meaning| {
        Key::quantity(stem, quantity, usual, example, meaning).optional()
    };
    let speed = "speed of the input; the heat and the force of the unbalance need it";
    let inertia = "moment of inertia at the output, the load's included; the natural frequency needs it";
    let mass = "mass of the planet plate, the parts that move with it included; the unbalance needs it";
    let safety = "static safety s0 that is required of the contacts (ISO 76: 1, for quiet running 2)";
    Section {
        name: "operation",
        required: false,
        mechanics: false,
        meaning: "How the drive is run and what moves with it, for `cbpt friction`.",
        keys: vec![
            quantity("input_speed", Quantity::AnglePerTime, "rpm", 100.0, speed),
            quantity("output_inertia", Quantity::Inertia, "kg_m2", 0.01, inertia),
            quantity("planet_mass", Quantity::Mass, "kg", 0.5, mass),
            Key::number("static_safety", Operation::default().static_safety, safety)
                .within((Excluded(0.0), Unbounded))
                .by_default(),
        ],
    }
}

/// Besides its own keys, one for every number of the drive.
fn uncertainty(drive: &[Section]) -> Section {
    let relative =
        |stem, default, meaning| Key::number(stem, default, meaning).within(NOT_NEGATIVE).by_default();
    let angle = "standard uncertainty of all contact angles together";
    let mut keys = vec![
        relative("contact_stiffness_rel", 0.10, "relative standard uncertainty of the contact stiffness"),
        Key::quantity("contact_angle", Quantity::Angle, "deg", 0.5 / 180.0 * PI, angle)
            .within(NOT_NEGATIVE)
            .by_default(),
        relative("torque_gain_rel", 0.01, "relative standard uncertainty of the torque readings' gain"),
        relative("preload_gain_rel", 0.02, "relative standard uncertainty of the preload readings' gain"),
        relative("sensor_gain_rel", 0.005, "relative standard uncertainty of the angle sensor's gain"),
    ];
    for section in drive {
        keys.extend(section.keys.iter().filter(|key| uncertain_key(key)).map(|key| {
            spread_key(section, key, &|what| {
                format!("standard uncertainty of {what}; without it the value is exact")
            })
        }));
    }
    Section {
        name: "uncertainty",
        required: false,
        mechanics: false,
        meaning: "Standard uncertainties (k = 1) that are known independently of the readings; every fit uses them as priors.",
        keys,
    }
}

/// A key for the spread of a number.
fn spread_key(section: &Section, key: &Key, meaning: &dyn Fn(&str) -> String) -> Key {
    Key {
        stem: uncertainty_of(&dotted(section.name, &key.stem)).into(),
        need: Need::Optional,
        range: NOT_NEGATIVE,
        meaning: meaning(&format!("[{}] {}", section.name, key.stem)).into(),
        ..key.clone()
    }
}

fn tolerance<'a>(sections: impl Iterator<Item = &'a Section>) -> Section {
    let keys = |section: &'a Section| {
        let keys = section.keys.iter().filter(|key| tolerated_key(key));
        keys.map(|key| spread_key(section, key, &|what| format!("tolerance of {what}, plus or minus")))
    };
    Section {
        name: "tolerance",
        required: false,
        mechanics: false,
        meaning: "Tolerances of the drawing: limits on both sides of the nominal value; all values between them are equally \
                  likely. `cbpt tolerance` uses the standard uncertainty of a number that has no tolerance. Fits do not use \
                  this section.",
        keys: sections.flat_map(keys).collect(),
    }
}

fn effects() -> Section {
    Section {
        name: "effect",
        required: false,
        mechanics: false,
        meaning: "An effect to add to the model; write the section once for each effect. The parameters of a built-in effect \
                  are further keys, for example `reference_deflection_um = 2`; a parameter that is not given has its \
                  default. An own effect has an expression, a port and parameters.",
        keys: vec![
            Key::text("id", library::EFFECTS[0], "id of a built-in effect, or a new name for an own effect"),
            Key::choice(
                "port",
                PORTS,
                "where the effect acts; an own effect acts at load, series or reading",
            )
            .optional(),
            Key::choice(
                "adds_to",
                &["torque_Nm", "preload_N"],
                "quantity that an own effect at the load port adds to",
            )
            .optional(),
            Key::text(
                "expression",
                "a * torque_Nm",
                "formula of an own effect, in SI; the guide on own effects lists its names and functions",
            )
            .optional(),
            Key::new(PARAMETERS, Kind::Parameters, Value::Text(String::new()), "parameters of an own effect")
                .optional(),
        ],
    }
}

/// The one key that holds a table.
pub(super) const PARAMETERS: &str = "parameters";

static PARAMETER: LazyLock<Section> = LazyLock::new(|| Section {
    name: "effect.parameters",
    required: false,
    mechanics: false,
    meaning: "One parameter of an own effect: `parameters = { a = { unit = \"rad/(N m)\", start = 1e-7 } }`.",
    keys: vec![
        Key::text(
            "unit",
            "",
            "unit of start, min and max, for example \"arcsec/(N m)\"; the formula takes them in SI; \"\" for a plain number",
        ),
        Key::number("start", 1.0, "value from which a fit starts"),
        Key::number("min", 0.0, "least value").optional(),
        Key::number("max", 1.0, "greatest value").optional(),
    ],
});
