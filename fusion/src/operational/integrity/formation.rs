//! Transponders that fly in formation. If a radar's errors are as large as their distance, it is unknown which of its
//! tracks is which aircraft, so its tracks are no evidence of the position of one of them. Such an identity stays
//! unverified.

use std::collections::BTreeSet;

use super::watch::SECOND;
use crate::frames::Enu;
use crate::operational::cycle::Cycle;
use crate::operational::ids::TargetId;
use crate::operational::places::SpatialIndex;
use crate::operational::targets::Targets;

/// Largest distance between two members of a formation, metres.
const NEAR_M: f64 = 100.0;
/// Time over which the motion of two members is compared, seconds.
const COMPARED_S: i32 = 8;
/// Largest change of the distance between two members in that time, metres.
const ALIKE_M: f64 = 16.0;
/// Number of other members that make a formation. A forger can invent fewer with less effort.
const OTHERS: usize = 3;

/// The transponders that fly in a formation at the centre of the slot.
pub(super) fn members(targets: &Targets, cycle: &Cycle) -> BTreeSet<TargetId> {
    let before = cycle.centre + SECOND * -COMPARED_S;
    let flying = targets.iter().filter_map(|target| {
        let now = target.on_curve(cycle.centre, cycle.settings)?.position;
        let then = target.on_curve(before, cycle.settings)?.position;
        Some((now, (target.id(), then)))
    });
    let places = SpatialIndex::of(flying);
    let is_member = |now: Enu, id: TargetId, then: Enu| {
        let others = places.within(now, NEAR_M).filter(|(there, (other, before))| {
            let apart = (there.0 - now.0).xy();
            *other != id && apart.norm() <= NEAR_M && (apart - (before.0 - then.0).xy()).norm() < ALIKE_M
        });
        others.take(OTHERS).count() == OTHERS
    };
    let members = places.iter().filter(|&&(now, (id, then))| is_member(now, id, then));
    members.map(|&(_, (id, _))| id).collect()
}
