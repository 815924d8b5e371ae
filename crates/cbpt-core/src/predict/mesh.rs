//! All pairs of a drive at one input angle with the contacts that the effects make of them, under a load.
//!
//! - [`Tables`]: meshing points at one input angle, their slopes by the contact angle, the shapes of gaps;
//! - [`Pairs`]: these with scale, exponent, spring and gaps applied, ready for loads; homogeneous ones are solved in lanes;
//! - [`Mesh`]: the solved drive: its angle and how that answers to each number.

use std::f64::consts::TAU;

use crate::drive::{CrossSlide, Deceleration, Drive, EqualSpeed, OutputPlate, RingGroove};
use crate::effect::port::{Ball, Contact};
use crate::equilibrium::lanes::contacts::ByContact;
use crate::equilibrium::lanes::nearby::{Homogeneous, Place, SideBySide};
use crate::equilibrium::ready::Changes;
use crate::equilibrium::response::{Asked, GapShape, Response, Slopes, respond};
use crate::equilibrium::{ReadyPair, State};
use crate::error::InvalidInput;
use crate::status::Status;

/// The deceleration pair and at most two rows of an equal-speed pair.
pub const MOST_PAIRS: usize = 3;

/// A shape of a gap: m for one unit of a parameter, at a ball.
pub type GapAt<'a> = &'a (dyn Fn(&Ball) -> [f64; 3] + Sync);

/// Meshing points at one input angle.
#[derive(Debug, Clone)]
pub struct Tables {
    pairs: Vec<PairTable>,
    share: f64,
}

#[derive(Debug, Clone)]
struct PairTable {
    pair: ReadyPair,
    /// d ln k / d beta of every contact, 1/rad.
    stiffness_slopes_per_rad: ByContact,
    contacts: SideBySide,
}

/// The drive with all its contact angles shifted.
///
/// # Errors
/// Where an angle leaves the range between 0 and 90 degrees.
pub fn shifted(drive: &Drive, shift_rad: f64) -> Result<Drive, InvalidInput> {
    let deceleration = *drive.deceleration();
    let contact_angle_rad = deceleration.contact_angle_rad + shift_rad;
    let equal_speed = match *drive.equal_speed() {
        EqualSpeed::RingGroove(ring) => EqualSpeed::RingGroove(RingGroove {
            outside_contact_angle_rad: ring.outside_contact_angle_rad + shift_rad,
            inside_contact_angle_rad: ring.inside_contact_angle_rad + shift_rad,
            ..ring
        }),
        EqualSpeed::CrossSlide(slide) => EqualSpeed::CrossSlide(CrossSlide {
            contact_angle_rad: slide.contact_angle_rad + shift_rad,
            ..slide
        }),
    };
    let shifted = Drive::new(
        *drive.material(),
        Deceleration { contact_angle_rad, ..deceleration },
        equal_speed,
        drive.track_curvature(),
    )?;
    shifted.with_parts_of(drive)
}

impl Tables {
    /// Meshing points at an input angle; the slopes by the contact angle only where they are wanted.
    pub fn new(drive: &Drive, input_angle_rad: f64, slopes: bool) -> Self {
        let points = drive.points(input_angle_rad);
        let track = drive.track_curvature();
        let grooves = [&drive.deceleration().groove, drive.equal_speed().groove()];
        let pairs = std::iter::once((grooves[0], points.deceleration))
            .chain(points.equal_speed.into_iter().map(|row| (grooves[1], row)))
            .map(|(groove, points)| {
                let slope = |point: &crate::pair::MeshingPoint| point.stiffness_slope_per_rad(groove, track);
                let by_diagonal: Vec<f64> =
                    if slopes { points.points.iter().map(slope).collect() } else { Vec::new() };
                let pair = ReadyPair::new(&points);
                let contacts = SideBySide::new(&pair, &by_diagonal);
                let stiffness_slopes_per_rad =
                    if slopes { pair.by_contact(&by_diagonal) } else { Vec::new() };
                PairTable { pair, stiffness_slopes_per_rad, contacts }
            })
            .collect();
        Self { pairs, share: points.equal_speed_share }
    }

