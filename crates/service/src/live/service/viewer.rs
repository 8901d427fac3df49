//! Shows and sends a picture that other nodes make, like an engine's own.

use std::collections::VecDeque;
use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender};
use std::thread::JoinHandle;
use std::time::Duration;

use jiff::SignedDuration;
use tokio::sync::mpsc::Sender;
use tracing::warn;

use super::decisions::{DecisionForwarder, OperatorDecision};
use super::publication::Publisher;
use super::{Outlets, POLL_INTERVAL};
use crate::clock::WallClock;
use crate::live::alerts::{ServiceFault, Severity};
use crate::live::driver::Driver;
use crate::live::health::SensorState;
use crate::live::integrity::TrustAssessments;
use crate::live::members::ClusterMembers;
use crate::live::ongoing_losses::OngoingLosses;
use crate::live::published::{PublishedPicture, Status};
use fusion::operational::ActiveAssociation;
use fusion::slots::Slot;
use fusion::time::{SECOND, Time};
use input::pipeline::Tally;
use picture::Picture;
use site::config::Config;

/// Timeout of the status, which the nodes that make the picture report once a second. It is longer than a
/// takeover; after it the state of the sensors is unknown.
const UNHEARD: SignedDuration = SignedDuration::from_secs(8);

/// Data from the nodes that make the picture.
#[derive(Debug)]
pub enum ViewerInput {
    /// A slot: the usual picture, and the present picture if it is made.
    Slot(Box<Picture>, Option<Box<Picture>>),
    /// Status of the sensors, and the owner's assessments and correlations.
    Status(Box<Status>, Box<TrustAssessments>, Vec<ActiveAssociation>),
    /// Members of the cluster.
    Members(Box<ClusterMembers>),
    /// Offset of this machine's clock ahead of the members', if it is wrong; the picture uses the members' times.
    Ahead(SignedDuration),
}

/// Counts of received slots.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ViewerCounts {
    /// Slots shown.
    pub shown: u64,
    /// Slots not shown because they, or later ones, had been shown.
    pub doubled: u64,
    /// Slots never received.
    pub missing: u64,
}

/// Thread that shows the picture.
pub struct Viewer {
    stop: Arc<AtomicBool>,
    thread: JoinHandle<Tally>,
}

impl Viewer {
    /// Starts to show received slots, on its own thread. Operators' decisions are sent to the nodes that make it. `shelves`
    /// keeps the shelved alerts.
    ///
    /// # Errors
    /// The system gives no thread.
    pub fn start(
        config: &Config,
        driver: &Driver,
        outlets: Outlets,
        clock: &WallClock,
        (inputs, decided): (Receiver<ViewerInput>, Option<Sender<OperatorDecision>>),
        shelves: Option<SyncSender<Arc<str>>>,
    ) -> io::Result<Self> {
        let stop = Arc::new(AtomicBool::new(false));
        let view = ViewerState::new(config, driver, outlets, clock, shelves, decided);
        let stopped = stop.clone();
        let thread = std::thread::Builder::new()
            .name("picture".to_owned())
            .spawn(move || view.run(&inputs, &stopped))?;
        Ok(Self { stop, thread })
    }

    /// Whether the thread has ended by itself, which is a bug.
    pub fn has_ended(&self) -> bool {
        self.thread.is_finished()
    }

    /// Shows what was received, and ends; returns the counts. Must not be called on a thread of a
    /// runtime.
    ///
    /// # Errors
    /// The thread panicked.
    pub fn stop(self) -> Result<Tally, String> {
        self.stop.store(true, Ordering::Relaxed);
        self.thread.join().map_err(|_| "the picture's thread panicked; this is a bug".to_owned())
    }
}

struct ViewerState {
    publisher: Publisher,
    due_after: SignedDuration,
    lead: SignedDuration,
    /// The latest slot received.
    last: Option<Slot>,
    seq: u64,
    counts: ViewerCounts,
    last_status: Option<Status>,
    forwarder: DecisionForwarder,
    /// Faults of the members, with the time of their last report.
    troubles: (Time, Vec<ServiceFault>),
    misses: OngoingLosses,
    failed_logged: u64,
    shelves: Option<SyncSender<Arc<str>>>,
    saved_shelves: Arc<str>,
    next_status: Time,
    /// Correction of this machine's clock.
    ahead: SignedDuration,
    /// Slots received twice, until they are logged.
    late: VecDeque<Slot>,
}

