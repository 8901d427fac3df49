//! What readers see: each slot's picture as it is published, and the state of the service once a second.

use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError};
use std::time::{Duration, Instant};

use tokio::sync::{broadcast, watch};

use super::alert_desk::{AlertDesk, AlertRecords, alert_desk};
use super::alerts::{Alert, Trouble};
use super::condition::{Condition, Facts, Lateness, Punctuality};
use super::correlations::{Correlations, Correlator, correlations};
use super::inputs::Inputs;
use super::integrity::{IntegrityDesk, IntegrityRequests, integrity};
use super::members::Members;
use super::outlooks::{OutlookWriter, Outlooks, outlooks};
use super::posts::Posts;
use super::published::{PublishedPicture, Status};
use super::timings::Timings;
use crate::config::Config;
use crate::picture::PictureMaker;
use crate::record::{RecorderCounts, RecorderMeter};
use fusion::time::Time;

/// Slots that a reader may be behind before it has to begin anew: 16 s.
const KEPT: usize = 64;

/// The readers' side; cheap to clone.
#[derive(Clone, Debug)]
pub struct Hub {
    /// The site.
    pub config: Arc<Config>,
    /// Makes JSON of tracks.
    pub maker: Arc<PictureMaker>,
    /// When the service started; part of the ids of events.
    pub started: Time,
    /// The latest reports of the sensors.
    pub inputs: Arc<Inputs>,
    /// Takes operators' decisions.
    pub decider: Correlator,
    /// Takes operators' words on transponders, and knows what is known of these.
    pub integrity: IntegrityDesk,
    /// Who will come near whom.
    pub outlooks: Outlooks,
    /// Takes what operators decide about alerts.
    pub alert_desk: AlertDesk,
    frames: broadcast::Sender<Arc<PublishedPicture>>,
    latest: watch::Receiver<Option<Arc<PublishedPicture>>>,
    status: watch::Receiver<Option<Arc<Status>>>,
    members: watch::Receiver<Option<Arc<Members>>>,
    alerts: watch::Sender<Arc<Vec<Arc<Alert>>>>,
    known: Arc<Known>,
}

/// The one writer's side.
#[derive(Debug)]
pub struct HubWriter {
    /// Makes JSON of tracks.
    pub maker: Arc<PictureMaker>,
    /// Keeps the latest reports for readers.
    pub inputs: Arc<Inputs>,
    /// Operators' decisions.
    pub correlations: Correlations,
    /// Operators' words on transponders.
    pub integrity: IntegrityRequests,
    /// Takes what is found out about who will come near whom.
    pub outlooks: OutlookWriter,
    /// What operators decided about alerts, for the record.
    pub alerts: AlertRecords,
    frames: broadcast::Sender<Arc<PublishedPicture>>,
    latest: watch::Sender<Option<Arc<PublishedPicture>>>,
    status: watch::Sender<Option<Arc<Status>>>,
    members: watch::Sender<Option<Arc<Members>>>,
    known: Arc<Known>,
}

