//! Encodes detections and reports as the sensors' datagrams.

use asterix::cat034::{self, MessageKind, MessageType, RotationPeriod, SourcePosition, SystemStatus};
use asterix::cat048::{
    self, DetectionType, Height3D, PolarPosition, TargetReport, TrackNumber, TrackVelocity,
};
use asterix::cat129::{self, Altitude, GnssAccuracy, HorizontalVelocity, Position, VerticalVelocity};
use asterix::{DataSource, Explicit, TimeOfDay, encode_block};
use jiff::SignedDuration;

use fusion::time::Time;
use input::normalise::{nearest_day, time_of_day_count};
use picture::formats::DATAGRAM_MAX;
use world::ground::{Antenna, Ground};
use world::radar::{RadarDetection, clock_s};
use world::scenario::{Radar, Span, Transponder};
use world::streams::RandomStream;
use world::transponder::TransponderReport;

/// A datagram and its time of arrival over a perfect network.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SentDatagram {
    /// Time of arrival.
    pub arrives: Time,
    /// Index of the sensor in the configuration.
    pub sensor: usize,
    /// Payload of the datagram.
    pub payload: Vec<u8>,
}

/// Maximum time for which a radar collects detections before sending, seconds.
const LONGEST_BATCH_S: f64 = 0.25;
/// Octets reserved in a datagram for a service message.
const SERVICE_OCTETS: usize = 40;

/// Time that is `seconds` after take-off.
pub fn after(start: Time, seconds: f64) -> Time {
    start + SignedDuration::from_nanos((seconds * 1e9).round() as i64)
}

/// Time as a sensor stamps it, rounded to 1/128 s.
pub fn stamped(time: Time) -> Time {
    nearest_day(time_of_day_count(time), time).unwrap_or(time)
}

fn time_of_day(time: Time) -> Option<TimeOfDay> {
    TimeOfDay::from_count(time_of_day_count(time))
}

/// Datagrams of radar number `sensor`, whose detections are in order of time. Detections within one period, at most
/// 0.25 s, are sent together.
pub fn radar_datagrams(
    radar: &Radar,
    sensor: usize,
    antenna: &Antenna,
    detections: &[RadarDetection],
    (start, duration_s): (Time, f64),
    stream: &mut RandomStream,
) -> Vec<SentDatagram> {
    let source = DataSource { sac: radar.sac as u8, sic: radar.sic as u8 };
    let batch_s = radar.period_s.min(LONGEST_BATCH_S);
    let service_s = radar.period_s.max(1.0);
    let mut next_service_s = 0.0;
    let mut sent = Vec::new();
    let mut rest = detections;
    for batch in 0..(duration_s / batch_s).ceil() as usize {
        let end_s = (batch + 1) as f64 * batch_s;
        let count = rest.partition_point(|detection| detection.time_s < end_s);
        let (now, later) = rest.split_at(count);
        rest = later;
        let mut payloads = Vec::new();
        if radar.service_messages && end_s > next_service_s {
            payloads.push(service_block(
                radar,
                source,
                antenna,
                after(start, clock_s(radar, next_service_s)),
            ));
            next_service_s += service_s;
        }
        plots(radar, source, now, start, &mut payloads);
        // The first detection of a batch has waited longest.
        let shortest = radar.latency_s.low.min(radar.latency_s.high - batch_s).max(0.0);
        let longest = (radar.latency_s.high - batch_s).max(shortest);
        let delay_s = stream.within(Span::new(shortest, longest));
        for (place, payload) in payloads.into_iter().enumerate() {
            let arrives = after(start, end_s + delay_s + place as f64 * 1e-4);
            sent.push(SentDatagram { arrives, sensor, payload });
        }
    }
    sent
}

/// Appends blocks of plots, each as large as a datagram allows. The first follows the service message, if there is one.
fn plots(
    radar: &Radar,
    source: DataSource,
    detections: &[RadarDetection],
    start: Time,
    payloads: &mut Vec<Vec<u8>>,
) {
    let records: Vec<_> =
        detections.iter().filter_map(|detection| plot_record(radar, source, detection, start)).collect();
    let mut room = DATAGRAM_MAX - SERVICE_OCTETS;
    let mut block: Vec<cat048::Record> = Vec::new();
    let mut used = 0;
    let mut octets = Vec::new();
    let mut flush = |block: &mut Vec<cat048::Record>, first: bool| {
        let joined = if first { payloads.pop() } else { None };
        let mut payload = joined.unwrap_or_default();
        if encode_block(block, &mut payload).is_ok() {
            payloads.push(payload);
        }
        block.clear();
    };
    let mut first = true;
    for record in records {
        octets.clear();
        asterix::Record::encode_into(&record, &mut octets);
        if used + octets.len() + 3 > room {
            flush(&mut block, first);
            (first, used, room) = (false, 0, DATAGRAM_MAX);
        }
        used += octets.len();
        block.push(record);
    }
    if !block.is_empty() {
        flush(&mut block, first);
    }
}

