//! The API and the map without a configured site: `replay --serve`, a recording, and `demo --http`, a simulated flight.

use std::error::Error;
use std::net::SocketAddr;
use std::sync::Arc;
use std::time::Duration;

use jiff::SignedDuration;
use tokio::net::TcpListener;
use tracing::{error, info, warn};

use super::own_ports::OwnPorts;
use super::replay::Args;
use super::simulate::{send, start};
use super::{CommandResult, Outcome, Usage};
use crate::api::{self, ApiState};
use crate::areas::{AlertAreas, Masks};
use crate::capture::TrailerRules;
use crate::config::{Auth, Config};
use crate::live::{Alerts, Clock, Driver, Hub, OpenCaptures, Outlets, Player, Service, now, observe};
use crate::net::listen::lines;
use crate::net::send::Sinks;
use crate::picture::PictureMaker;
use crate::pipeline::Pipeline;
use crate::simulate::{Scenario, Simulation, simulate};
use fusion::time::Time;

/// Serves the replay until Ctrl-C.
///
/// # Errors
/// An input cannot be opened, or the address is taken.
pub fn replay(args: &Args, config: Arc<Config>, masks: Masks, speed: f64) -> CommandResult {
    let (named, again) = (args.clone(), args.again);
    let trailers = TrailerRules::of(&config);
    let open: OpenCaptures = Arc::new(move || super::replay::open(&named, &trailers));
    let date = args.day_of(&open()?); // a wrong path is an error at once
    let plan = super::replay::kept(args)?.correlations.plan(&config);
    plan.unused.iter().for_each(|unused| warn!("{unused}"));
    let runtime = tokio::runtime::Builder::new_multi_thread().worker_threads(2).enable_all().build()?;
    runtime.block_on(async {
        let listener = listen(&config)?;
        let (scheme, address) = (config.http.scheme(), listener.local_addr()?);
        let maker = PictureMaker::new(&config, Pipeline::new(&config, masks.clone()).normaliser());
        let (writer, hub) = Hub::new(config.clone(), Arc::new(maker), now());
        let areas = AlertAreas::load(&config.areas)?;
        let (player, _) = Player::start(open, date, config, masks, writer, (speed, again), plan)?;
        let options = api::Options { player: Some(player), ..Default::default() };
        let api = ApiState::start(hub.clone(), options)?;
        // A recording has times of its own: its sensors are looked at from its start.
        tokio::spawn(observe(hub.clone(), Alerts::new(areas, Time::default()), None));
        let http = tokio::spawn(api::serve(listener, api.clone()));
        info!("{scheme}://{address}/ shows the replay; Ctrl-C ends it");
        tokio::signal::ctrl_c().await?;
        api.close();
        http.await?;
        Ok(Outcome::Done)
    })
}

/// Sends the scenario to the live service on this machine and serves what it makes of it; one flight after another, until
/// Ctrl-C, or for that long.
///
/// # Errors
/// The address is taken, or there is no multicast on the loopback interface.
pub fn demo(
    scenario: Scenario,
    seed: u64,
    http: SocketAddr,
    duration: Option<SignedDuration>,
) -> CommandResult {
    let mut first = simulate(&scenario, seed, Some(start(&scenario)))?;
    let ports =
        OwnPorts::instead_of(&first.config).map_err(|error| format!("no UDP port is free: {error}"))?;
    ports.lead(&mut first);
    let mut config = first.config.clone();
    config.http.listen = http;
    let config = Arc::new(config);
    let runtime = tokio::runtime::Builder::new_multi_thread().worker_threads(2).enable_all().build()?;
    runtime.block_on(async {
        let listener = listen(&config)?;
        let address = listener.local_addr()?;
        let driver = Driver::new(&config, Masks::default(), now(), lines(&config).len());
        let (writer, hub) = Hub::new(config.clone(), Arc::new(driver.maker().clone()), now());
        let api = ApiState::start(hub.clone(), api::Options::default())?;
        let sinks = Sinks::open(&config.output.asterix)?;
        let outlets = Outlets {
            hub: writer,
            sinks,
            recorder: None,
            numbers: None,
            registration: None,
            correlations: None,
        };
        let handle = tokio::runtime::Handle::current();
        let service = Service::start(config.clone(), driver, outlets, Clock::default(), &handle)?;
        tokio::spawn(observe(hub.clone(), Alerts::new(AlertAreas::default(), hub.started), None));
        let served = tokio::spawn(api::serve(listener, api.clone()));
        // It sleeps most of its time, and ends with the process.
        std::thread::spawn(move || fly(&scenario, seed, first, &ports));
        for sink in &config.output.asterix {
            info!("the fused picture goes to {}", sink.name());
        }
        info!("http://{address}/ shows ten drones and birds, live; Ctrl-C ends it");
        let over = async {
            match duration.map(Duration::try_from) {
                Some(Ok(duration)) => tokio::time::sleep(duration).await,
                _ => std::future::pending().await,
            }
        };
        tokio::select! {
            ended = tokio::signal::ctrl_c() => ended?,
            () = over => {}
        }
        tokio::task::spawn_blocking(move || service.stop()).await??;
        api.close();
        served.await?;
        Ok(Outcome::Done)
    })
}

/// Sends flight after flight.
fn fly(scenario: &Scenario, mut seed: u64, first: Simulation, ports: &OwnPorts) {
    let mut next = Ok(first);
    loop {
        let sent = next.map_err(Into::into).and_then(|simulation| send(&simulation));
        if let Err(error) = sent {
            return error!("the flight has ended: {error}");
        }
        seed += 1;
        next = simulate(scenario, seed, Some(start(scenario))).map(|mut simulation| {
            ports.lead(&mut simulation);
            simulation
        });
    }
}

/// Where the API listens: without tokens only on this machine.
fn listen(config: &Config) -> Result<TcpListener, Box<dyn Error + Send + Sync>> {
    let listen = config.http.listen;
    if config.http.auth == Auth::None && !config.http.is_local() {
        return Err(
            Usage(format!("{listen}: without tokens (http.auth) only a loopback address is served")).into()
        );
    }
    api::listen(listen)
        .map_err(|error| format!("cannot listen on {listen}: {error}; --http takes another address").into())
}
