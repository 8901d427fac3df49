//! The messages of SAPIENT (BSI Flex 335 v2.0) that this service sends or reads, as protocol buffers. The fields are those
//! that it fills; their numbers are the standard's.

use prost::{Enumeration, Message, Oneof};

/// `google.protobuf.Timestamp`.
#[derive(Clone, Copy, PartialEq, Message)]
pub(crate) struct Timestamp {
    #[prost(int64, tag = "1")]
    pub(crate) seconds: i64,
    #[prost(int32, tag = "2")]
    pub(crate) nanos: i32,
}

/// Every message is one of these.
#[derive(Clone, PartialEq, Message)]
pub(crate) struct SapientMessage {
    #[prost(message, optional, tag = "1")]
    pub(crate) timestamp: Option<Timestamp>,
    /// UUID of the sender.
    #[prost(string, optional, tag = "2")]
    pub(crate) node_id: Option<String>,
    /// UUID of the receiver.
    #[prost(string, optional, tag = "3")]
    pub(crate) destination_id: Option<String>,
    #[prost(oneof = "Content", tags = "4, 5, 6, 7, 8, 9, 12")]
    pub(crate) content: Option<Content>,
}

#[derive(Clone, PartialEq, Oneof)]
pub(crate) enum Content {
    #[prost(message, tag = "4")]
    Registration(Registration),
    #[prost(message, tag = "5")]
    RegistrationAck(RegistrationAck),
    #[prost(message, tag = "6")]
    StatusReport(StatusReport),
    #[prost(message, tag = "7")]
    DetectionReport(DetectionReport),
    #[prost(message, tag = "8")]
    Task(Task),
    #[prost(message, tag = "9")]
    TaskAck(TaskAck),
    #[prost(message, tag = "12")]
    Error(Error),
}

#[derive(Clone, PartialEq, Message)]
pub(crate) struct Registration {
    #[prost(message, repeated, tag = "1")]
    pub(crate) node_definition: Vec<NodeDefinition>,
    #[prost(string, optional, tag = "2")]
    pub(crate) icd_version: Option<String>,
    #[prost(string, optional, tag = "3")]
    pub(crate) name: Option<String>,
    #[prost(string, optional, tag = "4")]
    pub(crate) short_name: Option<String>,
    #[prost(message, repeated, tag = "5")]
    pub(crate) capabilities: Vec<Capability>,
    #[prost(message, optional, tag = "6")]
    pub(crate) status_definition: Option<StatusDefinition>,
    #[prost(message, repeated, tag = "7")]
    pub(crate) mode_definition: Vec<ModeDefinition>,
    #[prost(message, repeated, tag = "10")]
    pub(crate) config_data: Vec<ConfigurationData>,
}

#[derive(Clone, PartialEq, Message)]
pub(crate) struct NodeDefinition {
    #[prost(enumeration = "NodeType", optional, tag = "1")]
    pub(crate) node_type: Option<i32>,
    #[prost(string, repeated, tag = "2")]
    pub(crate) node_sub_type: Vec<String>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Enumeration)]
#[repr(i32)]
pub(crate) enum NodeType {
    Unspecified = 0,
    FusionNode = 20,
}

#[derive(Clone, PartialEq, Message)]
pub(crate) struct Capability {
    #[prost(string, optional, tag = "1")]
    pub(crate) category: Option<String>,
    #[prost(string, optional, tag = "2")]
    pub(crate) kind: Option<String>,
}

#[derive(Clone, PartialEq, Message)]
pub(crate) struct StatusDefinition {
    #[prost(message, optional, tag = "1")]
    pub(crate) status_interval: Option<Duration>,
}

#[derive(Clone, Copy, PartialEq, Message)]
pub(crate) struct Duration {
    #[prost(enumeration = "TimeUnits", optional, tag = "1")]
    pub(crate) units: Option<i32>,
    #[prost(float, optional, tag = "3")]
    pub(crate) value: Option<f32>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Enumeration)]
