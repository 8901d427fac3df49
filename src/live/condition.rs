//! The service's condition: whether its picture can be relied on. Sans-IO.
//!
//! [`Punctuality`] measures how late the picture is, and [`Condition`] adds everything else that is known to be wrong.
//! `/readyz`, `/api/v1/status`, `/metrics`, the alerts, the log, the map's badge and CAT065 all ask it, so that none
//! contradicts another.

use std::collections::VecDeque;
use std::fmt;
use std::time::Duration;

use super::alerts::{Severity, Trouble};
use super::health::SensorState;
use super::published::Status;

/// A picture later than configured by more than this is late.
const LATE: Duration = Duration::from_secs(1);
/// It is on time again once no slot of the last seconds ([`REMEMBERED`]) was later than this.
const ON_TIME: Duration = Duration::from_millis(500);
/// Time over which lateness is judged: what comes and goes faster is one lateness.
const REMEMBERED: Duration = Duration::from_secs(3);
/// Delayed datagrams from which the engine counts as overloaded; a few may have been on their way when the whole process
/// was paused.
const BACKLOG: usize = 10;
/// Slots published within this time count as one, the latest of them: it bounds what is remembered.
const MERGED: Duration = Duration::from_millis(100);

/// How late the live service publishes. A replay, which has a pace of its own, never notes anything here.
///
/// Its times (`at`) are of a monotonic clock, counted from any origin: a step of the wall clock does not confuse it.
#[derive(Clone, Debug)]
pub struct Punctuality {
    /// Time between two slots.
    slot: Duration,
    /// What was published in the last seconds, at least the latest slot; the oldest first.
    recent: VecDeque<Published>,
    /// The greatest lateness since it became late; `None` while it is on time.
    worst: Option<Duration>,
}

#[derive(Clone, Copy, Debug)]
struct Published {
    at: Duration,
    late: Duration,
    waited: usize,
}

/// How late the picture is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Lateness {
    /// Later than configured by this: the most in the last 3 s, up to now.
    pub late: Duration,
    /// The most since it became late; `None` while it counts as on time.
    pub worst: Option<Duration>,
    /// Why.
    pub cause: Cause,
}

/// Why a picture is late, as far as is known.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cause {
    /// Reports wait for the engine: more come than it can handle.
    Overload,
    /// Nothing has been published for longer than 1 s.
    Silence,
    /// Slots are published late, though hardly anything waits: something else held the process up.
    HeldUp,
}

impl Punctuality {
    /// Nothing published yet; a slot is due each `slot`.
    pub fn new(slot: Duration) -> Self {
        Self { slot, recent: VecDeque::new(), worst: None }
    }

    /// Notes a slot that was published at `at`, `late` after it was due, with the number of delayed datagrams since the slot
    /// before.
    pub fn note(&mut self, at: Duration, late: Duration, waited: usize) {
        match self.recent.back_mut().filter(|last| at.saturating_sub(last.at) < MERGED) {
            Some(last) => {
                last.late = last.late.max(late);
                last.waited += waited;
            }
            None => self.recent.push_back(Published { at, late, waited }),
        }
        self.look(at);
    }

    /// How late the picture is at `at`; `None` before the first slot.
    pub fn look(&mut self, at: Duration) -> Option<Lateness> {
        while self.recent.len() > 1 && at.saturating_sub(self.recent[0].at) > REMEMBERED {
            self.recent.pop_front();
        }
        let last = self.recent.back()?;
        let silence = at.saturating_sub(last.at).saturating_sub(self.slot);
        let published = self.recent.iter().map(|published| published.late).max().unwrap_or_default();
        let late = published.max(last.late + silence);
        self.worst = match self.worst {
            None => (late > LATE).then_some(late),
            Some(worst) => (late >= ON_TIME).then_some(worst.max(late)),
        };
        let waited: usize = self.recent.iter().map(|published| published.waited).sum();
        let cause = if waited >= BACKLOG {
            Cause::Overload
        } else if silence > LATE {
            Cause::Silence
        } else {
            Cause::HeldUp
        };
        Some(Lateness { late, worst: self.worst, cause })
    }
}

impl Lateness {
    /// Whether the picture counts as late.
    pub fn is_late(&self) -> bool {
        self.worst.is_some()
    }
}

