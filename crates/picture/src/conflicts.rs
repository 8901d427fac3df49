//! Conflicts: evaluates each second's picture with the engine's conflict detection, and names the tracks as readers know them.

mod ground;
mod json;

use std::collections::BTreeMap;

use nalgebra::{Matrix2, Matrix4};

use crate::{Picture, PictureMaker, PictureTrack, TrackClass};
use conflict::{ConflictAircraft, Conflicts, HeldLevel, Level, TrafficKind, Volume};
use fusion::frames::Geodetic;
use fusion::integrity::State;
use fusion::time::{SECOND, Time};
use fusion::{Enu, Identity};
use ground::GroundMonitor;
use site::config::{Config, PictureKind};

pub use json::{ConflictJson, ConflictLine, NO_LEVEL, VolumeJson, levels};

/// Standard deviation of a height below which it bounds a conflict although it is too coarse to be published, in metres. A height
/// that was never measured has at least this (`fusion::operational`).
const COARSE_HEIGHT_M: f64 = 60.0;
/// Time for which an aircraft that is no longer in the picture may take part, in nanoseconds.
const MISSING_NS: u64 = 20 * SECOND as u64;
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
    ground: GroundMonitor,
    /// Aircraft of the last pictures: their tracks, and their states at the time of the evaluation.
    recent: BTreeMap<conflict::ConflictKey, RecentAircraft>,
}

/// An aircraft as last seen in a picture.
#[derive(Debug)]
struct RecentAircraft {
    track: PictureTrack,
    state: ConflictAircraft,
    seen: Time,
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
    pub found: conflict::PredictedConflict,
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
    /// Names of both aircraft, as on the map.
    pub names: [String; 2],
    /// Transponder of each aircraft whose reported position is not to be trusted.
    pub failed: [Option<Identity>; 2],
    /// Whether the heights of both are known, not only as a coarse bound.
    pub are_heights_known: bool,
    /// Radius and half height of the volume, metres.
    pub volume_m: [f64; 2],
}

impl Conflict {
    /// Present distance as a share of the volume: below 1, both are within it.
    pub fn closeness(&self) -> f64 {
        let (now, [horizontal_m, vertical_m]) = (&self.found.relative, self.volume_m);
        let above = now.vertical.map_or(0.0, |vertical| vertical.height_m.abs() / vertical_m);
        (now.position.norm() / horizontal_m).max(above)
    }

