//! Targets that two cameras begin where their lines of sight cross.
//!
//! Each pair of tracks of two cameras is a candidate while neither follows a target. If both show one aircraft, the distance of
//! their lines is due to the errors of both cameras; if not, it is the distance of two aircraft ([`PairEvidence`]). With several
//! aircraft, some lines of different aircraft cross as well. A pair begins a target only if it is clearly likelier than every other
//! pair of its tracks, by its own lines or by those of a third camera. Other pairs stay open.

use std::collections::{BTreeMap, BTreeSet};

use nalgebra::{Matrix2, Vector2, Vector3};

use super::crossing::{Crossing, Passing, SightOffset};
use super::evidence::{CameraStarts, PairEvidence, TrackPair};
use super::{CameraTrack, Cameras, PairScore};
use crate::filter::StateEstimate;
use crate::operational::cycle::{Cycle, EARLIEST, LATEST};
use crate::operational::ids::{Begun, TargetId};
use crate::operational::settings::OperationalSettings;
use crate::operational::targets::{Target, Targets};
use crate::operational::tracklets::Tracklets;
use crate::operational::tuning::{
    CAMERA_END_LLR, CAMERA_ENDS_S, CAMERA_FIELD, CAMERA_FOLLOW_LLR, CAMERA_FREE_MAX, CAMERA_LLR_MAX,
    CAMERA_MARGIN_LLR, CAMERA_PAIRS_MAX, CAMERA_SPEED_S, CAMERA_START_LOOKS, CAMERA_START_SIGMA_M,
    CAMERA_THIRD_LLR, CAMERA_THIRD_LLR_MAX, CAMERA_THIRD_S, CAMERA_TOGETHER_S, DRONE_ACCELERATION_MAX_M_S2,
    DRONE_CLIMB_MAX_M_S, DRONE_SPEED_MAX_M_S,
};
use crate::report::{CameraTrackKey, SensorIndex};
use crate::time::Time;

impl Cameras {
    /// Pairs of tracks that have begun no target.
    pub(in crate::operational) fn starts(&self) -> CameraStarts {
        self.starts
    }

    /// Begins targets where the lines of sight of two cameras cross, and ends those whose lines no longer do.
    pub(in crate::operational) fn start(&mut self, targets: &mut Targets, cycle: &Cycle) {
        self.starts.undecided = 0;
        if self.oriented.len() < 2 && self.pairs.is_empty() {
            return;
        }
        let mut evidence = std::mem::take(&mut self.pairs);
        let founding = self.founding(targets);
        let open = self.open(targets, cycle);
        let is_kept: BTreeSet<TrackPair> = open.iter().copied().chain(founding.values().copied()).collect();
        evidence.retain(|pair, _| is_kept.contains(pair));
        for &pair in &is_kept {
            self.compare(pair, evidence.entry(pair).or_default(), cycle.centre, cycle.settings);
        }
        let is_wrong = |(_, pair): &(&TargetId, &TrackPair)| {
            evidence.get(pair).is_some_and(|evidence| evidence.total() < CAMERA_END_LLR)
        };
        let wrong: BTreeSet<TargetId> = founding.iter().filter(is_wrong).map(|(&id, _)| id).collect();
        for track in self.tracks.values_mut().filter(|_| !wrong.is_empty()) {
            track.target = track.target.filter(|id| !wrong.contains(id));
            track.scores.retain(|id, _| !wrong.contains(id));
        }
        targets.forget_all(&wrong);
        // Looks after the slot are known as well.
        let with_ahead = |pair: &TrackPair| {
            let mut ahead = evidence.get(pair).cloned().unwrap_or_default();
            if ahead.total() > CAMERA_END_LLR {
                self.compare(*pair, &mut ahead, LATEST, cycle.settings);
            }
            (*pair, ahead)
        };
        let ahead: BTreeMap<TrackPair, PairEvidence> = open.iter().map(with_ahead).collect();
        let mut begun: Vec<Crossing> = Vec::new();
        for &pair in open.iter().filter(|pair| ahead[pair].is_ready(cycle.centre)) {
            if !self.is_clear(pair, &open, &ahead, cycle) {
                self.starts.undecided += 1;
                continue;
            }
            let Some((first, crossing)) = self.path(pair, cycle) else { continue };
            // A second pair of cameras may begin to see the same aircraft.
            if begun.iter().any(|other| crossing.may_be(other)) {
                continue;
            }
            begun.push(crossing);
            self.begin(pair, first, targets, cycle);
        }
        self.pairs = evidence;
    }

