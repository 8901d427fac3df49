//! The published picture: tracks with WGS-84 positions, made once per slot from the engine's emission.

mod accuracy;
mod class;
pub mod conflicts;
mod contributor_json;
pub mod decode;
pub mod formats;
mod integrity_json;
mod kinds;
mod motion;
mod names;
pub mod remote_id_json;
mod rfc3339;
mod series;
mod texts;
mod track_json;
mod transponder_id;
mod uncooperative_detector;
pub mod xml;

use std::collections::{BTreeMap, BTreeSet};

use fusion::frames::{Geodetic, TangentPlane};
use fusion::integrity::{Concern, State};
use fusion::point::{Basis, Estimate, NowPicture};
use fusion::report::AircraftKind;
use fusion::slots::Slot;
use fusion::time::{SECOND, Time};
use fusion::{Emission, Enu, Identity, Point, SensorIndex, Source};
use input::normalise::Normaliser;
use serde::{Deserialize, Serialize};
use site::config::Config;
pub use site::config::MAX_ACCURACY_M;

pub use accuracy::{AccuracyClass, HORIZONTAL, SPEED, VERTICAL, class_names};
pub use class::TrackClass;
pub use integrity_json::{ReasonName, StateName};
pub use kinds::TrackSource;
pub use motion::{Ellipse, PublishedMotion};
pub use names::{TrackNames, short_serial};
pub use rfc3339::Rfc3339;
pub use series::PictureSeries;
pub use texts::{serial_text, text};
pub use track_json::TrackJson;
pub use transponder_id::TransponderId;
pub use uncooperative_detector::{Resolved, UncooperativeDetector};

/// Maximum standard deviation of an estimated height to be published, in metres. A height that was never measured has at least 60
/// m (`fusion::operational`).
const HEIGHT_KNOWN_M: f64 = 30.0;

/// Time since the last report above which a transponder counts as silent, in seconds.
const HEARD_S: f64 = 5.0;
/// Maximum age of a radar plot that supports the position of a failed transponder, in seconds.
const SUPPORTED_S: f64 = 5.0;

/// All tracks of one slot.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Picture {
    /// Index of the slot.
    pub slot: Slot,
    /// Centre of the slot: time of applicability of all tracks.
    pub time: Time,
    /// Tracks: fused, then radar, transponder and cameras; each by track number.
    pub tracks: Vec<PictureTrack>,
    /// Integrity problems of transponders at this slot.
    pub concerns: Vec<Concern>,
    /// Aircraft that have stopped being uncooperative.
    pub resolved: Vec<Resolved>,
}

impl Picture {
    /// Tracks without vehicles on the ground, and without unmeasured tracks of poor accuracy ([`PictureTrack::is_within`]).
    pub fn within(&self, max_accuracy_m: f64) -> impl Iterator<Item = &PictureTrack> {
        self.tracks.iter().filter(move |track| track.is_within(max_accuracy_m) && !track.is_vehicle())
    }

    /// Copies the findings about tracks and transponders from the picture made with this one.
    pub fn mark_as(&mut self, known: &Self) {
        let by_number: BTreeMap<_, _> = known.tracks.iter().map(|track| (track.key(), track)).collect();
        for track in &mut self.tracks {
            let Some(known) = by_number.get(&track.key()) else { continue };
            track.point.integrity = known.point.integrity;
            track.disputed.clone_from(&known.disputed);
            track.is_uncooperative = known.is_uncooperative;
        }
        self.concerns.clone_from(&known.concerns);
    }

    /// Keeps only the tracks of [`Picture::within`].
    pub fn keep_within(&mut self, max_accuracy_m: f64) {
        self.tracks.retain(|track| track.is_within(max_accuracy_m) && !track.is_vehicle());
    }
}

/// A point of the engine's output with its position on Earth.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PictureTrack {
    /// Point as emitted by the engine.
    pub point: Point,
    /// Time of applicability.
    pub time: Time,
    /// Latitude, longitude and ellipsoidal height. The height is assumed if none was measured.
    pub position: Geodetic,
    /// Height above mean sea level, in metres; `None` if none was measured.
    pub altitude_amsl_m: Option<f64>,
    /// Velocity and accuracy; `None` in the `reference` profile.
    pub motion: Option<PublishedMotion>,
    /// Ids of the tracks of this picture that claim to be the same aircraft at another position.
    pub disputed: Vec<String>,
    /// Id of the aircraft, if assigned by a region of several cells.
    pub id: Option<String>,
    /// Short name, unique among the tracks of a picture; empty until [`TrackNames`] gives it. Each node of a cluster names for itself.
    #[serde(skip)]
    pub name: String,
    /// Whether it flies without a transponder where a receiver should hear one; found by [`UncooperativeDetector`].
    pub is_uncooperative: bool,
}

impl PictureTrack {
    /// Unique key of the aircraft, needed because numbers are reused.
    fn key(&self) -> (u32, Time) {
        (self.point.number, self.point.first_seen)
    }

