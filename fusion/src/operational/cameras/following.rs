//! Decides which target each track of a camera shows, and learns the cameras' orientations.

use std::collections::BTreeMap;

use super::{CameraTrack, Cameras, OrientedCamera, PairScore, look_at};
use crate::operational::cycle::{Cycle, EARLIEST};
use crate::operational::ids::TargetId;
use crate::operational::settings::Camera;
use crate::operational::targets::Targets;
use crate::operational::tuning::{
    CAMERA_AGREE2, CAMERA_ALONE_LOOKS, CAMERA_ALONE_SPAN, CAMERA_ENDS_S, CAMERA_FIELD, CAMERA_FOLLOW_LLR,
    CAMERA_KEPT, CAMERA_LLR_MAX, CAMERA_LOOK_LLR_MAX, CAMERA_MARGIN_LLR, CAMERA_SPAN, CAMERA_TURNED_LLR,
    CAMERA_TURNED_S, CAMERA_WITNESS_LOOKS,
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
        let may_teach = |id: TargetId| {
            is_trusted(id)
                && targets
                    .get(id)
                    .is_some_and(|target| target.transponder().is_some() && target.is_heard(cycle))
        };
        for (key, track) in &mut self.tracks {
            let Some(camera) = settings.camera(key.sensor) else { continue };
            let oriented = self.oriented.entry(key.sensor).or_insert(OrientedCamera {
                orientation: CameraOrientation::configured(camera.orientation),
                turned: None,
                until: centre,
                learnt: EARLIEST,
            });
            if camera.orientation > 0.0 {
                oriented.orientation.advance(centre.seconds_since(oriented.until));
            }
            oriented.until = centre;
            track.score(targets, camera, oriented, may_teach, centre);
            let before = track.target;
            track.decide(targets);
            if track.target != before {
                track.from = previous;
            }
        }
        self.orient(may_teach, cycle);
    }

    /// Takes an orientation that the tracks determine for each camera whose orientation is not known, or fits no look any more.
    fn orient(&mut self, may_teach: impl Fn(TargetId) -> bool + Copy, cycle: &Cycle) {
        let Cycle { centre, settings, .. } = *cycle;
        for (&sensor, oriented) in &mut self.oriented {
            let Some(camera) = settings.camera(sensor).filter(|camera| camera.orientation > 0.0) else {
                continue;
            };
            let is_known = oriented.orientation.looks > 0;
            if is_known && centre.seconds_since(oriented.learnt) < CAMERA_TURNED_S {
                continue;
            }
            let its = self.tracks.iter().filter(|(key, _)| key.sensor == sensor);
            let witnesses: Vec<PairScore> =
                its.filter_map(|(_, track)| track.witness(is_known, may_teach, camera)).collect();
            let Some(new) = agreed(&witnesses) else { continue };
            let turned = if is_known { Some(centre) } else { oriented.turned };
            *oriented = OrientedCamera { orientation: new, turned, until: centre, learnt: centre };
            // Scores with another orientation mean nothing.
            for track in
                self.tracks.iter_mut().filter(|(key, _)| key.sensor == sensor).map(|(_, track)| track)
            {
                (track.target, track.scores) = (None, BTreeMap::new());
            }
        }
    }
}

/// Orientation on which two tracks agree, or one alone after many looks; `None`: there is none.
fn agreed(witnesses: &[PairScore]) -> Option<CameraOrientation> {
    let agree = |one: &PairScore, other: &PairScore| one.own.distance2(&other.own) <= CAMERA_AGREE2;
    let mut best: Option<&PairScore> = None;
    for (index, one) in witnesses.iter().enumerate() {
        let others = || witnesses.iter().enumerate().filter(|(at, _)| *at != index).map(|(_, other)| other);
        let is_seconded = others().any(|other| agree(one, other));
        let is_alone = one.own.looks >= CAMERA_ALONE_LOOKS && one.span >= CAMERA_ALONE_SPAN;
        let is_contradicted = others().any(|other| !agree(one, other));
        if (is_seconded || (is_alone && !is_contradicted))
            && best.is_none_or(|best| one.own.uncertainty() < best.own.uncertainty())
        {
            best = Some(one);
        }
    }
    best.map(|pair| pair.own)
}

impl CameraTrack {
    /// Adds the looks since the last slot to the scores, and to the camera's orientation.
    fn score(
        &mut self,
        targets: &Targets,
        camera: &Camera,
        oriented: &mut OrientedCamera,
        may_teach: impl Fn(TargetId) -> bool,
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
                let known = self.scores.remove(&target.id());
                let is_new = known.is_none();
                let mut pair = known.unwrap_or_else(begun);
                let own = llr(&pair.own, &view);
                let llr = if is_known { llr(orientation, &view) } else { own };
                // Targets that were never in the field of view need not be remembered.
                if is_new && llr <= 0.0 && own <= 0.0 {
                    continue;
                }
                let sum = |before: f64, more: f64| (before + more).clamp(-CAMERA_LLR_MAX, CAMERA_LLR_MAX);
                (pair.llr, pair.own_llr) = (sum(pair.llr, llr), sum(pair.own_llr, own));
                pair.own.learn(&view);
                pair.span = pair.span.max(angle(view.expected, pair.first));
                if is_known && self.target == Some(target.id()) && may_teach(target.id()) {
                    orientation.learn(&view);
                    oriented.learnt = look.time;
                }
                self.scores.insert(target.id(), pair);
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

    /// The pair that explains the track by one target alone with an orientation of its own; if the camera's orientation is known,
    /// that has to contradict the track. `None`: there is none.
    fn witness(
        &self,
        is_known: bool,
        may_teach: impl Fn(TargetId) -> bool,
        camera: &Camera,
    ) -> Option<PairScore> {
        if is_known && self.scores.values().any(|pair| pair.llr > 0.0) {
            return None;
        }
        let (id, pair) = self.scores.iter().max_by(|one, other| one.1.own_llr.total_cmp(&other.1.own_llr))?;
        let is_alone = |(other, its): (&TargetId, &PairScore)| {
            other == id || its.own_llr <= pair.own_llr - CAMERA_MARGIN_LLR
        };
        let contradicts = !is_known || pair.llr <= -CAMERA_TURNED_LLR;
        let is_close = pair.own.residual2() <= (2.0 * camera.azimuth.max(camera.elevation)).powi(2);
        let is_witness = contradicts
            && is_close
            && pair.own_llr >= CAMERA_TURNED_LLR
            && pair.own.looks >= CAMERA_WITNESS_LOOKS
            && pair.span >= CAMERA_SPAN
            && may_teach(*id)
            && self.scores.iter().all(is_alone);
        is_witness.then(|| pair.clone())
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