    /// The pair that began each target that only cameras see, if both tracks still follow it.
    fn founding(&self, targets: &Targets) -> BTreeMap<TargetId, TrackPair> {
        let followed = |key: &CameraTrackKey| self.tracks.get(key).and_then(|track| track.target);
        let pair = |id: TargetId| match id.begun {
            Begun::Cameras(_, one, other)
                if followed(&one) == Some(id)
                    && followed(&other) == Some(id)
                    && targets.get(id).is_some_and(Target::is_of_cameras_alone) =>
            {
                Some((id, (one, other)))
            }
            _ => None,
        };
        targets.iter().filter_map(|target| pair(target.id())).collect()
    }

    /// Pairs of tracks that follow no target and may be none of the known ones. The tracks of each camera that have lasted longest
    /// are taken.
    fn open(&mut self, targets: &Targets, cycle: &Cycle) -> Vec<TrackPair> {
        let is_seen = |id: &TargetId| {
            targets
                .get(*id)
                .and_then(|target| target.last_measurement())
                .is_some_and(|last| cycle.centre.seconds_since(last.time) <= CAMERA_ENDS_S)
        };
        let is_free = |track: &CameraTrack| {
            track.target.is_none()
                && track.looks.len() >= CAMERA_START_LOOKS as usize / 2
                && track.looks.back().is_some_and(|last| last.time >= cycle.centre)
                && !track.scores.iter().any(|(id, pair)| pair.llr > 0.0 && is_seen(id))
        };
        let mut of_camera: BTreeMap<SensorIndex, Vec<(Time, CameraTrackKey)>> = BTreeMap::new();
        for (&key, track) in self.tracks.iter().filter(|(_, track)| is_free(track)) {
            of_camera.entry(key.sensor).or_default().push((track.begun, key));
        }
        let mut left_out = 0;
        for tracks in of_camera.values_mut() {
            tracks.sort_unstable();
            left_out += tracks.len().saturating_sub(CAMERA_FREE_MAX);
            tracks.truncate(CAMERA_FREE_MAX);
        }
        let mut pairs = Vec::new();
        for (sensor, tracks) in &of_camera {
            for (other, others) in of_camera.range(sensor..).skip(1) {
                debug_assert!(sensor < other);
                pairs.extend(tracks.iter().flat_map(|one| others.iter().map(|other| (one.1, other.1))));
            }
        }
        left_out += pairs.len().saturating_sub(CAMERA_PAIRS_MAX);
        pairs.truncate(CAMERA_PAIRS_MAX);
        self.starts.left_out += left_out as u64;
        pairs
    }

    /// Two tracks.
    fn tracks_of(&self, (one, other): TrackPair) -> Option<(&CameraTrack, &CameraTrack)> {
        self.tracks.get(&one).zip(self.tracks.get(&other))
    }

    /// How the lines of sight of two tracks pass each other at a time.
    fn passing(&self, pair: TrackPair, time: Time, settings: &OperationalSettings) -> Option<Passing> {
        let (one, other) = self.tracks_of(pair)?;
        let line = |key: CameraTrackKey, track: &CameraTrack| {
            track.line_at(time, settings.camera(key.sensor)?, self.oriented.get(&key.sensor)?)
        };
        Some(line(pair.0, one)?.passing(&line(pair.1, other)?))
    }

    /// Adds the looks up to a time to the evidence.
    fn compare(
        &self,
        pair: TrackPair,
        evidence: &mut PairEvidence,
        until: Time,
        settings: &OperationalSettings,
    ) {
        let Some((one, _)) = self.tracks_of(pair) else { return };
        let since = evidence.until;
        let times = one.looks.iter().map(|look| look.time);
        for time in times.filter(|&time| time > since && time <= until) {
            if let Some(passing) = self.passing(pair, time, settings) {
                evidence.add(time, &passing);
            }
        }
        evidence.until = evidence.until.max(until);
    }

    /// Where the lines of two tracks cross at the looks of the first.
    fn crossings(&self, pair: TrackPair, settings: &OperationalSettings) -> Vec<(Time, Crossing)> {
        let times = self.tracks.get(&pair.0).into_iter().flat_map(|one| &one.looks).map(|look| look.time);
        let crossing = |time| match self.passing(pair, time, settings)? {
            Passing::Near(crossing) => Some((time, crossing)),
            Passing::Behind | Passing::Parallel => None,
        };
        times.filter_map(crossing).collect()
    }

