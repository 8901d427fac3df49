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
use super::{CommandResult, Outcome, load_live};
use crate::api;
use crate::app::{Failure, Live, LiveBuilder, Signals, runtime};
use crate::areas::Areas;
use crate::config::{Config, ConfigError, ConfigErrors, Place};
use crate::live::now;
use crate::state::StateLock;

/// Runs the live service: listens to the sensors, sends the fused picture, serves it over HTTP.
///
/// Ctrl-C or SIGTERM ends it within 5 s, a second one at once. SIGHUP reads the file anew: tokens, certificate, limits, names
/// and CORS of the API, areas of kind alert and coverage, output.asterix and the limits of the history change at once; the log names every
/// key that needs a restart, and of an invalid file nothing is taken.
#[derive(Clone, Debug, clap::Args)]
pub struct Args {
    /// The site's configuration.
    #[arg(value_name = "FILE", required_unless_present = "config")]
    pub file: Option<PathBuf>,
    /// The site's configuration, named as for all other commands.
    #[arg(long, value_name = "FILE", conflicts_with = "file")]
    pub config: Option<PathBuf>,
    /// How the log on standard error looks; json: an object per line, with its time.
    #[arg(long, value_enum, default_value_t = LogFormat::Text, value_name = "FORMAT")]
    pub log_format: LogFormat,
}

impl Args {
    /// The file of the configuration.
    pub fn config(&self) -> &Path {
        // One of them is required.
        self.file.as_deref().or(self.config.as_deref()).unwrap_or(Path::new("site.toml"))
    }
}

/// How a log line looks.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum LogFormat {
    /// For people.
    Text,
    /// For machines.
    Json,
}

/// Time between two looks at whether the engine still runs.
const WATCH: Duration = Duration::from_millis(500);

/// Runs the command.
pub fn run(args: &Args) -> CommandResult {
    let config = Arc::new(load_live(args.config())?);
    if config.cluster.is_some() && cfg!(not(feature = "cluster")) {
        return Err(ConfigErrors::from(ConfigError {
            file: args.config().display().to_string(),
            place: Place::File,
            key: "cluster".to_owned(),
            value: None,
            message: "this program was built without `cluster`; build it with --features cluster, or remove [cluster] for one \
                      machine"
                .to_owned(),
        })
        .into());
    }
    let areas = Areas::load(&config.areas)?;
    areas.warnings(now()).iter().for_each(|warning| warn!("{warning}"));
    let runtime = runtime(2)?;
    let ended = runtime.block_on(serve(args, config, areas));
    if ended.is_err() {
        // Who was told to end at once waits for no disk.
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
    let live = begin(&config, &areas)?.keep_state()?.record()?.keep_history().start()?;
    let mut reload = reload_of(args, &config, areas, &live);
    info!(site = config.site.name, url = %live.served.url, "running; Ctrl-C ends it");
    let notifier = Notifier::from_env();
    notifier.tell("READY=1");

    let ended = wait(&mut reload, (&mut signals, &mut hangup), &live, &notifier).await;
    info!("stopping");
    notifier.tell("STOPPING=1");
    let tally = live.stop(&mut signals).await?;
    ended?;
    info!(received = tally.received, dropped = tally.dropped(), "stopped");
    Ok(Outcome::Done)
}

/// A service whose API listens.
fn begin(config: &Arc<Config>, areas: &Areas) -> Result<LiveBuilder, Failure> {
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
    }
}

/// Waits for the end; an error where the engine has ended by itself.
async fn wait(
    reload: &mut Reload,
    (signals, hangup): (&mut Signals, &mut Signal),
    live: &Live,
    notifier: &Notifier,
) -> Result<(), Failure> {
    let mut watch = tokio::time::interval(WATCH);
    let mut statuses = live.served.hub.statuses();
    loop {
        tokio::select! {
            () = signals.stop() => return Ok(()),
            _ = hangup.recv() => reload.again(),
            // Once a second, from the engine's own thread: where it hangs, the watchdog is not told otherwise.
            Ok(()) = statuses.changed() => notifier.tell("WATCHDOG=1"),
            _ = watch.tick() => {
                if live.has_ended() {
                    return Err("the engine's thread has ended; this is a bug".into());
                }
            }
        }
    }
}
