//! Hand-made CAT129: octets and their values, decoded and encoded.

#![allow(clippy::unwrap_used, reason = "a test that meets the unexpected fails")]

mod common;

use common::{FULL_UAS, FUSED_POINT, MINIMAL_UAS, block, check, hex, read};
use utm_asterix::cat129::{
    self, Altitude, CertificationCategory, DataDestination, FusionReport, GnssAccuracy, HorizontalVelocity,
    OperationalRisk, Position, RiskCategories, VerticalVelocity, WholeSerial,
    fusion_report::{Deviation, Flags, Source, UavProbability},
};
use utm_asterix::{DataSource, Explicit, TimeOfDay};

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
    record.operational_risk = Some(OperationalRisk {
        categories: RiskCategories::from_octets([0xff]),
        undescribed: Some([0xaa, 0xbb]),
    });
    check("81 000e 410980 0102 ffaabb 000001", &record);
}

#[test]
fn operational_risk_of_unclear_length_is_one_octet() {
    // Two records in a block, which the edition does not allow: the first is read with one octet.
    let two = block(129, &hex("0108 11 0108 22aabb"));
    let (records, fault) = read::<cat129::Record>(&two);
    assert_eq!(fault, None);
    let risks: Vec<_> = records.iter().filter_map(|record| record.operational_risk).collect();
    assert_eq!(
        risks[0],
        OperationalRisk { categories: RiskCategories::from_octets([0x11]), undescribed: None }
    );
    assert_eq!(
        risks[1],
        OperationalRisk { categories: RiskCategories::from_octets([0x22]), undescribed: Some([0xaa, 0xbb]) }
    );
}

#[test]
fn whole_serial_number_follows_the_report_or_is_alone() {
    let serial = WholeSerial::new(b"1581F4FKD2291000A4").unwrap();
    let field = fused_point().to_field_with(&serial);
    let report = fused_point().to_field();
    let digits = "31353831463446 4b44323239313030304134 2020";
    assert_eq!(field.octets()[..4], hex("2a 5546 02")[..]);
    assert_eq!(field.octets()[4..22], report.octets()[4..], "version 1 otherwise");
    assert_eq!(field.octets()[22..], hex(digits)[..]);
    assert_eq!(FusionReport::read(&field), Some(fused_point()));
    assert_eq!(WholeSerial::read(&field), Some(serial));
    assert_eq!(serial.last(), *b"F4FKD2291000A4"[2..].first_chunk().unwrap());
    let alone = serial.to_field();
    assert_eq!(alone.octets(), hex(&format!("18 5546 03 {digits}")));
    assert_eq!((FusionReport::read(&alone), WholeSerial::read(&alone)), (None, Some(serial)));
    assert_eq!(WholeSerial::read(&report), None);
    assert_eq!(WholeSerial::new(&[b'1'; 21]), None);
    assert_eq!(WholeSerial::new(b"TEST-1").unwrap().last(), *b"TEST-1      ");
    // Truncated, and longer than stated.
    for contents in [&field.contents()[..40], &[field.contents(), &[0]].concat()] {
        let field = Explicit::new(contents).unwrap();
        assert_eq!((FusionReport::read(&field), WholeSerial::read(&field)), (None, None));
    }
}
