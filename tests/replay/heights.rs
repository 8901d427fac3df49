//! Remote ID in every output format: unmeasured heights, binary identities, and declarations of a drone.

use std::fmt::Write;

use asterix::{blocks, cat062, cat129};
use fusion::time::{SECOND, Time};
use remote_id::{
    BasicId, HeightAbove, IdType, LENGTH, Location, LocationContent, Message, Status, System, SystemContent,
    UaType, pack,
};
use serde_json::Value;

use super::common::{Scratch, pcap, ran, utm_fusion};
use super::parquet_file::rows;

const SITE: &str = r#"
[site]
name = "field"
sac = 25
sic = 1
latitude_deg = 52.5
longitude_deg = -0.58
height_amsl_m = 60.0

[[sensors]]
id = "rid"
kind = "remote-id"
sac = 25
sic = 2
"#;

/// Time of the first report, whole seconds since 1970: a full hour.
const START_S: i64 = 1_700_002_800;

/// Lines of a gateway: each second, a message pack with identity and position of each drone, which flies east. The
/// height is known from `known_from_s` on.
fn lines(drones: &[(IdType, &[u8])], seconds: u16, known_from_s: u16) -> String {
    let height = |second, content| LocationContent {
        geodetic_altitude_m: (second >= known_from_s).then_some(180.0),
        ..content
    };
    sent(drones, seconds, height, &[])
}

/// Lines of a gateway with modified positions and further messages.
fn sent(
    drones: &[(IdType, &[u8])],
    seconds: u16,
    change: impl Fn(u16, LocationContent) -> LocationContent,
    more: &[Message],
) -> String {
    let mut text = String::new();
    for second in 0..seconds {
        for (drone, (id_type, id)) in drones.iter().enumerate() {
            let content = LocationContent {
                status: Status::Airborne,
                course_deg: Some(90.0),
                speed_m_s: Some(8.0),
                climb_m_s: Some(0.0),
                place_deg: Some([52.51 + 0.002 * drone as f64, -0.58 + f64::from(second) * 1.18e-4]),
                pressure_altitude_m: None,
                geodetic_altitude_m: None,
                height_m: None,
                accuracy_h_m: Some(10.0),
                accuracy_v_m: None,
                accuracy_pressure_m: None,
                accuracy_speed_m_s: None,
                seconds_of_hour: Some(f64::from(second)),
                accuracy_time_s: None,
            };
            let own = BasicId::new(*id_type, UaType::Rotorcraft, id);
            let position = Location::new(&change(second, content));
            let mut messages = vec![Message::BasicId(own), Message::Location(position)];
            messages.extend(more);
            let octets = pack(&messages).unwrap();
            let digits: String = octets.iter().map(|octet| format!("{octet:02x}")).collect();
            let time = START_S + i64::from(second);
            writeln!(
                text,
                r#"{{"time":{time},"transmitter":"02:00:00:00:00:{drone:02x}","message":"{digits}"}}"#
            )
            .unwrap();
        }
    }
    text
}

/// A capture of the lines, each in a datagram received half a second after its time.
fn capture(lines: &str) -> Vec<u8> {
    let received = |line: &str| {
        let line: Value = serde_json::from_str(line).unwrap();
        Time::from_nanos(line["time"].as_i64().unwrap() * SECOND + SECOND / 2)
    };
    pcap(lines.lines().map(|line| (received(line), line.as_bytes())))
}

/// Output of `replay` for the lines, in a format.
fn replayed(lines: &str, format: &str) -> Vec<u8> {
    let scratch = Scratch::new();
    let (site, input) = (scratch.file("site.toml", SITE), scratch.file("in.pcap", capture(lines)));
    let mut command = utm_fusion("replay");
    command.arg(input).arg("--config").arg(site);
    let ran = ran(command.args(["-o", "-", "--output-format", format]));
    assert_eq!(ran.code, 0, "{}", ran.stderr);
    ran.stdout
}

fn tracks(lines: &str) -> Vec<Value> {
    let text = String::from_utf8(replayed(lines, "ndjson")).unwrap();
    text.lines().map(|line| serde_json::from_str(line).unwrap()).collect()
}

