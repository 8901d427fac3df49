//! Hand-made frames: flags of 802.11, fragmented elements, Bluetooth with every link type, French beacons.

use remote_id::{
    Advertisement, Fault, French, HeightAbove, IdType, LENGTH, Link, Listener, Message, NotHeard, Transport,
    advertisements, messages,
};

/// A Self-ID message.
const MESSAGE: [u8; LENGTH] = *b"\x32\0a flight for testing...";
const ADDRESS: [u8; 6] = [1, 2, 3, 4, 5, 6];
const VENDOR: [u8; 4] = [0xfa, 0x0b, 0xbc, 0x0d];

/// A management frame; `header` is its frame control, `body` follows the header of 24 octets.
fn management(header: [u8; 2], body: &[u8]) -> Vec<u8> {
    [&header[..], &[0; 2], &[0xff; 6], &ADDRESS, &[9; 6], &[0; 2], body].concat()
}

/// The body of a beacon: time stamp, interval, capabilities, the name of a network, and these elements.
fn beacon_body(elements: &[u8]) -> Vec<u8> {
    [&[0; 12][..], &[0, 3, b'n', b'e', b't'], elements].concat()
}

fn element(number: u8, contents: &[u8]) -> Vec<u8> {
    [&[number, contents.len() as u8], contents].concat()
}

fn vendor(octets: &[u8]) -> Vec<u8> {
    element(221, &[&VENDOR, octets].concat())
}

fn pack(count: u8) -> Vec<u8> {
    let mut octets = vec![0xf2, 25, count];
    (0..count).for_each(|number| {
        octets.extend(MESSAGE);
        *octets.last_mut().expect("a message") = b'0' + number;
    });
    octets
}

fn heard(link: Link, frame: &[u8]) -> Vec<Advertisement<'_>> {
    advertisements(link, frame).expect("an advertisement")
}

/// The octets of the only advertisement in a frame.
fn octets_of(link: Link, frame: &[u8]) -> Vec<u8> {
    let mut all = heard(link, frame);
    assert_eq!((all.len(), all[0].transmitter), (1, ADDRESS));
    all.remove(0).octets.into_owned()
}

#[test]
fn frame_control_flags_do_not_hide_a_beacon() {
    let body = beacon_body(&vendor(&[&[7][..], &MESSAGE].concat()));
    // Retry, power management, more data, and the order bit without the field that it indicates today.
    for flags in [0, 0x08, 0x10, 0x20, 0x38, 0x80] {
        assert_eq!(octets_of(Link::Ieee80211, &management([0x80, flags], &body)), MESSAGE, "{flags:02x}");
    }
    let with_control = [&[0x11, 0x22, 0x33, 0x44][..], &body].concat();
    assert_eq!(octets_of(Link::Ieee80211, &management([0x80, 0x80], &with_control)), MESSAGE);
    assert_eq!(octets_of(Link::Ieee80211, &management([0x50, 0], &body)), MESSAGE, "probe response");
    let encrypted = management([0x80, 0x40], &body);
    assert_eq!(advertisements(Link::Ieee80211, &encrypted), Err(NotHeard::Other));
}

#[test]
fn short_control_frame_is_not_cut() {
    // An acknowledgement frame.
    let ack = [&[0xd4, 0, 0, 0][..], &ADDRESS].concat();
    assert_eq!(advertisements(Link::Ieee80211, &ack), Err(NotHeard::Other));
}

#[test]
fn pack_of_ten_over_two_elements_is_joined() {
    let whole = [&[7][..], &pack(10)].concat();
    let (first, second) = whole.split_at(251);
    let counted = [&[7][..], second].concat();
    for end in [vendor(second), vendor(&counted), element(242, second)] {
        let frame = management([0x80, 0], &beacon_body(&[vendor(first), end].concat()));
        let octets = octets_of(Link::Ieee80211, &frame);
        assert_eq!(messages(&octets).filter(Result::is_ok).count(), 10);
        assert_eq!(octets, pack(10));
    }
}

