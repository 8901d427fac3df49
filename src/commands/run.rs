//! `run`: the live service.

use std::error::Error;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

use tokio::signal::unix::{Signal, SignalKind, signal};
use tracing::{error, info, warn};

use super::notify::Notifier;
use super::reload::{Reload, limits};
use super::{CommandResult, Outcome, load_live, open_sinks};
use crate::api::{self, ApiState};
use crate::areas::Areas;
use crate::config::Config;
use crate::current::Current;
use crate::history::{Historian, Store};
use crate::live::{Alerts, Clock, Driver, Hub, Outlets, Service, now, observe};
use crate::net::listen as udp;
use crate::record::{Recorded, Recorder};
use crate::state::{
    DecisionsKeeper, Keeper, RegistrationKeeper, Registrations, kept_lines, registration_text,
};

/// Runs the live service: listens to the sensors, sends the fused picture, serves it over HTTP.
///
/// Ctrl-C or SIGTERM ends it within 5 s, a second one at once. SIGHUP reads the file anew: tokens, certificate, limits, names
/// and CORS of the API, areas of kind alert and coverage, output.asterix and the limits of the history change at once; the log names every
/// key that needs a restart, and of an invalid file nothing is taken.
#[derive(Clone, Debug, clap::Args)]
pub struct Args {
    /// The site's configuration.
    #[arg(long, value_name = "FILE")]
    pub config: PathBuf,
    /// How the log on standard error looks; json: an object a line, with its time.
    #[arg(long, value_enum, default_value_t = LogFormat::Text, value_name = "FORMAT")]
    pub log_format: LogFormat,
}

/// How a log line looks.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum LogFormat {
    /// For people.
    Text,
    /// For machines.
    Json,
}

/// How often it is looked whether the engine still runs.
const WATCH: Duration = Duration::from_millis(500);
/// What is still to be done when the engine has stopped may take this long.
const STOP: Duration = Duration::from_secs(2);

/// Runs the command.
pub fn run(args: &Args) -> CommandResult {
    let config = Arc::new(load_live(&args.config)?);
    let areas = Areas::load(&config.areas)?;
    let runtime = tokio::runtime::Builder::new_multi_thread().worker_threads(2).enable_all().build()?;
    runtime.block_on(serve(args, config, areas))
}

