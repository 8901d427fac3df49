//! Hand-made CAT048: octets and their values, decoded and encoded.

#![allow(clippy::unwrap_used, reason = "a test that meets the unexpected fails")]

mod common;

use common::{DRONE_PLOT, EVERY_ITEM, check, hex, read};
use utm_asterix::cat048::{
    self, AcasAdvisory, AircraftAddress, AircraftIdentification, Amplitude, AzimuthDifference, BdsRegister,
    CalculatedDoppler, Capability, CartesianPosition, ClimbMode, Communications, DetectionType, FlightLevel,
    FlightStatus, Height3D, Mode1, Mode1Confidence, Mode2, Mode2Confidence, Mode3A, Mode3AConfidence, ModeC,
    PlotCharacteristics, PolarPosition, RadialDoppler, RangeDifference, RawDoppler, Replies,
    ReservedExpansion, RunLength, TargetReport, TrackNumber, TrackQuality, TrackSensor, TrackStatus,
    TrackVelocity, Warnings,
};
use utm_asterix::{
    DataSource, Explicit, Layout, Repeated, TimeOfDay, cat034, cat065, cat129, encode_block, items, profile,
};

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
}

#[test]
fn every_item_of_cat048() {
    let register = |bds1| {
        BdsRegister::default()
            .with_data(0x00_1122_3344_5566)
            .and_then(|register| register.with_bds1(bds1))
            .unwrap()
    };
    let record = cat048::Record {
        data_source: Some(DataSource { sac: 20, sic: 129 }),
        time_of_day: TimeOfDay::from_seconds(28_800.5),
        target_report: Some(TargetReport::new(DetectionType::ModeSRollCallAndPrimary).with_test(true)),
        polar_position: Some(PolarPosition::from_octets([0x30, 0xa6, 0xba, 0x34])),
        mode_3a: Some(Mode3A::from_octets([0xe8, 0x04])),
        flight_level: Some(FlightLevel::from_octets([0xff, 0xfb])),
        plot_characteristics: Some(PlotCharacteristics {
            ssr_run_length: RunLength::default().with_degrees(1.054_687_5),
            ssr_replies: Replies::default().with_number(4),
            ssr_amplitude: Amplitude::default().with_dbm(-55.0),
            psr_run_length: RunLength::default().with_degrees(0.31),
            psr_amplitude: Amplitude::default().with_dbm(42.0),
            range_difference: RangeDifference::default().with_metres(72.0),
            azimuth_difference: AzimuthDifference::default().with_degrees(-0.088),
        }),
        aircraft_address: AircraftAddress::new(0x4a_08eb),
        aircraft_identification: AircraftIdentification::new("ROT415"),
        bds_registers: Repeated::new(&[register(4), register(5)]),
        track_number: Some(TrackNumber::from_octets([0xf7, 0x83])),
        cartesian_position: CartesianPosition::default()
            .with_x_m(3704.0)
            .and_then(|position| position.with_y_m(-3704.0)),
        track_velocity: TrackVelocity::new(1852.0, 180.0),
        track_status: Some(
            TrackStatus::new()
                .with_tentative(true)
                .with_sensor(TrackSensor::Primary)
                .with_climb_mode(ClimbMode::Unknown)
                .with_ghost(true),
        ),
        track_quality: TrackQuality::default()
            .with_sigma_x_m(14.0)
            .and_then(|quality| quality.with_sigma_y_m(29.0))
            .and_then(|quality| quality.with_sigma_v_m_s(0.34))
            .and_then(|quality| quality.with_sigma_h_deg(0.35)),
        warnings: Warnings::new(&[19, 0, 127]),
        mode_3a_confidence: Mode3AConfidence::default().with_low_quality(0o7777),
        mode_c: ModeC::default().with_gray_code(0x123).and_then(|code| code.with_low_quality(0x456)),
        height_3d: Some(Height3D::from_octets([0xff, 0xfe])),
        radial_doppler: Some(RadialDoppler {
            calculated: CalculatedDoppler::default().with_doubtful(true).with_speed_m_s(-5.0),
            raw: Repeated::new(&[RawDoppler::default()
                .with_doppler_m_s(10)
                .and_then(|doppler| doppler.with_ambiguity_m_s(20))
                .and_then(|doppler| doppler.with_frequency_mhz(3000))
                .unwrap()]),
        }),
        capability: Capability::default()
            .with_communications(Communications::CommAB)
            .with_flight_status(FlightStatus::AlertOnGround)
            .with_specific_services(true)
            .with_25_ft(true)
            .with_identification(true)
            .with_bds_10_bit_16(true)
            .with_bds_10_bits_37_to_40(5),
        acas_advisory: AcasAdvisory::default().with_data(0x30_0000_0000_0000),
        mode_1: Mode1::default().with_code_bits(0x1f),
        mode_2: Mode2::default().with_code(0o5274),
        mode_1_confidence: Mode1Confidence::default().with_low_quality(0x1f),
        mode_2_confidence: Mode2Confidence::default().with_low_quality(0o7777),
        special_purpose: Explicit::new(&[0x80, 0x7f]),
        reserved_expansion: Explicit::new(&[1, 2, 3]),
        fspec_padding: 0,
    };
    check(EVERY_ITEM, &record);
    // Its GEN48 announces a subfield that edition 1.13 does not define.
    assert_eq!(ReservedExpansion::read(record.reserved_expansion.as_ref().unwrap()), None);
}

