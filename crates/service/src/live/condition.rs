//! The service's condition: whether its picture can be relied on. Sans-IO.
//!
//! [`Punctuality`] measures how late the picture is, and [`Condition`] adds everything else that is known to be wrong.
//! `/readyz`, `/api/v1/status`, `/metrics`, the alerts, the log, the map's badge and CAT065 all ask it, so that none
//! contradicts another.

use std::collections::VecDeque;
use std::fmt;
use std::time::Duration;

use super::alerts::{ServiceFault, Severity};
use super::health::SensorState;
use super::published::Status;

/// A picture later than configured by more than this is late.
const LATE: Duration = Duration::from_secs(1);
/// Maximum lateness within [`REMEMBERED`] at which a late picture counts as on time again.
const ON_TIME: Duration = Duration::from_millis(500);
/// Time over which lateness is judged; repeated lateness within it counts as one.
const REMEMBERED: Duration = Duration::from_secs(3);
/// Number of delayed datagrams from which the engine counts as overloaded. A few may merely have arrived while the whole
/// process was paused.
const BACKLOG: usize = 10;
/// Slots published within this time are kept as one, with the greatest lateness. This bounds the memory.
const MERGED: Duration = Duration::from_millis(100);

/// Lateness of the live service's slots. A replay, which has its own pace, never reports slots here.
///
/// Its times (`at`) are of a monotonic clock with any origin, so a step of the wall clock has no effect.
#[derive(Clone, Debug)]
pub struct Punctuality {
    /// Time between two slots.
    slot: Duration,
    /// Slots published in the last seconds, the oldest first; always contains the latest.
    recent: VecDeque<SlotLateness>,
    /// Greatest lateness since the picture became late; `None` while it is on time.
    worst: Option<Duration>,
}

#[derive(Clone, Copy, Debug)]
struct SlotLateness {
    at: Duration,
    late: Duration,
    waited: usize,
}

/// Lateness of the picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PictureLateness {
    /// Greatest lateness in the last 3 s, beyond the configured latency.
    pub late: Duration,
    /// Greatest lateness since the picture became late; `None` while it counts as on time.
    pub worst: Option<Duration>,
    /// Cause.
    pub cause: LatenessCause,
}

/// Cause of a late picture, as far as it is known.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LatenessCause {
    /// Reports wait for the engine: it receives more than it can handle.
    Overload,
    /// No slot has been published for more than 1 s.
    Silence,
    /// Slots are published late although hardly any input waits: something else delayed the process.
    HeldUp,
}

impl Punctuality {
    /// Starts without slots; one is due every `slot`.
    pub fn new(slot: Duration) -> Self {
        Self { slot, recent: VecDeque::new(), worst: None }
    }

    /// Records a slot that was published at `at`, `late` after it was due, with the number of delayed datagrams since the
    /// slot before.
    pub fn note(&mut self, at: Duration, late: Duration, waited: usize) {
        match self.recent.back_mut().filter(|last| at.saturating_sub(last.at) < MERGED) {
            Some(last) => {
                last.late = last.late.max(late);
                last.waited += waited;
            }
            None => self.recent.push_back(SlotLateness { at, late, waited }),
        }
        self.look(at);
    }

    /// Lateness of the picture at `at`; `None` before the first slot.
    pub fn look(&mut self, at: Duration) -> Option<PictureLateness> {
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
            LatenessCause::Overload
        } else if silence > LATE {
            LatenessCause::Silence
        } else {
            LatenessCause::HeldUp
        };
        Some(PictureLateness { late, worst: self.worst, cause })
    }
}

impl PictureLateness {
    /// Whether the picture counts as late.
    pub fn is_late(&self) -> bool {
        self.worst.is_some()
    }
}

impl fmt::Display for PictureLateness {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let late = Seconds(self.late);
        match self.cause {
            LatenessCause::Overload => write!(f, "the engine is overloaded: the picture is {late} late")?,
            LatenessCause::Silence => {
                write!(f, "the picture is {late} late: no slot has been published meanwhile")?;
            }
            LatenessCause::HeldUp => {
                write!(f, "the picture is {late} late: the service was held up, though little input waits")?;
            }
        }
        match self.worst {
            Some(worst) if worst > self.late + LATE => write!(f, " ({} at worst)", Seconds(worst)),
            _ => Ok(()),
        }
    }
}

/// A duration as `3.2 s` or `21 s`.
struct Seconds(Duration);

impl fmt::Display for Seconds {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let seconds = self.0.as_secs_f64();
        write!(f, "{seconds:.*} s", usize::from(seconds < 10.0))
    }
}

/// Level of service.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum ServiceLevel {
    /// No fault is known.
    Ok,
    /// The picture is current, but something is wrong.
    Degraded,
    /// The picture is not current, or missing.
    NotReady,
}

fusion::interface_names!(ServiceLevel { Ok = "ok", Degraded = "degraded", NotReady = "not_ready" });

/// A fault that affects the condition.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ConditionReason {
    /// Resulting level; never [`ServiceLevel::Ok`].
    pub level: ServiceLevel,
    /// Text of the fault.
    pub text: String,
}

/// Inputs of the condition.
#[derive(Clone, Copy, Debug)]
pub struct ConditionInputs<'a> {
    /// Whether a slot has been published.
    pub has_slot: bool,
    /// How late the picture is; `None` in a replay, and before the first slot.
    pub lateness: Option<PictureLateness>,
    /// Last status from the engine; `None` right after the start.
    pub status: Option<&'a Status>,
    /// Faults of the archive and of the receivers of alerts, which the engine's status does not contain.
    pub followers: &'a [ServiceFault],
}

