//! A reader of the stream: a position in the log, without a task or a queue. Its next event is looked up when its connection can
//! take it. A client that does not read costs the others nothing; when it reads again, it gets a resync event and a snapshot.

use std::collections::{BTreeSet, HashSet, VecDeque};
use std::fmt;
use std::net::Ipv4Addr;
use std::pin::Pin;
use std::sync::Arc;

use axum::http::StatusCode;
use tokio::sync::watch;

use super::client::Subscriber;
use super::endings::Endings;
use super::event_log::{NextEvent, StreamEvent};
use super::event_text;
use super::events::{self, Closed, Resync};
use super::filter::TrackFilter;
use super::payload::Payload;
use super::problem::Problem;
use super::render::InFlight;
use super::request::ApiRequest;
use super::slot_json::SlotJson;
use super::state::ApiState;
use super::stream_limit::CountedStream;
use super::tokens::Credential;
use super::track_slice::TrackSlice;
use super::tracks::{filter, kind, picture, trail_s};
use fusion::time::Time;
use site::config::PictureKind;

const INTERVAL: &str = "a whole number of milliseconds, 250 to 10000";

/// A snapshot that is made on another thread; `None` if that failed.
struct PendingSnapshot(Pin<Box<dyn Future<Output = (Option<Payload>, InFlight)> + Send>>);

impl fmt::Debug for PendingSnapshot {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Making")
    }
}

#[derive(Debug)]
pub struct EventStream {
    state: ApiState,
    kind: PictureKind,
    filter: TrackFilter,
    /// Length of the trails in a snapshot, in seconds.
    trail_s: Option<u32>,
    /// Minimum time between two `tracks` events; `None` means every slot.
    interval_ns: Option<i64>,
    /// Number of the last event processed.
    position: u64,
    news: watch::Receiver<u64>,
    /// Tracks shown to this reader, if it has a filter.
    endings: Endings,
    /// Slots waiting for the end of their interval.
    waiting: Vec<Arc<SlotJson>>,
    /// Tracks that ended in the waiting slots.
    ended: BTreeSet<Arc<str>>,
    /// Time of the last slot sent.
    sent: Option<Time>,
    out: VecDeque<Payload>,
    prepare: fn(&Payload),
    /// Snapshot that is being made.
    pending: Option<PendingSnapshot>,
    /// Last snapshot handed to the connection, until it is taken.
    in_flight: Option<InFlight>,
    client: Subscriber,
    closed: bool,
    /// Token of the reader, checked repeatedly because it may be revoked.
    credential: Credential,
    /// Counts the stream until the connection ends.
    _stream: CountedStream,
}

impl EventStream {
    /// Opens a stream by the parameters of a request. It starts after event `last` if that is still kept.
    ///
    /// `prepare` makes the encoding of an expensive snapshot that the connection needs.
    ///
    /// # Errors
    /// 400 if a parameter breaks its rule, 429 if too many streams are open, 503 while the service stops.
    pub fn open(request: &ApiRequest, last: Option<&str>, prepare: fn(&Payload)) -> Result<Self, Problem> {
        let (filter, kind, trail_s) = (filter(request)?, kind(request)?, trail_s(request)?);
        let interval_ms =
            request.query.value("interval_ms", INTERVAL, |ms: &i64| (250..=10_000).contains(ms))?;
        let state = request.state.clone();
        if state.is_closing() {
            return Err(Problem::unavailable("the service stops", Vec::new()));
        }
        let stream = state.stream_limit.admit(request.client).ok_or_else(|| {
            let detail = "too many streams are open, in all or from this address";
            Problem::new(StatusCode::TOO_MANY_REQUESTS, detail).retry_after_s(5)
        })?;
        let resume = last.and_then(|id| state.number_of(id));
        let mut reader = Self {
            news: state.log.watch(),
            position: 0,
            endings: Endings::default(),
            waiting: Vec::new(),
            ended: BTreeSet::new(),
            sent: None,
            out: VecDeque::new(),
            pending: None,
            prepare,
            in_flight: None,
            client: Subscriber::at(request.client.unwrap_or(Ipv4Addr::UNSPECIFIED.into())),
            closed: false,
            interval_ns: interval_ms.map(|ms| ms * 1_000_000),
            state,
            kind,
            filter,
            credential: request.credential,
            trail_s,
            _stream: stream,
        };
        match resume.filter(|&position| !matches!(reader.state.log.after(position), NextEvent::Forgotten)) {
            Some(position) => {
                reader.position = position;
                for slot in reader.state.log.slots_until(position) {
                    let Some(slot) = slot.of(kind) else { continue };
                    reader.sent = Some(slot.time());
                    let ended = reader.note(&slot);
                    // The connection may have ended within an interval. Tracks are rather sent twice than never.
                    if reader.interval_ns.is_some() {
                        reader.hold(slot, ended);
                    }
                }
            }
            None => reader.begin(),
        }
        Ok(reader)
    }