#[repr(i32)]
pub(crate) enum TimeUnits {
    Unspecified = 0,
    Seconds = 4,
}

#[derive(Clone, PartialEq, Message)]
pub(crate) struct ModeDefinition {
    #[prost(string, optional, tag = "1")]
    pub(crate) mode_name: Option<String>,
    #[prost(enumeration = "ModeType", optional, tag = "2")]
    pub(crate) mode_type: Option<i32>,
    #[prost(message, optional, tag = "4")]
    pub(crate) settle_time: Option<Duration>,
    #[prost(message, optional, tag = "5")]
    pub(crate) maximum_latency: Option<Duration>,
    #[prost(enumeration = "TrackingType", optional, tag = "7")]
    pub(crate) tracking_type: Option<i32>,
    #[prost(message, repeated, tag = "10")]
    pub(crate) detection_definition: Vec<DetectionDefinition>,
    #[prost(message, optional, tag = "11")]
    pub(crate) task: Option<TaskDefinition>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Enumeration)]
#[repr(i32)]
pub(crate) enum ModeType {
    Unspecified = 0,
    Permanent = 1,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Enumeration)]
#[repr(i32)]
pub(crate) enum TrackingType {
    Unspecified = 0,
    /// An object keeps its id, also where its track was interrupted.
    Track = 3,
}

#[derive(Clone, PartialEq, Message)]
pub(crate) struct DetectionDefinition {
    #[prost(message, optional, tag = "1")]
    pub(crate) location_type: Option<LocationType>,
    #[prost(message, repeated, tag = "3")]
    pub(crate) detection_report: Vec<ReportDefinition>,
    #[prost(message, repeated, tag = "4")]
    pub(crate) detection_class_definition: Vec<DetectionClassDefinition>,
    #[prost(message, optional, tag = "6")]
    pub(crate) velocity_type: Option<VelocityType>,
    #[prost(message, optional, tag = "7")]
    pub(crate) geometric_error: Option<GeometricError>,
}

/// Latitude and longitude have one of two alternatives of the standard each; this service uses no other.
#[derive(Clone, Copy, PartialEq, Message)]
pub(crate) struct LocationType {
    #[prost(enumeration = "CoordinateSystem", optional, tag = "1")]
    pub(crate) location_units: Option<i32>,
    #[prost(enumeration = "Datum", optional, tag = "3")]
    pub(crate) location_datum: Option<i32>,
}

/// `Registration.DetectionReport`.
#[derive(Clone, PartialEq, Message)]
pub(crate) struct ReportDefinition {
    #[prost(enumeration = "ReportCategory", optional, tag = "1")]
    pub(crate) category: Option<i32>,
    #[prost(string, optional, tag = "2")]
    pub(crate) kind: Option<String>,
    #[prost(string, optional, tag = "3")]
    pub(crate) units: Option<String>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Enumeration)]
#[repr(i32)]
pub(crate) enum ReportCategory {
    Unspecified = 0,
    Track = 2,
    Object = 3,
}

#[derive(Clone, PartialEq, Message)]
pub(crate) struct DetectionClassDefinition {
    #[prost(enumeration = "ConfidenceDefinition", optional, tag = "1")]
    pub(crate) confidence_definition: Option<i32>,
    #[prost(message, repeated, tag = "3")]
    pub(crate) class_definition: Vec<ClassDefinition>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Enumeration)]
#[repr(i32)]
pub(crate) enum ConfidenceDefinition {
    Unspecified = 0,
    SingleClass = 1,
}

#[derive(Clone, PartialEq, Message)]
pub(crate) struct ClassDefinition {
    #[prost(string, optional, tag = "1")]
    pub(crate) kind: Option<String>,
}

#[derive(Clone, Copy, PartialEq, Message)]
pub(crate) struct VelocityType {
    #[prost(message, optional, tag = "4")]
    pub(crate) enu_velocity_units: Option<VelocityUnits>,
    #[prost(enumeration = "Datum", optional, tag = "6")]
    pub(crate) location_datum: Option<i32>,
}

