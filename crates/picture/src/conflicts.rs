//! Conflicts: evaluates each second's picture with the engine's conflict detection, and names the tracks as readers know them.

mod json;

use std::collections::BTreeMap;

use nalgebra::{Matrix2, Matrix4};

use crate::{Picture, PictureMaker, PictureTrack, TrackClass};
use fusion::conflicts::{self, ConflictAircraft, Conflicts, HeldLevel, Level, TrafficKind, Volume};
use fusion::frames::Geodetic;
use fusion::integrity::State;
use fusion::time::{SECOND, Time};
use fusion::{Enu, Identity};
use site::config::{Config, PictureKind};

pub use json::{ConflictJson, ConflictLine, NO_LEVEL, VolumeJson, levels};

/// Evaluates one picture per second.
#[derive(Debug)]
pub struct ConflictWatch {
    conflicts: Conflicts,
    on: PictureKind,
    /// Time from the picture to the evaluation, in seconds.
    age_s: f64,
    max_accuracy_m: f64,
    /// The conflicts that hold a level, as last evaluated with both aircraft present, by id and volume.
    held: BTreeMap<(u64, usize), Conflict>,
}

/// The result of one evaluation.
#[derive(Clone, Debug, PartialEq)]
pub struct Outlook {
    /// Time of the evaluation.
    pub time: Time,
    /// Every pair and volume with a level, or with a probability of at least 0.01. If one aircraft is missing while a level
    /// holds, the figures are those of the last evaluation with both.
    pub conflicts: Vec<Conflict>,
    /// Conflicts for the stream: warnings and violations, and each change of a level.
    pub news: Vec<Conflict>,
    /// Number of aircraft evaluated.
    pub aircraft: usize,
    /// Number of aircraft without a valid covariance.
    pub left_out: usize,
    /// Number of pairs near enough to be evaluated.
    pub tested: usize,
}

/// A pair of aircraft and a volume, with the names of tracks that readers know.
#[derive(Clone, Debug, PartialEq)]
pub struct Conflict {
    /// Time of the evaluation.
    pub time: Time,
    /// Time of the positions; earlier than `time` if one aircraft is missing.
    pub seen: Time,
    /// Result of the engine.
    pub found: conflicts::PredictedConflict,
    /// Ids of both tracks.
    pub tracks: [String; 2],
    /// Track numbers of both tracks.
    pub numbers: [u32; 2],
    /// Name of the volume.
    pub volume: String,
    /// Positions at the closest point of approach; the height is `None` if it is unknown.
    pub cpa: [(Geodetic, Option<f64>); 2],
    /// State of the less trustworthy of the two transponders.
    pub integrity: Option<State>,
    /// Transponder of each aircraft; `None`: it has none, or integrity checks speak against it.
    pub trusted: [Option<Identity>; 2],
}

impl Conflict {
    /// Whether both aircraft were present at the evaluation.
    pub fn is_seen(&self) -> bool {
        self.seen == self.time
    }

    /// The level, if any.
    pub fn level(&self) -> Option<Level> {
        self.found.level.map(|(level, _)| level)
    }
}

impl ConflictWatch {
    /// The watch of a site; `None` if its configuration does not ask for conflicts.
    pub fn of(config: &Config) -> Option<Self> {
        config.predicts_conflicts().then(|| Self::new(config))
    }

    /// The watch of a site, whether or not its configuration asks for conflicts.
    pub fn new(config: &Config) -> Self {
        let on = config.conflicts.picture;
        Self {
            conflicts: Conflicts::new(config.conflicts.rules()),
            on,
            age_s: config.fusion.latency_of(on).as_secs_f64(),
            max_accuracy_m: config.output.max_accuracy_m,
            held: BTreeMap::new(),
        }
    }

    /// The volumes.
    pub fn volumes(&self) -> &[Volume] {
        &self.conflicts.rules().volumes
    }

    /// The kind of picture that is evaluated.
    pub fn on(&self) -> PictureKind {
        self.on
    }

