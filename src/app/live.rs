//! The live service: driver, outputs, API, history and recorder, assembled and stopped in order.

use std::collections::BTreeMap;
use std::io;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, SyncSender};

use futures_util::future::join;
use tokio::net::TcpListener;
use tokio::sync::mpsc::Sender;
use tracing::{error, info, warn};

use super::{AppError, Served, Signals, open_sinks};
use api::pmtiles::Basemap;
use fusion::integrity::ActiveOverride;
use fusion::numbering::Given;
use fusion::operational::{ActiveRelocation, RadarRelocation, SavedAssociation};
use fusion::time::Time;
use input::pipeline::Tally;
use picture::UncooperativeDetector;
use picture::formats::Encoders;
use service::current::Current;
use service::history::{Historian, HistoryLimits, HistoryStore};
use service::live::{
    AlertMonitor, AlertSettings, Archive, Driver, Followers, Hub, KeeperQueues, LiveService,
    OperatorDecision, OperatorZones, Outlets, Viewer, ViewerInput, WallClock, now,
};
use service::net::listen::lines;
use service::net::send::UdpDestinations;
use service::notices::{Deliveries, NoticeReceivers};
use service::record::{RecordedContents, Recorder, RecorderQueue, RecordingItem};
use service::sinks::PictureSinks;
use service::state::{
    AlertDecision, CorrelationPlan, SavedRegistrations, StateFile, StateHealth, StateKeeper, WarmKeeper,
    WarmState, ZoneStore, alert_line, kept_lines, read_correlations, read_numbers, read_registration,
    registration_text, relocation_lines,
};
use site::areas::Areas;
use site::config::Config;

/// Builder of a live service. By default nothing is kept or recorded.
pub struct LiveBuilder {
    config: Arc<Config>,
    areas: Areas,
    listener: TcpListener,
    started: Time,
    driver: Driver,
    /// Transponder numbers restored from the state directory.
    numbers: Vec<Given>,
    /// Further restored state, written to the start of a recording.
    before: Vec<RecordingItem>,
    /// Alerts that are shelved.
    shelved: Vec<AlertDecision>,
    encoders: Encoders,
    keepers: Option<KeeperQueues>,
    kept_by: Option<(Vec<StateKeeper>, Option<WarmKeeper>)>,
    /// Source of pictures from other nodes, and destination of operator decisions.
    seen: Option<(Receiver<ViewerInput>, Sender<OperatorDecision>)>,
    shelves: Option<SyncSender<Arc<str>>>,
    recorder: Option<(RecorderQueue, Recorder)>,
    history: Option<HistoryStore>,
    /// Zones that operators have activated, if they are kept.
    zones: Option<ZoneStore>,
    /// Health of the state files.
    health: StateHealth,
    /// Base map of a site whose configuration names none.
    basemap: Option<Arc<Basemap>>,
}

/// State kept across a restart: transponder numbers, correlations, and operator decisions on transponders.
type LiveRemains = (Vec<Given>, Vec<SavedAssociation>, Vec<ActiveOverride>, Vec<ActiveRelocation>);

/// The running service.
pub struct Live {
    /// API and observer.
    pub served: Served,
    /// Outputs.
    pub sinks: UdpDestinations,
    /// Settings of the alerts, reloadable.
    pub alert_settings: Current<AlertSettings>,
    /// History, if one is kept.
    pub history: Option<HistoryStore>,
    /// Zones of operators, if they are kept; for the owner of the areas.
    pub zones: Option<OperatorZones>,
    source: PictureThread,
    keepers: Vec<StateKeeper>,
    warm: Option<WarmKeeper>,
    recorder: Option<Recorder>,
    /// Deliveries of alerts, and of the picture.
    deliveries: [Deliveries; 2],
}

/// Source of the picture: an own engine, or other nodes.
enum PictureThread {
    Engine(LiveService),
    Viewer(Viewer),
}

impl PictureThread {
    fn has_ended(&self) -> bool {
        match self {
            Self::Engine(service) => service.has_ended(),
            Self::Viewer(viewer) => viewer.has_ended(),
        }
    }

    fn stop(self) -> Result<Tally, String> {
        match self {
            Self::Engine(service) => service.stop().map(|driver| driver.pipeline().tally().clone()),
            Self::Viewer(viewer) => viewer.stop(),
        }
    }
}

