//! The live service, room by room.

use std::collections::BTreeMap;
use std::io;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, SyncSender};

use futures_util::future::join;
use tokio::net::TcpListener;
use tokio::sync::mpsc::Sender;
use tracing::{error, info, warn};

use super::{Failure, Served, Signals, open_sinks};
use crate::api;
use crate::areas::Areas;
use crate::config::Config;
use crate::current::Current;
use crate::formats::Encoders;
use crate::history::{Historian, Limits, Store};
use crate::integrity::Lookout;
use crate::live::{
    AlertSettings, Alerts, Archive, Clock, Decision, Driver, Followers, Hub, KeeperQueues, Outlets, Seen,
    Service, Viewer, now,
};
use crate::net::listen::lines;
use crate::net::send::Sinks;
use crate::notices::{Deliveries, Receivers};
use crate::pipeline::Tally;
use crate::record::{Recorded, Recorder, RecorderQueue};
use crate::sinks::PictureSinks;
use crate::state::{
    AlertDecision, CorrelationPlan, Keeper, Registrations, StateFile, StateHealth, Warm, WarmKeeper,
    alert_line, kept_lines, read_correlations, read_numbers, read_registration, registration_text,
};
use fusion::integrity::HeldWord;
use fusion::numbering::Given;
use fusion::operational::SavedCorrelation;
use fusion::time::Time;

/// A live service that is being put together. It keeps nothing unless it is told to.
pub struct LiveBuilder {
    config: Arc<Config>,
    areas: Areas,
    listener: TcpListener,
    started: Time,
    driver: Driver,
    /// Transponder numbers of before.
    numbers: Vec<Given>,
    /// The rest of what was before, as the recording begins with it.
    before: Vec<Recorded>,
    /// The alerts that were shelved.
    shelved: Vec<AlertDecision>,
    encoders: Encoders,
    keepers: Option<KeeperQueues>,
    kept_by: Option<(Vec<Keeper>, Option<WarmKeeper>)>,
    /// Where the picture comes from that is made elsewhere, and who keeps the alerts that are shelved.
    seen: Option<(Receiver<Seen>, Sender<Decision>)>,
    shelves: Option<SyncSender<Arc<str>>>,
    recorder: Option<(RecorderQueue, Recorder)>,
    history: Option<Store>,
    /// Health of the files of the state.
    health: StateHealth,
}

/// What outlives a restart: numbers, correlations and words.
type Outlived = (Vec<Given>, Vec<SavedCorrelation>, Vec<HeldWord>);

/// The running service.
pub struct Live {
    /// Its readers.
    pub served: Served,
    /// Its outputs.
    pub sinks: Sinks,
    /// What alerts are raised by.
    pub alert_settings: Current<AlertSettings>,
    /// Its history, where one is kept.
    pub history: Option<Store>,
    source: Source,
    keepers: Vec<Keeper>,
    warm: Option<WarmKeeper>,
    recorder: Option<Recorder>,
    /// Of alerts, and of the picture.
    deliveries: [Deliveries; 2],
}

/// Who makes the picture, or shows that of others.
enum Source {
    Engine(Service),
    Viewer(Viewer),
}

impl Source {
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
    /// Of a site whose API listens already: an address that is taken is told before anything is sent.
    pub fn new(config: Arc<Config>, areas: Areas, listener: TcpListener) -> Self {
        let started = now();
        Self {
            driver: Driver::new(&config, areas.masks(), started, lines(&config).len())
                .with_lookout(Lookout::new(&config, &areas)),
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
            health: StateHealth::default(),
        }
    }