fn members(value: &Value, names: &[&str]) -> Vec<String> {
    names.iter().filter(|name| value.get(**name).is_some()).map(|name| (*name).to_owned()).collect()
}

#[test]
fn unmeasured_height_is_absent_in_every_format() {
    let lines = lines(&[(IdType::SerialNumber, b"1581F5WIFIODID000001")], 40, u16::MAX);
    let points = tracks(&lines);
    assert!(points.len() > 150, "{}", points.len());
    for point in &points {
        let none = members(point, &["alt", "alt_msl", "vertical_speed", "accuracy_v_m", "accuracy_v"]);
        assert!(none.is_empty(), "{point}");
    }
    for row in rows(replayed(&lines, "parquet")) {
        let none: Vec<_> =
            row.keys().filter(|name| name.contains("height_e") || name.contains("altitude")).collect();
        assert!(none.is_empty(), "{row:?}");
    }
    let csv = String::from_utf8(replayed(&lines, "csv")).unwrap();
    for line in csv.lines().skip(1) {
        assert_eq!(line.split(',').nth(8), Some(""), "{line}");
    }
    let collection: Value = serde_json::from_slice(&replayed(&lines, "geojson")).unwrap();
    for feature in collection["features"].as_array().unwrap() {
        assert_eq!(feature["geometry"]["coordinates"].as_array().unwrap().len(), 2, "{feature}");
    }
    let mcap = String::from_utf8_lossy(&replayed(&lines, "mcap")).into_owned();
    assert!(mcap.contains("accuracy_h_m") && !mcap.contains("alt_msl"), "{mcap}");
    let octets = replayed(&lines, "asterix");
    let mut records = 0;
    for block in blocks(&octets).map(Result::unwrap).filter(|block| block.category == 129) {
        for located in block.records::<cat129::Record>() {
            let record = located.unwrap().record;
            assert!(record.altitude_amsl.is_none() && record.vertical_velocity.is_none(), "{record:?}");
            records += 1;
        }
    }
    assert_eq!(records, points.len());
    let octets = replayed(&lines, "cat062");
    let mut records = 0;
    for block in blocks(&octets).map(Result::unwrap) {
        for located in block.records::<cat062::Record>() {
            let record = located.unwrap().record;
            let accuracies = record.accuracies.as_ref();
            assert!(record.geometric_altitude.is_none() && record.climb_rate.is_none(), "{record:?}");
            assert!(accuracies.is_none_or(|known| known.geometric.is_none() && known.climb.is_none()));
            records += 1;
        }
    }
    assert!(records >= points.len());
}

#[test]
fn height_measured_later_is_published_from_then_on() {
    let points = tracks(&lines(&[(IdType::SerialNumber, b"1581F5WIFIODID000001")], 60, 30));
    let known: Vec<bool> = points.iter().map(|point| point.get("alt").is_some()).collect();
    let first = known.iter().position(|known| *known).unwrap();
    assert!(known[first..].iter().all(|known| *known), "{known:?}");
    assert!((80..=125).contains(&first), "{first}");
    for point in &points[first..] {
        assert!((point["alt"].as_f64().unwrap() - 180.0).abs() < 15.0, "{point}");
    }
}

#[test]
fn binary_identities_with_blank_octets_are_two_drones() {
    let one = b"\x00\x11\xaa\x11\xbb\x22\xcc\x43\x4d\x8d\x00\x11\x22\x33\x44\x55";
    let other = b"\x11\xaa\x11\xbb\x22\xcc\x43\x4d\x8d\x00\x11\x22\x33\x44\x55\x00";
    let blank = b"\x20\xaa\x11\xbb\x22\xcc\x43\x4d\x8d\x00\x11\x22\x33\x44\x55\x20";
    let drones = [one, other, blank].map(|id| (IdType::UtmAssigned, &id[..]));
    let points = tracks(&lines(&drones, 30, 0));
    let seen: std::collections::BTreeSet<_> =
        points.iter().map(|point| point["uas_id"]["utm_id"].as_str().unwrap().to_owned()).collect();
    let expected = [
        "0011aa11-bb22-cc43-4d8d-001122334455",
        "11aa11bb-22cc-434d-8d00-112233445500",
        "20aa11bb-22cc-434d-8d00-112233445520",
    ];
    assert_eq!(seen.into_iter().collect::<Vec<_>>(), expected);
    let sessions = [&b"\x01\x20abc\x00"[..], &b"\x01\x20abc\x20"[..]].map(|id| (IdType::SpecificSession, id));
    let points = tracks(&lines(&sessions, 30, 0));
    let ids: std::collections::BTreeSet<_> = points.iter().map(|point| point["id"].to_string()).collect();
    assert_eq!(ids.len(), 2, "{ids:?}");
}

