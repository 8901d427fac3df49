//! Handover of an aircraft, or of an unassigned radar track, from one engine to another that begins to receive its
//! reports.
//!
//! Whether a track is a drone, which aircraft it belongs to and where that aircraft must be follow from all of its
//! plots. Some decisions are permanent: a track once confirmed as a drone stays one. An engine with fewer plots would
//! decide otherwise. So the state is handed over, and both engines agree from then on, as long as both receive the same
//! reports. The identifiers of tracks and targets are those of the sending engine ([`TrackletId`], [`TargetId`]);
//! references to objects that only that engine has are omitted.

use std::collections::BTreeSet;

use serde::{Deserialize, Serialize};

use super::Operational;
use super::cycle::EARLIEST;
use super::ids::{TargetId, TrackletId};
use super::integrity::IdentityMonitor;
use super::likelihood::PairLikelihood;
use super::manual_association::DecidedPair;
use super::radar_pairs;
use super::settings::OperationalSettings;
use super::targets::{Target, Targets};
use super::tracklets::Tracklet;
use crate::checkpoint::LAYOUT;
use crate::frames::Enu;
use crate::report::Fix;
use crate::time::Time;

/// Reference to an aircraft or a radar track, valid in every engine that observed its start or received its state.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct TrackRef(TrackRefKind);

#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
enum TrackRefKind {
    Target(TargetId),
    Track(TrackletId),
}

/// State of an aircraft with its radar tracks, or of an unassigned radar track, from one engine.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct TrackHandover {
    /// Version of the layout, that of a checkpoint.
    layout: u16,
    /// Centre of the slot up to which the state is settled.
    until: Time,
    octets: Vec<u8>,
}

/// Maximum age of a state, seconds: after that the aircraft has flown on.
const AWAITED_S: f64 = 5.0;

/// Handed-over states that are ahead of this engine's time.
#[derive(Debug, Default, Serialize, Deserialize)]
pub(super) struct PendingHandovers(Vec<TrackHandover>);

/// Serialised form of a handover.
#[derive(Debug, Serialize)]
struct SerialisedHandover<'a> {
    target: Option<&'a Target>,
    tracklets: Vec<&'a Tracklet>,
    pairs: Vec<(TrackletId, &'a PairLikelihood)>,
    monitor: Option<&'a IdentityMonitor>,
    decisions: Vec<DecidedPair>,
}

/// Deserialised form of a handover.
#[derive(Debug, Deserialize)]
struct DeserialisedHandover {
    target: Option<Target>,
    tracklets: Vec<Tracklet>,
    /// Likelihoods that other radar tracks are this aircraft.
    pairs: Vec<(TrackletId, PairLikelihood)>,
    monitor: Option<IdentityMonitor>,
    /// Operators' decisions on the radar tracks.
    decisions: Vec<DecidedPair>,
}

impl Operational {
    /// All aircraft and unassigned radar tracks, each with its position in the slot that was decided last.
    pub(crate) fn names(&self) -> Vec<(TrackRef, Enu)> {
        let Some(time) = self.decided else { return Vec::new() };
        let targets = self.targets.iter().filter_map(|target| {
            Some((TrackRef(TrackRefKind::Target(target.id())), target.estimate(time)?.position))
        });
        let tracks = self.tracklets.iter().filter(|tracklet| tracklet.target().is_none());
        let tracks = tracks.filter_map(|tracklet| {
            Some((TrackRef(TrackRefKind::Track(tracklet.id)), tracklet.nearest(time)?.position))
        });
        targets.chain(tracks).collect()
    }

    /// Reference to the aircraft that is published with this number.
    pub(crate) fn numbered(&self, number: u32) -> Option<TrackRef> {
        let mut targets = self.targets.iter().filter(|target| !self.targets.is_companion(target.id()));
        let shown = |target: &Target| self.targets.number_shown(target);
        let target = targets.find(|target| shown(target).is_some_and(|own| own.number == number))?;
        Some(TrackRef(TrackRefKind::Target(target.id())))
    }

    /// State of an aircraft or a radar track for a handover. It includes the unassigned radar tracks that could be this
    /// aircraft and whose position is `around`.
    pub(crate) fn handover(
        &self,
        TrackRef(name): TrackRef,
        around: impl Fn(Enu) -> bool,
    ) -> Option<TrackHandover> {
        let Self { targets, tracklets, correlations, integrities, .. } = self;
        let until = self.decided?;
        let (target, tracklets, pairs) = match name {
            TrackRefKind::Target(id) => {
                let target = targets.get(id)?;
                let could_be = |other: &Tracklet| {
                    let is_near = |own: &Tracklet| other.mutual_with(own.id).is_some();
                    other.target().is_none()
                        && (other.pair(id).is_some() || target.followed(tracklets).any(is_near))
                };
                let is_around =
                    |other: &Tracklet| other.nearest(until).is_some_and(|plot| around(plot.position));
                let own = |tracklet: &&Tracklet| {
                    tracklet.target() == Some(id) || (could_be(tracklet) && is_around(tracklet))
                };
                let (own, others): (Vec<_>, Vec<_>) = tracklets.iter().partition(own);
                let pairs = others.into_iter().filter_map(|other| Some((other.id, other.pair(id)?)));
                (Some(target), own, pairs.collect())
            }
            TrackRefKind::Track(id) => (None, vec![tracklets.get(id)?], Vec::new()),
        };
        let monitor = target.and_then(Target::identity).and_then(|identity| integrities.monitor(identity));
        let decisions = tracklets.iter().flat_map(|tracklet| correlations.of(tracklet.id)).collect();
        let octets =
            postcard::to_stdvec(&SerialisedHandover { target, tracklets, pairs, monitor, decisions })
                .expect("every state can be written down");
        Some(TrackHandover { layout: LAYOUT, until, octets })
    }

