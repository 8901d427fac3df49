//! Registration of this node: a fusion node with one mode, which takes no tasks.

use super::messages::{
    Capability, ClassDefinition, ConfidenceDefinition, ConfigurationData, CoordinateSystem, Datum,
    DetectionClassDefinition, DetectionDefinition, Duration, GeometricError, LocationType, ModeDefinition,
    ModeType, NodeDefinition, NodeType, RegionDefinition, RegionType, ReportCategory, ReportDefinition,
    SapientRegistration, SpeedUnits, StatusDefinition, TaskDefinition, TimeUnits, TrackingType, VelocityType,
    VelocityUnits,
};
use super::{MODE, SapientWriter};

/// Possible contents of `track_info` and `object_info`: category, name, and values.
const REPORTED: [(ReportCategory, &str, &str); 6] = [
    (ReportCategory::Track, "id", "text"),
    (ReportCategory::Track, "source", "fused, radar, transponder"),
    (ReportCategory::Track, "integrity", "unverified, verified, suspect, failed"),
    (ReportCategory::Track, "extrapolated", "true"),
    (ReportCategory::Object, "serial_number", "text"),
    (ReportCategory::Object, "crew", "unmanned, crewed"),
];

/// Possible classes in `classification`.
const CLASSES: [&str; 3] = ["Air Vehicle", "Land Vehicle", "Other"];

fn text(words: &str) -> Option<String> {
    Some(words.to_owned())
}

fn seconds(value: f32) -> Option<Duration> {
    Some(Duration { units: Some(TimeUnits::Seconds.into()), value: Some(value) })
}

pub(super) fn registration(writer: &SapientWriter) -> SapientRegistration {
    let place = LocationType {
        location_units: Some(CoordinateSystem::LatLngDegM.into()),
        location_datum: Some(Datum::Wgs84Ellipsoid.into()),
    };
    SapientRegistration {
        node_definition: vec![NodeDefinition {
            node_type: Some(NodeType::FusionNode.into()),
            node_sub_type: vec!["Track fusion".to_owned()],
        }],
        icd_version: text("BSI Flex 335 v2.0"),
        name: Some(writer.site.clone()),
        short_name: text("utm-fusion"),
        capabilities: vec![Capability {
            category: text("Fusion"),
            kind: text("Tracks of radar and of drones' transponders"),
        }],
        status_definition: Some(StatusDefinition { status_interval: seconds(writer.status_interval_s) }),
        mode_definition: vec![ModeDefinition {
            mode_name: text(MODE),
            mode_type: Some(ModeType::Permanent.into()),
            settle_time: seconds(0.0),
            maximum_latency: seconds(writer.latency_s),
            tracking_type: Some(TrackingType::Track.into()),
            detection_definition: vec![detections(place)],
            task: Some(TaskDefinition {
                concurrent_tasks: Some(0),
                region_definition: Some(RegionDefinition {
                    region_type: vec![RegionType::AreaOfInterest.into()],
                    region_area: vec![place],
                }),
            }),
        }],
        config_data: vec![ConfigurationData {
            manufacturer: "utm-fusion".to_owned(),
            model: "utm-fusion".to_owned(),
            software_version: text(env!("CARGO_PKG_VERSION")),
        }],
    }
}

fn detections(place: LocationType) -> DetectionDefinition {
    let report = |(category, kind, units): (ReportCategory, &str, &str)| ReportDefinition {
        category: Some(category.into()),
        kind: text(kind),
        units: text(units),
    };
    let metres_per_second = Some(SpeedUnits::MetresPerSecond.into());
    DetectionDefinition {
        location_type: Some(place),
        detection_report: REPORTED.map(report).into(),
        detection_class_definition: vec![DetectionClassDefinition {
            confidence_definition: Some(ConfidenceDefinition::SingleClass.into()),
            class_definition: CLASSES.map(|class| ClassDefinition { kind: text(class) }).into(),
        }],
        velocity_type: Some(VelocityType {
            enu_velocity_units: Some(VelocityUnits {
                east_north_rate_units: metres_per_second,
                up_rate_units: metres_per_second,
            }),
            location_datum: Some(Datum::Wgs84Ellipsoid.into()),
        }),
        geometric_error: Some(GeometricError {
            kind: text("Standard Deviation"),
            units: text("as the coordinates: degrees, metres"),
            variation_type: text("as estimated for each report"),
        }),
    }
}
