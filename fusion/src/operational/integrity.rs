//! The pass that judges transponders: states from the evidence of radar tracks and from their own reports.
//!
//! Second by second each radar track is compared with the transponders around. It is evidence of one at most: *near* where it is
//! where the transponder says, or has been and does not fly otherwise since; *far* where it is elsewhere and flies alike.

mod choice;
mod judge;
mod lost;
mod marks;
mod watch;

use std::collections::{BTreeMap, BTreeSet};

use jiff::SignedDuration;
use serde::{Deserialize, Serialize};

use super::correlation::Decided;
use super::cycle::Cycle;
use super::ids::{TargetId, TrackletId};
use super::places::Places;
use super::registrations::Registrations;
use super::settings::Settings;
use super::targets::{Target, Targets};
use super::tracklets::{Tracklet, Tracklets};
use super::tuning::DRONE_SPEED_MAX_M_S;
use crate::integrity::{
    Action, Assessment, Concern, Delay, HeldWord, Jammed, Reason, ReportRules, Trust, Word,
};
use crate::point::Point;
use crate::report::{Fix, Identity};
use crate::slots::Slot;
use crate::time::Time;
use choice::{Claim, Claims};
pub(super) use judge::Judge;
use judge::Shown;
use watch::{Curve, SECOND, TakenFor, Watch};

/// A radar track further away than this is not looked at, metres, beside so many deviations of its slow errors.
const AROUND_M: f64 = 300.0;
const AROUND_SIGMAS: f64 = 2.0;
/// Who a radar track was seen to be counts for so long, seconds.
const CLAIMED_S: i32 = 5;
/// What is known of an identity is kept this long after its last report, where a radar was compared with it or it was flagged;
const FORGOTTEN: SignedDuration = SignedDuration::from_hours(1);
/// of more than so many identities only as long as they are published.
const JUDGES_MAX: usize = 16_384;

/// A radar track that sees an aircraft where its transponder is not.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub(super) struct Twin {
    /// The target of that transponder.
    liar: TargetId,
    /// How much likelier it flies as the transponder does than as another aircraft, natural logarithm.
    pub(super) motion: f64,
}

/// All of them.
pub(super) type Twins = BTreeMap<TrackletId, Twin>;

/// What is known of every identity heard lately.
#[derive(Debug, Default, Serialize, Deserialize)]
pub(super) struct Integrities {
    reports: ReportRules,
    judges: BTreeMap<Identity, Judge>,
    claims: Claims,
    /// The last second that all were judged in.
    second: Option<i64>,
    twins: Twins,
    /// What operators say, by identity.
    words: BTreeMap<Identity, HeldWord>,
    /// Identities of hosts that have steered a registration: no radar verifies them.
    doubted: BTreeSet<Identity>,
}

impl Integrities {
    /// Takes the reports that came since the last slot, by time.
    pub(super) fn hear(&mut self, fixes: &[Fix], settings: &Settings) {
        if settings.integrity.action == Action::Off {
            return;
        }
        self.reports.take(fixes);
    }

    /// Judges every identity by what is known at the slot's deadline.
    pub(super) fn assess(&mut self, tracklets: &Tracklets, targets: &Targets, cycle: &Cycle) {
        if cycle.settings.integrity.action == Action::Off {
            return;
        }
        self.reports.look(cycle.deadline);
        self.claims.turn(cycle.centre + SECOND * -CLAIMED_S);
        for &ended in tracklets.ended() {
            self.claims.end(ended);
            self.judges.values_mut().for_each(|judge| _ = judge.watches.remove(&ended));
        }
        self.watch(tracklets, targets, cycle);
        self.settle(tracklets, targets, cycle);
    }

