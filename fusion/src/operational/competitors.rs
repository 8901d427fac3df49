//! Other candidates for a target's radar track or transponder.

use std::collections::BTreeMap;

use super::cycle::Cycle;
use super::ids::TargetId;
use super::manual_association::{ManualAssociations, Verdict};
use super::targets::{Target, Targets};
use super::track_drift;
use super::tracklets::Tracklets;
use super::tuning::{COMPETITORS_MAX, PAIR_LLR_MAX};
use crate::point::{Competitor, Rival};

/// Candidates by target, the likeliest first: transponders for its radar track, and radar tracks for its transponder.
/// Those with the lowest possible score are omitted.
pub(super) fn competitors(
    tracklets: &Tracklets,
    targets: &Targets,
    correlations: &ManualAssociations,
    cycle: &Cycle,
) -> BTreeMap<TargetId, Vec<Competitor>> {
    let mut all: BTreeMap<TargetId, Vec<Competitor>> = BTreeMap::new();
    for tracklet in tracklets.iter().filter(|tracklet| track_drift::is_present(tracklet, cycle)) {
        let follows =
            |id: &TargetId| targets.get(*id).is_some_and(|target| target.is_followed_by(tracklet.id));
        let own = tracklet.target().filter(follows);
        for &(id, pair) in tracklet.pairs() {
            let Some(score) = pair.total().filter(|&total| total > -PAIR_LLR_MAX) else { continue };
            let transponder = targets.get(id).and_then(Target::transponder);
            let is_own = own.is_some_and(|own| targets.are_together(own, id));
            let Some(transponder) = transponder.filter(|_| !is_own) else { continue };
            let identity = transponder.identity;
            let decorrelated = correlations.verdict(tracklet.id, identity) == Verdict::Decorrelated;
            let competitor = |who| Competitor { who, score, decorrelated };
            all.entry(id).or_default().push(competitor(Rival::Radar(tracklet.key)));
            if let Some(own) = own {
                let number = transponder.numbered.map(|numbered| numbered.number);
                let rival = Rival::Transponder { sensor: transponder.sensor, number, identity };
                all.entry(own).or_default().push(competitor(rival));
            }
        }
    }
    for competitors in all.values_mut() {
        // The sort is stable: candidates with equal scores stay in the order in which they began.
        competitors.sort_by(|a, b| b.score.total_cmp(&a.score));
        let mut counts = [0; 2];
        competitors.retain(|competitor| {
            let count = &mut counts[usize::from(matches!(competitor.who, Rival::Radar(_)))];
            *count += 1;
            *count <= COMPETITORS_MAX
        });
    }
    all
}
