//! Labels radar tracks whose class has settled: with a transponder, or certainly without.

use super::{Classes, LabelledTrack};
use crate::operational::cycle::Cycle;
use crate::operational::targets::Targets;
use crate::operational::tracklets::Tracklets;
use crate::operational::tuning::{ASSOCIATE_LLR, CLASS_UNDECIDED_LLR};

impl Classes {
    /// Adds the radar tracks whose class has settled with the plots up to the slot.
    pub(in crate::operational) fn learn(
        &mut self,
        tracklets: &mut Tracklets,
        targets: &Targets,
        cycle: &Cycle,
    ) {
        let dt = cycle.centre.seconds_since(cycle.previous);
        self.radars.values_mut().for_each(|evidence| evidence.decay(dt));
        for tracklet in tracklets.iter_mut() {
            let Some(mean) = tracklet.take_class() else { continue };
            let has_transponder = |id| targets.get(id).is_some_and(|target| target.transponder().is_some());
            let is_drone = match tracklet.target().filter(|&id| has_transponder(id)) {
                Some(id) if tracklet.pair_llr(id).is_some_and(|llr| llr >= ASSOCIATE_LLR) => true,
                None if tracklet
                    .pairs()
                    .iter()
                    .all(|(_, pair)| pair.total() <= Some(CLASS_UNDECIDED_LLR)) =>
                {
                    false
                }
                _ => continue, // the track cannot be labelled
            };
            let Some(last) = tracklet.last_until(cycle.centre) else { continue };
            let radar = tracklet.key.sensor;
            let track = LabelledTrack { radar, position: last.position, uav_probability: mean, is_drone };
            match self.shared {
                Some(_) => self.labelled.push(track),
                None => self.count(&track),
            }
        }
    }
}
