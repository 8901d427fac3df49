//! A scenario: a TOML file whose every key has a default (`config/scenarios/every-key.toml` shows them all).

mod keys;
mod sections;

use std::path::Path;

use jiff::Timestamp;

use keys::Key;
pub use keys::{Pattern, Span};
pub use sections::{
    Airspace, Birds, Clutter, Drones, FixedWing, Multirotor, Network, Place, Radar, Transponder,
};

use crate::config::error::Faults;
use crate::config::reader::{Item, Section, each};
use crate::config::tree::{self, Table, quoted};
use crate::config::{ConfigError, ConfigErrors, Place as ErrorPlace};
use fusion::time::Time;

/// What flies, what sees it, and how that fails.
#[derive(Clone, Debug, PartialEq)]
pub struct Scenario {
    /// Its name; it is part of every stream of chance.
    pub name: String,
    /// When it begins.
    pub start: Time,
    /// How long it lasts, seconds.
    pub duration_s: f64,
    /// The place.
    pub place: Place,
    /// Where drones fly.
    pub airspace: Airspace,
    /// The drones.
    pub drones: Drones,
    /// How multirotors fly.
    pub multirotor: Multirotor,
    /// How fixed wings fly.
    pub fixed_wing: FixedWing,
    /// Birds.
    pub birds: Birds,
    /// What else moves, or does not.
    pub clutter: Clutter,
    /// The radars; one with every default where the file names none.
    pub radars: Vec<Radar>,
    /// The transponders and their receiver.
    pub transponder: Transponder,
    /// The network.
    pub network: Network,
}

/// Where a scenario begins that does not say.
const START: &str = "2026-03-14T09:00:00Z";
/// Half a day: which day a time of day belongs to is then plain all the way.
const LONGEST_S: f64 = 43_200.0;
/// Each has a multicast group of its own, 239.192.48.n.
const MOST_RADARS: usize = 254;
/// Without the margins of an evaluation nothing would be left.
const SHORTEST_S: f64 = 20.0;

impl Scenario {
    /// Reads the file at `path`.
    ///
    /// # Errors
    /// The file cannot be read, or anything [`Scenario::parse`] refuses.
    pub fn load(path: &Path) -> Result<Self, ConfigErrors> {
        let name = path.display().to_string();
        #[expect(clippy::disallowed_methods, reason = "the one place that reads a scenario's file")]
        let text = std::fs::read_to_string(path).map_err(|error| {
            ConfigErrors::from(ConfigError {
                file: name.clone(),
                place: ErrorPlace::File,
                key: String::new(),
                value: None,
                message: format!("cannot be read: {error}; give the path of a scenario (TOML, UTF-8)"),
            })
        })?;
        Self::parse(&text, &name)
    }

    /// Reads `text`; errors show `file` as the name of its file.
    ///
    /// # Errors
    /// Every fault of the text, each with line and key.
    pub fn parse(text: &str, file: &str) -> Result<Self, ConfigErrors> {
        let faults = Faults::new(file);
        let root = tree::parse(text, &faults);
        faults.check()?;
        let mut top = Section::top(&root, &faults);
        let name = top.need("name", "name = …, of letters, digits, _ and -");
        let name = name.and_then(|item| String::read(&item, &keys::ANY));
        let start = top.item("start").and_then(|item| instant(&item));
        let duration_s = top.item("duration_s").and_then(|item| {
            let rule = format!("a scenario lasts {SHORTEST_S} to {LONGEST_S} seconds");
            item.number(&rule, |value| (SHORTEST_S..=LONGEST_S).contains(&value))
        });
        let mut scenario = Self {
            name: name.unwrap_or_default(),
            duration_s: duration_s.unwrap_or(300.0),
            place: Place::read(top.section("place")),
            airspace: Airspace::read(top.section("airspace")),
            drones: Drones::read(top.section("drones")),
            multirotor: Multirotor::read(top.section("multirotor")),
            fixed_wing: FixedWing::read(top.section("fixed_wing")),
            birds: Birds::read(top.section("birds")),
            clutter: Clutter::read(top.section("clutter")),
            radars: Vec::new(),
            transponder: Transponder::read(top.section("transponder")),
            network: Network::read(top.section("network")),
            start: start.unwrap_or_else(default_start),
        };
        scenario.radars = each(top.item("radars"), |section| Some(Radar::read(section))).unwrap_or_default();
        if scenario.radars.is_empty() {
            scenario.radars.push(Radar::default());
        }
        scenario.agree(&root, &faults);
        top.finish();
        faults.check()?;
        Ok(scenario)
    }

