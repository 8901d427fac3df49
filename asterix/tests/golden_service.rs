//! Hand-made CAT034 and CAT065: octets and their values, decoded and encoded.

#![allow(clippy::unwrap_used, reason = "a test that meets the unexpected fails")]

mod common;

use common::{SERVICE_MESSAGE, SERVICE_STATUS, block, check, hex, read};
use utm_asterix::cat034::{
    self, Channels, CollimationError, CommonMode, CommonStatus, CounterKind, DataFilter, Filter,
    MessageCount, MessageKind, MessageType, ModeSMode, ModeSStatus, PolarWindow, PsrMode, RotationPeriod,
    SectorNumber, SensorStatus, SourcePosition, SsrMode, SystemMode, SystemStatus,
};
use utm_asterix::cat065::{
    self, BatchNumber, OperationalStatus, ProcessingSystem, ServiceEvent, ServiceIdentification,
    ServiceStatus,
};
use utm_asterix::{DataSource, Explicit, FaultKind, Repeated, TimeOfDay, blocks};

#[test]
fn every_item_of_cat034() {
    let count = |kind, count| MessageCount::default().with_kind(kind).with_count(count).unwrap();
    let record = cat034::Record {
        data_source: Some(DataSource { sac: 25, sic: 7 }),
        message_type: Some(MessageType::default().with_kind(MessageKind::NorthMarker)),
        time_of_day: TimeOfDay::from_seconds(43_200.0),
        sector_number: SectorNumber::default().with_azimuth_deg(90.0),
        rotation_period: RotationPeriod::default().with_period_s(4.0),
        system_status: Some(SystemStatus {
            common: Some(CommonStatus::default().with_nogo(true).with_reset(true).with_time_invalid(true)),
            psr: Some(SensorStatus::default().with_channels(Channels::Both).with_overloaded(true)),
            ssr: Some(
                SensorStatus::default()
                    .with_antenna_2(true)
                    .with_channels(Channels::A)
                    .with_monitor_disconnected(true),
            ),
            mode_s: Some(
                ModeSStatus::default()
                    .with_channels(Channels::B)
                    .with_overloaded(true)
                    .with_co_ordination_on_b(true)
                    .with_co_ordination_overloaded(true),
            ),
        }),
        system_mode: Some(SystemMode {
            common: CommonMode::default()
                .with_processor_reduction(5)
                .and_then(|mode| mode.with_transmission_reduction(5)),
            psr: PsrMode::default()
                .with_circular(true)
                .with_reduction(5)
                .and_then(|mode| mode.with_sensitivity_map(1)),
            ssr: SsrMode::default().with_reduction(3),
            mode_s: ModeSMode::default().with_in_cluster(true).with_reduction(2),
        }),
        message_counts: Repeated::new(&[count(CounterKind::Psr, 5), count(CounterKind::RollCall, 2047)]),
        polar_window: PolarWindow::default()
            .with_rho_start_m(1852.0)
            .and_then(|window| window.with_rho_end_m(3704.0))
            .and_then(|window| window.with_theta_start_deg(90.0))
            .and_then(|window| window.with_theta_end_deg(180.0)),
        data_filter: Some(DataFilter::default().with_filter(Filter::Psr)),
        source_position: SourcePosition::default()
            .with_height_m(27.0)
            .and_then(|position| position.with_latitude_deg(45.0))
            .and_then(|position| position.with_longitude_deg(-1.406_25)),
        collimation_error: CollimationError::default()
            .with_range_m(-14.0)
            .and_then(|error| error.with_azimuth_deg(-2.8125)),
        reserved_expansion: Explicit::new(&[0xaa, 0xbb]),
        special_purpose: Explicit::new(&[0xfe]),
        fspec_padding: 0,
    };
    check(SERVICE_MESSAGE, &record);
}

#[test]
fn cat034_items_are_decoded() {
    let (records, _) = read::<cat034::Record>(&hex(SERVICE_MESSAGE));
    let record = &records[0];
    assert_eq!(record.message_type.unwrap().kind(), MessageKind::NorthMarker);
    assert_eq!(record.sector_number.unwrap().azimuth_deg(), 90.0);
    assert_eq!(record.rotation_period.unwrap().period_s(), 4.0);
    let status = record.system_status.as_ref().unwrap();
    let common = status.common.unwrap();
    assert!(common.is_nogo() && common.is_reset() && common.is_time_invalid() && !common.is_chain_2());
    assert_eq!(status.ssr.unwrap().channels(), Channels::A);
    assert!(!status.mode_s.unwrap().is_data_link_overloaded());
    let mode = record.system_mode.as_ref().unwrap();
    assert_eq!((mode.ssr.unwrap().reduction(), mode.mode_s.unwrap().reduction()), (3, 2));
    assert_eq!(record.polar_window.unwrap().rho_end_m(), 3704.0);
    assert_eq!(record.data_filter.unwrap().filter(), Filter::Psr);
    let position = record.source_position.unwrap();
    assert_eq!(
        (position.height_m(), position.latitude_deg(), position.longitude_deg()),
        (27.0, 45.0, -1.406_25)
    );
    assert_eq!(record.collimation_error.unwrap().range_m(), -14.468_75);
}