impl ViewerState {
    fn new(
        config: &Config,
        driver: &Driver,
        outlets: Outlets,
        clock: &WallClock,
        shelves: Option<SyncSender<Arc<str>>>,
        decided: Option<Sender<OperatorDecision>>,
    ) -> Self {
        Self {
            publisher: Publisher::new(config, outlets, clock.clone()),
            due_after: config.fusion.latency() - config.fusion.slot / 2,
            lead: driver.lead(),
            last: None,
            seq: 0,
            counts: ViewerCounts::default(),
            last_status: None,
            forwarder: DecisionForwarder::new(config, decided),
            troubles: (clock.now(), Vec::new()),
            misses: OngoingLosses::default(),
            failed_logged: 0,
            shelves,
            saved_shelves: "".into(),
            next_status: clock.now(),
            ahead: SignedDuration::ZERO,
            late: VecDeque::new(),
        }
    }

    fn run(mut self, inputs: &Receiver<ViewerInput>, stop: &AtomicBool) -> Tally {
        while !stop.load(Ordering::Relaxed) {
            match inputs.recv_timeout(self.until_due()) {
                Ok(input) => self.handle(input),
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => break,
            }
            let at = self.publisher.clock.now();
            self.forward_requests(at);
            self.publisher.publish_due(at, self.lead);
            self.publisher.evaluate_conflicts();
            if at >= self.next_status || self.next_status.nanos() - at.nanos() > SECOND {
                self.next_status = Time::from_nanos((at.nanos() / SECOND + 1) * SECOND);
                self.publish_status(at);
            }
        }
        self.publisher.publish_pending();
        self.publish_status(self.publisher.clock.now());
        self.last_status.map(|told| told.tally).unwrap_or_default()
    }

    fn until_due(&self) -> Duration {
        let wait = self.publisher.next_due();
        let wait = wait.map(|due| Duration::try_from(due - self.publisher.clock.now()).unwrap_or_default());
        wait.map_or(POLL_INTERVAL, |wait| wait.min(POLL_INTERVAL))
    }

    fn handle(&mut self, input: ViewerInput) {
        match input {
            ViewerInput::Slot(picture, now) => {
                if let Some(last) = self.last {
                    if picture.slot <= last {
                        self.counts.doubled += 1;
                        self.late.push_back(picture.slot);
                        return;
                    }
                    self.counts.missing += (picture.slot.0 - last.0 - 1).unsigned_abs();
                }
                self.last = Some(picture.slot);
                self.seq += 1;
                self.counts.shown += 1;
                self.forwarder.note_picture(&picture);
                let due = picture.time + self.due_after;
                self.publisher.enqueue(PublishedPicture {
                    seq: self.seq,
                    due,
                    published_at: due,
                    picture: *picture,
                    now: now.map(|now| *now).into(),
                });
            }
            ViewerInput::Status(status, integrities, correlations) => {
                self.forwarder.note_cell_status(&correlations, &integrities);
                self.publisher.outlets.hub.trust_requests.publish(&integrities);
                self.publisher.outlets.hub.correlation_requests.publish_if_changed(&correlations);
                self.last_status = Some(*status);
            }
            ViewerInput::Members(members) => {
                self.troubles = (self.publisher.clock.now(), members.troubles());
                let ViewerCounts { shown, doubled, missing } = self.counts;
                let members = ClusterMembers { shown, doubled, missing, ..*members };
                self.publisher.outlets.hub.publish_members(members);
            }
            ViewerInput::Ahead(ahead) => {
                self.publisher.clock.step(std::mem::replace(&mut self.ahead, ahead) - ahead);
            }
        }
    }

    /// Forwards operators' requests to the nodes that make the picture.
    fn forward_requests(&mut self, at: Time) {
        let is_heard = self.last_status.as_ref().is_some_and(|told| at - told.at <= UNHEARD);
        let hub = &self.publisher.outlets.hub;
        self.forwarder.forward(&hub.correlation_requests, &hub.trust_requests, is_heard);
        hub.relocation_requests.refuse_all();
    }

