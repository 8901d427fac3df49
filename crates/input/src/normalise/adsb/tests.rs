//! Fields of an ADS-B record, item by item.

use asterix::cat021::{
    AddressType, AircraftAddress, AircraftIdentification, BarometricLevel, CoarsePosition, GroundVector,
    Position,
};
use asterix::{DataSource, TimeOfDay};
use fusion::frames::Geodetic;
use fusion::time::SECOND;

use super::*;
use site::areas::Masks;
use site::config::Config;

/// An aerodrome with one receiver and no radar: its frame is at the origin.
const SITE: &str = r#"[site]
name = "test"
sac = 25
sic = 1
latitude_deg = 52.0
longitude_deg = 4.0
height_amsl_m = 10
geoid_undulation_m = 40

[[sensors]]
id = "air"
kind = "adsb"
sac = 25
sic = 21

[http]
listen = "127.0.0.1:8080"
"#;
const SOURCE: DataSource = DataSource { sac: 25, sic: 21 };
const ADDRESS: u32 = 0x48_4A_F0;
/// Received at noon.
const NOON_S: i64 = 1_699_920_000 + 12 * 3600;
/// Tolerance of heights in metres: half a least significant bit, with a margin.
const HEIGHT_LSB_M: f64 = 1.0;

fn site() -> Normaliser {
    Normaliser::new(&Config::parse(SITE, "site.toml", std::iter::empty()).unwrap(), Masks::default())
}

fn received() -> Time {
    Time::from_nanos(NOON_S * SECOND)
}

/// Time of day, this number of seconds after noon.
fn after(seconds: f64) -> TimeOfDay {
    TimeOfDay::from_count(((12.0 * 3600.0 + seconds) * 128.0) as u32).unwrap()
}

/// A position, one second before its reception.
fn record() -> Record {
    Record {
        position_time: Some(after(-1.0)),
        ..bare(TargetReport::default(), Position::new(52.0, 4.0).unwrap())
    }
}

fn bare(report: TargetReport, place: Position) -> Record {
    let builder = Record::builder(SOURCE, report, AircraftAddress::new(ADDRESS));
    builder.fine_position(Some(place)).build().unwrap()
}

fn fix_of(record: &Record) -> Result<Fix, Refusal> {
    site().adsb(record, received(), &mut Barometer::default()).map_err(|(sensor, refusal)| {
        assert_eq!(sensor, Some(SensorIndex(0)));
        refusal
    })
}

fn fixed(record: &Record) -> Fix {
    fix_of(record).unwrap()
}

/// Position on Earth.
fn place(fix: &Fix) -> Geodetic {
    site().frame().to_geodetic(fix.position)
}

#[test]
fn fix_has_identity_sensor_and_time() {
    let fix = fixed(&record());
    assert_eq!((fix.identity, fix.sensor), (Identity::of_address(ADDRESS), SensorIndex(0)));
    assert_eq!(fix.items, UasItems::default(), "it has no serial number");
    assert_eq!(fix.time, Time::from_nanos((NOON_S - 1) * SECOND));

    // Time of applicability of the position, otherwise its reception, otherwise the transmission of the record.
    let times = |applicable, receiver, sent| {
        fix_of(&Record {
            position_time: applicable,
            position_reception: receiver,
            transmission_time: sent,
            velocity_time: Some(after(-9.0)),
            ..record()
        })
    };
    let [applicable, receiver, sent] = [-3.0, -2.0, -1.0].map(|seconds| Some(after(seconds)));
    let before_noon = |fix: Result<Fix, Refusal>| NOON_S - fix.unwrap().time.nanos() / SECOND;
    assert_eq!(before_noon(times(applicable, receiver, sent)), 3);
    assert_eq!(before_noon(times(None, receiver, sent)), 2);
    assert_eq!(before_noon(times(None, None, sent)), 1);
    assert_eq!(times(None, None, None), Err(Refusal::NoTime), "that of the velocity is another one");
    assert_eq!(times(Some(after(60.0)), None, None), Err(Refusal::Future));
    let no_time_of_day = TimeOfDay::from_count(86_401 * 128);
    assert_eq!(times(no_time_of_day, None, None), Err(Refusal::TimeOutOfRange));
}

#[test]
fn incomplete_report_is_refused_with_the_reason() {
    let nowhere = Record { fine_position: None, ..record() };
    assert_eq!(fix_of(&nowhere), Err(Refusal::NoPosition));
    assert_eq!(fix_of(&Record { target_address: None, ..record() }), Err(Refusal::NoIdentity));
    let beyond = Position::default().with_latitude_deg(91.0);
    assert_eq!(fix_of(&Record { fine_position: beyond, ..record() }), Err(Refusal::PositionOutOfRange));
    let other = Record { data_source: Some(DataSource { sac: 25, sic: 22 }), ..record() };
    let refused = site().adsb(&other, received(), &mut Barometer::default()).unwrap_err();
    assert!(matches!(refused, (None, Refusal::UnknownSource { category: 21, .. })), "{refused:?}");
}

