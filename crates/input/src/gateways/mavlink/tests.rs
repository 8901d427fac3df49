use asterix::blocks;
use asterix::cat129::WholeSerial;
use proptest::prelude::*;

use super::*;

const SOURCE: DataSource = DataSource { sac: 25, sic: 31 };
const NOON: Time = Time::from_nanos(1_800_014_400_000_000_000);

fn translator() -> MavlinkTranslator {
    let system = KnownSystem { manufacturer: Some(*b"ACM"), ..KnownSystem::new("DRONE-7").unwrap() };
    let drones = Some((SOURCE, BTreeMap::from([(7, system)])));
    MavlinkTranslator::new(MavlinkSensors { drones, ..MavlinkSensors::default() })
}

/// Encodes a frame.
fn frame(version: u8, flags: u8, system: u8, message: u32, contents: &[u8]) -> Vec<u8> {
    let [low, middle, high, _] = message.to_le_bytes();
    let length = contents.len() as u8;
    let mut frame = match version {
        1 => vec![VERSION_1, length, 9, system, 1, low],
        _ => vec![VERSION_2, length, flags, 0, 9, system, 1, low, middle, high],
    };
    frame.extend(contents);
    let seed = if message == HEARTBEAT.0 { HEARTBEAT.1 } else { GLOBAL_POSITION_INT.1 };
    let checksum = calculate_crc(&frame[1..], seed);
    frame.extend(checksum.to_le_bytes());
    if version == 2 && flags & SIGNED != 0 {
        frame.extend([0xfd; SIGNATURE]);
    }
    frame
}

fn position(latitude: i32, longitude: i32) -> Vec<u8> {
    let mut contents = 5000_u32.to_le_bytes().to_vec();
    [latitude, longitude, 123_400, 50_000].iter().for_each(|value| contents.extend(value.to_le_bytes()));
    [1250_i16, -300, -150].iter().for_each(|value| contents.extend(value.to_le_bytes()));
    contents.extend(35_000_u16.to_le_bytes());
    contents
}

fn records(translator: &mut MavlinkTranslator, octets: &[u8]) -> Vec<Record> {
    let mut records = Vec::new();
    translator.take(octets, NOON, |datagram| {
        let block = blocks(&datagram).next().unwrap().unwrap();
        records.extend(block.records::<Record>().map(|located| located.unwrap().record));
    });
    let counts = translator.counts();
    assert_eq!(counts.frames, counts.translated + counts.heartbeats + counts.dropped.total());
    records
}

/// A HEARTBEAT of an ArduPilot simulation, octet by octet, with its checksum from pymavlink.
#[test]
fn checksum_matches_other_implementations() {
    // mavutil: type 2, autopilot 3, base_mode 81, custom_mode 0, status 3, version 3.
    let octets = [0, 0, 0, 0, 2, 3, 81, 3, 3];
    // CRC-16/MCRF4XX of "123456789" is 0x6f91; the seed is processed like a further octet.
    assert_eq!(calculate_crc(b"12345678", b'9'), 0x6f91);
    let mut translator = translator();
    records(&mut translator, &frame(1, 0, 7, 0, &octets));
    assert_eq!(translator.counts().heartbeats, 1);
}

#[test]
fn position_is_translated_in_both_versions() {
    let contents = position(500_000_000, 80_000_000);
    // A frame of version 2 omits the heading of 0 at its end.
    let short = [&contents[..26], &[0, 0]].concat();
    let frames = [
        frame(1, 0, 7, 33, &contents),
        frame(2, 0, 7, 33, &contents),
        frame(2, SIGNED, 7, 33, &contents),
        frame(2, 0, 7, 33, &short[..26]),
    ];
    let mut translator = translator();
    let records = records(&mut translator, &frames.concat());
    assert_eq!((records.len(), translator.counts().signed, translator.counts().outside), (4, 1, 0));
    for record in records {
        assert_eq!(record.data_source, Some(SOURCE));
        assert_eq!(record.serial_number, Some(*b"DRONE-7     "));
        assert_eq!(
            (record.manufacturer, record.model, record.registration_country),
            (Some(*b"ACM"), None, Some(*b"ZZ"))
        );
        let place = record.position.unwrap();
        assert!((place.latitude_deg() - 50.0).abs() < 1e-6 && (place.longitude_deg() - 8.0).abs() < 1e-6);
        assert_eq!(record.altitude_amsl.unwrap().metres(), 123.4);
        let velocity = record.horizontal_velocity.unwrap();
        assert_eq!((velocity.east_m_s(), velocity.north_m_s()), (-3.0, 12.5));
        assert_eq!(record.vertical_velocity.unwrap().up_m_s(), 1.5);
        assert_eq!(record.time_of_day.unwrap().seconds(), 43_200.0);
    }
}

