//! Hand-made CAT015, CAT021, CAT062 and CAT063: octets, builders and accessors.

#![allow(clippy::unwrap_used, reason = "a test that meets the unexpected fails")]

mod common;

use common::{BEARING, LIGHT_AIRCRAFT, SENSOR, SYSTEM_TRACK, hex, read, read_in};
use utm_asterix::cat015::{
    self, Angle, AngleDeviation, AzimuthInformation, ElevationInformation, MessageKind, MessageType,
    ReportNumber, ReportStatus, ScanDirection, SignedAngle, TargetReport, TargetTaxonomy, Warnings,
};
use utm_asterix::cat021::{
    self, AddressType, AircraftAddress, AircraftIdentification, BarometricLevel, CoarsePosition, Edition,
    Emitter, EmitterCategory, GeometricHeight, GroundVector, MopsVersion, QualityIndicators, Standard,
    Surface, SurfaceCharacteristics, SurfaceCharacteristics21, VerticalRate,
};
use utm_asterix::cat062::{
    self, Age, CartesianPosition, ComposedTrackNumber, Covariance, EstimatedAccuracies, HeightSource,
    PositionAccuracy, TrackNumber, TrackStatus, UnitTrack, UpdateAges, Velocity,
};
use utm_asterix::cat063::{self, Connection, SensorStatus};
use utm_asterix::{BuildError, DataSource, FaultKind, Record, TimeOfDay, encode_block};

const STATION: DataSource = DataSource { sac: 25, sic: 7 };

fn light_aircraft() -> Result<cat021::Record, BuildError> {
    let report = cat021::TargetReport::default().with_on_ground(false);
    let quality = QualityIndicators::default()
        .with_velocity_category(1)
        .and_then(|quality| quality.with_accuracy_category(10));
    cat021::Record::builder(STATION, report, AircraftAddress::new(0x4a_08eb))
        .position_time(TimeOfDay::from_seconds(43_200.0))
        .position(CoarsePosition::new(60.0, 29.999_99))
        .geometric_height(GeometricHeight::default().with_height_m(1024.0 * 1.905))
        .quality(quality)
        .mops_version(MopsVersion::default().with_standard(Standard::Do260B))
        .flight_level(BarometricLevel::default().with_flight_level(100.0))
        .geometric_rate(VerticalRate::default().with_up_m_s(0.254))
        .ground_vector(GroundVector::new(463.0, 0.0))
        .target_identification(AircraftIdentification::new("ROT415"))
        .emitter(Emitter::default().with_category(EmitterCategory::Light))
        .build()
}

#[test]
fn an_aircraft_in_adsb() {
    let record = light_aircraft().unwrap();
    assert_eq!(record.target_report.unwrap().address_type(), AddressType::Icao);
    assert_eq!(record.time_of_day().map(TimeOfDay::seconds), Some(43_200.0));
    assert_eq!(record.target_address.unwrap().to_string(), "4A08EB");
    let position = record.position.unwrap();
    assert!((position.latitude_deg() - 60.0).abs() < 2e-5 && (position.longitude_deg() - 30.0).abs() < 4e-5);
    assert_eq!(record.geometric_height.unwrap().height_m(), 1024.0 * 1.905);
    assert_eq!(record.quality.unwrap().horizontal_accuracy_m(), Some(10.0));
    assert_eq!(record.geometric_rate.unwrap().octets(), [0, 8]);
    assert_eq!(record.ground_vector.unwrap().octets(), [0x10, 0, 0, 0]);
    let mut octets = Vec::new();
    encode_block(std::slice::from_ref(&record), &mut octets).unwrap();
    assert_eq!(read::<cat021::Record>(&octets), (vec![record], None));
    assert_eq!(octets, hex(LIGHT_AIRCRAFT));
}

#[test]
fn edition_determines_the_second_octet_of_271() {
    // 040 and 271, FRN 2 and 37; 0x05 is length and width 5 up to edition 2.1, and in 2.2 spare bits and FX.
    let octets = hex("15 000c 41 01 01 01 01 40 00 03 05");
    let old = SurfaceCharacteristics21::default().with_ident(true).with_length_and_width(5).unwrap();
    let (records, fault) = read_in::<cat021::Record>(Edition::V2_1, &octets);
    assert_eq!((records.len(), fault), (1, None));
    assert_eq!(records[0].surface, Some(Surface::Edition21(old)));
    let (records, fault) = read_in::<cat021::Record>(Edition::V2_2, &octets);
    assert!(records.is_empty());
    let fault = fault.unwrap();
    assert_eq!((fault.item, fault.kind), (Some("271"), FaultKind::ItemPastEnd));

    let octets = hex("15 000c 41 01 01 01 01 40 00 03 50");
    let new = SurfaceCharacteristics::default().with_ident(true).with_length_and_width(5).unwrap();
    let (records, fault) = read_in::<cat021::Record>(Edition::V2_2, &octets);
    assert_eq!((records[0].surface, fault), (Some(Surface::Edition22(new)), None));
}