    /// Publishes the last received status, once a second.
    fn publish_status(&mut self, at: Time) {
        let hub = &self.publisher.outlets.hub;
        // Decisions are recorded by the engine's node; shelved alerts are kept here.
        hub.alert_records.lines().for_each(drop);
        let shelves = hub.alert_records.shelves();
        if let Some(keeper) = &self.shelves
            && *shelves != *self.saved_shelves
            && keeper.try_send(shelves.clone()).is_ok()
        {
            self.saved_shelves = shelves;
        }
        for slot in self.late.drain(..) {
            warn!(slot = slot.0, "a slot came twice: shown once");
        }
        let Some(told) = &self.last_status else { return };
        let mut status = told.clone();
        if at - told.at > UNHEARD {
            let silent_s = (at - told.at).as_secs();
            let text = format!(
                "nobody has said for {silent_s} s how the sensors are: the cell has no owner, or the log is away"
            );
            for sensor in &mut status.sensors {
                sensor.state = SensorState::Outage;
                sensor.reasons = vec!["not known".to_owned()];
            }
            let trouble =
                ServiceFault { about: ServiceFault::CLUSTER.into(), severity: Severity::Critical, text };
            status.troubles.push(trouble);
        }
        let (heard_of, troubles) = &self.troubles;
        if at - *heard_of <= UNHEARD {
            status.troubles.extend(troubles.iter().cloned());
        }
        if let Some(slots) = self.misses.update(self.counts.missing, at) {
            let text = format!("{slots} slots were published by nobody");
            status.troubles.push(ServiceFault {
                about: ServiceFault::CLUSTER.into(),
                severity: Severity::Warning,
                text,
            });
        }
        let failed = self.publisher.failed_sends - self.failed_logged;
        self.failed_logged = self.publisher.failed_sends;
        if failed > 0 {
            let text = format!("{failed} datagrams could not be sent in a second");
            status.troubles.push(ServiceFault {
                about: ServiceFault::OUTPUT.into(),
                severity: Severity::Critical,
                text,
            });
        }
        status.at = at;
        self.publisher.publish_status(status);
    }
}

#[cfg(test)]
mod tests {
    use fusion::integrity::Trust;

    use super::*;
    use crate::live::requests::RequestError;
    use crate::live::{CellState, DriverEvent, Hub, ServiceLevel, TransponderName, TrustRequest};
    use crate::net::send::UdpDestinations;
    use lab::simulate::{Scenario, simulate};
    use picture::formats::Encoders;
    use site::areas::Masks;

    /// The slots of a flight of half a minute that ends now, and a view whose thread does not run.
    fn viewed() -> (ViewerState, Hub, Driver, Vec<ViewerInput>) {
        let text = include_str!("../../../../../config/scenarios/crossing.toml")
            .replace("duration_s = 300", "duration_s = 30");
        let start = crate::live::now() + SignedDuration::from_secs(-30);
        let flight = simulate(&Scenario::parse(&text, "crossing.toml").unwrap(), 1, Some(start)).unwrap();
        let config = Arc::new(flight.config);
        let mut driver = Driver::new(&config, Masks::default(), start, 2);
        let mut slots = Vec::new();
        for datagram in &flight.datagrams {
            driver.receive(&input::capture::Reception {
                received: Some(datagram.received),
                input: 0,
                from: None,
                kind: input::capture::ReceptionKind::Datagram,
                origin: 0,
                payload: datagram.payload.clone(),
            });
            while let Some(made) = driver.poll() {
                if let DriverEvent::Slot(frame) = made {
                    let now = frame.now.get().map(|now| Box::new(Picture::clone(&now)));
                    slots.push(ViewerInput::Slot(frame.picture.into(), now));
                }
            }
        }
        let (writer, hub) = Hub::new(config.clone(), Arc::new(driver.maker().clone()), start);
        let (sinks, encoders) = (UdpDestinations::open(&[]).unwrap(), Encoders::new(&config));
        let outlets = Outlets { hub: writer, sinks, encoders, recorder: None, keepers: None };
        let view = ViewerState::new(&config, &driver, outlets, &WallClock::default(), None, None);
        (view, hub, driver, slots)
    }

    fn told(driver: &mut Driver, at: Time) -> ViewerInput {
        let status = Status {
            at,
            sensors: driver.sensors(at, |_| Vec::new()),
            unknown: Vec::new(),
            tally: driver.pipeline().tally().clone(),
            numbers_used: 0,
            lateness_s: None,
            failed_sends: 0,
            troubles: Vec::new(),
        };
        ViewerInput::Status(status.into(), Box::default(), Vec::new())
    }

