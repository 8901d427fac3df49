//! Transponder identities that belong to one aircraft: two CAT129 transponders on one drone, or CAT129 beside Remote ID or
//! ADS-B.
//!
//! Once a second the pass compares the curves of transponders that fly near each other ([`SameAircraftEvidence`]). Identities that
//! agree for most of a minute of flight are linked: the aircraft has one target that represents it, the leader, one point
//! and one number. The other targets, its companions, are filtered and compared as before, but neither associated nor
//! published. The link is revoked when the curves separate, when the integrity pass flags one of the identities, or when a
//! radar has two tracks of them; each target then has its own number again.

mod combined;
mod evidence;

use std::collections::{BTreeMap, BTreeSet};

use jiff::SignedDuration;
use nalgebra::Matrix2;
use serde::{Deserialize, Serialize};

use super::cycle::Cycle;
use super::ids::TargetId;
use super::integrity::IdentityAssessments;
use super::places::SpatialIndex;
use super::targets::{Target, Targets};
use super::tracklets::{Tracklet, Tracklets};
use super::tuning::{
    ASSOCIATE_LLR, POORER, SAME_CANDIDATES_MAX, SAME_CROWD_M, SAME_FORGOTTEN_S, SAME_LEADER_SILENT_S,
    SAME_NEAR_M, SAME_SPEED_MIN_M_S,
};
use crate::frames::Enu;
use crate::report::{Identity, SensorIndex};
use crate::time::SECOND;
pub(super) use combined::{TransponderShare, combined};
use evidence::{SameAircraftEvidence, TransponderComparison};

/// Two identities, the lesser one first.
type IdentityPair = (Identity, Identity);

/// The evidence on each pair of identities that fly near each other.
#[derive(Debug, Default, Serialize, Deserialize)]
pub(super) struct SameAircraft {
    pairs: BTreeMap<IdentityPair, SameAircraftEvidence>,
    /// The last whole second that was evaluated.
    second: Option<i64>,
}

/// A transponder at the centre of the slot.
#[derive(Clone, Copy)]
struct PlacedTransponder<'a> {
    target: &'a Target,
    identity: Identity,
    /// Distance flown in the last second, metres.
    flown_m: f64,
}

impl SameAircraft {
    /// Compares all pairs once a second, without flagged identities.
    pub(super) fn assess(
        &mut self,
        targets: &Targets,
        tracklets: &Tracklets,
        integrities: &IdentityAssessments,
        cycle: &Cycle,
    ) {
        let is_trusted = |identity: Identity| !integrities.is_flagged(identity);
        let is_left = |identity: Identity| targets.of_identity(identity).is_some() && is_trusted(identity);
        self.pairs.retain(|&(one, other), evidence| {
            is_left(one)
                && is_left(other)
                && (evidence.is_linked() || cycle.centre.seconds_since(evidence.last()) <= SAME_FORGOTTEN_S)
        });
        let second = cycle.centre.nanos().div_euclid(SECOND);
        if self.second.replace(second) == Some(second) {
            return;
        }
        let flying = |target| {
            let flying = PlacedTransponder::of(target, cycle).filter(|flying| is_trusted(flying.identity))?;
            Some((target.on_curve(cycle.centre, cycle.settings)?.position, flying))
        };
        let places = SpatialIndex::of(targets.iter().filter_map(flying));
        let mut compared: BTreeMap<IdentityPair, [(Enu, PlacedTransponder); 2]> = BTreeMap::new();
        for &(place, one) in places.iter() {
            let mut near: Vec<(f64, (Enu, PlacedTransponder))> = places
                .within(place, SAME_NEAR_M)
                .filter(|(_, other)| other.identity != one.identity)
                .map(|&(there, other)| ((there.0 - place.0).xy().norm(), (there, other)))
                .filter(|&(away_m, _)| away_m <= SAME_NEAR_M)
                .collect();
            near.sort_by(|a, b| a.0.total_cmp(&b.0)); // stable
            for (index, &(_, other)) in near.iter().enumerate() {
                let pair = pair(one.identity, other.1.identity);
                let is_candidate =
                    index < SAME_CANDIDATES_MAX && one.flown_m.min(other.1.flown_m) >= SAME_SPEED_MIN_M_S;
                if is_candidate || self.pairs.contains_key(&pair) {
                    let both = [(place, one), other];
                    compared.insert(pair, both);
                }
            }
        }
        // Linked identities are compared at any distance.
        let linked = self.pairs.iter().filter(|(_, evidence)| evidence.is_linked()).map(|(&pair, _)| pair);
        let at = |identity| {
            let target = targets.get(targets.of_identity(identity)?)?;
            flying(target)
        };
        for (one, other) in linked.collect::<Vec<IdentityPair>>() {
            if let Some((one, other)) = at(one).zip(at(other)) {
                compared.entry(pair(one.1.identity, other.1.identity)).or_insert([one, other]);
            }
        }
        if compared.is_empty() {
            return;
        }
        let seen_by = DetectingRadars::of(tracklets, cycle);
        for (pair, [(place, one), (there, other)]) in compared {
            let is_own = |identity: Identity| {
                identity == pair.0
                    || identity == pair.1
                    || self.is_linked(identity, pair.0)
                    || self.is_linked(identity, pair.1)
            };
            let crowd = places
                .within(place, SAME_CROWD_M)
                .filter(|(near, _)| (near.0 - place.0).xy().norm() <= SAME_CROWD_M)
                .filter(|(_, near)| !is_own(near.identity))
                .count() as f64;
            let is_seen_twice = seen_by.is_twice(one.target.id(), other.target.id());
            if let Some(look) =
                compare_transponders((place, &one), (there, &other), crowd, is_seen_twice, cycle)
            {
                self.pairs.entry(pair).or_insert_with(|| SameAircraftEvidence::new(look.time)).observe(&look);
            }
        }
    }

