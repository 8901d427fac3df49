//! Data for readers: each slot's picture as it is published, and the status once a second.

use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError};
use std::time::{Duration, Instant};

use tokio::sync::{broadcast, watch};

use super::alert_requests::{AlertRecordQueue, AlertRequests, alert_requests};
use super::alerts::{Alert, ServiceFault};
use super::condition::{Condition, ConditionInputs, PictureLateness, Punctuality};
use super::conflict_reports::{ConflictPublisher, ConflictReports, conflict_reports};
use super::correlations::{CorrelationRequestQueue, CorrelationRequests, correlation_requests};
use super::http_input::HttpInput;
use super::integrity::{TrustRequestQueue, TrustRequests, trust_requests};
use super::members::ClusterMembers;
use super::published::{PublishedPicture, Status};
use super::recent_reports::RecentReports;
use super::relocations::{RelocationRequestQueue, RelocationRequests, relocation_requests};
use super::timings::SlotTimings;
use crate::record::{RecorderCounts, RecorderMeter};
use fusion::time::Time;
use picture::PictureMaker;
use site::config::Config;

/// Maximum number of slots that a reader may fall behind before it has to start again: 16 s.
const KEPT: usize = 64;

/// The readers' end; cheap to clone.
#[derive(Clone, Debug)]
pub struct Hub {
    /// Configuration of the site.
    pub config: Arc<Config>,
    /// Converts tracks to JSON.
    pub maker: Arc<PictureMaker>,
    /// Start of the service; part of the ids of events.
    pub started: Time,
    /// Latest reports of the sensors.
    pub recent_reports: Arc<RecentReports>,
    /// Queue of operators' decisions on correlations.
    pub correlation_requests: CorrelationRequests,
    /// Queue of operators' trust settings, with the present assessments of the transponders.
    pub trust_requests: TrustRequests,
    /// Queue of operators' decisions on radars' positions, with the relocations in force.
    pub relocation_requests: RelocationRequests,
    /// Predicted conflicts.
    pub conflict_reports: ConflictReports,
    /// Queue of operators' decisions about alerts.
    pub alert_requests: AlertRequests,
    pictures: broadcast::Sender<Arc<PublishedPicture>>,
    latest: watch::Receiver<Option<Arc<PublishedPicture>>>,
    status: watch::Receiver<Option<Arc<Status>>>,
    members: watch::Receiver<Option<Arc<ClusterMembers>>>,
    alerts: watch::Sender<Arc<Vec<Arc<Alert>>>>,
    shared: Arc<HubState>,
}

/// The end of the only writer.
#[derive(Debug)]
pub struct HubWriter {
    /// Converts tracks to JSON.
    pub maker: Arc<PictureMaker>,
    /// Keeps the latest reports for readers.
    pub recent_reports: Arc<RecentReports>,
    /// Operators' decisions on correlations.
    pub correlation_requests: CorrelationRequestQueue,
    /// Operators' trust settings for transponders.
    pub trust_requests: TrustRequestQueue,
    /// Operators' decisions on radars' positions.
    pub relocation_requests: RelocationRequestQueue,
    /// Publishes the predicted conflicts.
    pub conflict_reports: ConflictPublisher,
    /// Operators' decisions about alerts, for the recording.
    pub alert_records: AlertRecordQueue,
    pictures: broadcast::Sender<Arc<PublishedPicture>>,
    latest: watch::Sender<Option<Arc<PublishedPicture>>>,
    status: watch::Sender<Option<Arc<Status>>>,
    members: watch::Sender<Option<Arc<ClusterMembers>>>,
    shared: Arc<HubState>,
}

/// State shared by both ends, so that all readers see the same condition.
#[derive(Debug)]
struct HubState {
    /// Origin of the times given to [`Punctuality`].
    origin: Instant,
    punctuality: Mutex<Punctuality>,
    /// `None` before the first slot, and in a replay.
    timings: Mutex<Option<SlotTimings>>,
    recorder: OnceLock<RecorderMeter>,
    /// Input for gateways that post over HTTP; set in a live service with such a line.
    http_input: OnceLock<HttpInput>,
    /// Faults of the observer's followers.
    followers: watch::Sender<Vec<ServiceFault>>,
}