#[test]
fn finer_of_two_positions_is_used() {
    let coarse = CoarsePosition::new(52.2, 4.2);
    let both = place(&fixed(&Record { position: coarse, ..record() }));
    assert!((both.latitude_deg() - 52.0).abs() < 1e-6, "{}", both.latitude_deg());
    let alone = place(&fixed(&Record { position: coarse, fine_position: None, ..record() }));
    let (latitude_off, longitude_off) = (alone.latitude_deg() - 52.2, alone.longitude_deg() - 4.2);
    assert!(latitude_off.abs() < 1.1e-5 && longitude_off.abs() < 1.1e-5, "{latitude_off} {longitude_off}");
}

/// Each flag alone.
#[test]
fn report_doubted_by_the_ground_station_is_refused() {
    let with = |flag: fn(TargetReport) -> TargetReport| {
        let target_report = Some(flag(TargetReport::default()));
        fix_of(&Record { target_report, ..record() }).map(|_| ())
    };
    for (flag, refusal) in [
        ((|report| report.with_nogo(true)) as fn(TargetReport) -> TargetReport, Refusal::NotBelieved),
        (|report| report.with_compact_position_invalid(true), Refusal::NotBelieved),
        (|report| report.with_position_jump(true), Refusal::NotBelieved),
        (|report| report.with_out_of_range(true), Refusal::NotBelieved),
        (|report| report.with_position_check_failed(true), Refusal::NotBelieved),
        (|report| report.with_simulated(true), Refusal::Simulated),
        (|report| report.with_test(true), Refusal::TestTarget),
        (|report| report.with_field_monitor(true), Refusal::TestTarget),
        (|report| report.with_simulated(true).with_nogo(true).with_test(true), Refusal::Simulated),
        (|report| report.with_test(true).with_nogo(true), Refusal::TestTarget),
    ] {
        assert_eq!(with(flag), Err(refusal), "{:?}", flag(TargetReport::default()));
    }
    // Flags that do not affect the position.
    for flag in [
        (|report| report.with_on_ground(true)) as fn(TargetReport) -> TargetReport,
        |report| report.with_range_checked(true),
        |report| report.with_corrected(true),
        |report| report.with_lookup_failed(true),
        |report| report.with_selected_altitude_lacking(true),
    ] {
        assert_eq!(with(flag), Ok(()), "{:?}", flag(TargetReport::default()));
    }
    assert_eq!(fix_of(&Record { target_report: None, ..record() }).map(|_| ()), Ok(()));
}

/// NACp: the 95 % radii of DO-260B, in nautical miles and metres, and those of half of normal errors: 1.1774 sigma instead
/// of 2.4477 sigma.
#[test]
fn horizontal_accuracy_follows_nacp() {
    let stated = |category: u8| {
        let quality = QualityIndicators::default().with_accuracy_category(category);
        fixed(&Record { quality, ..record() }).accuracy_m
    };
    let miles = [10.0, 4.0, 2.0, 1.0, 0.5, 0.3, 0.1, 0.05].map(|miles| miles * 1852.0);
    for (category, radius_m) in (1..).zip(miles.into_iter().chain([30.0, 10.0, 3.0])) {
        let half_m = radius_m * 1.177_41 / 2.447_75;
        let accuracy_m = stated(category).unwrap();
        assert!((accuracy_m / half_m - 1.0).abs() < 1e-4, "{category}: {accuracy_m}, not {half_m}");
    }
    // An unknown accuracy counts as poor.
    let unknown_m = stated(0).unwrap();
    assert!(stated(5).unwrap() <= unknown_m && unknown_m <= stated(4).unwrap(), "{unknown_m}");
    assert_eq!([12, 15].map(stated), [None, None], "nobody has defined these");
    // The first octet has only velocity and integrity.
    assert_eq!(fixed(&record()).accuracy_m, None);
    let first = QualityIndicators::default().with_position_category(8);
    assert_eq!(fixed(&Record { quality: first, ..record() }).accuracy_m, None);
}

/// GVA: 1.96 sigma of a normal error contain 95 %.
#[test]
fn vertical_accuracy_follows_gva() {
    let stated = |category: u8| {
        let quality = QualityIndicators::default().with_geometric_category(category);
        let geometric_height = GeometricHeight::default().with_height_m(500.0);
        fixed(&Record { quality, geometric_height, ..record() }).height_sigma_m
    };
    let sigma_m = |category| stated(category).unwrap();
    assert!((sigma_m(1) - 76.531).abs() < 1e-3 && (sigma_m(2) - 22.959).abs() < 1e-3);
    assert_eq!([0, 3].map(stated), [None, None], "unknown, and not defined");
}

