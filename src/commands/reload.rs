//! SIGHUP: reads the configuration again, and applies changes that need no restart. Zones of operators: puts them in force.

use std::error::Error;
use std::path::PathBuf;

use tracing::{error, info, warn};

use api::{AccessSettings, ApiState};
use service::current::Current;
use service::history::{HistoryLimits, HistoryStore};
use service::live::{AlertSettings, OperatorZones, PendingZoneRequest, now};
use service::net::send::UdpDestinations;
use site::areas::Areas;
use site::config::{Auth, Config, changes};

/// The configuration in force, and the components to which changes apply.
pub struct Reload {
    /// Configuration file.
    pub file: PathBuf,
    /// Configuration in force: the file, except for changes that need a restart.
    pub config: Config,
    /// Areas in force.
    pub areas: Areas,
    /// State of the API's request handlers.
    pub api: ApiState,
    /// Outputs.
    pub sinks: UdpDestinations,
    /// Settings of the alerts.
    pub alerts: Current<AlertSettings>,
    /// History, if one is kept.
    pub history: Option<HistoryStore>,
    /// Zones of operators, if they are kept.
    pub zones: Option<OperatorZones>,
}

impl Reload {
    /// Reads the file again and logs the changes. If the file is invalid, nothing changes.
    pub fn again(&mut self) {
        info!("{}: read anew", self.file.display());
        match self.apply() {
            Ok(()) => info!("SIGHUP is done"),
            Err(error) => error!("SIGHUP is refused, everything stays as it was:\n{error}"),
        }
    }

    /// The next request about a zone of an operator; waits forever if there are no more.
    pub async fn zone_request(&mut self) -> PendingZoneRequest {
        let request = match &mut self.zones {
            Some(zones) => zones.next().await,
            None => None,
        };
        match request {
            Some(request) => request,
            None => std::future::pending().await,
        }
    }

    /// Carries out a request about a zone of an operator. The zone is in force before the request is answered.
    pub fn change_zone(&mut self, request: PendingZoneRequest) {
        let Self { zones: Some(zones), areas, alerts, .. } = self else { return };
        zones.carry_out(request, now(), |zones| {
            alerts.replace(alerts.get().with_areas(areas.alerts_with(zones.areas())));
        });
    }

    fn apply(&mut self) -> Result<(), Box<dyn Error + Send + Sync>> {
        let wanted = Config::load(&self.file)?;
        let read = Areas::load(&wanted.areas)?;
        // The masks of the engine never change, because a recording is replayed with one set of masks.
        let areas = read.with_masks_of(&self.areas);
        let mut config = self.config.clone();
        config.reload(&wanted);
        config.areas = areas.configured().cloned().collect();
        // A listener either uses TLS or does not; only its certificate can change.
        if wanted.http.tls.is_some() != self.config.http.tls.is_some() {
            config.http.tls.clone_from(&self.config.http.tls);
        }
        // The address stays and other machines can reach it, so authentication is never disabled.
        if wanted.http.auth == Auth::None && !config.http.is_local() {
            config.http.auth.clone_from(&self.config.http.auth);
        }
        let access = AccessSettings::load(&config, &areas)?;
        let active = self.zones.iter().flat_map(OperatorZones::areas);
        let alerts = AlertSettings::new(&config.alerts, &areas)?.with_areas(areas.alerts_with(active));

        // From here on no change is refused.
        let warnings = access.warnings(now()).into_iter().chain(areas.warnings(now()));
        warnings.for_each(|warning| warn!("{warning}"));
        if let Some(tokens) = access.tokens() {
            info!("{tokens} tokens are accepted");
        }
        self.api.set_access(access);
        self.alerts.replace(alerts);
        let sinks = self.sinks.reopen(&wanted.output.asterix);
        if let Err(error) = &sinks {
            error!("output.asterix stays as it was: {error}; correct it and send SIGHUP again");
            config.output.asterix.clone_from(&self.config.output.asterix);
        }
        match (&self.history, HistoryLimits::of(&wanted.state)) {
            (Some(history), Some(limits)) => history.limit(limits),
            // Enabling or disabling the history needs a restart.
            _ => config.state.clone_from(&self.config.state),
        }

        // Changes are logged by comparison, so that every key is covered. Areas are compared as they were read.
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
