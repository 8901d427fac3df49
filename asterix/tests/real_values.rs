//! Values of real data: one test for each peculiarity of radars, transponders and their clocks.

#![allow(clippy::unwrap_used, reason = "a test that meets the unexpected fails")]

mod common;

use common::{block, encode, hex, read};
use utm_asterix::cat048::{self, Height3D};
use utm_asterix::{Chain, Fault, cat034, cat065, cat129};

fn plot(contents: &str) -> (Vec<cat048::Record>, Option<Fault>) {
    read(&block(48, &hex(contents)))
}

#[test]
fn negative_flight_level_and_height() {
    let (records, _) = plot("05 01 08  3ffb ff00");
    assert_eq!(records[0].flight_level.unwrap().flight_level(), -1.25);
    assert_eq!(records[0].height_3d.unwrap().height_ft(), -6400.0);
}

#[test]
fn several_warnings_and_unknown_ones() {
    let (records, _) = plot("010140 27 fd 2e");
    assert_eq!(records[0].warnings, cat048::Warnings::new(&[19, 126, 23]));
}

#[test]
fn spare_bits_are_kept() {
    let contents = hex("01 11 08 f001 ff00");
    let (records, fault) = read::<cat048::Record>(&block(48, &contents));
    assert_eq!(fault, None);
    assert_eq!(encode(&records[0]), contents);
    let contents = hex("01 03 80 0012cfff6a ffff1f");
    let (records, _) = read::<cat129::Record>(&block(129, &contents));
    assert_eq!(records[0].vertical_velocity.unwrap().up_m_s(), -2.25);
    assert_eq!(encode(&records[0]), contents);
}

#[test]
fn unaligned_and_24_bit_numbers_keep_their_sign() {
    // 090, 185, 220: -1 count each, and the maximum.
    let (records, _) = read::<cat129::Record>(&block(129, &hex("01 43 80 ffffff fffff80000 0fffff")));
    let record = &records[0];
    assert_eq!(record.altitude_amsl.unwrap().metres(), -0.1);
    let velocity = record.horizontal_velocity.unwrap();
    assert_eq!((velocity.east_m_s(), velocity.north_m_s()), (-0.01, -5242.88));
    assert_eq!(record.vertical_velocity.unwrap().up_m_s(), -0.01);
}

#[test]
fn time_of_day_past_the_end_of_the_day() {
    let (records, fault) = plot("40 a8c000 40 ffffff 40 000000");
    assert_eq!(fault, None);
    let times: Vec<_> = records.iter().map(|record| record.time_of_day.unwrap()).collect();
    assert_eq!(times[0].seconds(), 86_400.0);
    assert_eq!(times[1].seconds(), 131_071.992_187_5);
    let of_the_day: Vec<bool> = times.iter().map(|time| time.in_range()).collect();
    assert_eq!(of_the_day, [false, false, true]);
}

#[test]
fn position_off_the_earth() {
    let (records, fault) =
        read::<cat129::Record>(&block(129, &hex("0180 20000001 00000000 0180 20000000 c0000000")));
    assert_eq!(fault, None);
    let on_the_earth: Vec<bool> = records.iter().map(|record| record.position.unwrap().in_range()).collect();
    assert_eq!(on_the_earth, [false, true]);
}

#[test]
fn serial_number_that_is_no_text() {
    let contents = hex("08 00ff80c3 28000000 0000007f");
    let (records, fault) = read::<cat129::Record>(&block(129, &contents));
    assert_eq!(fault, None);
    assert_eq!(records[0].serial_number.unwrap()[..5], [0x00, 0xff, 0x80, 0xc3, 0x28]);
    assert_eq!(encode(&records[0]), contents);
}