    /// Stores a state of another engine until this one has reached the same slot.
    pub(crate) fn store_handover(&mut self, acquaintance: TrackHandover) {
        self.awaited.0.push(acquaintance);
    }

    /// Applies the stored states up to the slot that was decided last.
    pub(super) fn apply_pending_handovers(&mut self, settings: &OperationalSettings) {
        let Some(decided) = self.decided else { return };
        let awaited = std::mem::take(&mut self.awaited.0);
        let (due, later): (Vec<_>, Vec<_>) = awaited.into_iter().partition(|known| known.until <= decided);
        self.awaited.0 = later;
        for TrackHandover { layout, until, octets } in due {
            let is_fresh = layout == LAYOUT && decided.seconds_since(until) <= AWAITED_S;
            // Another version has another layout; this engine then continues with its own state.
            let read: Option<DeserialisedHandover> =
                is_fresh.then(|| postcard::from_bytes(&octets).ok()).flatten();
            // An object that is known here would fall back to an earlier state.
            if let Some(read) = read.filter(|read| until == decided || !self.is_known(read)) {
                self.apply_handover(read, (until, decided), settings);
            }
        }
    }

    /// Whether this engine has the object by the same identifier, from its own reports or an earlier handover.
    fn is_known(&self, read: &DeserialisedHandover) -> bool {
        match &read.target {
            Some(target) => self.targets.get(target.id()).is_some(),
            None => read.tracklets.iter().all(|tracklet| self.tracklets.get(tracklet.id).is_some()),
        }
    }

    /// Replaces this engine's state of the object, and updates it from the slot of the handover to the one that was
    /// decided last.
    fn apply_handover(
        &mut self,
        read: DeserialisedHandover,
        (until, decided): (Time, Time),
        settings: &OperationalSettings,
    ) {
        let DeserialisedHandover { target, mut tracklets, pairs, monitor, decisions } = read;
        let id = target.as_ref().map(Target::id);
        let identity = target.as_ref().and_then(Target::identity);
        // This engine's own targets of the aircraft, and the numbers under which they were published.
        let before = identity.and_then(|identity| self.targets.of_identity(identity));
        let mut numbers = Vec::new();
        let mut fixes: Vec<Fix> = Vec::new();
        for before in BTreeSet::from_iter(before.into_iter().chain(id)) {
            if let Some(known) = self.targets.detach(before) {
                fixes.extend(known.transponder().into_iter().flat_map(|own| own.after(EARLIEST)));
                numbers.extend(known.number());
                let own = self.tracklets.iter_mut().filter(|tracklet| tracklet.target() == Some(before));
                own.for_each(|tracklet| _ = tracklet.replace_target(None));
            }
        }
        for tracklet in &mut tracklets {
            let Some(radar) = settings.radar(tracklet.key.sensor) else { continue };
            for known in self.tracklets.take_same(tracklet, radar) {
                numbers.extend(known.target().and_then(|left| self.targets.dissociate(left, known.id)));
                self.correlations.rename(known.id, tracklet.id);
                tracklet.merge(known);
            }
        }
        self.correlations.take_over(decisions);
        let own: Vec<TrackletId> = tracklets.iter().map(|tracklet| tracklet.id).collect();
        tracklets.into_iter().for_each(|tracklet| self.tracklets.insert_handover(tracklet));
        if let Some(mut target) = target {
            if let Some(identity) = identity {
                fixes.extend(self.admission.admit(identity));
            }
            target.resume(fixes, numbers.first().copied());
            numbers = numbers.split_off(numbers.len().min(1));
            self.targets.insert(target);
        }
        numbers.into_iter().for_each(|number| self.targets.release(number));
        if let (Some(identity), Some(monitor)) = (identity, monitor) {
            self.integrities.take_over(identity, monitor, &self.tracklets);
        }
        self.catch_up(&own, id, pairs, (until, decided), settings);
    }

    /// Compares the new objects with all others for the time since the handover.
    fn catch_up(
        &mut self,
        own: &[TrackletId],
        target: Option<TargetId>,
        pairs: Vec<(TrackletId, PairLikelihood)>,
        since: (Time, Time),
        settings: &OperationalSettings,
    ) {
        let Self { tracklets, targets, .. } = self;
        for (other, pair) in pairs {
            if let Some((other, target)) = tracklets.get_mut(other).zip(target) {
                other.set_known_pair(target, pair);
                compare(other, &[target], targets, since, settings);
            }
        }
        for &id in own {
            let Some(tracklet) = tracklets.get_mut(id) else { continue };
            let compared: Vec<TargetId> = tracklet.pairs().iter().map(|pair| pair.0).collect();
            compare(tracklet, &compared, targets, since, settings);
            radar_pairs::catch_up(tracklets, id, own, since, settings);
        }
    }
}

/// Adds the plots of a period to a track's likelihoods with these targets.
fn compare(
    tracklet: &mut Tracklet,
    compared: &[TargetId],
    targets: &Targets,
    since: (Time, Time),
    settings: &OperationalSettings,
) {
    let Some(radar) = settings.radar(tracklet.key.sensor) else { return };
    for &id in compared {
        if let Some(transponder) = targets.get(id).and_then(Target::transponder) {
            tracklet.compare(id, transponder, since, radar, settings);
        }
    }
}
