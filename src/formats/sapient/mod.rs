//! Tracks as SAPIENT messages, BSI Flex 335 v2.0 (`docs/SAPIENT.md`).

pub(crate) mod frames;
pub(crate) mod messages;
mod registration;
mod ulid;

use crate::picture::{Motion, PictureMaker, PictureTrack, TrackClass, serial_text};
use fusion::time::{SECOND, Time};
use messages::{
    Classification, Content, CoordinateSystem, Datum, DetectionReport, EnuVelocity, Info, Location,
    ObjectInfo, Registration, SapientMessage, StatusReport, System, TaskAck, TaskStatus, Timestamp,
};
use registration::registration;
use ulid::ulid;

/// The one mode of this node.
const MODE: &str = "Default";
/// Length of a degree of latitude, metres; of longitude at the equator. Within 0.6 % of the ellipsoid's, for deviations.
const DEGREE_M: f64 = 111_195.0;

/// Writes the messages of one node.
#[derive(Clone, Debug)]
pub(crate) struct SapientWriter {
    /// UUID of this node, in every message.
    pub(crate) node_id: String,
    /// Name of the site.
    pub(crate) site: String,
    /// Between two status reports, seconds.
    pub(crate) status_interval_s: f32,
    /// From a slot's opening to its publication, seconds.
    pub(crate) latency_s: f32,
}

impl SapientWriter {
    /// A message of this node.
    pub(crate) fn message(&self, at: Time, content: Content) -> SapientMessage {
        let nanos = at.nanos();
        SapientMessage {
            timestamp: Some(Timestamp {
                seconds: nanos.div_euclid(SECOND),
                nanos: nanos.rem_euclid(SECOND) as i32,
            }),
            node_id: Some(self.node_id.clone()),
            destination_id: None,
            content: Some(content),
        }
    }

    /// What a connection begins with.
    pub(crate) fn registration(&self) -> Registration {
        registration(self)
    }

    /// How the service is.
    pub(crate) fn status(&self, at: Time, system: System, info: Info) -> StatusReport {
        StatusReport {
            report_id: Some(ulid(at, &[self.node_id.as_bytes(), b"status"])),
            system: Some(system.into()),
            info: Some(info.into()),
            mode: Some(MODE.to_owned()),
        }
    }

    /// A task is refused: this node takes none.
    pub(crate) fn refusal(&self, task_id: Option<String>) -> TaskAck {
        TaskAck {
            task_id,
            task_status: Some(TaskStatus::Rejected.into()),
            reason: vec!["this node takes no tasks".to_owned()],
        }
    }

    /// A track; `None` for a place that is not on Earth.
    pub(crate) fn detection(&self, track: &PictureTrack, maker: &PictureMaker) -> Option<DetectionReport> {
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

    /// The last report of a track that is in the picture no more.
    pub(crate) fn lost(&self, at: Time, last: DetectionReport) -> DetectionReport {
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

/// Longitude, latitude and ellipsoidal height with their standard deviations, each in the unit of its coordinate.
fn location(track: &PictureTrack) -> Option<Location> {
    let (latitude, longitude) = (track.position.latitude_deg(), track.position.longitude_deg());
    if !((-90.0..=90.0).contains(&latitude) && (-180.0..=180.0).contains(&longitude)) {
        return None;
    }
    let deviation_m = |variance: f64| variance.max(0.0).sqrt();
    let estimate = track.point.estimate.as_ref();
    // At a pole every longitude is the same place.
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

/// A radar's classifier is asked for how sure it is; of a transponder nobody says.
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
        up_rate: vertical.map(Motion::climb),
        east_rate_error: deviation(known.velocity_covariance.m11),
        north_rate_error: deviation(known.velocity_covariance.m22),
        up_rate_error: vertical.and_then(|_| deviation(known.climb_m2s2)),
    })
}