#[derive(Clone, Copy, PartialEq, Message)]
pub(crate) struct VelocityUnits {
    #[prost(enumeration = "SpeedUnits", optional, tag = "1")]
    pub(crate) east_north_rate_units: Option<i32>,
    #[prost(enumeration = "SpeedUnits", optional, tag = "2")]
    pub(crate) up_rate_units: Option<i32>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Enumeration)]
#[repr(i32)]
pub(crate) enum SpeedUnits {
    Unspecified = 0,
    MetresPerSecond = 1,
}

#[derive(Clone, PartialEq, Message)]
pub(crate) struct GeometricError {
    #[prost(string, optional, tag = "1")]
    pub(crate) kind: Option<String>,
    #[prost(string, optional, tag = "2")]
    pub(crate) units: Option<String>,
    #[prost(string, optional, tag = "3")]
    pub(crate) variation_type: Option<String>,
}

#[derive(Clone, PartialEq, Message)]
pub(crate) struct TaskDefinition {
    #[prost(int32, optional, tag = "1")]
    pub(crate) concurrent_tasks: Option<i32>,
    #[prost(message, optional, tag = "2")]
    pub(crate) region_definition: Option<RegionDefinition>,
}

#[derive(Clone, PartialEq, Message)]
pub(crate) struct RegionDefinition {
    #[prost(enumeration = "RegionType", repeated, tag = "1")]
    pub(crate) region_type: Vec<i32>,
    #[prost(message, repeated, tag = "3")]
    pub(crate) region_area: Vec<LocationType>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Enumeration)]
#[repr(i32)]
pub(crate) enum RegionType {
    Unspecified = 0,
    AreaOfInterest = 1,
}

#[derive(Clone, PartialEq, Message)]
pub(crate) struct ConfigurationData {
    #[prost(string, tag = "1")]
    pub(crate) manufacturer: String,
    #[prost(string, tag = "2")]
    pub(crate) model: String,
    #[prost(string, optional, tag = "5")]
    pub(crate) software_version: Option<String>,
}

#[derive(Clone, PartialEq, Message)]
pub(crate) struct RegistrationAck {
    #[prost(bool, optional, tag = "1")]
    pub(crate) acceptance: Option<bool>,
    #[prost(string, repeated, tag = "3")]
    pub(crate) ack_response_reason: Vec<String>,
}

#[derive(Clone, PartialEq, Message)]
pub(crate) struct StatusReport {
    #[prost(string, optional, tag = "1")]
    pub(crate) report_id: Option<String>,
    #[prost(enumeration = "System", optional, tag = "2")]
    pub(crate) system: Option<i32>,
    #[prost(enumeration = "Info", optional, tag = "3")]
    pub(crate) info: Option<i32>,
    #[prost(string, optional, tag = "5")]
    pub(crate) mode: Option<String>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Enumeration)]
#[repr(i32)]
pub(crate) enum System {
    Unspecified = 0,
    Ok = 1,
    Warning = 2,
    Error = 3,
    /// The node is about to disconnect.
    Goodbye = 5,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Enumeration)]
#[repr(i32)]
pub(crate) enum Info {
    Unspecified = 0,
    New = 1,
    Unchanged = 2,
}

#[derive(Clone, PartialEq, Message)]
pub(crate) struct DetectionReport {
    #[prost(string, optional, tag = "1")]
    pub(crate) report_id: Option<String>,
    #[prost(string, optional, tag = "2")]
    pub(crate) object_id: Option<String>,
    #[prost(string, optional, tag = "4")]
    pub(crate) state: Option<String>,
    #[prost(message, optional, tag = "6")]
    pub(crate) location: Option<Location>,
    #[prost(message, repeated, tag = "8")]
    pub(crate) track_info: Vec<ObjectInfo>,
    #[prost(message, repeated, tag = "10")]
    pub(crate) object_info: Vec<ObjectInfo>,
    #[prost(message, repeated, tag = "11")]
    pub(crate) classification: Vec<Classification>,
    #[prost(message, optional, tag = "19")]
    pub(crate) enu_velocity: Option<EnuVelocity>,
    #[prost(string, optional, tag = "23")]
    pub(crate) id: Option<String>,
}