#[test]
fn dropped_frames_are_counted_by_reason() {
    let good = position(500_000_000, 80_000_000);
    let mut damaged = frame(2, 0, 7, 33, &good);
    damaged[14] ^= 4;
    let mut translator = translator();
    for octets in [
        damaged,
        frame(2, 0, 8, 33, &good),
        frame(2, 0, 7, 33, &position(0, 0)),
        frame(2, 0, 7, 33, &position(910_000_000, 0)),
        frame(2, 2, 7, 33, &good),
        frame(2, 0, 7, 30, &good),
        frame(1, 0, 7, 33, &good)[..20].to_vec(),
    ] {
        assert!(records(&mut translator, &octets).is_empty());
    }
    let expected =
        "1 cut, 1 checksum, 1 incompatible, 1 other_message, 1 unknown_system, 1 no_position, 1 out_of_range";
    assert_eq!(translator.counts().dropped.to_string(), expected);
}

/// A frame with an unknown checksum may include its neighbours in its contents, up to the end or to the next frame.
#[test]
fn damaged_length_consumes_no_following_frame() {
    let good = frame(1, 0, 7, 33, &position(500_000_000, 80_000_000));
    let unknown = frame(1, 0, 7, 30, &[0; 28]);
    for neighbours in 1..=2 {
        let mut damaged = unknown.clone();
        damaged[1] += (neighbours * good.len()) as u8;
        let octets = [damaged, good.repeat(neighbours)].concat();
        let mut translator = translator();
        assert_eq!(records(&mut translator, &octets).len(), neighbours);
        assert_eq!(translator.counts().dropped.to_string(), "1 checksum");
        assert_eq!(translator.counts().outside, unknown.len() as u64);
    }
    let mut translator = translator();
    assert!(records(&mut translator, &frame(1, 0, 7, 30, &good)).is_empty());
    assert_eq!(translator.counts().dropped.to_string(), "1 other_message");
}

#[test]
fn serial_number_is_checked_and_padded() {
    let whole = KnownSystem::new("1581F4FKD2291000A4B2").unwrap().serial_number;
    assert_eq!(whole.last(), *b"D2291000A4B2");
    assert_eq!(KnownSystem::new("TEST-1").unwrap().serial_number.last(), *b"TEST-1      ");
    assert_eq!(["", "   ", "123456789012345678901", "é"].map(KnownSystem::new), [None, None, None, None]);
}

proptest! {
    #[test]
    fn arbitrary_octets_are_only_counted(octets: Vec<u8>, first in prop::sample::select(vec![0xfe_u8, 0xfd, 0])) {
        records(&mut translator(), &[&[first], &octets[..]].concat());
    }

    #[test]
    fn damaged_frame_affects_no_neighbour(damage in prop::collection::btree_map(0..40_usize, any::<u8>(), 1..6), second: bool) {
        let version = if second { 2 } else { 1 };
        let good = frame(version, 0, 7, 33, &position(500_000_000, 80_000_000));
        let mut bad = good.clone();
        for (at, octet) in damage {
            let at = at % bad.len();
            bad[at] = octet;
        }
        let found = records(&mut translator(), &[&good[..], &bad, &good].concat());
        prop_assert!((2..=3).contains(&found.len()));
    }
}

/// Frames of system 9, component 236, made by pymavlink 2.4.50 (`dialects.v20.common`), each by `….pack(MAVLink(None, 9, 236))`:
/// MAVLink_adsb_vehicle_message(0x40621D, 522572000, 39194000, 0, 1158240, 9000, 6000, -150, b"KLM1023", 5, 1, 159, 1200).
const VEHICLE: &str =
    "fd2600000009ecf600001d624000e0d0251f900d560260ac1100282370176aff9f00b004004b4c4d31303233000005010234";
/// MAVLink_open_drone_id_basic_id_message(0, 0, [0] * 20, 1, 2, list(b"1581F4FKD2291000A4B2")).
const BASIC_ID: &str = "fd2c00000009ec643200000000000000000000000000000000000000000000000102313538314634464b44323239313030304134423213ca";
/// MAVLink_open_drone_id_location_message(0, 0, [0] * 20, 2, 27050, 1250, -150, 522573000, 39195000, 95.5, 120.0, 1, 30.5, 11, 4,
/// 3, 3, 1800.5, 5).
const LOCATION: &str = "fd3b00000009ec653200c8d4251f781156020000bf420000f0420000f4410010e144aa69e2046aff0000000000000000000000000000000000000000000002010b04030305f64d";
/// MAVLink_open_drone_id_location_message(0, 0, [0] * 20, 0, 36100, 25500, 6300, 522573000, 39195000, -1000, -1000, 0,
/// -1000, 0, 0, 0, 0, 65535, 0): all optional values unknown.
const PLACE_ALONE: &str =
    "fd1e00000009ec653200c8d4251f7811560200007ac400007ac400007ac400ff7f47048d9c639c18e4b5";