    /// Whether these two are linked as one aircraft.
    fn is_linked(&self, one: Identity, other: Identity) -> bool {
        self.pairs.get(&pair(one, other)).is_some_and(SameAircraftEvidence::is_linked)
    }

    /// The targets of each aircraft that has several.
    fn groups(&self, targets: &Targets) -> Vec<BTreeSet<TargetId>> {
        let mut groups: Vec<BTreeSet<TargetId>> = Vec::new();
        let mut group_of: BTreeMap<TargetId, usize> = BTreeMap::new();
        for (&(one, other), _) in self.pairs.iter().filter(|(_, evidence)| evidence.is_linked()) {
            let both = targets.of_identity(one).zip(targets.of_identity(other));
            let Some((one, other)) = both else { continue };
            let known = [one, other].map(|id| group_of.get(&id).copied());
            let mut group = BTreeSet::from([one, other]);
            for index in known.into_iter().flatten() {
                group.append(&mut groups[index]);
            }
            group_of.extend(group.iter().map(|&id| (id, groups.len())));
            groups.push(group);
        }
        groups.retain(|group| !group.is_empty());
        groups
    }

    /// Unites the targets of one aircraft: determines the leader, and the aircraft's number.
    pub(super) fn unite(&self, targets: &mut Targets, tracklets: &mut Tracklets, cycle: &Cycle) {
        let groups = self.groups(targets);
        let leaders = groups.iter().filter_map(|group| leader(group, targets, cycle));
        let led: Vec<(TargetId, BTreeSet<TargetId>)> = leaders.zip(groups.iter().cloned()).collect();
        targets.unite(&led);
        for (leader, group) in led {
            for companion in group.into_iter().filter(|&id| id != leader) {
                targets.hand_over(tracklets, companion, leader, cycle);
            }
        }
    }

    /// Passes the numbers of identities that have ended by silence to the identities that they were linked with, if
    /// their aircraft was published under that number.
    pub(super) fn end(&self, ended: &[Identity], targets: &mut Targets) {
        if ended.is_empty() {
            return;
        }
        for &(one, other) in
            self.pairs.iter().filter(|(_, evidence)| evidence.is_linked()).map(|(pair, _)| pair)
        {
            match (ended.contains(&one), ended.contains(&other)) {
                (true, false) => targets.pass_number_on(one, other),
                (false, true) => targets.pass_number_on(other, one),
                _ => {}
            }
        }
    }
}

impl<'a> PlacedTransponder<'a> {
    fn of(target: &'a Target, cycle: &Cycle) -> Option<Self> {
        let identity = target.identity()?;
        let now = target.on_curve(cycle.centre, cycle.settings)?;
        let before = target.on_curve(cycle.centre + SignedDuration::from_secs(-1), cycle.settings);
        let flown_m = before.map_or(0.0, |before| (now.position.0 - before.position.0).xy().norm());
        Some(Self { target, identity, flown_m })
    }
}

fn pair(one: Identity, other: Identity) -> IdentityPair {
    (one.min(other), one.max(other))
}

