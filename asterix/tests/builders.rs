//! Builders store the given items and name the item of an error.

#![allow(clippy::unwrap_used, reason = "a test that meets the unexpected fails")]

use utm_asterix::cat034::{self, MessageKind, MessageType, SectorNumber};
use utm_asterix::cat048::{self, DetectionType, Height3D, PolarPosition, TargetReport, TrackNumber};
use utm_asterix::cat065::{self, OperationalStatus, SystemStatus};
use utm_asterix::cat129::{self, Altitude, Position};
use utm_asterix::{BuildError, DataSource, Explicit, Record as _, TimeOfDay};

const SOURCE: DataSource = DataSource { sac: 25, sic: 7 };

fn noon() -> Option<TimeOfDay> {
    TimeOfDay::from_seconds(43_200.0)
}

#[test]
fn builder_values_are_in_the_record() {
    let built = cat048::Record::builder(SOURCE, noon(), TargetReport::new(DetectionType::Primary))
        .polar_position(PolarPosition::new(1852.0, 90.0))
        .track_number(TrackNumber::from_octets([0, 7]))
        .special_purpose(Explicit::new(&[254]))
        .build();
    let expected = cat048::Record {
        data_source: Some(SOURCE),
        time_of_day: noon(),
        target_report: Some(TargetReport::new(DetectionType::Primary)),
        polar_position: PolarPosition::new(1852.0, 90.0),
        track_number: TrackNumber::new(7),
        special_purpose: Explicit::new(&[254]),
        ..cat048::Record::default()
    };
    assert_eq!(built, Ok(expected));
}

#[test]
fn the_first_value_out_of_range_is_named() {
    let begin = || cat048::Record::builder(SOURCE, noon(), TargetReport::new(DetectionType::Primary));
    let mistake = |item| Err(BuildError::OutOfRange { category: 48, item });
    assert_eq!(begin().height_3d(Height3D::from_metres(1e6)).build(), mistake("110"));
    let twice = begin().polar_position(PolarPosition::new(-1.0e4, 0.0)).track_number(TrackNumber::new(4096));
    assert_eq!(twice.build(), mistake("040"));
    let late = TimeOfDay::from_seconds(86_400.0);
    let early = cat048::Record::builder(SOURCE, late, TargetReport::new(DetectionType::Primary));
    assert_eq!(early.height_3d(None).build(), mistake("140"));
    assert_eq!(
        mistake("110").unwrap_err().to_string(),
        "CAT048 item 110: a value is out of the range that the item can hold"
    );
}

#[test]
fn a_drone_needs_an_altitude() {
    let begin = || cat129::Record::builder(SOURCE, *b"PL", noon(), Position::new(54.5, 15.0));
    assert_eq!(begin().build(), Err(BuildError::Missing { category: 129, items: "090, 100" }));
    assert!(begin().altitude_agl(Altitude::from_metres(30.0)).build().is_ok());
    assert!(
        begin().altitude_amsl(Altitude::from_metres(120.0)).serial_number(*b"123456784095").build().is_ok()
    );
}

#[test]
fn service_messages() {
    let sector = MessageType::default().with_kind(MessageKind::SectorCrossing);
    let message = cat034::Record::builder(SOURCE, sector, noon())
        .sector_number(SectorNumber::default().with_azimuth_deg(90.0))
        .build()
        .unwrap();
    let mut octets = Vec::new();
    message.encode_into(&mut octets);
    assert_eq!(octets, [0xf0, 25, 7, 2, 0x54, 0x60, 0x00, 0x40]);

    let status = cat065::MessageType::default().with_kind(cat065::MessageKind::SystemStatus);
    let degraded = SystemStatus::default().with_operational_status(OperationalStatus::Degraded);
    let message = cat065::Record::builder(SOURCE, status, noon()).system_status(degraded).build().unwrap();
    octets.clear();
    message.encode_into(&mut octets);
    assert_eq!(octets, [0xd4, 25, 7, 1, 0x54, 0x60, 0x00, 0x40]);
}