impl HubState {
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
            http_input: OnceLock::new(),
            followers: watch::Sender::default(),
        }
    }

    fn lateness(&self) -> Option<PictureLateness> {
        let at = self.origin.elapsed();
        self.punctuality().look(at)
    }

    fn condition(&self, has_slot: bool, status: Option<&Status>) -> Condition {
        let (lateness, followers) = (self.lateness(), self.followers.borrow());
        Condition::of(&ConditionInputs { has_slot, lateness, status, followers: &followers })
    }

    /// A poisoned lock is usable: no update of this state can be left half done.
    fn punctuality(&self) -> MutexGuard<'_, Punctuality> {
        self.punctuality.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn timings(&self) -> MutexGuard<'_, Option<SlotTimings>> {
        self.timings.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Hub {
    /// Both ends.
    pub fn new(config: Arc<Config>, maker: Arc<PictureMaker>, started: Time) -> (HubWriter, Self) {
        let (pictures, _) = broadcast::channel(KEPT);
        let (latest_writer, latest) = watch::channel(None);
        let (status_writer, status) = watch::channel(None);
        let (members_writer, members) = watch::channel(None);
        let recent_reports = Arc::<RecentReports>::default();
        let (correlation_queue, correlation_requests) = correlation_requests();
        let (trust_queue, trust_requests) = trust_requests();
        let (relocation_queue, relocation_requests) = relocation_requests();
        let (conflict_publisher, conflict_reports) = conflict_reports();
        let (alert_records, alert_requests) = alert_requests();
        let shared = Arc::new(HubState::new(config.fusion.slot.unsigned_abs()));
        let writer = HubWriter {
            maker: maker.clone(),
            recent_reports: recent_reports.clone(),
            correlation_requests: correlation_queue,
            trust_requests: trust_queue,
            relocation_requests: relocation_queue,
            conflict_reports: conflict_publisher,
            alert_records,
            pictures: pictures.clone(),
            latest: latest_writer,
            status: status_writer,
            members: members_writer,
            shared: shared.clone(),
        };
        let (alerts, _) = watch::channel(Arc::default());
        (
            writer,
            Self {
                config,
                maker,
                started,
                recent_reports,
                correlation_requests,
                trust_requests,
                relocation_requests,
                conflict_reports,
                alert_requests,
                pictures,
                latest,
                status,
                members,
                alerts,
                shared,
            },
        )
    }

    /// The latest slot; `None` before the first.
    pub fn latest(&self) -> Option<Arc<PublishedPicture>> {
        self.latest.borrow().clone()
    }

    /// Subscribes to all slots from now on. A reader more than 64 slots behind receives an error.
    pub fn pictures(&self) -> broadcast::Receiver<Arc<PublishedPicture>> {
        self.pictures.subscribe()
    }

    /// The latest status; `None` right after the start.
    pub fn status(&self) -> Option<Arc<Status>> {
        self.status.borrow().clone()
    }

    /// Present condition of the service, also if the engine has stopped since its last status.
    pub fn condition(&self) -> Condition {
        self.shared.condition(self.latest.borrow().is_some(), self.status().as_deref())
    }

    /// Lateness of the live picture; `None` before its first slot, and in a replay.
    pub fn lateness(&self) -> Option<PictureLateness> {
        self.shared.lateness()
    }

    /// Durations of the slots so far; `None` before the first slot of the live service, and in a replay.
    pub fn timings(&self) -> Option<SlotTimings> {
        self.shared.timings().clone()
    }

    /// Counts of the recorder; `None` without a recorder.
    pub fn recorded(&self) -> Option<RecorderCounts> {
        self.shared.recorder.get().map(RecorderMeter::counts)
    }

    /// Input for gateways that post over HTTP; `None` if the site has no such line, in a replay, and right after the start.
    pub fn http_input(&self) -> Option<&HttpInput> {
        self.shared.http_input.get()
    }

    /// Sets the faults of the followers; called by the observer.
    pub(super) fn set_followers_troubles(&self, troubles: Vec<ServiceFault>) {
        self.shared.followers.send_replace(troubles);
    }

    /// All alerts: the active ones, then the ended ones, the latest first.
    pub fn alerts(&self) -> Arc<Vec<Arc<Alert>>> {
        self.alerts.borrow().clone()
    }

    /// Subscribes to the alerts; notified whenever an alert begins, changes or ends.
    pub fn alert_changes(&self) -> watch::Receiver<Arc<Vec<Arc<Alert>>>> {
        self.alerts.subscribe()
    }

    /// Sets the alerts; called by the observer.
    pub(super) fn set_alerts(&self, alerts: Vec<Arc<Alert>>) {
        self.alerts.send_replace(Arc::new(alerts));
    }

    /// Members of the cluster; `None` on a single machine, and before the first message from the cluster.
    pub fn members(&self) -> Option<Arc<ClusterMembers>> {
        self.members.borrow().clone()
    }

    /// Subscribes to the status.
    pub fn statuses(&self) -> watch::Receiver<Option<Arc<Status>>> {
        self.status.clone()
    }
}

impl HubWriter {
    /// Publishes a slot of the live service, and records its lateness. `waited`: number of datagrams delayed in the
    /// engine's queue since the slot before. Never waits for readers.
    pub fn publish_live(&self, frame: PublishedPicture, waited: usize) -> Arc<PublishedPicture> {
        let since = |time: Time| {
            let nanos = frame.published_at.nanos().saturating_sub(time.nanos());
            Duration::from_nanos(u64::try_from(nanos).unwrap_or(0))
        };
        let late = since(frame.due);
        let mut timings = self.shared.timings();
        let counted = timings.get_or_insert_default();
        counted.lateness.note(late);
        counted.latency.note(since(frame.picture.time));
        drop(timings);
        // The lateness is recorded first: a reader of the slot sees it too.
        let at = self.shared.origin.elapsed();
        self.shared.punctuality().note(at, late, waited);
        self.publish(frame)
    }

    /// Condition of the service with `status`, which need not be published yet.
    pub fn condition(&self, status: &Status) -> Condition {
        self.shared.condition(self.latest.borrow().is_some(), Some(status))
    }

    /// Publishes the recorder's counts from now on.
    pub fn set_recorder(&self, meter: RecorderMeter) {
        // Set once, by the only recorder.
        let _ = self.shared.recorder.set(meter);
    }

    /// Accepts http_input from gateways from now on.
    pub fn set_http_input(&self, http_input: HttpInput) {
        // Set once, by the only such line.
        let _ = self.shared.http_input.set(http_input);
    }

    /// Publishes a slot; never waits.
    pub fn publish(&self, frame: PublishedPicture) -> Arc<PublishedPicture> {
        let frame = Arc::new(frame);
        self.latest.send_replace(Some(frame.clone()));
        // Fails only without subscribers.
        let _ = self.pictures.send(frame.clone());
        frame
    }

    /// Publishes the members of the cluster; never waits.
    pub fn publish_members(&self, members: ClusterMembers) {
        self.members.send_replace(Some(Arc::new(members)));
    }

    /// Publishes a status; never waits.
    pub fn publish_status(&self, status: Status) {
        self.status.send_replace(Some(Arc::new(status)));
    }
}
