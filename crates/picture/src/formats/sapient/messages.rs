//! SAPIENT messages (BSI Flex 335 v2.0) that this service sends or reads, as protocol buffers. Only the fields in use are
//! defined, with the numbers of the standard.

#![expect(
    missing_docs,
    reason = "types, fields and values have the names of the standard, which describes them"
)]

use prost::{Enumeration, Message, Oneof};

/// `google.protobuf.ProtobufTimestamp`.
#[derive(Clone, Copy, PartialEq, Message)]
pub struct ProtobufTimestamp {
    #[prost(int64, tag = "1")]
    pub seconds: i64,
    #[prost(int32, tag = "2")]
    pub nanos: i32,
}

/// Envelope of every message.
#[derive(Clone, PartialEq, Message)]
pub struct SapientMessage {
    #[prost(message, optional, tag = "1")]
    pub timestamp: Option<ProtobufTimestamp>,
    /// UUID of the sender.
    #[prost(string, optional, tag = "2")]
    pub node_id: Option<String>,
    /// UUID of the receiver.
    #[prost(string, optional, tag = "3")]
    pub destination_id: Option<String>,
    #[prost(oneof = "SapientContent", tags = "4, 5, 6, 7, 8, 9, 12")]
    pub content: Option<SapientContent>,
}

#[derive(Clone, PartialEq, Oneof)]
pub enum SapientContent {
    #[prost(message, tag = "4")]
    Registration(SapientRegistration),
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
pub struct SapientRegistration {
    #[prost(message, repeated, tag = "1")]
    pub node_definition: Vec<NodeDefinition>,
    #[prost(string, optional, tag = "2")]
    pub icd_version: Option<String>,
    #[prost(string, optional, tag = "3")]
    pub name: Option<String>,
    #[prost(string, optional, tag = "4")]
    pub short_name: Option<String>,
    #[prost(message, repeated, tag = "5")]
    pub capabilities: Vec<Capability>,
    #[prost(message, optional, tag = "6")]
    pub status_definition: Option<StatusDefinition>,
    #[prost(message, repeated, tag = "7")]
    pub mode_definition: Vec<ModeDefinition>,
    #[prost(message, repeated, tag = "10")]
    pub config_data: Vec<ConfigurationData>,
}

#[derive(Clone, PartialEq, Message)]
pub struct NodeDefinition {
    #[prost(enumeration = "NodeType", optional, tag = "1")]
    pub node_type: Option<i32>,
    #[prost(string, repeated, tag = "2")]
    pub node_sub_type: Vec<String>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Enumeration)]
#[repr(i32)]
pub enum NodeType {
    Unspecified = 0,
    FusionNode = 20,
}

#[derive(Clone, PartialEq, Message)]
pub struct Capability {
    #[prost(string, optional, tag = "1")]
    pub category: Option<String>,
    #[prost(string, optional, tag = "2")]
    pub kind: Option<String>,
}

#[derive(Clone, PartialEq, Message)]
pub struct StatusDefinition {
    #[prost(message, optional, tag = "1")]
    pub status_interval: Option<Duration>,
}

#[derive(Clone, Copy, PartialEq, Message)]
pub struct Duration {
    #[prost(enumeration = "TimeUnits", optional, tag = "1")]
    pub units: Option<i32>,
    #[prost(float, optional, tag = "3")]
    pub value: Option<f32>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Enumeration)]
#[repr(i32)]
pub enum TimeUnits {
    Unspecified = 0,
    Seconds = 4,
}

#[derive(Clone, PartialEq, Message)]
pub struct ModeDefinition {
    #[prost(string, optional, tag = "1")]
    pub mode_name: Option<String>,
    #[prost(enumeration = "ModeType", optional, tag = "2")]
    pub mode_type: Option<i32>,
    #[prost(message, optional, tag = "4")]
    pub settle_time: Option<Duration>,
    #[prost(message, optional, tag = "5")]
    pub maximum_latency: Option<Duration>,
    #[prost(enumeration = "TrackingType", optional, tag = "7")]
    pub tracking_type: Option<i32>,
    #[prost(message, repeated, tag = "10")]
    pub detection_definition: Vec<DetectionDefinition>,
    #[prost(message, optional, tag = "11")]
    pub task: Option<TaskDefinition>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Enumeration)]
#[repr(i32)]
pub enum ModeType {
    Unspecified = 0,
    Permanent = 1,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Enumeration)]
#[repr(i32)]
pub enum TrackingType {
    Unspecified = 0,
    /// An object keeps its id even if its track was interrupted.
    Track = 3,
}

