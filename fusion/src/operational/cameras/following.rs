//! Decides which target each track of a camera shows, and learns the cameras' orientations.

use super::{CameraTrack, Cameras, OrientedCamera, PairScore, look_at};
use crate::operational::cycle::Cycle;
use crate::operational::ids::TargetId;
use crate::operational::settings::Camera;
use crate::operational::targets::{Target, Targets};
use crate::operational::tuning::{
    CAMERA_ENDS_S, CAMERA_FIELD, CAMERA_FOLLOW_LLR, CAMERA_KEPT, CAMERA_LLR_MAX, CAMERA_LOOK_LLR_MAX,
    CAMERA_MARGIN_LLR, CAMERA_SPAN, CAMERA_TURNED_LLR, CAMERA_TURNED_LOOKS, CAMERA_TURNED_SPAN,
};
use crate::registration::{CameraLook, CameraOrientation};
use crate::time::Time;

impl Cameras {
    /// Decides the target of each track from the looks up to the slot, and removes tracks that have ended. `is_trusted`:
    /// whether the position of a target may teach a camera.
    pub(in crate::operational) fn follow(
        &mut self,
        targets: &Targets,
        is_trusted: impl Fn(TargetId) -> bool,
        cycle: &Cycle,
    ) {
        let Cycle { centre, previous, settings, .. } = *cycle;
        self.tracks.retain(|_, track| {
            while track.looks.front().is_some_and(|look| look.time < centre + -CAMERA_KEPT) {
                track.looks.pop_front();
            }
            track.looks.back().is_some_and(|last| centre.seconds_since(last.time) <= CAMERA_ENDS_S)
        });
        let mut turned = Vec::new();
        for (key, track) in &mut self.tracks {
            let Some(camera) = settings.camera(key.sensor) else { continue };
            let configured = CameraOrientation::configured(camera.orientation);
            let oriented = self.oriented.entry(key.sensor).or_insert(OrientedCamera {
                orientation: configured,
                turned: None,
                until: centre,
            });
            if camera.orientation > 0.0 {
                oriented.orientation.advance(centre.seconds_since(oriented.until));
            }
            oriented.until = centre;
            let may_teach = |target: &Target| {
                is_trusted(target.id()) && target.transponder().is_some() && target.is_heard(cycle)
            };
            track.score(targets, camera, oriented, may_teach, centre);
            let before = track.target;
            track.decide(targets);
            if let Some(new) = track.turned_orientation(oriented) {
                *oriented = OrientedCamera { orientation: new, turned: Some(centre), until: centre };
                turned.push(key.sensor);
            }
            if track.target != before {
                track.from = previous;
            }
        }
        // Scores with an orientation that was wrong mean nothing.
        for (_, track) in self.tracks.iter_mut().filter(|(key, _)| turned.contains(&key.sensor)) {
            (track.target, track.scores) = (None, Default::default());
        }
    }
}

impl CameraTrack {
    /// Adds the looks since the last slot to the scores, and to the camera's orientation.
    fn score(
        &mut self,
        targets: &Targets,
        camera: &Camera,
        oriented: &mut OrientedCamera,
        may_teach: impl Fn(&Target) -> bool,
        centre: Time,
    ) {
        let first = self.looks.partition_point(|look| look.time <= self.until);
        for look in self.looks.range(first..).take_while(|look| look.time <= centre) {
            for target in targets.iter().filter(|target| !targets.is_companion(target.id())) {
                let place = target.estimate(look.time);
                let Some(view) = place.and_then(|place| look_at(look, camera, &place)) else { continue };
                let orientation = &mut oriented.orientation;
                let is_known = orientation.is_known(view.expected, look.elevation.is_some());
                let begun = || PairScore {
                    llr: 0.0,
                    own_llr: 0.0,
                    own: CameraOrientation::configured(camera.orientation),
                    first: view.expected,
                    span: 0.0,
                };
                let mut pair = self.scores.remove(&target.id());
                let was_known = pair.is_some();
                let mut pair_now = pair.take().unwrap_or_else(begun);
                let own = llr(&pair_now.own, &view);
                let llr = if is_known { llr(orientation, &view) } else { own };
                // Targets that were never in the field of view need not be remembered.
                if !was_known && llr <= 0.0 && own <= 0.0 {
                    continue;
                }
                let sum = |before: f64, more: f64| (before + more).clamp(-CAMERA_LLR_MAX, CAMERA_LLR_MAX);
                (pair_now.llr, pair_now.own_llr) = (sum(pair_now.llr, llr), sum(pair_now.own_llr, own));
                pair_now.own.learn(&view);
                pair_now.span = pair_now.span.max(angle(view.expected, pair_now.first));
                if self.target == Some(target.id()) && may_teach(target) {
                    if is_known {
                        orientation.learn(&view);
                    } else if pair_now.span >= CAMERA_SPAN
                        && pair_now.own.uncertainty() < orientation.uncertainty()
                    {
                        *orientation = pair_now.own;
                    }
                }
                self.scores.insert(target.id(), pair_now);
            }
        }
        self.until = self.until.max(centre);
    }