#[test]
fn editions_have_names() {
    for edition in Edition::ALL {
        assert_eq!(edition.to_string().parse(), Ok(edition));
    }
    assert!("2.8".parse::<Edition>().unwrap_err().to_string().contains("known are 2.1"));
    let mut record = light_aircraft().unwrap();
    assert_eq!(Edition::least(&record), None);
    record.mops_version = record.mops_version.map(|mops| mops.with_standard(Standard::Do260C));
    assert_eq!(Edition::least(&record), Some(Edition::V2_5));
    record.quality = record.quality.map(|quality| quality.with_integrity_received(true));
    assert_eq!(Edition::least(&record), Some(Edition::V2_7));
}

#[test]
fn a_system_track() {
    let accuracies = EstimatedAccuracies {
        position: PositionAccuracy::default().with_east_m(10.0).and_then(|at| at.with_north_m(20.0)),
        covariance: Covariance::from_square_metres(-25.0),
        ..EstimatedAccuracies::default()
    };
    let ages =
        UpdateAges { track: Age::from_seconds(0.5), psr: Age::from_seconds(0.0), ..UpdateAges::default() };
    let status = TrackStatus::default().with_height_source(HeightSource::Multilateration).with_coasted(true);
    let unit = |unit, number| {
        UnitTrack::default().with_unit(unit).and_then(|track| track.with_track_number(number)).unwrap()
    };
    let noon = TimeOfDay::from_seconds(43_200.0);
    let record = cat062::Record::builder(STATION, noon, TrackNumber::new(42), status)
        .position(cat062::Position::new(60.0, 30.0))
        .cartesian_position(
            CartesianPosition::default().with_x_m(100.0).and_then(|position| position.with_y_m(-100.0)),
        )
        .velocity(Velocity::new(50.0, -50.0))
        .update_ages(ages)
        .geometric_altitude(GeometricHeight::default().with_height_m(1024.0 * 1.905))
        .composed_track(ComposedTrackNumber::new(&[unit(1, 3), unit(2, 4)]))
        .accuracies(accuracies)
        .build()
        .unwrap();
    assert!((record.accuracies.as_ref().unwrap().covariance.unwrap().square_metres() + 25.0).abs() < 1e-9);
    let status = record.track_status.unwrap();
    assert!(status.is_coasted() && !status.is_tentative());
    assert_eq!(status.height_source(), HeightSource::Multilateration);
    assert_eq!(ComposedTrackNumber::new(&[]), None);
    let mut octets = Vec::new();
    encode_block(std::slice::from_ref(&record), &mut octets).unwrap();
    let (records, fault) = read::<cat062::Record>(&octets);
    assert_eq!((records.as_slice(), fault), (&[record][..], None));
    let tracks = records[0].composed_track.as_ref().unwrap().tracks();
    assert_eq!(tracks.iter().map(|track| track.track_number()).collect::<Vec<_>>(), [3, 4]);
    assert_eq!(octets, hex(SYSTEM_TRACK));
}

#[test]
fn a_sensor() {
    let status = SensorStatus::default().with_connection(Connection::Degraded).with_time_invalid(true);
    let record =
        cat063::Record::builder(STATION, TimeOfDay::from_seconds(43_200.0), DataSource { sac: 1, sic: 2 })
            .status(status)
            .build()
            .unwrap();
    let mut octets = Vec::new();
    encode_block(std::slice::from_ref(&record), &mut octets).unwrap();
    assert_eq!(octets, hex(SENSOR));
    assert_eq!(read::<cat063::Record>(&octets), (vec![record], None));
}

#[test]
fn a_bearing() {
    let deviation = AngleDeviation::default().with_degrees(0.2);
    let azimuth = AzimuthInformation {
        azimuth: Angle::default().with_degrees(90.0),
        deviation,
        ..AzimuthInformation::default()
    };
    let elevation = ElevationInformation {
        elevation: SignedAngle::default().with_degrees(15.0),
        deviation,
        ..ElevationInformation::default()
    };
    let kind = MessageType::default().with_kind(MessageKind::SensorCentricTrack);
    assert_eq!((kind.octets(), kind.is_event_driven()), ([8], false));
    let record = cat015::Record::builder(STATION, kind, TimeOfDay::from_seconds(43_200.0))
        .target_report(TargetReport::default().with_scan_direction(ScanDirection::Static))
        .number(ReportNumber::default().with_number(42))
        .status(ReportStatus::default().with_tentative(true))
        .azimuth(azimuth)
        .elevation(elevation)
        .build()
        .unwrap();
    let mut octets = Vec::new();
    encode_block(std::slice::from_ref(&record), &mut octets).unwrap();
    assert_eq!(octets, hex(BEARING));
    let (records, fault) = read::<cat015::Record>(&octets);
    assert_eq!((records.as_slice(), fault), (&[record][..], None));
    assert_eq!(records[0].target_report.unwrap().taxonomy(), TargetTaxonomy::Actual);
    let elevation = records[0].elevation.as_ref().unwrap();
    assert!((elevation.elevation.unwrap().degrees() - 15.0).abs() <= 90.0 / 65536.0);
    assert!((elevation.deviation.unwrap().degrees() - 0.2).abs() <= 22.5 / 65536.0);
    assert_eq!(Warnings::new(&[32]).unwrap().codes().collect::<Vec<_>>(), [32]);
    // An azimuth is reduced to one turn; an elevation is limited.
    assert_eq!(Angle::default().with_degrees(-90.0).unwrap().degrees(), 270.0);
    assert_eq!(SignedAngle::default().with_degrees(90.0), None);
}
