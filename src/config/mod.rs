//! The configuration: one TOML file, single keys overridden by the environment.
//!
//! `config/example.toml` shows every key. A key's name holds its unit; an unknown key is refused; an error names file,
//! line, key, what is wrong and what to do, and all errors are reported together.
//!
//! A key is overridden by the variable `UTM_FUSION__SECTION__KEY`, deeper ones by further `__`
//! (`UTM_FUSION__OUTPUT__RECORD__DIR`). Its value is read as a TOML value, and as text where it is none. `[[sensors]]`
//! and `[[areas]]` are set in the file only.
//!
//! On the way in: text → `tree` (values that know their line) → `overrides` → one reader per section (`site`,
//! `sensors`, `fusion`, `output`, `http`), which asks for its keys and refuses the rest. The readers go through the tree rather
//! than through serde, which stops at the first fault.

mod changes;
mod cidr;
pub(crate) mod error;
mod fusion;
mod http;
mod network;
mod output;
mod overrides;
pub(crate) mod reader;
mod sensors;
mod show;
mod site;
pub(crate) mod tree;
mod types;

use std::path::Path;

pub use changes::{Change, changes};
pub use cidr::{Network, NotANetwork};
pub use error::{ConfigError, ConfigErrors, Place};
pub use http::{Auth, Http, RateLimit, Tiles, TlsFiles};
pub use reader::FILL_IN;
pub use types::{
    Address, Area, AreaKind, Classification, Fusion, Input, MAX_WINDOW_SLOTS, Motion, Output, Profile, Radar,
    RadarAccuracy, Record, Registration, Sensor, SensorKind, SerialSource, Sink, Site, State, Transponder,
    TransponderAccuracy, UnknownMotion, UnknownProfile,
};

use error::Faults;
use reader::Section;

/// A valid configuration, every default filled in. [`Display`](std::fmt::Display) writes it as TOML that reads back
/// to the same value.
#[derive(Clone, Debug, PartialEq)]
pub struct Config {
    /// The service itself.
    pub site: Site,
    /// The sensors in the order of the file; at least one is a radar, and the first radar is the origin of the frame.
    pub sensors: Vec<Sensor>,
    /// The engine.
    pub fusion: Fusion,
    /// Polygons, not yet loaded.
    pub areas: Vec<Area>,
    /// What is sent and recorded.
    pub output: Output,
    /// The HTTP service.
    pub http: Http,
    /// What outlives a restart.
    pub state: State,
}

impl Config {
    /// Reads the file at `path` and the environment of this process.
    ///
    /// # Errors
    /// The file cannot be read, or anything [`Config::parse`] refuses.
    pub fn load(path: impl AsRef<Path>) -> Result<Self, ConfigErrors> {
        let path = path.as_ref();
        let name = path.display().to_string();
        #[expect(clippy::disallowed_methods, reason = "the one place that reads the configuration file")]
        let text = std::fs::read_to_string(path).map_err(|error| {
            ConfigErrors::from(ConfigError {
                file: name.clone(),
                place: Place::File,
                key: String::new(),
                value: None,
                message: format!(
                    "cannot be read: {error}; give the path of a configuration file (TOML, UTF-8)"
                ),
            })
        })?;
        // `env::vars` would panic on an unrelated variable that is not UTF-8.
        let env = std::env::vars_os()
            .filter_map(|(key, value)| Some((key.into_string().ok()?, value.to_string_lossy().into_owned())));
        Self::parse(&text, &name, env)
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
        let (site, own) = site::read_site(top.need_section("site", "[site] with name, sac and sic"));
        let (sensors, ids) = sensors::read(&mut top, own);
        let fusion = fusion::read(top.section("fusion"));
        let areas = site::read_areas(&mut top, &ids, Path::new(name));
        let output = output::read_output(top.section("output"));
        let http = http::read_http(top.section("http"), Path::new(name));
        let state = output::read_state(top.section("state"));
        top.finish();

        let config = (|| {
            Some(Self {
                site: site?,
                sensors: sensors?,
                fusion: fusion?,
                areas: areas?,
                output: output?,
                http: http?,
                state: state?,
            })
        })();
        faults.check()?;
        Ok(config.expect("a reader that gives nothing has said why"))
    }

    /// The radars, in the order of the file; the first is the origin of the ENU frame.
    pub fn radars(&self) -> impl Iterator<Item = (&Sensor, &Radar)> {
        self.sensors.iter().filter_map(|sensor| match &sensor.kind {
            SensorKind::Radar(radar) => Some((sensor, radar)),
            SensorKind::Transponder(_) => None,
        })
    }
}

#[cfg(test)]
mod tests;