    /// Whether the volume is known to be entered at the time of the positions.
    pub fn is_entered(&self) -> bool {
        self.are_heights_known && self.found.exit_s.is_some() && self.found.entry_s <= 0.0
    }

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
            ground: GroundMonitor::default(),
            recent: BTreeMap::new(),
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
        let shown: BTreeMap<conflict::ConflictKey, &PictureTrack> =
            picture.within(self.max_accuracy_m).map(|track| (track.key(), track)).collect();
        self.ground.note(picture.time, shown.values().copied());
        let mut aircraft: Vec<ConflictAircraft> =
            shown.values().filter_map(|track| self.aircraft(track, maker)).collect();
        self.remember(time, &shown, &aircraft);
        let missing = self.recent.values().filter(|recent| recent.seen != time);
        aircraft.extend(missing.clone().map(|recent| {
            let age_s = time.seconds_since(recent.seen);
            let state = recent.state.clone().moved(age_s, &self.conflicts.rules().ahead);
            ConflictAircraft { is_shown: false, ..state }
        }));
        let mut tracks = shown;
        tracks.extend(missing.map(|recent| (recent.track.key(), &recent.track)));
        let evaluation = self.conflicts.evaluate(time, aircraft);
        let (aircraft, volumes) = (&evaluation.aircraft, &self.conflicts.rules().volumes);
        let named = |&found: &conflict::PredictedConflict| {
            let pair = found.pair.map(|index| &aircraft[index]);
            let tracks = pair.map(|one| tracks[&one.key]);
            let t_cpa_s = found.approach.t_cpa_s;
            let are_heights_known = tracks.iter().all(|track| track.altitude_amsl_m.is_some());
            // Most aircraft of unknown height are far above or below each other.
            let level = found.level.map(|(level, since)| match are_heights_known {
                true => (level, since),
                false => (Level::Advisory, since),
            });
            let found = conflict::PredictedConflict { level, ..found };
            Conflict {
                time,
                seen: time,
                found,
                tracks: tracks.map(|track| maker.track_id(track)),
                numbers: pair.map(|one| one.key.0),
                volume: volumes[found.volume].name.clone(),
                cpa: pair.map(|one| {
                    let place = maker.place(Enu::from(one.position.0 + one.velocity * t_cpa_s));
                    (place, one.vertical.map(|_| place.height_m))
                }),
                integrity: tracks.into_iter().filter_map(|track| Some(track.point.integrity?.state)).max(),
                trusted: tracks.map(PictureTrack::trusted),
                names: tracks.map(|track| track.name.clone()),
                failed: tracks.map(PictureTrack::failed),
                are_heights_known,
                volume_m: [volumes[found.volume].horizontal_m, volumes[found.volume].vertical_m],
            }
        };
        let mut conflicts: Vec<Conflict> = evaluation.conflicts.iter().map(named).collect();
        for &HeldLevel { id, volume, level } in &evaluation.unseen {
            if let Some(conflict) = self.held.get(&(id, volume)) {
                let level = if conflict.are_heights_known { level } else { (Level::Advisory, level.1) };
                let found = conflict::PredictedConflict { level: Some(level), ..conflict.found };
                conflicts.push(Conflict { time, found, ..conflict.clone() });
            }
        }
        let news = self.news(&conflicts);
        let conflict::ConflictEvaluation { aircraft, left_out, tested, .. } = evaluation;
        Some(Outlook { time, conflicts, news, aircraft: aircraft.len(), left_out, tested })
    }

    /// Replaces the aircraft that are remembered: those of this picture, and those that are missing in it for a short time.
    /// An aircraft that is still shown, but takes no part any more, is forgotten.
    fn remember(
        &mut self,
        time: Time,
        shown: &BTreeMap<conflict::ConflictKey, &PictureTrack>,
        aircraft: &[ConflictAircraft],
    ) {
        let is_recent = |seen: Time| time >= seen && time.nanos().abs_diff(seen.nanos()) <= MISSING_NS;
        self.recent.retain(|key, recent| !shown.contains_key(key) && is_recent(recent.seen));
        for state in aircraft {
            let recent =
                RecentAircraft { track: shown[&state.key].clone(), state: state.clone(), seen: time };
            self.recent.insert(state.key, recent);
        }
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
        if self.ground.has(track) {
            return None;
        }
        let mut covariance = Matrix4::zeros();
        let mut put = |row, column, block: &Matrix2<f64>| {
            covariance.fixed_view_mut::<2, 2>(row, column).copy_from(block);
        };
        put(0, 0, &estimate.horizontal);
        put(2, 2, &estimate.velocity_covariance);
        put(0, 2, &estimate.position_velocity);
        put(2, 0, &estimate.position_velocity.transpose());
        let vertical = [estimate.vertical_m2, estimate.height_climb, estimate.climb_m2s2];
        let is_known = track.altitude_amsl_m.is_some();
        let is_coarse = !is_known && estimate.vertical_m2 < COARSE_HEIGHT_M * COARSE_HEIGHT_M;
        let aircraft = ConflictAircraft {
            key: track.key(),
            position: point.position,
            velocity: estimate.velocity,
            covariance,
            vertical: (is_known || is_coarse).then_some(vertical),
            kind,
            disputed: point.disputed.clone(),
            has_transponder: point.source.transponder().is_some(),
            is_shown: true,
        };
        Some(aircraft.moved(self.age_s, &self.conflicts.rules().ahead))
    }
}
