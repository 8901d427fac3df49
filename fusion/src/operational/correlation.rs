//! Correlations: what an operator has decided, that a radar track and a transponder are one aircraft or that they are not.
//!
//! A correlation is about a radar track for as long as the radar keeps it: a number that comes again is another track, of
//! which nothing was decided. The transponder is meant by its identity, so that it may fall silent and come back.
//!
//! Over a restart it holds where the radar's number is heard again within its break, as if there had been no restart.

use std::collections::{BTreeMap, BTreeSet};

use serde::{Deserialize, Serialize};

use super::ids::{TargetId, TrackletId};
use super::settings::Settings;
use super::targets::Targets;
use super::tracklets::{Tracklet, Tracklets};
use crate::report::{Identity, RadarTrackKey, SensorIndex};
use crate::slots::Slot;
use crate::time::Time;

/// What an operator says of a pair.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum Verdict {
    /// They are one aircraft.
    Correlated,
    /// They are not.
    Decorrelated,
    /// Left to the evidence again.
    Automatic,
}

crate::interface_names!(Verdict {
    Correlated = "correlated",
    Decorrelated = "decorrelated",
    Automatic = "automatic",
});

impl Verdict {
    /// The verdict of that name.
    pub fn of_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|verdict| verdict.name() == name)
    }
}

/// An operator's decision on a pair.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Correlation {
    /// The radar track that has this number now.
    pub radar: RadarTrackKey,
    /// The transponder.
    pub transponder: Identity,
    /// What is decided.
    pub verdict: Verdict,
}

/// A correlation in force.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct HeldCorrelation {
    /// The decision; never [`Verdict::Automatic`].
    pub correlation: Correlation,
    /// The first slot published by it.
    pub since: Slot,
}

/// A correlation kept for the time after a restart.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct SavedCorrelation {
    /// The decision, and since when it holds.
    pub held: HeldCorrelation,
    /// Time of the last plot of its radar track.
    pub heard: Time,
}

/// What has become of a correlation of before a restart.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum ResumedCorrelation {
    /// It holds as before: the radar track is heard again.
    Holds(HeldCorrelation),
    /// It has ended: the radar's number was not heard again within its break, so another aircraft may have it now.
    Ended(HeldCorrelation),
}

/// Why a pair cannot be correlated.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum NotCorrelated {
    /// The profile has no correlations.
    #[error("the reference profile decides by itself; manual correlation needs the operational profile")]
    Reference,
    /// The radar has no such track in the slot published last.
    #[error("the radar has no such track now")]
    NoRadarTrack,
    /// The transponder is unknown, or silent for long.
    #[error("no such transponder has been heard lately")]
    NoTransponder,
}

/// The correlations in force, by radar track and transponder: the verdict, and since when.
#[derive(Debug, Default, Serialize, Deserialize)]
pub(super) struct Correlations(BTreeMap<(TrackletId, Identity), (Verdict, Slot)>);

/// The correlations in force, as association and initiation need them.
#[derive(Debug, Default)]
pub(super) struct Decided {
    correlated: BTreeMap<TrackletId, TargetId>,
    /// The radars that they are of: a decision on one radar's track binds no other's.
    bound: BTreeSet<(SensorIndex, TargetId)>,
    apart: BTreeSet<(TrackletId, TargetId)>,
}

impl Decided {
    /// The target that a radar track is, whatever speaks against it.
    pub(super) fn target(&self, id: TrackletId) -> Option<TargetId> {
        self.correlated.get(&id).copied()
    }

    /// Whether it is left to the evidence that this radar track is that target.
    pub(super) fn leaves(&self, tracklet: &Tracklet, target: TargetId) -> bool {
        !self.correlated.contains_key(&tracklet.id)
            && !self.bound.contains(&(tracklet.key.sensor, target))
            && !self.are_apart(tracklet.id, target)
    }

    /// A radar track that sees an aircraft where its transponder is not is not what that says, unless an operator has decided.
    pub(super) fn part(&mut self, tracklet: &Tracklet, target: TargetId) {
        if self.leaves(tracklet, target) {
            self.apart.insert((tracklet.id, target));
        }
    }

