//! `run` in a cluster.

use std::sync::Arc;

use tokio::signal::unix::Signal;
use tracing::info;

use super::{Args, WATCH, begin, reload_of};
use crate::app::{AppError, Live, Parts, Signals};
use crate::commands::notify::Notifier;
use crate::commands::reload::Reload;
use crate::commands::{CommandResult, Outcome};
use service::state::StateLock;
use site::areas::Areas;
use site::config::{Cluster, Config, Role};

/// Runs the roles of this process until it is stopped.
pub(super) async fn serve(
    args: &Args,
    (config, cluster): (Arc<Config>, &Cluster),
    areas: Areas,
    (mut signals, mut hangup): (Signals, Signal),
) -> CommandResult {
    // A gateway keeps no state.
    let keeps_state = [Role::Node, Role::Picture].into_iter().any(|role| cluster.does(role));
    let _lock = if keeps_state { StateLock::take(&config.state.dir)? } else { None };
    // An address in use is reported before anything is written to the log.
    let builder = if cluster.does(Role::Picture) { Some(begin(&config, &areas)?) } else { None };
    let Some(mut parts) = Parts::join(&config, cluster, &areas, &mut signals).await? else {
        return Ok(Outcome::Done);
    };
    let live = match builder.zip(parts.seen.take()) {
        Some((builder, seen)) => Some(builder.view(seen)?.keep_history().start()?),
        None => None,
    };
    let mut reload = live.as_ref().map(|live| reload_of(args, &config, areas, live));
    let url = live.as_ref().map(|live| live.served.url.clone());
    let roles = cluster.roles.iter().map(Role::name).collect::<Vec<_>>().join(", ");
    info!(site = config.site.name, node = cluster.node, roles, url, "running; Ctrl-C ends it");
    let notifier = Notifier::from_env();
    notifier.notify("READY=1");
    let ended = wait(&mut reload, (&mut signals, &mut hangup), live.as_ref(), &parts, &notifier).await;
    info!("stopping");
    notifier.notify("STOPPING=1");
    parts.leave().await;
    if let Some(live) = live {
        live.stop(&mut signals).await?;
    }
    ended?;
    info!("stopped");
    Ok(Outcome::Done)
}

/// Waits for the end. Returns an error if a part ended by itself.
async fn wait(
    reload: &mut Option<Reload>,
    (signals, hangup): (&mut Signals, &mut Signal),
    live: Option<&Live>,
    parts: &Parts,
    notifier: &Notifier,
) -> Result<(), AppError> {
    let mut watch = tokio::time::interval(WATCH);
    loop {
        tokio::select! {
            () = signals.stop() => return Ok(()),
            _ = hangup.recv() => reload.iter_mut().for_each(Reload::again),
            _ = watch.tick() => {
                if live.is_some_and(Live::has_ended) || parts.has_ended() {
                    return Err("a thread of the service has ended; this is a bug".into());
                }
                notifier.notify("WATCHDOG=1");
            }
        }
    }
}
