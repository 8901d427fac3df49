//! Which radar track is evidence of a transponder: one at most, and of one transponder at most.

use std::collections::BTreeMap;

use super::watch::{Judged, TakenFor};
use crate::operational::ids::TrackletId;
use crate::operational::tracklets::Tracklets;
use crate::report::Identity;

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

/// Whose each radar track is that is near somebody, or was for long; and as whose it flies best.
#[derive(Debug, Default)]
pub(super) struct Claims {
    near: BTreeMap<TrackletId, (Identity, Judged)>,
    /// The two best by the way it flies.
    flies: BTreeMap<TrackletId, [(Option<Identity>, f64); 2]>,
}

impl Claims {
    /// A radar track as seen from a transponder.
    pub(super) fn note(&mut self, tracklet: TrackletId, identity: Identity, judged: &Judged) {
        let best = self.flies.entry(tracklet).or_insert([(None, f64::NEG_INFINITY); 2]);
        if judged.motion > best[0].1 {
            *best = [(Some(identity), judged.motion), best[0]];
        } else if judged.motion > best[1].1 {
            best[1] = (Some(identity), judged.motion);
        }
        if !judged.is_near() && !judged.is_loyal {
            return;
        }
        if self.near.get(&tracklet).is_none_or(|(_, other)| is_nearer(judged, other)) {
            self.near.insert(tracklet, (identity, *judged));
        }
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
        let another = self.near.get(&tracklet).filter(|claim| claim.0 != identity);
        match another {
            Some((_, other)) if !is_near || is_nearer(other, judged) => None,
            _ if judged.is_pair() => Some(Own::Pair),
            _ if !is_drone(tracklet, tracklets) => None,
            _ if is_near => Some(Own::Near),
            _ if is_current || self.is_far(tracklet, identity, judged) => Some(Own::Far),
            _ => None,
        }
    }

    /// Whether a radar track that is nobody's flies as this transponder does, and as no other.
    fn is_far(&self, tracklet: TrackletId, identity: Identity, judged: &Judged) -> bool {
        let others =
            self.flies.get(&tracklet).into_iter().flatten().filter(|other| other.0 != Some(identity));
        let other = others.map(|other| other.1).fold(f64::NEG_INFINITY, f64::max);
        let is_level = judged.second.height_m.is_none_or(|height_m| height_m.abs() < FAR_HEIGHT_M);
        judged.taken_for != TakenFor::Another
            && judged.motion > FAR_MOTION
            && judged.motion > other + FAR_LEAD
            && is_level
    }
}

/// Whether the radar takes it for a drone.
fn is_drone(tracklet: TrackletId, tracklets: &Tracklets) -> bool {
    tracklets.get(tracklet).is_some_and(|tracklet| {
        let (seconds, mean) = tracklet.existence().class();
        seconds == 0.0 || mean > DRONE_PROBABILITY
    })
}

/// Whether a radar track is rather the first one's.
fn is_nearer(one: &Judged, other: &Judged) -> bool {
    let order = |one: &Judged| (!one.is_near(), !one.is_pair());
    order(one).cmp(&order(other)).then(one.away.total_cmp(&other.away)).is_lt()
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