#[test]
fn two_elements_of_one_beacon_are_both_decoded() {
    for (first, second) in [(MESSAGE.to_vec(), pack(2)), (pack(3), MESSAGE.to_vec()), (pack(1), pack(2))] {
        let elements = [vendor(&[&[7][..], &first].concat()), vendor(&[&[8][..], &second].concat())].concat();
        let frame = management([0x80, 0], &beacon_body(&elements));
        let all = heard(Link::Ieee80211, &frame);
        let octets: Vec<&[u8]> = all.iter().map(|heard| &*heard.octets).collect();
        assert_eq!(octets, [&first[..], &second[..]]);
    }
    // A truncated pack does not swallow the pack after it.
    let elements =
        [vendor(&[&[7][..], &pack(4)[..60]].concat()), vendor(&[&[8][..], &pack(2)].concat())].concat();
    let frame = management([0x80, 0], &beacon_body(&elements));
    assert_eq!(heard(Link::Ieee80211, &frame).len(), 2);
}

#[test]
fn element_cut_by_the_capture_costs_only_itself() {
    let elements = [vendor(&[&[7][..], &MESSAGE].concat()), vec![221, 40, 1, 2]].concat();
    let frame = management([0x80, 0], &beacon_body(&elements));
    assert_eq!(octets_of(Link::Ieee80211, &frame), MESSAGE);
}

#[test]
fn pack_of_ten_is_read_and_eleven_refused() {
    assert_eq!(messages(&pack(10)).filter(Result::is_ok).count(), 10);
    assert_eq!(messages(&pack(11)).collect::<Vec<_>>(), [Err(Fault::PackCount { count: 11 })]);
    let cut = messages(&pack(3)[..60]).last();
    let fault = cut.expect("an item").expect_err("a fault");
    assert_eq!(fault.to_string(), "the pack says that it has 3 messages, and ends in message 3");
}

/// Advertising data with flags and Remote ID.
fn data(octets: &[u8]) -> Vec<u8> {
    [&[2, 1, 6][..], &[5 + octets.len() as u8, 0x16, 0xfa, 0xff, 0x0d, 7], octets].concat()
}

fn backwards() -> Vec<u8> {
    ADDRESS.into_iter().rev().collect()
}

/// The access address and a packet of that type, without its checksum.
fn packet(kind: u8, body: &[u8]) -> Vec<u8> {
    [&[0xd6, 0xbe, 0x89, 0x8e, 0x40 | kind, body.len() as u8], body].concat()
}

fn nordic(packet: &[u8]) -> Vec<u8> {
    let mut header = [0; 17];
    header[8] = 1;
    [&header, packet, &[0; 3]].concat()
}

#[test]
fn bluetooth_legacy_advertising_is_decoded() {
    let body = [backwards(), data(&MESSAGE)].concat();
    for kind in 0..16 {
        let frame = nordic(&packet(kind, &body));
        let heard = advertisements(Link::NordicBle, &frame);
        if [0, 2, 4, 6].contains(&kind) {
            assert_eq!(octets_of(Link::NordicBle, &frame), MESSAGE, "{kind}");
        } else {
            assert!(heard.is_err(), "{kind}: {heard:?}");
        }
    }
    let mut other = packet(0, &body);
    other[0] = 0;
    assert_eq!(advertisements(Link::NordicBle, &nordic(&other)), Err(NotHeard::Other), "a data channel");
}

