//! The drive as data: material, deceleration pair, equal-speed pair. Checked once, then frozen.
//!
//! All lengths are in metres, angles in radians, stresses in pascals. The names follow the field; the letters of
//! the 2017 paper (DOI 10.1177/1687814017734112) stand beside them in the documentation of each number.

use std::f64::consts::FRAC_PI_2;
use std::sync::Arc;

use crate::as_made::{AsMade, Counts};
use crate::error::{InvalidInput, require, require_positive};
use crate::real::Real;

/// Young's modulus and Poisson's ratio of one body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Elasticity {
    /// Young's modulus, Pa.
    pub youngs_modulus_Pa: f64,
    /// Poisson's ratio, below 0.5 and above -1.
    pub poissons_ratio: f64,
}

impl Elasticity {
    /// Bearing steel: 208 GPa and 0.3.
    pub const BEARING_STEEL: Self = Self { youngs_modulus_Pa: 208e9, poissons_ratio: 0.3 };

    fn check(&self, who: &str) -> Result<(), InvalidInput> {
        require_positive(format_args!("material.{who}youngs_modulus_Pa"), self.youngs_modulus_Pa)?;
        let nu = self.poissons_ratio;
        require(
            nu > -1.0 && nu < 0.5,
            format_args!("material.{who}poissons_ratio"),
            nu,
            "must lie between -1 and 0.5, 0.3 for steel",
        )
    }
}

/// What balls and plates are made of.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Material {
    /// The balls.
    pub ball: Elasticity,
    /// The plates with their grooves.
    pub plate: Elasticity,
    /// Highest peak contact pressure before a finding is raised, Pa (4.2 GPa for ball on groove by ISO 76).
    pub pressure_limit_Pa: f64,
}

impl Default for Material {
    fn default() -> Self {
        Self { ball: Elasticity::BEARING_STEEL, plate: Elasticity::BEARING_STEEL, pressure_limit_Pa: 4.2e9 }
    }
}

impl Material {
    /// Contact modulus E*, Pa: 1/E* = (1 - nu1^2)/E1 + (1 - nu2^2)/E2 (Hertz).
    pub fn contact_modulus_Pa(&self) -> f64 {
        let numbers = |m: &Elasticity| [m.youngs_modulus_Pa, m.poissons_ratio];
        contact_modulus_Pa(numbers(&self.ball), numbers(&self.plate))
    }
}

/// E* (Pa) from Young's modulus (Pa) and Poisson's ratio of ball and plate.
pub(crate) fn contact_modulus_Pa<T: Real>(ball: [T; 2], plate: [T; 2]) -> T {
    let compliance = |[modulus, ratio]: [T; 2]| (-(ratio * ratio) + 1.0) / modulus;
    T::of(1.0) / (compliance(ball) + compliance(plate))
}

/// Ball and groove section, the same for every groove of a row of balls.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GrooveSection {
    /// Ball radius r, m.
    pub ball_radius_m: f64,
    /// Groove conformity beta*: groove-arc radius over ball radius, above 1.
    pub groove_conformity: f64,
    /// Depth of the groove below the face of the plate, m, if it is known; only the edge check needs it.
    pub groove_depth_m: Option<f64>,
}

impl GrooveSection {
    fn check(&self, pair: &str) -> Result<(), InvalidInput> {
        require_positive(format_args!("{pair}.ball_radius_m"), self.ball_radius_m)?;
        require(
            self.groove_conformity.is_finite() && self.groove_conformity > 1.0,
            format_args!("{pair}.groove_conformity"),
            self.groove_conformity,
            "must be greater than 1 (groove-arc radius over ball radius), typically 1.03 to 1.1",
        )?;
        match self.groove_depth_m {
            Some(depth) => require_positive(format_args!("{pair}.groove_depth_m"), depth),
            None => Ok(()),
        }
    }
}

/// Which plate of the deceleration pair drives the output.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum OutputPlate {
    /// The plate with the hypocycloid groove, Z3 = Z2 + 1 lobes; turns as the input, ratio (Z2 + 1)/2.
    #[default]
    Hypocycloid,
    /// The plate with the epicycloid groove, Z1 = Z2 - 1 lobes; turns against the input, ratio -(Z2 - 1)/2.
    Epicycloid,
}

/// The deceleration pair: balls where an epicycloid and a hypocycloid groove overlap.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Deceleration {
    /// Number of balls Z2, 3 or more.
    pub ball_count: u32,
    /// Short-amplitude coefficient K, between 0 and 1.
    pub short_amplitude_coefficient: f64,
    /// Rolling-circle radius r0, m.
    pub rolling_circle_radius_m: f64,
    /// Angle beta between a contact normal and the plane of the plates, rad.
    pub contact_angle_rad: f64,
    /// Ball and groove section.
    pub groove: GrooveSection,
    /// The plate that drives the output.
    pub output_plate: OutputPlate,
}

