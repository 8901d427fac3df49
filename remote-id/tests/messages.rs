//! Hand-made messages, and random octets.

use proptest::prelude::*;
use remote_id::{
    BasicId, Fault, HeightAbove, IdType, LENGTH, Link, Location, Message, NotHeard, Status, UaType,
    advertisements, messages,
};

/// 52.1 N, 0.25 W, course 270, 70.5 m/s, climbing 2.5 m/s, 120 m geodetic, 60 m above ground, at 30 min 12.3 s.
const LOCATION: [u8; LENGTH] = [
    0x12, 0x27, 90, 9, 5, 0x40, 0xd4, 0x0d, 0x1f, 0x60, 0xda, 0xd9, 0xff, 0, 0, 0xc0, 0x08, 0x48, 0x08, 0x5b,
    0x34, 0xcb, 0x46, 3, 0,
];

fn location(octets: [u8; LENGTH]) -> Location {
    let Ok(Message::Location(location)) = Message::new(octets) else { panic!("{octets:?}") };
    location
}

/// The location message with one octet changed.
fn with(index: usize, octet: u8) -> Location {
    let mut octets = LOCATION;
    octets[index] = octet;
    location(octets)
}

fn pack(count: u8, messages: &[[u8; LENGTH]]) -> Vec<u8> {
    [&[0xf2, LENGTH as u8, count][..], &messages.concat()].concat()
}

#[test]
fn location_octets_are_decoded() {
    let location = location(LOCATION);
    let [latitude, longitude] = location.place_deg();
    assert!((latitude - 52.1).abs() < 1e-9 && (longitude + 0.25).abs() < 1e-9, "{latitude} {longitude}");
    assert_eq!(location.status(), Status::Airborne);
    assert_eq!(location.course_deg(), Some(270.0));
    assert_eq!(location.speed_m_s(), Some(9.0 * 0.75 + 63.75));
    assert_eq!(location.climb_m_s(), Some(2.5));
    assert_eq!(location.pressure_altitude_m(), None);
    assert_eq!(location.geodetic_altitude_m(), Some(120.0));
    assert_eq!(location.height_m(), Some((60.0, HeightAbove::Ground)));
    assert_eq!((location.accuracy_h_m(), location.accuracy_v_m()), (Some(3.0), Some(3.0)));
    assert_eq!((location.accuracy_speed_m_s(), location.accuracy_pressure_m()), (Some(0.3), Some(25.0)));
    assert!((location.seconds_of_hour().unwrap() - 1812.3).abs() < 1e-9);
    assert!((location.accuracy_time_s().unwrap() - 0.3).abs() < 1e-9);
    assert_eq!(Message::Location(location).version(), 2);
}

#[test]
fn unknown_values_are_none() {
    // Course 361; speed 255; vertical speed 63; no accuracy; beyond the hour.
    assert_eq!(with(2, 181).course_deg(), None);
    assert_eq!(with(3, 255).speed_m_s(), None);
    assert_eq!(with(4, 126).climb_m_s(), None);
    assert_eq!(with(4, 0x82).climb_m_s(), Some(-63.0));
    assert_eq!((with(19, 0).accuracy_h_m(), with(19, 0).accuracy_v_m()), (None, None));
    assert_eq!((with(19, 0xff).accuracy_h_m(), with(19, 0xff).accuracy_v_m()), (None, None));
    assert_eq!(with(22, 0xff).seconds_of_hour(), None);
    assert_eq!(with(23, 0).accuracy_time_s(), None);
    assert_eq!(with(19, 1).accuracy_h_m(), Some(18_520.0));
}

#[test]
fn an_identity_is_written_and_read() {
    let id = BasicId::new(IdType::SerialNumber, UaType::Rotorcraft, b"1581F6GKB23C003");
    assert_eq!((id.id_type(), id.ua_type()), (IdType::SerialNumber, UaType::Rotorcraft));
    assert_eq!((id.id(), id.id_octets().len()), (&b"1581F6GKB23C003"[..], 20));
    assert_eq!(Message::new(*Message::BasicId(id).octets()), Ok(Message::BasicId(id)));
    for number in 0..16 {
        let mut octets = *Message::BasicId(id).octets();
        octets[1] = number << 4 | number;
        let Ok(Message::BasicId(other)) = Message::new(octets) else { panic!("{number}") };
        assert_eq!(BasicId::new(other.id_type(), other.ua_type(), other.id()), other);
    }
}