    /// Whether they are known not to be one.
    pub(super) fn are_apart(&self, id: TrackletId, target: TargetId) -> bool {
        self.apart.contains(&(id, target))
    }
}

/// What holds of a radar track and a transponder, and since when.
pub(super) type Decision = ((TrackletId, Identity), (Verdict, Slot));

impl Correlations {
    /// What was decided of a radar track.
    pub(super) fn of(&self, id: TrackletId) -> impl Iterator<Item = Decision> {
        let of = self.0.iter().filter(move |((tracklet, _), _)| *tracklet == id);
        of.map(|(&pair, &held)| (pair, held))
    }

    /// A radar track has another name.
    pub(super) fn rename(&mut self, before: TrackletId, now: TrackletId) {
        for ((id, identity), held) in self.of(before).collect::<Vec<_>>() {
            self.0.remove(&(id, identity));
            self.0.insert((now, identity), held);
        }
    }

    /// What was decided elsewhere holds here; but for what was decided here.
    pub(super) fn take_over(&mut self, decisions: Vec<Decision>) {
        decisions.into_iter().for_each(|(pair, held)| _ = self.0.entry(pair).or_insert(held));
    }

    pub(super) fn contains(&self, tracklet: TrackletId, transponder: Identity) -> bool {
        self.0.contains_key(&(tracklet, transponder))
    }

    pub(super) fn verdict(&self, tracklet: TrackletId, transponder: Identity) -> Verdict {
        self.0.get(&(tracklet, transponder)).map_or(Verdict::Automatic, |held| held.0)
    }

    /// Takes a decision on this tracklet over. `true`: the two were one by the operator's decision, which he takes back.
    pub(super) fn hold(
        &mut self,
        id: TrackletId,
        correlation: Correlation,
        since: Slot,
        tracklets: &Tracklets,
    ) -> bool {
        let Correlation { radar, transponder, verdict } = correlation;
        let pair = (id, transponder);
        if verdict == Verdict::Correlated {
            // A radar track is one transponder, and a transponder one track of a radar.
            let of_radar =
                |id| tracklets.get(id).is_some_and(|other: &Tracklet| other.key.sensor == radar.sensor);
            self.0.retain(|&(other, identity), (verdict, _)| {
                let shares = other == id || (identity == transponder && of_radar(other));
                *verdict != Verdict::Correlated || !shares
            });
        }
        match verdict {
            Verdict::Automatic => {
                return self.0.remove(&pair).is_some_and(|(before, _)| before == Verdict::Correlated);
            }
            // What was said before and is said again holds since then.
            _ if self.0.get(&pair).is_some_and(|before| before.0 == verdict) => {}
            _ => _ = self.0.insert(pair, (verdict, since)),
        }
        false
    }

    /// Each with the last plot of its radar track.
    pub(super) fn kept(&self, tracklets: &Tracklets) -> Vec<SavedCorrelation> {
        let kept = |(&(id, transponder), &(verdict, since)): (&(TrackletId, Identity), &(Verdict, Slot))| {
            let tracklet = tracklets.get(id)?;
            let correlation = Correlation { radar: tracklet.key, transponder, verdict };
            Some(SavedCorrelation { held: HeldCorrelation { correlation, since }, heard: tracklet.last() })
        };
        self.0.iter().filter_map(kept).collect()
    }

    /// Correlations end with the radar track that they are about.
    pub(super) fn end(&mut self, tracklets: &Tracklets, time: Time, settings: &Settings) {
        self.0.retain(|&(id, _), _| {
            tracklets.get(id).is_some_and(|tracklet| !tracklet.has_ended(time, settings))
        });
    }

    /// What they say of the targets that there are.
    pub(super) fn decided(&self, tracklets: &Tracklets, targets: &Targets) -> Decided {
        let mut decided = Decided::default();
        for (&(id, identity), &(verdict, _)) in &self.0 {
            let Some(target) = targets.of_identity(identity) else { continue };
            let Some(tracklet) = tracklets.get(id) else { continue };
            if verdict == Verdict::Correlated {
                decided.correlated.insert(id, target);
                decided.bound.insert((tracklet.key.sensor, target));
            } else {
                decided.apart.insert((id, target));
            }
        }
        decided
    }
}

#[cfg(test)]
mod tests;
