//! Cameras: their orientation, the assignment of their tracks to targets, and the measurements that follow.
//!
//! A bearing gives a direction without a distance, so a camera's track never begins a target. It is assigned to the
//! target whose expected direction it follows: the log-likelihood ratios of "this target" to "anything in the field of
//! view" are summed over the looks. Each look at an assigned target is a line on which the target lies. Across the line
//! the position is known by the angle times the expected distance; along it nothing is measured.
//!
//! A camera is turned and tilted by some degrees from what is configured. Until its orientation is known, each pair of a
//! track and a target is judged with an orientation of its own, learnt from the pair's looks: the right target explains all
//! looks by one rotation. The camera takes an orientation on which two tracks agree, or one alone after many looks, and then
//! learns from all further looks at aircraft with a transponder. Until then its looks measure nothing.

mod following;

use std::collections::{BTreeMap, VecDeque};

use nalgebra::Vector2;
use serde::{Deserialize, Serialize};

use super::ids::TargetId;
use super::settings::{Camera, OperationalSettings};
use super::tuning::{CAMERA_LOOK_S, CAMERA_NEAR_M, CAMERA_RANGE_STEP};
use crate::filter::{By, Measurement, StateEstimate};
use crate::frames::Enu;
use crate::registration::{CameraLook, CameraOrientation};
use crate::report::{Bearing, CameraTrackKey, SensorIndex};
use crate::time::Time;

/// All cameras and their tracks.
#[derive(Debug, Default, Serialize, Deserialize)]
pub(super) struct Cameras {
    tracks: BTreeMap<CameraTrackKey, CameraTrack>,
    /// Orientation of each camera, as learnt.
    oriented: BTreeMap<SensorIndex, OrientedCamera>,
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
        let track = self.tracks.entry(bearing.track).or_default();
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
        let its = self.tracks.iter().filter(move |(_, track)| track.target == Some(target));
        let with_camera = move |(key, track): (&CameraTrackKey, &'a CameraTrack)| {
            Some((*key, track, settings.camera(key.sensor)?, &self.oriented.get(&key.sensor)?.orientation))
        };
        its.filter_map(with_camera).flat_map(move |(key, track, camera, orientation)| {
            let after = track.looks.iter().filter(move |look| look.time > since.max(track.from));
            let measured = move |look| measured(look, camera, orientation, &place_at(look.time)?);
            after.filter_map(move |look| Some((key, measured(look)?)))
        })
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
) -> Option<Measurement> {
    let expected = ExpectedView::of(camera, place)?;
    let corrected = orientation.correct(look.azimuth, look.elevation.unwrap_or(expected.elevation));
    if !orientation.is_known(corrected, look.elevation.is_some()) {
        return None;
    }
    let [azimuth, elevation] = corrected;
    let elevation = look.elevation.is_some().then_some(elevation);
    let [azimuth2, elevation2] = orientation.variances(corrected);
    // The distance is quantised, so that measurements with nearly the same distance are not filtered again.
    let ground_m = CAMERA_RANGE_STEP.powf((expected.ground_m.ln() / CAMERA_RANGE_STEP.ln()).round());
    let (sin, cos) = azimuth.sin_cos();
    let outward = Vector2::new(sin, cos);
    let slant_m = ground_m / expected.elevation.cos();
    let up_m = elevation.map(|elevation| elevation.tan() * ground_m);
    let along_m = (outward.transpose() * place.horizontal * outward).x.max(0.0).sqrt();
    let position = camera.position.0 + (outward * ground_m).push(up_m.unwrap_or(0.0));
    let slope = elevation.map_or(0.0, f64::tan);
    // At least half a step, the rounding error of the distance.
    let rounded_m = ground_m * (CAMERA_RANGE_STEP - 1.0) / 2.0;
    Some(Measurement {
        time: look.time,
        position: Enu::from(position),
        height_measured: elevation.is_some(),
        velocity: None,
        climb: None,
        by: By::Camera {
            sensor: look.track.sensor,
            clockwise: Vector2::new(cos, -sin),
            across_m: ground_m * camera.azimuth.hypot(azimuth2.sqrt()),
            height_m: (slant_m * camera.elevation.hypot(elevation2.sqrt()) / expected.elevation.cos())
                .hypot(slope * along_m.max(rounded_m)),
        },
    })
}
