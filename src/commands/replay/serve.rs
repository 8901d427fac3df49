//! `replay --serve`: shows a recording on the map.

use std::sync::Arc;

use tracing::info;

use super::args::Args;
use crate::app::{Served, Signals, listen_locally, runtime};
use crate::commands::{CommandResult, Outcome, needs_tokens};
use fusion::time::Time;
use input::capture::{SiteReceivers, TrailerRules};
use input::pipeline::Pipeline;
use picture::PictureMaker;
use picture::UncooperativeDetector;
use service::live::{AlertMonitor, AlertSettings, Followers, Hub, OpenCaptures, Player, now};
use site::areas::{Areas, Masks};
use site::config::Config;

/// Serves the replay until Ctrl-C.
///
/// # Errors
/// An input cannot be opened, or the address is in use.
pub fn serve(args: &Args, config: Arc<Config>, masks: Masks, speed: f64) -> CommandResult {
    let (named, again) = (args.clone(), args.again);
    let (trailers, receivers) = (TrailerRules::of(&config), SiteReceivers::of(&config));
    let open: OpenCaptures = Arc::new(move || named.open(&trailers, &receivers));
    let date = args.day_of(&open()?); // reports a wrong path at once
    let plan = args.saved_state()?.correlations.plan(&config);
    runtime(2)?.block_on(async {
        let mut signals = Signals::listen()?;
        let listener = listen_locally(&config)?.ok_or_else(|| needs_tokens(&config))?;
        let maker = PictureMaker::new(&config, Pipeline::new(&config, masks.clone()).normaliser());
        let (writer, hub) = Hub::new(config.clone(), Arc::new(maker), now());
        let settings = AlertSettings::new(&config.alerts, &Areas::load(&config.areas)?)?;
        // The sensors of a recording are monitored from its start, in times of the recording.
        let mut alerts = AlertMonitor::new(settings, Time::default());
        alerts.plan(plan.alerts.clone());
        let detector = UncooperativeDetector::load(&config, masks.clone())?;
        let (player, _) = Player::start(open, date, config, (masks, detector), writer, (speed, again), plan)?;
        let options = api::Options { player: Some(player), ..Default::default() };
        let served = Served::start(listener, hub, options, alerts, Followers::default())?;
        info!(url = %served.url, "the replay is shown; Ctrl-C ends it");
        signals.stop().await;
        served.close().await?;
        Ok(Outcome::Done)
    })
}