    /// Position in the order of a picture: fused, then radar, transponder and cameras; each by track number.
    pub const fn order(&self) -> (u8, u32) {
        let rank = match self.point.source {
            Source::Fused(..) => 0,
            Source::Radar(_) => 1,
            Source::Transponder(_) => 2,
            Source::Cameras => 3,
        };
        (rank, self.point.number)
    }

    /// Whether it is a vehicle on the ground of an aerodrome, which clients have to ask for.
    pub fn is_vehicle(&self) -> bool {
        let part = self.point.source.transponder();
        part.is_some_and(|part| part.aircraft.kind == AircraftKind::Vehicle)
    }

    /// Whether the position lies between two measurements. In the `reference` profile: whether there is a transponder, whose
    /// position is always interpolated.
    pub fn is_interpolated(&self) -> bool {
        match &self.motion {
            Some(motion) => motion.basis == Basis::Interpolated,
            None => self.point.source.transponder().is_some(),
        }
    }

    /// Whether the position lies after the last measurement or before the first; never in the `reference` profile.
    pub fn is_extrapolated(&self) -> bool {
        self.motion.is_some_and(|motion| motion.basis == Basis::Extrapolated)
    }

    /// Whether the position lies after the last measurement.
    pub fn is_coasting(&self) -> bool {
        self.is_extrapolated() && self.motion.is_some_and(|motion| motion.last_measurement.is_some())
    }

    /// Whether the track passes the accuracy limit, in metres: not if no sensor measured it in its slot and the radius of 95 % of
    /// its horizontal errors is larger. A measured track always passes.
    pub fn is_within(&self, max_accuracy_m: f64) -> bool {
        self.unmeasured_accuracy_m().is_none_or(|accuracy_m| accuracy_m <= max_accuracy_m)
    }

    /// Radius that contains 95 % of the horizontal errors, in metres, if no sensor measured the track in its slot; otherwise
    /// `None`.
    ///
    /// Also `None` in the `reference` profile; for a transponder that is no longer trusted, because its disputed position has to
    /// be shown; and for a crewed aircraft that is heard, whatever accuracy it reports.
    pub fn unmeasured_accuracy_m(&self) -> Option<f64> {
        let part = self.point.source.transponder();
        let crewed = part.filter(|part| part.aircraft.kind == AircraftKind::Crewed);
        let heard = crewed.and_then(|part| part.time);
        let is_heard = heard.is_some_and(|heard| self.time.seconds_since(heard).abs() <= HEARD_S);
        if is_heard || self.point.estimate.is_some_and(|estimate| estimate.lie_m2 > 0.0) {
            return None;
        }
        self.motion.filter(|motion| motion.basis != Basis::Measured).map(|motion| motion.accuracy_h_m)
    }

    /// Identity of its transponder, if no evidence is against it.
    pub fn trusted(&self) -> Option<Identity> {
        let identity = self.point.source.transponder()?.identity;
        let is_doubted = self.point.integrity.is_some_and(|known| known.state >= State::Suspect);
        (!is_doubted).then_some(identity)
    }

    /// Identity of its transponder, if that has failed and no radar supports the position: radar does not see an aircraft there,
    /// or sees this one elsewhere.
    pub fn failed(&self) -> Option<Identity> {
        let identity = self.point.source.transponder()?.identity;
        let is_failed = self.point.integrity.is_some_and(|known| known.state == State::Failed);
        let seen = self.point.source.radar().map(|radar| self.time.seconds_since(radar.time).abs());
        let is_supported = seen.is_some_and(|age_s| age_s <= SUPPORTED_S) && self.point.disputed.is_empty();
        (is_failed && !is_supported).then_some(identity)
    }

    /// Motion with a vertical component; `None` if the height is unknown.
    pub fn vertical_motion(&self) -> Option<&PublishedMotion> {
        self.motion.as_ref().filter(|_| self.altitude_amsl_m.is_some())
    }

    /// Whether a radar contributed that did not measure the height.
    pub fn radar_height_missing(&self) -> bool {
        self.point.source.radar().is_some_and(|radar| !radar.height_measured)
    }

    /// Name of the source: `fused`, `radar`, `transponder` or `camera`.
    pub fn source_name(&self) -> &'static str {
        TrackSource::from(&self.point.source).name()
    }
}

/// Maker of pictures, with the site's frame, the geoid, and the names of the sensors.
#[derive(Clone, Debug)]
pub struct PictureMaker {
    frame: TangentPlane,
    undulation_m: f64,
    sensors: Vec<String>,
    weights: FusionWeights,
    /// Serial numbers of transponders on crewed aircraft.
    crewed: BTreeSet<String>,
    slots_per_second: i64,
}

/// Weights of the sensors in a fused position.
#[derive(Clone, Copy, Debug, PartialEq)]
struct FusionWeights {
    radar: f64,
    transponder: f64,
}

