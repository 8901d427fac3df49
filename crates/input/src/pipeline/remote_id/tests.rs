use remote_id::{BasicId, IdType, UaType};

use super::*;
use crate::gateways::remote_id::LineRefusal;
use fusion::time::SECOND;
use remote_id::LENGTH;

fn at(seconds: i64) -> Time {
    Time::from_nanos((1_700_000_000 + seconds) * SECOND)
}

fn basic(id_type: IdType, id: &[u8]) -> Vec<u8> {
    Message::BasicId(BasicId::new(id_type, UaType::Rotorcraft, id)).octets().to_vec()
}

/// A Location message; its time is in tenths of a second after the hour.
fn location(tenths: u16) -> Vec<u8> {
    let mut octets = vec![0; LENGTH];
    octets[0] = 0x12;
    octets[5..9].copy_from_slice(&525_000_000_i32.to_le_bytes());
    octets[9..13].copy_from_slice(&(-5_880_000_i32).to_le_bytes());
    octets[21..23].copy_from_slice(&tenths.to_le_bytes());
    octets
}

fn from(transmitter: &str, octets: &[u8]) -> BroadcastLine {
    BroadcastLine {
        time: None,
        transmitter: transmitter.to_owned(),
        rssi_dbm: None,
        receiver: None,
        octets: octets.to_vec(),
    }
}

