//! Cameras: their orientation, the assignment of their tracks to targets, and the measurements that follow.
//!
//! A bearing gives a direction without a distance, so one camera's track never begins a target; two cameras do, where their lines
//! cross ([`starting`]). A track is assigned to the
//! target whose expected direction it follows: the log-likelihood ratios of "this target" to "anything in the field of
//! view" are summed over the looks. Each look at an assigned target is a line on which the target lies. Across the line
//! the position is known by the angle times the expected distance; along it nothing is measured.
//!
//! A camera is turned and tilted by some degrees from what is configured. Until its orientation is known, each pair of a
//! track and a target is judged with an orientation of its own, learnt from the pair's looks: the right target explains all
//! looks by one rotation. The camera takes an orientation on which two tracks agree, or one alone after many looks, and then
//! learns from all further looks at aircraft with a transponder. Until then its looks measure nothing.

mod crossing;
mod evidence;
mod following;
mod starting;

use std::collections::{BTreeMap, VecDeque};

use nalgebra::{Matrix2, Vector2};
use serde::{Deserialize, Serialize};

use super::ids::TargetId;
use super::settings::{Camera, OperationalSettings};
use super::tuning::{
    CAMERA_CROSSED_STEP, CAMERA_CROSSING_SINE, CAMERA_ENDS_S, CAMERA_LOOK_S, CAMERA_NEAR_M,
    CAMERA_RANGE_STEP, CAMERA_TOGETHER_S,
};
use crate::filter::{By, Measurement, StateEstimate};
use crate::frames::Enu;
use crate::registration::{CameraLook, CameraOrientation};
use crate::report::{Bearing, CameraTrackKey, SensorIndex};
use crate::time::Time;
use crossing::LastingErrors;
pub use evidence::CameraStarts;
use evidence::{PairEvidence, TrackPair};

/// All cameras and their tracks.
#[derive(Debug, Default, Serialize, Deserialize)]
pub(super) struct Cameras {
    tracks: BTreeMap<CameraTrackKey, CameraTrack>,
    /// Orientation of each camera, as learnt.
    oriented: BTreeMap<SensorIndex, OrientedCamera>,
    /// Evidence on pairs of tracks that may begin a target, or have.
    pairs: BTreeMap<TrackPair, PairEvidence>,
    starts: CameraStarts,
}

/// Orientation of a camera, as learnt.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct OrientedCamera {
    /// The orientation.
    pub orientation: CameraOrientation,
    /// Latest time at which looks contradicted the orientation, and another one replaced it.
    pub turned: Option<Time>,
    /// Time up to which the orientation was predicted.
    until: Time,
    /// Time of the latest look learnt from.
    learnt: Time,
}

/// The bearings of one track, and its target.
#[derive(Debug, Default, Serialize, Deserialize)]
struct CameraTrack {
    /// Time of its first bearing.
    begun: Time,
    /// Bearings by time, at least [`CAMERA_LOOK_S`] apart, because a camera's errors persist for a while.
    looks: VecDeque<Bearing>,
    /// Likelihood of each target.
    scores: BTreeMap<TargetId, PairScore>,
    target: Option<TargetId>,
    /// Time after which looks are used for the present target.
    from: Time,
    /// Time up to which looks are included in the scores.
    until: Time,
}

/// Likelihood that a track shows a target.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct PairScore {
    /// Sum of log-likelihood ratios with the camera's orientation, or with the pair's own until that is known.
    llr: f64,
    /// Sum of log-likelihood ratios with the pair's own orientation.
    own_llr: f64,
    /// Orientation that explains the pair's looks best.
    own: CameraOrientation,
    /// Expected direction at the first look, radians.
    first: [f64; 2],
    /// Largest change of the expected direction since, radians.
    span: f64,
}

impl Cameras {
    /// The orientation of each camera.
    pub(super) fn oriented(&self) -> impl Iterator<Item = (SensorIndex, &OrientedCamera)> {
        self.oriented.iter().map(|(&sensor, oriented)| (sensor, oriented))
    }

