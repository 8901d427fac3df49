//! Recorded transmissions, message by message, compared with the reference decoder (opendroneid-core-c).
//!
//! Enabled by `UTM_FUSION_SHARED_DATA`, the folder of the recordings.

#![expect(
    clippy::unwrap_used,
    clippy::disallowed_methods,
    reason = "a test that cannot go on fails; recordings are files"
)]

use std::fs;
use std::io::Read;
use std::path::{Path, PathBuf};

use pcap_parser::{LegacyPcapSlice, PcapBlockOwned, PcapNGSlice};
use remote_id::{
    Fault, HeightAbove, Link, Location, Message, NotHeard, Status, Transport, advertisements, messages,
};
use serde_json::{Value, json};

fn folder() -> Option<PathBuf> {
    let folder =
        std::env::var_os("UTM_FUSION_SHARED_DATA").map(|data| Path::new(&data).join("remote-id-radio"));
    if folder.is_none() {
        eprintln!("skipped: UTM_FUSION_SHARED_DATA names no recordings");
    }
    folder
}

/// The frames of a capture.
fn frames(path: &Path) -> Vec<Vec<u8>> {
    let octets = fs::read(path).unwrap();
    if path.extension().unwrap() == "pcap" {
        let all = LegacyPcapSlice::from_slice(&octets).unwrap().map(Result::unwrap);
        return all
            .filter_map(|block| match block {
                PcapBlockOwned::Legacy(block) => Some(block.data.to_vec()),
                _ => None,
            })
            .collect();
    }
    let all = PcapNGSlice::from_slice(&octets).unwrap().map(Result::unwrap);
    all.filter_map(|block| match block {
        PcapBlockOwned::NG(pcap_parser::Block::EnhancedPacket(packet)) => {
            Some(packet.data[..packet.caplen as usize].to_vec())
        }
        _ => None,
    })
    .collect()
}

/// The output of the reference decoder, one advertisement per line.
fn lines(path: &Path) -> Vec<Value> {
    let mut text = String::new();
    flate2::read::GzDecoder::new(fs::File::open(path).unwrap()).read_to_string(&mut text).unwrap();
    text.lines().map(|line| serde_json::from_str(line).unwrap()).collect()
}

/// A message with the fields of the reference decoder.
fn as_decoded(message: &Message) -> Value {
    let id_hex = |octets: &[u8]| octets.iter().map(|octet| format!("{octet:02x}")).collect::<String>();
    match message {
        Message::BasicId(id) => json!({ "type": 0, "id_hex": id_hex(id.id_octets()) }),
        Message::Location(location) => location_as_decoded(location),
        Message::Authentication(_) => json!({ "type": 2 }),
        Message::SelfId(_) => json!({ "type": 3 }),
        Message::System(system) => {
            let [latitude, longitude] = system.operator_deg();
            json!({
                "type": 4, "op_lat": latitude, "op_lon": longitude,
                "area_count": system.area_count(), "area_radius": system.area_radius_m(),
            })
        }
        Message::OperatorId(operator) => json!({ "type": 5, "op_id_hex": id_hex(operator.id()) }),
    }
}

fn location_as_decoded(location: &Location) -> Value {
    let status = match location.status() {
        Status::Undeclared => 0,
        Status::Ground => 1,
        Status::Airborne => 2,
        Status::Emergency => 3,
        Status::SystemFailure => 4,
        Status::Reserved(number) => number,
    };
    let [latitude, longitude] = location.place_deg();
    json!({
        "type": 1, "status": status, "lat": latitude, "lon": longitude,
        "direction": location.course_deg().unwrap_or(361.0),
        "speed_h": location.speed_m_s().unwrap_or(255.0),
        "speed_v": location.climb_m_s().unwrap_or(63.0),
        "alt_baro": location.pressure_altitude_m().unwrap_or(-1000.0),
        "alt_geo": location.geodetic_altitude_m().unwrap_or(-1000.0),
        "height": location.height_m().map_or(-1000.0, |(metres, _)| metres),
        "timestamp": location.seconds_of_hour().unwrap_or(f64::NAN),
    })
}

