//! The configuration: one TOML file, single keys overridden by the environment.
//!
//! `config/example.toml` shows every key. A key's name holds its unit; an unknown key is refused; an error names file,
//! line, key, what is wrong and what to do, and all errors are reported together.
//!
//! A key is overridden by the variable `UTM_FUSION__SECTION__KEY`, deeper ones by further `__`
//! (`UTM_FUSION__OUTPUT__RECORD__DIR`). Its value is read as a TOML value, and as text where it is none. `[[sensors]]`
//! and `[[areas]]` are set in the file only.
//!
//! Each key is stated once, in the `section!` of its table (`site`, `sensors`, `network`, `fusion`, `integrity`,
//! `conflicts`, `alerts`, `areas`, `output`, `http`, `cluster`), with
//! its field, default, check, meaning, and whether SIGHUP reloads it; `docs/CONFIGURATION.md` follows from there.
//!
//! On the way in: text → `tables::tree` (values that know their line) → `overrides` → the tables, which ask for their keys and
//! refuse the rest. They go through the tree rather than through serde, which stops at the first fault.

mod adsb;
mod alerts;
mod areas;
mod changes;
mod cidr;
mod classification;
mod cluster;
mod conflicts;
mod connections;
mod fusion;
mod http;
mod integrity;
mod map;
mod network;
mod output;
mod overrides;
mod page;
mod receivers;
mod sensors;
mod sinks;
mod site;

use std::collections::BTreeMap;
use std::fmt::{self, Display, Formatter};
use std::path::Path;

use asterix::DataSource;
use asterix::cat021::Edition;

pub use adsb::AdsB;
pub use alerts::{AlertKind, AlertRule, Alerts, Severity};
pub use areas::{AlertArea, Area, AreaKind, AreaSeverity};
pub use changes::{Change, changes};
pub use cidr::{Network, NotANetwork};
pub use classification::{CategoryOctet, Classification, Codes, ScaledOctet};
pub use cluster::{CellArea, Cluster, Role};
pub use conflicts::{Advisory, ConflictVolume, Conflicts, VolumePreset, VolumeSide, Warning};
pub use connections::{BrokerAddress, Connection, ConnectionFormat, MavlinkSystem, mavlink_sensors};
pub use fusion::{Fusion, MAX_WINDOW_SLOTS, Motion, Profile};
pub use http::{Auth, Http, RateLimit, Tiles, TlsFiles};
pub use integrity::{Action, Integrity};
pub use map::Map;
pub use network::{Address, Category, Feed, Input, LONGEST_TRAILER, PictureKind, Sink};
pub use output::{Output, Persistence, Record, SerialSource};
pub use page::{keys, reference};
pub use receivers::{Mqtt, MqttTracks, Webhook};
pub use sensors::{
    Camera, CameraAccuracy, Radar, RadarAccuracy, Registration, Sensor, SensorKind, Transponder,
    TransponderAccuracy,
};
pub use sinks::{Carrier, Cot, CotUrl, F3623, Sapient, TcpUrl};
pub use site::Site;
pub use tables::error::{ConfigError, ConfigErrors, Place};
pub use tables::named::UnknownName;
pub use tables::reader::FILL_IN;

use tables::error::{self, Faults};
use tables::reader::Section;
use tables::table::Table;
use tables::{kinds, tree};

/// A valid configuration, every default filled in. [`Display`] writes it as TOML that reads back
/// to the same value.
#[derive(Clone, Debug, PartialEq)]
pub struct Config {
    /// The service itself.
    pub site: Site,
    /// The sensors in the order of the file; the first radar is the origin of the frame, without one the site is.
    pub sensors: Vec<Sensor>,
    /// The engine.
    pub fusion: Fusion,
    /// Whether transponders are what they say they are.
    pub integrity: Integrity,
    /// Who will come near whom.
    pub conflicts: Conflicts,
    /// What is to be looked at, and who hears of it.
    pub alerts: Alerts,
    /// Polygons, not yet loaded.
    pub areas: Vec<Area>,
    /// What is sent and recorded.
    pub output: Output,
    /// The HTTP service.
    pub http: Http,
    /// The map page.
    pub map: Map,
    /// What outlives a restart.
    pub state: Persistence,
    /// Several machines.
    pub cluster: Option<Cluster>,
}

/// TOML that reads back to the same value. What is absent and has no default is a comment that says what that means.
impl Display for Config {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        show(f, "[site]", &self.site)?;
        self.sensors.iter().try_for_each(|sensor| show(f, "\n[[sensors]]", sensor))?;
        show(f, "\n[fusion]", &self.fusion)?;
        show(f, "\n[integrity]", &self.integrity)?;
        show(f, "\n[conflicts]", &self.conflicts)?;
        show(f, "\n[alerts]", &self.alerts)?;
        self.areas.iter().try_for_each(|area| show(f, "\n[[areas]]", area))?;
        show(f, "\n[output]", &self.output)?;
        show(f, "\n[http]", &self.http)?;
        show(f, "\n[map]", &self.map)?;
        show(f, "\n[state]", &self.state)?;
        self.cluster.iter().try_for_each(|cluster| show(f, "\n[cluster]", cluster))
    }
}

fn show(f: &mut Formatter<'_>, header: &str, table: &impl Table) -> fmt::Result {
    writeln!(f, "{header}")?;
    table.entries().iter().try_for_each(|entry| match &entry.value {
        Ok(value) => writeln!(f, "{} = {value}", entry.key),
        Err(absent) => writeln!(f, "# {}: {absent}", entry.key),
    })
}

