//! `replay --serve`: a recording with the API and the map of the live service.

use std::path::PathBuf;
use std::sync::Arc;

use jiff::civil::Date;
use tracing::info;

use super::{CommandResult, Outcome};
use crate::api::{self, ApiState};
use crate::areas::{AlertAreas, Masks};
use crate::config::{Auth, Config};
use crate::ingest::Capture;
use crate::live::{Alerts, Hub, OpenCaptures, Player, now, observe};
use crate::picture::PictureMaker;
use crate::pipeline::Pipeline;

/// Serves the replay until Ctrl-C.
///
/// # Errors
/// An input cannot be opened, or the address is taken.
pub fn replay(
    inputs: Vec<PathBuf>,
    date: Date,
    config: Arc<Config>,
    masks: Masks,
    speed: f64,
) -> CommandResult {
    let open: OpenCaptures = Box::new(move || inputs.iter().map(|path| Capture::open(path)).collect());
    open()?; // a wrong path is told at once
    let runtime = tokio::runtime::Builder::new_multi_thread().worker_threads(2).enable_all().build()?;
    runtime.block_on(async {
        let listen = config.http.listen;
        if config.http.auth == Auth::None && !listen.ip().is_loopback() {
            return Err(
                format!("{listen}: without tokens (http.auth) only a loopback address is served").into()
            );
        }
        let listener = tokio::net::TcpListener::bind(listen)
            .await
            .map_err(|error| format!("cannot listen on {listen}: {error}; --http takes another address"))?;
        let address = listener.local_addr()?;
        let maker = PictureMaker::new(&config, Pipeline::new(&config, masks.clone()).normaliser());
        let (writer, hub) = Hub::new(config.clone(), Arc::new(maker), now());
        let areas = AlertAreas::load(&config.areas)?;
        let (player, _) = Player::start(open, date, config, masks, writer, speed)?;
        let options = api::Options { player: Some(player), ..Default::default() };
        let api = ApiState::start(hub.clone(), options)?;
        let alerts = Alerts::new(areas, hub.started);
        tokio::spawn(observe(hub, alerts, None));
        let http = tokio::spawn(api::serve(listener, api.clone()));
        info!("http://{address}/ shows the replay; Ctrl-C ends it");
        tokio::signal::ctrl_c().await?;
        api.close();
        http.await?;
        Ok(Outcome::Done)
    })
}
