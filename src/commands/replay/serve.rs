//! `replay --serve`: a recording on the map.

use std::sync::Arc;

use tracing::info;

use super::args::Args;
use crate::api;
use crate::app::{Served, Signals, listen_locally, runtime};
use crate::areas::{Areas, Masks};
use crate::capture::{Receivers, TrailerRules};
use crate::commands::{CommandResult, Outcome, needs_tokens};
use crate::config::Config;
use crate::integrity::Lookout;
use crate::live::{AlertSettings, Alerts, Followers, Hub, OpenCaptures, Player, now};
use crate::picture::PictureMaker;
use crate::pipeline::Pipeline;
use fusion::time::Time;

/// Serves the replay until Ctrl-C.
///
/// # Errors
/// An input cannot be opened, or the address is taken.
pub fn serve(args: &Args, config: Arc<Config>, masks: Masks, speed: f64) -> CommandResult {
    let (named, again) = (args.clone(), args.again);
    let (trailers, receivers) = (TrailerRules::of(&config), Receivers::of(&config));
    let open: OpenCaptures = Arc::new(move || named.open(&trailers, &receivers));
    let date = args.day_of(&open()?); // a wrong path is an error at once
    let plan = args.saved_state()?.correlations.plan(&config);
    runtime(2)?.block_on(async {
        let mut signals = Signals::listen()?;
        let listener = listen_locally(&config)?.ok_or_else(|| needs_tokens(&config))?;
        let maker = PictureMaker::new(&config, Pipeline::new(&config, masks.clone()).normaliser());
        let (writer, hub) = Hub::new(config.clone(), Arc::new(maker), now());
        let settings = AlertSettings::new(&config.alerts, &Areas::load(&config.areas)?)?;
        // A recording has times of its own: its sensors are looked at from its start.
        let mut alerts = Alerts::new(settings, Time::default());
        alerts.plan(plan.alerts.clone());
        let lookout = Lookout::load(&config, masks.clone())?;
        let (player, _) = Player::start(open, date, config, (masks, lookout), writer, (speed, again), plan)?;
        let options = api::Options { player: Some(player), ..Default::default() };
        let served = Served::start(listener, hub, options, alerts, Followers::default())?;
        info!(url = %served.url, "the replay is shown; Ctrl-C ends it");
        signals.stop().await;
        served.close().await?;
        Ok(Outcome::Done)
    })
}