impl fmt::Display for Lateness {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let late = Seconds(self.late);
        match self.cause {
            Cause::Overload => write!(f, "the engine is overloaded: the picture is {late} late")?,
            Cause::Silence => write!(f, "the picture is {late} late: no slot has been published meanwhile")?,
            Cause::HeldUp => {
                write!(f, "the picture is {late} late: the service was held up, though little input waits")?;
            }
        }
        match self.worst {
            Some(worst) if worst > self.late + LATE => write!(f, " ({} at worst)", Seconds(worst)),
            _ => Ok(()),
        }
    }
}

/// `3.2 s`, `21 s`.
struct Seconds(Duration);

impl fmt::Display for Seconds {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let seconds = self.0.as_secs_f64();
        write!(f, "{seconds:.*} s", usize::from(seconds < 10.0))
    }
}

/// Level of service.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Level {
    /// Nothing is known to be wrong.
    Ok,
    /// There is a picture of now, and something is wrong.
    Degraded,
    /// There is no picture of now.
    NotReady,
}

fusion::interface_names!(Level { Ok = "ok", Degraded = "degraded", NotReady = "not_ready" });

/// Something that is wrong.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Reason {
    /// The level that it leaves; never [`Level::Ok`].
    pub level: Level,
    /// What is wrong, in words.
    pub text: String,
}

/// What the condition is derived from.
#[derive(Clone, Copy, Debug)]
pub struct Facts<'a> {
    /// Whether a slot has been published.
    pub has_slot: bool,
    /// How late the picture is; `None` in a replay, and before the first slot.
    pub lateness: Option<Lateness>,
    /// What the engine told last; `None` in the first moments.
    pub status: Option<&'a Status>,
    /// What is wrong with the archive and the receivers of alerts, which the engine does not know.
    pub followers: &'a [Trouble],
}

/// Everything that is wrong now.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Condition {
    reasons: Vec<Reason>,
    troubles: Vec<Trouble>,
}

impl Condition {
    /// The condition that `facts` make.
    pub fn of(facts: &Facts<'_>) -> Self {
        let mut condition = Self::default();
        let sensors = || facts.status.iter().flat_map(|status| &status.sensors);
        let troubles = || facts.status.iter().flat_map(|status| &status.troubles).chain(facts.followers);
        if !facts.has_slot {
            condition.add(Level::NotReady, "no slot has been published yet".to_owned());
        }
        // A clock that was set back explains why nothing is published: one fault is reported once.
        let waits_for_clock = troubles().any(|trouble| trouble.about == Trouble::CLOCK);
        if let Some(lateness) = facts.lateness.filter(|lateness| lateness.is_late() && !waits_for_clock) {
            let text = lateness.to_string();
            condition.add(Level::NotReady, text.clone());
            condition.troubles.push(Trouble {
                about: Trouble::PICTURE.into(),
                severity: Severity::Critical,
                text,
            });
        }
        if facts.status.is_none() {
            condition.add(Level::NotReady, "the state of the lines is not known yet".to_owned());
        }
        for line in sensors().flat_map(|sensor| &sensor.lines).filter(|line| !line.joined) {
            condition.add(Level::NotReady, format!("line {} is not open", line.name));
        }
        for sensor in sensors().filter(|sensor| sensor.state != SensorState::Operational) {
            let text =
                format!("sensor {}: {}: {}", sensor.id, sensor.state.name(), sensor.reasons.join("; "));
            condition.add(Level::Degraded, text);
        }
        for trouble in troubles() {
            let stops_picture = trouble.about == Trouble::CLOCK;
            let level = if stops_picture { Level::NotReady } else { Level::Degraded };
            condition.add(level, trouble.text.clone());
            condition.troubles.push(trouble.clone());
        }
        condition
    }

    /// Adds something that is wrong, once.
    pub fn add(&mut self, level: Level, text: String) {
        if !self.reasons.iter().any(|reason| reason.text == text) {
            self.reasons.push(Reason { level, text });
        }
    }

    /// The worst of it.
    pub fn level(&self) -> Level {
        self.reasons.iter().map(|reason| reason.level).max().unwrap_or(Level::Ok)
    }

    /// What is wrong, in words, of at least that level.
    pub fn reasons(&self, at_least: Level) -> Vec<&str> {
        let bad = self.reasons.iter().filter(|reason| reason.level >= at_least);
        bad.map(|reason| reason.text.as_str()).collect()
    }

