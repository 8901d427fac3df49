//! Correlations: an operator's decisions that a radar track and a transponder are one aircraft, or that they are not.
//!
//! A correlation refers to a radar track for as long as the radar keeps it: a number that is used again is another
//! track, without decisions. The transponder is referred to by its identity, so that it may fall silent and return.
//!
//! After a restart a correlation takes effect again if a plot with the radar's number is received within its break.

use std::collections::{BTreeMap, BTreeSet};

use serde::{Deserialize, Serialize};

use super::ids::{TargetId, TrackletId};
use super::settings::OperationalSettings;
use super::targets::Targets;
use super::tracklets::{Tracklet, Tracklets};
use crate::report::{Identity, RadarTrackKey, SensorIndex};
use crate::slots::Slot;
use crate::time::Time;

/// An operator's verdict on a pair.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum Verdict {
    /// The two are one aircraft.
    Correlated,
    /// The two are not one aircraft.
    Decorrelated,
    /// The evidence decides.
    Automatic,
}

crate::interface_names!(Verdict {
    Correlated = "correlated",
    Decorrelated = "decorrelated",
    Automatic = "automatic",
});

impl Verdict {
    /// The verdict with that name.
    pub fn of_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|verdict| verdict.name() == name)
    }
}

/// An operator's decision on a pair.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct ManualAssociation {
    /// The radar track that has this number now.
    pub radar: RadarTrackKey,
    /// The transponder.
    pub transponder: Identity,
    /// The verdict.
    pub verdict: Verdict,
}

/// A correlation in force.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct ActiveAssociation {
    /// The decision; never [`Verdict::Automatic`].
    pub correlation: ManualAssociation,
    /// The first slot in which it was in force.
    pub since: Slot,
}

/// A correlation saved for a restart.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct SavedAssociation {
    /// The decision, and the slot since which it is in force.
    pub held: ActiveAssociation,
    /// Time of the last plot of its radar track.
    pub heard: Time,
}

/// Outcome of a correlation that was restored after a restart.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum RestoredAssociation {
    /// The correlation is in force again: a plot of the radar track was received.
    Holds(ActiveAssociation),
    /// The correlation has ended: no plot with the radar's number was received within its break, so another aircraft may
    /// have the number now.
    Ended(ActiveAssociation),
}

/// Reason for refusing a correlation.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum AssociationRefusal {
    /// The profile has no correlations.
    #[error("the reference profile decides by itself; manual correlation needs the operational profile")]
    Reference,
    /// The radar has no such track in the slot published last.
    #[error("the radar has no such track now")]
    NoRadarTrack,
    /// The transponder is unknown, or was not received for long.
    #[error("no such transponder has been heard lately")]
    NoTransponder,
}

/// The correlations in force, by radar track and transponder: the verdict, and the slot since which it is in force.
#[derive(Debug, Default, Serialize, Deserialize)]
pub(super) struct ManualAssociations(BTreeMap<(TrackletId, Identity), (Verdict, Slot)>);

/// The correlations in force, as needed by association and initiation.
#[derive(Debug, Default)]
pub(super) struct DecidedPairs {
    correlated: BTreeMap<TrackletId, TargetId>,
    /// Radars and targets of these correlations: a decision on one radar's track does not bind another radar's.
    bound: BTreeSet<(SensorIndex, TargetId)>,
    apart: BTreeSet<(TrackletId, TargetId)>,
}

impl DecidedPairs {
    /// The target to which an operator has assigned a radar track.
    pub(super) fn target(&self, id: TrackletId) -> Option<TargetId> {
        self.correlated.get(&id).copied()
    }

    /// Whether the evidence decides if this radar track is that target.
    pub(super) fn leaves(&self, tracklet: &Tracklet, target: TargetId) -> bool {
        !self.correlated.contains_key(&tracklet.id)
            && !self.bound.contains(&(tracklet.key.sensor, target))
            && !self.are_apart(tracklet.id, target)
    }