    /// Looks at the radar tracks around each transponder, second by second as soon as both are known. Whose each of them is
    /// goes by what was seen up to the slot before, so that the order of the transponders does not matter.
    fn watch<'t>(&mut self, tracklets: &'t Tracklets, targets: &Targets, cycle: &Cycle) {
        let settings = cycle.settings;
        let begin = judge::first_end(cycle) + -SECOND;
        let last = |tracklet: &'t Tracklet| {
            let lasts = Some(tracklet).filter(|tracklet| tracklet.last() > begin);
            Some((lasts?.nearest(cycle.deadline)?.position, tracklet))
        };
        let places = Places::of(tracklets.iter().filter_map(last));
        let widest = settings.radars().map(|(_, radar)| radar.track_errors.bias_azimuth).fold(0.0, f64::max);
        let mut seen = Vec::new();
        for target in targets.iter() {
            let Some(transponder) = target.transponder() else { continue };
            let judge = self.judges.entry(transponder.identity).or_insert_with(|| {
                let delay = settings.delay(&transponder.identity, &transponder.kind()).unwrap_or_default();
                Judge::new(
                    transponder.identity,
                    cycle.centre,
                    Delay { mean_s: delay.mean_s - delay.applied_s, sigma_s: delay.sigma_s },
                )
            });
            judge.hear(transponder);
            let pending: Vec<Time> = judge.pending(transponder, cycle).collect();
            let Some(&first) = pending.first() else { continue };
            let jumps = self.reports.finding(transponder.identity).suspect.contains(Reason::Jump);
            let Some(mut curve) = Curve::from(first, transponder, cycle) else { continue };
            for end in pending {
                let Some(place) = curve.turn(end) else { continue };
                let begin = end + -SECOND;
                let around_m = AROUND_M + AROUND_SIGMAS * place.0.xy().norm() * widest;
                let flown_m = DRONE_SPEED_MAX_M_S * cycle.deadline.seconds_since(end);
                for &(_, tracklet) in places.within(place, around_m + flown_m) {
                    if tracklet.first() > end || tracklet.last() <= begin {
                        continue;
                    }
                    let Some(plot) = tracklet.last_until(end).filter(|plot| plot.time > begin) else {
                        continue;
                    };
                    if (plot.position.0 - place.0).xy().norm() > around_m {
                        continue;
                    }
                    let Some(radar) = settings.radar(tracklet.key.sensor) else { continue };
                    let taken_for = match tracklet.target() {
                        Some(own) if own == target.id() => TakenFor::Own,
                        Some(other) if targets.get(other).and_then(Target::transponder).is_some() => {
                            TakenFor::Another
                        }
                        Some(nobody) => TakenFor::Nobodys(nobody),
                        None => TakenFor::Nothing,
                    };
                    let watch = judge.watches.entry(tracklet.id).or_insert_with(Watch::new);
                    if let Some(judged) = watch.look(tracklet, &mut curve, (taken_for, jumps), radar) {
                        seen.push((tracklet.id, Claim::of(transponder.identity, judged)));
                    }
                }
                judge.weigh(&self.claims, tracklets);
            }
            judge.watches.values_mut().for_each(Watch::rest);
        }
        seen.into_iter().for_each(|(tracklet, claim)| self.claims.note(tracklet, claim));
    }

    /// The states that follow.
    fn settle(&mut self, tracklets: &Tracklets, targets: &Targets, cycle: &Cycle) {
        let Self { reports, judges, claims, words, twins, second, doubted, .. } = self;
        let rules = &cycle.settings.integrity;
        let now = cycle.centre.nanos().div_euclid(SECOND.as_nanos() as i64);
        let is_next = second.replace(now) != Some(now);
        let is_crowd = judges.len() > JUDGES_MAX;
        judges.retain(|&identity, judge| {
            let is_of_note = !is_crowd && judge.is_of_note() && cycle.centre - judge.heard() <= FORGOTTEN;
            let is_kept = is_of_note || targets.of_identity(identity).is_some();
            if !is_kept {
                claims.forget(identity);
            }
            is_kept
        });
        twins.clear();
        for (&identity, judge) in judges {
            let trust = words.get(&identity).map(|held| held.word.trust);
            let mut finding = reports.finding(identity);
            if finding.still_since.is_some() && judge.is_seen_moving(tracklets, cycle.centre) {
                finding.failed.insert(Reason::Frozen);
            }
            if doubted.contains(&identity) && trust != Some(Trust::Trusted) {
                judge.withdraw_agreement();
            }
            // Where nothing has changed, once a second is enough.
            if is_next || judge.has_news(&finding) {
                judge.judge(cycle.centre, &finding, trust, rules);
            }
            judge.set_silent(finding.silent_since);
            if rules.show_twin
                && let Some((tracklet, motion)) = judge.twin()
                && let Some(liar) = targets.of_identity(identity)
            {
                twins.insert(tracklet, Twin { liar, motion });
            }
        }
    }

    /// What radars see where a suspect is not is another aircraft than what the suspect says; with `split` all they see is.
    pub(super) fn part(
        &self,
        decided: &mut Decided,
        tracklets: &Tracklets,
        targets: &Targets,
        settings: &Settings,
    ) {
        let rules = &settings.integrity;
        if rules.show_twin {
            for (&id, twin) in &self.twins {
                tracklets.get(id).into_iter().for_each(|tracklet| decided.part(tracklet, twin.liar));
            }
        }
        if rules.action == Action::Split {
            for liar in self.flagged(targets) {
                tracklets.iter().for_each(|tracklet| decided.part(tracklet, liar));
            }
        }
    }

    /// A suspect says nothing of registration and delays. Identities of a host that steered a registration are noted.
    pub(super) fn protect(
        &mut self,
        registrations: &mut Registrations,
        targets: &Targets,
        settings: &Settings,
        now: Time,
    ) {
        let trusted = self.words.values().filter(|held| held.word.trust == Trust::Trusted);
        registrations.trusted = trusted.map(|held| held.word.identity).collect();
        self.doubted = registrations.doubted(targets);
        if settings.integrity.protect {
            registrations.disbelieve(self.flagged(targets).collect(), now);
        }
    }

    fn flagged(&self, targets: &Targets) -> impl Iterator<Item = TargetId> {
        let flagged = self.judges.iter().filter(|(_, judge)| judge.state().is_flagged());
        flagged.filter_map(|(&identity, _)| targets.of_identity(identity))
    }

    /// Radar tracks that see an aircraft where its transponder is not, as far as that is to be shown.
    pub(super) fn twins(&self) -> &Twins {
        &self.twins
    }

    /// Marks the points of the slot, and says what is wrong at it.
    pub(super) fn mark(
        &mut self,
        points: &mut [Point],
        tracklets: &Tracklets,
        targets: &Targets,
        cycle: &Cycle,
    ) -> Vec<Concern> {
        let rules = &cycle.settings.integrity;
        if rules.action == Action::Off {
            return Vec::new();
        }
        let Self { reports, judges, twins, .. } = self;
        for point in points.iter_mut() {
            match point.source.transponder() {
                Some(part) => {
                    if let Some(judge) = judges.get_mut(&part.identity) {
                        judge
                            .show(part, Shown { track: point.number, is_seen: marks::is_seen(point, cycle) });
                    }
                }
                None => marks::note_radar_only(point, judges, twins, tracklets, targets, cycle),
            }
        }
        lost::explain(points, reports, targets, cycle);
        // A gap is no concern of anybody's; a jamming is one, and not as many as it silences.
        let concerns = |concern: &Concern| match concern {
            Concern::Silent { identity, .. } => reports.is_missed(*identity),
            _ => true,
        };
        let mut concerns: Vec<Concern> =
            judges.values_mut().flat_map(Judge::concerns).filter(concerns).collect();
        if let Some(Jammed { identities, places, since }) = reports.jammed().cloned() {
            concerns.push(Concern::Jamming { identities, places, since });
        }
        marks::flag(points, judges, rules);
        concerns
    }

    /// The same without radar tracks: what outlives a silence of all sensors.
    pub(super) fn without_tracks(self) -> Self {
        let Self { mut reports, words, .. } = self;
        reports.start_afresh();
        Self { reports, words, ..Self::default() }
    }

    /// Marks the points of another picture of the deadline by what those of the slot have shown; nothing is learnt of them.
    pub(super) fn flag(&self, points: &mut [Point], slot: &[Point], cycle: &Cycle) {
        let rules = &cycle.settings.integrity;
        if rules.action == Action::Off {
            return;
        }
        let unexplained: BTreeSet<u32> =
            slot.iter().filter(|point| point.is_unexplained).map(|point| point.number).collect();
        points.iter_mut().for_each(|point| point.is_unexplained = unexplained.contains(&point.number));
        marks::flag(points, &self.judges, rules);
    }

    /// An operator's word, from the slot `since` on.
    pub(super) fn say(&mut self, word: Word, since: Slot) {
        self.judges.get_mut(&word.identity).into_iter().for_each(Judge::wake);
        match word.trust {
            Trust::Automatic => {
                self.words.remove(&word.identity);
            }
            Trust::Trusted | Trust::Distrusted => {
                self.words.insert(word.identity, HeldWord { word, since });
            }
        }
    }

    /// What is known of an identity.
    pub(super) fn judge(&self, identity: Identity) -> Option<&Judge> {
        self.judges.get(&identity)
    }

    /// Goes on with what another engine knows of an identity.
    pub(super) fn take_over(&mut self, identity: Identity, mut judge: Judge, tracklets: &Tracklets) {
        judge.watches.retain(|&id, _| tracklets.get(id).is_some());
        self.judges.insert(identity, judge);
    }

    /// The operators' words in force, by identity.
    pub(super) fn words(&self) -> impl Iterator<Item = HeldWord> {
        self.words.values().copied()
    }

    /// What is known of each identity heard lately.
    pub(super) fn assessments(&self) -> impl Iterator<Item = &Assessment> {
        self.judges.values().map(Judge::known)
    }
}