    /// The shape of a gap at every diagonal of every pair.
    pub fn gap_shapes(drive: &Drive, input_angle_rad: f64, gap: GapAt<'_>) -> [GapShape; MOST_PAIRS] {
        let deceleration = drive.deceleration();
        let theta = input_angle_rad;
        let planet_turn = drive.planet_turn();
        let balls = |count: u32, first_rad: f64, pitch_radius_m: f64, decelerates: bool| -> GapShape {
            // Along the fixed groove a ball moves with the crank's turn against the line of centres.
            let fixed = match deceleration.output_plate {
                OutputPlate::Hypocycloid => theta,
                OutputPlate::Epicycloid => -theta,
            };
            (0..count)
                .flat_map(|number| {
                    let in_plate_rad = TAU * f64::from(number) / f64::from(count);
                    let from_line_rad = first_rad + in_plate_rad;
                    let at = gap(&Ball {
                        decelerates,
                        number: number as usize,
                        from_line_rad,
                        on_fixed_groove_rad: from_line_rad + fixed,
                        on_planet_groove_rad: from_line_rad + fixed * planet_turn,
                        in_plate_rad,
                        pitch_radius_m,
                    });
                    [at; 2]
                })
                .collect()
        };
        let phi = drive.deceleration_phase_rad(theta);
        let first = balls(deceleration.ball_count, phi, deceleration.pitch_radius_m(), true);
        let equal = drive.equal_speed();
        let psi = match equal {
            EqualSpeed::RingGroove(_) => drive.equal_speed_phase_rad(theta),
            EqualSpeed::CrossSlide(_) => 0.0,
        };
        let row = balls(equal.ball_count(), psi, equal.pitch_radius_m(), false);
        [first, row.clone(), row]
    }
}

/// One parameter of an effect on gaps, at one input angle.
#[derive(Debug, Clone)]
pub struct Gap {
    /// Its shape at every diagonal of every pair.
    pub shapes: [GapShape; MOST_PAIRS],
}

/// The pairs at one input angle, ready for loads.
#[derive(Debug, Clone)]
pub struct Pairs<'a> {
    tables: &'a Tables,
    pairs: Vec<ReadyPair>,
    /// Of the pairs that are homogeneous.
    quick: Vec<Option<Homogeneous<'a>>>,
    /// By pair, what the gaps whose answers are wanted add to the deformations.
    gaps: Vec<Vec<ByContact>>,
}

impl<'a> Pairs<'a> {
    /// Applies the values of scale, exponent, spring and gaps; `wanted` are the gaps whose answers will be asked for.
    pub fn new(
        tables: &'a Tables,
        contact: &Contact,
        spring_N_per_m: f64,
        gaps: &[(f64, &Gap)],
        wanted: &[&Gap],
    ) -> Self {
        let ready = |(number, table): (usize, &PairTable)| {
            let gaps: Vec<(f64, &[[f64; 3]])> =
                gaps.iter().map(|(value, gap)| (*value, &gap.shapes[number][..])).collect();
            table.pair.changed(&Changes {
                stiffness_scale: contact.stiffness_scale.value,
                exponent: contact.exponent.value,
                axial_spring_N_per_m: spring_N_per_m,
                gaps: &gaps,
            })
        };
        let pairs: Vec<ReadyPair> = tables.pairs.iter().enumerate().map(ready).collect();
        Self {
            quick: tables.pairs.iter().zip(&pairs).map(|(table, pair)| table.contacts.of(pair)).collect(),
            gaps: (pairs.iter().enumerate())
                .map(|(number, pair)| wanted.iter().map(|gap| pair.closing(&gap.shapes[number])).collect())
                .collect(),
            pairs,
            tables,
        }
    }

    /// Solves all pairs; `warm` holds states nearby and takes the new ones. Without `wanted` the mesh knows how it answers
    /// to torque and preload only.
    ///
    /// # Errors
    /// The status, where there is no solution.
    pub fn solve(&self, load: [f64; 2], wanted: Option<Wanted>, warm: &mut Warm) -> Result<Mesh, Status> {
        let mut mesh = Mesh {
            status: Status::Solved,
            angle_rad: 0.0,
            parts_rad: [0.0; 2],
            residual: 0.0,
            slopes: Slopes { gaps: vec![0.0; wanted.map_or(0, |_| self.gaps[0].len())], ..Slopes::default() },
            torque_Nm: load[0],
            with_stops_Nm: load[0],
            carried_share: 1.0,
            carrying: [0; 2],
            regime: None,
        };
        let mut failed: Option<Status> = None;
        for (number, pair) in self.pairs.iter().enumerate() {
            // Torque of the pair over M0, and the share of its angle that reaches the output.
            let share = if number == 0 { 1.0 } else { self.tables.share };
            match self.respond(number, [load[0] * share, load[1]], wanted, warm) {
                Ok(response) => mesh.add(&response, share, f64::from(pair.rows()), number),
                Err(status) => failed = Some(failed.map_or(status, |before| before.worse(status))),
            }
        }
        failed.map_or(Ok(mesh), Err)
    }

