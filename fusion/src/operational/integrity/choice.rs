//! Which radar track is evidence of a transponder: one at most, and of one transponder at most.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::watch::{Judged, TakenFor};
use crate::operational::ids::TrackletId;
use crate::operational::tracklets::Tracklets;
use crate::report::Identity;
use crate::time::Time;

/// Far: it flies so much likelier as this aircraft than as another one, and than as any other transponder's.
const FAR_MOTION: f64 = 0.0;
const FAR_LEAD: f64 = 3.0;
/// Far: the radar takes it for a drone with at least this mean probability, and it is no higher or lower than this, metres.
const DRONE_PROBABILITY: f64 = 0.3;
const FAR_HEIGHT_M: f64 = 45.0;
/// Probability that a radar track is the aircraft's own before it is looked at: one that the association takes for it, one that
/// is near, one that is elsewhere.
const OWN_PAIR: f64 = 0.9;
const OWN_NEAR: f64 = 0.7;
const OWN_FAR: f64 = 0.35;

/// How near a radar track is to a transponder: the least is the nearest.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
struct Nearness {
    is_elsewhere: bool,
    is_no_pair: bool,
    /// Squared deviations.
    away: f64,
}

impl Nearness {
    fn of(judged: &Judged) -> Self {
        Self { is_elsewhere: !judged.is_near(), is_no_pair: !judged.is_pair(), away: judged.away }
    }

    fn is_less(&self, other: &Self) -> bool {
        let order = |one: &Self| (one.is_elsewhere, one.is_no_pair);
        order(self).cmp(&order(other)).then(self.away.total_cmp(&other.away)).is_lt()
    }
}

/// A radar track as it was seen from a transponder.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub(super) struct Claim {
    identity: Identity,
    time: Time,
    /// How much likelier it flies as this aircraft than as another one, natural logarithm.
    motion: f64,
    nearness: Nearness,
    /// Whether it is near, or was for long.
    is_near: bool,
}

impl Claim {
    /// What is made of a look.
    pub(super) fn of(identity: Identity, judged: &Judged) -> Self {
        Self {
            identity,
            time: judged.second.look.time,
            motion: judged.motion,
            nearness: Nearness::of(judged),
            is_near: judged.is_near() || judged.is_loyal,
        }
    }
}

/// As whose each radar track was seen lately, up to the slot before.
#[derive(Debug, Default, Serialize, Deserialize)]
pub(super) struct Claims {
    /// By identity.
    all: BTreeMap<TrackletId, Vec<Claim>>,
    /// Those before are out of date.
    since: Option<Time>,
}

impl Claims {
    /// A slot begins: claims count from `since` on.
    pub(super) fn turn(&mut self, since: Time) {
        self.since = Some(since);
    }

    /// A radar track has ended.
    pub(super) fn end(&mut self, tracklet: TrackletId) {
        self.all.remove(&tracklet);
    }

    /// A radar track as seen from a transponder.
    pub(super) fn note(&mut self, tracklet: TrackletId, claim: Claim) {
        let claims = self.all.entry(tracklet).or_default();
        match claims.binary_search_by_key(&claim.identity, |other| other.identity) {
            Ok(index) => claims[index] = claim,
            Err(index) => claims.insert(index, claim),
        }
    }

    /// An identity is forgotten.
    pub(super) fn forget(&mut self, identity: Identity) {
        self.all.values_mut().for_each(|claims| claims.retain(|claim| claim.identity != identity));
    }

    fn of(&self, tracklet: TrackletId) -> impl Iterator<Item = &Claim> + Clone {
        let claims = self.all.get(&tracklet).into_iter().flatten();
        claims.filter(|claim| self.since.is_some_and(|since| claim.time >= since))
    }

    /// How likely the radar track is the transponder's own before it is weighed; `None`: it is not looked at.
    pub(super) fn own(
        &self,
        tracklet: TrackletId,
        identity: Identity,
        judged: &Judged,
        is_current: bool,
        tracklets: &Tracklets,
    ) -> Option<Own> {
        let is_near = judged.is_near() || judged.is_loyal;
        // The pair's, else the nearest one's.
        let nearer = |best: &'_ Claim, other: &Claim| other.nearness.is_less(&best.nearness);
        let claims = self.of(tracklet);
        let near = claims.clone().filter(|claim| claim.is_near);
        let nearest = near.reduce(|best, other| if nearer(best, other) { other } else { best });
        let another = nearest.filter(|claim| claim.identity != identity);
        match another {
            Some(other) if !is_near || other.nearness.is_less(&Nearness::of(judged)) => None,
            _ if judged.is_pair() => Some(Own::Pair),
            _ if !is_drone(tracklet, tracklets) => None,
            _ if is_near => Some(Own::Near),
            _ if is_current || is_far(claims, identity, judged) => Some(Own::Far),
            _ => None,
        }
    }
}

/// Whether a radar track that is nobody's flies as this transponder does, and as no other.
fn is_far<'a>(claims: impl Iterator<Item = &'a Claim>, identity: Identity, judged: &Judged) -> bool {
    let others = claims.filter(|claim| claim.identity != identity);
    let other = others.map(|other| other.motion).fold(f64::NEG_INFINITY, f64::max);
    let is_level = judged.second.height_m.is_none_or(|height_m| height_m.abs() < FAR_HEIGHT_M);
    judged.taken_for != TakenFor::Another
        && judged.motion > FAR_MOTION
        && judged.motion > other + FAR_LEAD
        && is_level
}

/// Whether the radar takes it for a drone.
fn is_drone(tracklet: TrackletId, tracklets: &Tracklets) -> bool {
    tracklets.get(tracklet).is_some_and(|tracklet| {
        let (seconds, mean) = tracklet.existence().class();
        seconds == 0.0 || mean > DRONE_PROBABILITY
    })
}

/// How a radar track comes to be looked at.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Own {
    Far,
    Near,
    /// The association takes it for the aircraft's own.
    Pair,
}

impl Own {
    /// Probability that it is the aircraft's own before it is looked at.
    pub(super) fn probability(self) -> f64 {
        match self {
            Self::Far => OWN_FAR,
            Self::Near => OWN_NEAR,
            Self::Pair => OWN_PAIR,
        }
    }
}