impl LiveBuilder {
    /// Starts from a listener that is already bound, so that an address in use is reported before anything is sent.
    pub fn new(config: Arc<Config>, areas: Areas, listener: TcpListener) -> Self {
        let started = now();
        Self {
            driver: Driver::new(&config, areas.masks(), started, lines(&config).len())
                .with_detector(UncooperativeDetector::new(&config, &areas)),
            encoders: Encoders::new(&config),
            config,
            areas,
            listener,
            started,
            numbers: Vec::new(),
            before: Vec::new(),
            shelved: Vec::new(),
            keepers: None,
            kept_by: None,
            seen: None,
            shelves: None,
            recorder: None,
            history: None,
            zones: None,
            health: StateHealth::default(),
            basemap: None,
        }
    }

    /// Gives the map page a base map, unless the configuration names one.
    pub fn with_basemap(mut self, basemap: Basemap) -> Self {
        self.basemap = Some(Arc::new(basemap));
        self
    }

    /// Shows pictures of other nodes, without an engine. Operator decisions are forwarded to those nodes. Only shelved alerts are
    /// kept in the state directory.
    ///
    /// # Errors
    /// No thread could be started.
    pub fn view(
        mut self,
        (seen, decided): (Receiver<ViewerInput>, Sender<OperatorDecision>),
    ) -> io::Result<Self> {
        let (directory, health) = (&self.config.state.dir, &self.health);
        let shelved = StateFile::SHELVED.load(directory, self.started, health, read_correlations);
        self.shelved = shelved.plan(&self.config).alerts;
        let (shelves, keeper) = StateFile::SHELVED.keep(directory, Arc::<str>::from(""), health)?;
        self.kept_by = Some((vec![keeper], None));
        (self.seen, self.shelves) = (Some((seen, decided)), Some(shelves));
        Ok(self)
    }

    /// Restores the state directory, and keeps it up to date.
    ///
    /// # Errors
    /// No thread could be started.
    pub fn keep_state(mut self) -> io::Result<Self> {
        // True even for a damaged file, which is set aside while it is read.
        let was_here = WarmState::is_there(&self.config.state.dir);
        let is_warm = self.resume();
        let (numbers, kept, words, relocations) = if is_warm { self.known() } else { self.recalled() };
        let Self { config, driver, started, health, .. } = &mut self;
        let (directory, now) = (&config.state.dir, *started);
        if !is_warm && (was_here || !numbers.is_empty() || !health.all().is_empty()) {
            // An earlier service may have published slots ahead when it was stopped; which ones is unknown.
            driver.publish_after(now);
            info!("an earlier service was here: slots of before this start are not published");
        }
        let registrations = SavedRegistrations::of(config, driver.pipeline().engine());
        if !registrations.is_empty() {
            info!(radars = registrations.len(), "registration goes on");
        }
        let shelved = StateFile::SHELVED.load(directory, now, health, read_correlations).plan(config).alerts;
        if !shelved.is_empty() {
            info!(alerts = shelved.len(), "alerts stay shelved");
        }
        let zones = ZoneStore::load(directory, health, now);
        let active = zones.zones().count();
        if active > 0 {
            info!(zones = active, "zones of operators stay active");
        }
        let shelves: String = shelved.iter().map(alert_line).collect();
        let decisions =
            (kept_lines(&kept, &words, config) + &relocation_lines(&relocations, config) + &shelves).into();

        let by_number: BTreeMap<_, _> = numbers.iter().map(|&given| (given.number, given)).collect();
        let nothing = Arc::<str>::from("");
        let (of_numbers, numbers_keeper) = StateFile::NUMBERS.keep(directory, by_number, health)?;
        let (registration, registration_keeper) =
            StateFile::REGISTRATION.keep(directory, nothing.clone(), health)?;
        let (of_decisions, decisions_keeper) =
            StateFile::DECISIONS.keep(directory, nothing.clone(), health)?;
        let (of_shelved, shelved_keeper) = StateFile::SHELVED.keep(directory, nothing, health)?;
        let warm =
            (config.state.checkpoint_s > 0.0).then(|| WarmKeeper::start(directory, health)).transpose()?;
        let (of_engine, warm) = warm.unzip();
        let queues = KeeperQueues {
            numbers: of_numbers,
            registration,
            decisions: of_decisions,
            shelved: of_shelved,
            warm: of_engine,
        };
        let keepers = vec![numbers_keeper, registration_keeper, decisions_keeper, shelved_keeper];
        self.keepers = Some(queues);
        self.kept_by = Some((keepers, warm));
        self.shelved = shelved;
        self.zones = Some(zones);
        self.numbers = numbers;
        self.before = vec![
            RecordingItem::Registered(registration_text(&registrations).into()),
            RecordingItem::Correlations(decisions),
        ];
        self.before.extend(self.driver.published().map(RecordingItem::Published));
        if is_warm {
            // The recording starts at the state of the engine.
            self.before.push(RecordingItem::Checkpoint(self.driver.checkpoint(&self.config)));
        }
        Ok(self)
    }