    /// What is wrong with the service itself; each becomes an alert.
    pub fn troubles(&self) -> &[Trouble] {
        &self.troubles
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    const SLOT: Duration = Duration::from_millis(250);

    fn ms(ms: u64) -> Duration {
        Duration::from_millis(ms)
    }

    /// On time for a second, the last slot at 1 s.
    fn punctual() -> Punctuality {
        let mut punctuality = Punctuality::new(SLOT);
        (1..=4).for_each(|slot| punctuality.note(ms(slot * 250), ms(1), 0));
        punctuality
    }

    #[test]
    fn before_the_first_slot_nothing_is_late() {
        assert_eq!(Punctuality::new(SLOT).look(ms(60_000)), None);
    }

    #[test]
    fn an_engine_that_stands_still_is_late_once_a_slot_is_missing_for_a_second() {
        let mut punctuality = punctual();
        assert!(!punctuality.look(ms(2_249)).unwrap().is_late());
        let stands = punctuality.look(ms(8_250)).unwrap();
        assert_eq!((stands.is_late(), stands.cause), (true, Cause::Silence));
        assert_eq!(stands.to_string(), "the picture is 7.0 s late: no slot has been published meanwhile");
    }

    #[test]
    fn an_overload_is_named_and_its_worst_is_told_until_it_is_over() {
        let mut punctuality = punctual();
        punctuality.note(ms(2_000), ms(79_000), 10);
        punctuality.note(ms(2_200), ms(79_000), 10);
        punctuality.note(ms(4_000), ms(20_600), 10);
        // It is over three seconds after the last slot that was late.
        for slot in 0..=11 {
            punctuality.note(ms(5_200 + slot * 250), ms(2), 0);
            assert!(punctuality.look(ms(5_200 + slot * 250)).unwrap().is_late() == (slot < 8), "{slot}");
        }
        let mut again = punctual();
        again.note(ms(2_000), ms(79_000), 10);
        again.note(ms(5_500), ms(20_600), 10);
        let text = "the engine is overloaded: the picture is 21 s late (79 s at worst)";
        assert_eq!(again.look(ms(5_500)).unwrap().to_string(), text);
    }

    #[test]
    fn between_half_a_second_and_one_it_stays_what_it_was() {
        let mut punctuality = punctual();
        punctuality.note(ms(1_250), ms(900), 0);
        assert!(!punctuality.look(ms(1_250)).unwrap().is_late());
        punctuality.note(ms(1_500), ms(1_100), 0);
        for slot in 1..100 {
            punctuality.note(ms(1_500 + slot * 250), ms(600), 0);
            assert!(punctuality.look(ms(1_500 + slot * 250)).unwrap().is_late());
        }
    }

    #[test]
    fn a_clock_set_back_is_one_reason_and_not_a_late_picture_too() {
        let clock = Trouble {
            about: Trouble::CLOCK.into(),
            severity: Severity::Critical,
            text: "the clock was set back".to_owned(),
        };
        let late = Some(Lateness { late: ms(9_000), worst: Some(ms(9_000)), cause: Cause::Silence });
        let facts =
            Facts { has_slot: true, lateness: late, status: None, followers: std::slice::from_ref(&clock) };
        let condition = Condition::of(&facts);
        assert_eq!(condition.level(), Level::NotReady);
        assert_eq!(condition.troubles(), [clock]);
        let reasons = condition.reasons(Level::NotReady);
        assert_eq!(reasons, ["the state of the lines is not known yet", "the clock was set back"]);
    }

    proptest! {
        /// Whatever is published and whenever it is looked at: it is late at once when more than a second is missing, never
        /// leaves that while the last slots were, and what is remembered is bounded.
        #[test]
        fn lateness_is_never_understated(
            slots in prop::collection::vec((0_u64..2_000, 0_u64..30_000, 0_usize..20), 1..200),
            pause in 0_u64..10_000,
        ) {
            let mut punctuality = Punctuality::new(SLOT);
            let mut at = Duration::ZERO;
            for &(after, late, waited) in &slots {
                at += ms(after);
                punctuality.note(at, ms(late), waited);
                prop_assert!(punctuality.look(at).is_some_and(|now| now.late >= ms(late)));
                prop_assert!(late <= 1_000 || punctuality.look(at).is_some_and(|now| now.is_late()));
                prop_assert!(punctuality.recent.len() <= 32);
            }
            let now = punctuality.look(at + ms(pause)).unwrap();
            let last = ms(slots[slots.len() - 1].1);
            prop_assert!(now.late >= last + ms(pause).saturating_sub(SLOT));
            prop_assert!(now.is_late() == now.worst.is_some_and(|worst| worst >= now.late));
            prop_assert!(now.is_late() || now.late <= LATE);
        }
    }
}
