//! SIGHUP: the configuration is read anew, and what can change while the service runs does.

use std::error::Error;
use std::path::PathBuf;

use tracing::{error, info, warn};

use crate::api::{ApiState, Terms};
use crate::areas::{AlertAreas, Areas};
use crate::config::{Auth, Config, changes};
use crate::current::Current;
use crate::history::{Limits, Store};
use crate::live::now;
use crate::net::send::Sinks;

/// What is in force, and who has to know of a change.
pub struct Reload {
    /// The file that is read anew.
    pub file: PathBuf,
    /// What is in force: what the file says, but for what needs a restart.
    pub config: Config,
    /// Its areas.
    pub areas: Areas,
    /// Who answers requests.
    pub api: ApiState,
    /// Where the output goes.
    pub sinks: Sinks,
    /// Where a track raises an alert.
    pub alerts: Current<AlertAreas>,
    /// The history, where one is kept.
    pub history: Option<Store>,
}

impl Reload {
    /// Reads the file and tells what came of it. Where anything in it is wrong, nothing changes.
    pub fn again(&mut self) {
        info!("{}: read anew", self.file.display());
        if let Err(error) = self.apply() {
            error!("everything stays as it was:\n{error}");
        }
        info!("SIGHUP is done");
    }

    fn apply(&mut self) -> Result<(), Box<dyn Error + Send + Sync>> {
        let wanted = Config::load(&self.file)?;
        let read = Areas::load(&wanted.areas)?;
        // The engine has its masks for good: a recording replays with one set of them.
        let areas = read.with_masks_of(&self.areas);
        let mut config = self.config.clone();
        config.areas = areas.configured().cloned().collect();
        config.http.cors.clone_from(&wanted.http.cors);
        config.http.limit = wanted.http.limit;
        config.http.connections_per_address = wanted.http.connections_per_address;
        config.http.hosts.clone_from(&wanted.http.hosts);
        config.http.trusted_proxies.clone_from(&wanted.http.trusted_proxies);
        // A listener speaks TLS or does not: only which certificate it shows can change.
        if wanted.http.tls.is_some() == config.http.tls.is_some() {
            config.http.tls.clone_from(&wanted.http.tls);
        }
        // The address stays, and others may reach it: then it is never opened to everybody.
        if wanted.http.auth != Auth::None || config.http.is_local() {
            config.http.auth = wanted.http.auth.clone();
        }
        let terms = Terms::load(&config, &areas)?;

        // From here on nothing is refused.
        terms.warnings(now()).iter().for_each(|warning| warn!("{warning}"));
        if let Some(tokens) = terms.tokens() {
            info!("{tokens} tokens are accepted");
        }
        self.api.set_terms(terms);
        self.alerts.replace(areas.alerts());
        let sinks = self.sinks.reopen(&wanted.output.asterix);
        match &sinks {
            Ok(()) => config.output.asterix.clone_from(&wanted.output.asterix),
            Err(error) => {
                error!("output.asterix stays as it was: {error}; put it right and send SIGHUP again");
            }
        }
        if let (Some(history), Some(limits)) = (&self.history, Limits::of(&wanted.state)) {
            history.limit(limits);
            config.state.history_hours = wanted.state.history_hours;
            config.state.history_mib = wanted.state.history_mib;
        }

        // What was done is told by comparing, so that no key can be forgotten. Areas are compared as they were read.
        for change in changes(&self.config, &config).iter().filter(|change| change.key != "areas") {
            info!("in force now: {change}");
        }
        if areas != self.areas {
            info!("in force now: areas of kind alert and coverage");
        }
        let told = |key: &str| key == "areas" || (key == "output.asterix" && sinks.is_err());
        for change in changes(&config, &wanted).iter().filter(|change| !told(&change.key)) {
            warn!("needs a restart: {change}");
        }
        if read.masks() != self.areas.masks() {
            warn!("needs a restart: areas of kind mask");
        }
        (self.config, self.areas) = (config, areas);
        Ok(())
    }
}