/// The target that represents an aircraft: the present leader while it is received, otherwise the one with far better
/// positions, otherwise the one with the oldest number.
fn leader(group: &BTreeSet<TargetId>, targets: &Targets, cycle: &Cycle) -> Option<TargetId> {
    let is_heard = |id: &TargetId| {
        let last = targets.get(*id).and_then(Target::transponder)?.last_until(cycle.centre)?;
        (cycle.silent_s(last) <= SAME_LEADER_SILENT_S).then_some(*id)
    };
    let heard: Vec<TargetId> = group.iter().filter_map(is_heard).collect();
    let able = if heard.is_empty() { group.iter().copied().collect() } else { heard };
    if let Some(before) = able.iter().copied().find(|&id| targets.is_leader(id)) {
        return Some(before);
    }
    let sigma_m = |id: TargetId| {
        let bias = targets.get(id).and_then(Target::transponder)?.bias(cycle.settings)?;
        Some(bias.horizontal_m2.sqrt())
    };
    let best_m = able.iter().filter_map(|&id| sigma_m(id)).fold(f64::INFINITY, f64::min);
    able.into_iter().min_by_key(|&id| {
        let is_poorer = sigma_m(id).is_none_or(|sigma_m| sigma_m > POORER * best_m);
        (is_poorer, targets.own_number(id).map_or((true, None), |own| (false, Some(own.age()))), id)
    })
}

/// Compares two transponders at the centre of the slot.
fn compare_transponders(
    (place, one): (Enu, &PlacedTransponder),
    (there, other): (Enu, &PlacedTransponder),
    crowd: f64,
    is_seen_twice: bool,
    cycle: &Cycle,
) -> Option<TransponderComparison> {
    let settings = cycle.settings;
    let both = [one, other].map(|flying| {
        let transponder = flying.target.transponder()?;
        Some((
            transponder.bias(settings)?,
            transponder.on_curve(cycle.centre, settings)?,
            transponder.lacks_height(),
        ))
    });
    let [Some((bias, here, lacks)), Some((other_bias, other_here, other_lacks))] = both else { return None };
    let before = cycle.centre + SignedDuration::from_secs(-1);
    let along =
        one.target.on_curve(before, settings).map(|before| (here.position.0 - before.position.0).xy());
    let along = along.unwrap_or_default();
    let apart = place.0 - there.0;
    let has_heights = here.height_measured && other_here.height_measured && !lacks && !other_lacks;
    let flown_m = one.flown_m.min(other.flown_m);
    Some(TransponderComparison {
        time: cycle.centre,
        apart: apart.xy(),
        slow: Matrix2::identity() * (bias.horizontal_m2 + other_bias.horizontal_m2)
            + along * along.transpose() * (bias.time_s2 + other_bias.time_s2),
        white_m2: here.sigma_m * here.sigma_m + other_here.sigma_m * other_here.sigma_m,
        height: has_heights.then_some((apart.z, bias.vertical_m2 + other_bias.vertical_m2)),
        flown_m: if flown_m >= SAME_SPEED_MIN_M_S { flown_m } else { 0.0 },
        crowd,
        is_seen_twice,
    })
}

/// The radars that detect a target at the slot: by a track of it, and by an unassigned track that is likely to be of
/// it.
#[derive(Debug, Default)]
struct DetectingRadars(BTreeMap<TargetId, [BTreeSet<SensorIndex>; 2]>);

impl DetectingRadars {
    fn of(tracklets: &Tracklets, cycle: &Cycle) -> Self {
        let mut seen = Self::default();
        let is_now =
            |tracklet: &&Tracklet| tracklet.first() <= cycle.centre && tracklet.last() >= cycle.centre;
        for tracklet in tracklets.iter().filter(is_now) {
            let mut note = |id, which: usize| {
                seen.0.entry(id).or_default()[which].insert(tracklet.key.sensor);
            };
            match tracklet.target() {
                Some(id) => note(id, 0),
                None => {
                    let is_likely =
                        |id: &TargetId| tracklet.pair_llr(*id).is_some_and(|llr| llr >= ASSOCIATE_LLR);
                    tracklet.pairs().iter().map(|pair| pair.0).filter(is_likely).for_each(|id| note(id, 1));
                }
            }
        }
        seen
    }

    /// Whether one radar has a track of each of them.
    fn is_twice(&self, one: TargetId, other: TargetId) -> bool {
        let (Some(one), Some(other)) = (self.0.get(&one), self.0.get(&other)) else { return false };
        let beside = |own: &BTreeSet<SensorIndex>, others: &[BTreeSet<SensorIndex>; 2]| {
            others.iter().any(|other| !own.is_disjoint(other))
        };
        beside(&one[0], other) || beside(&other[0], one)
    }
}
