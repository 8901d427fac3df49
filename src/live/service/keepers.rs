//! What the engine's thread hands to those who keep it over a restart, and to the recorder: decisions of operators,
//! transponder numbers, registration. Nothing here waits: what does not fit a queue is handed on the next time.

use std::sync::Arc;
use std::sync::mpsc::TrySendError;

use tracing::{info, warn};

use super::{Engine, Estimates};
use crate::record::Recorded;
use crate::state::{Registrations, correlation_line, kept_lines, registration_text};
use fusion::numbering::NumberChange;
use fusion::operational::{Correlation, HeldCorrelation, ResumedCorrelation};
use fusion::time::Time;

/// The registration's keeper and the recorder hear of it at most this often.
const REGISTRATION: jiff::SignedDuration = jiff::SignedDuration::from_secs(10);
/// What the recorder could not be given yet of decisions; more than these are lost.
const UNRECORDED: usize = 1024;

impl Engine {
    /// Hands on which decisions are in force, where that has changed, and says which of before a restart are.
    pub(super) fn tell_decisions(&mut self) {
        for resumed in self.driver.resumed() {
            match resumed {
                ResumedCorrelation::Holds(held) => {
                    info!("{}: it holds again after the restart", self.describe(&held.correlation));
                }
                ResumedCorrelation::Ended(held) => warn!(
                    "{}: it ended with the restart, since the radar did not see the track again in time",
                    self.describe(&held.correlation)
                ),
            }
        }
        let held = self.driver.pipeline().engine().correlations();
        if held != self.held {
            let line = |held: &HeldCorrelation| correlation_line(held.since, &held.correlation, &self.config);
            let text: String = held.iter().map(line).collect();
            self.unrecorded.push_back(Recorded::Correlations { text: text.into() });
            self.outlets.hub.correlations.tell(held.clone());
            self.held = held;
        }
        while let Some(next) = self.unrecorded.front() {
            let has_room =
                self.outlets.recorder.as_ref().is_none_or(|recorder| recorder.has_room_for(next.clone()));
            if !has_room && self.unrecorded.len() <= UNRECORDED {
                break;
            }
            self.unrecorded.pop_front();
        }
    }

    /// A decision, for people.
    fn describe(&self, correlation: &Correlation) -> String {
        let Correlation { radar, transponder, verdict } = correlation;
        let sensor = self.config.sensors.get(usize::from(radar.sensor.0)).map_or("", |sensor| &sensor.id);
        let serial = transponder.serial().escape_ascii();
        format!("{sensor} track {} and transponder {serial}: {}", radar.number, verdict.name())
    }

    /// Hands on what a restart would have to know of decisions; where there is no room for it, the next time.
    pub(super) fn keep_decisions(&mut self) {
        let Some((keeper, text)) = self.outlets.correlations.as_ref().zip(self.newly_kept()) else { return };
        if keeper.try_send(text.clone()).is_ok() {
            self.kept = text;
        }
    }

    /// That, where it is not what was handed on.
    pub(super) fn newly_kept(&self) -> Option<Arc<str>> {
        let text = kept_lines(&self.driver.pipeline().engine().kept(), &self.config);
        (*text != *self.kept).then(|| text.into())
    }

    /// A transponder number was used, or went back: its keeper and the recorder have to know.
    pub(super) fn note_number(&mut self, change: NumberChange) {
        let number = change.given().number;
        if self.outlets.numbers.is_some() {
            self.unkept.insert(number, change);
        }
        if self.outlets.recorder.is_some() {
            self.unrecorded_numbers.insert(number, change);
        }
    }

    /// Hands on what became of transponder numbers; what does not fit the queues waits for the next time.
    pub(super) fn tell_numbers(&mut self) {
        if let Some(keeper) = &self.outlets.numbers {
            while let Some((&number, &change)) = self.unkept.first_key_value() {
                // A keeper that has ended has said so.
                if let Err(TrySendError::Full(_)) = keeper.try_send(change) {
                    break;
                }
                self.unkept.remove(&number);
            }
        }
        if let Some(recorder) = &self.outlets.recorder {
            while let Some((&number, &change)) = self.unrecorded_numbers.first_key_value() {
                // Of one that went back nothing is to be done: a file begins with those of who flies.
                if let NumberChange::Heard(given) = change
                    && !recorder.has_room_for(Recorded::Numbered { given })
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
        let kept = self.outlets.registration.as_ref().is_none_or(|to| to.try_send(text.clone()).is_ok());
        let recorder = self.outlets.recorder.as_ref();
        if kept && recorder.is_none_or(|recorder| recorder.has_room_for(Recorded::Registered { text })) {
            self.registered = registered;
        }
    }

    /// The registration, and the text of its file, where it is not what was handed on.
    pub(super) fn new_registration(&self) -> Option<(Estimates, Arc<str>)> {
        let engine = self.driver.pipeline().engine();
        let now: Estimates = engine.registered().map(|(sensor, now)| (sensor, now.estimate)).collect();
        (now != self.registered).then(|| {
            let text = registration_text(&Registrations::of(&self.config, engine));
            (now, text.into())
        })
    }
}