    /// Separates a radar track from the target of a transponder whose position contradicts it, unless an operator has
    /// decided.
    pub(super) fn part(&mut self, tracklet: &Tracklet, target: TargetId) {
        if self.leaves(tracklet, target) {
            self.apart.insert((tracklet.id, target));
        }
    }

    /// Whether the two are known to be different aircraft.
    pub(super) fn are_apart(&self, id: TrackletId, target: TargetId) -> bool {
        self.apart.contains(&(id, target))
    }
}

/// Verdict on a radar track and a transponder, and the slot since which it is in force.
pub(super) type DecidedPair = ((TrackletId, Identity), (Verdict, Slot));

impl ManualAssociations {
    /// Decisions on a radar track.
    pub(super) fn of(&self, id: TrackletId) -> impl Iterator<Item = DecidedPair> {
        let of = self.0.iter().filter(move |((tracklet, _), _)| *tracklet == id);
        of.map(|(&pair, &held)| (pair, held))
    }

    /// Changes the identifier of a radar track.
    pub(super) fn rename(&mut self, before: TrackletId, now: TrackletId) {
        for ((id, identity), held) in self.of(before).collect::<Vec<_>>() {
            self.0.remove(&(id, identity));
            self.0.insert((now, identity), held);
        }
    }

    /// Adds decisions of another engine; those of this engine have priority.
    pub(super) fn take_over(&mut self, decisions: Vec<DecidedPair>) {
        decisions.into_iter().for_each(|(pair, held)| _ = self.0.entry(pair).or_insert(held));
    }

    pub(super) fn contains(&self, tracklet: TrackletId, transponder: Identity) -> bool {
        self.0.contains_key(&(tracklet, transponder))
    }

    pub(super) fn verdict(&self, tracklet: TrackletId, transponder: Identity) -> Verdict {
        self.0.get(&(tracklet, transponder)).map_or(Verdict::Automatic, |held| held.0)
    }

    /// Applies a decision on this tracklet. Returns `true` if it revokes a correlation by which the two were one.
    pub(super) fn apply(
        &mut self,
        id: TrackletId,
        correlation: ManualAssociation,
        since: Slot,
        tracklets: &Tracklets,
    ) -> bool {
        let ManualAssociation { radar, transponder, verdict } = correlation;
        let pair = (id, transponder);
        if verdict == Verdict::Correlated {
            // A radar track has one transponder, and a transponder has one track of a radar.
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
            // A repeated decision keeps its first slot.
            _ if self.0.get(&pair).is_some_and(|before| before.0 == verdict) => {}
            _ => _ = self.0.insert(pair, (verdict, since)),
        }
        false
    }

    /// The correlations in force, each with the time of the last plot of its radar track.
    pub(super) fn saved(&self, tracklets: &Tracklets) -> Vec<SavedAssociation> {
        let kept = |(&(id, transponder), &(verdict, since)): (&(TrackletId, Identity), &(Verdict, Slot))| {
            let tracklet = tracklets.get(id)?;
            let correlation = ManualAssociation { radar: tracklet.key, transponder, verdict };
            Some(SavedAssociation { held: ActiveAssociation { correlation, since }, heard: tracklet.last() })
        };
        self.0.iter().filter_map(kept).collect()
    }

    /// Ends the correlations of radar tracks that have ended.
    pub(super) fn end(&mut self, tracklets: &Tracklets, time: Time, settings: &OperationalSettings) {
        self.0.retain(|&(id, _), _| {
            tracklets.get(id).is_some_and(|tracklet| !tracklet.has_ended(time, settings))
        });
    }

    /// The decisions on the present targets.
    pub(super) fn decided(&self, tracklets: &Tracklets, targets: &Targets) -> DecidedPairs {
        let mut decided = DecidedPairs::default();
        for (&(id, identity), &(verdict, _)) in &self.0 {
            // A decision on one identity of an aircraft applies to the aircraft.
            let Some(target) = targets.of_identity(identity).map(|id| targets.leader(id)) else { continue };
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