/// Shared by both sides, so that the condition is the same for everybody.
#[derive(Debug)]
struct Known {
    /// What [`Punctuality`] counts time from.
    origin: Instant,
    punctuality: Mutex<Punctuality>,
    /// None before the first slot, and in a replay.
    timings: Mutex<Option<Timings>>,
    recorder: OnceLock<RecorderMeter>,
    /// Where gateways post to, in a live service that has such a line.
    posts: OnceLock<Posts>,
    /// What is wrong with those that the observer hands on to.
    followers: watch::Sender<Vec<Trouble>>,
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
            timings: Mutex::default(),
            recorder: OnceLock::new(),
            posts: OnceLock::new(),
            followers: watch::Sender::default(),
        }
    }

    fn lateness(&self) -> Option<Lateness> {
        let at = self.origin.elapsed();
        self.punctuality().look(at)
    }

    fn condition(&self, has_slot: bool, status: Option<&Status>) -> Condition {
        let (lateness, followers) = (self.lateness(), self.followers.borrow());
        Condition::of(&Facts { has_slot, lateness, status, followers: &followers })
    }

    /// A panic elsewhere leaves nothing half done in here.
    fn punctuality(&self) -> MutexGuard<'_, Punctuality> {
        self.punctuality.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn timings(&self) -> MutexGuard<'_, Option<Timings>> {
        self.timings.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Hub {
    /// Both sides.
    pub fn new(config: Arc<Config>, maker: Arc<PictureMaker>, started: Time) -> (HubWriter, Self) {
        let (frames, _) = broadcast::channel(KEPT);
        let (latest_writer, latest) = watch::channel(None);
        let (status_writer, status) = watch::channel(None);
        let (members_writer, members) = watch::channel(None);
        let inputs = Arc::<Inputs>::default();
        let (correlations, decider) = correlations();
        let (integrity_requests, integrity) = integrity();
        let (outlook_writer, outlooks) = outlooks();
        let (alert_records, alert_desk) = alert_desk();
        let known = Arc::new(Known::new(config.fusion.slot.unsigned_abs()));
        let writer = HubWriter {
            maker: maker.clone(),
            inputs: inputs.clone(),
            correlations,
            integrity: integrity_requests,
            outlooks: outlook_writer,
            alerts: alert_records,
            frames: frames.clone(),
            latest: latest_writer,
            status: status_writer,
            members: members_writer,
            known: known.clone(),
        };
        let (alerts, _) = watch::channel(Arc::default());
        (
            writer,
            Self {
                config,
                maker,
                started,
                inputs,
                decider,
                integrity,
                outlooks,
                alert_desk,
                frames,
                latest,
                status,
                members,
                alerts,
                known,
            },
        )
    }

    /// The latest slot; `None` before the first.
    pub fn latest(&self) -> Option<Arc<PublishedPicture>> {
        self.latest.borrow().clone()
    }

    /// Every slot from now on; a reader more than 64 slots behind is told so.
    pub fn pictures(&self) -> broadcast::Receiver<Arc<PublishedPicture>> {
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

    /// How long the slots took so far; `None` before the first one of the live service, and in a replay.
    pub fn timings(&self) -> Option<Timings> {
        self.known.timings().clone()
    }

    /// What the recorder has done so far; `None` where there is none.
    pub fn recorded(&self) -> Option<RecorderCounts> {
        self.known.recorder.get().map(RecorderMeter::counts)
    }

    /// Where gateways post to; `None` where the site has no such line, in a replay, and in the first moments.
    pub fn posts(&self) -> Option<&Posts> {
        self.known.posts.get()
    }

    /// For the observer: what is wrong with those that it hands on to.
    pub(super) fn set_followers_troubles(&self, troubles: Vec<Trouble>) {
        self.known.followers.send_replace(troubles);
    }

    /// The alerts: those that last, then those that ended, the latest first.
    pub fn alerts(&self) -> Arc<Vec<Arc<Alert>>> {
        self.alerts.borrow().clone()
    }

    /// Changes whenever an alert begins, changes or ends.
    pub fn alert_changes(&self) -> watch::Receiver<Arc<Vec<Arc<Alert>>>> {
        self.alerts.subscribe()
    }

    /// For the observer.
    pub(super) fn set_alerts(&self, alerts: Vec<Arc<Alert>>) {
        self.alerts.send_replace(Arc::new(alerts));
    }

    /// Who makes the picture; `None` on one machine, and before anything is known of the cluster.
    pub fn members(&self) -> Option<Arc<Members>> {
        self.members.borrow().clone()
    }

    /// Changes with each new status.
    pub fn statuses(&self) -> watch::Receiver<Option<Arc<Status>>> {
        self.status.clone()
    }
}

impl HubWriter {
    /// Publishes a slot of the live service, and notes how late that is; `waited`: how many datagrams had waited for the
    /// engine for long since the slot before. Never waits for readers.
    pub fn publish_live(&self, frame: PublishedPicture, waited: usize) -> Arc<PublishedPicture> {
        let since = |time: Time| {
            let nanos = frame.published_at.nanos().saturating_sub(time.nanos());
            Duration::from_nanos(u64::try_from(nanos).unwrap_or(0))
        };
        let late = since(frame.due);
        let mut timings = self.known.timings();
        let counted = timings.get_or_insert_default();
        counted.lateness.note(late);
        counted.latency.note(since(frame.picture.time));
        drop(timings);
        // Whoever sees the slot knows how late it is.
        let at = self.known.origin.elapsed();
        self.known.punctuality().note(at, late, waited);
        self.publish(frame)
    }

    /// The service's condition as of `status`, which need not have been told yet.
    pub fn condition(&self, status: &Status) -> Condition {
        self.known.condition(self.latest.borrow().is_some(), Some(status))
    }

    /// Shows readers the recorder's counts from now on.
    pub fn set_recorder(&self, meter: RecorderMeter) {
        // There is one recorder, and this is said once.
        let _ = self.known.recorder.set(meter);
    }

    /// Lets gateways post from now on.
    pub fn set_posts(&self, posts: Posts) {
        // There is one such line, and this is said once.
        let _ = self.known.posts.set(posts);
    }

    /// Publishes a slot; never waits.
    pub fn publish(&self, frame: PublishedPicture) -> Arc<PublishedPicture> {
        let frame = Arc::new(frame);
        self.latest.send_replace(Some(frame.clone()));
        // Nobody may be listening.
        let _ = self.frames.send(frame.clone());
        frame
    }

    /// Publishes who makes the picture; never waits.
    pub fn tell_members(&self, members: Members) {
        self.members.send_replace(Some(Arc::new(members)));
    }

    /// Publishes a status; never waits.
    pub fn tell(&self, status: Status) {
        self.status.send_replace(Some(Arc::new(status)));
    }
}