    /// Whether a pair is clearly likelier than every other one of its tracks.
    fn is_clear(
        &self,
        pair: TrackPair,
        open: &[TrackPair],
        evidence: &BTreeMap<TrackPair, PairEvidence>,
        cycle: &Cycle,
    ) -> bool {
        let total = |pair: &TrackPair| evidence.get(pair).map_or(0.0, PairEvidence::total);
        let own = total(&pair);
        let is_of = |track: CameraTrackKey, sensor: SensorIndex, other: &TrackPair| {
            (other.0 == track && other.1.sensor == sensor) || (other.1 == track && other.0.sensor == sensor)
        };
        let is_rival = |other: &&TrackPair| {
            **other != pair
                && (is_of(pair.0, pair.1.sensor, other) || is_of(pair.1, pair.0.sensor, other))
                && total(other) > own - CAMERA_MARGIN_LLR
        };
        let mut rivals = open.iter().filter(is_rival).peekable();
        if rivals.peek().is_none() {
            return true;
        }
        let third = self.third_llr(pair, cycle);
        third > 0.0
            && rivals
                .all(|&rival| total(&rival) + self.third_llr(rival, cycle) <= own + third - CAMERA_MARGIN_LLR)
    }

    /// LLR of the best track of a third camera for the positions where the lines of a pair cross; at least zero.
    fn third_llr(&self, pair: TrackPair, cycle: &Cycle) -> f64 {
        let settings = cycle.settings;
        let mut crossings = self.crossings(pair, settings);
        let mut last = EARLIEST;
        crossings.retain(|(time, _)| {
            let is_apart = last == EARLIEST || time.seconds_since(last) >= CAMERA_THIRD_S;
            if is_apart {
                last = *time;
            }
            is_apart
        });
        let thirds =
            self.tracks.iter().filter(|(key, _)| key.sensor != pair.0.sensor && key.sensor != pair.1.sensor);
        let of_track = |(key, track): (&CameraTrackKey, &CameraTrack)| {
            let (camera, oriented) = settings.camera(key.sensor).zip(self.oriented.get(&key.sensor))?;
            let llrs = crossings.iter().filter_map(|(time, crossing)| {
                let line = track.line_at(*time, camera, oriented)?;
                let SightOffset { angles: off, variances, rows } = line.off(&crossing.position)?;
                let spread =
                    |one: usize, other: usize| (rows[one].transpose() * crossing.covariance * rows[other]).x;
                let covariance = Matrix2::new(
                    variances[0] + spread(0, 0),
                    spread(0, 1),
                    spread(1, 0),
                    variances[1] + spread(1, 1),
                );
                let off = Vector2::from(off);
                let distance = (off.transpose() * covariance.try_inverse()? * off).x;
                let density = covariance.determinant().sqrt() * std::f64::consts::TAU;
                let llr = 2.0 * CAMERA_FIELD.ln() - density.ln() - 0.5 * distance;
                Some(llr.clamp(CAMERA_THIRD_LLR[0], CAMERA_THIRD_LLR[1]))
            });
            Some(llrs.sum::<f64>().min(CAMERA_THIRD_LLR_MAX))
        };
        thirds.filter_map(of_track).fold(0.0, f64::max)
    }

    /// The crossing nearest to the slot, and the time of the first one, if the crossings are the path of a drone and the position is
    /// known well enough.
    fn path(&self, pair: TrackPair, cycle: &Cycle) -> Option<(Time, Crossing)> {
        let crossings = self.crossings(pair, cycle.settings);
        let away = |time: Time| (time.nanos() - cycle.centre.nanos()).abs();
        let &(time, crossing) = crossings.iter().min_by_key(|(time, _)| away(*time))?;
        if away(time) > (CAMERA_TOGETHER_S * 1e9) as i64 || crossing.sigma_m() > CAMERA_START_SIGMA_M {
            return None;
        }
        let (mut steps, mut wrong) = (0, 0);
        let mut before: Option<(Time, Vector3<f64>, f64)> = None;
        let mut from = crossings.first()?;
        for to in &crossings {
            let dt = to.0.seconds_since(from.0);
            if dt < CAMERA_SPEED_S {
                continue;
            }
            let velocity = (to.1.position - from.1.position) / dt;
            let sigma_m_s = 3.0 * from.1.sigma_m().hypot(to.1.sigma_m()) * 3_f64.sqrt() / dt;
            let middle = Time::from_nanos((from.0.nanos() + to.0.nanos()) / 2);
            let turns = before.is_some_and(|(earlier, other, other_m_s)| {
                let change_m_s = DRONE_ACCELERATION_MAX_M_S2 * middle.seconds_since(earlier);
                (velocity - other).norm() > change_m_s + sigma_m_s + other_m_s
            });
            let is_wrong = velocity.xy().norm() > DRONE_SPEED_MAX_M_S + sigma_m_s
                || velocity.z.abs() > DRONE_CLIMB_MAX_M_S + sigma_m_s
                || turns;
            steps += 1;
            wrong += usize::from(is_wrong);
            before = Some((middle, velocity, sigma_m_s));
            from = to;
        }
        // A few looks of real cameras are wrong.
        (steps > 0 && wrong * 5 <= steps).then(|| (crossings[0].0, crossing))
    }

