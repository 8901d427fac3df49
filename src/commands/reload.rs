//! SIGHUP: the configuration is read anew, and what can change while the service runs does.

use std::error::Error;
use std::path::PathBuf;

use tracing::{error, info, warn};

use crate::api::{ApiState, Terms};
use crate::areas::Areas;
use crate::config::{Auth, Config, changes};
use crate::current::Current;
use crate::history::{Limits, Store};
use crate::live::{AlertSettings, now};
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
    /// What alerts are raised by.
    pub alerts: Current<AlertSettings>,
    /// The history, where one is kept.
    pub history: Option<Store>,
}

impl Reload {
    /// Reads the file and tells what came of it. Where anything in it is wrong, nothing changes.
    pub fn again(&mut self) {
        info!("{}: read anew", self.file.display());
        match self.apply() {
            Ok(()) => info!("SIGHUP is done"),
            Err(error) => error!("SIGHUP is refused, everything stays as it was:\n{error}"),
        }
    }

    fn apply(&mut self) -> Result<(), Box<dyn Error + Send + Sync>> {
        let wanted = Config::load(&self.file)?;
        let read = Areas::load(&wanted.areas)?;
        // The engine has its masks for good: a recording replays with one set of them.
        let areas = read.with_masks_of(&self.areas);
        let mut config = self.config.clone();
        config.reload(&wanted);
        config.areas = areas.configured().cloned().collect();
        // A listener speaks TLS or does not: only which certificate it shows can change.
        if wanted.http.tls.is_some() != self.config.http.tls.is_some() {
            config.http.tls.clone_from(&self.config.http.tls);
        }
        // The address stays, and others may reach it: then it is never opened to everybody.
        if wanted.http.auth == Auth::None && !config.http.is_local() {
            config.http.auth.clone_from(&self.config.http.auth);
        }
        let terms = Terms::load(&config, &areas)?;
        let alerts = AlertSettings::new(&config.alerts, &areas)?;

        // From here on nothing is refused.
        let warnings = terms.warnings(now()).into_iter().chain(areas.warnings(now()));
        warnings.for_each(|warning| warn!("{warning}"));
        if let Some(tokens) = terms.tokens() {
            info!("{tokens} tokens are accepted");
        }
        self.api.set_terms(terms);
        self.alerts.replace(alerts);
        let sinks = self.sinks.reopen(&wanted.output.asterix);
        if let Err(error) = &sinks {
            error!("output.asterix stays as it was: {error}; correct it and send SIGHUP again");
            config.output.asterix.clone_from(&self.config.output.asterix);
        }
        match (&self.history, Limits::of(&wanted.state)) {
            (Some(history), Some(limits)) => history.limit(limits),
            // A history is begun or ended by a restart only.
            _ => config.state.clone_from(&self.config.state),
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
