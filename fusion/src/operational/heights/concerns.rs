//! The concern where a transponder's heights contradict those of radars.

use std::collections::BTreeMap;

use crate::integrity::Concern;
use crate::operational::cycle::Cycle;
use crate::point::Point;

/// The transponders of these points whose heights contradict those of radars, one concern for each identity.
pub(in crate::operational) fn concerns(points: &[Point], cycle: &Cycle) -> impl Iterator<Item = Concern> {
    let mut concerns = BTreeMap::new();
    for point in points {
        for part in point.source.transponder().into_iter().chain(&point.also) {
            let identity = part.identity;
            let heights = cycle.settings.heights.get(&identity);
            let Some(offset) = heights.and_then(|heights| heights.contradiction) else { continue };
            concerns.entry(identity).or_insert(Concern::Height {
                identity,
                track: Some(point.number),
                offset_m: offset.mean_m,
                deviation_m: offset.variance_m2.sqrt(),
            });
        }
    }
    concerns.into_values()
}
