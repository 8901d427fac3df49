//! Cameras: assignment of their tracks to targets, and the measurements that follow.
//!
//! A bearing gives a direction without a distance, so a camera's track never begins a target. It is assigned to the
//! target whose expected direction it follows: the log-likelihood ratios of "this target" to "anything in the field of
//! view" are summed over the looks. Each look at an assigned target is a line on which the target lies. Across the line
//! the position is known by the angle times the expected distance; along it nothing is measured.

mod following;

use std::collections::{BTreeMap, VecDeque};
use std::f64::consts::TAU;

use nalgebra::Vector2;
use serde::{Deserialize, Serialize};

use super::ids::TargetId;
use super::settings::{Camera, OperationalSettings};
use super::tuning::{CAMERA_FIELD, CAMERA_LOOK_LLR_MAX, CAMERA_LOOK_S, CAMERA_NEAR_M, CAMERA_RANGE_STEP};
use crate::filter::{By, Measurement, StateEstimate};
use crate::frames::Enu;
use crate::report::{Bearing, CameraTrackKey};
use crate::time::Time;

/// The tracks of all cameras.
#[derive(Debug, Default, Serialize, Deserialize)]
pub(super) struct Cameras(BTreeMap<CameraTrackKey, CameraTrack>);

/// The bearings of one track, and its target.
#[derive(Debug, Default, Serialize, Deserialize)]
struct CameraTrack {
    /// Bearings by time, at least [`CAMERA_LOOK_S`] apart, because a camera's errors persist for a while.
    looks: VecDeque<Bearing>,
    /// Sums of log-likelihood ratios, by target.
    scores: BTreeMap<TargetId, f64>,
    target: Option<TargetId>,
    /// Time after which looks are used for the present target.
    from: Time,
    /// Time up to which looks are included in the scores.
    until: Time,
}

impl Cameras {
    /// Adds a bearing.
    pub(super) fn insert(&mut self, bearing: Bearing) {
        let track = self.0.entry(bearing.track).or_default();
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
        let its = self.0.iter().filter(move |(_, track)| track.target == Some(target));
        its.filter_map(move |(key, track)| Some((*key, track, settings.camera(key.sensor)?))).flat_map(
            move |(key, track, camera)| {
                let after = track.looks.iter().filter(move |look| look.time > since.max(track.from));
                let measured = move |look| measured(look, camera, &place_at(look.time)?);
                after.filter_map(move |look| Some((key, measured(look)?)))
            },
        )
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

/// LLR that a look is at that position; `None` if the target is too near.
fn llr(look: &Bearing, camera: &Camera, place: &StateEstimate) -> Option<f64> {
    let expected = ExpectedView::of(camera, place)?;
    let normal = |off: f64, variance: f64| -0.5 * off * off / variance - 0.5 * (TAU * variance).ln();
    let azimuth_off = wrapped(look.azimuth - expected.azimuth);
    let mut llr = normal(azimuth_off, expected.azimuth2 + camera.azimuth.powi(2)) + CAMERA_FIELD.ln();
    if let Some(elevation) = look.elevation {
        let off = elevation - expected.elevation;
        llr += normal(off, expected.elevation2 + camera.elevation.powi(2)) + CAMERA_FIELD.ln();
    }
    Some(llr.clamp(-CAMERA_LOOK_LLR_MAX, CAMERA_LOOK_LLR_MAX))
}

/// The line of a look, at the expected distance of the target.
fn measured(look: &Bearing, camera: &Camera, place: &StateEstimate) -> Option<Measurement> {
    let expected = ExpectedView::of(camera, place)?;
    // The distance is quantised, so that measurements with nearly the same distance are not filtered again.
    let ground_m = CAMERA_RANGE_STEP.powf((expected.ground_m.ln() / CAMERA_RANGE_STEP.ln()).round());
    let (sin, cos) = look.azimuth.sin_cos();
    let outward = Vector2::new(sin, cos);
    let slant_m = ground_m / expected.elevation.cos();
    let up_m = look.elevation.map(|elevation| elevation.tan() * ground_m);
    let along_m = (outward.transpose() * place.horizontal * outward).x.max(0.0).sqrt();
    let position = camera.position.0 + (outward * ground_m).push(up_m.unwrap_or(0.0));
    let slope = look.elevation.map_or(0.0, f64::tan);
    // At least half a step, the rounding error of the distance.
    let rounded_m = ground_m * (CAMERA_RANGE_STEP - 1.0) / 2.0;
    Some(Measurement {
        time: look.time,
        position: Enu::from(position),
        height_measured: look.elevation.is_some(),
        velocity: None,
        climb: None,
        by: By::Camera {
            sensor: look.track.sensor,
            clockwise: Vector2::new(cos, -sin),
            across_m: ground_m * camera.azimuth,
            height_m: (slant_m * camera.elevation / expected.elevation.cos())
                .hypot(slope * along_m.max(rounded_m)),
        },
    })
}

/// The equivalent angle between -π and π.
fn wrapped(angle: f64) -> f64 {
    (angle + TAU / 2.0).rem_euclid(TAU) - TAU / 2.0
}