    /// The orientations without the tracks.
    pub(super) fn without_tracks(self) -> Self {
        Self { oriented: self.oriented, ..Self::default() }
    }

    /// Adds a bearing.
    pub(super) fn insert(&mut self, bearing: Bearing) {
        let begun = || CameraTrack { begun: bearing.time, ..CameraTrack::default() };
        let track = self.tracks.entry(bearing.track).or_insert_with(begun);
        let index = track.looks.partition_point(|look| look.time < bearing.time);
        let is_apart = |look: Option<&Bearing>| {
            look.is_none_or(|look| look.time.seconds_since(bearing.time).abs() >= CAMERA_LOOK_S)
        };
        if is_apart(track.looks.get(index))
            && is_apart(index.checked_sub(1).and_then(|at| track.looks.get(at)))
        {
            track.looks.insert(index, bearing);
        }
    }

    /// Measurements of a target by cameras after `since`, each look with the expected distance of the target at its
    /// time; by track, and by time.
    pub(super) fn of<'a>(
        &'a self,
        target: TargetId,
        since: Time,
        place_at: impl Fn(Time) -> Option<StateEstimate> + Copy + 'a,
        settings: &'a OperationalSettings,
    ) -> impl Iterator<Item = (CameraTrackKey, Measurement)> + 'a {
        let its: Vec<(CameraTrackKey, &CameraTrack)> = self
            .tracks
            .iter()
            .filter(|(_, track)| track.target == Some(target))
            .map(|(&key, track)| (key, track))
            .collect();
        let mut all = Vec::new();
        for &(key, track) in &its {
            let Some((camera, oriented)) = settings.camera(key.sensor).zip(self.oriented.get(&key.sensor))
            else {
                continue;
            };
            for look in track.looks.iter().filter(|look| look.time > since.max(track.from)) {
                let Some(place) = place_at(look.time) else { continue };
                let is_crossed = its.iter().any(|(other, track)| {
                    let there = settings.camera(other.sensor).filter(|_| other.sensor != key.sensor);
                    there.is_some_and(|own| track.crosses(look.time, own, camera, &place))
                });
                let measured = measured(look, camera, &oriented.orientation, &place, is_crossed);
                all.extend(measured.map(|measured| (key, measured)));
            }
        }
        all.into_iter()
    }

    /// Covariance of the position of a target by the errors of its cameras that last, over ground and in height, m²; `None`: fewer
    /// than two cameras see it now.
    pub(super) fn lasting_m2(
        &self,
        target: TargetId,
        time: Time,
        place: &StateEstimate,
        settings: &OperationalSettings,
    ) -> Option<(Matrix2<f64>, f64)> {
        let its = self
            .tracks
            .iter()
            .filter(|(_, track)| track.target == Some(target) && track.is_near(time, CAMERA_ENDS_S));
        let errors = its.filter_map(|(key, _)| {
            let (camera, oriented) = settings.camera(key.sensor).zip(self.oriented.get(&key.sensor))?;
            LastingErrors::of(camera, &oriented.orientation, place)
        });
        crossing::lasting_m2(&errors.collect::<Vec<LastingErrors>>())
    }
}

impl CameraTrack {
    /// Whether it has a bearing within some seconds of a time.
    fn is_near(&self, time: Time, seconds: f64) -> bool {
        let after = self.looks.partition_point(|look| look.time < time);
        let beside = [after.checked_sub(1), Some(after)].into_iter().flatten();
        let mut beside = beside.filter_map(|index| self.looks.get(index));
        beside.any(|look| look.time.seconds_since(time).abs() <= seconds)
    }

    /// Whether it looks at `place` around a time, from another side than `camera`.
    fn crosses(&self, time: Time, own: &Camera, camera: &Camera, place: &StateEstimate) -> bool {
        let [one, other] = [own, camera].map(|camera| place.position.0 - camera.position.0);
        crossing::sine_over_ground(&one, &other) >= CAMERA_CROSSING_SINE
            && self.is_near(time, CAMERA_TOGETHER_S)
    }
}

