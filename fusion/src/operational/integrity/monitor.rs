//! Integrity of one identity: the evidence for and against it, and the resulting state.

use std::collections::{BTreeSet, VecDeque};

use super::choice::{EvidenceReason, TrackClaims};
use super::watch::{SECOND, TrackWatches, Watch, WatchResult};
use crate::integrity::{
    Assessment, Concern, Evidence, Finding, HypothesisBank, IntegrityRules, PointIntegrity, Reason, Reasons,
    StampDelay, State, Trust,
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

/// Maximum delay of plots.
const PLOTS_COME_WITHIN: SignedDuration = SignedDuration::from_secs(1);
/// Delay after a second's decision up to which it is evaluated, seconds.
const LATE_SECONDS: i32 = 5;
/// Maximum weight of a radar track's earlier motion, natural logarithm.
const MOTION_MAX: f64 = 6.0;
/// Squared distance in standard deviations above which a radar track is elsewhere.
const ELSEWHERE_AWAY: f64 = 20.0;
/// Minimum speed of a moving radar track, metres a second, averaged over a period, seconds.
const MOVING_M_S: f64 = 3.0;
const MOVING_WITHIN_S: i32 = 5;
/// Additional log-likelihood required for late stamps compared with a false position: interpolation also errs along the
/// track.
const LATE_MORE: f64 = 3.0;
/// Maximum number of evidence entries.
const EVIDENCE_MAX: usize = 20;
/// Minimum offset of a suspect, metres.
const OFFSET_MIN_M: f64 = 15.0;
/// Maximum age of the last radar observation that can end a state, and minimum durations without evidence against it
/// for a suspect and a failed identity, seconds.
const LOOKED_LATELY_S: f64 = 10.0;
const SUSPECT_ENDS_S: f64 = 5.0;
const FAILED_ENDS_S: f64 = 30.0;
/// Time after the last agreeing radar track for which an identity stays verified, seconds.
const VERIFY_LASTS_S: f64 = 60.0;
/// Minimum number of observed seconds of an agreeing radar track, and minimum LLR by motion, for this aircraft against
/// one that passes by: 20 to 1.
const AGREES_SECONDS: u32 = 15;
const AGREES_MOTION: f64 = 3.0;
/// Number of radar tracks that are sufficient for a failure; minimum number of seconds of each, and minimum increase of
/// the index.
const FAILED_TRACKS: usize = 2;
const FAILED_SECONDS: u32 = 5;
const FAILED_GAIN: f64 = 3.0;

/// Integrity state of one identity.
#[derive(Debug, Serialize, Deserialize)]
pub(in crate::operational) struct IdentityMonitor {
    pub(super) bank: HypothesisBank,
    pub(super) watches: TrackWatches,
    /// The radar track that is evidence now.
    current: Option<EvidenceTrack>,
    evidence: VecDeque<Evidence>,
    state: State,
    since: Time,
    /// Published assessment, as of the last evaluation.
    known: Assessment,
    /// Time of its last report, if it has fallen silent.
    silent: Option<Time>,
    /// Its point in the slot.
    shown: Option<ShownPoint>,
    reasons: Reasons,
    /// Time since which there is no evidence against it.
    quiet: Option<Time>,
    /// Index at the last observation.
    index: f64,
    /// End of the last second evaluated; time of the last observation weighed.
    looked: Option<Time>,
    weighed: Option<Time>,
    /// Time of the last observation of an agreeing radar track since the last flag.
    agreed: Option<Time>,
    /// Time of its newest report.
    heard: Time,
    /// Whether an observation was weighed since the last evaluation.
    is_weighed_anew: bool,
    /// Track number of the aircraft that a radar detects away from the transponder's position.
    twin_number: Option<u32>,
    /// Aircraft without a transponder that were elsewhere while this one was detected at its reported position.
    others: BTreeSet<TargetId>,
}

/// The point of an identity in a slot.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub(super) struct ShownPoint {
    /// Its track number.
    pub(super) track: u32,
    /// Whether a radar detects it then.
    pub(super) is_seen: bool,
}

/// Rounds down to a whole second.
fn whole(time: Time) -> Time {
    let length = SECOND.as_nanos() as i64;
    Time::from_nanos(time.nanos().div_euclid(length) * length)
}

/// End of the first second that can be evaluated now.
pub(super) fn first_end(cycle: &Cycle) -> Time {
    whole(cycle.centre) + SECOND * -LATE_SECONDS
}

/// The radar track that is evidence now.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
struct EvidenceTrack {
    tracklet: TrackletId,
    /// Aircraft without a transponder to which the association assigns it.
    nobodys: Option<TargetId>,
    /// Index before this track.
    before: f64,
}

