//! `run`: the live service.

#[cfg(feature = "cluster")]
mod cluster;

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use tokio::signal::unix::{Signal, SignalKind, signal};
use tracing::{info, warn};

use super::notify::Notifier;
use super::reload::Reload;
use super::{CommandResult, Outcome, check_mqtt, load_live, mqtt_inputs, mqtt_receivers, refusal};
use crate::app::{AppError, Live, LiveBuilder, Signals, runtime};
use service::live::now;
use service::state::StateLock;
use site::areas::Areas;
use site::config::Config;

/// Runs the live service: receives data from the sensors, sends the fused picture, and serves it over HTTP.
///
/// Ctrl-C or SIGTERM ends it within 5 s, a second one at once. SIGHUP reads the file again. These take effect at once: tokens,
/// certificate, limits, names and CORS of the API, areas of kind alert and coverage, output.asterix and the limits of the
/// history. The log names every key that needs a restart. If the file is invalid, nothing changes.
#[derive(Clone, Debug, clap::Args)]
pub struct Args {
    /// Site configuration.
    #[arg(value_name = "FILE", required_unless_present = "config")]
    pub file: Option<PathBuf>,
    /// Site configuration, as for the other commands.
    #[arg(long, value_name = "FILE", conflicts_with = "file")]
    pub config: Option<PathBuf>,
    /// Format of the log on standard error; json: one object per line, with its time.
    #[arg(long, value_enum, default_value_t = LogFormat::Text, value_name = "FORMAT")]
    pub log_format: LogFormat,
}

impl Args {
    /// Path of the configuration.
    pub fn config(&self) -> &Path {
        // Clap requires one of them.
        self.file.as_deref().or(self.config.as_deref()).unwrap_or(Path::new("site.toml"))
    }
}

/// Format of the log.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum LogFormat {
    /// For reading.
    Text,
    /// For log collectors.
    Json,
}

/// Interval at which the engine's thread is checked.
const WATCH: Duration = Duration::from_millis(500);

/// Runs the command.
pub fn run(args: &Args) -> CommandResult {
    let config = Arc::new(load_live(args.config())?);
    if config.cluster.is_some() && cfg!(not(feature = "cluster")) {
        let message = "this program was built without `cluster`; build it with --features cluster, or remove [cluster] for one \
                       machine";
        return Err(refusal(args.config(), "cluster", message.to_owned()).into());
    }
    check_mqtt(args.config(), mqtt_inputs(&config).chain(mqtt_receivers(&config)))?;
    let areas = Areas::load(&config.areas)?;
    areas.warnings(now()).iter().for_each(|warning| warn!("{warning}"));
    let runtime = runtime(2)?;
    let ended = runtime.block_on(serve(args, config, areas));
    if ended.is_err() {
        // A second signal asked to end at once, so writes to disk are not awaited.
        runtime.shutdown_background();
    }
    ended
}

async fn serve(args: &Args, config: Arc<Config>, areas: Areas) -> CommandResult {
    let (mut signals, mut hangup) = (Signals::listen()?, signal(SignalKind::hangup())?);
    #[cfg(feature = "cluster")]
    if let Some(cluster) = &config.cluster {
        return cluster::serve(args, (config.clone(), cluster), areas, (signals, hangup)).await;
    }
    let _lock = StateLock::take(&config.state.dir)?;
    let mut live = begin(&config, &areas)?.keep_state()?.record()?.keep_history().start()?;
    let zones = live.zones.take();
    let mut reload = Reload { zones, ..reload_of(args, &config, areas, &live) };
    info!(site = config.site.name, url = %live.served.url, "running; Ctrl-C ends it");
    let notifier = Notifier::from_env();
    notifier.notify("READY=1");

    let ended = wait(&mut reload, (&mut signals, &mut hangup), &live, &notifier).await;
    info!("stopping");
    notifier.notify("STOPPING=1");
    let tally = live.stop(&mut signals).await?;
    ended?;
    info!(received = tally.received, dropped = tally.dropped(), "stopped");
    Ok(Outcome::Done)
}

/// Builds a service whose API is already bound to its address.
fn begin(config: &Arc<Config>, areas: &Areas) -> Result<LiveBuilder, AppError> {
    let listen = config.http.listen;
    let listener =
        api::listen(listen).map_err(|error| format!("cannot listen on {listen} (http.listen): {error}"))?;
    Ok(LiveBuilder::new(config.clone(), areas.clone(), listener))
}

fn reload_of(args: &Args, config: &Config, areas: Areas, live: &Live) -> Reload {
    Reload {
        file: args.config().to_owned(),
        config: config.clone(),
        areas,
        api: live.served.api.clone(),
        sinks: live.sinks.clone(),
        alerts: live.alert_settings.clone(),
        history: live.history.clone(),
        zones: None,
    }
}

/// Waits for the end. Returns an error if the engine ended by itself.
async fn wait(
    reload: &mut Reload,
    (signals, hangup): (&mut Signals, &mut Signal),
    live: &Live,
    notifier: &Notifier,
) -> Result<(), AppError> {
    let mut watch = tokio::time::interval(WATCH);
    let mut statuses = live.served.hub.statuses();
    loop {
        tokio::select! {
            () = signals.stop() => return Ok(()),
            _ = hangup.recv() => reload.again(),
            request = reload.zone_request() => reload.change_zone(request),
            // The engine's thread sends a status once a second. If it hangs, the watchdog is not notified.
            Ok(()) = statuses.changed() => notifier.notify("WATCHDOG=1"),
            _ = watch.tick() => {
                if live.has_ended() {
                    return Err("the engine's thread has ended; this is a bug".into());
                }
            }
        }
    }
}