impl Deceleration {
    /// Eccentricity e = K r0, m; the crank's own eccentricity is 2 e.
    pub fn eccentricity_m(&self) -> f64 {
        self.short_amplitude_coefficient * self.rolling_circle_radius_m
    }

    /// Radius R = Z2 r0 of the circle of balls, m.
    pub fn pitch_radius_m(&self) -> f64 {
        f64::from(self.ball_count) * self.rolling_circle_radius_m
    }

    /// Lobes Z1 = Z2 - 1 of the epicycloid groove.
    pub fn epicycloid_lobes(&self) -> u32 {
        self.ball_count - 1
    }

    /// Lobes Z3 = Z2 + 1 of the hypocycloid groove.
    pub fn hypocycloid_lobes(&self) -> u32 {
        self.ball_count + 1
    }

    /// Lobes Zo of the groove of the output plate.
    pub fn output_lobes(&self) -> u32 {
        match self.output_plate {
            OutputPlate::Hypocycloid => self.hypocycloid_lobes(),
            OutputPlate::Epicycloid => self.epicycloid_lobes(),
        }
    }

    fn check(&self) -> Result<(), InvalidInput> {
        require(self.ball_count >= 3, "deceleration.ball_count", self.ball_count, "must be 3 or more")?;
        require(
            self.ball_count <= MAX_BALL_COUNT,
            "deceleration.ball_count",
            self.ball_count,
            "must be 1000 or less",
        )?;
        let k = self.short_amplitude_coefficient;
        require(
            k > 0.0 && k < 1.0,
            "deceleration.short_amplitude_coefficient",
            k,
            "must lie between 0 and 1: at 1 the cycloid has cusps, at 0 there is no eccentricity",
        )?;
        require_positive("deceleration.rolling_circle_radius_m", self.rolling_circle_radius_m)?;
        check_contact_angle("deceleration.contact_angle_rad", self.contact_angle_rad)?;
        self.groove.check("deceleration")
    }
}

/// Ring-groove equal-speed pair (RGES): ring grooves of radius e couple the planet to the output.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RingGroove {
    /// Number of balls Zd, 3 or more.
    pub ball_count: u32,
    /// Radius Rw of the circle of balls, m.
    pub pitch_radius_m: f64,
    /// Contact angle at the outside walls (the paper's beta2), rad.
    pub outside_contact_angle_rad: f64,
    /// Contact angle at the inside walls (the paper's beta1), rad.
    pub inside_contact_angle_rad: f64,
    /// Ball and groove section.
    pub groove: GrooveSection,
}

/// Which arms the cross-slide has.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum CrossSlideForm {
    /// Statics: the floating plate is in balance across its grooves, so the shift of the ball circle drops out.
    #[default]
    Balanced,
    /// The 2017 paper: the shift e cos(phi) is added to every arm, which leaves the floating plate out of balance.
    /// Only to compare with the paper.
    Paper,
}

/// Which torque the cross-slide carries and how its angle reaches the output.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum CrossSlideShare {
    /// Statics: it carries M0 Z1/Z3 and its angle reaches the output times Z1/Z3.
    #[default]
    Carried,
    /// The 2017 paper: it carries M0 and its angle adds whole. Only to compare with the paper.
    Paper,
}

/// Cross-slide equal-speed pair (CSGES): a floating plate between two rows of straight grooves.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CrossSlide {
    /// Number of balls ZS of each of the two rows, 3 or more.
    pub ball_count: u32,
    /// Radius RS of the circle of balls, m.
    pub pitch_radius_m: f64,
    /// Contact angle, rad.
    pub contact_angle_rad: f64,
    /// Ball and groove section.
    pub groove: GrooveSection,
    /// Arms by statics or as the paper has them.
    pub form: CrossSlideForm,
    /// Torque by statics or as the paper has it.
    pub share: CrossSlideShare,
}

/// The pair that passes the planet's rotation on, or holds it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum EqualSpeed {
    /// Ring grooves to the output.
    RingGroove(RingGroove),
    /// Cross-slide to the housing.
    CrossSlide(CrossSlide),
}

impl EqualSpeed {
    /// Number of balls of the pair (of one row for the cross-slide).
    pub fn ball_count(&self) -> u32 {
        match self {
            Self::RingGroove(ring) => ring.ball_count,
            Self::CrossSlide(slide) => slide.ball_count,
        }
    }