#[test]
fn bluetooth_link_layer_checksum_is_compared() {
    // A packet from a sniffer with changed names (an empty advertisement, checksum calculated by hand).
    let sent = [
        0xd6, 0xbe, 0x89, 0x8e, 0x42, 0x25, 2, 1, 0, 0xe1, 0xa5, 0xc4, 0x1e, 0x16, 0xfa, 0xff, 0x0d, 0, 0, 0,
        0x4d, 0x46, 0x47, 0x31, 0x41, 0x30, 0x31, 0x32, 0x33, 0x34, 0x35, 0x36, 0x37, 0x38, 0x39, 0, 0, 0, 0,
        0, 0, 0x50, 0xf6, 0x3f, 0x05, 0x7c,
    ];
    assert!(advertisements(Link::LeLinkLayer, &sent).is_ok());
    let mut garbled = sent;
    garbled[25] ^= 1;
    assert_eq!(advertisements(Link::LeLinkLayer, &garbled), Err(NotHeard::Damaged));
    let radio = |flags: u16, packet: &[u8]| [&[0; 8][..], &flags.to_le_bytes(), packet].concat();
    for (flags, packet, is_heard) in
        [(0x0001, &sent, true), (0x0001, &garbled, false), (0x0401, &sent, false), (0x0c01, &garbled, true)]
    {
        assert_eq!(advertisements(Link::LeRadio, &radio(flags, packet)).is_ok(), is_heard, "{flags:04x}");
    }
    // On the coded PHY an octet with the coding indicator follows the access address.
    let coded = [&sent[..4], &[0], &sent[4..]].concat();
    assert!(advertisements(Link::LeRadio, &radio(0x8c01, &coded)).is_ok());
    // A capture without checksums.
    assert_eq!(advertisements(Link::LeLinkLayer, &sent[..43]), Err(NotHeard::Cut));
}

#[test]
fn bluetooth_controller_reports_are_decoded() {
    let legacy = |octets: &[u8]| {
        let data = data(octets);
        [vec![3, 1], backwards(), vec![data.len() as u8], data, vec![0xc4]].concat()
    };
    let extended = |octets: &[u8]| {
        let data = data(octets);
        let between = [1, 0, 0xff, 0x7f, 0xc4, 0, 0, 0, 0, 0, 0, 0, 0, 0];
        [vec![0x10, 0, 1], backwards(), between.to_vec(), vec![data.len() as u8], data].concat()
    };
    let event = |about: u8, reports: &[Vec<u8>]| {
        let reports = [vec![about, reports.len() as u8], reports.concat()].concat();
        [vec![0x3e, reports.len() as u8], reports].concat()
    };
    let other: [u8; LENGTH] = *b"\x32\0a flight for others....";
    for events in [
        event(0x02, &[legacy(&MESSAGE), legacy(&other)]),
        event(0x0d, &[extended(&MESSAGE), extended(&other)]),
    ] {
        let hci = [&[4][..], &events].concat();
        let direction = [&[0, 0, 0, 1][..], &hci].concat();
        let monitor = [&[0, 0, 0, 3][..], &events].concat();
        for (link, frame) in [(Link::Hci, hci), (Link::HciDirection, direction), (Link::HciMonitor, monitor)]
        {
            let all = heard(link, &frame);
            let octets: Vec<&[u8]> = all.iter().map(|heard| &*heard.octets).collect();
            assert_eq!(octets, [&MESSAGE[..], &other[..]], "{link:?}");
            assert!(all.iter().all(|heard| heard.transmitter == ADDRESS));
        }
    }
    // The first part of a pack that the controller reported in two parts.
    let mut report = extended(&pack(9));
    report.truncate(report.len() - 40);
    report[23] -= 40;
    let frame = [&[4][..], &event(0x0d, &[report])].concat();
    assert_eq!(messages(&octets_of(Link::Hci, &frame)).filter(Result::is_ok).count(), 7);
    assert_eq!(advertisements(Link::Hci, &[1, 3, 0x0c, 0]), Err(NotHeard::Other), "a command");
}

/// A French element with these values.
fn french(values: &[(u8, &[u8])]) -> Vec<u8> {
    let values = values.iter().flat_map(|(kind, value)| element(*kind, value));
    let contents: Vec<u8> = [0x6a, 0x5c, 0x35, 0x01].into_iter().chain(values).collect();
    element(221, &contents)
}

