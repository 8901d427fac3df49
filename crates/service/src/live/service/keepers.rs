//! State that the engine's thread passes to keepers and recorder: decisions, transponder numbers, registration. Nothing
//! here waits: data that does not fit into a queue is passed on the next time.

use std::sync::Arc;
use std::sync::mpsc::TrySendError;

use tracing::{error_span, info, warn};

use super::{EngineThread, Estimates};
use crate::record::RecordingItem;
use crate::state::{
    SavedRegistrations, correlation_line, kept_lines, registration_text, relocation_line, relocation_lines,
    word_line,
};
use fusion::integrity::ActiveOverride;
use fusion::numbering::NumberChange;
use fusion::operational::{ActiveAssociation, ActiveRelocation, ManualAssociation, RestoredAssociation};
use fusion::time::Time;
use site::config::Config;

/// Minimum time between two transfers of the registration.
const REGISTRATION: jiff::SignedDuration = jiff::SignedDuration::from_secs(10);
/// Maximum number of entries about decisions waiting for the recorder; further ones are lost.
const UNRECORDED: usize = 1024;

/// Operators' decisions in force.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct DecisionsInForce {
    correlations: Vec<ActiveAssociation>,
    words: Vec<ActiveOverride>,
    relocations: Vec<ActiveRelocation>,
    /// Lines of the shelved alerts.
    shelves: Arc<str>,
}

impl DecisionsInForce {
    fn of(engine: &fusion::Engine, shelves: Arc<str>) -> Self {
        Self {
            correlations: engine.correlations(),
            words: engine.trust_overrides(),
            relocations: engine.relocations(),
            shelves,
        }
    }

    fn lines(&self, config: &Config) -> String {
        let pairs =
            self.correlations.iter().map(|held| correlation_line(held.since, &held.correlation, config));
        let words = self.words.iter().map(|held| word_line(held.since, &held.word, config));
        let relocations = relocation_lines(&self.relocations, config);
        pairs.chain(words).chain([relocations, self.shelves.to_string()]).collect()
    }
}

impl EngineThread {
    /// Carries out operators' decisions.
    pub(super) fn carry_out_requests(&mut self) {
        for (slot, correlation) in
            self.publisher.outlets.hub.correlation_requests.carry_out_all(&mut self.driver)
        {
            let line = correlation_line(slot, &correlation, &self.config).into();
            self.unrecorded.push_back(RecordingItem::Decided(line));
        }
        for (slot, word) in self.publisher.outlets.hub.trust_requests.carry_out_all(&mut self.driver) {
            let line = word_line(slot, &word, &self.config).into();
            self.unrecorded.push_back(RecordingItem::Decided(line));
        }
        for (slot, decided) in self.publisher.outlets.hub.relocation_requests.carry_out_all(&mut self.driver)
        {
            let line = relocation_line(slot, &decided, &self.config).into();
            self.unrecorded.push_back(RecordingItem::Decided(line));
        }
        self.unrecorded.extend(self.publisher.outlets.hub.alert_records.lines().map(RecordingItem::Decided));
        self.publish_decisions();
    }

    /// Publishes and records the decisions in force if they have changed, and logs what became of those from before a
    /// restart.
    pub(super) fn publish_decisions(&mut self) {
        for resumed in self.driver.engine_mut().resumed() {
            let (RestoredAssociation::Holds(held) | RestoredAssociation::Ended(held)) = resumed;
            let ManualAssociation { radar, transponder, verdict } = held.correlation;
            let sensor = self.config.sensors.get(usize::from(radar.sensor.0)).map_or("", |sensor| &sensor.id);
            let transponder = transponder.name().escape_ascii().to_string();
            let (track, verdict) = (radar.number, verdict.name());
            error_span!("decision", sensor, track, transponder, verdict).in_scope(|| match resumed {
                RestoredAssociation::Holds(_) => info!("decision holds again after the restart"),
                RestoredAssociation::Ended(_) => {
                    warn!("decision ended with the restart: the radar did not see the track again in time");
                }
            });
        }
        let held = DecisionsInForce::of(
            self.driver.pipeline().engine(),
            self.publisher.outlets.hub.alert_records.shelves(),
        );
        if held != self.in_force {
            self.unrecorded.push_back(RecordingItem::Correlations(held.lines(&self.config).into()));
            self.publisher.outlets.hub.correlation_requests.publish_if_changed(&held.correlations);
            self.publisher.outlets.hub.relocation_requests.publish_if_changed(&held.relocations);
            self.in_force = held;
            // Written at once, so that no decision is lost by a restart.
            self.next_checkpoint = Time::default();
        }
        self.publisher.outlets.hub.trust_requests.publish_if_changed(&self.driver);
        while let Some(next) = self.unrecorded.front() {
            let is_added = self
                .publisher
                .outlets
                .recorder
                .as_ref()
                .is_none_or(|recorder| recorder.try_add(next.clone()));
            if !is_added && self.unrecorded.len() <= UNRECORDED {
                break;
            }
            self.unrecorded.pop_front();
        }
    }

