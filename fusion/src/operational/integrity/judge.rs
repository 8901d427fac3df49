//! One identity: what speaks for and against it, and the state that follows.

use std::collections::{BTreeSet, VecDeque};

use super::choice::{Claims, Own};
use super::watch::{Judged, SECOND, Watch, Watches};
use crate::integrity::{
    Assessment, Bank, Concern, Delay, Evidence, Finding, IntegrityRules, PointIntegrity, Reason, Reasons,
    State, Trust,
};
use crate::operational::cycle::Cycle;
use crate::operational::ids::{TargetId, TrackletId};
use crate::operational::tracklets::Tracklets;
use crate::operational::transponder::Transponder;
use crate::point::TransponderPart;
use crate::report::{Identity, RadarTrackKey};
use crate::time::Time;
use jiff::SignedDuration;
use serde::{Deserialize, Serialize};

/// Plots come within this after they were made.
const PLOTS_COME_WITHIN: SignedDuration = SignedDuration::from_secs(1);
/// A second is looked at no later than this after it has been decided, seconds.
const LATE_SECONDS: i32 = 5;
/// How a radar track has flown before it is weighed counts no more than this, natural logarithm.
const MOTION_MAX: f64 = 6.0;
/// A radar track so far away is elsewhere, squared deviations.
const ELSEWHERE_AWAY: f64 = 20.0;
/// It moves where it is this fast, metres a second, on average over so many seconds.
const MOVING_M_S: f64 = 3.0;
const MOVING_WITHIN_S: i32 = 5;
/// That the stamps are late has to be so much likelier than that places are off: interpolation errs along the track, too.
const LATE_MORE: f64 = 3.0;
/// Evidences that are kept.
const EVIDENCE_MAX: usize = 20;
/// A suspect's offset is larger than this, metres.
const OFFSET_MIN_M: f64 = 15.0;
/// A state ends only by a radar look of the last seconds, and after so long, seconds.
const LOOKED_LATELY_S: f64 = 10.0;
const SUSPECT_ENDS_S: f64 = 5.0;
const FAILED_ENDS_S: f64 = 30.0;
/// Without a radar track that agrees for so long nobody stays verified, seconds.
const VERIFY_LASTS_S: f64 = 60.0;
/// A radar track agrees once it was looked at for so many seconds, and flies so much likelier as this aircraft than as another one
/// that passes by, natural logarithm: 20 to 1.
const AGREES_SECONDS: u32 = 15;
const AGREES_MOTION: f64 = 3.0;
/// Two radar tracks of at least so many seconds, each of which raises the index by so much, are enough.
const FAILED_TRACKS: usize = 2;
const FAILED_SECONDS: u32 = 5;
const FAILED_GAIN: f64 = 3.0;

/// One identity.
#[derive(Debug, Serialize, Deserialize)]
pub(in crate::operational) struct Judge {
    pub(super) bank: Bank,
    pub(super) watches: Watches,
    /// The radar track that is evidence now.
    current: Option<Current>,
    evidence: VecDeque<Evidence>,
    state: State,
    since: Time,
    /// What was made of it when it was judged last, and what is published of it.
    known: Assessment,
    /// Its last report, where it has fallen silent.
    silent: Option<Time>,
    /// Its point in the slot.
    shown: Option<Shown>,
    reasons: Reasons,
    /// Since when nothing speaks against it any more.
    quiet: Option<Time>,
    /// Index at the last look.
    index: f64,
    /// The last second that was looked at ended then; the last look that was weighed.
    looked: Option<Time>,
    weighed: Option<Time>,
    /// The last look at a radar track that agrees, since it was flagged last.
    agreed: Option<Time>,
    /// Time of its newest report.
    heard: Time,
    /// Whether a look was weighed since it was judged last.
    is_weighed_anew: bool,
    /// Number of the aircraft that a radar sees where its transponder is not.
    twin_number: Option<u32>,
    /// Aircraft without a transponder that were elsewhere while this one was seen where it says.
    others: BTreeSet<TargetId>,
}

/// The point of an identity in a slot.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub(super) struct Shown {
    /// Its track number.
    pub(super) track: u32,
    /// Whether a radar sees it then.
    pub(super) is_seen: bool,
}

/// The last whole second.
fn whole(time: Time) -> Time {
    let length = SECOND.as_nanos() as i64;
    Time::from_nanos(time.nanos().div_euclid(length) * length)
}

