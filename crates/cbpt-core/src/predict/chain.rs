//! The effects of a model along one row, port by port, in dual numbers; those of the user's own are in `own`.

use std::sync::Arc;

use crate::effect::Port;
use crate::effect::dual::Dual;
use crate::effect::lag::part_temperatures;
use crate::effect::own::OwnEffect;
use crate::effect::port::{Action, Contact, DriveNumbers, Friction, Load, Row};
use crate::effect::spec::Spec;

use super::added::Added;
use super::rows::Rows;

/// An effect with numbers, some of them seeded with a partial.
#[derive(Debug, Clone)]
pub struct Link {
    pub port: Port,
    pub action: Action,
    pub own: Vec<Dual>,
    /// Temperature of the part at every reading (K, less the first one); empty where it is the measured one.
    part_temperatures: Vec<Dual>,
    /// What it adds to the torque of every reading, N m; empty where it adds none.
    torques_Nm: Vec<Dual>,
    /// What rubs by it, alike at every reading.
    friction: Vec<Friction>,
}

impl Link {
    /// An effect of the library with its numbers, on these readings.
    pub fn new(spec: &Spec, own: Vec<Dual>, rows: &Rows) -> Self {
        let time_constant_s = spec.action.time_constant().map(|place| own[place]);
        let lags = time_constant_s.filter(|time_s| *time_s != Dual::constant(0.0));
        let part_temperatures = lags.map_or_else(Vec::new, |time_s| {
            rows.by_clock().into_iter().flat_map(|rows| part_temperatures(rows, &time_s)).collect()
        });
        let torques_Nm = if let Action::Torques(act) = spec.action {
            (0..rows.runs()).flat_map(|run| act(&own, &rows.by_run()[rows.run(run)])).collect()
        } else {
            Vec::new()
        };
        let friction = if let Action::Friction(act) = spec.action { act(&own) } else { Vec::new() };
        Self { port: spec.port, action: spec.action, own, part_temperatures, torques_Nm, friction }
    }

    fn temperature(&self, row: &Row) -> Dual {
        let lagging = self.part_temperatures.get(row.place).copied();
        lagging.unwrap_or(Dual::constant(row.temperature_difference_K))
    }
}

/// An own effect with its numbers, some of them seeded with a partial.
pub type OwnLink = (Arc<dyn OwnEffect>, Vec<Dual>);

/// Effects that do something, in the order in which they act.
#[derive(Debug, Clone)]
pub struct Chain {
    pub links: Vec<Link>,
    /// Own effects, which act after the library's of their port.
    pub own: Vec<OwnLink>,
    pub drive: DriveNumbers,
}

impl Chain {
    /// What rubs at every reading alike; what does at one reading is in its load.
    pub fn friction(&self) -> impl Iterator<Item = &Friction> {
        self.links.iter().flat_map(|link| &link.friction)
    }

    /// The load of a row: the instruments' gains first, then what acts on its way to the meshing points, then what own
    /// effects have added.
    pub fn load(&self, row: &Row, added: &Added) -> Load {
        let mut load = Load::default();
        self.load_into(&mut load, row, added);
        load
    }

    /// The same in place of another load.
    pub fn load_into(&self, load: &mut Load, row: &Row, added: &Added) {
        load.torque_Nm = Dual::constant(row.torque_Nm);
        load.preload_N = Dual::constant(row.preload_N);
        load.spring_N_per_m = Dual::constant(0.0);
        load.friction.clear();
        for gain in [true, false] {
            for link in self.links.iter().filter(|link| (link.port == Port::Reading) == gain) {
                match link.action {
                    Action::Load(act) => act(&link.own, row, load),
                    Action::Torques(_) => load.torque_Nm += link.torques_Nm[row.place],
                    Action::ThermalLoad(_, act) => act(&link.own, link.temperature(row), load),
                    _ => {}
                }
            }
        }
        load.torque_Nm += added.torque_Nm;
        load.preload_N += added.preload_N;
    }

    /// What the contacts of all pairs become.
    pub fn contact(&self) -> Contact {
        let mut contact = Contact::unchanged();
        for link in &self.links {
            if let Action::Contact(act) = link.action {
                act(&link.own, &mut contact);
            }
        }
        contact
    }

    /// The angle behind the meshing points under a torque on the output.
    pub fn series(&self, row: &Row, torque_Nm: Dual) -> Dual {
        let mut angle = Dual::constant(0.0);
        for link in &self.links {
            if let Action::Series(act) = link.action {
                angle += act(&link.own, row, &self.drive, torque_Nm);
            }
        }
        angle
    }

    /// What depends on the torques before adds to the angle behind the meshing points, at each reading of a run.
    pub fn history(&self, run: &[Row], torque_Nm: &[Dual]) -> Vec<Dual> {
        let mut angles = vec![Dual::constant(0.0); run.len()];
        for link in &self.links {
            if let Action::History(act) = link.action {
                for (angle, part) in angles.iter_mut().zip(act(&link.own, run, torque_Nm)) {
                    *angle += part;
                }
            }
        }
        angles
    }

    /// Whether anything depends on the torques before.
    pub fn has_history(&self) -> bool {
        self.links.iter().any(|link| matches!(link.action, Action::History(_)))
    }

    /// What the instrument shows of the angles of a table, rad.
    pub fn readings(&self, table: &Rows, added: &[Added], mut angles: Vec<Dual>) -> Vec<Dual> {
        let rows = table.by_run();
        for link in self.links.iter().filter(|link| link.port == Port::Reading) {
            if let Action::Readings(act) = link.action {
                for run in (0..table.runs()).map(|number| table.run(number)) {
                    let shown = act(&link.own, &rows[run.clone()], &angles[run.clone()]);
                    angles[run].copy_from_slice(&shown);
                }
            } else {
                for (row, angle) in rows.iter().zip(&mut angles) {
                    *angle = self.reading(link, row, added, *angle);
                }
            }
        }
        angles
    }

    /// The same of one effect at a row.
    fn reading(&self, link: &Link, row: &Row, added: &[Added], angle: Dual) -> Dual {
        match link.action {
            Action::Reading(act) => act(&link.own, row, angle),
            Action::ThermalReading(_, act) => act(&link.own, row, link.temperature(row), angle),
            Action::TorqueReading(act) => {
                act(&link.own, self.load(row, Added::to(row.place, added)).torque_Nm, angle)
            }
            _ => angle,
        }
    }
}
