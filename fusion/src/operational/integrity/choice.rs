//! Choice of the radar track that is evidence about a transponder: at most one, and each for at most one transponder.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::watch::{TrackAssociation, WatchResult};
use crate::operational::ids::TrackletId;
use crate::operational::tracklets::Tracklets;
use crate::report::Identity;
use crate::time::Time;

/// Minimum LLR by motion of a distant track, for this aircraft against another one; minimum lead over any other
/// transponder.
const FAR_MOTION: f64 = 0.0;
const FAR_LEAD: f64 = 3.0;
/// Minimum class probability of a distant track, and maximum height difference, metres.
const DRONE_PROBABILITY: f64 = 0.3;
const FAR_HEIGHT_M: f64 = 45.0;
/// Prior probability that a radar track is of this aircraft: an associated one, a near one, a distant one.
const OWN_PAIR: f64 = 0.9;
const OWN_NEAR: f64 = 0.7;
const OWN_FAR: f64 = 0.35;

/// Distance between a radar track and a transponder; the smallest is the nearest.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
struct Nearness {
    is_elsewhere: bool,
    is_no_pair: bool,
    /// Squared distance in standard deviations.
    away: f64,
}

impl Nearness {
    fn of(judged: &WatchResult) -> Self {
        Self { is_elsewhere: !judged.is_near(), is_no_pair: !judged.is_pair(), away: judged.away }
    }

    fn is_less(&self, other: &Self) -> bool {
        let order = |one: &Self| (one.is_elsewhere, one.is_no_pair);
        order(self).cmp(&order(other)).then(self.away.total_cmp(&other.away)).is_lt()
    }
}

/// Observation of a radar track from a transponder.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub(super) struct TrackClaim {
    identity: Identity,
    time: Time,
    /// LLR by motion, for this aircraft against another one.
    motion: f64,
    nearness: Nearness,
    /// Whether it is near, or was for long.
    is_near: bool,
}

impl TrackClaim {
    /// Creates a claim from an observation.
    pub(super) fn of(identity: Identity, judged: &WatchResult) -> Self {
        Self {
            identity,
            time: judged.second.look.time,
            motion: judged.motion,
            nearness: Nearness::of(judged),
            is_near: judged.is_near() || judged.is_loyal,
        }
    }
}

/// Recent observations of each radar track, up to the previous slot.
#[derive(Debug, Default, Serialize, Deserialize)]
pub(super) struct TrackClaims {
    /// Claims by radar track, ordered by identity.
    all: BTreeMap<TrackletId, Vec<TrackClaim>>,
    /// Time before which claims are outdated.
    since: Option<Time>,
}

impl TrackClaims {
    /// Starts a slot: claims count from `since` on.
    pub(super) fn begin_slot(&mut self, since: Time) {
        self.since = Some(since);
    }

    /// Removes a radar track that has ended.
    pub(super) fn end(&mut self, tracklet: TrackletId) {
        self.all.remove(&tracklet);
    }

    /// Stores the observation of a radar track from a transponder.
    pub(super) fn record(&mut self, tracklet: TrackletId, claim: TrackClaim) {
        let claims = self.all.entry(tracklet).or_default();
        match claims.binary_search_by_key(&claim.identity, |other| other.identity) {
            Ok(index) => claims[index] = claim,
            Err(index) => claims.insert(index, claim),
        }
    }

    /// Removes an identity.
    pub(super) fn forget(&mut self, identity: Identity) {
        self.all.values_mut().for_each(|claims| claims.retain(|claim| claim.identity != identity));
    }

    fn of(&self, tracklet: TrackletId) -> impl Iterator<Item = &TrackClaim> + Clone {
        let claims = self.all.get(&tracklet).into_iter().flatten();
        claims.filter(|claim| self.since.is_some_and(|since| claim.time >= since))
    }

    /// Prior assignment of the radar track to the transponder; `None`: it is not used as evidence.
    pub(super) fn evidence_reason(
        &self,
        tracklet: TrackletId,
        identity: Identity,
        judged: &WatchResult,
        is_current: bool,
        tracklets: &Tracklets,
    ) -> Option<EvidenceReason> {
        let is_near = judged.is_near() || judged.is_loyal;
        // The associated transponder, otherwise the nearest one.
        let nearer = |best: &'_ TrackClaim, other: &TrackClaim| other.nearness.is_less(&best.nearness);
        let claims = self.of(tracklet);
        let near = claims.clone().filter(|claim| claim.is_near);
        let nearest = near.reduce(|best, other| if nearer(best, other) { other } else { best });
        let another = nearest.filter(|claim| claim.identity != identity);
        match another {
            Some(other) if !is_near || other.nearness.is_less(&Nearness::of(judged)) => None,
            _ if judged.is_pair() => Some(EvidenceReason::Pair),
            _ if !is_drone(tracklet, tracklets) => None,
            _ if is_near => Some(EvidenceReason::Near),
            _ if is_current || is_far(claims, identity, judged) => Some(EvidenceReason::Far),
            _ => None,
        }
    }
}

/// Whether an unassigned radar track moves like this transponder, and like no other.
fn is_far<'a>(
    claims: impl Iterator<Item = &'a TrackClaim>,
    identity: Identity,
    judged: &WatchResult,
) -> bool {
    let others = claims.filter(|claim| claim.identity != identity);
    let other = others.map(|other| other.motion).fold(f64::NEG_INFINITY, f64::max);
    let is_level = judged.second.height_m.is_none_or(|height_m| height_m.abs() < FAR_HEIGHT_M);
    judged.taken_for != TrackAssociation::Another
        && judged.motion > FAR_MOTION
        && judged.motion > other + FAR_LEAD
        && is_level
}

/// Whether the radar classifies it as a drone.
fn is_drone(tracklet: TrackletId, tracklets: &Tracklets) -> bool {
    tracklets.get(tracklet).is_some_and(|tracklet| {
        let (seconds, mean) = tracklet.existence().class();
        seconds == 0.0 || mean > DRONE_PROBABILITY
    })
}

/// Reason for using a radar track as evidence.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum EvidenceReason {
    Far,
    Near,
    /// The association assigns it to the aircraft.
    Pair,
}

impl EvidenceReason {
    /// Prior probability that the track is of this aircraft.
    pub(super) fn probability(self) -> f64 {
        match self {
            Self::Far => OWN_FAR,
            Self::Near => OWN_NEAR,
            Self::Pair => OWN_PAIR,
        }
    }
}