/// The end of the first second that can be looked at now.
pub(super) fn first_end(cycle: &Cycle) -> Time {
    whole(cycle.centre) + SECOND * -LATE_SECONDS
}

/// The radar track that is evidence now.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
struct Current {
    tracklet: TrackletId,
    /// Aircraft without a transponder that the association takes it for.
    nobodys: Option<TargetId>,
    /// Index before it.
    before: f64,
}

impl Judge {
    pub(super) fn new(identity: Identity, time: Time, delay: Delay) -> Self {
        Self {
            bank: Bank::new(time, delay),
            watches: Watches::new(),
            current: None,
            evidence: VecDeque::new(),
            state: State::Unverified,
            since: time,
            known: Assessment::new(identity, time),
            silent: None,
            shown: None,
            reasons: Reasons::default(),
            quiet: None,
            index: 0.0,
            looked: None,
            weighed: None,
            agreed: None,
            heard: time,
            is_weighed_anew: true,
            twin_number: None,
            others: BTreeSet::new(),
        }
    }

    /// The ends of the seconds that can be looked at now: those with the transponder's curve, but no later than the slot.
    pub(super) fn pending(
        &mut self,
        transponder: &Transponder,
        cycle: &Cycle,
    ) -> impl Iterator<Item = Time> + use<> {
        let received = cycle.deadline + -PLOTS_COME_WITHIN;
        let heard = transponder.last_heard().unwrap_or(cycle.centre).min(received);
        let until = whole(heard.max(cycle.centre));
        let first = self.looked.map_or(until, |looked| looked + SECOND).max(first_end(cycle));
        self.looked = self.looked.max(Some(until));
        let count = (until.nanos() - first.nanos()).div_euclid(SECOND.as_nanos() as i64) + 1;
        (0..count.max(0)).map(move |index| first + SECOND * index as i32)
    }

    /// Weighs the looks at the radar track that is the likeliest to be its own.
    pub(super) fn weigh(&mut self, claims: &Claims, tracklets: &Tracklets) {
        let identity = self.known.identity;
        let current = self.current.map(|current| current.tracklet);
        let stays = self.bank.is_own();
        let candidates = self.watches.iter().filter_map(|(&id, watch)| {
            let judged = watch.last().filter(|judged| !judged.is_weighed(self.weighed))?;
            let own = claims.own(id, identity, judged, current == Some(id), tracklets)?;
            let is_other = judged.taken_for.nobodys().is_some_and(|nobodys| self.others.contains(&nobodys));
            if own == Own::Far && is_other {
                return None;
            }
            Some(((current == Some(id) && stays, own), judged, id))
        });
        let best = candidates.max_by(|a, b| a.0.cmp(&b.0).then(a.1.motion.total_cmp(&b.1.motion)));
        if let Some(((_, own), judged, id)) = best
            && let Some(tracklet) = tracklets.get(id)
        {
            let judged = *judged;
            if own != Own::Far && self.index < 0.0 {
                // Who is elsewhere while it is here is another one.
                let elsewhere = self.watches.values().filter_map(Watch::last).filter(|other| {
                    let apart_s = other.second.look.time.seconds_since(judged.second.look.time);
                    apart_s.abs() < 1.5 && other.away > ELSEWHERE_AWAY
                });
                self.others.extend(elsewhere.filter_map(|other| other.taken_for.nobodys()));
            }
            self.weighed = Some(judged.second.look.time);
            if !judged.walks_off {
                self.take(id, tracklet.key, &judged, own);
            }
        }
    }

    /// A look of a radar track.
    fn take(&mut self, tracklet: TrackletId, key: RadarTrackKey, judged: &Judged, own: Own) {
        let look = &judged.second.look;
        let same = self.current.filter(|current| current.tracklet == tracklet);
        let nobodys = judged.taken_for.nobodys();
        let continues = same.is_none()
            && nobodys.is_some()
            && self.current.is_some_and(|current| current.nobodys == nobodys);
        let before = same.map_or(self.index, |current| current.before);
        self.current = Some(Current { tracklet, nobodys, before });
        let odds = (own.probability() / (1.0 - own.probability()))
            * judged.so_far.clamp(-MOTION_MAX, MOTION_MAX).exp();
        if continues {
            self.bank.go_on(look, judged.other);
        } else {
            self.bank.take(look, odds / (1.0 + odds), judged.other);
        }
        self.index = self.bank.index();
        self.is_weighed_anew = true;
        if same.is_none() {
            let is_near = own != Own::Far;
            self.evidence.push_front(Evidence {
                track: key,
                is_near,
                from: look.time,
                seconds: 0,
                gain: 0.0,
            });
            self.evidence.truncate(EVIDENCE_MAX);
        }
        if let Some(evidence) = self.evidence.front_mut() {
            evidence.seconds += 1;
            evidence.gain = self.index - before;
            // To be near for a moment is no agreement: who passes by is, too.
            let is_alike = evidence.seconds >= AGREES_SECONDS && judged.so_far >= AGREES_MOTION;
            if own != Own::Far && is_alike && self.bank.agrees() {
                self.agreed = Some(look.time);
            }
        }
    }

