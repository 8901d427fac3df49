//! The pass that judges transponders: states from the evidence of radar tracks and from their own reports.
//!
//! Second by second each radar track is compared with the transponders around. It is evidence of one at most: *near* where it is
//! where the transponder says, or has been and does not fly otherwise since; *far* where it is elsewhere and flies alike.

mod judge;
mod watch;

use std::collections::BTreeMap;

use super::cycle::Cycle;
use super::ids::{TargetId, TrackletId};
use super::places::Places;
use super::settings::Settings;
use super::targets::Targets;
use super::tracklets::Tracklets;
use super::tuning::DELAY_BETWEEN_TRANSPONDERS_S;
use crate::filter::LineOfSight;
use crate::integrity::{
    Action, Assessment, Concern, Delay, HeldWord, PointIntegrity, ReportRules, Trust, Word,
};
use crate::point::Point;
use crate::report::{Fix, Identity};
use crate::slots::Slot;
use crate::time::Time;
use judge::Judge;
use watch::{Judged, SECOND, Watch};

/// A radar track further away than this is not looked at, metres, beside so many deviations of its slow errors.
const AROUND_M: f64 = 300.0;
const AROUND_SIGMAS: f64 = 2.0;
/// Far: it flies so much likelier as this aircraft than as another one, and than as any other transponder's.
const FAR_MOTION: f64 = 3.0;
const FAR_LEAD: f64 = 3.0;
/// Far: the radar takes it for a drone with at least this mean probability, and it is no higher or lower than this, metres.
const FAR_PROBABILITY: f64 = 0.3;
const FAR_HEIGHT_M: f64 = 45.0;
/// Far: no radar track was near for so long, seconds.
const FAR_ALONE_S: f64 = 3.0;
/// Identities not heard for longer are forgotten, seconds.
const FORGOTTEN_S: f64 = 3600.0;

/// What is known of every identity heard lately.
#[derive(Debug, Default)]
pub(super) struct Integrities {
    reports: ReportRules,
    judges: BTreeMap<Identity, Judge>,
    /// Time of the newest report of each.
    heard: BTreeMap<Identity, Time>,
    assessments: BTreeMap<Identity, Assessment>,
    /// What operators say, by identity.
    words: BTreeMap<Identity, HeldWord>,
    /// The last second that was judged ended then.
    judged: Option<Time>,
}

/// A radar track as seen from a transponder.
struct Sighting {
    identity: Identity,
    tracklet: TrackletId,
    judged: Judged,
    /// Whether the association takes them for one.
    is_pair: bool,
}

impl Integrities {
    /// Takes the reports that came since the last slot, by time.
    pub(super) fn hear(&mut self, fixes: &[Fix], settings: &Settings) {
        if settings.integrity.action == Action::Off {
            return;
        }
        self.reports.take(fixes);
        for fix in fixes {
            let heard = self.heard.entry(fix.identity).or_insert(fix.time);
            *heard = (*heard).max(fix.time);
        }
    }

    /// Judges every identity by what is known at the slot's deadline.
    pub(super) fn assess(&mut self, tracklets: &Tracklets, targets: &Targets, cycle: &Cycle) {
        let rules = &cycle.settings.integrity;
        if rules.action == Action::Off {
            return;
        }
        self.reports.look(cycle.deadline);
        let length = SECOND.as_nanos() as i64;
        let whole = Time::from_nanos(cycle.centre.nanos().div_euclid(length) * length);
        let first = self.judged.map_or(whole, |judged| judged + SECOND).max(whole + SECOND * -5);
        let mut end = first;
        while end <= whole {
            self.look(tracklets, targets, end, cycle);
            end = end + SECOND;
        }
        self.judged = Some(whole);
        self.settle(cycle);
    }