#[test]
fn geometric_height_is_above_the_ellipsoid() {
    let geometric_height = GeometricHeight::default().with_height_m(500.0);
    let fix = fixed(&Record { geometric_height, ..record() });
    assert!(fix.height_measured);
    assert!((place(&fix).height_m - 500.0).abs() < HEIGHT_LSB_M, "{}", place(&fix).height_m);
    assert!((fix.position.up() - 450.0).abs() < HEIGHT_LSB_M, "the origin is 50 m above it");
    // The highest count means "greater".
    let most = GeometricHeight::default().with_height_m(62_421.0);
    assert!(most.is_some());
    let fix = fixed(&Record { geometric_height: most, ..record() });
    assert!(!fix.height_measured && fix.height_sigma_m.is_none());
    // Without a height, that of the site is used.
    let fix = fixed(&record());
    assert!(!fix.height_measured && fix.position.up().abs() < 1e-3, "{}", fix.position.up());
}

#[test]
fn pressure_altitude_is_coarse_until_offset_is_known() {
    let (site, mut barometer) = (site(), Barometer::default());
    let mut hear = |record: &Record| site.adsb(record, received(), &mut barometer).unwrap();
    // Flight level 30, 914.4 m.
    let low = Record { flight_level: BarometricLevel::default().with_flight_level(30.0), ..record() };
    let coarse = hear(&low);
    let height_m = site.frame().to_geodetic(coarse.position).height_m;
    assert!(coarse.height_measured && (height_m - 914.4 - 40.0).abs() < HEIGHT_LSB_M, "{height_m}");
    assert!((coarse.height_sigma_m.unwrap() * 1.96 - 300.0).abs() < 5.0);
    let both = Record { geometric_height: GeometricHeight::default().with_height_m(1014.4), ..low.clone() };
    for _ in 0..20 {
        assert!((site.frame().to_geodetic(hear(&both).position).height_m - 1014.4).abs() < HEIGHT_LSB_M);
    }
    let fix = hear(&low);
    let height_m = site.frame().to_geodetic(fix.position).height_m;
    assert!(fix.height_measured && (height_m - 1014.4).abs() < HEIGHT_LSB_M, "{height_m}");
    let near_m = fix.height_sigma_m.unwrap();
    // 1.5 km above them the height is less certain.
    let high = Record { flight_level: BarometricLevel::default().with_flight_level(80.0), ..record() };
    let fix = hear(&high);
    let height_m = site.frame().to_geodetic(fix.position).height_m;
    assert!((height_m - 2538.4).abs() < HEIGHT_LSB_M, "{height_m}");
    assert!(fix.height_sigma_m.unwrap() > near_m + 50.0);
}

/// North at the aircraft's position differs from north at the site, because meridians converge.
#[test]
fn velocity_is_rotated_into_the_site_frame() {
    let flying = |longitude_deg: f64, track_deg: f64| {
        let place = Position::new(52.0, longitude_deg).unwrap();
        let ground_vector = GroundVector::new(200.0, track_deg);
        let geometric_height = GeometricHeight::default().with_height_m(50.0);
        let record = bare(TargetReport::default(), place);
        let geometric_rate = VerticalRate::default().with_up_m_s(0.0);
        fixed(&Record {
            position_time: Some(after(-1.0)),
            ground_vector,
            geometric_height,
            geometric_rate,
            ..record
        })
    };
    // Speed in steps of 0.113 m/s, tracks of 0.0055 degrees.
    let at_site = flying(4.0, 30.0).velocity.unwrap();
    assert!((at_site - Vector2::new(100.0, 173.205)).norm() < 0.1, "{at_site}");

    // 1.5 degrees east, 103 km away, north is turned by 1.5° sin 52° to the west.
    let far = flying(5.5, 0.0);
    let velocity = far.velocity.unwrap();
    let turned_deg = velocity.x.atan2(velocity.y).to_degrees();
    assert!((turned_deg + 1.5 * 52_f64.to_radians().sin()).abs() < 0.01, "{turned_deg}");
    // An aircraft in level flight to the east there descends relative to the site's plane: 1.5° cos 52°.
    let east = flying(5.5, 90.0);
    let sinks_m_s = east.climb_m_s.unwrap();
    let expected_m_s = -200.0 * (1.5_f64.to_radians()).sin() * 52_f64.to_radians().cos();
    assert!((sinks_m_s - expected_m_s).abs() < 0.02, "{sinks_m_s}, not {expected_m_s}");
    // The velocity equals the motion of the position in the site's axes, over a minute by geodesy.
    let [here, there] = [5.5, 5.5 + 12_000.0 / (6_390_749.0 * 52_f64.to_radians().cos()).to_radians()]
        .map(|longitude_deg| flying(longitude_deg, 90.0).position);
    let moved = (there.0 - here.0).xy() / 60.0;
    assert!((moved - east.velocity.unwrap()).norm() < 0.4, "{moved}");
}