impl PictureMaker {
    /// Maker for the site of `config`, in the frame of `normaliser`.
    pub fn new(config: &Config, normaliser: &Normaliser) -> Self {
        Self {
            frame: normaliser.frame().clone(),
            undulation_m: normaliser.undulation_m(),
            sensors: config.sensors.iter().map(|sensor| sensor.id.clone()).collect(),
            weights: FusionWeights {
                radar: config.fusion.weight_radar,
                transponder: config.fusion.weight_transponder,
            },
            crewed: config.conflicts.crewed.iter().cloned().collect(),
            slots_per_second: (SECOND / config.fusion.slot.as_nanos() as i64).max(1),
        }
    }

    /// Picture of an emission's slot.
    pub fn picture(&self, emission: Emission) -> Picture {
        self.of(emission.slot, emission.time, emission.points, emission.concerns)
    }

    /// Predicted picture of a deadline.
    pub fn now(&self, now: NowPicture) -> Picture {
        let mut picture = self.of(now.slot, now.time, now.points, Vec::new());
        for track in &mut picture.tracks {
            if let Some((motion, estimate)) = track.motion.as_mut().zip(track.point.estimate.as_ref()) {
                motion.ellipse = Some(Ellipse::of(&estimate.horizontal));
            }
        }
        picture
    }

    fn of(&self, slot: Slot, time: Time, points: Vec<Point>, concerns: Vec<Concern>) -> Picture {
        // Before the points are consumed: links are by number, and clients use ids.
        let disputed: Vec<Vec<String>> = points.iter().map(|point| self.disputed(point, &points)).collect();
        let track = |(point, disputed): (Point, Vec<String>)| {
            let position = self.frame.to_geodetic(point.position);
            let estimate = point.estimate.as_ref();
            let known = |estimate: &Estimate| estimate.vertical_m2 < HEIGHT_KNOWN_M * HEIGHT_KNOWN_M;
            let measured = point.source.height_measured() || estimate.is_some_and(known);
            PictureTrack {
                time,
                position,
                altitude_amsl_m: measured.then_some(position.height_m - self.undulation_m),
                motion: estimate
                    .map(|estimate| PublishedMotion::new(estimate, point.position, position, &self.frame)),
                disputed,
                id: None,
                name: String::new(),
                is_uncooperative: false,
                point,
            }
        };
        Picture {
            slot,
            time,
            tracks: points.into_iter().zip(disputed).map(track).collect(),
            concerns,
            resolved: Vec::new(),
        }
    }

    /// Ids of the `points` that claim to be the same aircraft as `point`.
    fn disputed(&self, point: &Point, points: &[Point]) -> Vec<String> {
        let others =
            point.disputed.iter().filter_map(|&number| points.iter().find(|other| other.number == number));
        others.map(|other| self.id(other)).collect()
    }

    /// Height of the geoid above the ellipsoid at the site, in metres.
    pub fn geoid_undulation_m(&self) -> f64 {
        self.undulation_m
    }

    /// Position on Earth of a position in the site's frame.
    pub fn place(&self, position: Enu) -> Geodetic {
        self.frame.to_geodetic(position)
    }

    /// Whether once-a-second checks run in this slot. If a slot is longer than a second, they run in every slot.
    pub fn begins_second(&self, slot: Slot) -> bool {
        slot.0.rem_euclid(self.slots_per_second) == 0
    }

    /// Duration of a number of slots in seconds, rounded up.
    pub fn seconds(&self, slots: u64) -> u64 {
        slots.div_ceil(self.slots_per_second.unsigned_abs())
    }

    /// Class of a track.
    pub fn class(&self, track: &PictureTrack) -> TrackClass {
        TrackClass::of(&track.point.source, &self.crewed)
    }

    /// Configured name of a sensor.
    pub fn sensor(&self, index: SensorIndex) -> &str {
        &self.sensors[usize::from(index.0)]
    }

    /// Id of a track, made of letters, digits, `-`, `.`, `_`.
    ///
    /// In a region of several cells: `U-<cell>-<count>`. At one site with the `operational` profile, one per aircraft for its
    /// lifetime: `U-<number>`, with `-<first seen>` if the number is reused. With the `reference` profile `F-<number>`,
    /// `T-<number>`, or `R-<sensor>-<number>-<first seen>`, because a radar reuses its numbers.
    pub fn track_id(&self, track: &PictureTrack) -> String {
        track.id.clone().unwrap_or_else(|| self.id(&track.point))
    }

    fn id(&self, point: &Point) -> String {
        let Point { number, first_seen, source, .. } = point;
        if point.estimate.is_some() {
            return match *number {
                own @ 10_000.. => format!("U-{own}"),
                comes_again => format!("U-{comes_again}-{}", first_seen.as_seconds()),
            };
        }
        match source {
            Source::Fused(..) => format!("F-{number}"),
            Source::Radar(radar) => {
                format!("R-{}-{number}-{}", self.sensor(radar.track.sensor), first_seen.as_seconds())
            }
            Source::Transponder(_) => format!("T-{number}"),
            // Only the operational profile has them.
            Source::Cameras => format!("U-{number}-{}", first_seen.as_seconds()),
        }
    }
}

#[cfg(test)]
mod tests;