/// Whether all fields of `ours` are equal in `theirs`.
fn agree(ours: &Value, theirs: &Value) -> bool {
    ours.as_object().unwrap().iter().all(|(name, ours)| match (ours.as_f64(), theirs[name].as_f64()) {
        (Some(ours), Some(theirs)) => (ours - theirs).abs() < 1e-6,
        _ if name == "op_id_hex" => theirs[name].as_str().unwrap().starts_with(ours.as_str().unwrap()),
        _ => *ours == theirs[name],
    })
}

#[test]
fn every_message_is_read_as_the_reference_decoder_reads_it() {
    let Some(folder) = folder() else { return };
    for (name, extension, link, heard, compared) in [
        ("parrot-anafi-wifi-60s", "pcap", Link::Radiotap, 559, 1_120),
        ("test-transmitter-wifi-beacon", "pcap", Link::Radiotap, 21, 105),
        ("test-transmitter-wifi-nan", "pcap", Link::Radiotap, 42, 42),
        ("ble5-long-range-9s", "pcapng", Link::NordicBle, 167, 684),
    ] {
        let frames = frames(&folder.join(name).with_extension(extension));
        let lines = lines(&folder.join(format!("{name}.ndjson.gz")));
        let (mut lines, mut said, mut same, mut damaged) = (lines.iter(), 0, 0, 0);
        for frame in &frames {
            let said_by = match advertisements(link, frame).as_deref() {
                Ok([advertisement]) => advertisement.clone(),
                Ok(several) => panic!("{name}: {several:?}"),
                Err(NotHeard::Damaged) => {
                    damaged += 1;
                    continue;
                }
                Err(_) => continue,
            };
            let transmitter: Vec<String> =
                said_by.transmitter.iter().map(|octet| format!("{octet:02x}")).collect();
            // The reference decoder also reads frames with a wrong checksum.
            let hex: String = said_by.octets.iter().map(|octet| format!("{octet:02x}")).collect();
            let line = lines
                .find(|line| {
                    line["counter"] == said_by.counter && hex.starts_with(line["message"].as_str().unwrap())
                })
                .unwrap_or_else(|| panic!("{name}: {hex}"));
            said += 1;
            assert_eq!(line["transmitter"], transmitter.join(":"));
            let transport = match said_by.transport {
                Transport::WifiBeacon => "wifi-beacon",
                Transport::WifiFrench => "wifi-french",
                Transport::WifiNan => "wifi-nan",
                Transport::Bluetooth => "ble",
            };
            assert_eq!(line["transport"], transport);
            let theirs = line["decoded"].as_array().unwrap();
            let ours: Vec<_> = messages(&said_by.octets).collect();
            if theirs.is_empty() {
                assert!(matches!(ours[..], [Err(Fault::PackCount { count: 0 })]), "{ours:?}");
                continue;
            }
            assert_eq!(ours.len(), theirs.len(), "{hex}");
            for (ours, theirs) in ours.iter().zip(theirs) {
                let ours = ours.unwrap_or_else(|fault| panic!("{name}: {fault}: {theirs}"));
                assert!(agree(&as_decoded(&ours), theirs), "{name}: {:?}\n{theirs}", as_decoded(&ours));
                assert_eq!(u64::from(ours.version()), theirs["version"]);
                same += 1;
            }
        }
        eprintln!("{name}: {} frames, {said} heard, {damaged} damaged, {same} messages", frames.len());
        assert_eq!((said, same), (heard, compared), "{name}");
    }
}

#[test]
fn heights_of_the_emulator_are_above_its_take_off() {
    let Some(folder) = folder() else { return };
    let frames = frames(&folder.join("test-transmitter-wifi-beacon.pcap"));
    let said = advertisements(Link::Radiotap, &frames[0]).unwrap();
    let location = messages(&said[0].octets).find_map(|message| match message {
        Ok(Message::Location(location)) => Some(location),
        _ => None,
    });
    let location = location.unwrap();
    assert_eq!(location.height_m(), Some((100.0, HeightAbove::TakeOff)));
    assert_eq!((location.accuracy_h_m(), location.accuracy_v_m()), (Some(30.0), Some(25.0)));
    assert_eq!((location.accuracy_speed_m_s(), location.accuracy_time_s()), (Some(10.0), Some(1.0)));
    assert_eq!(location.accuracy_pressure_m(), Some(10.0));
}