    /// Solves one of the pairs: a homogeneous one in lanes, which know how it answers to most numbers.
    fn respond(
        &self,
        number: usize,
        load: [f64; 2],
        wanted: Option<Wanted>,
        warm: &mut Warm,
    ) -> Result<Response, Status> {
        let (pair, table) = (&self.pairs[number], &self.tables.pairs[number]);
        let asked = wanted.map_or(Asked::default(), |wanted| Asked {
            stiffness_slopes_per_rad: wanted.contact_angle.then_some(&table.stiffness_slopes_per_rad),
            stiffness: wanted.stiffness,
            exponent: wanted.exponent,
            spring: wanted.spring,
            gaps: &self.gaps[number],
        });
        let answered_quickly = !(asked.exponent || asked.spring || !asked.gaps.is_empty());
        let by_angle = answered_quickly && wanted.is_some_and(|wanted| wanted.contact_angle);
        let [start, unloaded] = &mut warm.states[number];
        let place = &mut warm.places[number];
        let quick = self.quick[number].as_ref();
        if let Some((response, found)) =
            quick.and_then(|quick| quick.respond(pair, load, place.as_ref(), by_angle))
        {
            (*place, *start) = (Some(found), Some(response.state));
            if answered_quickly {
                return Ok(response);
            }
        }
        let response = respond(pair, load, [start.as_ref(), unloaded.as_ref()], asked)?;
        (*start, *unloaded) = (Some(response.state), response.unloaded.or(*unloaded));
        Ok(response)
    }
}

/// Which answers are wanted beside those to torque, preload and the gaps of the site.
#[derive(Debug, Clone, Copy, Default)]
#[allow(clippy::struct_excessive_bools)] // each a question of its own
pub struct Wanted {
    /// To the stiffness.
    pub stiffness: bool,
    /// To the exponent.
    pub exponent: bool,
    /// To the contact angle.
    pub contact_angle: bool,
    /// To the axial spring.
    pub spring: bool,
}

/// States of the pairs from which a solution nearby starts, loaded and unloaded.
#[derive(Debug, Clone, Copy, Default)]
pub struct Warm {
    states: [[Option<State>; 2]; MOST_PAIRS],
    /// Where pairs that are homogeneous stand on their curves.
    places: [Option<Place>; MOST_PAIRS],
}

/// Which contacts carry; of two pairs the later one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Regime {
    /// All diagonals that exist.
    AllLoaded,
    /// Some have parted.
    SomeParted,
    /// d <= 0: transmission is not continuous.
    BelowContinuous,
}

impl Regime {
    /// `all_loaded`, `some_parted` or `below_continuous`.
    pub fn name(self) -> &'static str {
        match self {
            Self::AllLoaded => "all_loaded",
            Self::SomeParted => "some_parted",
            Self::BelowContinuous => "below_continuous",
        }
    }
}

/// The meshing points of the whole drive under a load.
#[derive(Debug, Clone, PartialEq)]
pub struct Mesh {
    /// Whether the displacements are small.
    pub status: Status,
    /// Elastic angle at the output, rad.
    pub angle_rad: f64,
    /// Its parts: of the deceleration pair, and what of the equal-speed pair reaches the output, rad.
    pub parts_rad: [f64; 2],
    /// Largest scaled residual.
    pub residual: f64,
    /// How it answers, the torque being the one that it carries and the preload that of the drive.
    pub slopes: Slopes,
    /// Torque that it carries, N m.
    pub torque_Nm: f64,
    /// Torque on it and on the stops beside it, N m.
    pub with_stops_Nm: f64,
    /// How much of a further torque on both it carries.
    pub carried_share: f64,
    /// Diagonals that carry in one row of the deceleration and the equal-speed pair.
    pub carrying: [usize; 2],
    /// Which contacts carry; a torsion spring has none.
    pub regime: Option<Regime>,
}

/// How far the meshing points, or a spring in their place, turn under a load.
#[derive(Debug, Clone, Copy)]
pub struct Turned {
    /// The angle, rad.
    pub angle_rad: f64,
    /// Its derivative by the torque, rad/(N m).
    pub by_torque: f64,
}

impl Mesh {
    /// How its angle answers to the torque on it and on the stops beside it, rad/(N m).
    pub fn by_torque(&self) -> f64 {
        self.carried_share * self.slopes.torque
    }

    fn add(&mut self, response: &Response, share: f64, rows: f64, pair: usize) {
        let weight = share * rows;
        let (total, own) = (&mut self.slopes, &response.rotation);
        self.status = self.status.worse(response.status);
        self.angle_rad += weight * response.state.rotation_rad;
        self.parts_rad[pair.min(1)] += weight * response.state.rotation_rad;
        self.residual = self.residual.max(response.residual);
        total.torque += weight * share * own.torque;
        total.preload += weight * own.preload;
        total.spring += weight * own.spring;
        total.log_stiffness += weight * own.log_stiffness;
        total.contact_angle += weight * own.contact_angle;
        total.exponent += weight * own.exponent;
        for (gap, own) in total.gaps.iter_mut().zip(&own.gaps) {
            *gap += weight * own;
        }
        self.carrying[pair.min(1)] = response.carrying;
        let regime = if response.state.approach_m() <= 0.0 {
            Regime::BelowContinuous
        } else if response.parted > 0 {
            Regime::SomeParted
        } else {
            Regime::AllLoaded
        };
        self.regime = self.regime.max(Some(regime));
    }
}
