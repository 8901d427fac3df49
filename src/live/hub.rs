//! What readers see: each slot's picture as it is published, and the state of the service once a second.

use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError};
use std::time::{Duration, Instant};

use tokio::sync::{broadcast, watch};

use super::alerts::{Alert, Trouble};
use super::condition::{Condition, Facts, Lateness, Punctuality};
use super::correlations::{Correlations, Correlator, correlations};
use super::health::{SensorStatus, Unknown};
use super::inputs::Inputs;
use crate::config::Config;
use crate::picture::{Picture, PictureMaker};
use crate::pipeline::Tally;
use crate::record::{RecorderCounts, RecorderMeter};
use fusion::time::Time;

/// Slots that a reader may be behind before it has to begin anew: 16 s.
const KEPT: usize = 64;

/// A published slot.
#[derive(Clone, Debug, PartialEq)]
pub struct Frame {
    /// Counts the slots of this run of the service, from 1.
    pub seq: u64,
    /// When the slot was due.
    pub due: Time,
    /// When it was published.
    pub published_at: Time,
    /// What is in it.
    pub picture: Picture,
}

/// How the service is; published once a second.
#[derive(Clone, Debug, PartialEq)]
pub struct Status {
    /// When.
    pub at: Time,
    /// In the order of the configuration.
    pub sensors: Vec<SensorStatus>,
    /// Sources that no sensor is.
    pub unknown: Vec<Unknown>,
    /// What happened since the start.
    pub tally: Tally,
    /// Transponder numbers that somebody has.
    pub numbers_used: usize,
    /// How late slots were published in the last minutes, seconds: median, 95th and 99th percentile.
    pub lateness_s: Option<[f64; 3]>,
    /// Datagrams that could not be sent since the start.
    pub failed_sends: u64,
    /// What the engine knows to be wrong with the service itself; [`Condition`] adds what it cannot know.
    pub troubles: Vec<Trouble>,
}

/// The readers' side; cheap to clone.
#[derive(Clone, Debug)]
pub struct Hub {
    /// The site.
    pub config: Arc<Config>,
    /// Makes JSON of tracks.
    pub maker: Arc<PictureMaker>,
    /// When the service started; part of the ids of events.
    pub started: Time,
    /// What the sensors said lately.
    pub inputs: Arc<Inputs>,
    /// Decides which radar track is which transponder.
    pub decider: Correlator,
    frames: broadcast::Sender<Arc<Frame>>,
    latest: watch::Receiver<Option<Arc<Frame>>>,
    status: watch::Receiver<Option<Arc<Status>>>,
    alerts: watch::Sender<Arc<Vec<Alert>>>,
    known: Arc<Known>,
}

/// The one writer's side.
#[derive(Debug)]
pub struct HubWriter {
    /// Where the reports go that somebody wants to see.
    pub inputs: Arc<Inputs>,
    /// What operators decide.
    pub correlations: Correlations,
    frames: broadcast::Sender<Arc<Frame>>,
    latest: watch::Sender<Option<Arc<Frame>>>,
    status: watch::Sender<Option<Arc<Status>>>,
    known: Arc<Known>,
}

/// What both sides know, so that the condition is the same whoever asks for it.
#[derive(Debug)]
struct Known {
    /// What [`Punctuality`] counts time from.
    origin: Instant,
    punctuality: Mutex<Punctuality>,
    recorder: OnceLock<RecorderMeter>,
    history: watch::Sender<Option<Trouble>>,
}

