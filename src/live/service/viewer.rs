//! A picture that is made elsewhere: shown and sent here, as an engine's own is.

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

use super::decisions::{Decider, Decision};
use super::publication::Publisher;
use super::{LOOK_UP, Outlets};
use crate::config::Config;
use crate::live::alerts::{Severity, Trouble};
use crate::live::clock::Clock;
use crate::live::driver::Driver;
use crate::live::health::SensorState;
use crate::live::integrity::Integrities;
use crate::live::losses::Losses;
use crate::live::members::Members;
use crate::live::published::{PublishedPicture, Status};
use crate::picture::Picture;
use crate::pipeline::Tally;
use fusion::operational::HeldCorrelation;
use fusion::slots::Slot;
use fusion::time::{SECOND, Time};

/// Whoever makes the picture says each second how it is; after this time without a
/// word, longer than a take-over, its sensors are not known any more.
const UNHEARD: SignedDuration = SignedDuration::from_secs(8);

/// What comes from where the picture is made.
#[derive(Debug)]
pub enum Seen {
    /// A slot: the usual picture, and that of now where it is made.
    Slot(Box<Picture>, Option<Box<Picture>>),
    /// How the sensors are, and what the owner knows.
    Told(Box<Status>, Box<Integrities>, Vec<HeldCorrelation>),
    /// Who makes it.
    Members(Box<Members>),
    /// How far the clock of this machine is ahead of those of the members, where it is wrong: the picture is timed by theirs.
    Ahead(SignedDuration),
}

/// What was counted of the slots that came.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SeenCounts {
    /// Shown.
    pub shown: u64,
    /// Not shown because they, or later ones, had been shown.
    pub doubled: u64,
    /// That never came.
    pub missing: u64,
}

/// Who shows it.
pub struct Viewer {
    stop: Arc<AtomicBool>,
    thread: JoinHandle<Tally>,
}

impl Viewer {
    /// Begins to show what comes, on a thread of its own; what operators decide goes to whoever makes it. Alerts that are shelved
    /// are kept by `shelves`.
    ///
    /// # Errors
    /// The system gives no thread.
    pub fn start(
        config: &Config,
        driver: &Driver,
        outlets: Outlets,
        clock: &Clock,
        (seen, decided): (Receiver<Seen>, Option<Sender<Decision>>),
        shelves: Option<SyncSender<Arc<str>>>,
    ) -> io::Result<Self> {
        let stop = Arc::new(AtomicBool::new(false));
        let view = View::new(config, driver, outlets, clock, shelves, decided);
        let stopped = stop.clone();
        let thread = std::thread::Builder::new()
            .name("picture".to_owned())
            .spawn(move || view.run(&seen, &stopped))?;
        Ok(Self { stop, thread })
    }

    /// Whether its thread has ended by itself, which is a bug.
    pub fn has_ended(&self) -> bool {
        self.thread.is_finished()
    }

    /// Shows what has come, and ends; what was counted. Not on a thread of a runtime.
    ///
    /// # Errors
    /// The thread panicked.
    pub fn stop(self) -> Result<Tally, String> {
        self.stop.store(true, Ordering::Relaxed);
        self.thread.join().map_err(|_| "the picture's thread panicked; this is a bug".to_owned())
    }
}

struct View {
    publisher: Publisher,
    due_after: SignedDuration,
    lead: SignedDuration,
    /// The latest slot that was taken.
    last: Option<Slot>,
    seq: u64,
    counts: SeenCounts,
    told: Option<Status>,
    decider: Decider,
    /// What was wrong with the members when they were last heard of.
    troubles: (Time, Vec<Trouble>),
    misses: Losses,
    failed_told: u64,
    shelves: Option<SyncSender<Arc<str>>>,
    kept_shelves: Arc<str>,
    next_status: Time,
    /// By how much its clock is corrected.
    ahead: SignedDuration,
    /// Slots that came twice, until they are told.
    late: VecDeque<Slot>,
}

impl View {
    fn new(
        config: &Config,
        driver: &Driver,
        outlets: Outlets,
        clock: &Clock,
        shelves: Option<SyncSender<Arc<str>>>,
        decided: Option<Sender<Decision>>,
    ) -> Self {
        Self {
            publisher: Publisher::new(config, outlets, clock.clone()),
            due_after: config.fusion.latency() - config.fusion.slot / 2,
            lead: driver.lead(),
            last: None,
            seq: 0,
            counts: SeenCounts::default(),
            told: None,
            decider: Decider::new(config, decided),
            troubles: (clock.now(), Vec::new()),
            misses: Losses::default(),
            failed_told: 0,
            shelves,
            kept_shelves: "".into(),
            next_status: clock.now(),
            ahead: SignedDuration::ZERO,
            late: VecDeque::new(),
        }
    }