    /// Looks at the second that ends at `end`.
    fn look(&mut self, tracklets: &Tracklets, targets: &Targets, end: Time, cycle: &Cycle) {
        let sightings = self.sightings(tracklets, targets, end, cycle);
        let near = claims(&sightings);
        let mut by_identity: BTreeMap<Identity, Vec<&Sighting>> = BTreeMap::new();
        for sighting in &sightings {
            by_identity.entry(sighting.identity).or_default().push(sighting);
        }
        for (identity, own) in by_identity {
            let Some(judge) = self.judges.get_mut(&identity) else { continue };
            let current = judge.current();
            let is_current = |one: &Sighting| current.is_some_and(|current| current.0 == one.tracklet);
            let nearest =
                own.iter().filter(|one| near.get(&one.tracklet) == Some(&identity)).min_by(|a, b| {
                    let order = |one: &Sighting| (!is_current(one), !one.is_pair);
                    order(a).cmp(&order(b)).then(a.judged.away.total_cmp(&b.judged.away))
                });
            let chosen = match nearest {
                Some(one) => Some((one, true)),
                None => {
                    let is_alone = current
                        .is_none_or(|(_, is_near, last)| !is_near || end.seconds_since(last) > FAR_ALONE_S);
                    let far = own.iter().filter(|one| !near.contains_key(&one.tracklet));
                    far.filter(|one| is_alone && is_far(one, &sightings, tracklets))
                        .max_by(|a, b| {
                            let order = |one: &Sighting| is_current(one);
                            order(a).cmp(&order(b)).then(a.judged.motion.total_cmp(&b.judged.motion))
                        })
                        .map(|one| (one, false))
                }
            };
            if let Some((one, is_near)) = chosen
                && !one.judged.walks_off
                && let Some(tracklet) = tracklets.get(one.tracklet)
            {
                judge.take(one.tracklet, tracklet.key, &one.judged, is_near);
            }
        }
    }

    /// Each radar track from each transponder around.
    fn sightings(
        &mut self,
        tracklets: &Tracklets,
        targets: &Targets,
        end: Time,
        cycle: &Cycle,
    ) -> Vec<Sighting> {
        let settings = cycle.settings;
        let middle = end + -SECOND / 2;
        let place = |target: &super::targets::Target| {
            Some((target.on_curve(middle, settings)?.position, target.id()))
        };
        let places = Places::of(targets.iter().filter_map(place));
        let mut sightings = Vec::new();
        for tracklet in tracklets.iter() {
            let Some(radar) = settings.radar(tracklet.key.sensor) else { continue };
            let Some(plot) = tracklet.between(end + -SECOND, end).next_back() else { continue };
            let range_m = LineOfSight::from(radar.position, plot.position).range_m;
            let around_m = AROUND_M + AROUND_SIGMAS * range_m * radar.track_errors.bias_azimuth;
            let mut around: Vec<TargetId> =
                places.within(plot.position, around_m).map(|near| near.1).collect();
            around.sort_unstable();
            for id in around {
                let Some(target) = targets.get(id) else { continue };
                let Some(transponder) = target.transponder() else { continue };
                let delay = settings.delay(&transponder.kind()).unwrap_or_default();
                let judge = self.judges.entry(transponder.identity).or_insert_with(|| {
                    let sigma_s = DELAY_BETWEEN_TRANSPONDERS_S.hypot(delay.sigma_s);
                    Judge::new(end, Delay { mean_s: delay.mean_s - delay.applied_s, sigma_s })
                });
                let watch = judge.watches.entry(tracklet.id).or_insert_with(Watch::new);
                let known = (end, cycle.deadline);
                if let Some(judged) = watch.look(tracklet, transponder, known, radar, settings) {
                    let is_pair = tracklet.target() == Some(id);
                    let identity = transponder.identity;
                    sightings.push(Sighting { identity, tracklet: tracklet.id, judged, is_pair });
                }
            }
        }
        for judge in self.judges.values_mut() {
            judge.watches.retain(|&id, _| tracklets.get(id).is_some());
        }
        sightings
    }