/// Encodes a plot. `None` if CAT048 cannot represent a value, which cannot happen with a valid scenario.
fn plot_record(
    radar: &Radar,
    source: DataSource,
    detection: &RadarDetection,
    start: Time,
) -> Option<cat048::Record> {
    let probability = (detection.uav_probability * 255.0).round() as u8;
    let time = time_of_day(after(start, detection.stamped_s));
    let mut record = cat048::Record::builder(source, time, TargetReport::new(DetectionType::Primary))
        .polar_position(PolarPosition::new(detection.range_m, detection.azimuth_deg))
        .track_number(TrackNumber::new(detection.number))
        .special_purpose(Explicit::new(&[probability]));
    if radar.velocities {
        let (east, north) = detection.velocity;
        record = record.track_velocity(TrackVelocity::new(east.hypot(north), east.atan2(north).to_degrees()));
    }
    if radar.heights {
        record = record.height_3d(Height3D::from_metres(detection.altitude_amsl_m));
    }
    record.build().ok()
}

/// A north marker (CAT034) with rotation period, status and position.
fn service_block(radar: &Radar, source: DataSource, antenna: &Antenna, time: Time) -> Vec<u8> {
    let place = &antenna.position;
    let position = SourcePosition::default()
        .with_height_m(antenna.altitude_amsl_m)
        .and_then(|position| position.with_latitude_deg(place.latitude_deg()))
        .and_then(|position| position.with_longitude_deg(place.longitude_deg()));
    let kind = MessageType::default().with_kind(MessageKind::NorthMarker);
    let status = SystemStatus { common: Some(cat034::CommonStatus::default()), ..SystemStatus::default() };
    let record = cat034::Record::builder(source, kind, time_of_day(time))
        .rotation_period(RotationPeriod::default().with_period_s(radar.period_s))
        .system_status(status)
        .source_position(position)
        .build();
    let mut block = Vec::new();
    if let Ok(record) = record {
        encode_block(&[record], &mut block).unwrap_or_default();
    }
    block
}

/// A transponder's report as its receiver forwards it. The serial number is derived from the report's identity.
pub fn transponder_datagram(
    model: &Transponder,
    sensor: usize,
    ground: &Ground,
    report: &TransponderReport,
    start: Time,
) -> Option<SentDatagram> {
    let source = DataSource { sac: model.sac as u8, sic: model.sic as u8 };
    let place = ground.geodetic(&report.position);
    let rounded = |degrees: f64| match model.rounded_deg {
        0.0 => degrees,
        step_deg => (degrees / step_deg).round() * step_deg,
    };
    let position = Position::new(rounded(place.latitude_deg()), rounded(place.longitude_deg()));
    let time = time_of_day(after(start, report.stamped_s));
    let mut record = cat129::Record::builder(source, *b"GB", time, position)
        .manufacturer(*b"SIM")
        .model(*b"UAS")
        .serial_number(serial(report.identity))
        .altitude_amsl(Altitude::from_metres(ground.altitude_amsl_m(&report.position)));
    if let Some(accuracy_m) = report.accuracy_m {
        record = record.gnss_accuracy(GnssAccuracy::from_metres(accuracy_m));
    }
    if model.velocities {
        let velocity = report.velocity;
        record = record
            .horizontal_velocity(HorizontalVelocity::new(velocity.x, velocity.y))
            .vertical_velocity(VerticalVelocity::new(velocity.z));
    }
    let record = record.build().ok()?;
    let mut payload = Vec::new();
    encode_block(&[record], &mut payload).ok()?;
    Some(SentDatagram { arrives: after(start, report.arrives_s), sensor, payload })
}

/// Offset from a drone's number to the identity of its second transponder.
pub const SECOND_IDENTITY: usize = 100_000;

/// Number of a drone's transponder: its serial number, and its track number in the output.
pub fn transponder_number(drone: usize) -> u32 {
    drone as u32 + 1
}

/// Serial number of a transponder as text.
pub fn serial_text(drone: usize) -> String {
    format!("{:012}", transponder_number(drone))
}

fn serial(drone: usize) -> [u8; 12] {
    let mut serial = [b'0'; 12];
    let digits = transponder_number(drone).to_string();
    serial[12 - digits.len()..].copy_from_slice(digits.as_bytes());
    serial
}