    fn decide(&mut self, targets: &Targets) {
        self.scores.retain(|&id, pair| {
            targets.get(id).is_some()
                && !targets.is_companion(id)
                && pair.llr.max(pair.own_llr) > -CAMERA_LLR_MAX
        });
        let mut best = None;
        for (&id, pair) in &self.scores {
            if best.is_none_or(|(_, most)| pair.llr > most) {
                best = Some((id, pair.llr));
            }
        }
        let second = |id: TargetId| {
            let others = self.scores.iter().filter(|(other, _)| **other != id).map(|(_, pair)| pair.llr);
            others.fold(f64::NEG_INFINITY, f64::max)
        };
        // The present target is kept until another one is better by the margin.
        let own = self.target.and_then(|id| Some((id, self.scores.get(&id)?.llr)));
        let stays = own.filter(|&(id, score)| score > 0.0 && second(id) < score + CAMERA_MARGIN_LLR);
        let new =
            best.filter(|&(id, score)| score >= CAMERA_FOLLOW_LLR && second(id) <= score - CAMERA_MARGIN_LLR);
        self.target = stays.or(new).map(|(id, _)| id);
    }

    /// The orientation that explains the track by one target, which the camera's orientation contradicts; `None`: there is none.
    fn turned_orientation(&self, oriented: &OrientedCamera) -> Option<CameraOrientation> {
        let contradicts = |pair: &PairScore| {
            pair.llr <= -CAMERA_TURNED_LLR
                && pair.own_llr >= CAMERA_TURNED_LLR
                && pair.own.looks >= CAMERA_TURNED_LOOKS
                && pair.span >= CAMERA_TURNED_SPAN
        };
        if oriented.orientation.looks == 0 || self.scores.values().any(|pair| pair.llr > 0.0) {
            return None;
        }
        let (id, pair) = self.scores.iter().find(|(_, pair)| contradicts(pair))?;
        let is_alone = |(other, its): (&TargetId, &PairScore)| {
            other == id || its.own_llr <= pair.own_llr - CAMERA_MARGIN_LLR
        };
        self.scores.iter().all(is_alone).then_some(pair.own)
    }
}

/// LLR that a look is at its aircraft rather than anywhere in the field of view.
fn llr(orientation: &CameraOrientation, look: &CameraLook) -> f64 {
    let angles = orientation.log_likelihoods(look);
    let sum: f64 = angles.into_iter().flatten().map(|likelihood| likelihood + CAMERA_FIELD.ln()).sum();
    sum.clamp(-CAMERA_LOOK_LLR_MAX, CAMERA_LOOK_LLR_MAX)
}

/// Angle between two directions, azimuth and elevation each, radians.
fn angle([azimuth, elevation]: [f64; 2], other: [f64; 2]) -> f64 {
    let cos =
        elevation.sin() * other[1].sin() + elevation.cos() * other[1].cos() * (azimuth - other[0]).cos();
    cos.clamp(-1.0, 1.0).acos()
}