    /// The states that follow.
    fn settle(&mut self, cycle: &Cycle) {
        let Self { reports, judges, heard, assessments, words, .. } = self;
        heard.retain(|_, heard| cycle.centre.seconds_since(*heard) <= FORGOTTEN_S);
        judges.retain(|identity, _| heard.contains_key(identity));
        assessments.clear();
        for (&identity, &heard) in &*heard {
            let trust = words.get(&identity).map(|held| held.word.trust);
            let judge = judges
                .entry(identity)
                .or_insert_with(|| Judge::new(cycle.centre, Delay { mean_s: 0.0, sigma_s: 0.1 }));
            judge.judge(cycle.centre, &reports.finding(identity), trust, &cycle.settings.integrity);
            let mut assessment = judge.assessment(identity, cycle.centre, heard, trust);
            assessment.is_silent = reports.silent_since(identity).is_some();
            assessments.insert(identity, assessment);
        }
    }

    /// Marks the points of the slot, and says what is wrong at it.
    pub(super) fn mark(&self, points: &mut [Point]) -> Vec<Concern> {
        let mut tracks = BTreeMap::new();
        for point in points {
            let Some(part) = point.source.transponder() else { continue };
            tracks.insert(part.identity, point.number);
            point.integrity = self.assessments.get(&part.identity).map(|known| known.integrity);
        }
        let flagged = self.assessments.values().filter(|known| known.integrity.state.is_flagged());
        flagged
            .map(|known| {
                let PointIntegrity { state, reasons, offset_m, .. } = known.integrity;
                let track = tracks.get(&known.identity).copied();
                Concern::Integrity {
                    identity: known.identity,
                    track,
                    twin: known.twin,
                    state,
                    reasons,
                    offset_m,
                }
            })
            .collect()
    }

    /// An operator's word, from the slot `since` on.
    pub(super) fn say(&mut self, word: Word, since: Slot) {
        match word.trust {
            Trust::Automatic => _ = self.words.remove(&word.identity),
            Trust::Trusted | Trust::Distrusted => {
                _ = self.words.insert(word.identity, HeldWord { word, since })
            }
        }
    }

    /// The operators' words in force, by identity.
    pub(super) fn words(&self) -> impl Iterator<Item = HeldWord> {
        self.words.values().copied()
    }

    /// What is known of each identity heard lately.
    pub(super) fn assessments(&self) -> impl Iterator<Item = &Assessment> {
        self.assessments.values()
    }
}

/// Whose each radar track is that is near somebody, or was for long: that of the pair, else of the nearest.
fn claims(sightings: &[Sighting]) -> BTreeMap<TrackletId, Identity> {
    let mut claims: BTreeMap<TrackletId, &Sighting> = BTreeMap::new();
    for one in sightings.iter().filter(|one| one.judged.is_near() || one.judged.is_loyal) {
        let order = |one: &Sighting| (!one.judged.is_near(), !one.is_pair);
        let is_better = |other: &&Sighting| {
            order(one).cmp(&order(other)).then(one.judged.away.total_cmp(&other.judged.away)).is_lt()
        };
        if claims.get(&one.tracklet).is_none_or(is_better) {
            claims.insert(one.tracklet, one);
        }
    }
    claims.into_iter().map(|(tracklet, one)| (tracklet, one.identity)).collect()
}

/// Whether a radar track that is nobody's flies as this transponder does, and as no other.
fn is_far(one: &Sighting, sightings: &[Sighting], tracklets: &Tracklets) -> bool {
    let others =
        sightings.iter().filter(|other| other.tracklet == one.tracklet && other.identity != one.identity);
    let other = others.map(|other| other.judged.motion).fold(f64::NEG_INFINITY, f64::max);
    let is_drone = tracklets.get(one.tracklet).is_some_and(|tracklet| {
        let (seconds, mean) = tracklet.existence().class();
        seconds == 0.0 || mean > FAR_PROBABILITY
    });
    let is_level = one.judged.second.height_m.is_none_or(|height_m| height_m.abs() < FAR_HEIGHT_M);
    one.judged.motion > FAR_MOTION && one.judged.motion > other + FAR_LEAD && is_drone && is_level
}
