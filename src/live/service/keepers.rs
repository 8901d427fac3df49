//! State that the engine's thread hands to its keepers and to the recorder: decisions, transponder numbers, registration.
//! Nothing here waits: what does not fit a queue is handed on the next time.

use std::sync::Arc;
use std::sync::mpsc::TrySendError;

use tracing::{error_span, info, warn};

use super::{Engine, Estimates};
use crate::config::Config;
use crate::record::Recorded;
use crate::state::{Registrations, correlation_line, kept_lines, registration_text, word_line};
use fusion::integrity::HeldWord;
use fusion::numbering::NumberChange;
use fusion::operational::{Correlation, HeldCorrelation, ResumedCorrelation};
use fusion::time::Time;

/// Shortest time between two hand-overs of the registration.
const REGISTRATION: jiff::SignedDuration = jiff::SignedDuration::from_secs(10);
/// Most items about decisions that wait for the recorder; more are lost.
const UNRECORDED: usize = 1024;

/// What operators have decided and is in force.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct InForce {
    correlations: Vec<HeldCorrelation>,
    words: Vec<HeldWord>,
    /// The lines of the alerts that are shelved.
    shelves: Arc<str>,
}

impl InForce {
    fn of(engine: &fusion::Engine, shelves: Arc<str>) -> Self {
        Self { correlations: engine.correlations(), words: engine.words(), shelves }
    }

    fn lines(&self, config: &Config) -> String {
        let pairs =
            self.correlations.iter().map(|held| correlation_line(held.since, &held.correlation, config));
        let words = self.words.iter().map(|held| word_line(held.since, &held.word, config));
        pairs.chain(words).chain([self.shelves.to_string()]).collect()
    }
}

impl Engine {
    /// Carries out operators' decisions.
    pub(super) fn decide(&mut self) {
        for (slot, correlation) in self.publisher.outlets.hub.correlations.obey(&mut self.driver) {
            let line = correlation_line(slot, &correlation, &self.config).into();
            self.unrecorded.push_back(Recorded::Decided(line));
        }
        for (slot, word) in self.publisher.outlets.hub.integrity.obey(&mut self.driver) {
            let line = word_line(slot, &word, &self.config).into();
            self.unrecorded.push_back(Recorded::Decided(line));
        }
        self.unrecorded.extend(self.publisher.outlets.hub.alerts.lines().map(Recorded::Decided));
        self.tell_decisions();
    }

    /// Hands on which decisions are in force, where that has changed, and logs what became of those of before a restart.
    pub(super) fn tell_decisions(&mut self) {
        for resumed in self.driver.engine_mut().resumed() {
            let (ResumedCorrelation::Holds(held) | ResumedCorrelation::Ended(held)) = resumed;
            let Correlation { radar, transponder, verdict } = held.correlation;
            let sensor = self.config.sensors.get(usize::from(radar.sensor.0)).map_or("", |sensor| &sensor.id);
            let transponder = transponder.name().escape_ascii().to_string();
            let (track, verdict) = (radar.number, verdict.name());
            error_span!("decision", sensor, track, transponder, verdict).in_scope(|| match resumed {
                ResumedCorrelation::Holds(_) => info!("decision holds again after the restart"),
                ResumedCorrelation::Ended(_) => {
                    warn!("decision ended with the restart: the radar did not see the track again in time");
                }
            });
        }
        let held = InForce::of(self.driver.pipeline().engine(), self.publisher.outlets.hub.alerts.shelves());
        if held != self.held {
            self.unrecorded.push_back(Recorded::Correlations(held.lines(&self.config).into()));
            self.publisher.outlets.hub.correlations.tell(&held.correlations);
            self.held = held;
            // No restart forgets what an operator has decided.
            self.next_checkpoint = Time::default();
        }
        self.publisher.outlets.hub.integrity.tell(&self.driver);
        while let Some(next) = self.unrecorded.front() {
            let has_room = self
                .publisher
                .outlets
                .recorder
                .as_ref()
                .is_none_or(|recorder| recorder.has_room_for(next.clone()));
            if !has_room && self.unrecorded.len() <= UNRECORDED {
                break;
            }
            self.unrecorded.pop_front();
        }
    }