impl Config {
    /// Reads the file at `path` and the environment of this process.
    ///
    /// # Errors
    /// The file cannot be read, or anything [`Config::parse`] refuses.
    pub fn load(path: impl AsRef<Path>) -> Result<Self, ConfigErrors> {
        let path = path.as_ref();
        let text = error::read_file(path, "configuration file")?;
        // `env::vars` would panic on an unrelated variable that is not UTF-8.
        let env = std::env::vars_os()
            .filter_map(|(key, value)| Some((key.into_string().ok()?, value.to_string_lossy().into_owned())));
        Self::parse(&text, &path.display().to_string(), env)
    }

    /// Reads `text`, overridden by the `UTM_FUSION__…` variables among `env` (others are ignored). `name` is the path
    /// of the file: errors show it, and the files of `[[areas]]` are looked for beside it.
    ///
    /// # Errors
    /// Every fault of the text and the variables; only the syntax errors where there are any, because what follows
    /// one is guesswork.
    pub fn parse(
        text: &str,
        name: &str,
        env: impl Iterator<Item = (String, String)>,
    ) -> Result<Self, ConfigErrors> {
        let faults = Faults::new(name);
        let mut root = tree::parse(text, &faults);
        faults.check()?;
        overrides::apply(&mut root, env, &faults);

        let mut top = Section::top(&root, &faults);
        let site = Site::read(top.need_section("site", "[site] with name, sac and sic"));
        let sensors = sensors::read(&mut top, &site, &faults);
        let fusion = Fusion::read(top.section("fusion"));
        let integrity = Integrity::read(top.section("integrity"));
        let conflicts = Conflicts::read(top.section("conflicts"));
        let alerts = Alerts::read(top.section("alerts"));
        let ids: Vec<&str> = sensors.iter().map(|sensor| &*sensor.id).collect();
        let areas =
            kinds::checked_tables(top.item("areas"), |area: &Area, section| area.check(section, &ids));
        let output = Output::read(top.section("output"));
        for key in output.sinks_of_now().into_iter().filter(|_| !fusion.now) {
            if let Some(sinks) = top.written("output").and_then(|item| item.section()?.written(key)) {
                sinks.refuse(
                    "there is no picture of now to send; set fusion.now = true, in the operational profile",
                );
            }
        }
        let lacks_now = conflicts.lacks_now(&fusion);
        if lacks_now
            && let Some(item) = top.written("conflicts").and_then(|item| item.section()?.written("enabled"))
        {
            item.refuse("there is no picture of now to compute them on; set fusion.now = true, or picture = \"lagged\"");
        }
        let http = Http::read(top.section("http"));
        let map = Map::read(top.section("map"));
        let state = Persistence::read(top.section("state"));
        let cluster = top.item("cluster").and_then(|item| item.section()).map(Cluster::read);
        top.finish();
        // What was refused or is missing is blank: it never leaves.
        faults.check()?;
        Ok(Self {
            site,
            sensors,
            fusion,
            integrity,
            conflicts,
            alerts,
            areas,
            output,
            http,
            map,
            state,
            cluster,
        })
    }

    /// Takes the keys that SIGHUP reloads from `wanted`; areas are reloaded by whoever has read their files.
    pub fn reload(&mut self, wanted: &Self) {
        self.site.reload(&wanted.site);
        self.fusion.reload(&wanted.fusion);
        self.integrity.reload(&wanted.integrity);
        self.conflicts.reload(&wanted.conflicts);
        self.alerts.reload(&wanted.alerts);
        self.output.reload(&wanted.output);
        self.http.reload(&wanted.http);
        self.map.reload(&wanted.map);
        self.state.reload(&wanted.state);
        self.cluster.iter_mut().zip(&wanted.cluster).for_each(|(own, wanted)| own.reload(wanted));
    }

    /// Whether it is found out if transponders are what they say they are.
    pub fn judges_integrity(&self) -> bool {
        self.fusion.profile == Profile::Operational && self.integrity.action != Action::Off
    }

    /// Whether it is computed who will come near whom.
    pub fn finds_conflicts(&self) -> bool {
        self.fusion.profile == Profile::Operational && self.conflicts.enabled
    }

    /// The radars, in the order of the file; the first is the origin of the ENU frame.
    pub fn radars(&self) -> impl Iterator<Item = (&Sensor, &Radar)> {
        self.sensors.iter().filter_map(|sensor| Some((sensor, sensor.kind.radar()?)))
    }

    /// Which edition of CAT021 each ADS-B receiver follows, by SAC and SIC.
    pub fn editions(&self) -> BTreeMap<DataSource, Edition> {
        let of = |sensor: &Sensor| match &sensor.kind {
            SensorKind::AdsB(adsb) => Some((DataSource { sac: sensor.sac, sic: sensor.sic }, adsb.edition)),
            _ => None,
        };
        self.sensors.iter().filter_map(of).collect()
    }

    /// The origin of the ENU frame: WGS-84 latitude and longitude, degrees, and height above mean sea level, metres; of the
    /// first radar or, without one, of the site.
    pub fn origin(&self) -> (f64, f64, f64) {
        match self.radars().next() {
            Some((_, radar)) => (radar.latitude_deg, radar.longitude_deg, radar.height_amsl_m),
            None => {
                let Site { latitude_deg, longitude_deg, height_amsl_m, .. } = self.site;
                let [latitude, longitude, height] =
                    [latitude_deg, longitude_deg, height_amsl_m].map(Option::unwrap_or_default);
                (latitude, longitude, height)
            }
        }
    }
}

#[cfg(test)]
mod tests;