/// Expected position of a target as seen from a camera: distance over ground, direction, and the variances of its
/// angles.
struct ExpectedView {
    ground_m: f64,
    azimuth: f64,
    elevation: f64,
    azimuth2: f64,
    elevation2: f64,
}

impl ExpectedView {
    /// `None` if the target is too near to the camera for useful angles.
    fn of(camera: &Camera, place: &StateEstimate) -> Option<Self> {
        let away = place.position.0 - camera.position.0;
        let ground_m = away.xy().norm();
        if ground_m < CAMERA_NEAR_M {
            return None;
        }
        let clockwise = Vector2::new(away.y, -away.x) / ground_m;
        let slant_m2 = away.norm_squared();
        let across_m2 = (clockwise.transpose() * place.horizontal * clockwise).x;
        Some(Self {
            ground_m,
            azimuth: away.x.atan2(away.y),
            elevation: away.z.atan2(ground_m),
            azimuth2: across_m2 / (ground_m * ground_m),
            elevation2: place.vertical / slant_m2,
        })
    }
}

/// A look at an aircraft at that position; `None` if it is too near.
fn look_at(look: &Bearing, camera: &Camera, place: &StateEstimate) -> Option<CameraLook> {
    let expected = ExpectedView::of(camera, place)?;
    Some(CameraLook {
        azimuth: look.azimuth,
        elevation: look.elevation,
        expected: [expected.azimuth, expected.elevation],
        measured2: [camera.azimuth.powi(2), camera.elevation.powi(2)],
        expected2: [expected.azimuth2, expected.elevation2],
    })
}

/// The line of a look, at the expected distance of the target; `None` if the camera's orientation is not known well enough.
fn measured(
    look: &Bearing,
    camera: &Camera,
    orientation: &CameraOrientation,
    place: &StateEstimate,
    is_crossed: bool,
) -> Option<Measurement> {
    let expected = ExpectedView::of(camera, place)?;
    let corrected = orientation.correct(look.azimuth, look.elevation.unwrap_or(expected.elevation));
    if !orientation.is_known(corrected, look.elevation.is_some()) {
        return None;
    }
    let [azimuth, elevation] = corrected;
    let elevation = look.elevation.is_some().then_some(elevation);
    let [azimuth2, elevation2] = orientation.variances(corrected);
    let (sin, cos) = azimuth.sin_cos();
    let outward = Vector2::new(sin, cos);
    let along_m = (outward.transpose() * place.horizontal * outward).x.max(0.0).sqrt();
    // The distance is quantised, so that measurements with nearly the same distance are not filtered again.
    let step = if is_crossed { CAMERA_CROSSED_STEP } else { CAMERA_RANGE_STEP };
    let ground_m = step.powf((expected.ground_m.ln() / step.ln()).round());
    let slant_m = ground_m / expected.elevation.cos();
    let up_m = elevation.map(|elevation| elevation.tan() * ground_m);
    let position = camera.position.0 + (outward * ground_m).push(up_m.unwrap_or(0.0));
    let slope = elevation.map_or(0.0, f64::tan);
    // At least half a step, the rounding error of the distance.
    let rounded_m = ground_m * (step - 1.0) / 2.0;
    Some(Measurement {
        time: look.time,
        position: Enu::from(position),
        height_measured: elevation.is_some(),
        velocity: None,
        climb: None,
        by: By::Camera {
            sensor: look.track.sensor,
            is_crossed,
            clockwise: Vector2::new(cos, -sin),
            across_m: ground_m * camera.azimuth.hypot(azimuth2.sqrt()),
            height_m: (slant_m * camera.elevation.hypot(elevation2.sqrt()) / expected.elevation.cos())
                .hypot(slope * along_m.max(rounded_m)),
        },
    })
}
