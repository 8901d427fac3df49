//! The configuration: one TOML file, with single keys overridden by the environment.
//!
//! `config/example.toml` shows every key. The name of a key includes its unit. Unknown keys are refused. All errors are reported
//! together, each with file, line, key, the problem and the remedy.
//!
//! The variable `UTM_FUSION__SECTION__KEY` overrides a key; deeper keys need more `__` (`UTM_FUSION__OUTPUT__RECORD__DIR`). The
//! value is parsed as TOML, and as plain text if that fails. `[[sensors]]` and `[[areas]]` can be set in the file only.
//!
//! Each key is defined once, in the `section!` of its table (`site`, `sensors`, `network`, `fusion`, `integrity`, `conflicts`,
//! `alerts`, `areas`, `output`, `http`, `cluster`): field, default, check, documentation, and whether SIGHUP reloads it.
//! `docs/CONFIGURATION.md` is generated from these definitions.
//!
//! Reading: text → `tables::tree` (values with their line) → `overrides` → the tables, which take their keys and refuse the
//! others. Serde is not used for reading because it stops at the first error.

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
mod line_fields;
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
pub use changes::{ConfigChange, changes};
pub use cidr::{Network, NotANetwork};
pub use classification::{CategoryOctet, Classification, Codes, ScaledOctet};
pub use cluster::{CellArea, Cluster, Role};
pub use conflicts::{Advisory, ConflictVolume, Conflicts, VolumePreset, VolumeSide, Warning};
pub use connections::{BrokerAddress, Connection, ConnectionFormat, KnownSystem, MavlinkSystem, NO_COUNTRY};
pub use fusion::{Fusion, MAX_WINDOW_SLOTS, Motion, Profile};
pub use http::{Auth, Http, RateLimit, Tiles, TlsFiles};
pub use integrity::{Action, Integrity};
pub use line_fields::{LineField, LineFields, LineMapping, LinePosition};
pub use map::Map;
pub use network::{Address, Category, Feed, Input, LONGEST_TRAILER, PictureKind, Sink};
pub use output::{MAX_ACCURACY_M, Output, Persistence, Record, SerialSource};
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

/// A valid configuration with all defaults filled in. [`Display`] writes it as TOML that reads back to the same value.
#[derive(Clone, Debug, PartialEq)]
pub struct Config {
    /// Identity and location of the service.
    pub site: Site,
    /// Sensors in the order of the file. The first radar is the origin of the local frame; without a radar, the site is.
    pub sensors: Vec<Sensor>,
    /// Fusion engine.
    pub fusion: Fusion,
    /// Integrity of transponders.
    pub integrity: Integrity,
    /// Prediction of conflicts between aircraft.
    pub conflicts: Conflicts,
    /// Alerts and their receivers.
    pub alerts: Alerts,
    /// Files of areas, not yet loaded.
    pub areas: Vec<Area>,
    /// Outputs and recording.
    pub output: Output,
    /// HTTP service.
    pub http: Http,
    /// Map page.
    pub map: Map,
    /// State kept across restarts.
    pub state: Persistence,
    /// Cluster of several machines.
    pub cluster: Option<Cluster>,
}

/// Writes TOML that reads back to the same value. An absent key without a default is written as a comment that explains its
/// absence.
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
    /// The file cannot be read, or its content is refused by [`Config::parse`].
    pub fn load(path: impl AsRef<Path>) -> Result<Self, ConfigErrors> {
        let path = path.as_ref();
        let text = error::read_file(path, "configuration file")?;
        // `env::vars` would panic on an unrelated variable that is not UTF-8.
        let env = std::env::vars_os()
            .filter_map(|(key, value)| Some((key.into_string().ok()?, value.to_string_lossy().into_owned())));
        Self::parse(&text, &path.display().to_string(), env)
    }

    /// Parses `text`, overridden by the `UTM_FUSION__…` variables of `env`; other variables are ignored. `name` is the path of
    /// the file, used in errors and as the base of the paths in `[[areas]]`.
    ///
    /// # Errors
    /// All errors of the text and the variables. After a syntax error only the syntax errors, because what follows would be
    /// guesswork.
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
        // Refused or missing keys have placeholder values, which are never returned.
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

    /// Takes the keys that SIGHUP reloads from `wanted`. The caller that reads the files of areas reloads the areas.
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

    /// Whether the integrity of transponders is evaluated.
    pub fn evaluates_integrity(&self) -> bool {
        self.fusion.profile == Profile::Operational && self.integrity.action != Action::Off
    }

    /// Whether conflicts are predicted.
    pub fn predicts_conflicts(&self) -> bool {
        self.fusion.profile == Profile::Operational && self.conflicts.enabled
    }

    /// Radars in the order of the file. The first is the origin of the ENU frame.
    pub fn radars(&self) -> impl Iterator<Item = (&Sensor, &Radar)> {
        self.sensors.iter().filter_map(|sensor| Some((sensor, sensor.kind.radar()?)))
    }

    /// Edition of CAT021 of each ADS-B receiver, by SAC and SIC.
    pub fn editions(&self) -> BTreeMap<DataSource, Edition> {
        let of = |sensor: &Sensor| match &sensor.kind {
            SensorKind::AdsB(adsb) => Some((DataSource { sac: sensor.sac, sic: sensor.sic }, adsb.edition)),
            _ => None,
        };
        self.sensors.iter().filter_map(of).collect()
    }

    /// Origin of the ENU frame: WGS-84 latitude and longitude in degrees, and height above mean sea level in metres. It is the
    /// position of the first radar, or of the site if there is no radar.
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
