//! Who will come near whom: the engine's conflicts, computed on each second's picture and named as readers know the tracks.

mod json;

use std::collections::BTreeMap;

use nalgebra::{Matrix2, Matrix4};

use crate::config::{Config, PictureKind};
use crate::picture::{Picture, PictureMaker, PictureTrack, TrackClass};
use fusion::conflicts::{self, Aircraft, Conflicts, Kind, Level, Unseen, Volume};
use fusion::frames::Geodetic;
use fusion::integrity::State;
use fusion::time::{SECOND, Time};
use fusion::{Enu, Identity};

pub use json::{ConflictJson, ConflictLine, NO_LEVEL, VolumeJson, levels};

/// Looks at every second's picture.
#[derive(Debug)]
pub struct ConflictWatch {
    conflicts: Conflicts,
    on: PictureKind,
    /// From the time of the picture to that of the evaluation, seconds.
    age_s: f64,
    max_accuracy_m: f64,
    /// Those that hold a level, by id and volume, as they were seen last.
    held: BTreeMap<(u64, usize), Conflict>,
}

/// What was found in a second.
#[derive(Clone, Debug, PartialEq)]
pub struct Outlook {
    /// The time of the positions.
    pub time: Time,
    /// Every pair and volume with a level, or with a probability of at least 0.01; of those that hold a level although one
    /// of both is missing what was found when both were seen last.
    pub conflicts: Vec<Conflict>,
    /// What the stream tells: warnings and violations, and each change of a level.
    pub news: Vec<Conflict>,
    /// Aircraft that took part.
    pub aircraft: usize,
    /// Aircraft without a sound covariance.
    pub left_out: usize,
    /// Pairs that were near enough to be looked at.
    pub tested: usize,
}

/// A pair and a volume, by the names that readers know.
#[derive(Clone, Debug, PartialEq)]
pub struct Conflict {
    /// The time of the evaluation.
    pub time: Time,
    /// The time of the positions: earlier where one of both is missing.
    pub seen: Time,
    /// What the engine found.
    pub found: conflicts::Conflict,
    /// Ids of both tracks.
    pub tracks: [String; 2],
    /// Their numbers.
    pub numbers: [u32; 2],
    /// Name of the volume.
    pub volume: String,
    /// Where both are at the closest point of approach; the height is `None` where it is not known.
    pub cpa: [(Geodetic, Option<f64>); 2],
    /// The worse state of their transponders.
    pub integrity: Option<State>,
    /// Their transponders, as far as nothing speaks against these.
    pub trusted: [Option<Identity>; 2],
}

impl Conflict {
    /// Whether both were there.
    pub fn is_seen(&self) -> bool {
        self.seen == self.time
    }

    /// The level that holds.
    pub fn level(&self) -> Option<Level> {
        self.found.level.map(|(level, _)| level)
    }
}

impl ConflictWatch {
    /// For a site where they are computed.
    pub fn of(config: &Config) -> Option<Self> {
        config.finds_conflicts().then(|| Self::new(config))
    }

    /// For a site, also where its configuration does not ask for it.
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

    /// The picture that it looks at.
    pub fn on(&self) -> PictureKind {
        self.on
    }

    /// What is found in a picture; `None` between two evaluations.
    pub fn look(&mut self, picture: &Picture, maker: &PictureMaker) -> Option<Outlook> {
        if !maker.begins_second(picture.slot) {
            return None;
        }
        let time = Time::from_nanos(picture.time.nanos() + (self.age_s * SECOND as f64) as i64);
        let tracks: BTreeMap<conflicts::Key, &PictureTrack> =
            picture.within(self.max_accuracy_m).map(|track| (key(track), track)).collect();
        let aircraft = tracks.values().filter_map(|track| self.aircraft(track, maker)).collect();
        let evaluation = self.conflicts.evaluate(time, aircraft);
        let aircraft = &evaluation.aircraft;
        let named = |&found: &conflicts::Conflict| {
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
        for &Unseen { id, volume, level } in &evaluation.unseen {
            if let Some(conflict) = self.held.get(&(id, volume)) {
                let found = conflicts::Conflict { level: Some(level), ..conflict.found };
                conflicts.push(Conflict { time, found, ..conflict.clone() });
            }
        }
        let news = self.news(&conflicts);
        let conflicts::Evaluation { aircraft, left_out, tested, .. } = evaluation;
        Some(Outlook { time, conflicts, news, aircraft: aircraft.len(), left_out, tested })
    }

    /// What is new since the evaluation before.
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

    /// `None`: it takes no part.
    fn aircraft(&self, track: &PictureTrack, maker: &PictureMaker) -> Option<Aircraft> {
        let point = &track.point;
        let estimate = point.estimate.as_ref()?;
        let kind = match maker.class(track) {
            TrackClass::Crewed => Kind::Crewed,
            TrackClass::Drone | TrackClass::Unknown => Kind::Drone,
            // Birds are near each other all day.
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
        let aircraft = Aircraft {
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

fn key(track: &PictureTrack) -> conflicts::Key {
    (track.point.number, track.point.first_seen)
}