#[test]
fn every_item_of_cat065() {
    let record = cat065::Record {
        data_source: Some(DataSource { sac: 25, sic: 7 }),
        message_type: Some(cat065::MessageType::default().with_kind(cat065::MessageKind::SystemStatus)),
        service_identification: ServiceIdentification::default().with_number(3),
        time_of_day: TimeOfDay::from_seconds(43_200.0),
        batch_number: BatchNumber::default().with_number(2),
        system_status: Some(
            cat065::SystemStatus::default()
                .with_operational_status(OperationalStatus::NotConnected)
                .with_time_invalid(true)
                .with_processing_system(ProcessingSystem::First)
                .with_renumbering(true),
        ),
        service_status: Some(ServiceStatus::default().with_event(ServiceEvent::MainRadarOperational)),
        reserved_expansion: Explicit::new(&[0xaa]),
        special_purpose: Explicit::new(&[0xbb]),
        fspec_padding: 0,
    };
    check(SERVICE_STATUS, &record);
    let (records, _) = read::<cat065::Record>(&hex(SERVICE_STATUS));
    let status = records[0].system_status.unwrap();
    assert_eq!(status.operational_status(), OperationalStatus::NotConnected);
    assert_eq!(status.processing_system(), ProcessingSystem::First);
    assert!(status.is_time_invalid() && status.renumbering() && !status.is_overloaded());
    assert_eq!(records[0].service_status.unwrap().event(), ServiceEvent::MainRadarOperational);
}

/// A north marker with status, processing mode and counts, and a sector crossing, in one block.
#[test]
fn north_marker_and_sector_crossing_in_a_block() {
    let contents = [
        hex("ef80 19c9 01 356d4d 0200"), // 010, 000, 030, 041
        hex("94 40 20 8800"),            // 050: COM, PSR, MDS
        hex("9c 00 10 20 30"),           // 060: COM, PSR, SSR, MDS
        hex("01 0805"),                  // 070: one count
        hex("f0 19c9 02 356d4e 40"),
    ]
    .concat();
    let octets = block(34, &contents);
    assert_eq!(blocks(&octets).next().unwrap().unwrap().measure(cat034::UAP), Ok(2));
    let (records, fault) = read::<cat034::Record>(&octets);
    assert_eq!((records.len(), fault), (2, None));
    let [marker, crossing] = records.as_slice() else { panic!() };
    assert_eq!(marker.data_source, Some(DataSource { sac: 25, sic: 201 }));
    assert_eq!(marker.message_type.unwrap().kind(), MessageKind::NorthMarker);
    assert_eq!(marker.time_of_day.unwrap().seconds(), 27_354.601_562_5);
    assert_eq!(marker.rotation_period.unwrap().period_s(), 4.0);
    let status = marker.system_status.as_ref().unwrap();
    let common = status.common.unwrap();
    assert!(common.is_chain_2() && !common.is_nogo() && !common.is_reset() && !common.is_time_invalid());
    assert_eq!(status.psr.unwrap().channels(), Channels::A);
    assert_eq!(status.ssr, None);
    let mode_s = status.mode_s.unwrap();
    assert!(mode_s.is_antenna_2() && mode_s.is_monitor_disconnected());
    assert_eq!(mode_s.channels(), Channels::None);
    let mode = marker.system_mode.as_ref().unwrap();
    assert_eq!((mode.psr.unwrap().reduction(), mode.psr.unwrap().sensitivity_map()), (1, 0));
    assert_eq!(mode.ssr.unwrap().reduction(), 1);
    assert_eq!((mode.mode_s.unwrap().reduction(), mode.mode_s.unwrap().is_in_cluster()), (1, true));
    let counts = marker.message_counts.as_ref().unwrap();
    assert_eq!((counts.len(), counts[0].kind(), counts[0].count()), (1, CounterKind::Psr, 5));
    assert_eq!(crossing.message_type.unwrap().kind(), MessageKind::SectorCrossing);
    assert_eq!(crossing.sector_number.unwrap().azimuth_deg(), 90.0);
    // Truncated by an octet: the second record is a fault, the first is valid. An octet of zeros is an empty record.
    let (records, fault) = read::<cat034::Record>(&block(34, &contents[..contents.len() - 1]));
    let fault = fault.unwrap();
    assert_eq!((records.len(), fault.item, fault.kind), (1, Some("020"), FaultKind::ItemPastEnd));
    assert_eq!(fault.offset, octets.len() - 1);
    let (records, fault) = read::<cat034::Record>(&block(34, &[contents.as_slice(), &[0]].concat()));
    assert_eq!((records.len(), fault), (3, None));
    assert_eq!(records[2], cat034::Record::default());
}