#[test]
fn french_beacon_is_read() {
    let id = b"AMSBB1000000000000000000BETA01";
    let element = french(&[
        (1, &[1]),
        (2, id),
        (4, &4_630_452_i32.to_be_bytes()),
        (5, &(-715_816_i32).to_be_bytes()),
        (6, &302_i16.to_be_bytes()),
        (7, &(-12_i16).to_be_bytes()),
        (8, &4_630_443_i32.to_be_bytes()),
        (9, &(-715_819_i32).to_be_bytes()),
        (10, &[15]),
        (11, &270_u16.to_be_bytes()),
        (99, b"later"),
    ]);
    let frame = management([0x80, 0], &beacon_body(&element));
    let all = heard(Link::Ieee80211, &frame);
    assert_eq!(all[0].transport, Transport::WifiFrench);
    let read = French::new(&all[0].octets).expect("values");
    let close = |a: Option<[f64; 2]>, b: [f64; 2]| {
        a.is_some_and(|a| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-9))
    };
    assert!(
        close(read.place_deg, [46.304_52, -7.158_16]) && close(read.take_off_deg, [46.304_43, -7.158_19])
    );
    assert_eq!((read.altitude_amsl_m, read.height_m), (Some(302.0), Some(-12.0)));
    assert_eq!((read.speed_m_s, read.course_deg), (Some(15.0), Some(270.0)));
    let pack = read.pack(50.0).expect("messages");
    let all: Vec<Message> = messages(&pack).map(|message| message.expect("sound")).collect();
    let [Message::BasicId(basic), Message::Location(location), Message::System(system)] = all[..] else {
        panic!("{all:?}")
    };
    assert_eq!((basic.id_type(), basic.id()), (IdType::Registration, &b"AMSBB1BETA01"[..]));
    assert_eq!(location.geodetic_altitude_m(), Some(352.0));
    assert_eq!(location.height_m(), Some((-12.0, HeightAbove::TakeOff)));
    assert_eq!((location.speed_m_s(), location.course_deg()), (Some(15.0), Some(270.0)));
    assert_eq!((location.seconds_of_hour(), location.accuracy_h_m()), (None, None));
    assert!(close(Some(system.operator_deg()), [46.304_43, -7.158_19]));
}

#[test]
fn french_identity_too_long_is_left_out() {
    let long = b"AMSBB1123456789012345678901234";
    let position: [(u8, &[u8]); 2] = [(4, &[0, 0x46, 0, 0]), (5, &[0, 0x0a, 0, 0])];
    let with = |values: &[(u8, &[u8])]| {
        let element = french(&[values, &position].concat());
        let read = French::new(&element[6..]).expect("values");
        let pack = read.pack(0.0).expect("messages");
        let first = messages(&pack).next().expect("a message").expect("sound");
        match first {
            Message::BasicId(basic) => Some((basic.id_type(), basic.id().to_vec())),
            _ => None,
        }
    };
    assert_eq!(with(&[(2, long)]), None);
    assert_eq!(with(&[(2, &long[..29])]), None, "not of 30 characters");
    let serial = b"1581F5BKX233A00B1A2C";
    assert_eq!(with(&[(2, long), (3, serial)]), Some((IdType::SerialNumber, serial.to_vec())));
    assert_eq!(French::new(&[]), None);
    assert_eq!(French::new(&[4, 4, 0, 0]), None, "a value that is cut");
}

/// A packet of extended advertising with these flags and header fields.
fn extended(flags: u8, fields: &[u8], data: &[u8]) -> Vec<u8> {
    let header = [&[1 + fields.len() as u8, flags], fields].concat();
    nordic(&packet(7, &[&header, data].concat()))
}

/// Packets with the parts of advertising data `adi`: AUX_ADV_IND with an address, then AUX_CHAIN_IND without one.
fn in_packets(parts: &[&[u8]], adi: [u8; 2]) -> Vec<Vec<u8>> {
    let last = parts.len() - 1;
    let frame = |(at, data): (usize, &&[u8])| {
        let address = if at == 0 { backwards() } else { Vec::new() };
        let pointer: &[u8] = if at < last { &[0x25, 0x10, 0x20] } else { &[] };
        let flags = u8::from(at == 0) | 1 << 3 | u8::from(at < last) << 4;
        extended(flags, &[&address[..], &adi, pointer].concat(), data)
    };
    parts.iter().enumerate().map(frame).collect()
}