    /// Shows what comes from elsewhere, and has no engine of its own: what operators decide goes to those who have. Of the state it keeps the alerts that are shelved.
    ///
    /// # Errors
    /// No thread could be started.
    pub fn view(mut self, (seen, decided): (Receiver<Seen>, Sender<Decision>)) -> io::Result<Self> {
        let (directory, health) = (&self.config.state.dir, &self.health);
        let shelved = StateFile::SHELVED.load(directory, self.started, health, read_correlations);
        self.shelved = shelved.plan(&self.config).alerts;
        let (shelves, keeper) = StateFile::SHELVED.keep(directory, Arc::<str>::from(""), health)?;
        self.kept_by = Some((vec![keeper], None));
        (self.seen, self.shelves) = (Some((seen, decided)), Some(shelves));
        Ok(self)
    }

    /// Goes on with what the state directory holds, and keeps it up to date.
    ///
    /// # Errors
    /// No thread could be started.
    pub fn keep_state(mut self) -> io::Result<Self> {
        // Also where it is damaged, and set aside by then.
        let was_here = Warm::is_there(&self.config.state.dir);
        let is_warm = self.go_on();
        let (numbers, kept, words) = if is_warm { self.known() } else { self.recalled() };
        let Self { config, driver, started, health, .. } = &mut self;
        let (directory, now) = (&config.state.dir, *started);
        if !is_warm && (was_here || !numbers.is_empty() || !health.all().is_empty()) {
            // What an earlier service has published, ahead perhaps when it was stopped, is not known.
            driver.publish_after(now);
            info!("an earlier service was here: slots of before this start are not published");
        }
        let registrations = Registrations::of(config, driver.pipeline().engine());
        if !registrations.is_empty() {
            info!(radars = registrations.len(), "registration goes on");
        }
        let shelved = StateFile::SHELVED.load(directory, now, health, read_correlations).plan(config).alerts;
        if !shelved.is_empty() {
            info!(alerts = shelved.len(), "alerts stay shelved");
        }
        let shelves: String = shelved.iter().map(alert_line).collect();
        let decisions = (kept_lines(&kept, &words, config) + &shelves).into();

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
        self.numbers = numbers;
        self.before = vec![
            Recorded::Registered(registration_text(&registrations).into()),
            Recorded::Correlations(decisions),
        ];
        self.before.extend(self.driver.published().map(Recorded::Published));
        if is_warm {
            // What is recorded begins where the engine is.
            self.before.push(Recorded::Checkpoint(self.driver.checkpoint(&self.config)));
        }
        Ok(self)
    }

    /// Goes on where a service has stopped just now, if there was one; whether it does.
    fn go_on(&mut self) -> bool {
        let Self { config, areas, driver, started, encoders, health, .. } = self;
        let oldest = config.fusion.window();
        let is_wanted = config.state.checkpoint_s > 0.0;
        let Some(warm) =
            is_wanted.then(|| Warm::restore(&config.state.dir, *started, oldest, health)).flatten()
        else {
            return false;
        };
        if let Err(error) = driver.go_on(config, areas.masks(), &warm, *started) {
            info!(%error, "state of the engine does not fit: begun anew");
            return false;
        }
        encoders.go_on(&warm.encoders);
        let pause_s = (*started - warm.until).as_secs_f64();
        info!(datagrams = warm.inputs.len(), pause_s, "the engine goes on where it stopped");
        true
    }

    /// What the engine that goes on knows.
    fn known(&self) -> Outlived {
        let engine = self.driver.pipeline().engine();
        (engine.numbers().given().collect(), engine.kept(), engine.words())
    }

    /// What the files of the state hold, given to the engine.
    fn recalled(&mut self) -> Outlived {
        let Self { config, driver, started, health, .. } = self;
        let (directory, now) = (&config.state.dir, *started);
        let mut numbers = StateFile::NUMBERS.load(directory, now, health, read_numbers);
        // A file of an earlier version has no times.
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
        let CorrelationPlan { kept, words, .. } = decisions.plan(config);
        if !kept.is_empty() {
            info!(decisions = kept.len(), "decisions hold again where their radar tracks are heard in time");
        }
        if !words.is_empty() {
            info!(words = words.len(), "what operators said of transponders holds again");
        }
        let held = words.iter().map(|&(since, word)| HeldWord { word, since }).collect();
        driver.engine_mut().resume(kept.clone());
        driver.engine_mut().plan_words(words);
        (numbers, kept, held)
    }