#[derive(Clone, PartialEq, Message)]
pub struct DetectionDefinition {
    #[prost(message, optional, tag = "1")]
    pub location_type: Option<LocationType>,
    #[prost(message, repeated, tag = "3")]
    pub detection_report: Vec<ReportDefinition>,
    #[prost(message, repeated, tag = "4")]
    pub detection_class_definition: Vec<DetectionClassDefinition>,
    #[prost(message, optional, tag = "6")]
    pub velocity_type: Option<VelocityType>,
    #[prost(message, optional, tag = "7")]
    pub geometric_error: Option<GeometricError>,
}

/// Coordinate and datum types of a location. The standard has two alternatives for latitude and longitude, of which the service
/// uses one.
#[derive(Clone, Copy, PartialEq, Message)]
pub struct LocationType {
    #[prost(enumeration = "CoordinateSystem", optional, tag = "1")]
    pub location_units: Option<i32>,
    #[prost(enumeration = "Datum", optional, tag = "3")]
    pub location_datum: Option<i32>,
}

/// `SapientRegistration.DetectionReport`.
#[derive(Clone, PartialEq, Message)]
pub struct ReportDefinition {
    #[prost(enumeration = "ReportCategory", optional, tag = "1")]
    pub category: Option<i32>,
    #[prost(string, optional, tag = "2")]
    pub kind: Option<String>,
    #[prost(string, optional, tag = "3")]
    pub units: Option<String>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Enumeration)]
#[repr(i32)]
pub enum ReportCategory {
    Unspecified = 0,
    Track = 2,
    Object = 3,
}

#[derive(Clone, PartialEq, Message)]
pub struct DetectionClassDefinition {
    #[prost(enumeration = "ConfidenceDefinition", optional, tag = "1")]
    pub confidence_definition: Option<i32>,
    #[prost(message, repeated, tag = "3")]
    pub class_definition: Vec<ClassDefinition>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Enumeration)]
#[repr(i32)]
pub enum ConfidenceDefinition {
    Unspecified = 0,
    SingleClass = 1,
}

#[derive(Clone, PartialEq, Message)]
pub struct ClassDefinition {
    #[prost(string, optional, tag = "1")]
    pub kind: Option<String>,
}

#[derive(Clone, Copy, PartialEq, Message)]
pub struct VelocityType {
    #[prost(message, optional, tag = "4")]
    pub enu_velocity_units: Option<VelocityUnits>,
    #[prost(enumeration = "Datum", optional, tag = "6")]
    pub location_datum: Option<i32>,
}

#[derive(Clone, Copy, PartialEq, Message)]
pub struct VelocityUnits {
    #[prost(enumeration = "SpeedUnits", optional, tag = "1")]
    pub east_north_rate_units: Option<i32>,
    #[prost(enumeration = "SpeedUnits", optional, tag = "2")]
    pub up_rate_units: Option<i32>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Enumeration)]
#[repr(i32)]
pub enum SpeedUnits {
    Unspecified = 0,
    MetresPerSecond = 1,
}

#[derive(Clone, PartialEq, Message)]
pub struct GeometricError {
    #[prost(string, optional, tag = "1")]
    pub kind: Option<String>,
    #[prost(string, optional, tag = "2")]
    pub units: Option<String>,
    #[prost(string, optional, tag = "3")]
    pub variation_type: Option<String>,
}

#[derive(Clone, PartialEq, Message)]
pub struct TaskDefinition {
    #[prost(int32, optional, tag = "1")]
    pub concurrent_tasks: Option<i32>,
    #[prost(message, optional, tag = "2")]
    pub region_definition: Option<RegionDefinition>,
}

#[derive(Clone, PartialEq, Message)]
pub struct RegionDefinition {
    #[prost(enumeration = "RegionType", repeated, tag = "1")]
    pub region_type: Vec<i32>,
    #[prost(message, repeated, tag = "3")]
    pub region_area: Vec<LocationType>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Enumeration)]
#[repr(i32)]
pub enum RegionType {
    Unspecified = 0,
    AreaOfInterest = 1,
}

#[derive(Clone, PartialEq, Message)]
pub struct ConfigurationData {
    #[prost(string, tag = "1")]
    pub manufacturer: String,
    #[prost(string, tag = "2")]
    pub model: String,
    #[prost(string, optional, tag = "5")]
    pub software_version: Option<String>,
}

#[derive(Clone, PartialEq, Message)]
pub struct RegistrationAck {
    #[prost(bool, optional, tag = "1")]
    pub acceptance: Option<bool>,
    #[prost(string, repeated, tag = "3")]
    pub ack_response_reason: Vec<String>,
}

#[derive(Clone, PartialEq, Message)]
pub struct StatusReport {
    #[prost(string, optional, tag = "1")]
    pub report_id: Option<String>,
    #[prost(enumeration = "SapientSystemState", optional, tag = "2")]
    pub system: Option<i32>,
    #[prost(enumeration = "ReportInfo", optional, tag = "3")]
    pub info: Option<i32>,
    #[prost(string, optional, tag = "5")]
    pub mode: Option<String>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Enumeration)]