async fn serve(args: &Args, config: Arc<Config>, areas: Areas) -> CommandResult {
    let mut signals = Signals::listen()?;
    // First of all: an address that is taken is told before anything is sent.
    let listen = config.http.listen;
    let listener =
        api::listen(listen).map_err(|error| format!("cannot listen on {listen} (http.listen): {error}"))?;
    let address = listener.local_addr()?;
    let started = now();
    let mut driver = Driver::new(&config, areas.masks(), started, udp::lines(&config).len());
    let mut numbers = Keeper::load(&config.state.dir, started);
    let refused = driver.remember(&mut numbers);
    if refused > 0 {
        warn!("{refused} transponder numbers of before contradict others and are given anew");
    }
    let kept = RegistrationKeeper::load(&config.state.dir, started);
    kept.restore(&config, Some(started), driver.engine_mut()).iter().for_each(|unused| warn!("{unused}"));
    let registrations = Registrations::of(&config, driver.pipeline().engine());
    if !registrations.is_empty() {
        info!("the registration of {} radars goes on", registrations.len());
    }
    let plan = DecisionsKeeper::load(&config.state.dir, started).plan(&config);
    plan.unused.iter().for_each(|unused| warn!("{unused}"));
    if !plan.kept.is_empty() {
        info!(
            "{} decisions of before hold again where their radar tracks are heard in time",
            plan.kept.len()
        );
    }
    let correlated = kept_lines(&plan.kept, &config);
    driver.engine_mut().resume(plan.kept);
    let (kept, keeper) = Keeper::start(config.state.dir.clone(), numbers.clone())?;
    let (registration, registration_keeper) = RegistrationKeeper::start(config.state.dir.clone())?;
    let (correlations, correlations_keeper) = DecisionsKeeper::start(config.state.dir.clone())?;
    let record = config.output.record.as_ref();
    let record = record.map(|record| Recorder::start(&config, record, numbers, true)).transpose()?;
    let (recorded, recorder) = record.unzip();
    if let Some(recorded) = &recorded {
        recorded.wait(Recorded::Registered { text: registration_text(&registrations).into() });
        recorded.wait(Recorded::Correlations { text: correlated.into() });
    }
    let (writer, hub) = Hub::new(config.clone(), Arc::new(driver.maker().clone()), started);
    let history = history(&config);
    let api = ApiState::start(hub.clone(), api::Options { history: history.clone(), ..Default::default() })?;
    let sinks = open_sinks(&config)?;
    let alert_areas = Current::from(areas.alerts());
    let mut reload = Reload {
        file: args.config.clone(),
        config: Config::clone(&config),
        areas,
        api: api.clone(),
        sinks: sinks.clone(),
        alerts: alert_areas.clone(),
        history: history.clone(),
    };
    let outlets = Outlets {
        hub: writer,
        sinks,
        recorder: recorded,
        numbers: Some(kept),
        registration: Some(registration),
        correlations: Some(correlations),
    };
    let handle = tokio::runtime::Handle::current();
    let service = Service::start(config.clone(), driver, outlets, Clock::default(), &handle)?;
    let alerts = Alerts::new(alert_areas, started);
    let observer = tokio::spawn(observe(hub.clone(), alerts, history.and_then(historian)));
    let http = tokio::spawn(api::serve(listener, api.clone()));
    info!("{}: running, {}://{address}/; Ctrl-C ends it", config.site.name, config.http.scheme());
    let notifier = Notifier::from_env();
    notifier.tell("READY=1");

    let ended = wait(&mut reload, &mut signals, &service, &hub, &notifier).await;
    info!("stopping");
    notifier.tell("STOPPING=1");
    // A second signal does not wait for what is owed.
    let stopped = tokio::task::spawn_blocking(move || {
        let driver = service.stop();
        // The engine is gone, and with it what fed these.
        keeper.join();
        registration_keeper.join();
        correlations_keeper.join();
        recorder.map(Recorder::join);
        driver
    });
    let driver = tokio::select! {
        driver = stopped => driver??,
        () = signals.stop() => return Err("stopped at once; what the window held was not put out".into()),
    };
    // The last slots are still on their way into the history.
    drop(tokio::time::timeout(STOP, observer).await);
    // What was owed has been published: the streams show it, and end.
    api.close();
    http.await?;
    ended?;
    let tally = driver.pipeline().tally();
    info!("stopped: {} datagrams received, {} dropped or not used", tally.received, tally.dropped());
    Ok(Outcome::Done)
}

/// The history, where one is configured: where it cannot be opened the service runs all the same.
fn history(config: &Config) -> Option<Store> {
    let state = &config.state;
    let limits = limits(state)?;
    let path = state.dir.join("history.redb");
    let store = Store::closed(&path, limits);
    if let Err(error) = store.reopen() {
        error!("no history is kept: {error}; it is tried again, and the service goes on");
    }
    Some(store)
}

fn historian(store: Store) -> Option<Historian> {
    Historian::start(store).map_err(|error| error!("no history is kept: {error}")).ok()
}

/// Until it is to end; an error where the engine has ended by itself.
async fn wait(
    reload: &mut Reload,
    signals: &mut Signals,
    service: &Service,
    hub: &Hub,
    notifier: &Notifier,
) -> Result<(), Box<dyn Error + Send + Sync>> {
    let mut watch = tokio::time::interval(WATCH);
    let mut statuses = hub.statuses();
    let Signals { interrupt, terminate, hangup } = signals;
    loop {
        tokio::select! {
            _ = interrupt.recv() => return Ok(()),
            _ = terminate.recv() => return Ok(()),
            _ = hangup.recv() => reload.again(),
            // Once a second, from the engine's own thread: where it hangs, the watchdog is not told otherwise.
            Ok(()) = statuses.changed() => notifier.tell("WATCHDOG=1"),
            _ = watch.tick() => {
                if service.has_ended() {
                    return Err("the engine's thread has ended; this is a bug".into());
                }
            }
        }
    }
}

/// What the system asks of the process.
struct Signals {
    interrupt: Signal,
    terminate: Signal,
    hangup: Signal,
}

impl Signals {
    fn listen() -> std::io::Result<Self> {
        Ok(Self {
            interrupt: signal(SignalKind::interrupt())?,
            terminate: signal(SignalKind::terminate())?,
            hangup: signal(SignalKind::hangup())?,
        })
    }

    /// Until SIGINT or SIGTERM.
    async fn stop(&mut self) {
        tokio::select! {
            _ = self.interrupt.recv() => {}
            _ = self.terminate.recv() => {}
        }
    }
}