    /// Continues from the state of a service that stopped within the window. Returns whether it does.
    fn resume(&mut self) -> bool {
        let Self { config, areas, driver, started, encoders, health, .. } = self;
        let oldest = config.fusion.window();
        let is_wanted = config.state.checkpoint_s > 0.0;
        let Some(warm) =
            is_wanted.then(|| WarmState::restore(&config.state.dir, *started, oldest, health)).flatten()
        else {
            return false;
        };
        if let Err(error) = driver.resume(config, areas.masks(), &warm, *started) {
            info!(%error, "state of the engine does not fit: begun anew");
            return false;
        }
        encoders.resume(&warm.encoders);
        let pause_s = (*started - warm.until).as_secs_f64();
        info!(datagrams = warm.inputs.len(), pause_s, "engine state restored");
        true
    }

    /// State of an engine that continues.
    fn known(&self) -> LiveRemains {
        let engine = self.driver.pipeline().engine();
        let words = engine.trust_overrides();
        (engine.numbers().given().collect(), engine.saved_associations(), words, engine.relocations())
    }

    /// Restores the state files into a new engine, and returns their contents.
    fn recalled(&mut self) -> LiveRemains {
        let Self { config, driver, started, health, .. } = self;
        let (directory, now) = (&config.state.dir, *started);
        let mut numbers = StateFile::NUMBERS.load(directory, now, health, read_numbers);
        // Files of an earlier version have no times.
        numbers.iter_mut().for_each(|given| _ = given.heard.get_or_insert(now));
        let loaded = numbers.len();
        let refused = driver.remember(&mut numbers);
        if loaded > 0 {
            info!(numbers = loaded, directory = %directory.display(), "transponder numbers loaded");
        }
        if refused > 0 {
            warn!(numbers = refused, "transponder numbers contradict others and are given anew");
        }
        let registrations = StateFile::REGISTRATION.load(directory, now, health, read_registration);
        registrations.restore(config, Some(now), driver.engine_mut());
        let decisions = StateFile::DECISIONS.load(directory, now, health, read_correlations);
        let CorrelationPlan { kept, words, relocations, .. } = decisions.plan(config);
        if !kept.is_empty() {
            info!(decisions = kept.len(), "decisions hold again where their radar tracks are heard in time");
        }
        if !words.is_empty() {
            info!(words = words.len(), "what operators said of transponders holds again");
        }
        if !relocations.is_empty() {
            info!(radars = relocations.len(), "radars stay where operators moved them");
        }
        let held = words.iter().map(|&(since, word)| ActiveOverride { word, since }).collect();
        driver.engine_mut().resume(kept.clone());
        driver.engine_mut().plan_trust_overrides(words);
        let active = relocations
            .iter()
            .filter_map(|&(since, RadarRelocation { radar, to })| {
                Some(ActiveRelocation { radar, to: to?, since })
            })
            .collect();
        driver.engine_mut().plan_relocations(relocations);
        (numbers, kept, held, active)
    }

    /// Starts recording if it is configured. Call after the state is restored, because the recording starts with it.
    ///
    /// # Errors
    /// No thread could be started.
    pub fn record(mut self) -> io::Result<Self> {
        if let Some(record) = &self.config.output.record {
            let numbers = std::mem::take(&mut self.numbers);
            let (queue, recorder) =
                Recorder::start(&self.config, record, numbers, RecordedContents::Service)?;
            self.before.drain(..).for_each(|before| _ = queue.add(before));
            self.recorder = Some((queue, recorder));
        }
        Ok(self)
    }

    /// Keeps the history if it is configured. It is opened in a thread of its own: a large file, or one that was not closed, does
    /// not delay the start.
    pub fn keep_history(mut self) -> Self {
        let state = &self.config.state;
        self.history = HistoryLimits::of(state)
            .map(|limits| HistoryStore::closed(&state.dir, limits, self.health.clone()));
        self
    }