impl Known {
    #[expect(
        clippy::disallowed_methods,
        reason = "whether slots still come is measured by a clock that nobody sets"
    )]
    fn new(slot: Duration) -> Self {
        Self {
            origin: Instant::now(),
            punctuality: Mutex::new(Punctuality::new(slot)),
            recorder: OnceLock::new(),
            history: watch::Sender::new(None),
        }
    }

    fn lateness(&self) -> Option<Lateness> {
        let at = self.origin.elapsed();
        self.punctuality().look(at)
    }

    fn condition(&self, has_slot: bool, status: Option<&Status>) -> Condition {
        let (lateness, history) = (self.lateness(), self.history.borrow());
        Condition::of(&Facts { has_slot, lateness, status, history: history.as_ref() })
    }

    /// A panic elsewhere leaves nothing half done in here.
    fn punctuality(&self) -> MutexGuard<'_, Punctuality> {
        self.punctuality.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Hub {
    /// Both sides.
    pub fn new(config: Arc<Config>, maker: Arc<PictureMaker>, started: Time) -> (HubWriter, Self) {
        let (frames, _) = broadcast::channel(KEPT);
        let (latest_writer, latest) = watch::channel(None);
        let (status_writer, status) = watch::channel(None);
        let inputs = Arc::<Inputs>::default();
        let (correlations, decider) = correlations();
        let known = Arc::new(Known::new(config.fusion.slot.unsigned_abs()));
        let writer = HubWriter {
            inputs: inputs.clone(),
            correlations,
            frames: frames.clone(),
            latest: latest_writer,
            status: status_writer,
            known: known.clone(),
        };
        let (alerts, _) = watch::channel(Arc::default());
        (writer, Self { config, maker, started, inputs, decider, frames, latest, status, alerts, known })
    }

    /// The latest slot; `None` before the first.
    pub fn latest(&self) -> Option<Arc<Frame>> {
        self.latest.borrow().clone()
    }

    /// Every slot from now on; who is more than 64 slots behind is told so.
    pub fn frames(&self) -> broadcast::Receiver<Arc<Frame>> {
        self.frames.subscribe()
    }

    /// The latest status; `None` in the first moments.
    pub fn status(&self) -> Option<Arc<Status>> {
        self.status.borrow().clone()
    }

    /// The service's condition now, also where the engine has stood still since it spoke last.
    pub fn condition(&self) -> Condition {
        self.known.condition(self.latest.borrow().is_some(), self.status().as_deref())
    }

    /// How late the live picture is; `None` before its first slot, and in a replay.
    pub fn lateness(&self) -> Option<Lateness> {
        self.known.lateness()
    }

    /// What the recorder has done by now; `None` where there is none.
    pub fn recorded(&self) -> Option<RecorderCounts> {
        self.known.recorder.get().map(RecorderMeter::counts)
    }

    /// For the one that keeps the history: what is wrong with it.
    pub(super) fn set_history_trouble(&self, trouble: Option<Trouble>) {
        self.known.history.send_replace(trouble);
    }

    /// What is wrong, or was lately: those that last first, then those that ended, the latest first.
    pub fn alerts(&self) -> Arc<Vec<Alert>> {
        self.alerts.borrow().clone()
    }

    /// Told whenever an alert begins, ends or gets worse.
    pub fn alert_changes(&self) -> watch::Receiver<Arc<Vec<Alert>>> {
        self.alerts.subscribe()
    }

    /// For the one that watches.
    pub(super) fn set_alerts(&self, alerts: Vec<Alert>) {
        self.alerts.send_replace(Arc::new(alerts));
    }

    /// Told of each new status.
    pub fn statuses(&self) -> watch::Receiver<Option<Arc<Status>>> {
        self.status.clone()
    }
}

impl HubWriter {
    /// Publishes a slot of the live service, and notes how late that is; `waited`: how many datagrams had waited for the
    /// engine for long since the slot before. Never waits for readers.
    pub fn publish_live(&self, frame: Frame, waited: usize) {
        let late_ns = frame.published_at.nanos().saturating_sub(frame.due.nanos());
        let late = Duration::from_nanos(u64::try_from(late_ns).unwrap_or(0));
        // Whoever sees the slot knows how late it is.
        let at = self.known.origin.elapsed();
        self.known.punctuality().note(at, late, waited);
        self.publish(frame);
    }

    /// The service's condition as of `status`, which need not have been told yet.
    pub fn condition(&self, status: &Status) -> Condition {
        self.known.condition(self.latest.borrow().is_some(), Some(status))
    }

    /// What the recorder does is read from there from now on, at the moment at which somebody asks.
    pub fn set_recorder(&self, meter: RecorderMeter) {
        // There is one recorder, and this is said once.
        let _ = self.known.recorder.set(meter);
    }

    /// Publishes a slot; never waits.
    pub fn publish(&self, frame: Frame) {
        let frame = Arc::new(frame);
        self.latest.send_replace(Some(frame.clone()));
        // Nobody may be listening.
        let _ = self.frames.send(frame);
    }

    /// Publishes a status; never waits.
    pub fn tell(&self, status: Status) {
        self.status.send_replace(Some(Arc::new(status)));
    }
}
