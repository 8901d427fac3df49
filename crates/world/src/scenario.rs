//! A scenario: a TOML file whose every key has a default (`config/scenarios/every-key.toml` shows them all).

mod emitters;
mod keys;
mod sections;

use std::path::Path;

use fusion::time::Time;
use jiff::Timestamp;

pub use emitters::{Adsb, Camera, Crewed, RemoteId};
pub use keys::{Attack, Pattern, VelocityModel};
pub use sections::{
    Airspace, Birds, Clutter, Drones, FixedWing, Multirotor, Network, Place, Radar, Transponder,
};
pub use tables::kinds::Span;

use tables::error::{ConfigErrors, Faults, read_file};
use tables::kinds::{Kind, flag, inline, number, parsed, tables};
use tables::reader::{Item, Section};
use tables::section;
use tables::table::{ByHand, Table, need};
use tables::tree;

section! {
    /// A scenario: targets, sensors, and their errors.
    Scenario {
        /// Name of the scenario; it is part of the random seed, so that another name gives another flight
        name: String = need("name = …, of letters, digits, _ and -"), keys::plain_name();
        /// Start, UTC
        start: Timestamp = default_start(), time();
        /// Duration, seconds
        duration_s: f64 = 300.0, number(
            // At most half a day, so that the day of each time of day is unambiguous. The minimum leaves a usable
            // interval between the margins of an evaluation.
            "a scenario lasts 20 to 43200 seconds",
            |s| (20.0..=43_200.0).contains(&s),
        );
        /// Whether there are radars
        has_radars: bool = true, flag();
        /// The place.
        place: Place = Place::default(), inline();
        /// The airspace in which drones fly.
        airspace: Airspace = Airspace::default(), inline();
        /// The drones.
        drones: Drones = Drones::default(), inline();
        /// Flight of multirotors.
        multirotor: Multirotor = Multirotor::default(), inline();
        /// Flight of fixed-wing drones.
        fixed_wing: FixedWing = FixedWing::default(), inline();
        /// Birds.
        birds: Birds = Birds::default(), inline();
        /// Vehicles and clutter.
        clutter: Clutter = Clutter::default(), inline();
        /// The radars. A file that names none has one radar with every default.
        radars: Vec<Radar> = Vec::new(), tables();
        /// The transponders and their receiver.
        transponder: Transponder = Transponder::default(), inline();
        /// Crewed aircraft.
        crewed: Crewed = Crewed::default(), inline();
        /// The ADS-B receiver.
        adsb: Adsb = Adsb::default(), inline();
        /// Remote ID.
        remote_id: RemoteId = RemoteId::default(), inline();
        /// Cameras.
        cameras: Vec<Camera> = Vec::new(), tables();
        /// The network.
        network: Network = Network::default(), inline();
    } by hand {}
}

/// Start of a scenario that does not state one.
const START: &str = "2026-03-14T09:00:00Z";
/// Each radar has its own multicast group, 239.192.48.n.
const MOST_RADARS: usize = 254;

/// Checks keys that have to agree with each other.
impl ByHand for Scenario {
    fn more(&mut self, section: &mut Section<'_>) {
        let refuse = |table: Option<&Section<'_>>, key: &str, message: &str| match table
            .and_then(|table| table.written(key))
        {
            Some(item) => item.refuse(message),
            None => table.unwrap_or(section).refuse(format!("{key}: {message}")),
        };
        let table = |name: &str| section.written(name).and_then(|item| item.section());
        let drones = &self.drones;
        if drones.equipped > self.drone_count() {
            let message =
                format!("there are only {} drones: multirotors and fixed_wings", self.drone_count());
            refuse(table("drones").as_ref(), "equipped", &message);
        }
        if drones.spoofed + drones.jammed > drones.equipped {
            let message = "spoofed and jammed together are more than equipped";
            refuse(table("drones").as_ref(), "spoofed", message);
        }
        if self.transponder.attack == Attack::Swapped && drones.spoofed % 2 == 1 {
            let message = "attack \"swapped\" takes two transponders each";
            refuse(table("drones").as_ref(), "spoofed", message);
        }
        if drones.pattern == Pattern::Formation && drones.separation_m > 0.8 * drones.formation_m {
            let message = "in a formation this is at most 0.8 of formation_m";
            refuse(table("drones").as_ref(), "separation_m", message);
        }
        let service = (self.place.sac, self.place.sic);
        if (self.transponder.sac, self.transponder.sic) == service {
            let message = "SAC and SIC are the service's own ([place]); give the receiver others";
            refuse(table("transponder").as_ref(), "sic", message);
        }
        let is_without = |flag: bool, count: u32| !flag && count > 0;
        if is_without(self.transponder.has_receiver, drones.equipped) {
            refuse(table("transponder").as_ref(), "has_receiver", "there are transponders: drones.equipped");
        }
        if self.remote_id.drones > self.drone_count() {
            let message = format!("there are only {} drones", self.drone_count());
            refuse(table("remote_id").as_ref(), "drones", &message);
        }
        if self.crewed.conflicts > self.drone_count() {
            refuse(table("crewed").as_ref(), "conflicts", "each meets a drone of its own; there are fewer");
        }
        if is_without(self.has_radars, self.radars.len() as u32) {
            refuse(None, "has_radars", "there are [[radars]]; remove them, or set this to true");
        }
        if self.radars.is_empty() && self.has_radars {
            self.radars.push(Radar::default());
        }
        let list = section.written("radars").and_then(|list| list.list()).unwrap_or_default();
        for (index, radar) in self.radars.iter().enumerate() {
            let table = list.get(index).and_then(Item::section);
            let refuse = |key, message| refuse(table.as_ref(), key, message);
            let before = &self.radars[..index];
            let code = (radar.sac, radar.sic);
            if code == service || before.iter().any(|other| (other.sac, other.sic) == code) {
                refuse("sic", "each radar needs its own SAC and SIC, which are not the service's ([place])");
            } else if radar.id == TRANSPONDER_ID || before.iter().any(|other| other.id == radar.id) {
                refuse("id", "another sensor has this id already; give each its own");
            } else if radar.min_range_m >= radar.max_range_m {
                refuse("max_range_m", "this is not above min_range_m");
            } else if index == MOST_RADARS {
                table.as_ref().unwrap_or(section).refuse(format!("there are at most {MOST_RADARS} radars"));
            }
        }
        let ids = self.radars.iter().map(|radar| radar.id.as_str()).chain([TRANSPONDER_ID]);
        let mut ids: Vec<&str> = ids.collect();
        let receivers = [("adsb", &self.adsb.id), ("remote_id", &self.remote_id.id)];
        for (name, id) in receivers {
            if ids.contains(&id.as_str()) {
                refuse(table(name).as_ref(), "id", "another sensor has this id already; give each its own");
            }
            ids.push(id);
        }
        let list = section.written("cameras").and_then(|list| list.list()).unwrap_or_default();
        for (index, camera) in self.cameras.iter().enumerate() {
            let table = list.get(index).and_then(Item::section);
            let before = &self.cameras[..index];
            if ids.contains(&camera.id.as_str()) || before.iter().any(|other| other.id == camera.id) {
                refuse(table.as_ref(), "id", "another sensor has this id already; give each its own");
            } else if before.iter().any(|other| (other.sac, other.sic) == (camera.sac, camera.sic)) {
                refuse(table.as_ref(), "sic", "each camera needs its own SAC and SIC");
            }
        }
    }
}