#[repr(i32)]
pub enum SapientSystemState {
    Unspecified = 0,
    Ok = 1,
    Warning = 2,
    Error = 3,
    /// The node is about to disconnect.
    Goodbye = 5,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Enumeration)]
#[repr(i32)]
pub enum ReportInfo {
    Unspecified = 0,
    New = 1,
    Unchanged = 2,
}

#[derive(Clone, PartialEq, Message)]
pub struct DetectionReport {
    #[prost(string, optional, tag = "1")]
    pub report_id: Option<String>,
    #[prost(string, optional, tag = "2")]
    pub object_id: Option<String>,
    #[prost(string, optional, tag = "4")]
    pub state: Option<String>,
    #[prost(message, optional, tag = "6")]
    pub location: Option<Location>,
    #[prost(message, repeated, tag = "8")]
    pub track_info: Vec<ObjectInfo>,
    #[prost(message, repeated, tag = "10")]
    pub object_info: Vec<ObjectInfo>,
    #[prost(message, repeated, tag = "11")]
    pub classification: Vec<Classification>,
    #[prost(message, optional, tag = "19")]
    pub enu_velocity: Option<EnuVelocity>,
    #[prost(string, optional, tag = "23")]
    pub id: Option<String>,
}

#[derive(Clone, Copy, PartialEq, Message)]
pub struct Location {
    /// Longitude, in degrees.
    #[prost(double, optional, tag = "1")]
    pub x: Option<f64>,
    /// Latitude, in degrees.
    #[prost(double, optional, tag = "2")]
    pub y: Option<f64>,
    /// Height above the datum, in metres.
    #[prost(double, optional, tag = "3")]
    pub z: Option<f64>,
    #[prost(double, optional, tag = "4")]
    pub x_error: Option<f64>,
    #[prost(double, optional, tag = "5")]
    pub y_error: Option<f64>,
    #[prost(double, optional, tag = "6")]
    pub z_error: Option<f64>,
    #[prost(enumeration = "CoordinateSystem", optional, tag = "7")]
    pub coordinate_system: Option<i32>,
    #[prost(enumeration = "Datum", optional, tag = "8")]
    pub datum: Option<i32>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Enumeration)]
#[repr(i32)]
pub enum CoordinateSystem {
    Unspecified = 0,
    LatLngDegM = 1,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Enumeration)]
#[repr(i32)]
pub enum Datum {
    Unspecified = 0,
    Wgs84Ellipsoid = 1,
}

/// `DetectionReport.TrackObjectInfo`.
#[derive(Clone, PartialEq, Message)]
pub struct ObjectInfo {
    #[prost(string, optional, tag = "1")]
    pub kind: Option<String>,
    #[prost(string, optional, tag = "2")]
    pub value: Option<String>,
}

#[derive(Clone, PartialEq, Message)]
pub struct Classification {
    #[prost(string, optional, tag = "1")]
    pub kind: Option<String>,
    #[prost(float, optional, tag = "2")]
    pub confidence: Option<f32>,
}

/// Velocity, in metres per second.
#[derive(Clone, Copy, PartialEq, Message)]
pub struct EnuVelocity {
    #[prost(double, optional, tag = "1")]
    pub east_rate: Option<f64>,
    #[prost(double, optional, tag = "2")]
    pub north_rate: Option<f64>,
    #[prost(double, optional, tag = "3")]
    pub up_rate: Option<f64>,
    #[prost(double, optional, tag = "4")]
    pub east_rate_error: Option<f64>,
    #[prost(double, optional, tag = "5")]
    pub north_rate_error: Option<f64>,
    #[prost(double, optional, tag = "6")]
    pub up_rate_error: Option<f64>,
}

#[derive(Clone, PartialEq, Message)]
pub struct Task {
    #[prost(string, optional, tag = "1")]
    pub task_id: Option<String>,
}

#[derive(Clone, PartialEq, Message)]
pub struct TaskAck {
    #[prost(string, optional, tag = "1")]
    pub task_id: Option<String>,
    #[prost(enumeration = "TaskStatus", optional, tag = "2")]
    pub task_status: Option<i32>,
    #[prost(string, repeated, tag = "5")]
    pub reason: Vec<String>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Enumeration)]
#[repr(i32)]
pub enum TaskStatus {
    Unspecified = 0,
    Rejected = 2,
}

#[derive(Clone, PartialEq, Message)]
pub struct Error {
    #[prost(string, repeated, tag = "3")]
    pub error_message: Vec<String>,
}
