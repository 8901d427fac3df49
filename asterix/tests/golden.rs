//! Octets written by hand, beside what they say; both ways.

#![allow(clippy::unwrap_used, reason = "a test that meets the unexpected fails")]

mod common;

use asterix::cat048::{
    self, AircraftAddress, AircraftIdentification, ClimbMode, DetectionType, FlightLevel, Height3D, Mode3A,
    PolarPosition, TargetReport, TrackNumber, TrackSensor, TrackStatus, TrackVelocity, Warnings,
};
use asterix::cat129::{
    self, Altitude, CertificationCategory, DataDestination, FusionReport, GnssAccuracy, HorizontalVelocity,
    OperationalRisk, Position, VerticalVelocity,
    fusion_report::{Deviation, Flags, Source, UavProbability},
};
use asterix::{
    DataSource, Explicit, FaultKind, Format, RawItem, Record, TimeOfDay, blocks, cat034, encode_block,
};
use common::{DRONE_PLOT, EVERY_ITEM, FULL_UAS, FUSED_POINT, MINIMAL_UAS, block, hex, read};

/// Reads the block, compares with `record`, and writes it back.
fn check<R: Record + PartialEq + std::fmt::Debug>(octets: &str, record: &R) {
    let octets = hex(octets);
    let (records, fault) = read::<R>(&octets);
    assert_eq!(fault, None);
    assert_eq!(records.as_slice(), std::slice::from_ref(record));
    let mut out = Vec::new();
    encode_block(&records, &mut out).unwrap();
    assert_eq!(out, octets);
}

#[test]
fn drone_plot() {
    let record = cat048::Record {
        data_source: Some(DataSource { sac: 25, sic: 7 }),
        time_of_day: TimeOfDay::from_seconds(43_200.0),
        target_report: Some(TargetReport::new(DetectionType::Primary)),
        polar_position: PolarPosition::new(1852.0, 90.0),
        track_number: TrackNumber::new(7),
        warnings: Warnings::new(&[19, 24]),
        height_3d: Height3D::from_metres(-15.24),
        special_purpose: Explicit::new(&[254]),
        ..cat048::Record::default()
    };
    check(DRONE_PLOT, &record);
    assert_eq!(record.raw_items().count(), 0);
}

#[test]
fn every_item_of_cat048() {
    let raw = |frn: usize, octets: &str| RawItem::new(cat048::UAP[frn - 1].format, &hex(octets));
    let record = cat048::Record {
        data_source: Some(DataSource { sac: 20, sic: 129 }),
        time_of_day: TimeOfDay::from_seconds(28_800.5),
        target_report: Some(TargetReport::new(DetectionType::ModeSRollCallAndPrimary).with_test(true)),
        polar_position: Some(PolarPosition { rho: 0x30a6, theta: 0xba34 }),
        mode_3a: Some(Mode3A::from_word(0xe804)),
        flight_level: Some(FlightLevel::from_word(0xfffb)),
        plot_characteristics: raw(7, "fe 01020304050607"),
        aircraft_address: AircraftAddress::new(0x4a_08eb),
        aircraft_identification: AircraftIdentification::new("ROT415"),
        bds_registers: raw(10, "02 0011223344556640 0011223344556650"),
        track_number: Some(TrackNumber::from_word(0xf783)),
        cartesian_position: Some([0x01, 0x00, 0xff, 0x00]),
        track_velocity: TrackVelocity::new(1852.0, 180.0),
        track_status: Some(
            TrackStatus::new()
                .with_tentative(true)
                .with_sensor(TrackSensor::Primary)
                .with_climb_mode(ClimbMode::Unknown)
                .with_ghost(true),
        ),
        track_quality: Some([1, 2, 3, 4]),
        warnings: Warnings::new(&[19, 0, 127]),
        mode_3a_confidence: Some([0x0f, 0xff]),
        mode_c: Some([0x01, 0x23, 0x04, 0x56]),
        height_3d: Some(Height3D::from_word(0xfffe)),
        radial_doppler: raw(20, "c0 8005 01 000a00140bb8"),
        capability: Some([0x2d, 0xf5]),
        acas_advisory: Some([0x30, 0, 0, 0, 0, 0, 0]),
        mode_1: Some([0x1f]),
        mode_2: Some([0x0a, 0xbc]),
        mode_1_confidence: Some([0x1f]),
        mode_2_confidence: Some([0x0f, 0xff]),
        special_purpose: Explicit::new(&[0x80, 0x7f]),
        reserved_expansion: Explicit::new(&[1, 2, 3]),
        fspec_padding: 0,
    };
    check(EVERY_ITEM, &record);
    let raw: Vec<(&str, &[u8])> = record.raw_items().collect();
    assert_eq!(
        raw.iter().map(|&(item, _)| item).collect::<Vec<_>>(),
        ["130", "250", "042", "210", "080", "100", "120", "230", "260", "055", "050", "065", "060", "RE"]
    );
    assert_eq!(raw[6].1, hex("c0 8005 01 000a00140bb8"));
    assert_eq!(raw[13].1, [4, 1, 2, 3]);
}

