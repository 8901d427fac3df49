//! Remote ID messages as JSON, with the names of ASTM F3411-22a and units in the keys of numbers. Values that the standard calls
//! unknown are `null`.

use remote_id::{BasicId, HeightAbove, IdType, Location, Message, Status, UaType, messages};
use serde_json::{Value, json};

use super::{Error, Place, Tree, close_line, number, open_line, text as write_text, write_error};
use crate::gateways::remote_id::BroadcastLine as GatewayLine;
use crate::hex;

/// Kind of error for octets or a line without a message.
pub const REMOTE_ID: &str = "remote-id";

/// Appends a line for each message of a gateway's line. A faulty message becomes an error line, and its fault is passed to
/// `note`.
pub fn write_messages<O: Tree>(
    out: &mut O,
    line: &GatewayLine,
    received: Option<fusion::time::Time>,
    place: Place<'_>,
    errors_only: bool,
    mut note: impl FnMut(&mut O, Result<(), String>),
) {
    for message in messages(&line.octets) {
        match message {
            Ok(message) => {
                if errors_only {
                    continue;
                }
                open_line(out, line.time.or(received), place, None);
                write_text(out, "transmitter", &line.transmitter);
                if let Some(rssi_dbm) = line.rssi_dbm {
                    out.member("rssi_dbm", &json!(rssi_dbm));
                }
                if let Some(receiver) = &line.receiver {
                    write_text(out, "receiver", receiver);
                }
                let (name, fields) = fields(&message);
                write_text(out, "message", name);
                number(out, "version", message.version().into());
                for (key, value) in fields.as_object().into_iter().flatten() {
                    out.member(key, value);
                }
                close_line(out);
                note(out, Ok(()));
            }
            Err(fault) => {
                write_refused(out, &fault.to_string(), &line.octets, place);
                note(out, Err(fault.to_string()));
            }
        }
    }
}

/// Appends the line of octets without a message, or of an invalid gateway line.
pub fn write_refused(out: &mut impl Tree, detail: &str, octets: &[u8], place: Place<'_>) {
    let error = Error { kind: REMOTE_ID, offset: place.offset, item: None, detail: detail.to_owned() };
    write_error(out, &error, place, None, octets);
}

/// Name and fields of a message.
fn fields(message: &Message) -> (&'static str, Value) {
    match message {
        Message::BasicId(basic) => (
            "basic_id",
            json!({ "id_type": id_type(basic.id_type()), "ua_type": ua_type(basic.ua_type()), "uas_id": uas_id(basic) }),
        ),
        Message::Location(location) => ("location", location_fields(location)),
        Message::Authentication(octets) => ("authentication", json!({ "hex": hex::text(octets) })),
        Message::SelfId(own) => ("self_id", json!({ "description": text(own.words()) })),
        Message::System(system) => {
            let [latitude, longitude] = system.operator_deg();
            let fields = json!({
                "operator_latitude_deg": degrees(latitude), "operator_longitude_deg": degrees(longitude),
                "area_count": system.area_count(), "area_radius_m": system.area_radius_m(),
            });
            ("system", fields)
        }
        Message::OperatorId(operator) => ("operator_id", json!({ "operator_id": text(operator.id()) })),
    }
}

fn location_fields(location: &Location) -> Value {
    let [latitude, longitude] = location.place_deg();
    let (height_m, above) = location.height_m().unzip();
    let height_type = above.map(|above| match above {
        HeightAbove::TakeOff => "take-off",
        HeightAbove::Ground => "ground",
    });
    // A tenth has no exact double.
    let tenth = |seconds: f64| (seconds * 10.0).round() / 10.0;
    json!({
        "operational_status": status(location.status()),
        "latitude_deg": degrees(latitude),
        "longitude_deg": degrees(longitude),
        "track_direction_deg": location.course_deg(),
        "speed_m_s": location.speed_m_s(),
        "vertical_speed_m_s": location.climb_m_s(),
        "pressure_altitude_m": location.pressure_altitude_m(),
        "geodetic_altitude_m": location.geodetic_altitude_m(),
        "height_m": height_m,
        "height_type": height_type,
        "horizontal_accuracy_m": location.accuracy_h_m(),
        "vertical_accuracy_m": location.accuracy_v_m(),
        "baro_altitude_accuracy_m": location.accuracy_pressure_m(),
        "speed_accuracy_m_s": location.accuracy_speed_m_s(),
        "timestamp_s": location.seconds_of_hour().map(tenth),
        "timestamp_accuracy_s": location.accuracy_time_s().map(tenth),
    })
}

/// Degrees with seven decimals, as sent.
fn degrees(degrees: f64) -> f64 {
    (degrees * 1e7).round() / 1e7
}

/// Identity: text if it is printable ASCII. Binary kinds are always hexadecimal.
fn uas_id(basic: &BasicId) -> Value {
    match basic.id_type() {
        IdType::UtmAssigned | IdType::SpecificSession => json!({ "hex": hex::text(basic.id()) }),
        _ => text(basic.id()),
    }
}

fn text(octets: &[u8]) -> Value {
    let is_printable = |octet: &u8| (b' '..=b'~').contains(octet);
    match str::from_utf8(octets) {
        Ok(text) if octets.iter().all(is_printable) => json!(text),
        _ => json!({ "hex": hex::text(octets) }),
    }
}

fn id_type(id_type: IdType) -> Value {
    match id_type {
        IdType::None => json!("none"),
        IdType::SerialNumber => json!("serial-number"),
        IdType::Registration => json!("registration"),
        IdType::UtmAssigned => json!("utm-assigned"),
        IdType::SpecificSession => json!("specific-session"),
        IdType::Reserved(number) => json!(number),
    }
}

fn ua_type(ua_type: UaType) -> Value {
    match ua_type {
        UaType::None => json!("none"),
        UaType::Aeroplane => json!("aeroplane"),
        UaType::Rotorcraft => json!("rotorcraft"),
        UaType::HybridLift => json!("hybrid-lift"),
        UaType::Other(number) => json!(number),
    }
}

fn status(status: Status) -> Value {
    match status {
        Status::Undeclared => json!("undeclared"),
        Status::Ground => json!("ground"),
        Status::Airborne => json!("airborne"),
        Status::Emergency => json!("emergency"),
        Status::SystemFailure => json!("system-failure"),
        Status::Reserved(number) => json!(number),
    }
}