    /// Radius of the circle of balls, m.
    pub fn pitch_radius_m(&self) -> f64 {
        match self {
            Self::RingGroove(ring) => ring.pitch_radius_m,
            Self::CrossSlide(slide) => slide.pitch_radius_m,
        }
    }

    /// Ball and groove section.
    pub fn groove(&self) -> &GrooveSection {
        match self {
            Self::RingGroove(ring) => &ring.groove,
            Self::CrossSlide(slide) => &slide.groove,
        }
    }

    fn check(&self) -> Result<(), InvalidInput> {
        let count = self.ball_count();
        require(
            (3..=MAX_BALL_COUNT).contains(&count),
            "equal_speed.ball_count",
            count,
            "must lie between 3 and 1000",
        )?;
        require_positive("equal_speed.pitch_radius_m", self.pitch_radius_m())?;
        match self {
            Self::RingGroove(ring) => {
                check_contact_angle("equal_speed.outside_contact_angle_rad", ring.outside_contact_angle_rad)?;
                check_contact_angle("equal_speed.inside_contact_angle_rad", ring.inside_contact_angle_rad)?;
            }
            Self::CrossSlide(slide) => {
                check_contact_angle("equal_speed.contact_angle_rad", slide.contact_angle_rad)?;
            }
        }
        self.groove().check("equal_speed")
    }
}

/// How the curvature of a groove along its track enters the contact.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum TrackCurvature {
    /// With the curvature of the track (Meusnier); a wall that would undercut does not exist.
    #[default]
    Exact,
    /// Every wall taken as straight along its track; needed for designs that undercut, such as the paper's prototype.
    Neglect,
}

/// Far above any drive; keeps a mistyped number from asking for all the memory.
const MAX_BALL_COUNT: u32 = 1000;

/// A cycloid ball planetary transmission: two pairs, their material, checked and frozen.
#[derive(Debug, Clone, PartialEq)]
pub struct Drive {
    material: Material,
    deceleration: Deceleration,
    equal_speed: EqualSpeed,
    track_curvature: TrackCurvature,
    as_made: Option<Arc<AsMade>>,
}

impl Drive {
    /// Checks every number and freezes the drive.
    ///
    /// # Errors
    /// [`InvalidInput`] names the first number that cannot be, and what is required. Designs that can be built but
    /// should not are not errors; [`Drive::findings`](crate::Drive::findings) lists them.
    pub fn new(
        material: Material,
        deceleration: Deceleration,
        equal_speed: EqualSpeed,
        track_curvature: TrackCurvature,
    ) -> Result<Self, InvalidInput> {
        material.ball.check("ball_")?;
        material.plate.check("plate_")?;
        require_positive("material.pressure_limit_Pa", material.pressure_limit_Pa)?;
        deceleration.check()?;
        equal_speed.check()?;
        let slide_holds_planet = matches!(equal_speed, EqualSpeed::RingGroove(_))
            || deceleration.output_plate == OutputPlate::Hypocycloid;
        require(
            slide_holds_planet,
            "deceleration.output_plate",
            "epicycloid",
            "a cross-slide holds the planet of a drive whose output is the hypocycloid plate; \
             choose output_plate = \"hypocycloid\" or equal_speed.kind = \"ring_groove\"",
        )?;
        Ok(Self { material, deceleration, equal_speed, track_curvature, as_made: None })
    }

    /// The same drive with its parts as they were made.
    ///
    /// Every load that is solved then has them, and so have thresholds of the preload. What a designer asks of the nominal
    /// drive has not: [`crate::sensitivity`], [`crate::judge`], [`crate::extremes`].
    ///
    /// # Errors
    /// [`InvalidInput`] for a table that does not fit the drive.
    pub fn with_as_made(self, made: AsMade) -> Result<Self, InvalidInput> {
        self.with_parts((!made.is_nominal()).then(|| Arc::new(made)))
    }

    /// The same drive with the parts of another.
    pub(crate) fn with_parts_of(self, other: &Self) -> Result<Self, InvalidInput> {
        self.with_parts(other.as_made.clone())
    }

    fn with_parts(self, as_made: Option<Arc<AsMade>>) -> Result<Self, InvalidInput> {
        if let Some(made) = &as_made {
            let (balls, rings) = match &self.equal_speed {
                EqualSpeed::RingGroove(ring) => (ring.ball_count, ring.ball_count),
                EqualSpeed::CrossSlide(slide) => (2 * slide.ball_count, 0),
            };
            made.check(&Counts {
                deceleration: self.deceleration.ball_count,
                equal_speed: balls,
                rings,
                diameters_m: [&self.deceleration.groove, self.equal_speed.groove()]
                    .map(|groove| 2.0 * groove.ball_radius_m),
            })?;
        }
        Ok(Self { as_made, ..self })
    }