impl IdentityMonitor {
    pub(super) fn new(identity: Identity, time: Time, delay: StampDelay) -> Self {
        Self {
            bank: HypothesisBank::new(time, delay),
            watches: TrackWatches::new(),
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

    /// Ends of the seconds that can be evaluated now: those with a known curve of the transponder, and at least those
    /// up to the slot.
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

    /// Weighs the observations of the radar track that is most likely of this aircraft.
    pub(super) fn weigh_evidence(&mut self, claims: &TrackClaims, tracklets: &Tracklets) {
        let identity = self.known.identity;
        let current = self.current.map(|current| current.tracklet);
        let stays = self.bank.is_own();
        let candidates = self.watches.iter().filter_map(|(&id, watch)| {
            let judged = watch.last().filter(|judged| !judged.is_weighed(self.weighed))?;
            let own = claims.evidence_reason(id, identity, judged, current == Some(id), tracklets)?;
            let is_other =
                judged.taken_for.uncooperative_target().is_some_and(|nobodys| self.others.contains(&nobodys));
            if own == EvidenceReason::Far && is_other {
                return None;
            }
            Some(((current == Some(id) && stays, own), judged, id))
        });
        let best = candidates.max_by(|a, b| a.0.cmp(&b.0).then(a.1.motion.total_cmp(&b.1.motion)));
        if let Some(((_, own), judged, id)) = best
            && let Some(tracklet) = tracklets.get(id)
        {
            let judged = *judged;
            if own != EvidenceReason::Far && self.index < 0.0 {
                // An aircraft that is elsewhere at the same time is another one.
                let elsewhere = self.watches.values().filter_map(Watch::last).filter(|other| {
                    let apart_s = other.second.look.time.seconds_since(judged.second.look.time);
                    apart_s.abs() < 1.5 && other.away > ELSEWHERE_AWAY
                });
                self.others.extend(elsewhere.filter_map(|other| other.taken_for.uncooperative_target()));
            }
            self.weighed = Some(judged.second.look.time);
            if !judged.walks_off {
                self.observe(id, tracklet.key, &judged, own);
            }
        }
    }

    /// Adds an observation of a radar track.
    fn observe(
        &mut self,
        tracklet: TrackletId,
        key: RadarTrackKey,
        judged: &WatchResult,
        own: EvidenceReason,
    ) {
        let look = &judged.second.look;
        let same = self.current.filter(|current| current.tracklet == tracklet);
        let nobodys = judged.taken_for.uncooperative_target();
        let continues = same.is_none()
            && nobodys.is_some()
            && self.current.is_some_and(|current| current.nobodys == nobodys);
        let before = same.map_or(self.index, |current| current.before);
        self.current = Some(EvidenceTrack { tracklet, nobodys, before });
        let odds = (own.probability() / (1.0 - own.probability()))
            * judged.so_far.clamp(-MOTION_MAX, MOTION_MAX).exp();
        if continues {
            self.bank.observe_continuation(look, judged.other);
        } else {
            self.bank.observe(look, odds / (1.0 + odds), judged.other);
        }
        self.index = self.bank.index();
        self.is_weighed_anew = true;
        if same.is_none() {
            let is_near = own != EvidenceReason::Far;
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
            // Being near for a moment is no agreement: an aircraft that passes by is near, too.
            let is_alike = evidence.seconds >= AGREES_SECONDS && judged.so_far >= AGREES_MOTION;
            if own != EvidenceReason::Far && is_alike && self.bank.agrees() {
                self.agreed = Some(look.time);
            }
        }
    }

    /// Withdraws the radar's agreement, because the identity is of a host that was found to steer a registration.
    pub(super) fn withdraw_agreement(&mut self) {
        self.agreed = None;
    }

    /// Evaluates the state at `time`, from the observations so far and the rules on reports.
    pub(super) fn evaluate(
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
        self.apply_state(found, reasons, time, rules);
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

    /// Applies the evaluated state; a flag lasts until evidence ends it.
    fn apply_state(&mut self, found: State, reasons: Reasons, time: Time, rules: &IntegrityRules) {
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
        let is_looked_at =
            self.bank.last_observed().is_some_and(|last| time.seconds_since(last) <= LOOKED_LATELY_S);
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

    /// Whether a radar track of it moves.
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

    /// While it is flagged by radar: the radar track that shows the aircraft away from the transponder's position, and
    /// its LLR by motion.
    pub(super) fn twin(&self) -> Option<(TrackletId, f64)> {
        let is_off = self.state.is_flagged() && self.reasons.contains(Reason::Radar) && self.bank.is_own();
        let current = self.current.filter(|_| is_off)?;
        let judged = self.watches.get(&current.tracklet)?.last()?;
        Some((current.tracklet, judged.motion))
    }

    /// Requests an evaluation in the next slot, even without news.
    pub(super) fn wake(&mut self) {
        self.is_weighed_anew = true;
    }

    /// Updates the time of the newest report.
    pub(super) fn note_report(&mut self, transponder: &Transponder) {
        self.heard = self.heard.max(transponder.last_heard().unwrap_or(self.heard));
    }

    /// Time of its newest report.
    pub(super) fn last_report(&self) -> Time {
        self.heard
    }

    /// Whether its state must be kept.
    pub(super) fn is_of_note(&self) -> bool {
        self.state.is_flagged() || !self.evidence.is_empty()
    }

    /// Whether its state may have changed since the last evaluation.
    pub(super) fn is_outdated(&self, finding: &Finding) -> bool {
        self.is_weighed_anew
            || self.state.is_flagged()
            || !finding.suspect.is_empty()
            || !finding.failed.is_empty()
    }

    /// Track number of the aircraft that a radar detects away from the transponder's position, while it is flagged.
    pub(super) fn twin_number(&self) -> Option<u32> {
        self.twin_number.filter(|_| self.state.is_flagged())
    }

    /// Sets the track number of the aircraft that a radar detects away from the transponder's position.
    pub(super) fn set_twin_number(&mut self, number: u32) {
        self.twin_number = Some(number);
    }

    /// Sets the time of its last report if it has fallen silent, `None` otherwise.
    pub(super) fn set_silent(&mut self, silent: Option<Time>) {
        self.silent = silent;
    }

    /// Sets its point in the slot.
    pub(super) fn set_point(&mut self, part: &TransponderPart, shown: ShownPoint) {
        self.known.number = Some(part.number);
        self.shown = Some(shown);
    }

    /// Concerns about it at the slot, with the published points.
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

    /// The published assessment.
    pub(super) fn published(&self) -> &Assessment {
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
