//! EO/IR cameras: bearings of visible targets, each with a track number. CAT015, edition 1.2.

use asterix::cat015::{
    self, Angle, AngleDeviation, AzimuthInformation, ElevationInformation, MessageKind, MessageType,
    ReportNumber, ReportStatus, ScanDirection, SignedAngle, TargetReport,
};
use asterix::{DataSource, TimeOfDay, encode_block};
use nalgebra::Vector3;

use super::{CREWED, FurtherSensor, FurtherSensors, SensorScene};
use crate::evaluate::Label;
use crate::simulate::drone_id;
use crate::simulate::wire::{SentDatagram, after, stamped};
use input::normalise::time_of_day_count;
use site::config::{self, CameraAccuracy, SensorKind};
use world::ground::Antenna;
use world::radar::RadarTarget;
use world::scenario::Camera;
use world::streams::{Entity, RandomStream, radar_target};

/// Minimum deviation in the site's configuration, degrees.
const LEAST_DEG: f64 = 0.001;

/// State of one camera for one target.
struct CameraTargetState {
    stream: RandomStream,
    is_seen: bool,
    track: Option<CameraTargetTrack>,
}

struct CameraTargetTrack {
    number: u16,
    detected_s: f64,
    detections: u32,
}

/// A bearing with errors, degrees.
struct CameraBearing {
    number: u16,
    azimuth_deg: f64,
    elevation_deg: f64,
}

/// Adds everything that camera number `index` sends.
pub fn add_bearings(scene: &SensorScene<'_>, index: usize, model: &Camera, further: &mut FurtherSensors) {
    let stand = scene.ground.stand(Vector3::new(model.east_m, model.north_m, model.lens_agl_m));
    let sensor = further.receivers.len();
    further.receivers.push(receiver(scene, index, model, &stand));
    let mut states: Vec<CameraTargetState> = scene
        .targets
        .iter()
        .map(|target| {
            let mut stream = scene.streams.of(Entity::View, radar_target(index, target.number));
            let is_seen = stream.chance(model.seen_s / (model.seen_s + model.unseen_s));
            CameraTargetState { stream, is_seen, track: None }
        })
        .collect();
    // Delay of each picture.
    let mut line = scene.streams.of(Entity::View, radar_target(index, usize::MAX >> 33));
    let mut number = 0;
    for picture in 1..=(scene.scenario.duration_s / model.period_s) as usize {
        let time_s = picture as f64 * model.period_s;
        let (mut bearings, mut ended) = (Vec::new(), Vec::new());
        for (target, view) in scene.targets.iter().zip(&mut states) {
            let direction = direction(scene, model, &stand, target, time_s);
            let bearing = view.look(model, direction, time_s, || {
                number = if number == u16::MAX { 1 } else { number + 1 };
                number
            });
            if let Some(bearing) = bearing {
                further.labels.push(Label {
                    time: stamped(after(scene.start, time_s)),
                    sensor: model.id.clone(),
                    number: bearing.number.into(),
                    id: id(scene, target),
                    seduced: false,
                    identity: None,
                });
                bearings.push(bearing);
            }
            ended.extend(view.take_ended(model, time_s));
        }
        let latency_s = line.within(model.latency_s);
        let Some(payload) = block(scene, model, time_s, &bearings, &ended) else { continue };
        further.sent.push(SentDatagram { arrives: after(scene.start, time_s + latency_s), sensor, payload });
    }
}

/// The camera in the site's configuration: its position and data sheet.
fn receiver(scene: &SensorScene<'_>, index: usize, model: &Camera, stand: &Antenna) -> FurtherSensor {
    let rounded = |value: f64| (value * 1e9).round() / 1e9;
    let kind = config::Camera {
        latitude_deg: rounded(stand.position.latitude_deg()),
        longitude_deg: rounded(stand.position.longitude_deg()),
        height_amsl_m: stand.altitude_amsl_m,
        accuracy: Some(CameraAccuracy {
            azimuth_deg: model.noise_azimuth_deg.max(LEAST_DEG),
            elevation_deg: model.noise_elevation_deg.max(LEAST_DEG),
        }),
        ..config::Camera::default()
    };
    let code = (model.id.as_str(), model.sac, model.sic);
    let line = ([239, 192, 15, 1 + index as u8], 8015);
    let sensor = super::sensor(scene.scenario, code, model.period_s, line, SensorKind::Camera(kind));
    FurtherSensor { sensor, file: "camera.ast" }
}

/// Id of a target in the truth; `None`: not an aircraft.
fn id(scene: &SensorScene<'_>, target: &RadarTarget) -> Option<String> {
    let aircraft = || scene.aircraft.iter().find(|aircraft| CREWED + aircraft.number == target.number);
    target.drone.map(drone_id).or_else(|| aircraft().map(super::CrewedAircraft::id))
}

