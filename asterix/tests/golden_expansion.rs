//! The hand-made reserved expansion field of CAT048: octets and their values, decoded and encoded.

#![allow(clippy::unwrap_used, reason = "a test that meets the unexpected fails")]

mod common;

use common::{EXPANSION, check, hex};
use utm_asterix::cat048::expansion::{
    AdjacentSensor, AdsbLink, AlternativeCode, AlternativeFlightLevel, Common, CrossSection,
    CrossSectionArea, DataLink, DataLinkOrigin, DataLinkState, Date, ExtendedMode1, ExtendedMode4,
    ExtendedRange, ExtrapolationSource, FigureOfMerit, General, IdentityRequest, Lockout, Mode5,
    Mode5Altitude, Mode5New, Mode5Position, Mode5Summary, NationalOrigin, NewNationalOrigin, PlotLink,
    PlotNumber, PlotQuality, Prediction, RangeWidth, ReplyLink, ReplyType, ReservedExpansion, ScanNumber,
    Score, SignalToClutter, TimeOffset, TrackAcquisition, TrackCharacteristics, TrackLife, TransitionCode,
    TurnState, XPulses,
};
use utm_asterix::{DataSource, Explicit, Repeated, cat048};

fn position(latitude_deg: f64, longitude_deg: f64) -> Option<Mode5Position> {
    Mode5Position::default().with_latitude_deg(latitude_deg)?.with_longitude_deg(longitude_deg)
}

fn mode_5() -> Option<Mode5> {
    Some(Mode5 {
        summary: Some(
            Mode5Summary::default()
                .with_interrogated(true)
                .with_identity(true)
                .with_data(true)
                .with_mode_1(true)
                .with_mode_2(true)
                .with_mode_3(true)
                .with_mode_c(true),
        ),
        origin: NationalOrigin::default()
            .with_pin(0x1234)?
            .with_origin_invalid(true)
            .with_national_origin(5)?
            .with_mission(42),
        position: position(45.0, -45.0),
        altitude: Mode5Altitude::default().with_25_ft(true).with_altitude_ft(-1000.0),
        extended_mode_1: ExtendedMode1::default().with_validated(true).with_code(0o5123),
        time_offset: TimeOffset::default().with_seconds(0.5),
        x_pulses: Some(XPulses::default().with_mode_5_pin(true).with_mode_c(true).with_mode_2(true)),
    })
}

fn mode_5_new() -> Option<Mode5New> {
    Some(Mode5New {
        summary: Some(Mode5Summary::default().with_interrogated(true)),
        origin: NewNationalOrigin::default()
            .with_pin(0x1234)?
            .with_origin_invalid(true)
            .with_national_origin(5),
        position: position(-45.0, 45.0),
        altitude: Mode5Altitude::default().with_altitude_ft(-1000.0),
        extended_mode_1: ExtendedMode1::default().with_code(0o5123),
        time_offset: TimeOffset::default().with_seconds(0.507_812_5),
        x_pulses: Some(XPulses::default().with_mode_5_data(true).with_mode_3a(true).with_mode_1(true)),
        figure_of_merit: FigureOfMerit::default().with_figure(31),
    })
}

fn prediction() -> Option<Prediction> {
    Prediction::default()
        .with_rho_m(1852.0)?
        .with_theta_deg(90.0)?
        .with_evolution_rho_start_m(926.0)?
        .with_evolution_rho_end_m(3704.0)?
        .with_evolution_theta_start_deg(45.0)?
        .with_evolution_theta_end_deg(135.0)?
        .with_noise_rho_start_m(1389.0)?
        .with_noise_rho_end_m(2315.0)?
        .with_noise_theta_start_deg(67.5)?
        .with_noise_theta_end_deg(112.5)?
        .with_time_s(4.0)
}

fn track_characteristics() -> Option<TrackCharacteristics> {
    let adsb = |number| AdsbLink::default().with_number(number);
    Some(TrackCharacteristics {
        plot_link: PlotLink::default()
            .with_network_plot(true)
            .with_all_call(true)
            .with_psr(true)
            .with_plot_number(0x1234),
        adsb_links: Repeated::new(&[adsb(1)?, adsb(2)?]),
        turn_state: TurnState::default().with_percent(50),
        prediction: prediction(),
        data_links: Repeated::new(&[DataLink::default()
            .with_transaction(2)?
            .with_origin(DataLinkOrigin::CurrentScan)
            .with_state(DataLinkState::Completed)]),
        lockout: Lockout::default().with_locked_out(true).with_time_ms(1000),
        transition_code: TransitionCode::default()
            .with_count_1(3)?
            .with_code_1(0x1f)?
            .with_count_2(4)?
            .with_code_2(0o1234)?
            .with_count_3(5)?
            .with_code_3(0o7000),
        life: TrackLife::default()
            .with_acquisition(TrackAcquisition::Confirmed)
            .with_updates(5)?
            .with_last_update_ms(1000),
        adjacent_sensors: Repeated::new(&[AdjacentSensor::default()
            .with_sac(25)?
            .with_sic(7)?
            .with_time_s(0.5)?
            .with_data_use(1)?
            .with_drn_available(true)
            .with_drn(9)?]),
        extrapolation_source: ExtrapolationSource::default().with_source(2),
        identity_request: IdentityRequest::default().with_requested(true).with_mode_3a_age_s(10),
    })
}