    /// A radar that agrees does not count: the identity is one of a host that was found to steer a registration.
    pub(super) fn withdraw_agreement(&mut self) {
        self.agreed = None;
    }

    /// The state at `time`, by the looks so far and what the reports alone show.
    pub(super) fn judge(
        &mut self,
        time: Time,
        finding: &Finding,
        trust: Option<Trust>,
        rules: &IntegrityRules,
    ) {
        self.is_weighed_anew = false;
        let index = self.index;
        let level_m = self.bank.protection_level_m(time);
        let is_off = || self.bank.offset(time).is_some_and(|(offset, _)| offset.norm() > OFFSET_MIN_M);
        let mut reasons = finding.suspect.or(finding.failed);
        if index > rules.on && is_off() {
            reasons.insert(Reason::Radar);
        }
        if self.bank.late_index().is_some_and(|late| late > rules.on + LATE_MORE) {
            reasons.insert(Reason::Time);
        }
        let raising =
            |evidence: &&Evidence| evidence.seconds >= FAILED_SECONDS && evidence.gain >= FAILED_GAIN;
        let is_twofold =
            reasons.contains(Reason::Radar) && self.evidence.iter().filter(raising).count() >= FAILED_TRACKS;
        let found = match () {
            () if !finding.failed.is_empty() || is_twofold => State::Failed,
            () if !reasons.is_empty() => State::Suspect,
            () => self.unflagged(time, level_m, rules),
        };
        self.settle(found, reasons, time, rules);
        match trust {
            Some(Trust::Trusted) if self.state.is_flagged() => self.enter(State::Unverified, time),
            Some(Trust::Distrusted) => self.enter(State::Failed, time),
            _ => {}
        }
        self.known = self.assessment(time, level_m, trust);
    }

    fn unflagged(&self, time: Time, level_m: Option<f64>, rules: &IntegrityRules) -> State {
        let agrees = self.agreed.is_some_and(|last| time.seconds_since(last) < VERIFY_LASTS_S);
        let is_bounded = level_m.is_some_and(|level_m| level_m <= rules.alert_limit_m);
        if agrees && self.index < rules.off && is_bounded { State::Verified } else { State::Unverified }
    }

    /// A flag lasts until evidence says that it is over.
    fn settle(&mut self, found: State, reasons: Reasons, time: Time, rules: &IntegrityRules) {
        if found.is_flagged() {
            (self.quiet, self.agreed) = (None, None);
            self.reasons = if self.state.is_flagged() { self.reasons.or(reasons) } else { reasons };
            self.enter(found.max(if self.state.is_flagged() { self.state } else { found }), time);
            return;
        }
        if !self.state.is_flagged() {
            self.enter(found, time);
            return;
        }
        let by_radar = self.reasons.contains(Reason::Radar) || self.reasons.contains(Reason::Time);
        let is_looked_at = self.bank.looked().is_some_and(|last| time.seconds_since(last) <= LOOKED_LATELY_S);
        let is_over = if by_radar { self.index < rules.off && is_looked_at } else { true };
        if !is_over {
            self.quiet = None;
            return;
        }
        let since = *self.quiet.get_or_insert(time);
        let lasts_s = if self.state == State::Failed { FAILED_ENDS_S } else { SUSPECT_ENDS_S };
        if time.seconds_since(since) >= lasts_s {
            self.reasons = Reasons::default();
            self.enter(State::Unverified, time);
        }
    }

    fn enter(&mut self, state: State, time: Time) {
        if state != self.state {
            (self.state, self.since) = (state, time);
        }
        if !state.is_flagged() {
            (self.quiet, self.twin_number) = (None, None);
        }
    }

    pub(super) fn state(&self) -> State {
        self.state
    }

