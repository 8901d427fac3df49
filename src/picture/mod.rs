//! The published picture: tracks with WGS-84 positions, made once per slot from the engine's emission.

mod accuracy;
mod class;
mod integrity_json;
mod kinds;
mod motion;
pub mod remote_id_json;
mod rfc3339;
mod track_json;

use std::collections::{BTreeMap, BTreeSet};

use crate::config::Config;
use crate::integrity::Resolved;
use crate::normalise::Normaliser;
use fusion::frames::{Geodetic, TangentPlane};
use fusion::integrity::{Concern, State};
use fusion::point::{Basis, Estimate, NowPicture};
use fusion::report::AircraftKind;
use fusion::slots::Slot;
use fusion::time::{SECOND, Time};
use fusion::{Emission, Enu, Identity, Point, SensorIndex, Source};
use serde::{Deserialize, Serialize};

pub use accuracy::{Class, HORIZONTAL, SPEED, VERTICAL, class_names};
pub use class::TrackClass;
pub use integrity_json::{ReasonName, StateName};
pub use kinds::TrackSource;
pub use motion::{Ellipse, Motion};
pub use rfc3339::Rfc3339;
pub use track_json::{TrackJson, TransponderId, serial_text, text};

/// Standard deviation up to which an estimated height is published, metres; a height that was never measured has 60 m at
/// best (`fusion::operational`).
const HEIGHT_KNOWN_M: f64 = 30.0;

/// A transponder that has been silent for longer is no longer heard, seconds.
const HEARD_S: f64 = 5.0;

/// What readers get unless they or the configuration say otherwise, [`PictureTrack::is_within`], metres.
pub const MAX_ACCURACY_M: f64 = 100.0;

/// Everything of one slot.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Picture {
    /// The slot.
    pub slot: Slot,
    /// Its centre: the time of applicability of every track in it.
    pub time: Time,
    /// Fused, then radar, then transponder; each by track number.
    pub tracks: Vec<PictureTrack>,
    /// What is wrong with transponders at this slot.
    pub concerns: Vec<Concern>,
    /// Aircraft that were uncooperative until now.
    pub resolved: Vec<Resolved>,
}

impl Picture {
    /// Its tracks but vehicles on the ground, and those that nobody measured and that are known too poorly,
    /// [`PictureTrack::is_within`].
    pub fn within(&self, max_accuracy_m: f64) -> impl Iterator<Item = &PictureTrack> {
        self.tracks.iter().filter(move |track| track.is_within(max_accuracy_m) && !track.is_vehicle())
    }

    /// Takes over what is known of the same tracks, and of transponders, in the picture that was made with it.
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

    /// Leaves the others out.
    pub fn keep_within(&mut self, max_accuracy_m: f64) {
        self.tracks.retain(|track| track.is_within(max_accuracy_m) && !track.is_vehicle());
    }
}

/// One point of the engine's output with its position on Earth.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PictureTrack {
    /// As the engine emitted it.
    pub point: Point,
    /// Time of applicability.
    pub time: Time,
    /// Latitude, longitude and ellipsoidal height; the height is an assumed one where none was measured.
    pub position: Geodetic,
    /// Height above mean sea level, metres; `None` where none was measured.
    pub altitude_amsl_m: Option<f64>,
    /// Velocity and accuracy; `None` in the `reference` profile.
    pub motion: Option<Motion>,
    /// Ids of the tracks of this picture that claim to be the same aircraft elsewhere.
    pub disputed: Vec<String>,
    /// Its aircraft's id where a region of several cells gave it one.
    pub id: Option<String>,
    /// Whether it flies without a transponder where one is to be heard; [`Lookout`](crate::integrity::Lookout) finds that out.
    pub is_uncooperative: bool,
}

impl PictureTrack {
    /// What tells its aircraft from all others: numbers come again.
    fn key(&self) -> (u32, Time) {
        (self.point.number, self.point.first_seen)
    }

    /// Where it stands in a picture: fused, then radar, then transponder; each by track number.
    #[cfg(any(test, feature = "cluster"))]
    pub(crate) const fn order(&self) -> (u8, u32) {
        let rank = match self.point.source {
            Source::Fused(..) => 0,
            Source::Radar(_) => 1,
            Source::Transponder(_) => 2,
        };
        (rank, self.point.number)
    }

    /// Whether it is a vehicle on the ground of an aerodrome, which is for readers who ask for those.
    pub fn is_vehicle(&self) -> bool {
        let part = self.point.source.transponder();
        part.is_some_and(|part| part.aircraft.kind == AircraftKind::Vehicle)
    }

    /// Whether the position lies between two measurements. In the `reference` profile: whether there is a transponder, whose
    /// part always does.
    pub fn is_interpolated(&self) -> bool {
        match &self.motion {
            Some(motion) => motion.basis == Basis::Interpolated,
            None => self.point.source.transponder().is_some(),
        }
    }

    /// Whether the position lies after the last measurement or before the first: never in the `reference` profile.
    pub fn is_extrapolated(&self) -> bool {
        self.motion.is_some_and(|motion| motion.basis == Basis::Extrapolated)
    }