/// All present faults.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Condition {
    reasons: Vec<ConditionReason>,
    troubles: Vec<ServiceFault>,
}

impl Condition {
    /// Derives the condition from `facts`.
    pub fn of(facts: &ConditionInputs<'_>) -> Self {
        let mut condition = Self::default();
        let sensors = || facts.status.iter().flat_map(|status| &status.sensors);
        let troubles = || facts.status.iter().flat_map(|status| &status.troubles).chain(facts.followers);
        if !facts.has_slot {
            condition.add(ServiceLevel::NotReady, "no slot has been published yet".to_owned());
        }
        // A clock that was set back explains why no slot is published: one fault is reported once.
        let waits_for_clock = troubles().any(|trouble| trouble.about == ServiceFault::CLOCK);
        if let Some(lateness) = facts.lateness.filter(|lateness| lateness.is_late() && !waits_for_clock) {
            let text = lateness.to_string();
            condition.add(ServiceLevel::NotReady, text.clone());
            condition.troubles.push(ServiceFault {
                about: ServiceFault::PICTURE.into(),
                severity: Severity::Critical,
                text,
            });
        }
        if facts.status.is_none() {
            condition.add(ServiceLevel::NotReady, "the state of the lines is not known yet".to_owned());
        }
        for line in sensors().flat_map(|sensor| &sensor.lines).filter(|line| !line.joined) {
            condition.add(ServiceLevel::NotReady, format!("line {} is not open", line.name));
        }
        for sensor in sensors().filter(|sensor| sensor.state != SensorState::Operational) {
            let text =
                format!("sensor {}: {}: {}", sensor.id, sensor.state.name(), sensor.reasons.join("; "));
            condition.add(ServiceLevel::Degraded, text);
        }
        // Without any data an empty picture is not a clear sky.
        if sensors().next().is_some() && sensors().all(|sensor| sensor.state == SensorState::Outage) {
            condition.add(ServiceLevel::NotReady, "no sensor delivers data".to_owned());
        }
        for trouble in troubles() {
            let stops_picture = trouble.about == ServiceFault::CLOCK;
            let level = if stops_picture { ServiceLevel::NotReady } else { ServiceLevel::Degraded };
            condition.add(level, trouble.text.clone());
            condition.troubles.push(trouble.clone());
        }
        condition
    }

    /// Adds a fault, unless it is there already.
    pub fn add(&mut self, level: ServiceLevel, text: String) {
        if !self.reasons.iter().any(|reason| reason.text == text) {
            self.reasons.push(ConditionReason { level, text });
        }
    }

    /// The worst level.
    pub fn level(&self) -> ServiceLevel {
        self.reasons.iter().map(|reason| reason.level).max().unwrap_or(ServiceLevel::Ok)
    }

    /// Texts of the faults of at least that level.
    pub fn reasons(&self, at_least: ServiceLevel) -> Vec<&str> {
        let bad = self.reasons.iter().filter(|reason| reason.level >= at_least);
        bad.map(|reason| reason.text.as_str()).collect()
    }

    /// Faults of the service itself; each becomes an alert.
    pub fn troubles(&self) -> &[ServiceFault] {
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

    /// On time for a second; the last slot was published at 1 s.
    fn punctual() -> Punctuality {
        let mut punctuality = Punctuality::new(SLOT);
        (1..=4).for_each(|slot| punctuality.note(ms(slot * 250), ms(1), 0));
        punctuality
    }

    #[test]
    fn nothing_is_late_before_the_first_slot() {
        assert_eq!(Punctuality::new(SLOT).look(ms(60_000)), None);
    }

    #[test]
    fn stopped_engine_is_late_after_a_missing_second() {
        let mut punctuality = punctual();
        assert!(!punctuality.look(ms(2_249)).unwrap().is_late());
        let stands = punctuality.look(ms(8_250)).unwrap();
        assert_eq!((stands.is_late(), stands.cause), (true, LatenessCause::Silence));
        assert_eq!(stands.to_string(), "the picture is 7.0 s late: no slot has been published meanwhile");
    }

    #[test]
    fn overload_reports_its_worst_lateness_until_it_ends() {
        let mut punctuality = punctual();
        punctuality.note(ms(2_000), ms(79_000), 10);
        punctuality.note(ms(2_200), ms(79_000), 10);
        punctuality.note(ms(4_000), ms(20_600), 10);
        // The picture is on time again three seconds after the last late slot.
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
    fn lateness_between_thresholds_keeps_the_state() {
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
    fn clock_set_back_is_one_reason_without_lateness() {
        let clock = ServiceFault {
            about: ServiceFault::CLOCK.into(),
            severity: Severity::Critical,
            text: "the clock was set back".to_owned(),
        };
        let late =
            Some(PictureLateness { late: ms(9_000), worst: Some(ms(9_000)), cause: LatenessCause::Silence });
        let facts = ConditionInputs {
            has_slot: true,
            lateness: late,
            status: None,
            followers: std::slice::from_ref(&clock),
        };
        let condition = Condition::of(&facts);
        assert_eq!(condition.level(), ServiceLevel::NotReady);
        assert_eq!(condition.troubles(), [clock]);
        let reasons = condition.reasons(ServiceLevel::NotReady);
        assert_eq!(reasons, ["the state of the lines is not known yet", "the clock was set back"]);
    }

    proptest! {
        /// For any sequence of slots: the picture is late as soon as more than a second is missing, stays late while the
        /// last slots were late, and memory is bounded.
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