    /// Whether a radar that sees it sees it move.
    pub(super) fn is_seen_moving(&self, tracklets: &Tracklets, time: Time) -> bool {
        let seen = self.current.and_then(|current| tracklets.get(current.tracklet));
        let Some(tracklet) = seen.filter(|tracklet| tracklet.last() >= time) else { return false };
        let before = time + SECOND * -MOVING_WITHIN_S;
        let (Some(now), Some(then)) = (tracklet.nearest(time), tracklet.nearest(before)) else {
            return false;
        };
        let passed_s = now.time.seconds_since(then.time);
        passed_s > 1.0 && (now.position.0 - then.position.0).xy().norm() > MOVING_M_S * passed_s
    }

    /// The radar track that sees the aircraft where its transponder is not, and by how much likelier that is by the way it
    /// flies; while it is flagged by radar.
    pub(super) fn twin(&self) -> Option<(TrackletId, f64)> {
        let is_off = self.state.is_flagged() && self.reasons.contains(Reason::Radar) && self.bank.is_own();
        let current = self.current.filter(|_| is_off)?;
        let judged = self.watches.get(&current.tracklet)?.last()?;
        Some((current.tracklet, judged.motion))
    }

    /// It is to be judged in the next slot, whether there is news or not.
    pub(super) fn wake(&mut self) {
        self.is_weighed_anew = true;
    }

    /// Its transponder is heard.
    pub(super) fn hear(&mut self, transponder: &Transponder) {
        self.heard = self.heard.max(transponder.last_heard().unwrap_or(self.heard));
    }

    /// The time of its newest report.
    pub(super) fn heard(&self) -> Time {
        self.heard
    }

    /// Whether there is something to remember of it.
    pub(super) fn is_of_note(&self) -> bool {
        self.state.is_flagged() || !self.evidence.is_empty()
    }

    /// Whether its state may be another one than when it was judged last.
    pub(super) fn has_news(&self, finding: &Finding) -> bool {
        self.is_weighed_anew
            || self.state.is_flagged()
            || !finding.suspect.is_empty()
            || !finding.failed.is_empty()
    }

    /// Number of the aircraft that a radar sees where its transponder is not, while it is flagged.
    pub(super) fn twin_number(&self) -> Option<u32> {
        self.twin_number.filter(|_| self.state.is_flagged())
    }

    /// Number of the aircraft that a radar sees where its transponder is not.
    pub(super) fn set_twin_number(&mut self, number: u32) {
        self.twin_number = Some(number);
    }

    /// Whether it has fallen silent: its last report.
    pub(super) fn set_silent(&mut self, silent: Option<Time>) {
        self.silent = silent;
    }

    /// It has a point in the slot.
    pub(super) fn show(&mut self, part: &TransponderPart, shown: Shown) {
        self.known.number = Some(part.number);
        self.shown = Some(shown);
    }

    /// What is wrong with it at the slot, with the points that were shown.
    pub(super) fn concerns(&mut self) -> impl Iterator<Item = Concern> + use<> {
        let (shown, twin) = (self.shown.take(), self.twin_number());
        (self.known.is_silent, self.known.twin) = (self.silent.is_some(), twin);
        let Assessment { identity, integrity, .. } = self.known;
        let PointIntegrity { state, reasons, offset_m, .. } = integrity;
        let track = shown.map(|shown| shown.track);
        let lies = Concern::Integrity { identity, track, twin, state, reasons, offset_m };
        let is_seen = shown.is_some_and(|shown| shown.is_seen);
        let silent = self.silent.filter(|_| is_seen);
        let silent = silent.map(|heard| Concern::Silent { identity, track, heard });
        state.is_flagged().then_some(lies).into_iter().chain(silent)
    }

    /// What is known of it.
    pub(super) fn known(&self) -> &Assessment {
        &self.known
    }

    fn assessment(&self, time: Time, level_m: Option<f64>, trust: Option<Trust>) -> Assessment {
        let is_flagged = self.state.is_flagged();
        let is_off = is_flagged && self.index > 0.0;
        let offset = is_off.then(|| self.bank.offset(time)).flatten();
        let by_radar = self.reasons.contains(Reason::Radar);
        Assessment {
            identity: self.known.identity,
            number: None,
            integrity: PointIntegrity {
                state: self.state,
                index: self.index,
                protection_level_m: level_m,
                offset_m: offset.filter(|_| by_radar).map(|(offset, _)| offset.norm()),
                reasons: if is_flagged { self.reasons } else { Reasons::default() },
            },
            since: self.since,
            offset,
            heard: self.heard,
            is_silent: false,
            trust,
            twin: self.twin_number(),
            evidence: self.evidence.iter().copied().collect(),
        }
    }
}
