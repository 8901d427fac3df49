//! `run`: the live service.

use std::error::Error;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

use jiff::SignedDuration;
use tokio::signal::unix::{Signal, SignalKind, signal};
use tracing::{error, info, warn};

use super::{CommandResult, Outcome};
use crate::areas::{AlertAreas, Masks};
use crate::config::Config;
use crate::ingest::udp;
use crate::live::{Alerts, Driver, Hub, Outlets, Service, now, observe};
use crate::publish::Sinks;
use crate::store::{Historian, Limits, Store};

/// Runs the live service: listens to the sensors, sends the fused picture, serves it over HTTP.
///
/// Ctrl-C or SIGTERM ends it within 5 s, a second one at once; SIGHUP reads the configuration again.
#[derive(Clone, Debug, clap::Args)]
pub struct Args {
    /// The site's configuration.
    #[arg(long, value_name = "FILE")]
    pub config: PathBuf,
}

/// How often it is looked whether the engine still runs.
const WATCH: Duration = Duration::from_millis(500);
/// What is still to be done when the engine has stopped may take this long.
const STOP: Duration = Duration::from_secs(2);

/// Runs the command.
pub fn run(args: &Args) -> CommandResult {
    let config = Arc::new(Config::load(&args.config)?);
    let masks = Masks::load(&config.areas)?;
    let runtime = tokio::runtime::Builder::new_multi_thread().worker_threads(2).enable_all().build()?;
    runtime.block_on(serve(args, config, masks))
}

async fn serve(args: &Args, config: Arc<Config>, masks: Masks) -> CommandResult {
    let mut signals = Signals::listen()?;
    let started = now();
    let driver = Driver::new(&config, masks, started, udp::lines(&config).len());
    let (writer, hub) = Hub::new(config.clone(), Arc::new(driver.maker().clone()), started);
    let outlets = Outlets { hub: writer, sinks: Sinks::open(&config.output.asterix)?, recorder: None };
    let service = Service::start(config.clone(), driver, outlets, &tokio::runtime::Handle::current())?;
    let alerts = Alerts::new(AlertAreas::load(&config.areas)?, started);
    let observer = tokio::spawn(observe(hub, alerts, historian(&config)));
    info!("{}: running; Ctrl-C ends it", config.site.name);

    let ended = wait(args, &mut signals, &service).await;
    info!("stopping");
    // A second signal does not wait for what is owed.
    let stopped = tokio::task::spawn_blocking(move || service.stop());
    let driver = tokio::select! {
        driver = stopped => driver??,
        () = signals.stop() => return Err("stopped at once; what the window held was not put out".into()),
    };
    // The last slots are still on their way into the history.
    drop(tokio::time::timeout(STOP, observer).await);
    ended?;
    let tally = driver.pipeline().tally();
    info!("stopped: {} datagrams received, {} dropped or not used", tally.received, tally.dropped());
    Ok(Outcome::Done)
}

/// The history, where one is configured and can be opened: without it the service runs all the same.
fn historian(config: &Config) -> Option<Historian> {
    let state = &config.state;
    if state.history_hours <= 0.0 {
        return None;
    }
    let limits = Limits {
        age: SignedDuration::from_secs((state.history_hours * 3600.0) as i64),
        octets: u64::from(state.history_mib) << 20,
    };
    let path = state.dir.join("history.redb");
    let opened = std::fs::create_dir_all(&state.dir)
        .map_err(|error| format!("{}: {error}", state.dir.display()))
        .and_then(|()| Store::open(&path, limits).map_err(|error| error.to_string()))
        .and_then(|store| Historian::start(store).map_err(|error| error.to_string()));
    opened.map_err(|error| error!("no history is kept: {error}")).ok()
}

/// Until it is to end; an error where the engine has ended by itself.
async fn wait(
    args: &Args,
    signals: &mut Signals,
    service: &Service,
) -> Result<(), Box<dyn Error + Send + Sync>> {
    let mut watch = tokio::time::interval(WATCH);
    let Signals { interrupt, terminate, reload: hangup } = signals;
    loop {
        tokio::select! {
            _ = interrupt.recv() => return Ok(()),
            _ = terminate.recv() => return Ok(()),
            _ = hangup.recv() => reload(args),
            _ = watch.tick() => {
                if service.has_ended() {
                    return Err("the engine's thread has ended; this is a bug".into());
                }
            }
        }
    }
}

/// SIGHUP: what cannot change while it runs is told.
fn reload(args: &Args) {
    match Config::load(&args.config) {
        Ok(_) => warn!("{}: is valid; it takes effect with a restart", args.config.display()),
        Err(errors) => error!("the configuration stays as it was:\n{errors}"),
    }
}

/// What the system asks of the process.
struct Signals {
    interrupt: Signal,
    terminate: Signal,
    reload: Signal,
}

impl Signals {
    fn listen() -> std::io::Result<Self> {
        Ok(Self {
            interrupt: signal(SignalKind::interrupt())?,
            terminate: signal(SignalKind::terminate())?,
            reload: signal(SignalKind::hangup())?,
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
