//! A reader of the stream: a place in the log and nothing else, no task, no queue. Its next event is looked for when its
//! connection can take it, so one that does not read costs the others nothing, and is told to start again when it comes back.

use std::collections::{BTreeSet, HashSet, VecDeque};
use std::fmt;
use std::net::Ipv4Addr;
use std::pin::Pin;
use std::sync::Arc;

use axum::http::StatusCode;
use tokio::sync::watch;

use super::ask::Ask;
use super::client::Subscriber;
use super::endings::Endings;
use super::events::{self, Closed, Resync};
use super::filter::Filter;
use super::log::{Event, Next};
use super::payload::Payload;
use super::piece::Piece;
use super::problem::Problem;
use super::render::InFlight;
use super::seats::Seat;
use super::shown::Shown;
use super::state::ApiState;
use super::tokens::Pass;
use super::tracks::{filter, kind, picture, trail_s};
use crate::config::PictureKind;
use fusion::time::Time;

const INTERVAL: &str = "a whole number of milliseconds, 250 to 10000";

/// A snapshot that is made elsewhere; `None`: that failed.
struct Making(Pin<Box<dyn Future<Output = (Option<Payload>, InFlight)> + Send>>);

impl fmt::Debug for Making {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Making")
    }
}

#[derive(Debug)]
pub struct Reader {
    state: ApiState,
    kind: PictureKind,
    filter: Filter,
    /// How long the trails of a snapshot are.
    trail_s: Option<u32>,
    /// Shortest time between two `tracks` events; `None`: each slot.
    interval_ns: Option<i64>,
    /// Number of the last event that was looked at.
    place: u64,
    news: watch::Receiver<u64>,
    /// What was shown, where not everything is.
    endings: Endings,
    /// Slots that wait for their interval to end, what ended in them, and the time of the last slot that was sent.
    waiting: Vec<Arc<Shown>>,
    ended: BTreeSet<Arc<str>>,
    sent: Option<Time>,
    out: VecDeque<Payload>,
    prepare: fn(&Payload),
    /// The snapshot that is being made.
    making: Option<Making>,
    /// The one that was handed to the connection last, while it may not have been taken.
    in_flight: Option<InFlight>,
    client: Subscriber,
    closed: bool,
    /// Looked at again and again: a token may be withdrawn.
    pass: Pass,
    /// Given back when the connection ends.
    _seat: Seat,
}

impl Reader {
    /// What a request asks for, from the event `last` on where that is remembered.
    ///
    /// `prepare` makes the form of an expensive snapshot in which the connection takes it.
    ///
    /// # Errors
    /// 400 for a parameter that breaks its rule, 429 where too many are open, 503 while the service stops.
    pub fn open(ask: &Ask, last: Option<&str>, prepare: fn(&Payload)) -> Result<Self, Problem> {
        let (filter, kind, trail_s) = (filter(ask)?, kind(ask)?, trail_s(ask)?);
        let interval_ms = ask.query.value("interval_ms", INTERVAL, |ms: &i64| (250..=10_000).contains(ms))?;
        let state = ask.state.clone();
        if state.is_closing() {
            return Err(Problem::unavailable("the service stops", Vec::new()));
        }
        let seat = state.seats.take(ask.client).ok_or_else(|| {
            let detail = "too many streams are open, in all or from this address";
            Problem::new(StatusCode::TOO_MANY_REQUESTS, detail).retry_after_s(5)
        })?;
        let resume = last.and_then(|id| state.number_of(id));
        let mut reader = Self {
            news: state.log.watch(),
            place: 0,
            endings: Endings::default(),
            waiting: Vec::new(),
            ended: BTreeSet::new(),
            sent: None,
            out: VecDeque::new(),
            making: None,
            prepare,
            in_flight: None,
            client: Subscriber::at(ask.client.unwrap_or(Ipv4Addr::UNSPECIFIED.into())),
            closed: false,
            interval_ns: interval_ms.map(|ms| ms * 1_000_000),
            state,
            kind,
            filter,
            pass: ask.pass,
            trail_s,
            _seat: seat,
        };
        match resume.filter(|&place| !matches!(reader.state.log.after(place), Next::Forgotten)) {
            Some(place) => {
                reader.place = place;
                for slot in reader.state.log.slots_until(place) {
                    let Some(shown) = slot.of(kind) else { continue };
                    reader.sent = Some(shown.time());
                    let ended = reader.note(&shown);
                    // The connection may have ended within an interval: better twice than never.
                    if reader.interval_ns.is_some() {
                        reader.hold(shown, ended);
                    }
                }
            }
            None => reader.begin(),
        }
        Ok(reader)
    }