#[test]
fn pack_yields_valid_messages_and_reports_faults() {
    let noise = [0x97; LENGTH];
    let mut nobodys = LOCATION;
    nobodys[0] = 0x92;
    let octets = pack(4, &[LOCATION, noise, nobodys, LOCATION]);
    let read: Vec<_> = messages(&octets).collect();
    let sound = Ok(Message::Location(location(LOCATION)));
    assert_eq!(read, [sound, Err(Fault::Version { version: 7 }), Err(Fault::Kind { kind: 9 }), sound]);
    let cut: Vec<_> = messages(&octets[..3 + 30]).collect();
    assert_eq!(cut, [sound, Err(Fault::PackCut { count: 4, ends_in: 2 })]);
    for (octets, fault) in [
        (pack(0, &[]), Fault::PackCount { count: 0 }),
        (pack(11, &[LOCATION]), Fault::PackCount { count: 11 }),
        (vec![0xf0, 24, 1], Fault::PackLength { length: 24 }),
        (vec![0xf9, 25, 1], Fault::Version { version: 9 }),
        (vec![], Fault::Short { there: 0 }),
        (LOCATION[..24].to_vec(), Fault::Short { there: 24 }),
    ] {
        assert_eq!(messages(&octets).collect::<Vec<_>>(), [Err(fault)], "{octets:?}");
    }
    assert_eq!(messages(&pack(1, &[[0xf0; LENGTH]])).collect::<Vec<_>>(), [Err(Fault::NestedPack)]);
    assert_eq!(messages(&LOCATION).collect::<Vec<_>>(), [sound], "alone");
}

/// A beacon from an arbitrary address.
fn beacon(radiotap: &[u8], element: &[u8]) -> Vec<u8> {
    let mut frame = radiotap.to_vec();
    frame.extend([0x80, 0, 0, 0]);
    frame.extend([0xff; 6]);
    frame.extend([1, 2, 3, 4, 5, 6]);
    frame.extend([0; 8 + 12]);
    // The name of the network precedes the element.
    frame.extend([0, 3, b'n', b'e', b't']);
    frame.extend(element);
    frame
}

#[test]
fn a_frame_that_the_radio_garbled_is_no_frame() {
    let element = [&[221, 5 + 25, 0xfa, 0x0b, 0xbc, 0x0d, 77][..], &LOCATION].concat();
    let plain = beacon(&[], &element);
    let said = advertisements(Link::Ieee80211, &plain).unwrap();
    assert_eq!((said[0].transmitter, said[0].counter), ([1, 2, 3, 4, 5, 6], 77));
    assert_eq!(said[0].octets, LOCATION.as_slice());
    // Flags only; flags preceded by a time stamp aligned to eight octets.
    for (flags_at, header) in
        [(8, vec![0, 0, 9, 0, 2, 0, 0, 0, 0]), (16, [&[0, 0, 17, 0, 3, 0, 0, 0][..], &[0; 9]].concat())]
    {
        let mut header: Vec<u8> = header;
        let framed = beacon(&header, &element);
        assert_eq!(advertisements(Link::Radiotap, &framed), Ok(said.clone()));
        header[flags_at] = 0x40;
        let garbled = beacon(&header, &element);
        assert_eq!(advertisements(Link::Radiotap, &garbled), Err(NotHeard::Damaged));
        header[flags_at] = 0x10;
        let mut checked = beacon(&header, &element);
        checked.extend([0xde, 0xad, 0xbe, 0xef]);
        assert_eq!(advertisements(Link::Radiotap, &checked), Ok(said.clone()));
    }
    assert_eq!(advertisements(Link::Ieee80211, &plain[..plain.len() - 1]), Err(NotHeard::Cut));
    assert_eq!(advertisements(Link::Ieee80211, &beacon(&[], &[])), Err(NotHeard::Other));
}

proptest! {
    /// No input causes a panic, and a pack never yields more than its maximum number of messages.
    #[test]
    fn any_octets(octets in prop::collection::vec(any::<u8>(), 0..300)) {
        for link in Link::ALL {
            let _ = advertisements(link, &octets);
        }
        prop_assert!(messages(&octets).count() <= 10);
    }

    /// A truncated pack yields the messages before the cut.
    #[test]
    fn any_cut(count in 1_u8..10, length in 0_usize..240) {
        let octets = pack(count, &vec![LOCATION; count.into()]);
        let cut = &octets[..length.min(octets.len())];
        let whole = cut.len().saturating_sub(3) / LENGTH;
        prop_assert_eq!(messages(cut).filter(Result::is_ok).count(), if cut.len() < 3 { 0 } else { whole });
    }
}