impl Scenario {
    /// Reads the file at `path`.
    ///
    /// # Errors
    /// The file cannot be read, or anything [`Scenario::parse`] refuses.
    pub fn load(path: &Path) -> Result<Self, ConfigErrors> {
        Self::parse(&read_file(path, "scenario")?, &path.display().to_string())
    }

    /// Reads `text`; errors show `file` as the name of its file.
    ///
    /// # Errors
    /// Every fault of the text, each with line and key.
    pub fn parse(text: &str, file: &str) -> Result<Self, ConfigErrors> {
        let faults = Faults::new(file);
        let root = tree::parse(text, &faults);
        faults.check()?;
        let scenario = <Self as Table>::read(Section::top(&root, &faults));
        faults.check()?;
        Ok(scenario)
    }

    /// Start of the scenario, unless the simulation is given another one.
    pub fn start_time(&self) -> Time {
        let nanos = i64::try_from(self.start.as_nanosecond()).expect("a scenario begins before 2106");
        Time::from_nanos(nanos)
    }

    /// Number of drones.
    pub fn drone_count(&self) -> u32 {
        self.drones.multirotors + self.drones.fixed_wings
    }

    /// Returns the scenario as TOML; each key has a comment with its meaning.
    pub fn show(&self) -> String {
        let mut text = "# Every key with its meaning. One that is left out has its default.\n\n".to_owned();
        text.extend(keys::lines(self).take(4));
        text += &keys::show(&self.place, "[place]");
        text += &keys::show(&self.airspace, "[airspace]");
        text += &keys::show(&self.drones, "[drones]");
        text += &keys::show(&self.multirotor, "[multirotor]");
        text += &keys::show(&self.fixed_wing, "[fixed_wing]");
        text += &keys::show(&self.birds, "[birds]");
        text += &keys::show(&self.clutter, "[clutter]");
        for radar in &self.radars {
            text += &keys::show(radar, "[[radars]]");
        }
        text += &keys::show(&self.transponder, "[transponder]");
        text += &keys::show(&self.crewed, "[crewed]");
        text += &keys::show(&self.adsb, "[adsb]");
        text += &keys::show(&self.remote_id, "[remote_id]");
        for camera in &self.cameras {
            text += &keys::show(camera, "[[cameras]]");
        }
        if self.cameras.is_empty() {
            // A table that is present adds a camera, so this one is commented out.
            let camera = keys::show(&Camera::default(), "[[cameras]]");
            let lines = camera.trim_start().lines();
            text.push('\n');
            text.extend(lines.map(|line| format!("# {}\n", line.trim_start_matches("# "))));
        }
        text += &keys::show(&self.network, "[network]");
        text
    }
}

/// The transponder receiver's name as a sensor.
pub const TRANSPONDER_ID: &str = "drone-it";

fn default_start() -> Timestamp {
    stamp(START).expect("the default start is a time")
}

fn time() -> Kind<Timestamp> {
    const RULE: &str = "write it in quotes as \"2026-03-14T09:00:00Z\", years 1970 to 2105";
    parsed(RULE, |text| stamp(text).ok_or(RULE))
}

fn stamp(text: &str) -> Option<Timestamp> {
    let stamp: Timestamp = text.parse().ok()?;
    (0..=4_265_000_000).contains(&stamp.as_second()).then_some(stamp)
}