fn everything() -> Option<ReservedExpansion> {
    Some(ReservedExpansion {
        mode_5: mode_5(),
        mode_5_new: mode_5_new(),
        extended_mode_4: ExtendedMode4::new(3),
        plot_quality: Some(PlotQuality {
            score: Score::default().with_score(100),
            signal_to_clutter: SignalToClutter::default().with_decibels(20.0),
            range_width: RangeWidth::default().with_metres(1852.0),
            ambiguous_range: RangeWidth::default().with_metres(237_056.0),
        }),
        extended_range: ExtendedRange::default().with_metres(474_112.0),
        track_characteristics: track_characteristics(),
        common: Some(Common {
            plot_number: PlotNumber::default().with_number(0x0102),
            replies: Repeated::new(&[ReplyLink::default()
                .with_reply_type(ReplyType::RollCall)
                .with_number(4)?]),
            scan_number: ScanNumber::default().with_number(5),
            date: Date::default().with_year_digits(0x2026)?.with_month_digits(0x11)?.with_day_digits(0x21),
        }),
        general: Some(General {
            alternative_mode_2: AlternativeCode::default().with_not_validated(true).with_code(0o5123),
            alternative_mode_3a: AlternativeCode::default().with_garbled(true).with_code(0o7000),
            alternative_flight_level: AlternativeFlightLevel::default()
                .with_garbled(true)
                .with_flight_level(-1.25),
            cross_section: CrossSection::default().with_dbm2(-2.0),
            cross_section_area: CrossSectionArea::default().with_m2(1.0),
        }),
    })
}

#[test]
fn every_part_of_the_reserved_expansion_field() {
    let expansion = everything().unwrap();
    let record = cat048::Record {
        data_source: Some(DataSource { sac: 25, sic: 7 }),
        reserved_expansion: expansion.to_field(),
        ..cat048::Record::default()
    };
    check(EXPANSION, &record);
    let read = ReservedExpansion::read(record.reserved_expansion.as_ref().unwrap()).unwrap();
    assert_eq!(read, expansion);
}

#[test]
fn expansion_parts_are_decoded() {
    let octets = hex(EXPANSION);
    let read = ReservedExpansion::read(&Explicit::new(&octets[3 + 4 + 2 + 1..]).unwrap()).unwrap();
    let mode_5 = read.mode_5.unwrap();
    let position = mode_5.position.unwrap();
    assert_eq!((position.latitude_deg(), position.longitude_deg()), (45.0, -45.0));
    assert_eq!(mode_5.altitude.unwrap().altitude_ft(), -1000.0);
    assert_eq!(mode_5.origin.unwrap().mission(), 42);
    assert_eq!(read.mode_5_new.unwrap().figure_of_merit.unwrap().figure(), 31);
    assert_eq!(read.extended_mode_4.unwrap().friend_or_foe(), 3);
    assert_eq!(read.plot_quality.unwrap().ambiguous_range.unwrap().metres(), 237_056.0);
    assert_eq!(read.extended_range.unwrap().metres(), 474_112.0);
    let track = read.track_characteristics.unwrap();
    let numbers: Vec<u16> = track.adsb_links.unwrap().iter().map(|link| link.number()).collect();
    assert_eq!(numbers, [1, 2]);
    assert_eq!(track.prediction.unwrap().noise_rho_end_m(), 2315.0);
    assert_eq!(track.transition_code.unwrap().code_2(), 0o1234);
    let sensor = track.adjacent_sensors.unwrap()[0];
    assert_eq!((sensor.data_use(), sensor.has_drn(), sensor.drn()), (1, true, 9));
    assert_eq!(track.identity_request.unwrap().mode_3a_age_s(), 10);
    assert_eq!(read.common.unwrap().date.unwrap().year_digits(), 0x2026);
    let general = read.general.unwrap();
    assert_eq!(general.cross_section.unwrap().dbm2(), -2.0);
    assert_eq!(general.cross_section_area.unwrap().m2(), 1.0);
    assert_eq!(general.alternative_flight_level.unwrap().flight_level(), -1.25);
}

#[test]
fn a_field_that_is_not_of_edition_1_13_stays_as_it_is() {
    for contents in [
        "",                       // announces nothing
        "08 0100",                // ERR cut
        "08 010000 00",           // an octet too many
        "10 08 00",               // RPC announces an undefined subfield
        "40 0100",                // M5N with an octet of its primary subfield that announces nothing
        "04 fff1 00",             // RTC announces more subfields than there are
        "80 ff 00",               // MD5 likewise
        "20 0101010101010101 01", // M4E goes on past the end
    ] {
        let field = Explicit::new(&hex(contents)).unwrap();
        assert_eq!(ReservedExpansion::read(&field), None, "{contents}");
    }
    // A field that announces nothing and has no contents is valid; M4E keeps an undefined extension.
    for contents in ["00", "20 0704"] {
        let field = Explicit::new(&hex(contents)).unwrap();
        let read = ReservedExpansion::read(&field).unwrap();
        assert_eq!(read.to_field(), Some(field), "{contents}");
    }
    let mut long = everything().unwrap();
    let links = vec![AdsbLink::default(); 100];
    long.track_characteristics.as_mut().unwrap().adsb_links = Repeated::new(&links);
    assert_eq!(long.to_field(), None);
}
