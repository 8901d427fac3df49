//! The pass that assesses transponders, from radar tracks and from their own reports.
//!
//! Each second, every radar track is compared with the transponders around it. It is evidence on at most one of them. *Near*: the
//! track is where the transponder reports, or was there and has not flown differently since. *Far*: the track is elsewhere, but
//! flies the same motion.

mod choice;
mod formation;
mod lost;
mod marks;
mod monitor;
mod watch;

use std::collections::{BTreeMap, BTreeSet};

use jiff::SignedDuration;
use serde::{Deserialize, Serialize};

use super::cycle::Cycle;
use super::heights;
use super::ids::{TargetId, TrackletId};
use super::manual_association::DecidedPairs;
use super::places::SpatialIndex;
use super::registrations::Registrations;
use super::settings::OperationalSettings;
use super::targets::{Target, Targets};
use super::tracklets::{Tracklet, Tracklets};
use super::tuning::DRONE_SPEED_MAX_M_S;
use crate::integrity::{
    Action, ActiveOverride, Assessment, Concern, Jammed, Reason, ReportRules, StampDelay, Trust,
    TrustOverride,
};
use crate::point::Point;
use crate::report::{Fix, Identity};
use crate::slots::Slot;
use crate::time::Time;
use choice::{TrackClaim, TrackClaims};
pub(super) use monitor::IdentityMonitor;
use monitor::ShownPoint;
use watch::{SECOND, SampledCurve, TrackAssociation, Watch};

/// Distance within which a radar track is compared with a transponder, metres. [`AROUND_SIGMAS`] deviations of the azimuth bias
/// are added.
const AROUND_M: f64 = 300.0;
const AROUND_SIGMAS: f64 = 2.0;
/// Time for which an observation of a radar track as that of a transponder counts, seconds.
const CLAIMED_S: i32 = 5;
/// Time after the last report for which an assessment is kept, if a radar was compared with the identity or it was flagged.
const FORGOTTEN: SignedDuration = SignedDuration::from_hours(1);
/// Number of identities above which assessments are kept only while the identity is a target.
const MONITORS_MAX: usize = 16_384;

/// A radar track that sees an aircraft away from its transponder's position.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub(super) struct Twin {
    /// Target of the transponder.
    liar: TargetId,
    /// Log-likelihood ratio (natural) of the transponder's motion to that of another aircraft.
    pub(super) motion: f64,
}

/// All such radar tracks.
pub(super) type Twins = BTreeMap<TrackletId, Twin>;

/// Assessments of all identities with recent reports.
#[derive(Debug, Default, Serialize, Deserialize)]
pub(super) struct IdentityAssessments {
    reports: ReportRules,
    monitors: BTreeMap<Identity, IdentityMonitor>,
    claims: TrackClaims,
    /// Last second in which all identities were assessed.
    second: Option<i64>,
    twins: Twins,
    /// Operators' overrides by identity.
    overrides: BTreeMap<Identity, ActiveOverride>,
    /// Identities of hosts that have steered a registration: no radar verifies these.
    doubted: BTreeSet<Identity>,
}

impl IdentityAssessments {
    /// Processes the reports received since the last slot, in order of time.
    pub(super) fn add_reports(&mut self, fixes: &[Fix], settings: &OperationalSettings) {
        if settings.integrity.action == Action::Off {
            return;
        }
        self.reports.add_reports(fixes);
    }

    /// Assesses every identity with the reports up to the slot's deadline.
    pub(super) fn assess(&mut self, tracklets: &Tracklets, targets: &Targets, cycle: &Cycle) {
        if cycle.settings.integrity.action == Action::Off {
            return;
        }
        self.reports.evaluate(cycle.deadline);
        self.claims.begin_slot(cycle.centre + SECOND * -CLAIMED_S);
        let ended = tracklets.ended();
        if !ended.is_empty() {
            ended.iter().for_each(|&id| self.claims.end(id));
            for monitor in self.monitors.values_mut() {
                monitor.watches.retain(|id, _| ended.binary_search(id).is_err());
            }
        }
        self.observe_tracks(tracklets, targets, cycle);
        self.update_states(tracklets, targets, cycle);
    }