    /// Begins a target with the looks of both tracks from `first` on.
    fn begin(&mut self, pair: TrackPair, first: Time, targets: &mut Targets, cycle: &Cycle) {
        let id = TargetId { slot: cycle.slot, begun: Begun::Cameras(first, pair.0, pair.1) };
        targets.insert_sighted(id, cycle);
        for key in [pair.0, pair.1] {
            let Some((track, oriented)) = self.tracks.get_mut(&key).zip(self.oriented.get(&key.sensor))
            else {
                continue;
            };
            track.target = Some(id);
            track.from = Time::from_nanos(first.nanos() - 1);
            let first = track.looks.front();
            let first = first.map_or([0.0; 2], |look| [look.azimuth, look.elevation.unwrap_or(0.0)]);
            track.scores.insert(
                id,
                PairScore {
                    llr: CAMERA_LLR_MAX,
                    own_llr: CAMERA_LLR_MAX,
                    own: oriented.orientation,
                    first,
                    span: 0.0,
                },
            );
        }
    }

    /// Position at a time of a target that two cameras have begun, where their lines cross.
    pub(in crate::operational) fn crossing_of(
        &self,
        target: TargetId,
        time: Time,
        settings: &OperationalSettings,
    ) -> Option<StateEstimate> {
        let Begun::Cameras(_, one, other) = target.begun else { return None };
        match self.passing((one, other), time, settings)? {
            Passing::Near(crossing) => Some(crossing.estimate()),
            Passing::Behind | Passing::Parallel => None,
        }
    }

    /// Unites each target that only cameras see with another one that all of its tracks follow as well, unless another track of
    /// the same cameras follows that. A target with a transponder remains, otherwise the older one.
    pub(in crate::operational) fn join(
        &mut self,
        targets: &mut Targets,
        tracklets: &mut Tracklets,
        cycle: &Cycle,
    ) {
        let is_alone = |id: TargetId| targets.get(id).is_some_and(Target::is_of_cameras_alone);
        let mut of_target: BTreeMap<TargetId, Vec<CameraTrackKey>> = BTreeMap::new();
        for (&key, track) in &self.tracks {
            if let Some(target) = track.target {
                of_target.entry(target).or_default().push(key);
            }
        }
        let mut joined: Vec<(TargetId, TargetId)> = Vec::new();
        for (&id, keys) in of_target.iter().filter(|(id, _)| is_alone(**id)) {
            let own = keys.iter().filter_map(|key| self.tracks.get(key));
            let mut common: Option<BTreeSet<TargetId>> = None;
            for track in own {
                let fits = track.scores.iter().filter(|(_, pair)| pair.llr >= CAMERA_FOLLOW_LLR);
                let fits: BTreeSet<TargetId> = fits.map(|(&other, _)| other).collect();
                common = Some(match common {
                    Some(common) => common.intersection(&fits).copied().collect(),
                    None => fits,
                });
            }
            let sensors: BTreeSet<SensorIndex> = keys.iter().map(|key| key.sensor).collect();
            let is_free = |other: &TargetId| {
                let others = of_target.get(other).into_iter().flatten();
                *other != id && others.map(|key| key.sensor).all(|sensor| !sensors.contains(&sensor))
            };
            let is_now = |other: &TargetId| {
                targets
                    .get(*other)
                    .and_then(|target| target.last_measurement())
                    .is_some_and(|last| cycle.centre.seconds_since(last.time) <= CAMERA_TOGETHER_S)
            };
            let mut fitting = common.into_iter().flatten().filter(|other| is_free(other) && is_now(other));
            if let (Some(other), None) = (fitting.next(), fitting.next())
                && !joined
                    .iter()
                    .any(|pair| [pair.0, pair.1].iter().any(|known| *known == id || *known == other))
            {
                joined.push((id, other));
            }
        }
        for (id, other) in joined {
            let (from, to) = targets.join(id, other, tracklets);
            for track in self.tracks.values_mut() {
                let score = track.scores.remove(&from);
                if track.target == Some(from) {
                    track.target = Some(to);
                    if let Some(score) = score {
                        track.scores.entry(to).or_insert(score);
                    }
                }
            }
        }
    }
}