    /// Finds fault with keys that contradict each other.
    fn agree(&self, root: &Table, faults: &Faults) {
        let refuse = |mut section: Section<'_>, key: &'static str, message: &str| match section.item(key) {
            Some(item) => item.refuse(message),
            None => section.refuse(format!("{key}: {message}")),
        };
        let section = |name| Section::top(root, faults).section(name);
        let drones = &self.drones;
        if drones.equipped > self.drone_count() {
            let message =
                format!("there are only {} drones: multirotors and fixed_wings", self.drone_count());
            refuse(section("drones"), "equipped", &message);
        }
        if drones.spoofed + drones.jammed > drones.equipped {
            refuse(section("drones"), "spoofed", "spoofed and jammed together are more than equipped");
        }
        let service = (self.place.sac, self.place.sic);
        if (self.transponder.sac, self.transponder.sic) == service {
            let message = "SAC and SIC are the service's own ([place]); give the receiver others";
            refuse(section("transponder"), "sic", message);
        }
        let list = Section::top(root, faults).item("radars").and_then(|list| list.list()).unwrap_or_default();
        for (index, radar) in self.radars.iter().enumerate() {
            let table = list.get(index).and_then(Item::section);
            let table = table.unwrap_or_else(|| Section::top(root, faults));
            let before = &self.radars[..index];
            let code = (radar.sac, radar.sic);
            if code == service || before.iter().any(|other| (other.sac, other.sic) == code) {
                let message = "each radar needs its own SAC and SIC, which are not the service's ([place])";
                refuse(table, "sic", message);
            } else if radar.id == TRANSPONDER_ID || before.iter().any(|other| other.id == radar.id) {
                refuse(table, "id", "another sensor has this id already; give each its own");
            } else if radar.min_range_m >= radar.max_range_m {
                refuse(table, "max_range_m", "this is not above min_range_m");
            } else if index == MOST_RADARS {
                table.refuse(format!("there are at most {MOST_RADARS} radars"));
            }
        }
    }

    /// All drones.
    pub fn drone_count(&self) -> u32 {
        self.drones.multirotors + self.drones.fixed_wings
    }

    /// The scenario as TOML, every key with its meaning.
    pub fn show(&self) -> String {
        let mut text = "# Every key with its meaning. One that is left out has its default.\n\n".to_owned();
        text += &keys::line(
            "name",
            &self.name.show(),
            "part of every stream of chance: another name flies otherwise",
        );
        text += &keys::line("start", &quoted(&rfc3339(self.start)), "UTC");
        text += &keys::line("duration_s", &self.duration_s.show(), "how long it lasts, seconds");
        text += &self.place.show("[place]");
        text += &self.airspace.show("[airspace]");
        text += &self.drones.show("[drones]");
        text += &self.multirotor.show("[multirotor]");
        text += &self.fixed_wing.show("[fixed_wing]");
        text += &self.birds.show("[birds]");
        text += &self.clutter.show("[clutter]");
        for radar in &self.radars {
            text += &radar.show("[[radars]]");
        }
        text += &self.transponder.show("[transponder]");
        text += &self.network.show("[network]");
        text
    }
}

/// The transponder receiver's name as a sensor.
pub const TRANSPONDER_ID: &str = "drone-it";

fn default_start() -> Time {
    time_of(START).expect("the default start is a time")
}

fn instant(item: &Item<'_>) -> Option<Time> {
    let time = item.text().and_then(time_of);
    if time.is_none() {
        item.refuse("write it in quotes as \"2026-03-14T09:00:00Z\", years 1970 to 2105");
    }
    time
}

fn rfc3339(time: Time) -> String {
    Timestamp::from_nanosecond(time.nanos().into())
        .map_or_else(|_| time.to_string(), |stamp| stamp.to_string())
}

fn time_of(text: &str) -> Option<Time> {
    let stamp: Timestamp = text.parse().ok()?;
    let nanos = i64::try_from(stamp.as_nanosecond()).ok()?;
    (0..=4_265_000_000_000_000_000).contains(&nanos).then(|| Time::from_nanos(nanos))
}