    /// Evaluates a picture; `None` if no evaluation is due.
    pub fn look(&mut self, picture: &Picture, maker: &PictureMaker) -> Option<Outlook> {
        if !maker.begins_second(picture.slot) {
            return None;
        }
        let time = Time::from_nanos(picture.time.nanos() + (self.age_s * SECOND as f64) as i64);
        let tracks: BTreeMap<conflicts::ConflictKey, &PictureTrack> =
            picture.within(self.max_accuracy_m).map(|track| (key(track), track)).collect();
        let aircraft = tracks.values().filter_map(|track| self.aircraft(track, maker)).collect();
        let evaluation = self.conflicts.evaluate(time, aircraft);
        let aircraft = &evaluation.aircraft;
        let named = |&found: &conflicts::PredictedConflict| {
            let pair = found.pair.map(|index| &aircraft[index]);
            let tracks = pair.map(|one| tracks[&one.key]);
            let t_cpa_s = found.approach.t_cpa_s;
            Conflict {
                time,
                seen: time,
                found,
                tracks: tracks.map(|track| maker.track_id(track)),
                numbers: pair.map(|one| one.key.0),
                volume: self.conflicts.rules().volumes[found.volume].name.clone(),
                cpa: pair.map(|one| {
                    let place = maker.place(Enu::from(one.position.0 + one.velocity * t_cpa_s));
                    (place, one.vertical.map(|_| place.height_m))
                }),
                integrity: tracks.into_iter().filter_map(|track| Some(track.point.integrity?.state)).max(),
                trusted: tracks.map(PictureTrack::trusted),
            }
        };
        let mut conflicts: Vec<Conflict> = evaluation.conflicts.iter().map(named).collect();
        for &HeldLevel { id, volume, level } in &evaluation.unseen {
            if let Some(conflict) = self.held.get(&(id, volume)) {
                let found = conflicts::PredictedConflict { level: Some(level), ..conflict.found };
                conflicts.push(Conflict { time, found, ..conflict.clone() });
            }
        }
        let news = self.news(&conflicts);
        let conflicts::ConflictEvaluation { aircraft, left_out, tested, .. } = evaluation;
        Some(Outlook { time, conflicts, news, aircraft: aircraft.len(), left_out, tested })
    }

    /// The conflicts for the stream since the previous evaluation.
    fn news(&mut self, conflicts: &[Conflict]) -> Vec<Conflict> {
        let held = conflicts.iter().filter(|conflict| conflict.found.level.is_some());
        let held = held.filter_map(|one| Some(((one.found.id?, one.found.volume), one.clone())));
        let before = std::mem::replace(&mut self.held, held.collect());
        let is_news = |(key, conflict): &(&(u64, usize), &Conflict)| {
            let level = before.get(key).and_then(Conflict::level);
            conflict.level() != level || (conflict.is_seen() && level >= Some(Level::Warning))
        };
        let held = self.held.iter().filter(is_news).map(|(_, conflict)| conflict.clone());
        let mut news: Vec<Conflict> = held.collect();
        for (key, mut conflict) in before {
            if !self.held.contains_key(&key) {
                conflict.found.level = None;
                news.push(conflict);
            }
        }
        news
    }

    /// The aircraft of a track; `None` if the track takes no part.
    fn aircraft(&self, track: &PictureTrack, maker: &PictureMaker) -> Option<ConflictAircraft> {
        let point = &track.point;
        let estimate = point.estimate.as_ref()?;
        let kind = match maker.class(track) {
            TrackClass::Crewed => TrafficKind::Crewed,
            TrackClass::Drone | TrackClass::Unknown => TrafficKind::Drone,
            // Birds are near each other all the time.
            TrackClass::Other | TrackClass::Vehicle => return None,
        };
        let mut covariance = Matrix4::zeros();
        let mut put = |row, column, block: &Matrix2<f64>| {
            covariance.fixed_view_mut::<2, 2>(row, column).copy_from(block);
        };
        put(0, 0, &estimate.horizontal);
        put(2, 2, &estimate.velocity_covariance);
        put(0, 2, &estimate.position_velocity);
        put(2, 0, &estimate.position_velocity.transpose());
        let vertical = [estimate.vertical_m2, estimate.height_climb, estimate.climb_m2s2];
        let aircraft = ConflictAircraft {
            key: key(track),
            position: point.position,
            velocity: estimate.velocity,
            covariance,
            vertical: track.altitude_amsl_m.map(|_| vertical),
            kind,
            disputed: point.disputed.clone(),
        };
        Some(aircraft.moved(self.age_s, &self.conflicts.rules().ahead))
    }
}

fn key(track: &PictureTrack) -> conflicts::ConflictKey {
    (track.point.number, track.point.first_seen)
}