/// Number of messages and of faults that a listener returns for each frame.
fn listened(frames: &[Vec<u8>]) -> Vec<(usize, usize)> {
    let mut listener = Listener::default();
    let counts = |frame: &Vec<u8>| {
        let heard = listener.hear(Link::NordicBle, frame).unwrap_or_default();
        assert!(heard.iter().all(|heard| heard.transmitter == ADDRESS));
        let all: Vec<_> =
            heard.iter().flat_map(|heard| messages(&heard.octets).collect::<Vec<_>>()).collect();
        (
            all.iter().filter(|message| message.is_ok()).count(),
            all.iter().filter(|message| message.is_err()).count(),
        )
    };
    frames.iter().map(counts).collect()
}

#[test]
fn bluetooth_pack_over_chained_packets_is_whole() {
    let data = data(&pack(9));
    // The pack follows 9 octets and its header of 3: two packets hold 4 and 5 complete messages, three packets 1, 4 and 4.
    let two = in_packets(&[&data[..130], &data[130..]], [5, 0x10]);
    assert_eq!(listened(&two), [(4, 0), (5, 0)]);
    let three = in_packets(&[&data[..40], &data[40..150], &data[150..]], [5, 0x10]);
    assert_eq!(listened(&three), [(1, 0), (4, 0), (4, 0)]);
    let message = self::data(&MESSAGE);
    assert_eq!(listened(&in_packets(&[&message[..20], &message[20..]], [5, 0x10])), [(0, 0), (1, 0)]);
    // A single frame is read as far as it goes; a single chained one yields nothing.
    assert_eq!(messages(&octets_of(Link::NordicBle, &two[0])).filter(Result::is_ok).count(), 4);
    assert_eq!(advertisements(Link::NordicBle, &two[1]), Err(NotHeard::Other));
    // Complete data precede data that are continued.
    let more = in_packets(&[&data, &[3, 9, 65, 66]], [5, 0x10]);
    assert_eq!(listened(&more), [(9, 0), (0, 0)]);
}

#[test]
fn bluetooth_pack_whose_rest_is_lost_is_a_fault() {
    let data = data(&pack(9));
    let first = in_packets(&[&data[..130], &data[130..]], [5, 0x10]);
    let second = in_packets(&[&data[..130], &data[130..]], [6, 0x10]);
    // The first chained packet is lost, and a stray one belongs to no advertiser.
    let stray = in_packets(&[&data[..130], &data[130..]], [9, 0x10]).remove(1);
    let frames = [first[0].clone(), stray, second[0].clone(), second[1].clone()];
    assert_eq!(listened(&frames), [(4, 0), (0, 0), (4, 1), (5, 0)]);
}

#[test]
fn bluetooth_pack_over_reports_of_a_controller_is_whole() {
    let all = data(&pack(9));
    let report = |status: u8, data: &[u8]| {
        let between = [1, 0, 3, 0x7f, 0xc4, 0, 0, 0, 0, 0, 0, 0, 0, 0];
        let report = [&[status << 5, 0, 1][..], &backwards(), &between, &[data.len() as u8], data].concat();
        [&[4, 0x3e, 2 + report.len() as u8, 0x0d, 1][..], &report].concat()
    };
    let mut listener = Listener::default();
    let mut count = |frame: &[u8]| {
        let heard = listener.hear(Link::Hci, frame).unwrap_or_default();
        heard
            .iter()
            .flat_map(|heard| messages(&heard.octets).collect::<Vec<_>>())
            .filter(Result::is_ok)
            .count()
    };
    for _ in 0..2 {
        assert_eq!([count(&report(1, &all[..130])), count(&report(0, &all[130..]))], [4, 5]);
    }
}