#[test]
fn cat048_items_are_decoded() {
    let (records, _) = read::<cat048::Record>(&hex(EVERY_ITEM));
    let record = &records[0];
    let plot = record.plot_characteristics.as_ref().unwrap();
    assert_eq!(plot.ssr_run_length.unwrap().degrees(), 1.054_687_5);
    assert_eq!((plot.ssr_replies.unwrap().number(), plot.ssr_amplitude.unwrap().dbm()), (4, -55.0));
    assert_eq!(plot.psr_run_length.unwrap().degrees(), 0.307_617_187_5);
    assert_eq!(plot.psr_amplitude.unwrap().dbm(), 42.0);
    assert_eq!(plot.range_difference.unwrap().metres(), 72.343_75);
    assert_eq!(plot.azimuth_difference.unwrap().degrees(), -0.087_890_625);
    let registers = record.bds_registers.as_ref().unwrap();
    assert_eq!(registers.len(), 2);
    assert_eq!((registers[1].data(), registers[1].bds1(), registers[1].bds2()), (0x00_1122_3344_5566, 5, 0));
    let position = record.cartesian_position.unwrap();
    assert_eq!((position.x_m(), position.y_m()), (3704.0, -3704.0));
    let quality = record.track_quality.unwrap();
    assert_eq!((quality.sigma_x_m(), quality.sigma_y_m()), (14.468_75, 28.937_5));
    assert_eq!((quality.sigma_v_m_s(), quality.sigma_h_deg()), (0.339_111_328_125, 0.351_562_5));
    let doppler = record.radial_doppler.as_ref().unwrap();
    assert!(doppler.calculated.unwrap().is_doubtful());
    assert_eq!(doppler.calculated.unwrap().speed_m_s(), -5.0);
    let raw = doppler.raw.as_ref().unwrap()[0];
    assert_eq!((raw.doppler_m_s(), raw.ambiguity_m_s(), raw.frequency_mhz()), (10, 20, 3000));
    let capability = record.capability.unwrap();
    assert_eq!(capability.communications(), Communications::CommAB);
    assert_eq!(capability.flight_status(), FlightStatus::AlertOnGround);
    assert_eq!(record.mode_c.unwrap().gray_code(), 0x123);
    assert_eq!(record.mode_1_confidence.unwrap().low_quality(), 0x1f);
    assert_eq!(record.mode_2.unwrap().code(), 0o5274);
}

#[test]
fn items_of_a_record_with_their_octets() {
    let octets = hex(EVERY_ITEM);
    let walked: Vec<_> = items(cat048::UAP, &octets[3..]).collect();
    let numbers: Vec<&str> = walked.iter().map(|(item, _)| item.item).collect();
    assert!(numbers.into_iter().eq(cat048::UAP.iter().map(|item| item.item)));
    assert_eq!(walked[6].1, hex("fe1804c9072a0afc"));
    assert_eq!(walked[19].1, hex("c0 83fb 01 000a00140bb8"));
    assert_eq!(walked[27].1, [4, 1, 2, 3]);
    assert_eq!(walked.iter().map(|(_, octets)| octets.len()).sum::<usize>(), octets.len() - 3 - 4);
    // The rest of an incomplete record is left out.
    assert_eq!(items(cat048::UAP, &octets[3..20]).count(), 5);
    assert_eq!(items(cat048::UAP, &[0xff]).count(), 0);
}

#[test]
fn tables_are_in_order() {
    for uap in [cat034::UAP, cat048::UAP, cat129::UAP] {
        for (index, item) in uap.iter().enumerate() {
            assert_eq!(usize::from(item.frn), index + 1);
        }
    }
    assert!(cat065::UAP.iter().map(|item| item.frn).eq([1, 2, 3, 4, 5, 6, 7, 13, 14]));
    assert_eq!(cat048::UAP[18].item, "110");
    assert!(matches!(cat129::UAP[11].layout, Layout::OneOrThree(_)));
    assert_eq!(profile(34), Some(cat034::UAP));
    assert_eq!(profile(48), Some(cat048::UAP));
    assert_eq!(profile(65), Some(cat065::UAP));
    assert_eq!(profile(129), Some(cat129::UAP));
    assert_eq!(profile(61), None);
}

#[test]
fn repetition_has_a_count_of_one_octet() {
    assert!(Repeated::new(&[BdsRegister::default(); 255]).is_some());
    assert_eq!(Repeated::new(&[BdsRegister::default(); 256]), None);
    assert_eq!(Repeated::<BdsRegister>::new(&[]).unwrap().len(), 0);
}

#[test]
fn block_too_long_for_len_is_refused_without_writing() {
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