#[test]
fn minimal_uas() {
    check(
        MINIMAL_UAS,
        &cat129::Record {
            data_source: Some(DataSource { sac: 0, sic: 0 }),
            registration_country: Some(*b"PL"),
            time_of_day: TimeOfDay::from_seconds(43_200.0),
            position: Position::new(54.5, 15.0),
            altitude_amsl: Altitude::from_metres(120.0),
            ..cat129::Record::default()
        },
    );
}

#[test]
fn full_uas() {
    check(
        FULL_UAS,
        &cat129::Record {
            data_source: Some(DataSource { sac: 25, sic: 7 }),
            manufacturer: Some(*b"AIR"),
            model: Some(*b"DIT"),
            serial_number: Some(*b"123456784095"),
            registration_country: Some(*b"FR"),
            time_of_day: TimeOfDay::from_seconds(43_200.5),
            position: Position::new(48.8566, 2.3522),
            altitude_amsl: Altitude::from_metres(123.4),
            altitude_agl: Altitude::from_metres(45.6),
            gnss_accuracy: GnssAccuracy::from_metres(3.0),
            horizontal_velocity: HorizontalVelocity::new(3.0, -1.5),
            vertical_velocity: VerticalVelocity::new(-2.25),
            ..cat129::Record::default()
        },
    );
}

fn fused_point() -> FusionReport {
    FusionReport {
        source: Source::Fused,
        track_number: 10_007,
        radar_track: Some(7),
        transponder: Some(1),
        horizontal_deviation: Deviation::from_metres(2.5),
        vertical_deviation: Deviation::UNKNOWN,
        flags: Flags::INTERPOLATED.with(Flags::HEIGHT_NOT_MEASURED),
        uav_probability: UavProbability::from_probability(0.5),
    }
}

#[test]
fn fused_point_of_the_service() {
    check(
        FUSED_POINT,
        &cat129::Record {
            data_source: Some(DataSource { sac: 25, sic: 10 }),
            time_of_day: TimeOfDay::from_seconds(43_200.0),
            position: Position::new(54.5, 15.0),
            special_purpose: Some(fused_point().to_field()),
            ..cat129::Record::default()
        },
    );
    let (records, _) = read::<cat129::Record>(&hex(FUSED_POINT));
    let report = FusionReport::read(records[0].special_purpose.as_ref().unwrap()).unwrap();
    assert_eq!(report, fused_point());
    assert_eq!(report.horizontal_deviation.metres(), Some(2.5));
    assert_eq!(report.uav_probability.probability(), Some(0.5));
    assert!(report.flags.contains(Flags::INTERPOLATED) && !report.flags.contains(Flags::EXTRAPOLATED));
}

#[test]
fn radar_only_point_knows_no_transponder() {
    let report = FusionReport {
        source: Source::Radar,
        track_number: u32::MAX - 1,
        radar_track: Some(4095),
        transponder: None,
        horizontal_deviation: Deviation::UNKNOWN,
        vertical_deviation: Deviation::UNKNOWN,
        flags: Flags::default(),
        uav_probability: UavProbability::UNKNOWN,
    };
    let field = report.to_field();
    assert_eq!(field.octets(), hex("16 5546 01 02 fffffffe 0fff ffffffff ffff ffff 00 ff 00"));
    assert_eq!(FusionReport::read(&field), Some(report));
}

#[test]
fn other_special_purpose_fields_are_left_alone() {
    let ours = fused_point().to_field();
    let with = |index: usize, octet: u8| {
        let mut contents = ours.contents().to_vec();
        contents[index] = octet;
        Explicit::new(&contents).unwrap()
    };
    assert_eq!(FusionReport::read(&with(0, b'X')), None);
    assert_eq!(FusionReport::read(&with(1, b'X')), None);
    assert_eq!(FusionReport::read(&with(2, 2)), None); // another version
    assert_eq!(FusionReport::read(&with(3, 0)), None); // an unnamed source
    assert_eq!(FusionReport::read(&with(20, 1)), Some(fused_point())); // spare
    assert_eq!(FusionReport::read(&Explicit::new(&ours.contents()[..20]).unwrap()), None);
    assert_eq!(FusionReport::read(&Explicit::new(&[ours.contents(), &[0]].concat()).unwrap()), None);
    assert_eq!(FusionReport::read(&Explicit::new(&[]).unwrap()), None);
}