    /// Everything as it is now.
    fn begin(&mut self) {
        let (last, latest) = self.state.log.latest();
        let latest = latest.and_then(|shown| shown.of(self.kind));
        self.place = last;
        self.endings = Endings::default();
        self.waiting.clear();
        self.ended.clear();
        if let Some(shown) = &latest {
            self.sent = Some(shown.time());
            self.note(shown);
        }
        let (state, kind, filter, trail_s) =
            (self.state.clone(), self.kind, self.filter.clone(), self.trail_s);
        if trail_s.is_none() {
            let collection = picture(&state, (latest.as_deref(), kind), &filter, trail_s);
            return self.push(events::SNAPSHOT, &collection.plain());
        }
        let (client, id, prepare) = (self.client, state.event_id(self.place), self.prepare);
        self.making = Some(Making(Box::pin(async move {
            let in_flight = state.renderer.turn(client).await;
            let of = state.clone();
            let make = move || {
                let collection = picture(&of, (latest.as_deref(), kind), &filter, trail_s);
                let snapshot = Payload::from(events::written(&id, events::SNAPSHOT, &collection.plain()));
                prepare(&snapshot);
                snapshot
            };
            (state.renderer.expensive(&in_flight, make).await.ok(), in_flight)
        })));
    }

    /// The next event; `None` at the end. Nothing is lost where it is not waited for.
    pub async fn next(&mut self) -> Option<Payload> {
        loop {
            if let Some(event) = self.out.pop_front() {
                return Some(event);
            }
            // The connection asks for more, so it has taken the snapshot.
            self.in_flight = None;
            if let Some(Making(making)) = &mut self.making {
                // It stays where it is while this is not waited for.
                let (snapshot, in_flight) = making.await;
                self.making = None;
                // Without it the stream makes no sense.
                self.out.push_back(snapshot?);
                self.in_flight = Some(in_flight);
                return self.out.pop_front();
            }
            if self.closed {
                return None;
            }
            if !self.state.terms().may_stream(self.pass) {
                let id = self.state.event_id(self.place);
                self.out.push_back(events::event(&id, &Closed { reason: "the token is no longer known" }));
                self.closed = true;
                continue;
            }
            self.news.borrow_and_update();
            match self.state.log.after(self.place) {
                Next::Event(event) => {
                    self.place += 1;
                    self.take(event);
                }
                Next::Nothing => self.news.changed().await.ok()?,
                Next::Forgotten => self.resync("this connection was too slow; what it missed is forgotten"),
            }
        }
    }

    fn take(&mut self, event: Event) {
        match event {
            Event::Slot(shown) => self.slot(&shown),
            Event::Ended(octets) if self.is_plain() => self.out.push_back(octets),
            Event::Ended(_) => {}
            Event::Sensor(index, _) if !self.filter.wants_sensor(index) => {}
            Event::Told(octets) | Event::Sensor(_, octets) => self.out.push_back(octets),
            Event::Back(_) => self.resync("the replay went back"),
            Event::Lost => self.resync("the service was too slow; slots are missing"),
            Event::Closed(octets) => {
                self.flush();
                self.out.push_back(octets);
                self.closed = true;
            }
        }
    }

    /// Whether it gets the events as they are made for everybody.
    fn is_plain(&self) -> bool {
        self.kind == PictureKind::Lagged && self.filter.is_default() && self.interval_ns.is_none()
    }

    fn slot(&mut self, shown: &Arc<Shown>) {
        if self.is_plain() {
            return self.out.push_back(shown.event());
        }
        let Some(shown) = shown.of(self.kind) else { return };
        let time = shown.time();
        let ended = self.note(&shown);
        self.hold(shown, ended);
        let is_due = |sent: Time| time.nanos() - sent.nanos() >= self.interval_ns.unwrap_or(0);
        if self.sent.is_none_or(is_due) {
            self.flush();
        }
    }

    /// Keeps a slot until its interval ends.
    fn hold(&mut self, shown: Arc<Shown>, ended: Vec<Arc<str>>) {
        self.ended.extend(ended);
        // What is there again has not ended.
        self.ended.retain(|id| !self.endings.is_shown(id));
        self.waiting.push(shown);
    }

    /// Sends what waits: each track that changed as it was last, then those that ended.
    fn flush(&mut self) {
        let Some(newest) = self.waiting.last().cloned() else { return };
        self.sent = Some(newest.time());
        let waiting = std::mem::take(&mut self.waiting);
        let mut told = HashSet::new();
        let changes = waiting.iter().rev().flat_map(|shown| shown.new_ones());
        let latest = changes.filter(|(_, piece)| told.insert(&*piece.id));
        let collection = newest.join(latest, &self.filter);
        self.push(events::TRACKS, &collection);
        let ended: Vec<_> = std::mem::take(&mut self.ended).into_iter().collect();
        if !ended.is_empty() {
            let id = self.state.event_id(self.place);
            self.out.push_back(events::ended(&id, newest.time(), &ended));
        }
    }

    fn resync(&mut self, reason: &str) {
        let id = self.state.event_id(self.state.log.latest().0);
        self.out.push_back(events::event(&id, &Resync { reason }));
        self.begin();
    }

    /// Where it does not get what is made for everybody, what ended is found out by itself.
    fn note(&mut self, shown: &Shown) -> Vec<Arc<str>> {
        if self.is_plain() {
            return Vec::new();
        }
        let wanted = |piece: &&Piece| self.filter.wants(piece);
        self.endings.note(shown.time(), shown.pieces.iter().filter(wanted))
    }

    fn push(&mut self, name: &str, data: &[u8]) {
        let octets = events::written(&self.state.event_id(self.place), name, data);
        self.out.push_back(octets.into());
    }
}