#[test]
fn spare_bits_are_kept_in_every_item_that_has_some() {
    // 070, 170, 080, 100, 120 (CAL), 230, 055, 050, 065, 060: all bits set but the last FX.
    let contents = hex("09033778 ffff fffe ffff ffffffff 80ffff ffff ff ffff ff ffff");
    let (records, fault) = read::<cat048::Record>(&block(48, &contents));
    assert_eq!(fault, None);
    let record = &records[0];
    assert_eq!(encode(record), contents);
    assert_eq!(record.mode_3a.unwrap().code(), 0o7777);
    assert_eq!(record.radial_doppler.as_ref().unwrap().calculated.unwrap().speed_m_s(), -1.0);
    assert!(record.track_status.unwrap().is_slant_range_corrected());
    // Setters leave these bits unchanged.
    let mode_2 = record.mode_2.unwrap().with_code(0o1234).unwrap().with_garbled(false);
    assert_eq!(mode_2.octets(), [0xb2, 0x9c]);
    // 034/050 and 060, every subfield; 065/040.
    let contents = hex("06 9c ff ff ff ffff 9c ff ff ff ff");
    let (records, fault) = read::<cat034::Record>(&block(34, &contents));
    assert_eq!((fault, encode(&records[0])), (None, contents));
    let contents = hex("04 ff");
    let (records, fault) = read::<cat065::Record>(&block(65, &contents));
    assert_eq!((fault, encode(&records[0])), (None, contents));
}

#[test]
fn signs_of_the_other_widths() {
    // 042 (16 bits), 130 SAM and RPD (8), 120 CAL (10): -1 count each, then the minimum.
    let (records, _) = plot("030904 24ffff ffffffff 8003ff 030904 248080 80008000 800200");
    for (record, count) in records.iter().zip([[-1.0; 3], [-128.0, -32_768.0, -512.0]]) {
        let plot = record.plot_characteristics.as_ref().unwrap();
        assert_eq!(plot.ssr_amplitude.unwrap().dbm(), count[0]);
        assert_eq!(plot.range_difference.unwrap().metres(), count[0] * 7.234_375);
        let position = record.cartesian_position.unwrap();
        assert_eq!((position.x_m(), position.y_m()), (count[1] * 14.468_75, count[1] * 14.468_75));
        let doppler = record.radial_doppler.as_ref().unwrap();
        assert_eq!(doppler.calculated.unwrap().speed_m_s(), count[2]);
    }
    assert_eq!(records.len(), 2);
    // 034/120: 24 bits at an odd offset.
    let (records, _) = read::<cat034::Record>(&block(34, &hex("0110 ffff ffffff 800000")));
    let position = records[0].source_position.unwrap();
    let lsb = 180.0 / f64::from(1 << 23);
    assert_eq!(
        (position.height_m(), position.latitude_deg(), position.longitude_deg()),
        (-1.0, -lsb, -180.0)
    );
}

#[test]
fn midnight() {
    let (records, fault) = plot("40 a8bfff 40 000000");
    assert_eq!(fault, None);
    let times: Vec<f64> = records.iter().map(|record| record.time_of_day.unwrap().seconds()).collect();
    assert_eq!(times, [86_399.992_187_5, 0.0]);
    assert!(records.iter().all(|record| record.time_of_day.unwrap().in_range()));
    // All categories report it in the same way.
    let (records, _) = read::<cat034::Record>(&block(34, &hex("20 a8c000")));
    assert!(!records[0].time_of_day.unwrap().in_range());
    let (records, _) = read::<cat065::Record>(&block(65, &hex("10 a8bfff")));
    assert!(records[0].time_of_day.unwrap().in_range());
}

