//! A scenario: a TOML file whose every key has a default (`config/scenarios/every-key.toml` shows them all).

mod keys;
mod sections;

use std::path::Path;

use jiff::Timestamp;

pub use keys::{Pattern, Span};
pub use sections::{
    Airspace, Birds, Clutter, Drones, FixedWing, Multirotor, Network, Place, Radar, Transponder,
};

use crate::config::error::Faults;
use crate::config::reader::{Item, Section, each};
use crate::config::tree;
use crate::config::{ConfigError, ConfigErrors, Place as ErrorPlace};
use crate::time::Time;

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
/// No longer than a day: the sensors send times of day.
const LONGEST_S: f64 = 43_200.0;
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
        let name = top.need("name", "name = …, of letters, digits, _ and -").and_then(|item| {
            let text = item.text()?;
            let plain = text.chars().all(|c| c.is_ascii_alphanumeric() || c == '_' || c == '-');
            if !plain {
                item.refuse("use only letters A-Z a-z, digits, _ and -");
            }
            Some(text.to_owned())
        });
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
        let list = top.item("radars");
        scenario.radars = each(list.clone(), |section| Some(Radar::read(section))).unwrap_or_default();
        if scenario.radars.is_empty() {
            scenario.radars.push(Radar::default());
        }
        scenario.agree(&top, list.as_ref());
        top.finish();
        faults.check()?;
        Ok(scenario)
    }

    /// Finds fault with keys that contradict each other.
    fn agree(&self, top: &Section<'_>, radars: Option<&Item<'_>>) {
        let drones = &self.drones;
        if drones.equipped > self.drone_count() {
            top.refuse(format!(
                "drones.equipped = {}, but there are {} drones (multirotors and fixed_wings)",
                drones.equipped,
                self.drone_count()
            ));
        }
        if drones.spoofed + drones.jammed > drones.equipped {
            top.refuse("drones.spoofed and drones.jammed together are more than drones.equipped");
        }
        let mut codes: Vec<(u32, u32)> = self.radars.iter().map(|radar| (radar.sac, radar.sic)).collect();
        codes.push((self.place.sac, self.place.sic));
        codes.sort_unstable();
        let mut ids: Vec<&str> = self.radars.iter().map(|radar| radar.id.as_str()).collect();
        ids.push(TRANSPONDER_ID);
        ids.sort_unstable();
        if codes.windows(2).any(|pair| pair[0] == pair[1]) || ids.windows(2).any(|pair| pair[0] == pair[1]) {
            let message = "each radar needs its own id, and its own SAC and SIC, which are not the service's";
            radars.map_or_else(|| top.refuse(message), |list| list.refuse(message));
        }
        for radar in self.radars.iter().filter(|radar| radar.min_range_m >= radar.max_range_m) {
            top.refuse(format!("radar {}: min_range_m is not below max_range_m", radar.id));
        }
    }

    /// All drones.
    pub fn drone_count(&self) -> u32 {
        self.drones.multirotors + self.drones.fixed_wings
    }

    /// The scenario as TOML, every key with its meaning.
    pub fn show(&self) -> String {
        let mut text = format!(
            "name = \"{}\"{:27}# its name; another name flies otherwise\nstart = \"{}\"        # UTC\nduration_s = {:?}{:21}# seconds\n",
            self.name, "", self.start, self.duration_s, ""
        );
        let mut section = |name: &str, keys: String| text += &format!("\n[{name}]\n{keys}");
        section("place", self.place.show());
        section("airspace", self.airspace.show());
        section("drones", self.drones.show());
        section("multirotor", self.multirotor.show());
        section("fixed_wing", self.fixed_wing.show());
        section("birds", self.birds.show());
        section("clutter", self.clutter.show());
        for radar in &self.radars {
            section("[radars]", radar.show());
        }
        section("transponder", self.transponder.show());
        section("network", self.network.show());
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

fn time_of(text: &str) -> Option<Time> {
    let stamp: Timestamp = text.parse().ok()?;
    let nanos = i64::try_from(stamp.as_nanosecond()).ok()?;
    (0..=4_265_000_000_000_000_000).contains(&nanos).then(|| Time::from_nanos(nanos))
}