    /// Hands the decisions to their keeper; where there is no room, the next time.
    pub(super) fn keep_decisions(&mut self) {
        let Some(keepers) = &self.publisher.outlets.keepers else { return };
        if let Some(text) = self.new_decisions()
            && keepers.decisions.try_send(text.clone()).is_ok()
        {
            self.kept = text;
        }
        if let Some(text) = self.new_shelves()
            && keepers.shelved.try_send(text.clone()).is_ok()
        {
            self.kept_shelves = text;
        }
    }

    /// The text of the file of shelved alerts, where it has changed.
    pub(super) fn new_shelves(&self) -> Option<Arc<str>> {
        let text = self.publisher.outlets.hub.alerts.shelves();
        (*text != *self.kept_shelves).then_some(text)
    }

    /// The text of the decisions' file, where it has changed.
    pub(super) fn new_decisions(&self) -> Option<Arc<str>> {
        let engine = self.driver.pipeline().engine();
        // Before the first report nothing is new.
        engine.next_slot()?;
        let text = kept_lines(&engine.kept(), &engine.words(), &self.config);
        (*text != *self.kept).then(|| text.into())
    }

    /// Notes a transponder number that was used or went back, for its keeper and the recorder.
    pub(super) fn note_number(&mut self, change: NumberChange) {
        let number = change.given().number;
        if self.publisher.outlets.keepers.is_some() {
            self.unkept.insert(number, change);
        }
        if self.publisher.outlets.recorder.is_some() {
            self.unrecorded_numbers.insert(number, change);
        }
    }

    /// Hands on the changes of transponder numbers; what does not fit the queues waits for the next time.
    pub(super) fn tell_numbers(&mut self) {
        if let Some(keepers) = &self.publisher.outlets.keepers {
            while let Some((&number, &change)) = self.unkept.first_key_value() {
                // A keeper that has ended has said so.
                if let Err(TrySendError::Full(_)) = keepers.numbers.try_send(change) {
                    break;
                }
                self.unkept.remove(&number);
            }
        }
        if let Some(recorder) = &self.publisher.outlets.recorder {
            while let Some((&number, &change)) = self.unrecorded_numbers.first_key_value() {
                // One that went back is no matter of the recording: a file begins with those in flight.
                if let NumberChange::Heard(given) = change
                    && !recorder.has_room_for(Recorded::Numbered(given))
                {
                    break;
                }
                self.unrecorded_numbers.remove(&number);
            }
        }
    }

    /// Hands on the registration where it has changed; where there is no room for it, the next time.
    pub(super) fn tell_registration(&mut self, at: Time) {
        let is_due = at >= self.next_registration || self.next_registration - at > REGISTRATION;
        if !is_due {
            return;
        }
        self.next_registration = at + REGISTRATION;
        let Some((registered, text)) = self.new_registration() else { return };
        let keepers = self.publisher.outlets.keepers.as_ref();
        let kept = keepers.is_none_or(|keepers| keepers.registration.try_send(text.clone()).is_ok());
        let recorder = self.publisher.outlets.recorder.as_ref();
        if kept && recorder.is_none_or(|recorder| recorder.has_room_for(Recorded::Registered(text))) {
            self.registered = registered;
        }
    }

    /// The registration, and the text of its file, where it is not what was handed on.
    pub(super) fn new_registration(&self) -> Option<(Estimates, Arc<str>)> {
        let engine = self.driver.pipeline().engine();
        let now = Estimates::of(engine);
        (now != self.registered).then(|| {
            let text = registration_text(&Registrations::of(&self.config, engine));
            (now, text.into())
        })
    }
}