    #[test]
    fn slot_is_shown_once_and_missing_ones_are_reported() {
        let (mut view, hub, mut driver, slots) = viewed();
        let at = view.publisher.clock.now();
        let mut slots = slots.into_iter();
        let again = |input: &ViewerInput| match input {
            ViewerInput::Slot(picture, _) => ViewerInput::Slot(picture.clone(), None),
            _ => unreachable!("all are slots"),
        };
        let first = slots.next().unwrap();
        let copy = again(&first);
        view.handle(first);
        view.handle(copy);
        // Two that are never received.
        let _ = (slots.next(), slots.next());
        view.handle(slots.next().unwrap());
        view.publisher.publish_pending();
        view.handle(told(&mut driver, at));
        view.handle(ViewerInput::Members(
            ClusterMembers {
                cells: vec![CellState { cell: "all".into(), ..CellState::default() }],
                ..ClusterMembers::default()
            }
            .into(),
        ));
        view.publish_status(at);
        assert_eq!(hub.latest().unwrap().seq, 2, "two slots are shown");
        let members = hub.members().unwrap();
        assert_eq!((members.shown, members.doubled, members.missing), (2, 1, 2));
        let status = hub.status().unwrap();
        assert!(status.troubles.iter().any(|trouble| trouble.text == "2 slots were published by nobody"));
        // Seconds later, the losses are past.
        let later = at + SignedDuration::from_secs(9);
        view.handle(told(&mut driver, later));
        view.publish_status(later);
        assert!(hub.status().unwrap().troubles.is_empty());
    }

    /// Decisions are sent to the cells with the first slot that they affect, and refused while no cell is received.
    #[tokio::test]
    async fn decisions_are_sent_to_the_cells() {
        let (mut view, hub, mut driver, slots) = viewed();
        let (sender, mut decided) = crate::live::decisions();
        view.forwarder = DecisionForwarder::new(&hub.config, Some(sender));
        let at = view.publisher.clock.now();
        let says = |serial: &str| TrustRequest {
            transponder: TransponderName { serial: serial.to_owned(), country: None },
            trust: Trust::Distrusted,
        };
        let mut last = None;
        for slot in slots {
            if let ViewerInput::Slot(picture, _) = &slot {
                last = Some(picture.clone());
            }
            view.handle(slot);
        }
        let last = last.unwrap();
        let identity =
            last.tracks.iter().find_map(|track| track.point.source.transponder()).unwrap().identity;
        let serial = picture::serial_text(identity);
        // No status received yet.
        let answer = hub.trust_requests.submit(says(&serial)).unwrap();
        view.forward_requests(at);
        assert_eq!(answer.await.unwrap().unwrap_err(), RequestError::Unheard);

        view.handle(told(&mut driver, at));
        let answer = hub.trust_requests.submit(says(&serial)).unwrap();
        let unknown = hub.trust_requests.submit(says("nobody")).unwrap();
        view.forward_requests(at);
        let held = answer.await.unwrap().unwrap();
        let OperatorDecision::SetTrust(from, word) = decided.try_recv().unwrap() else {
            panic!("another decision")
        };
        assert_eq!((word.identity, word.trust), (identity, Trust::Distrusted));
        assert!(from > last.slot && held.words.iter().any(|held| held.word == word && held.since == from));
        assert!(unknown.await.unwrap().is_err() && decided.try_recv().is_err());
        // Minutes later, without any further message.
        let answer = hub.trust_requests.submit(says(&serial)).unwrap();
        view.forward_requests(at + SignedDuration::from_secs(60));
        assert_eq!(answer.await.unwrap().unwrap_err(), RequestError::Unheard);
    }

    #[test]
    fn sensors_are_unknown_without_a_recent_status() {
        let (mut view, hub, mut driver, slots) = viewed();
        let at = view.publisher.clock.now();
        slots.into_iter().take(4).for_each(|slot| view.handle(slot));
        view.handle(told(&mut driver, at));
        view.publish_status(at);
        assert!(hub.status().unwrap().troubles.is_empty());
        view.publish_status(at + SignedDuration::from_secs(10));
        let status = hub.status().unwrap();
        assert!(status.sensors.iter().all(|sensor| sensor.state == SensorState::Outage));
        assert!(
            status.troubles[0].text.starts_with("nobody has said for 10 s how the sensors are"),
            "{status:?}"
        );
        assert!(hub.condition().level() > ServiceLevel::Ok);
    }
}