    fn run(mut self, seen: &Receiver<Seen>, stop: &AtomicBool) -> Tally {
        while !stop.load(Ordering::Relaxed) {
            match seen.recv_timeout(self.until_due()) {
                Ok(seen) => self.see(seen),
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => break,
            }
            let at = self.publisher.clock.now();
            self.decide(at);
            self.publisher.publish_due(at, self.lead);
            self.publisher.look_ahead();
            if at >= self.next_status || self.next_status.nanos() - at.nanos() > SECOND {
                self.next_status = Time::from_nanos((at.nanos() / SECOND + 1) * SECOND);
                self.tell(at);
            }
        }
        self.publisher.publish_owed();
        self.tell(self.publisher.clock.now());
        self.told.map(|told| told.tally).unwrap_or_default()
    }

    fn until_due(&self) -> Duration {
        let wait = self.publisher.next_due();
        let wait = wait.map(|due| Duration::try_from(due - self.publisher.clock.now()).unwrap_or_default());
        wait.map_or(LOOK_UP, |wait| wait.min(LOOK_UP))
    }

    fn see(&mut self, seen: Seen) {
        match seen {
            Seen::Slot(picture, now) => {
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
                self.decider.see(&picture);
                let due = picture.time + self.due_after;
                self.publisher.take(PublishedPicture {
                    seq: self.seq,
                    due,
                    published_at: due,
                    picture: *picture,
                    now: now.map(|now| *now).into(),
                });
            }
            Seen::Told(status, integrities, correlations) => {
                self.decider.hear(&correlations, &integrities);
                self.publisher.outlets.hub.integrity.show(&integrities);
                self.publisher.outlets.hub.correlations.tell(&correlations);
                self.told = Some(*status);
            }
            Seen::Members(members) => {
                self.troubles = (self.publisher.clock.now(), members.troubles());
                let SeenCounts { shown, doubled, missing } = self.counts;
                let members = Members { shown, doubled, missing, ..*members };
                self.publisher.outlets.hub.tell_members(members);
            }
            Seen::Ahead(ahead) => {
                self.publisher.clock.step(std::mem::replace(&mut self.ahead, ahead) - ahead);
            }
        }
    }

    /// What operators ask for goes to those who make the picture.
    fn decide(&mut self, at: Time) {
        let is_heard = self.told.as_ref().is_some_and(|told| at - told.at <= UNHEARD);
        let hub = &self.publisher.outlets.hub;
        self.decider.decide(&hub.correlations, &hub.integrity, is_heard);
    }

    /// The status each second, as it was told last.
    fn tell(&mut self, at: Time) {
        let hub = &self.publisher.outlets.hub;
        // The recorder of decisions is where the engine is; what is shelved is kept here.
        hub.alerts.lines().for_each(drop);
        let shelves = hub.alerts.shelves();
        if let Some(keeper) = &self.shelves
            && *shelves != *self.kept_shelves
            && keeper.try_send(shelves.clone()).is_ok()
        {
            self.kept_shelves = shelves;
        }
        for slot in self.late.drain(..) {
            warn!(slot = slot.0, "a slot came twice: shown once");
        }
        let Some(told) = &self.told else { return };
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
            let trouble = Trouble { about: Trouble::CLUSTER.into(), severity: Severity::Critical, text };
            status.troubles.push(trouble);
        }
        let (heard_of, troubles) = &self.troubles;
        if at - *heard_of <= UNHEARD {
            status.troubles.extend(troubles.iter().cloned());
        }
        if let Some(slots) = self.misses.going_on(self.counts.missing, at) {
            let text = format!("{slots} slots were published by nobody");
            status.troubles.push(Trouble {
                about: Trouble::CLUSTER.into(),
                severity: Severity::Warning,
                text,
            });
        }
        let failed = self.publisher.failed_sends - self.failed_told;
        self.failed_told = self.publisher.failed_sends;
        if failed > 0 {
            let text = format!("{failed} datagrams could not be sent in a second");
            status.troubles.push(Trouble {
                about: Trouble::OUTPUT.into(),
                severity: Severity::Critical,
                text,
            });
        }
        status.at = at;
        self.publisher.tell(status);
    }
}

#[cfg(test)]
mod tests {
    use fusion::integrity::Trust;

    use super::*;
    use crate::areas::Masks;
    use crate::formats::Encoders;
    use crate::live::requests::Denied;
    use crate::live::{CellState, Hub, Level, Made, Named, Saying};
    use crate::net::send::Sinks;
    use crate::simulate::{Scenario, simulate};

    /// The slots of a flight of half a minute that ends now, and a view that nobody runs.
    fn viewed() -> (View, Hub, Driver, Vec<Seen>) {
        let text = include_str!("../../../config/scenarios/crossing.toml")
            .replace("duration_s = 300", "duration_s = 30");
        let start = crate::live::now() + SignedDuration::from_secs(-30);
        let flight = simulate(&Scenario::parse(&text, "crossing.toml").unwrap(), 1, Some(start)).unwrap();
        let config = Arc::new(flight.config);
        let mut driver = Driver::new(&config, Masks::default(), start, 2);
        let mut slots = Vec::new();
        for datagram in &flight.datagrams {
            driver.receive(&crate::capture::Reception {
                received: Some(datagram.received),
                input: 0,
                from: None,
                kind: crate::capture::ReceptionKind::Datagram,
                origin: 0,
                payload: datagram.payload.clone(),
            });
            while let Some(made) = driver.poll() {
                if let Made::Slot(frame) = made {
                    let now = frame.now.get().map(|now| Box::new(Picture::clone(&now)));
                    slots.push(Seen::Slot(frame.picture.into(), now));
                }
            }
        }
        let (writer, hub) = Hub::new(config.clone(), Arc::new(driver.maker().clone()), start);
        let (sinks, encoders) = (Sinks::open(&[]).unwrap(), Encoders::new(&config));
        let outlets = Outlets { hub: writer, sinks, encoders, recorder: None, keepers: None };
        let view = View::new(&config, &driver, outlets, &Clock::default(), None, None);
        (view, hub, driver, slots)
    }