    /// Starts with the current picture.
    fn begin(&mut self) {
        let (last, latest) = self.state.log.latest();
        let latest = latest.and_then(|slot| slot.of(self.kind));
        self.position = last;
        self.endings = Endings::default();
        self.waiting.clear();
        self.ended.clear();
        if let Some(slot) = &latest {
            self.sent = Some(slot.time());
            self.note(slot);
        }
        let (state, kind, filter, trail_s) =
            (self.state.clone(), self.kind, self.filter.clone(), self.trail_s);
        if trail_s.is_none() {
            let collection = picture(&state, (latest.as_deref(), kind), &filter, trail_s);
            return self.push(events::SNAPSHOT, &collection.plain());
        }
        let (client, id, prepare) = (self.client, state.event_id(self.position), self.prepare);
        self.pending = Some(PendingSnapshot(Box::pin(async move {
            let in_flight = state.renderer.turn(client).await;
            let of = state.clone();
            let make = move || {
                let collection = picture(&of, (latest.as_deref(), kind), &filter, trail_s);
                let snapshot = Payload::from(event_text::written(&id, events::SNAPSHOT, &collection.plain()));
                prepare(&snapshot);
                snapshot
            };
            (state.renderer.expensive(&in_flight, make).await.ok(), in_flight)
        })));
    }

    /// The next event; `None` at the end. Cancelling the wait loses nothing.
    pub async fn next(&mut self) -> Option<Payload> {
        loop {
            if let Some(event) = self.out.pop_front() {
                return Some(event);
            }
            // The connection asks for more, so it has taken the snapshot.
            self.in_flight = None;
            if let Some(PendingSnapshot(pending)) = &mut self.pending {
                // The snapshot stays in place if the wait is cancelled.
                let (snapshot, in_flight) = pending.await;
                self.pending = None;
                // The stream is useless without its snapshot.
                self.out.push_back(snapshot?);
                self.in_flight = Some(in_flight);
                return self.out.pop_front();
            }
            if self.closed {
                return None;
            }
            if !self.state.access().may_stream(self.credential) {
                let id = self.state.event_id(self.position);
                self.out.push_back(events::event(&id, &Closed { reason: "the token is no longer known" }));
                self.closed = true;
                continue;
            }
            self.news.borrow_and_update();
            match self.state.log.after(self.position) {
                NextEvent::Event(event) => {
                    self.position += 1;
                    self.take(event);
                }
                NextEvent::Nothing => self.news.changed().await.ok()?,
                NextEvent::Forgotten => {
                    self.resync("this connection was too slow; what it missed is forgotten");
                }
            }
        }
    }

    fn take(&mut self, event: StreamEvent) {
        match event {
            StreamEvent::Slot(slot) => self.slot(&slot),
            StreamEvent::Ended(octets) if self.is_plain() => self.out.push_back(octets),
            StreamEvent::Ended(_) => {}
            StreamEvent::Sensor(index, _) if !self.filter.wants_sensor(index) => {}
            StreamEvent::Broadcast(octets) | StreamEvent::Sensor(_, octets) => self.out.push_back(octets),
            StreamEvent::Back(_) => self.resync("the replay went back"),
            StreamEvent::Lost => self.resync("the service was too slow; slots are missing"),
            StreamEvent::Closed(octets) => {
                self.flush();
                self.out.push_back(octets);
                self.closed = true;
            }
        }
    }

    /// Whether the reader receives the events made for all readers.
    fn is_plain(&self) -> bool {
        self.kind == PictureKind::Lagged && self.filter.is_default() && self.interval_ns.is_none()
    }

    fn slot(&mut self, slot: &Arc<SlotJson>) {
        if self.is_plain() {
            return self.out.push_back(slot.event());
        }
        let Some(slot) = slot.of(self.kind) else { return };
        let time = slot.time();
        let ended = self.note(&slot);
        self.hold(slot, ended);
        let is_due = |sent: Time| time.nanos() - sent.nanos() >= self.interval_ns.unwrap_or(0);
        if self.sent.is_none_or(is_due) {
            self.flush();
        }
    }

    /// Keeps a slot until its interval ends.
    fn hold(&mut self, slot: Arc<SlotJson>, ended: Vec<Arc<str>>) {
        self.ended.extend(ended);
        // A track that is shown again has not ended.
        self.ended.retain(|id| !self.endings.is_shown(id));
        self.waiting.push(slot);
    }

    /// Sends the waiting slots: the latest state of each changed track, then the ended tracks.
    fn flush(&mut self) {
        let Some(newest) = self.waiting.last().cloned() else { return };
        self.sent = Some(newest.time());
        let waiting = std::mem::take(&mut self.waiting);
        let mut published = HashSet::new();
        let changes = waiting.iter().rev().flat_map(|slot| slot.changed_tracks());
        let latest = changes.filter(|(_, slice)| published.insert(&*slice.id));
        let collection = newest.join(latest, &self.filter);
        self.push(events::TRACKS, &collection);
        let ended: Vec<_> = std::mem::take(&mut self.ended).into_iter().collect();
        if !ended.is_empty() {
            let id = self.state.event_id(self.position);
            self.out.push_back(events::ended(&id, newest.time(), &ended));
        }
    }

    fn resync(&mut self, reason: &str) {
        let id = self.state.event_id(self.state.log.latest().0);
        self.out.push_back(events::event(&id, &Resync { reason }));
        self.begin();
    }

    /// Tracks that ended for a reader with its own filter.
    fn note(&mut self, slot: &SlotJson) -> Vec<Arc<str>> {
        if self.is_plain() {
            return Vec::new();
        }
        let wanted = |slice: &&TrackSlice| self.filter.wants(slice);
        self.endings.note(slot.time(), slot.slices.iter().filter(wanted))
    }

    fn push(&mut self, name: &str, data: &[u8]) {
        let octets = event_text::written(&self.state.event_id(self.position), name, data);
        self.out.push_back(octets.into());
    }
}