#[derive(Clone, Copy, PartialEq, Message)]
pub(crate) struct Location {
    /// Longitude, degrees.
    #[prost(double, optional, tag = "1")]
    pub(crate) x: Option<f64>,
    /// Latitude, degrees.
    #[prost(double, optional, tag = "2")]
    pub(crate) y: Option<f64>,
    /// Height above the datum, metres.
    #[prost(double, optional, tag = "3")]
    pub(crate) z: Option<f64>,
    #[prost(double, optional, tag = "4")]
    pub(crate) x_error: Option<f64>,
    #[prost(double, optional, tag = "5")]
    pub(crate) y_error: Option<f64>,
    #[prost(double, optional, tag = "6")]
    pub(crate) z_error: Option<f64>,
    #[prost(enumeration = "CoordinateSystem", optional, tag = "7")]
    pub(crate) coordinate_system: Option<i32>,
    #[prost(enumeration = "Datum", optional, tag = "8")]
    pub(crate) datum: Option<i32>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Enumeration)]
#[repr(i32)]
pub(crate) enum CoordinateSystem {
    Unspecified = 0,
    LatLngDegM = 1,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Enumeration)]
#[repr(i32)]
pub(crate) enum Datum {
    Unspecified = 0,
    Wgs84Ellipsoid = 1,
}

/// `DetectionReport.TrackObjectInfo`.
#[derive(Clone, PartialEq, Message)]
pub(crate) struct ObjectInfo {
    #[prost(string, optional, tag = "1")]
    pub(crate) kind: Option<String>,
    #[prost(string, optional, tag = "2")]
    pub(crate) value: Option<String>,
}

#[derive(Clone, PartialEq, Message)]
pub(crate) struct Classification {
    #[prost(string, optional, tag = "1")]
    pub(crate) kind: Option<String>,
    #[prost(float, optional, tag = "2")]
    pub(crate) confidence: Option<f32>,
}

/// Metres a second.
#[derive(Clone, Copy, PartialEq, Message)]
pub(crate) struct EnuVelocity {
    #[prost(double, optional, tag = "1")]
    pub(crate) east_rate: Option<f64>,
    #[prost(double, optional, tag = "2")]
    pub(crate) north_rate: Option<f64>,
    #[prost(double, optional, tag = "3")]
    pub(crate) up_rate: Option<f64>,
    #[prost(double, optional, tag = "4")]
    pub(crate) east_rate_error: Option<f64>,
    #[prost(double, optional, tag = "5")]
    pub(crate) north_rate_error: Option<f64>,
    #[prost(double, optional, tag = "6")]
    pub(crate) up_rate_error: Option<f64>,
}

#[derive(Clone, PartialEq, Message)]
pub(crate) struct Task {
    #[prost(string, optional, tag = "1")]
    pub(crate) task_id: Option<String>,
}

#[derive(Clone, PartialEq, Message)]
pub(crate) struct TaskAck {
    #[prost(string, optional, tag = "1")]
    pub(crate) task_id: Option<String>,
    #[prost(enumeration = "TaskStatus", optional, tag = "2")]
    pub(crate) task_status: Option<i32>,
    #[prost(string, repeated, tag = "5")]
    pub(crate) reason: Vec<String>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Enumeration)]
#[repr(i32)]
pub(crate) enum TaskStatus {
    Unspecified = 0,
    Rejected = 2,
}

#[derive(Clone, PartialEq, Message)]
pub(crate) struct Error {
    #[prost(string, repeated, tag = "3")]
    pub(crate) error_message: Vec<String>,
}