    fn told(driver: &mut Driver, at: Time) -> Seen {
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
        Seen::Told(status.into(), Box::default(), Vec::new())
    }

    #[test]
    fn a_slot_is_shown_once_and_what_nobody_published_is_said() {
        let (mut view, hub, mut driver, slots) = viewed();
        let at = view.publisher.clock.now();
        let mut slots = slots.into_iter();
        let again = |seen: &Seen| match seen {
            Seen::Slot(picture, _) => Seen::Slot(picture.clone(), None),
            _ => unreachable!("all are slots"),
        };
        let first = slots.next().unwrap();
        let copy = again(&first);
        view.see(first);
        view.see(copy);
        // Two that never come.
        let _ = (slots.next(), slots.next());
        view.see(slots.next().unwrap());
        view.publisher.publish_owed();
        view.see(told(&mut driver, at));
        view.see(Seen::Members(
            Members {
                cells: vec![CellState { cell: "all".into(), ..CellState::default() }],
                ..Members::default()
            }
            .into(),
        ));
        view.tell(at);
        assert_eq!(hub.latest().unwrap().seq, 2, "two slots are shown");
        let members = hub.members().unwrap();
        assert_eq!((members.shown, members.doubled, members.missing), (2, 1, 2));
        let status = hub.status().unwrap();
        assert!(status.troubles.iter().any(|trouble| trouble.text == "2 slots were published by nobody"));
        // Seconds later it is the past.
        let later = at + SignedDuration::from_secs(9);
        view.see(told(&mut driver, later));
        view.tell(later);
        assert!(hub.status().unwrap().troubles.is_empty());
    }

    /// What an operator decides goes to the cells, with the slot from which on it holds; and is refused while none is heard.
    #[tokio::test]
    async fn decisions_go_to_whoever_makes_the_picture() {
        let (mut view, hub, mut driver, slots) = viewed();
        let (sender, mut decided) = crate::live::decisions();
        view.decider = Decider::new(&hub.config, Some(sender));
        let at = view.publisher.clock.now();
        let says = |serial: &str| Saying {
            transponder: Named { serial: serial.to_owned(), country: None },
            trust: Trust::Distrusted,
        };
        let mut last = None;
        for slot in slots {
            if let Seen::Slot(picture, _) = &slot {
                last = Some(picture.clone());
            }
            view.see(slot);
        }
        let last = last.unwrap();
        let identity =
            last.tracks.iter().find_map(|track| track.point.source.transponder()).unwrap().identity;
        let serial = crate::picture::serial_text(identity);
        // Nobody has said yet how the sensors are.
        let answer = hub.integrity.ask(says(&serial)).unwrap();
        view.decide(at);
        assert_eq!(answer.await.unwrap().unwrap_err(), Denied::Unheard);

        view.see(told(&mut driver, at));
        let answer = hub.integrity.ask(says(&serial)).unwrap();
        let unknown = hub.integrity.ask(says("nobody")).unwrap();
        view.decide(at);
        let held = answer.await.unwrap().unwrap();
        let Decision::Say(from, word) = decided.try_recv().unwrap() else { panic!("another decision") };
        assert_eq!((word.identity, word.trust), (identity, Trust::Distrusted));
        assert!(from > last.slot && held.words.iter().any(|held| held.word == word && held.since == from));
        assert!(unknown.await.unwrap().is_err() && decided.try_recv().is_err());
        // And minutes later, when nobody is heard any more.
        let answer = hub.integrity.ask(says(&serial)).unwrap();
        view.decide(at + SignedDuration::from_secs(60));
        assert_eq!(answer.await.unwrap().unwrap_err(), Denied::Unheard);
    }

    #[test]
    fn sensors_are_not_known_while_nobody_says_how_they_are() {
        let (mut view, hub, mut driver, slots) = viewed();
        let at = view.publisher.clock.now();
        slots.into_iter().take(4).for_each(|slot| view.see(slot));
        view.see(told(&mut driver, at));
        view.tell(at);
        assert!(hub.status().unwrap().troubles.is_empty());
        view.tell(at + SignedDuration::from_secs(10));
        let status = hub.status().unwrap();
        assert!(status.sensors.iter().all(|sensor| sensor.state == SensorState::Outage));
        assert!(
            status.troubles[0].text.starts_with("nobody has said for 10 s how the sensors are"),
            "{status:?}"
        );
        assert!(hub.condition().level() > Level::Ok);
    }
}