#[test]
fn geometric_climb_is_preferred_to_barometric() {
    let rate = |up_m_s: f64| VerticalRate::default().with_up_m_s(up_m_s);
    let climb = |geometric_rate, barometric_rate| {
        fixed(&Record { geometric_rate, barometric_rate, ..record() }).climb_m_s
    };
    let near = |climb: Option<f64>, m_s: f64| climb.is_some_and(|climb| (climb - m_s).abs() < 0.02);
    assert!(near(climb(rate(5.0), rate(-4.0)), 5.0));
    assert!(near(climb(None, rate(-4.0)), -4.0));
    assert_eq!(climb(None, None), None);
    // A value above the range of the item is not used.
    assert_eq!(climb(rate(5.0).map(|rate| rate.with_exceeded(true)), None), None);
    let ground_vector = GroundVector::new(100.0, 0.0).map(|vector| vector.with_exceeded(true));
    assert_eq!(fixed(&Record { ground_vector, ..record() }).velocity, None);
}

#[test]
fn unmanned_emitter_category_is_unmanned() {
    use EmitterCategory as Is;
    let kind = |category: Option<EmitterCategory>, address_type: AddressType| {
        let target_report = Some(TargetReport::default().with_address_type(address_type));
        let emitter = category.map(|category| Emitter::default().with_category(category));
        fixed(&Record { target_report, emitter, ..record() }).aircraft
    };
    let of = |category| kind(Some(category), AddressType::Icao).kind;
    assert_eq!(of(Is::Unmanned), AircraftKind::Unmanned);
    for category in
        [Is::EmergencyVehicle, Is::ServiceVehicle, Is::Obstruction, Is::ObstacleCluster, Is::ObstacleLine]
    {
        assert_eq!(of(category), AircraftKind::Vehicle, "{category:?}");
    }
    for category in [Is::Unknown, Is::Light, Is::Heavy, Is::Rotorcraft, Is::Glider, Is::Parachutist] {
        assert_eq!(of(category), AircraftKind::Crewed, "{category:?}");
    }
    // The address type may state a vehicle, unless the category states a drone.
    assert_eq!(kind(None, AddressType::SurfaceVehicle).kind, AircraftKind::Vehicle);
    assert_eq!(kind(Some(Is::Unknown), AddressType::SurfaceVehicle).kind, AircraftKind::Vehicle);
    assert_eq!(kind(Some(Is::Unmanned), AddressType::SurfaceVehicle).kind, AircraftKind::Unmanned);
    let silent = kind(None, AddressType::Anonymous);
    assert_eq!((silent.kind, silent.emitter_category), (AircraftKind::Crewed, None));
    assert_eq!(kind(Some(Is::Rotorcraft), AddressType::Icao).emitter_category, Some(10));
    assert_eq!(kind(Some(Is::Unknown), AddressType::Icao).emitter_category, None, "no information");
}

#[test]
fn callsign_is_the_valid_part_of_the_field() {
    let callsign = |text: &str| {
        let target_identification = AircraftIdentification::new(text);
        assert!(target_identification.is_some());
        fixed(&Record { target_identification, ..record() }).aircraft.callsign
    };
    assert_eq!(callsign("KLM1023"), *b"KLM1023\0");
    assert_eq!(callsign("PH 1"), *b"PH 1\0\0\0\0");
    assert_eq!(callsign(""), [0; 8]);
    assert_eq!(fixed(&record()).aircraft.callsign, [0; 8]);
    // Six zeros, sent by an aircraft without a configured callsign, are no characters.
    let target_identification = Some(AircraftIdentification::default());
    assert_eq!(fixed(&Record { target_identification, ..record() }).aircraft.callsign, [0; 8]);
}

/// The rules of the `reference` profile compare heights.
#[test]
fn reference_profile_refuses_report_without_height() {
    let text = format!("{SITE}\n[fusion]\nprofile = \"reference\"\n");
    let config = Config::parse(&text, "site.toml", std::iter::empty()).unwrap();
    let site = Normaliser::new(&config, Masks::default());
    let refused = site.adsb(&record(), received(), &mut Barometer::default());
    assert_eq!(refused, Err((Some(SensorIndex(0)), Refusal::NoHeight)));
    let geometric_height = GeometricHeight::default().with_height_m(500.0);
    let said = Record { geometric_height, ..record() };
    assert!(site.adsb(&said, received(), &mut Barometer::default()).is_ok());
}
