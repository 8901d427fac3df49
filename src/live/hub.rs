//! What readers see: each slot's picture as it is published, and the state of the service once a second.

use std::sync::Arc;

use tokio::sync::{broadcast, watch};

use super::alerts::{Alert, Trouble};
use super::decisions::{Decider, Decisions, decisions};
use super::health::{SensorStatus, Unknown};
use super::inputs::Inputs;
use crate::config::Config;
use crate::picture::{Picture, PictureMaker};
use crate::pipeline::Tally;
use crate::publish::RecorderCounts;
use crate::time::Time;

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
    /// What the recorder did, where there is one.
    pub recording: Option<RecorderCounts>,
    /// What is wrong with the service itself.
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
    pub decider: Decider,
    frames: broadcast::Sender<Arc<Frame>>,
    latest: watch::Receiver<Option<Arc<Frame>>>,
    status: watch::Receiver<Option<Arc<Status>>>,
    alerts: watch::Sender<Arc<Vec<Alert>>>,
}

/// The one writer's side.
#[derive(Debug)]
pub struct HubWriter {
    /// Where the reports go that somebody wants to see.
    pub inputs: Arc<Inputs>,
    /// What operators decide.
    pub decisions: Decisions,
    frames: broadcast::Sender<Arc<Frame>>,
    latest: watch::Sender<Option<Arc<Frame>>>,
    status: watch::Sender<Option<Arc<Status>>>,
}

impl Hub {
    /// Both sides.
    pub fn new(config: Arc<Config>, maker: Arc<PictureMaker>, started: Time) -> (HubWriter, Self) {
        let (frames, _) = broadcast::channel(KEPT);
        let (latest_writer, latest) = watch::channel(None);
        let (status_writer, status) = watch::channel(None);
        let inputs = Arc::<Inputs>::default();
        let (decisions, decider) = decisions();
        let writer = HubWriter {
            inputs: inputs.clone(),
            decisions,
            frames: frames.clone(),
            latest: latest_writer,
            status: status_writer,
        };
        let (alerts, _) = watch::channel(Arc::default());
        (writer, Self { config, maker, started, inputs, decider, frames, latest, status, alerts })
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