/// MAVLink_open_drone_id_system_message(0, 0, [0] * 20, 1, 1, 522570000, 39190000, 1, 0, -1000, -1000, 1, 2, 45.5, 248000000).
const SYSTEM: &str = "fd3600000009ec68320010c9251ff0fd550200007ac400007ac400003642002ec80e010000000000000000000000000000000000000000000000000001010102fb69";
/// MAVLink_open_drone_id_operator_id_message(0, 0, [0] * 20, 0, b"FIN87astrdge12k8").
const OPERATOR_ID: &str =
    "fd2700000009ec693200000000000000000000000000000000000000000000000046494e38376173747264676531326b385224";
/// MAVLink_open_drone_id_message_pack_message(0, 0, mac + [0] * 14, 25, 2, basic_id + operator_id + [0] * 175) with mac
/// 90:3a:e6:5b:c8:a8 and two messages of 25 octets.
const PACK: &str = "fd4300000009ec7332000000903ae65bc8a8000000000000000000000000000019020212313538314634464b443232393130303041344232000000520046494e38376173747264676531326b3876c4";

fn octets(frame: &str) -> Vec<u8> {
    crate::hex::octets(frame).unwrap()
}

/// A translator with sensors for all messages.
fn of_all() -> MavlinkTranslator {
    let receiver = RemoteIdReceiver { id: Some("roof".to_owned()) };
    MavlinkTranslator::new(MavlinkSensors {
        aircraft: Some(SOURCE),
        remote_id: Some(receiver),
        ..translator().sensors
    })
}

fn translated(translator: &mut MavlinkTranslator, frame: &str) -> Vec<Vec<u8>> {
    let mut datagrams = Vec::new();
    translator.take(&octets(frame), NOON, |datagram| datagrams.push(datagram));
    datagrams
}

#[test]
fn adsb_vehicle_is_a_cat021_record() {
    use asterix::cat021;

    let datagrams = translated(&mut of_all(), VEHICLE);
    assert_eq!(datagrams.len(), 1);
    let block = blocks(&datagrams[0]).next().unwrap().unwrap();
    let records: Vec<_> = block
        .records_in::<cat021::Record>(cat021::Edition::default())
        .map(|located| located.unwrap().record)
        .collect();
    let record = &records[0];
    assert_eq!((records.len(), record.data_source), (1, Some(SOURCE)));
    assert_eq!(record.target_address.unwrap().address(), 0x40_621d);
    let place = record.fine_position.unwrap();
    assert!((place.latitude_deg() - 52.2572).abs() < 1e-6 && (place.longitude_deg() - 3.9194).abs() < 1e-6);
    // 1158.24 m by the barometer, received a second ago.
    assert_eq!(record.flight_level.unwrap().flight_level(), 38.0);
    assert_eq!((record.geometric_height, record.quality.is_none()), (None, true));
    assert_eq!(record.position_reception.unwrap().seconds(), 43_200.0 - 1.0);
    let vector = record.ground_vector.unwrap();
    assert!((vector.speed_m_s() - 60.0).abs() < 0.1 && (vector.track_deg() - 90.0).abs() < 0.01);
    assert!((record.barometric_rate.unwrap().up_m_s() + 1.5).abs() < 0.04);
    assert_eq!(record.target_identification.unwrap().to_string(), "KLM1023");
    assert_eq!(record.emitter.unwrap().category(), cat021::EmitterCategory::Heavy);
    // An invalid position gives no record.
    let mut invalid = octets(VEHICLE);
    invalid[10 + 22] &= !1;
    let end = invalid.len() - 2;
    let checksum = calculate_crc(&invalid[1..end], vehicle::ADSB_VEHICLE.1);
    invalid[end..].copy_from_slice(&checksum.to_le_bytes());
    let mut translator = of_all();
    translator.take(&invalid, NOON, |_| panic!("no position"));
    assert_eq!(translator.counts().dropped.to_string(), "1 no_position");
}