#[test]
fn declarations_are_published_and_an_emergency_is_an_alert() {
    let operator = SystemContent {
        location_type: 0,
        classification: 0,
        operator_deg: Some([52.5001, -0.5801]),
        area_count: 1,
        area_radius_m: 0.0,
        area_ceiling_m: None,
        area_floor_m: None,
        category_and_class: [0, 0],
        operator_altitude_m: Some(112.5),
        time_s: 0,
    };
    let mut registration = [0; LENGTH];
    registration[0] = 0x52;
    registration[2..9].copy_from_slice(b"FIN87AB");
    let more = [Message::System(System::new(&operator)), Message::new(registration).unwrap()];
    let change = |second, content| LocationContent {
        status: if (20..30).contains(&second) { Status::Emergency } else { Status::Airborne },
        height_m: Some((55.5, HeightAbove::TakeOff)),
        ..content
    };
    let lines = sent(&[(IdType::SerialNumber, b"1581F5WIFIODID000001")], 60, change, &more);
    let points = tracks(&lines);
    let declared = &points[points.len() / 4]["remote_id"];
    let expected = serde_json::json!({
        "ua_type": "Helicopter",
        "operational_status": "Airborne",
        "height": { "distance": 55.5, "reference": "TakeoffLocation" },
        "operator_id": "FIN87AB",
        "operator_location": { "lat": 52.5001, "lng": -0.5801, "alt": 112.5, "type": "Takeoff" },
    });
    assert_eq!(*declared, expected);
    let status = |point: &Value| point["remote_id"]["operational_status"] == "Emergency";
    assert!((30..60).contains(&points.iter().filter(|point| status(point)).count()));

    let scratch = Scratch::new();
    let (site, input) = (scratch.file("site.toml", SITE), scratch.file("in.pcap", capture(&lines)));
    let alerts = scratch.path("alerts.ndjson");
    let ran = ran(utm_fusion("replay").arg(input).arg("--config").arg(site).arg("--alerts").arg(&alerts));
    assert_eq!(ran.code, 0, "{}", ran.stderr);
    let text = String::from_utf8(std::fs::read(alerts).unwrap()).unwrap();
    let alerts: Vec<Value> = text.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    let of_kind: Vec<&Value> = alerts.iter().filter(|alert| alert["kind"] == "emergency").collect();
    assert_eq!(of_kind.len(), 2, "{text}");
    assert_eq!((&of_kind[0]["severity"], of_kind[0].get("until")), (&"critical".into(), None));
    assert_eq!(of_kind[0]["identity"], "1581F5WIFIODID000001");
    assert_eq!(of_kind[0]["track_id"], points[0]["id"]);
    assert!(of_kind[1]["until"].is_string());
}

#[test]
fn pressure_altitude_alone_is_a_height_within_300_m() {
    let change = |_, content| LocationContent { pressure_altitude_m: Some(150.0), ..content };
    let points = tracks(&sent(&[(IdType::SerialNumber, b"1581F5WIFIODID000001")], 40, change, &[]));
    for point in &points {
        let [alt_msl, accuracy] = ["alt_msl", "accuracy_v_m"].map(|name| point[name].as_f64().unwrap());
        assert!((alt_msl - 150.0).abs() < 5.0 && (250.0..400.0).contains(&accuracy), "{point}");
    }
}