    /// Passes the decisions to their keeper; if its queue is full, the next time.
    pub(super) fn save_decisions(&mut self) {
        let Some(keepers) = &self.publisher.outlets.keepers else { return };
        if let Some(text) = self.new_decisions()
            && keepers.decisions.try_send(text.clone()).is_ok()
        {
            self.saved_decisions = text;
        }
        if let Some(text) = self.new_shelves()
            && keepers.shelved.try_send(text.clone()).is_ok()
        {
            self.saved_shelves = text;
        }
    }

    /// Text of the file of shelved alerts, if it has changed.
    pub(super) fn new_shelves(&self) -> Option<Arc<str>> {
        let text = self.publisher.outlets.hub.alert_records.shelves();
        (*text != *self.saved_shelves).then_some(text)
    }

    /// Text of the decisions' file, if it has changed.
    pub(super) fn new_decisions(&self) -> Option<Arc<str>> {
        let engine = self.driver.pipeline().engine();
        // Before the first report nothing has changed.
        engine.next_slot()?;
        let relocations = engine.relocations();
        let text = kept_lines(&engine.saved_associations(), &engine.trust_overrides(), &self.config)
            + &relocation_lines(&relocations, &self.config);
        (*text != *self.saved_decisions).then(|| text.into())
    }

    /// Queues a change of a transponder number for keeper and recorder.
    pub(super) fn note_number(&mut self, change: NumberChange) {
        let number = change.given().number;
        if self.publisher.outlets.keepers.is_some() {
            self.unsaved_numbers.insert(number, change);
        }
        if self.publisher.outlets.recorder.is_some() {
            self.unrecorded_numbers.insert(number, change);
        }
    }

    /// Passes on the changes of transponder numbers; those that do not fit into the queues wait for the next time.
    pub(super) fn pass_on_numbers(&mut self) {
        if let Some(keepers) = &self.publisher.outlets.keepers {
            while let Some((&number, &change)) = self.unsaved_numbers.first_key_value() {
                // A keeper that has ended has logged the reason.
                if let Err(TrySendError::Full(_)) = keepers.numbers.try_send(change) {
                    break;
                }
                self.unsaved_numbers.remove(&number);
            }
        }
        if let Some(recorder) = &self.publisher.outlets.recorder {
            while let Some((&number, &change)) = self.unrecorded_numbers.first_key_value() {
                // A released number is not recorded: each file begins with those in use.
                if let NumberChange::Heard(given) = change
                    && !recorder.try_add(RecordingItem::Numbered(given))
                {
                    break;
                }
                self.unrecorded_numbers.remove(&number);
            }
        }
    }

    /// Passes on the registration if it has changed; if a queue is full, the next time.
    pub(super) fn pass_on_registration(&mut self, at: Time) {
        let is_due = at >= self.next_registration || self.next_registration - at > REGISTRATION;
        if !is_due {
            return;
        }
        self.next_registration = at + REGISTRATION;
        let Some((registered, text)) = self.new_registration() else { return };
        let keepers = self.publisher.outlets.keepers.as_ref();
        let kept = keepers.is_none_or(|keepers| keepers.registration.try_send(text.clone()).is_ok());
        let recorder = self.publisher.outlets.recorder.as_ref();
        if kept && recorder.is_none_or(|recorder| recorder.try_add(RecordingItem::Registered(text))) {
            self.registered = registered;
        }
    }

    /// Estimates and text of the registration's file, if they differ from those passed on last.
    pub(super) fn new_registration(&self) -> Option<(Estimates, Arc<str>)> {
        let engine = self.driver.pipeline().engine();
        let now = Estimates::of(engine);
        (now != self.registered).then(|| {
            let text = registration_text(&SavedRegistrations::of(&self.config, engine));
            (now, text.into())
        })
    }
}
