//! Targets of one aircraft with several transponders: which of them represents it, and its number.

use std::collections::BTreeSet;

use serde::{Deserialize, Serialize};

use super::{Target, Targets};
use crate::operational::cycle::Cycle;
use crate::operational::ids::{TargetId, TrackletId};
use crate::operational::track_numbers::TrackNumber;
use crate::operational::tracklets::{Tracklet, Tracklets};
use crate::report::{Identity, SensorIndex};

/// Membership of a target in an aircraft with several transponders.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct Membership {
    /// The target that represents the aircraft.
    leader: TargetId,
    /// The number of the aircraft: the oldest of its targets' numbers.
    number: Option<TrackNumber>,
    /// The other targets of the aircraft; empty except for the leader.
    companions: Vec<TargetId>,
}

impl Membership {
    /// The number of the aircraft, once one of its targets has one.
    pub(super) fn number(&self) -> Option<TrackNumber> {
        self.number
    }
}

impl Targets {
    /// Unites each of these sets of targets as one aircraft, represented by the given target.
    pub(in crate::operational) fn unite(&mut self, groups: &[(TargetId, BTreeSet<TargetId>)]) {
        self.together.clear();
        for (leader, group) in groups {
            let numbers = group.iter().filter_map(|&id| self.own_number(id));
            let number = numbers.min_by_key(|number| number.age());
            let others = || group.iter().copied().filter(|id| id != leader);
            let membership = |companions| Membership { leader: *leader, number, companions };
            self.together.insert(*leader, membership(others().collect()));
            self.together.extend(others().map(|id| (id, membership(Vec::new()))));
        }
    }

    /// The number that a target has on its own.
    pub(in crate::operational) fn own_number(&self, id: TargetId) -> Option<TrackNumber> {
        let target = self.all.get(id)?;
        target.number.or_else(|| self.numbers.of(target.identity()?))
    }

    /// The number under which a target is published: that of its aircraft.
    pub(in crate::operational) fn number_shown(&self, target: &Target) -> Option<TrackNumber> {
        let together = self.together.get(&target.id()).and_then(|membership| membership.number);
        together.or(target.number)
    }

    /// Whether a target represents an aircraft that has several.
    pub(in crate::operational) fn is_leader(&self, id: TargetId) -> bool {
        self.together.get(&id).is_some_and(|membership| membership.leader == id)
    }

    /// Whether another target represents its aircraft.
    pub(in crate::operational) fn is_companion(&self, id: TargetId) -> bool {
        self.together.get(&id).is_some_and(|membership| membership.leader != id)
    }

    /// The target that represents the aircraft of this one.
    pub(in crate::operational) fn leader(&self, id: TargetId) -> TargetId {
        self.together.get(&id).map_or(id, |membership| membership.leader)
    }

    /// The other targets of the aircraft that this one represents, in order.
    pub(in crate::operational) fn companions(&self, id: TargetId) -> impl Iterator<Item = &Target> {
        let companions =
            self.together.get(&id).map_or(&[][..], |membership| membership.companions.as_slice());
        companions.iter().filter_map(|&other| self.all.get(other))
    }

    /// Whether both are targets of one aircraft.
    pub(in crate::operational) fn are_together(&self, one: TargetId, other: TargetId) -> bool {
        self.leader(one) == self.leader(other)
    }

    /// Moves the radar tracks of a companion to the leader, unless it has a track of the same radar.
    pub(in crate::operational) fn hand_over(
        &mut self,
        tracklets: &mut Tracklets,
        companion: TargetId,
        leader: TargetId,
        cycle: &Cycle,
    ) {
        let Some((from, to)) = self.all.get(companion).zip(self.all.get(leader)) else { return };
        let is_taken = |sensor: SensorIndex| {
            let mut own = to.followed(tracklets);
            own.any(|own| own.key.sensor == sensor && own.last() >= cycle.centre)
        };
        let decide = |own: &Tracklet| (own.id, (!is_taken(own.key.sensor)).then_some(leader));
        let tracks: Vec<(TrackletId, Option<TargetId>)> = from.followed(tracklets).map(decide).collect();
        tracks.into_iter().for_each(|(track, to)| self.assign_track(tracklets, track, to));
    }

    /// Passes the number of an identity that has ended to another identity of its aircraft, if it was published under
    /// that number.
    pub(in crate::operational) fn pass_number_on(&mut self, ended: Identity, to: Identity) {
        let Some(id) = self.of_identity(to) else { return };
        let shown = self.together.get(&id).and_then(|membership| membership.number);
        if shown.is_some()
            && shown == self.numbers.of(ended)
            && let Some(number) = self.numbers.pass_on(ended, to)
            && let Some(target) = self.all.get_mut(id)
        {
            target.number = Some(number);
        }
    }
}