    /// Records, where the configuration asks for it; what was before is known by then.
    ///
    /// # Errors
    /// No thread could be started.
    pub fn record(mut self) -> io::Result<Self> {
        if let Some(record) = &self.config.output.record {
            let numbers = std::mem::take(&mut self.numbers);
            let (queue, recorder) = Recorder::start(&self.config, record, numbers, true)?;
            self.before.drain(..).for_each(|before| _ = queue.wait(before));
            self.recorder = Some((queue, recorder));
        }
        Ok(self)
    }

    /// Keeps the history, where the configuration asks for it. Its own thread opens it: a large file, or one that was not
    /// closed, does not delay the start.
    pub fn keep_history(mut self) -> Self {
        let state = &self.config.state;
        self.history = Limits::of(state).map(|limits| Store::closed(&state.dir, limits, self.health.clone()));
        self
    }

    /// Opens the outputs and the inputs, and starts; within a runtime.
    ///
    /// # Errors
    /// An output, or what the configuration of the API names, cannot be used; or no thread could be started.
    pub fn start(self) -> Result<Live, Failure> {
        let Self { config, areas, listener, started, driver, encoders, shelved, recorder, history, .. } =
            self;
        let state = (self.kept_by.is_some() || history.is_some()).then_some(self.health);
        let shelves = self.shelves;
        let (writer, hub) = Hub::new(config.clone(), Arc::new(driver.maker().clone()), started);
        let alert_settings = Current::from(AlertSettings::new(&config.alerts, &areas)?);
        let mut alerts = Alerts::new(alert_settings.clone(), started);
        alerts.resume(&shelved, started);
        let historian = history.clone().and_then(|store| {
            Historian::start(store).map_err(|error| error!(%error, "no history is kept")).ok()
        });
        let archive = historian.map(|historian| Box::new(historian) as Box<dyn Archive>);
        let receivers = Receivers::open(&config)?;
        receivers.warnings().iter().for_each(|warning| warn!("{warning}"));
        let (notices, deliveries) = receivers.start();
        let picture_sinks = PictureSinks::open(&config)?;
        picture_sinks.warnings().iter().for_each(|warning| warn!("{warning}"));
        let (meter, picture_deliveries) = picture_sinks.start(hub.clone());
        let options = api::Options {
            history: history.clone(),
            state: state.clone(),
            notices: notices.clone(),
            sinks: meter.clone(),
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
                let (clock, seen) = (Clock::default(), (seen, Some(decided)));
                Source::Viewer(Viewer::start(&config, &driver, outlets, &clock, seen, shelves)?)
            }
            None => {
                let runtime = tokio::runtime::Handle::current();
                Source::Engine(Service::start(config, driver, outlets, Clock::default(), &runtime)?)
            }
        };
        let keepers = keepers.unwrap_or_default();
        let deliveries = [deliveries, picture_deliveries];
        let warm = warm.flatten();
        Ok(Live { served, sinks, alert_settings, history, source, keepers, warm, recorder, deliveries })
    }
}

impl Live {
    /// Whether the engine's thread has ended, which it does by itself only when it panics.
    pub fn has_ended(&self) -> bool {
        self.source.has_ended()
    }

    /// Stops the inputs, publishes what is owed, writes what waits, and ends the API; what was counted.
    ///
    /// # Errors
    /// A thread panicked, or a further signal came: it does not wait for what is owed.
    pub async fn stop(self, signals: &mut Signals) -> Result<Tally, Failure> {
        let Self { mut served, source, keepers, warm, recorder, deliveries, .. } = self;
        let stopped = tokio::task::spawn_blocking(move || {
            let tally = source.stop();
            // The engine is gone, and with it what fed these.
            keepers.into_iter().for_each(Keeper::join);
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