#[test]
fn position_of_the_radar_to_two_metres_and_a_half() {
    let radar = cat034::SourcePosition::default()
        .with_height_m(27.3)
        .and_then(|position| position.with_latitude_deg(41.300_700))
        .and_then(|position| position.with_longitude_deg(2.102_058))
        .unwrap();
    let contents = [hex("0110"), radar.octets().to_vec()].concat();
    let (records, fault) = read::<cat034::Record>(&block(34, &contents));
    assert_eq!(fault, None);
    let position = records[0].source_position.unwrap();
    assert_eq!(position.height_m(), 27.0);
    let metres_in_a_degree = 1852.0 * 60.0;
    let lsb_m = 180.0 / f64::from(1 << 23) * metres_in_a_degree;
    assert!((lsb_m - 2.4).abs() < 0.02);
    assert!((position.latitude_deg() - 41.300_700).abs() * metres_in_a_degree <= lsb_m / 2.0);
    assert!((position.longitude_deg() - 2.102_058).abs() * metres_in_a_degree <= lsb_m / 2.0);
    // Latitudes beyond the poles decode, as in CAT129.
    let (records, fault) = read::<cat034::Record>(&block(34, &hex("0110 0000 7fffff 000000")));
    assert_eq!(fault, None);
    assert!(records[0].source_position.unwrap().latitude_deg() > 179.9);
}

#[test]
fn a_radar_that_warns_of_itself() {
    // NOGO, RDPR (track numbers will be assigned again) and TSV (the time source is invalid), one at a time.
    for (octet, expected) in [
        ("80", [true, false, false]),
        ("20", [false, true, false]),
        ("02", [false, false, true]),
        ("5d", [false, false, false]),
        ("a2", [true, true, true]),
    ] {
        let (records, fault) = read::<cat034::Record>(&block(34, &hex(&format!("04 80 {octet}"))));
        assert_eq!(fault, None);
        let status = records[0].system_status.as_ref().unwrap().common.unwrap();
        assert_eq!([status.is_nogo(), status.is_reset(), status.is_time_invalid()], expected, "{octet}");
    }
}

#[test]
fn codes_that_the_editions_do_not_define() {
    let (records, fault) = read::<cat034::Record>(&block(34, &hex("41 80 63 01 f805")));
    assert_eq!(fault, None);
    assert_eq!(records[0].message_type.unwrap().kind(), cat034::MessageKind::Other(99));
    let counts = records[0].message_counts.as_ref().unwrap();
    assert_eq!((counts[0].kind(), counts[0].count()), (cat034::CounterKind::Other(31), 5));
    let (records, fault) = read::<cat065::Record>(&block(65, &hex("42 00 ff")));
    assert_eq!(fault, None);
    assert_eq!(records[0].message_type.unwrap().kind(), cat065::MessageKind::Other(0));
    assert_eq!(records[0].service_status.unwrap().event(), cat065::ServiceEvent::Other(255));
    let (records, fault) = plot("010102 1800");
    assert_eq!(fault, None);
    assert_eq!(records[0].capability.unwrap().flight_status(), cat048::FlightStatus::Other(6));
}

#[test]
fn target_report_with_undefined_extension_is_decoded() {
    let mut chain = Chain::new(0x20);
    for (index, octet) in [0x80, 0xc0, 0x10, 0xe0, 0xd0, 0xfe, 0x02].into_iter().enumerate() {
        chain = chain.with(index + 1, 0xff, octet);
    }
    let contents = [&[0x20], chain.octets()].concat();
    let (records, fault) = read::<cat048::Record>(&block(48, &contents));
    assert_eq!((fault, encode(&records[0])), (None, contents));
    let report = records[0].target_report.unwrap();
    assert!(report.is_test());
    assert_eq!((report.on_site_adsb(), report.surveillance_cluster()), (Some(true), None));
    assert_eq!((report.acas_version(), report.phase_overlay_active()), (None, Some(true)));
    assert_eq!((report.reply_monitoring_supported(), report.reply_monitoring_active()), (Some(true), None));
    assert_eq!(report.chain().octet(7), Some(0x02));
}

#[test]
fn heights_in_steps_of_25_ft() {
    for (word, height_m) in [(0x0001_u16, 7.62), (0x3fff, -7.62), (0x1fff, 62_415.42), (0x2000, -62_423.04)] {
        assert!((Height3D::from_octets(word.to_be_bytes()).height_m() - height_m).abs() < 1e-9);
    }
}