    /// Whether it lies after the last one.
    pub fn is_coasting(&self) -> bool {
        self.is_extrapolated() && self.motion.is_some_and(|motion| motion.last_measurement.is_some())
    }

    /// Whether a reader wants it that leaves out what is known too poorly: a position that no sensor measured in its slot,
    /// where the radius that holds 95 % of its horizontal errors is above this, metres. What a sensor measured is there,
    /// however poorly it is known.
    pub fn is_within(&self, max_accuracy_m: f64) -> bool {
        self.unmeasured_accuracy_m().is_none_or(|accuracy_m| accuracy_m <= max_accuracy_m)
    }

    /// The radius that holds 95 % of its horizontal errors, metres, where no sensor measured it in its slot: never in the
    /// `reference` profile. Nor of a transponder that is believed no more: that its place is in dispute has to be seen; nor of
    /// one with somebody on board that is heard, however badly it says that it knows its place.
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

    /// Its transponder, as long as nothing speaks against that one.
    pub fn trusted(&self) -> Option<Identity> {
        let identity = self.point.source.transponder()?.identity;
        let is_doubted = self.point.integrity.is_some_and(|known| known.state >= State::Suspect);
        (!is_doubted).then_some(identity)
    }

    /// Motion with a vertical part: `None` where the height is not known.
    pub fn vertical_motion(&self) -> Option<&Motion> {
        self.motion.as_ref().filter(|_| self.altitude_amsl_m.is_some())
    }

    /// Whether a radar took part that did not measure the height.
    pub fn radar_height_missing(&self) -> bool {
        self.point.source.radar().is_some_and(|radar| !radar.height_measured)
    }

    /// `fused`, `radar` or `transponder`.
    pub fn source_name(&self) -> &'static str {
        TrackSource::from(&self.point.source).name()
    }
}

/// Makes pictures: knows the site's frame, its geoid, and the names of its sensors.
#[derive(Clone, Debug)]
pub struct PictureMaker {
    frame: TangentPlane,
    undulation_m: f64,
    sensors: Vec<String>,
    weights: Weights,
    /// Serial numbers of transponders with somebody on board.
    crewed: BTreeSet<String>,
    slots_per_second: i64,
}

/// The weights in a fused position.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Weights {
    radar: f64,
    transponder: f64,
}

impl PictureMaker {
    /// For the site of `config`, in the frame of `normaliser`.
    pub fn new(config: &Config, normaliser: &Normaliser) -> Self {
        Self {
            frame: normaliser.frame().clone(),
            undulation_m: normaliser.undulation_m(),
            sensors: config.sensors.iter().map(|sensor| sensor.id.clone()).collect(),
            weights: Weights {
                radar: config.fusion.weight_radar,
                transponder: config.fusion.weight_transponder,
            },
            crewed: config.conflicts.crewed.iter().cloned().collect(),
            slots_per_second: (SECOND / config.fusion.slot.as_nanos() as i64).max(1),
        }
    }

    /// The picture of an emission's slot.
    pub fn picture(&self, emission: Emission) -> Picture {
        self.of(emission.slot, emission.time, emission.points, emission.concerns)
    }

    /// The picture of its deadline.
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
        // Before the points are taken apart: a link is by number, and readers know ids.
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
                motion: estimate.map(|estimate| Motion::new(estimate, point.position, position, &self.frame)),
                disputed,
                id: None,
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

    /// The ids of those of `points` that claim to be the same aircraft as `point`.
    fn disputed(&self, point: &Point, points: &[Point]) -> Vec<String> {
        let others =
            point.disputed.iter().filter_map(|&number| points.iter().find(|other| other.number == number));
        others.map(|other| self.id(other)).collect()
    }

    /// The geoid above the ellipsoid at the site, metres.
    pub fn geoid_undulation_m(&self) -> f64 {
        self.undulation_m
    }

    /// Where a place in the site's frame is on Earth.
    pub fn place(&self, position: Enu) -> Geodetic {
        self.frame.to_geodetic(position)
    }

    /// Whether it is one of the slots in which is looked for what is looked for once a second; in all of them where a slot is
    /// longer.
    pub fn begins_second(&self, slot: Slot) -> bool {
        slot.0.rem_euclid(self.slots_per_second) == 0
    }

    /// How many seconds so many slots are, rounded up.
    pub fn seconds(&self, slots: u64) -> u64 {
        slots.div_ceil(self.slots_per_second.unsigned_abs())
    }

    /// What a track is taken for.
    pub fn class(&self, track: &PictureTrack) -> TrackClass {
        TrackClass::of(&track.point.source, &self.crewed)
    }

    /// A sensor's configured name.
    pub fn sensor(&self, index: SensorIndex) -> &str {
        &self.sensors[usize::from(index.0)]
    }

    /// The track's id, of letters, digits, `-`, `.`, `_`. Of a region of several cells `U-<cell>-<count>`; of one site in the `operational` profile one per aircraft for its life:
    /// `U-<number>`, with `-<first seen>` where the number is one that comes again. In the `reference` profile
    /// `F-<number>`, `T-<number>`, or `R-<sensor>-<number>-<first seen>`, because a radar gives its numbers again.
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
        }
    }
}

#[cfg(test)]
mod tests;
