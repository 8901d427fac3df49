//! Encoding of tracks as SAPIENT messages, BSI Flex 335 v2.0 (`docs/SAPIENT.md`).

pub mod frames;
pub mod messages;
mod registration;
mod ulid;

use crate::{PictureMaker, PictureTrack, PublishedMotion, TrackClass, serial_text};
use fusion::time::{SECOND, Time};
use messages::{
    Classification, CoordinateSystem, Datum, DetectionReport, EnuVelocity, Location, ObjectInfo,
    ProtobufTimestamp, ReportInfo, SapientContent, SapientMessage, SapientRegistration, SapientSystemState,
    StatusReport, TaskAck, TaskStatus,
};
use registration::registration;
use ulid::ulid;

/// Name of the single mode of this node.
const MODE: &str = "Default";
/// Length of a degree of latitude, and of longitude at the equator, in metres. Within 0.6 % of the ellipsoid; used for deviations
/// only.
const DEGREE_M: f64 = 111_195.0;

/// Writer of the messages of one node.
#[derive(Clone, Debug)]
pub struct SapientWriter {
    /// UUID of this node, in every message.
    pub node_id: String,
    /// Name of the site.
    pub site: String,
    /// Time between two status reports, in seconds.
    pub status_interval_s: f32,
    /// Time from the start of a slot to its publication, in seconds.
    pub latency_s: f32,
}

impl SapientWriter {
    /// A message from this node.
    pub fn message(&self, at: Time, content: SapientContent) -> SapientMessage {
        let nanos = at.nanos();
        SapientMessage {
            timestamp: Some(ProtobufTimestamp {
                seconds: nanos.div_euclid(SECOND),
                nanos: nanos.rem_euclid(SECOND) as i32,
            }),
            node_id: Some(self.node_id.clone()),
            destination_id: None,
            content: Some(content),
        }
    }

    /// First message of a connection.
    pub fn registration(&self) -> SapientRegistration {
        registration(self)
    }

    /// Status of the service.
    pub fn status(&self, at: Time, system: SapientSystemState, info: ReportInfo) -> StatusReport {
        StatusReport {
            report_id: Some(ulid(at, &[self.node_id.as_bytes(), b"status"])),
            system: Some(system.into()),
            info: Some(info.into()),
            mode: Some(MODE.to_owned()),
        }
    }

    /// Refusal of a task, because this node takes none.
    pub fn refusal(&self, task_id: Option<String>) -> TaskAck {
        TaskAck {
            task_id,
            task_status: Some(TaskStatus::Rejected.into()),
            reason: vec!["this node takes no tasks".to_owned()],
        }
    }

    /// Detection report of a track; `None` for a position that is not on Earth.
    pub fn detection(&self, track: &PictureTrack, maker: &PictureMaker) -> Option<DetectionReport> {
        let id = maker.track_id(track);
        let info = |kind: &str, value: &str| ObjectInfo {
            kind: Some(kind.to_owned()),
            value: Some(value.to_owned()),
        };
        let point = &track.point;
        let class = maker.class(track);
        let mut track_info = vec![info("id", &id), info("source", track.source_name())];
        if let Some(integrity) = point.integrity {
            track_info.push(info("integrity", integrity.state.name()));
        }
        if track.is_extrapolated() {
            track_info.push(info("extrapolated", "true"));
        }
        let transponder = point.source.transponder();
        let serial = transponder.map(|transponder| serial_text(transponder.identity));
        let mut object_info: Vec<_> = serial.iter().map(|serial| info("serial_number", serial)).collect();
        match class {
            TrackClass::Drone => object_info.push(info("crew", "unmanned")),
            TrackClass::Crewed => object_info.push(info("crew", "crewed")),
            _ => {}
        }
        Some(DetectionReport {
            report_id: Some(self.report_id(track.time, &id)),
            object_id: Some(ulid(point.first_seen, &[self.node_id.as_bytes(), id.as_bytes()])),
            state: None,
            location: Some(location(track)?),
            track_info,
            object_info,
            classification: classification(track, class).into_iter().collect(),
            enu_velocity: velocity(track),
            id: serial,
        })
    }

    /// Last report of a track that is no longer in the picture.
    pub fn lost(&self, at: Time, last: DetectionReport) -> DetectionReport {
        let object = last.object_id.clone().unwrap_or_default();
        DetectionReport {
            report_id: Some(self.report_id(at, &object)),
            state: Some("lost".to_owned()),
            enu_velocity: None,
            ..last
        }
    }

    fn report_id(&self, at: Time, what: &str) -> String {
        ulid(at, &[self.node_id.as_bytes(), b"report", what.as_bytes()])
    }
}

/// Longitude, latitude and ellipsoidal height, each with its standard deviation in the unit of the coordinate.
fn location(track: &PictureTrack) -> Option<Location> {
    let (latitude, longitude) = (track.position.latitude_deg(), track.position.longitude_deg());
    if !((-90.0..=90.0).contains(&latitude) && (-180.0..=180.0).contains(&longitude)) {
        return None;
    }
    let deviation_m = |variance: f64| variance.max(0.0).sqrt();
    let estimate = track.point.estimate.as_ref();
    // All longitudes are one place at a pole.
    let parallel_m = (DEGREE_M * latitude.to_radians().cos()).max(1.0);
    Some(Location {
        x: Some(longitude),
        y: Some(latitude),
        z: track.altitude_amsl_m.map(|_| track.position.height_m),
        x_error: estimate.map(|known| deviation_m(known.horizontal.m11) / parallel_m),
        y_error: estimate.map(|known| deviation_m(known.horizontal.m22) / DEGREE_M),
        z_error: track.vertical_motion().map(|motion| motion.deviation_v_m),
        coordinate_system: Some(CoordinateSystem::LatLngDegM.into()),
        datum: Some(Datum::Wgs84Ellipsoid.into()),
    })
}

/// Class of a track. The confidence comes from the radar's classifier; a transponder states none.
fn classification(track: &PictureTrack, class: TrackClass) -> Option<Classification> {
    let source = &track.point.source;
    let probability = source.radar().filter(|_| source.transponder().is_none());
    let probability = probability.and_then(|radar| radar.uav_probability);
    let (kind, confidence) = match class {
        TrackClass::Drone | TrackClass::Crewed => ("Air Vehicle", probability),
        TrackClass::Vehicle => ("Land Vehicle", None),
        TrackClass::Other => ("Other", probability.map(|drone| 1.0 - drone)),
        TrackClass::Unknown => return None,
    };
    Some(Classification { kind: Some(kind.to_owned()), confidence: confidence.map(|sure| sure as f32) })
}

fn velocity(track: &PictureTrack) -> Option<EnuVelocity> {
    let (motion, known) = track.motion.as_ref().zip(track.point.estimate.as_ref())?;
    let deviation = |variance: f64| Some(variance.max(0.0).sqrt());
    let vertical = track.vertical_motion();
    Some(EnuVelocity {
        east_rate: Some(motion.velocity.x),
        north_rate: Some(motion.velocity.y),
        up_rate: vertical.map(PublishedMotion::climb),
        east_rate_error: deviation(known.velocity_covariance.m11),
        north_rate_error: deviation(known.velocity_covariance.m22),
        up_rate_error: vertical.and_then(|_| deviation(known.climb_m2s2)),
    })
}
