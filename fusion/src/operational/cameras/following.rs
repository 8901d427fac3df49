//! Decides which target each track of a camera shows.

use super::{CameraTrack, Cameras, llr};
use crate::operational::cycle::Cycle;
use crate::operational::ids::TargetId;
use crate::operational::settings::Camera;
use crate::operational::targets::Targets;
use crate::operational::tuning::{
    CAMERA_ENDS_S, CAMERA_FOLLOW_LLR, CAMERA_KEPT, CAMERA_LLR_MAX, CAMERA_MARGIN_LLR,
};
use crate::time::Time;

impl Cameras {
    /// Decides the target of each track from the looks up to the slot, and removes tracks that have ended.
    pub(in crate::operational) fn follow(&mut self, targets: &Targets, cycle: &Cycle) {
        let Cycle { centre, previous, settings, .. } = *cycle;
        self.0.retain(|_, track| {
            while track.looks.front().is_some_and(|look| look.time < centre + -CAMERA_KEPT) {
                track.looks.pop_front();
            }
            track.looks.back().is_some_and(|last| centre.seconds_since(last.time) <= CAMERA_ENDS_S)
        });
        for (key, track) in &mut self.0 {
            if let Some(camera) = settings.camera(key.sensor) {
                track.score(targets, camera, centre);
                let before = track.target;
                track.decide(targets);
                if track.target != before {
                    track.from = previous;
                }
            }
        }
    }
}

impl CameraTrack {
    fn score(&mut self, targets: &Targets, camera: &Camera, centre: Time) {
        let first = self.looks.partition_point(|look| look.time <= self.until);
        for look in self.looks.range(first..).take_while(|look| look.time <= centre) {
            for target in targets.iter().filter(|target| !targets.is_companion(target.id())) {
                let llr = target.estimate(look.time).and_then(|place| llr(look, camera, &place));
                let Some(llr) = llr else { continue };
                let known = self.scores.get(&target.id()).copied();
                // Targets that were never in the field of view need not be remembered.
                if known.is_some() || llr > 0.0 {
                    let sum = known.unwrap_or(0.0) + llr;
                    self.scores.insert(target.id(), sum.clamp(-CAMERA_LLR_MAX, CAMERA_LLR_MAX));
                }
            }
        }
        self.until = self.until.max(centre);
    }

    fn decide(&mut self, targets: &Targets) {
        self.scores.retain(|&id, score| {
            targets.get(id).is_some() && !targets.is_companion(id) && *score > -CAMERA_LLR_MAX
        });
        let mut best = None;
        for (&id, &score) in &self.scores {
            if best.is_none_or(|(_, most)| score > most) {
                best = Some((id, score));
            }
        }
        let second = |id: TargetId| {
            let others = self.scores.iter().filter(|(other, _)| **other != id).map(|(_, score)| *score);
            others.fold(f64::NEG_INFINITY, f64::max)
        };
        // The present target is kept until another one is better by the margin.
        let own = self.target.and_then(|id| Some((id, *self.scores.get(&id)?)));
        let stays = own.filter(|&(id, score)| score > 0.0 && second(id) < score + CAMERA_MARGIN_LLR);
        let new =
            best.filter(|&(id, score)| score >= CAMERA_FOLLOW_LLR && second(id) <= score - CAMERA_MARGIN_LLR);
        self.target = stays.or(new).map(|(id, _)| id);
    }
}