    /// Compares the radar tracks around each transponder, second by second, as soon as both are available. The owner of a track
    /// follows from the observations up to the previous slot, so the order of the transponders does not matter.
    fn observe_tracks<'t>(&mut self, tracklets: &'t Tracklets, targets: &Targets, cycle: &Cycle) {
        let settings = cycle.settings;
        let begin = monitor::first_end(cycle) + -SECOND;
        let last = |tracklet: &'t Tracklet| {
            let lasts = Some(tracklet).filter(|tracklet| tracklet.last() > begin);
            Some((lasts?.nearest(cycle.deadline)?.position, tracklet))
        };
        let places = SpatialIndex::of(tracklets.iter().filter_map(last));
        let widest = settings.radars().map(|(_, radar)| radar.track_errors.bias_azimuth).fold(0.0, f64::max);
        let mut seen = Vec::new();
        let mut formation: Option<BTreeSet<TargetId>> = None;
        for target in targets.iter() {
            let Some(transponder) = target.transponder() else { continue };
            let monitor = self.monitors.entry(transponder.identity).or_insert_with(|| {
                let delay = settings.delay(&transponder.identity, &transponder.kind()).unwrap_or_default();
                IdentityMonitor::new(
                    transponder.identity,
                    cycle.centre,
                    StampDelay { mean_s: delay.mean_s - delay.applied_s, sigma_s: delay.sigma_s },
                )
            });
            monitor.note_report(transponder);
            let pending: Vec<Time> = monitor.pending(transponder, cycle).collect();
            let Some(&first) = pending.first() else { continue };
            if formation.get_or_insert_with(|| formation::members(targets, cycle)).contains(&target.id()) {
                continue;
            }
            let jumps = self.reports.finding(transponder.identity).suspect.contains(Reason::Jump);
            let Some(mut curve) = SampledCurve::from(first, transponder, cycle) else { continue };
            for end in pending {
                let Some(place) = curve.advance(end) else { continue };
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
                        Some(own) if own == target.id() => TrackAssociation::Own,
                        Some(other) if targets.get(other).and_then(Target::transponder).is_some() => {
                            TrackAssociation::Another
                        }
                        Some(nobody) => TrackAssociation::Nobodys(nobody),
                        None => TrackAssociation::Nothing,
                    };
                    let watch = monitor.watches.entry(tracklet.id).or_insert_with(Watch::new);
                    if let Some(judged) = watch.observe(tracklet, &mut curve, (taken_for, jumps), radar) {
                        seen.push((tracklet.id, TrackClaim::of(transponder.identity, judged)));
                    }
                }
                monitor.weigh_evidence(&self.claims, tracklets);
            }
            monitor.watches.values_mut().for_each(Watch::discard_ahead);
        }
        seen.into_iter().for_each(|(tracklet, claim)| self.claims.record(tracklet, claim));
    }

    /// Updates the states from the evidence.
    fn update_states(&mut self, tracklets: &Tracklets, targets: &Targets, cycle: &Cycle) {
        let Self { reports, monitors, claims, overrides, twins, second, doubted, .. } = self;
        let rules = &cycle.settings.integrity;
        let now = cycle.centre.nanos().div_euclid(SECOND.as_nanos() as i64);
        let is_next = second.replace(now) != Some(now);
        let is_crowd = monitors.len() > MONITORS_MAX;
        monitors.retain(|&identity, monitor| {
            let is_of_note =
                !is_crowd && monitor.is_of_note() && cycle.centre - monitor.last_report() <= FORGOTTEN;
            let is_kept = is_of_note || targets.of_identity(identity).is_some();
            if !is_kept {
                claims.forget(identity);
            }
            is_kept
        });
        twins.clear();
        for (&identity, monitor) in monitors {
            let trust = overrides.get(&identity).map(|held| held.word.trust);
            let mut finding = reports.finding(identity);
            if finding.still_since.is_some() && monitor.is_seen_moving(tracklets, cycle.centre) {
                finding.failed.insert(Reason::Frozen);
            }
            if doubted.contains(&identity) && trust != Some(Trust::Trusted) {
                monitor.withdraw_agreement();
            }
            // Without new evidence, one update a second is enough.
            if is_next || monitor.is_outdated(&finding) {
                monitor.evaluate(cycle.centre, &finding, trust, rules);
            }
            monitor.set_silent(finding.silent_since);
            if rules.show_twin
                && let Some((tracklet, motion)) = monitor.twin()
                && let Some(liar) = targets.of_identity(identity)
            {
                twins.insert(tracklet, Twin { liar, motion });
            }
        }
    }

    /// Separates a suspect from the radar tracks that see another aircraft; with `split`, from all radar tracks.
    pub(super) fn part(
        &self,
        decided: &mut DecidedPairs,
        tracklets: &Tracklets,
        targets: &Targets,
        settings: &OperationalSettings,
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

    /// Excludes suspects from registration and delays. Stores the identities of hosts that steered a registration.
    pub(super) fn exclude_suspects(
        &mut self,
        registrations: &mut Registrations,
        targets: &Targets,
        settings: &OperationalSettings,
        now: Time,
    ) {
        let trusted = self.overrides.values().filter(|held| held.word.trust == Trust::Trusted);
        registrations.trusted = trusted.map(|held| held.word.identity).collect();
        self.doubted = registrations.doubted(targets);
        if settings.integrity.protect {
            registrations.exclude_targets(self.flagged(targets).collect(), now);
        }
    }

    fn flagged(&self, targets: &Targets) -> impl Iterator<Item = TargetId> {
        let flagged = self.monitors.iter().filter(|(_, monitor)| monitor.state().is_flagged());
        flagged.filter_map(|(&identity, _)| targets.of_identity(identity))
    }

    /// Radar tracks that see an aircraft away from its transponder's position, if these are published.
    pub(super) fn twins(&self) -> &Twins {
        &self.twins
    }

    /// Marks the points of the slot, and returns the problems with transponders.
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
        let Self { reports, monitors, twins, .. } = self;
        for point in points.iter_mut() {
            match point.source.transponder() {
                Some(part) => {
                    let shown = ShownPoint { track: point.number, is_seen: marks::is_detected(point, cycle) };
                    for part in std::iter::once(part).chain(&point.also) {
                        if let Some(monitor) = monitors.get_mut(&part.identity) {
                            monitor.set_point(part, shown);
                        }
                    }
                }
                None => marks::note_radar_only(point, monitors, twins, tracklets, targets, cycle),
            }
        }
        lost::explain(points, reports, targets, cycle);
        // A usual gap is no concern. A jamming is one concern, and its silent identities are not reported singly.
        let concerns = |concern: &Concern| match concern {
            Concern::Silent { identity, .. } => reports.is_missed(*identity),
            _ => true,
        };
        let mut concerns: Vec<Concern> =
            monitors.values_mut().flat_map(IdentityMonitor::concerns).filter(concerns).collect();
        concerns.extend(heights::concerns::concerns(points, cycle));
        if let Some(Jammed { identities, places, since }) = reports.jammed().cloned() {
            concerns.push(Concern::Jamming { identities, places, since });
        }
        marks::flag(points, monitors, rules);
        concerns
    }

    /// The state without radar tracks, for a restart after silence of all sensors.
    pub(super) fn without_tracks(self) -> Self {
        let Self { mut reports, overrides, .. } = self;
        reports.restart();
        Self { reports, overrides, ..Self::default() }
    }

    /// Marks the points of another picture of the deadline with the results of the slot. It adds no evidence.
    pub(super) fn flag(&self, points: &mut [Point], slot: &[Point], cycle: &Cycle) {
        let rules = &cycle.settings.integrity;
        if rules.action == Action::Off {
            return;
        }
        let unexplained: BTreeSet<u32> =
            slot.iter().filter(|point| point.is_unexplained).map(|point| point.number).collect();
        points.iter_mut().for_each(|point| point.is_unexplained = unexplained.contains(&point.number));
        marks::flag(points, &self.monitors, rules);
    }

    /// Applies an operator's override from the slot `since` on.
    pub(super) fn set_trust(&mut self, word: TrustOverride, since: Slot) {
        self.monitors.get_mut(&word.identity).into_iter().for_each(IdentityMonitor::wake);
        match word.trust {
            Trust::Automatic => {
                self.overrides.remove(&word.identity);
            }
            Trust::Trusted | Trust::Distrusted => {
                self.overrides.insert(word.identity, ActiveOverride { word, since });
            }
        }
    }

    /// Whether an identity is suspect or failed.
    pub(super) fn is_flagged(&self, identity: Identity) -> bool {
        self.monitors.get(&identity).is_some_and(|monitor| monitor.state().is_flagged())
    }

    /// State of an identity.
    pub(super) fn monitor(&self, identity: Identity) -> Option<&IdentityMonitor> {
        self.monitors.get(&identity)
    }

    /// Takes over an identity's state from another engine.
    pub(super) fn take_over(
        &mut self,
        identity: Identity,
        mut monitor: IdentityMonitor,
        tracklets: &Tracklets,
    ) {
        monitor.watches.retain(|&id, _| tracklets.get(id).is_some());
        self.monitors.insert(identity, monitor);
    }

    /// The operators' overrides in force, by identity.
    pub(super) fn trust_overrides(&self) -> impl Iterator<Item = ActiveOverride> {
        self.overrides.values().copied()
    }

    /// Assessments of all identities with recent reports.
    pub(super) fn assessments(&self) -> impl Iterator<Item = &Assessment> {
        self.monitors.values().map(IdentityMonitor::published)
    }
}