#[test]
fn open_drone_id_becomes_a_remote_id_line() {
    use ::remote_id::{HeightAbove, IdType, Message, Status, UaType, messages};

    use crate::gateways::remote_id::BroadcastLine;

    let line = |frame: &str| {
        let datagrams = translated(&mut of_all(), frame);
        assert_eq!(datagrams.len(), 1, "{frame}");
        BroadcastLine::parse(&datagrams[0]).unwrap()
    };
    let message = |frame: &str| {
        let line = line(frame);
        assert_eq!((line.time, line.receiver.as_deref()), (Some(NOON), Some("roof")));
        assert_eq!(line.transmitter, "mavlink-9-236");
        messages(&line.octets).next().unwrap().unwrap()
    };
    let Message::BasicId(id) = message(BASIC_ID) else { panic!() };
    assert_eq!((id.id(), id.id_type()), (&b"1581F4FKD2291000A4B2"[..], IdType::SerialNumber));
    assert_eq!(id.ua_type(), UaType::Rotorcraft);
    let Message::Location(location) = message(LOCATION) else { panic!() };
    let said = location.content();
    assert_eq!((said.status, said.course_deg, said.speed_m_s), (Status::Airborne, Some(271.0), Some(12.5)));
    assert_eq!((location.place_counts(), said.climb_m_s), ([522_573_000, 39_195_000], Some(-1.5)));
    assert_eq!((said.pressure_altitude_m, said.geodetic_altitude_m), (Some(95.5), Some(120.0)));
    assert_eq!(said.height_m, Some((30.5, HeightAbove::Ground)));
    assert_eq!(
        (said.accuracy_h_m, said.accuracy_v_m, said.accuracy_pressure_m),
        (Some(3.0), Some(10.0), Some(25.0))
    );
    assert_eq!((said.accuracy_speed_m_s, said.seconds_of_hour), (Some(1.0), Some(1800.5)));
    assert_eq!(said.accuracy_time_s, Some(0.5));
    let Message::Location(location) = message(PLACE_ALONE) else { panic!() };
    let said = location.content();
    assert_eq!(
        (said.course_deg, said.speed_m_s, said.climb_m_s, said.seconds_of_hour),
        (None, None, None, None)
    );
    assert_eq!((said.pressure_altitude_m, said.geodetic_altitude_m, said.height_m), (None, None, None));
    let Message::System(system) = message(SYSTEM) else { panic!() };
    let said = system.content();
    let place = said.operator_deg.unwrap();
    assert!((place[0] - 52.257).abs() < 1e-7 && (place[1] - 3.919).abs() < 1e-7);
    assert_eq!((said.operator_altitude_m, said.area_ceiling_m, said.area_floor_m), (Some(45.5), None, None));
    assert_eq!((said.location_type, said.classification, said.category_and_class), (1, 1, [1, 2]));
    assert_eq!((said.area_count, said.time_s), (1, 248_000_000));
    let Message::OperatorId(operator) = message(OPERATOR_ID) else { panic!() };
    assert_eq!(operator.id(), b"FIN87astrdge12k8");
    // Received from another drone, whose address is stated.
    let pack = line(PACK);
    assert_eq!(pack.transmitter, "90:3a:e6:5b:c8:a8");
    let found: Vec<_> = messages(&pack.octets).map(Result::unwrap).collect();
    assert_eq!(found, [Message::BasicId(id), Message::OperatorId(operator)]);
}

#[test]
fn messages_without_a_sensor_are_other_messages() {
    let mut translator = translator();
    for frame in [VEHICLE, BASIC_ID, LOCATION, SYSTEM, OPERATOR_ID, PACK] {
        assert!(translated(&mut translator, frame).is_empty());
    }
    assert_eq!(translator.counts().dropped.to_string(), "6 other_message");
    let mut sensors = of_all().sensors;
    sensors.drones = None;
    let mut translator = MavlinkTranslator::new(sensors);
    let good = frame(2, 0, 7, 33, &position(500_000_000, 80_000_000));
    translator.take(&good, NOON, |_| panic!("no transponder"));
    assert_eq!(translator.counts().dropped.to_string(), "1 other_message");
    // A damaged frame is recognised by its checksum.
    let mut damaged = octets(BASIC_ID);
    damaged[40] ^= 1;
    translator.take(&damaged, NOON, |_| panic!("damaged"));
    assert_eq!(translator.counts().dropped.of(MavlinkDropReason::Checksum as usize), 1);
}

#[test]
fn long_serial_number_is_whole_in_the_special_purpose_field() {
    let system = KnownSystem::new("1581F4FKD2291000A4B2").unwrap();
    let drones = Some((SOURCE, BTreeMap::from([(7, system)])));
    let mut translator = MavlinkTranslator::new(MavlinkSensors { drones, ..MavlinkSensors::default() });
    let records = records(&mut translator, &frame(2, 0, 7, 33, &position(500_000_000, 80_000_000)));
    assert_eq!(records[0].serial_number, Some(*b"D2291000A4B2"));
    let whole = WholeSerial::read(records[0].special_purpose.as_ref().unwrap()).unwrap();
    assert_eq!(whole.octets(), b"1581F4FKD2291000A4B2");
}
