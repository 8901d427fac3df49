//! Radar tracks that fly as a transponder does, at a distance that association does not bridge.
//!
//! A radar that was moved, or whose position was mistyped, shows each drone beside its transponder. Its tracks are then not
//! associated, and teach nothing about its alignment. They still show where it stands ([`crate::registration::PlaceCheck`]).

use std::collections::BTreeMap;

use nalgebra::Vector2;
use serde::{Deserialize, Serialize};

use super::cycle::Cycle;
use super::ids::{TargetId, TrackletId};
use super::places::SpatialIndex;
use super::residuals::{ReportedCurve, residuals_with};
use super::settings::RadarSettings;
use super::targets::{Target, Targets};
use super::tracklets::{Tracklet, Tracklets};
use super::tuning::SEGMENT_S;
use crate::frames::Enu;
use crate::registration::{Sample, TrackComparison};
use crate::report::Identity;

/// Maximum distance of a radar track from the transponder that it is compared with, metres.
const REACH_M: f64 = 250.0;
/// Distance to the next transponder: metres, and multiple of the distance to the nearest.
const ALONE_M: f64 = 20.0;
const ALONE_TIMES: f64 = 1.5;
/// Distance that a transponder flies, with the radar track at a constant offset, before both are taken to be one aircraft, metres.
const PROVEN_M: f64 = 80.0;
/// Change of the offset that ends the comparison: metres, share of the distance flown, and deviations of the azimuth's bias.
const CHANGE_M: f64 = 15.0;
const CHANGE_SHARE: f64 = 0.25;
const CHANGE_SIGMAS: f64 = 1.5;

/// A radar track compared with the only transponder near it.
#[derive(Debug, Serialize, Deserialize)]
struct Lookalike {
    target: TargetId,
    /// Position over ground of the transponder at the beginning, and offset of the radar track from it.
    begun: Option<(Vector2<f64>, Vector2<f64>)>,
    is_proven: bool,
    along: TrackComparison,
}

/// The radar tracks without a transponder that are compared with one.
#[derive(Debug, Default, Serialize, Deserialize)]
pub(super) struct Lookalikes(BTreeMap<TrackletId, Lookalike>);

/// The transponder nearest to a plot, if all others are much farther away.
fn nearest(plot: Enu, places: &SpatialIndex<TargetId>) -> Option<TargetId> {
    let apart_m = |place: Enu| (place.0 - plot.0).xy().norm();
    let near = || places.within(plot, REACH_M).map(|&(place, id)| (apart_m(place), id));
    let (nearest_m, nearest) = near().min_by(|one, other| one.0.total_cmp(&other.0))?;
    let is_alone = near().all(|(apart_m, id)| id == nearest || apart_m > ALONE_M + ALONE_TIMES * nearest_m);
    (nearest_m <= REACH_M && is_alone).then_some(nearest)
}

impl Lookalikes {
    /// Forgets the radar tracks that have ended.
    pub(super) fn end(&mut self, tracklets: &Tracklets) {
        self.0.retain(|&id, _| tracklets.get(id).is_some());
    }

    /// Forgets a radar track that is compared with its own transponder now.
    pub(super) fn forget(&mut self, id: TrackletId) {
        self.0.remove(&id);
    }

    /// The transponders at the slot's centre.
    pub(super) fn places(targets: &Targets, cycle: &Cycle) -> SpatialIndex<TargetId> {
        let place =
            |target: &Target| Some((target.on_curve(cycle.centre, cycle.settings)?.position, target.id()));
        SpatialIndex::of(targets.iter().filter_map(place))
    }

    /// Compares the plots of a radar track since the last slot. Returns a sample of a pair that flies alike.
    pub(super) fn compare(
        &mut self,
        tracklet: &Tracklet,
        radar: &RadarSettings,
        (targets, places): (&Targets, &SpatialIndex<TargetId>),
        cycle: &Cycle,
    ) -> Option<(Identity, Sample)> {
        let nearest = tracklet.last_until(cycle.centre).and_then(|plot| nearest(plot.position, places));
        let Some((id, identity)) = nearest.and_then(|id| Some((id, targets.get(id)?.identity()?))) else {
            self.0.remove(&tracklet.id);
            return None;
        };
        if self.0.get(&tracklet.id).is_some_and(|known| known.target != id) {
            self.0.remove(&tracklet.id);
        }
        let target = targets.get(id)?;
        let mut curve = ReportedCurve::of(target, cycle.settings)?;
        let residuals = residuals_with(tracklet, target, &mut curve, radar, cycle);
        let lookalike = self.0.entry(tracklet.id).or_insert_with(|| Lookalike {
            target: id,
            begun: None,
            is_proven: false,
            along: TrackComparison::new(&radar.track_errors),
        });
        for (_, residual) in &residuals {
            let (place, offset) = (residual.target.0.xy(), (residual.plot.0 - residual.target.0).xy());
            let (begun, first) = *lookalike.begun.get_or_insert((place, offset));
            let flown_m = (place - begun).norm();
            let bias_m = CHANGE_SIGMAS * place.norm() * radar.track_errors.bias_azimuth;
            if (offset - first).norm() > CHANGE_M + CHANGE_SHARE * flown_m + bias_m {
                self.0.remove(&tracklet.id);
                return None;
            }
            lookalike.is_proven |= flown_m >= PROVEN_M + 2.0 * bias_m;
            lookalike.along.add(residual);
        }
        let is_due = lookalike.is_proven && lookalike.along.gathered_s() >= SEGMENT_S;
        is_due.then(|| lookalike.along.take_sample()).flatten().map(|sample| (identity, sample))
    }
}