    /// The same drive with nominal parts.
    #[must_use]
    pub fn nominal(&self) -> Self {
        Self { as_made: None, ..self.clone() }
    }

    /// Its parts as they were made; `None` where all are nominal.
    pub fn as_made(&self) -> Option<&AsMade> {
        self.as_made.as_deref()
    }

    /// Materials of balls and plates.
    pub fn material(&self) -> &Material {
        &self.material
    }

    /// The deceleration pair.
    pub fn deceleration(&self) -> &Deceleration {
        &self.deceleration
    }

    /// The equal-speed pair.
    pub fn equal_speed(&self) -> &EqualSpeed {
        &self.equal_speed
    }

    /// Whether the curvature of the tracks counts.
    pub fn track_curvature(&self) -> TrackCurvature {
        self.track_curvature
    }

    /// Transmission ratio i: input turns for one turn of the output, negative where they turn against each other.
    pub fn transmission_ratio(&self) -> f64 {
        match self.deceleration.output_plate {
            OutputPlate::Hypocycloid => f64::from(self.deceleration.hypocycloid_lobes()) / 2.0,
            OutputPlate::Epicycloid => -f64::from(self.deceleration.epicycloid_lobes()) / 2.0,
        }
    }

    /// The base case of the 2017 paper with ring grooves: K = 0.5, r0 = 4 mm, Z2 = 20, Zd = 14, Rw = 40 mm, balls of
    /// 1.5 mm radius, conformity 1.08, 45 degrees. The paper names no material; bearing steel is taken.
    pub fn paper_base_case() -> Self {
        let groove = GrooveSection { ball_radius_m: 1.5e-3, groove_conformity: 1.08, groove_depth_m: None };
        let contact_angle_rad = FRAC_PI_2 / 2.0;
        Self {
            material: Material::default(),
            deceleration: Deceleration {
                ball_count: 20,
                short_amplitude_coefficient: 0.5,
                rolling_circle_radius_m: 4e-3,
                contact_angle_rad,
                groove,
                output_plate: OutputPlate::Hypocycloid,
            },
            equal_speed: EqualSpeed::RingGroove(RingGroove {
                ball_count: 14,
                pitch_radius_m: 40e-3,
                outside_contact_angle_rad: contact_angle_rad,
                inside_contact_angle_rad: contact_angle_rad,
                groove,
            }),
            track_curvature: TrackCurvature::Exact,
            as_made: None,
        }
    }
}

fn check_contact_angle(field: &str, angle_rad: f64) -> Result<(), InvalidInput> {
    require(
        angle_rad > 0.0 && angle_rad < FRAC_PI_2,
        field,
        angle_rad,
        "must lie between 0 and 90 degrees, as the angle between a contact normal and the plane of the plates",
    )
}

/// What acts on the drive: torque, preload, and where the input crank stands.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Load {
    torque_Nm: f64,
    preload_N: f64,
    input_angle_rad: f64,
}

impl Load {
    /// Resistance torque M0 on the output (N m, either sign), preload N_Z (N, above 0) and crank angle theta (rad,
    /// 0 = line of centres as drawn).
    ///
    /// # Errors
    /// [`InvalidInput`] where a number is not finite or the preload is not above 0.
    pub fn new(torque_Nm: f64, preload_N: f64, input_angle_rad: f64) -> Result<Self, InvalidInput> {
        require(torque_Nm.is_finite(), "torque_Nm", torque_Nm, "must be a finite number")?;
        require_positive("preload_N", preload_N)?;
        require(input_angle_rad.is_finite(), "input_angle_rad", input_angle_rad, "must be a finite number")?;
        Ok(Self { torque_Nm, preload_N, input_angle_rad })
    }

    /// The load of a torsion spring without a preload.
    ///
    /// # Errors
    /// As [`Load::new`].
    pub fn without_preload(torque_Nm: f64, input_angle_rad: f64) -> Result<Self, InvalidInput> {
        Ok(Self { preload_N: 0.0, ..Self::new(torque_Nm, 1.0, input_angle_rad)? })
    }

    /// Resistance torque M0 on the output, N m.
    pub fn torque_Nm(&self) -> f64 {
        self.torque_Nm
    }

    /// Axial preload N_Z, N; 0 where a torsion spring has none.
    pub fn preload_N(&self) -> f64 {
        self.preload_N
    }

    /// Angle theta of the input crank, rad.
    pub fn input_angle_rad(&self) -> f64 {
        self.input_angle_rad
    }
}