    /// Opens outputs and inputs, and starts the service. Needs a runtime.
    ///
    /// # Errors
    /// An output, or a file that the API needs, cannot be used; or no thread could be started.
    pub fn start(self) -> Result<Live, AppError> {
        let Self { config, areas, listener, started, driver, encoders, shelved, recorder, history, .. } =
            self;
        let state = (self.kept_by.is_some() || history.is_some()).then_some(self.health);
        let shelves = self.shelves;
        let (writer, hub) = Hub::new(config.clone(), Arc::new(driver.maker().clone()), started);
        let (zones, zone_requests) = self.zones.map(OperatorZones::new).unzip();
        let alert_settings = AlertSettings::new(&config.alerts, &areas)?;
        let active = zones.iter().flat_map(OperatorZones::areas);
        let alert_settings = Current::from(alert_settings.with_areas(areas.alerts_with(active)));
        let mut alerts = AlertMonitor::new(alert_settings.clone(), started);
        alerts.resume(&shelved, started);
        let historian = history.clone().and_then(|store| {
            Historian::start(store).map_err(|error| error!(%error, "no history is kept")).ok()
        });
        let archive = historian.map(|historian| Box::new(historian) as Box<dyn Archive>);
        let receivers = NoticeReceivers::open(&config)?;
        receivers.warnings().iter().for_each(|warning| warn!("{warning}"));
        let (notices, deliveries) = receivers.start();
        let picture_sinks = PictureSinks::open(&config)?;
        picture_sinks.warnings().iter().for_each(|warning| warn!("{warning}"));
        let (meter, picture_deliveries) = picture_sinks.start(hub.clone());
        let options = api::Options {
            history: history.clone(),
            state: state.clone(),
            zones: zone_requests,
            notices: notices.clone(),
            sinks: meter.clone(),
            basemap: self.basemap,
            ..Default::default()
        };
        let followers =
            Followers { archive, messenger: Some(Box::new(notices)), outgoing: Some(Box::new(meter)), state };
        let served = Served::start(listener, hub, options, alerts, followers)?;
        let sinks = open_sinks(&config)?;
        let (keepers, warm) = self.kept_by.unzip();
        let (recorder_queue, recorder) = recorder.unzip();
        let outlets = Outlets {
            hub: writer,
            sinks: sinks.clone(),
            encoders,
            recorder: recorder_queue,
            keepers: self.keepers,
        };
        let source = match self.seen {
            Some((seen, decided)) => {
                let (clock, seen) = (WallClock::default(), (seen, Some(decided)));
                PictureThread::Viewer(Viewer::start(&config, &driver, outlets, &clock, seen, shelves)?)
            }
            None => {
                let runtime = tokio::runtime::Handle::current();
                PictureThread::Engine(LiveService::start(
                    config,
                    driver,
                    outlets,
                    WallClock::default(),
                    &runtime,
                )?)
            }
        };
        let keepers = keepers.unwrap_or_default();
        let deliveries = [deliveries, picture_deliveries];
        let warm = warm.flatten();
        Ok(Live {
            served,
            sinks,
            alert_settings,
            history,
            zones,
            source,
            keepers,
            warm,
            recorder,
            deliveries,
        })
    }
}

impl Live {
    /// Whether the engine's thread has ended. It ends before [`Self::stop`] only by a panic.
    pub fn has_ended(&self) -> bool {
        self.source.has_ended()
    }

    /// Stops the inputs, publishes the slots that are due, writes queued data, and ends the API. Returns the counters.
    ///
    /// # Errors
    /// A thread panicked, or another signal arrived; then the service does not wait for due slots.
    pub async fn stop(self, signals: &mut Signals) -> Result<Tally, AppError> {
        let Self { mut served, source, keepers, warm, recorder, deliveries, .. } = self;
        let stopped = tokio::task::spawn_blocking(move || {
            let tally = source.stop();
            // The engine has ended, and with it the senders of these queues.
            keepers.into_iter().for_each(StateKeeper::join);
            warm.into_iter().for_each(WarmKeeper::join);
            recorder.map(Recorder::join);
            tally
        });
        let ending = async {
            let tally = stopped.await??;
            served.settle().await;
            let [alerts, pictures] = deliveries;
            join(alerts.close(), pictures.close()).await;
            served.close().await?;
            Ok(tally)
        };
        tokio::select! {
            ended = ending => ended,
            () = signals.stop() => Err("stopped at once; not all that was owed may have been sent".into()),
        }
    }
}

#[cfg(test)]
mod damaged;