/// Azimuth and elevation, degrees, of a target within range and field of regard.
fn direction(
    scene: &SensorScene<'_>,
    model: &Camera,
    stand: &Antenna,
    target: &RadarTarget,
    time_s: f64,
) -> Option<[f64; 2]> {
    let place = scene.ground.geodetic(&target.path.at(time_s).position);
    let (range_m, azimuth, elevation) = stand.spherical(place);
    let farthest_m = match target.drone {
        Some(_) => model.range_m,
        None if target.number >= CREWED => model.crewed_range_m,
        None => model.bird_range_m,
    };
    let (azimuth_deg, elevation_deg) = (azimuth.to_degrees(), elevation.to_degrees());
    let off_deg = (azimuth_deg - model.looks_deg + 180.0).rem_euclid(360.0) - 180.0;
    let is_in_field = off_deg.abs() <= model.field_deg / 2.0
        && (model.elevation_deg.low..=model.elevation_deg.high).contains(&elevation_deg);
    (range_m <= farthest_m && is_in_field).then_some([azimuth_deg, elevation_deg])
}

impl CameraTargetState {
    fn look(
        &mut self,
        model: &Camera,
        direction: Option<[f64; 2]>,
        time_s: f64,
        new_number: impl FnOnce() -> u16,
    ) -> Option<CameraBearing> {
        let stream = &mut self.stream;
        let mean_s = if self.is_seen { model.seen_s } else { model.unseen_s };
        if stream.chance(1.0 - (-model.period_s / mean_s).exp()) {
            self.is_seen = !self.is_seen;
        }
        let is_detected = stream.chance(model.detection) && self.is_seen;
        let errors = [stream.normal(model.noise_azimuth_deg), stream.normal(model.noise_elevation_deg)];
        let [azimuth_deg, elevation_deg] = direction.filter(|_| is_detected)?;
        let begun = || CameraTargetTrack { number: new_number(), detected_s: time_s, detections: 0 };
        let track = self.track.get_or_insert_with(begun);
        (track.detected_s, track.detections) = (time_s, track.detections + 1);
        (track.detections >= model.confirmed_by).then(|| CameraBearing {
            number: track.number,
            azimuth_deg: azimuth_deg + model.bias_azimuth_deg + errors[0],
            elevation_deg: elevation_deg + model.bias_elevation_deg + errors[1],
        })
    }

    /// Removes a track that has not been detected for too long and returns its number, if the track was reported.
    fn take_ended(&mut self, model: &Camera, time_s: f64) -> Option<u16> {
        let lost = |track: &mut CameraTargetTrack| time_s - track.detected_s > model.drop_after_s;
        let track = self.track.take_if(lost)?;
        (track.detections >= model.confirmed_by).then_some(track.number)
    }
}

/// Block of one picture; `None` if it has no record.
fn block(
    scene: &SensorScene<'_>,
    model: &Camera,
    time_s: f64,
    bearings: &[CameraBearing],
    ended: &[u16],
) -> Option<Vec<u8>> {
    let source = DataSource { sac: model.sac as u8, sic: model.sic as u8 };
    let time = TimeOfDay::from_count(time_of_day_count(after(scene.start, time_s)));
    let begin = |kind, number| {
        cat015::Record::builder(source, MessageType::default().with_kind(kind), time)
            .number(ReportNumber::default().with_number(number))
    };
    let deviation = |degrees: f64| AngleDeviation::default().with_degrees(degrees);
    let of_bearing = |bearing: &CameraBearing| {
        begin(MessageKind::MeasurementTrack, bearing.number)
            .target_report(TargetReport::default().with_scan_direction(ScanDirection::Static))
            .status(ReportStatus::default())
            .azimuth(AzimuthInformation {
                azimuth: Angle::default().with_degrees(bearing.azimuth_deg),
                deviation: deviation(model.noise_azimuth_deg),
                ..AzimuthInformation::default()
            })
            .elevation(ElevationInformation {
                elevation: SignedAngle::default().with_degrees(bearing.elevation_deg),
                deviation: deviation(model.noise_elevation_deg),
                ..ElevationInformation::default()
            })
            .build()
            .ok()
    };
    let ends = ended.iter().filter_map(|&number| begin(MessageKind::TrackEnd, number).build().ok());
    let records: Vec<_> = bearings.iter().filter_map(of_bearing).chain(ends).collect();
    let mut payload = Vec::new();
    if !records.is_empty() {
        encode_block(&records, &mut payload).ok()?;
    }
    (!payload.is_empty()).then_some(payload)
}