#[test]
fn deviations_and_probabilities_stay_in_their_ranges() {
    assert_eq!(Deviation::from_metres(1e9).metres(), Some(6553.4));
    assert_eq!(Deviation::from_metres(f64::INFINITY).metres(), Some(6553.4));
    assert_eq!(Deviation::from_metres(0.25).metres(), Some(0.3));
    for unknown in [-1.0, f64::NAN] {
        assert_eq!(Deviation::from_metres(unknown), Deviation::UNKNOWN);
        assert_eq!(UavProbability::from_probability(unknown), UavProbability::UNKNOWN);
    }
    assert_eq!(UavProbability::from_probability(1.0).probability(), Some(1.0));
    assert_eq!(UavProbability::from_probability(1.1), UavProbability::UNKNOWN);
}

#[test]
fn operational_risk_of_one_octet_and_of_three() {
    // 015, 120 and 220, in that order.
    let mut record = cat129::Record {
        data_destination: Some(DataDestination { dac: 1, dic: 2 }),
        operational_risk: OperationalRisk::new(CertificationCategory::Certified, 4, 15),
        vertical_velocity: VerticalVelocity::new(0.01),
        ..cat129::Record::default()
    };
    check("81 000c 410980 0102 ff 000001", &record);
    record.operational_risk = Some(OperationalRisk { octet: 0xff, undescribed: Some([0xaa, 0xbb]) });
    check("81 000e 410980 0102 ffaabb 000001", &record);
}

#[test]
fn operational_risk_counts_as_one_octet_where_the_end_does_not_tell() {
    // Two records in a block, against the edition: the first is read with one octet.
    let two = block(129, &hex("0108 11 0108 22aabb"));
    let (records, fault) = read::<cat129::Record>(&two);
    assert_eq!(fault, None);
    let risks: Vec<_> = records.iter().filter_map(|record| record.operational_risk).collect();
    assert_eq!(risks[0], OperationalRisk { octet: 0x11, undescribed: None });
    assert_eq!(risks[1], OperationalRisk { octet: 0x22, undescribed: Some([0xaa, 0xbb]) });
}

#[test]
fn tables_are_in_order() {
    for uap in [&cat048::UAP[..], &cat129::UAP[..]] {
        for (index, item) in uap.iter().enumerate() {
            assert_eq!(usize::from(item.frn), index + 1);
        }
    }
    assert_eq!(cat048::UAP[18].item, "110");
    assert_eq!(cat129::UAP[11].format, Format::OneOrThree);
}

#[test]
fn raw_items_are_whole() {
    assert!(RawItem::new(cat048::UAP[6].format, &[0x80, 1]).is_some());
    for octets in [&[0x80][..], &[0x80, 1, 2][..], &[0x81, 1][..], &[][..]] {
        assert_eq!(RawItem::new(cat048::UAP[6].format, octets), None);
    }
}

#[test]
fn a_block_too_long_for_len_is_refused_and_leaves_the_octets_as_they_were() {
    let record = cat048::Record { special_purpose: Explicit::new(&[0; 254]), ..cat048::Record::default() };
    let records = vec![record; 254];
    let mut out = vec![1, 2, 3];
    let error = encode_block(&records, &mut out).unwrap_err();
    assert_eq!(error.length, 3 + 254 * 259);
    assert_eq!(out, [1, 2, 3]);
    encode_block(&records[..253], &mut out).unwrap();
    assert_eq!(out.len(), 3 + 3 + 253 * 259);
    assert!(Explicit::new(&[0; 255]).is_none());
}

/// A north marker with status, processing mode and counts, and a sector crossing, in one block.
#[test]
fn a_cat034_block_is_measured() {
    let octets = [
        &[0x22, 0x00, 0x23][..],
        &[0xef, 0x80, 0x19, 0xc9, 0x01, 0x35, 0x6d, 0x4d, 0x02, 0x00], // 010, 000, 030, 041
        &[0x94, 0x40, 0x20, 0x88, 0x00],                               // 050: COM, PSR, MDS
        &[0x9c, 0x00, 0x10, 0x20, 0x30],                               // 060: COM, PSR, SSR, MDS
        &[0x01, 0x08, 0x05],                                           // 070: one count
        &[0xf0, 0x19, 0xc9, 0x02, 0x35, 0x6d, 0x4e, 0x40, 0x00],       // too long by one octet
    ]
    .concat();
    let block = |octets: &[u8]| {
        let mut octets = octets.to_vec();
        octets[2] = octets.len() as u8;
        octets
    };
    let whole = block(&octets[..octets.len() - 1]);
    assert_eq!(blocks(&whole).next().unwrap().unwrap().measure(&cat034::UAP), Ok(2));
    let more = block(&octets);
    let measured = blocks(&more).next().unwrap().unwrap().measure(&cat034::UAP);
    assert_eq!(measured, Ok(3), "one octet of zeros is an empty record");
    let cut = block(&octets[..octets.len() - 2]);
    let fault = blocks(&cut).next().unwrap().unwrap().measure(&cat034::UAP).unwrap_err();
    assert_eq!((fault.item, fault.offset, fault.kind), (Some("020"), cut.len(), FaultKind::ItemPastEnd));
}