fn line(octets: &[u8]) -> String {
    format!(r#"{{"transmitter": "aa", "message": "{}"}}"#, crate::hex::text(octets))
}

#[test]
fn position_has_the_last_identity_of_its_transmitter() {
    let mut transmitters = Transmitters::default();
    let mut hear = |transmitter, octets: &[u8], seconds| {
        let mut said = transmitters.hear(&from(transmitter, octets), at(seconds));
        assert_eq!(said.len(), 1);
        said.remove(0)
    };
    assert_eq!(hear("aa", &location(1), 0), RemoteIdOutcome::Unused(Refusal::NoIdentity));
    assert_eq!(hear("aa", &basic(IdType::SerialNumber, b"ONE"), 1), RemoteIdOutcome::Identity);
    let one = Identity::new(b"ONE", None).unwrap();
    assert!(
        matches!(hear("aa", &location(2), 6), RemoteIdOutcome::Position(identity, ..) if identity == one)
    );
    assert_eq!(hear("aa", &location(2), 6), RemoteIdOutcome::Unused(Refusal::Repeated));
    assert_eq!(
        hear("bb", &location(3), 6),
        RemoteIdOutcome::Unused(Refusal::NoIdentity),
        "another transmitter"
    );
    assert_eq!(
        hear("aa", &location(3), 7),
        RemoteIdOutcome::Unused(Refusal::NoIdentity),
        "6 s after it said who it is"
    );
    hear("aa", &basic(IdType::SpecificSession, b"\x01XYZ"), 8);
    let session = Identity::of_name(fusion::report::Space::Session, b"\x01XYZ").unwrap();
    assert!(
        matches!(hear("aa", &location(4), 8), RemoteIdOutcome::Position(identity, ..) if identity == session)
    );
    hear("aa", &basic(IdType::SerialNumber, b"ONE"), 9);
    hear("aa", &basic(IdType::SpecificSession, b"\x01XYZ"), 9);
    assert!(
        matches!(hear("aa", &location(5), 9), RemoteIdOutcome::Position(identity, ..) if identity == one)
    );
}

#[test]
fn position_without_time_is_repeated_for_half_a_second() {
    let mut transmitters = Transmitters::default();
    let mut hear = |octets: &[u8], tenths: i64| {
        let now = Time::from_nanos(at(0).nanos() + tenths * SECOND / 10);
        transmitters.hear(&from("aa", octets), now).remove(0)
    };
    let unstamped = location(u16::MAX);
    let mut elsewhere = unstamped.clone();
    elsewhere[5] ^= 1;
    let repeated = RemoteIdOutcome::Unused(Refusal::Repeated);
    hear(&basic(IdType::Registration, b"FR1"), 0);
    let is_position = |said: &RemoteIdOutcome| matches!(said, RemoteIdOutcome::Position(..));
    assert!(is_position(&hear(&unstamped, 0)));
    assert_eq!(hear(&unstamped, 5), repeated);
    assert!(is_position(&hear(&unstamped, 10)), "it hovers");
    assert!(is_position(&hear(&unstamped, 20)));
    assert!(is_position(&hear(&elsewhere, 30)));
    assert_eq!(hear(&unstamped, 40), repeated, "a late copy of the place before");
    // With a time it is the same report.
    hear(&basic(IdType::Registration, b"FR1"), 45);
    assert!(is_position(&hear(&location(1), 50)));
    assert_eq!(hear(&location(1), 60), repeated);
}

#[test]
fn pack_may_have_identity_before_or_after_position() {
    let mut pack = vec![0xf2, LENGTH as u8, 2];
    pack.extend(location(1));
    pack.extend(basic(IdType::SerialNumber, b"ONE"));
    let mut transmitters = Transmitters::default();
    let said = transmitters.hear(&from("aa", &pack), at(0));
    assert!(matches!(said[..], [RemoteIdOutcome::Position(..), RemoteIdOutcome::Identity]), "{said:?}");
    pack.truncate(3 + LENGTH + 4);
    pack[2 + LENGTH] ^= 1;
    let said = transmitters.hear(&from("aa", &pack), at(1));
    assert!(matches!(said[..], [RemoteIdOutcome::Position(..), RemoteIdOutcome::Faulty(_)]), "{said:?}");
}

#[test]
fn declarations_of_a_transmitter_go_with_its_positions() {
    use remote_id::{System, SystemContent};
    let content = SystemContent {
        location_type: 1,
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
    let mut registration = vec![0; LENGTH];
    registration[0] = 0x52;
    registration[2..9].copy_from_slice(b"FIN87AB");
    let mut transmitters = Transmitters::default();
    let mut hear = |octets: &[u8], seconds| transmitters.hear(&from("aa", octets), at(seconds)).remove(0);
    assert_eq!(hear(Message::System(System::new(&content)).octets(), 0), RemoteIdOutcome::Identity);
    assert_eq!(hear(&registration, 0), RemoteIdOutcome::Identity);
    hear(&basic(IdType::SerialNumber, b"ONE"), 1);
    let RemoteIdOutcome::Position(_, _, declared) = hear(&location(1), 1) else { panic!() };
    let operator = declared.operator.unwrap();
    assert_eq!(
        (operator.place, operator.half_metres, operator.kind),
        ([525_001_000, -5_801_000], Some(225), 1)
    );
    assert_eq!((&declared.operator_id[..8], declared.ua_type), (&b"FIN87AB\0"[..], Some(2)));
    // A different aircraft has a different operator.
    hear(&basic(IdType::SerialNumber, b"TWO"), 2);
    let RemoteIdOutcome::Position(_, _, declared) = hear(&location(2), 2) else { panic!() };
    assert_eq!((declared.operator, declared.operator_id, declared.ua_type), (None, [0; 20], Some(2)));
}

#[test]
fn invalid_line_does_not_affect_its_neighbours() {
    let good = line(&location(1));
    let bad = [
        ("{", LineFault::Line(LineRefusal::NotAnObject)),
        (r#"{"message": "00"}"#, LineFault::Line(LineRefusal::NotAnObject)),
        (r#"{"transmitter": "aa", "message": "0g"}"#, LineFault::Line(LineRefusal::NotHexadecimal)),
        (r#"{"transmitter": "", "message": "00"}"#, LineFault::Line(LineRefusal::Name)),
        (r#"{"transmitter": "aa", "message": "00", "time": "noon"}"#, LineFault::Line(LineRefusal::Time)),
        (r#"{"transmitter": "aa", "message": "00", "time": 1e300}"#, LineFault::Line(LineRefusal::Time)),
    ];
    for (text, fault) in bad {
        let datagram = format!("{good}\n{text}\n\n{good}\r\n");
        let heard = heard(datagram.as_bytes(), None).unwrap();
        assert!(heard[0].is_ok() && heard[2].is_ok() && heard.len() == 3, "{text}");
        assert_eq!(heard[1], Err(fault), "{text}");
    }
}

#[test]
fn line_may_state_time_and_sender() {
    let text = r#"{"time": "2026-11-22T10:00:00.5Z", "transmitter": "aa", "rssi": -61, "receiver": "roof", "message": "00"}"#;
    let heard_at = heard(text.as_bytes(), None).unwrap().remove(0).unwrap();
    assert_eq!(heard_at.receiver.as_deref(), Some("roof"));
    assert_eq!(heard_at.time.unwrap().nanos(), 1_795_341_600_500_000_000);
    let text = r#"{"time": 1700000000.25, "transmitter": "aa", "message": "00"}"#;
    let stamped = heard(text.as_bytes(), None).unwrap().remove(0).unwrap().time.unwrap();
    assert_eq!(stamped, Time::from_nanos(at(0).nanos() + SECOND / 4));
}

#[test]
fn remote_id_is_distinguished_from_asterix() {
    assert!(is_broadcast(&location(1)) && is_broadcast(&basic(IdType::SerialNumber, b"ONE")));
    let mut pack = vec![0xf2, LENGTH as u8, 1];
    pack.extend(location(1));
    assert!(is_broadcast(&pack) && !is_broadcast(&pack[..27]));
    // A block of CAT048 with 25 octets resembles a Self-ID message of the first version.
    let mut block = vec![0; LENGTH];
    block[..3].copy_from_slice(&[0x30, 0, 25]);
    assert!(!is_broadcast(&block) && !is_broadcast(&[]) && !is_lines(&block));
}

proptest::proptest! {
    #[test]
    fn any_datagram_is_read_or_ignored(octets in proptest::collection::vec(proptest::num::u8::ANY, 0..200), text in "\\{.{0,80}") {
        let mut transmitters = Transmitters::default();
        for datagram in [&octets[..], text.as_bytes()] {
            for heard in heard(datagram, None).into_iter().flatten().flatten() {
                transmitters.hear(&heard, at(0));
            }
        }
    }
}
