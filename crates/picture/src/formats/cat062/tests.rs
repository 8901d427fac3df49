//! Tests of encoded records octet by octet, of random tracks, and of the numbers of tracks that come and go.

use std::collections::{BTreeMap, BTreeSet};

use asterix::blocks;
use jiff::SignedDuration;
use nalgebra::{Matrix2, Vector3};
use proptest::prelude::*;

use super::*;
use crate::PublishedMotion;
use crate::formats::DATAGRAM_MAX;
use fusion::frames::Geodetic;
use fusion::integrity::{PointIntegrity, Reasons, State};
use fusion::point::{Association, AssociationEvidence, Basis, RadarPart};
use fusion::report::{Aircraft, UasItems};
use fusion::time::SECOND;
use fusion::{Enu, Identity, Point, RadarTrackKey, SensorIndex};

fn config() -> Config {
    let site = include_str!("../../../../../testdata/demo/site.toml");
    Config::parse(site, "site.toml", std::iter::empty()).unwrap()
}

fn encoder() -> Cat062Encoder {
    Cat062Encoder::new(&config(), PictureKind::Lagged)
}

fn noon_and(seconds: f64) -> Time {
    Time::from_nanos(1_782_043_200 * SECOND + (seconds * SECOND as f64) as i64)
}

fn radar(number: u16, time: Time) -> RadarPart {
    let track = RadarTrackKey { sensor: SensorIndex(0), number };
    RadarPart { track, time, height_measured: true, uav_probability: Some(0.5) }
}

fn transponder(serial: &[u8; 12], number: u32, time: Option<Time>) -> TransponderPart {
    let identity = Identity::new(serial, Some(b"NO")).unwrap();
    let items = UasItems { serial_number: *serial, ..UasItems::default() };
    TransponderPart {
        number,
        identity,
        sensor: SensorIndex(1),
        time,
        items,
        aircraft: Aircraft::default(),
        height_measured: true,
    }
}

fn fused(radar: RadarPart, transponder: TransponderPart) -> Source {
    Source::Fused(
        radar,
        transponder,
        Association { distance_m: 3.0, because: AssociationEvidence::Likelihood { score: 9.0 } },
    )
}

/// A track at 60° north, 30° east, 190.5 m above the ellipsoid, at noon.
fn track(number: u32, source: Source, estimate: Option<Estimate>) -> PictureTrack {
    let time = noon_and(0.0);
    let motion = estimate.as_ref().map(|known| PublishedMotion {
        velocity: known.velocity,
        track_deg: None,
        half_h_m: 2.0,
        accuracy_h_m: 5.0,
        accuracy_v_m: 4.0,
        speed_accuracy: 1.0,
        deviation_h_m: known.sigma_m(),
        deviation_v_m: known.vertical_m2.sqrt(),
        basis: known.basis,
        last_measurement: known.last_measurement,
        ellipse: None,
    });
    PictureTrack {
        point: Point { estimate, ..Point::new(number, Enu::new(0.0, 0.0, 0.0), time, source) },
        time,
        position: Geodetic::from_degrees(60.0, 30.0, 190.5),
        altitude_amsl_m: Some(150.0),
        motion,
        disputed: Vec::new(),
        id: None,
        name: String::new(),
        is_uncooperative: false,
    }
}

fn estimate() -> Estimate {
    Estimate {
        velocity: Vector3::new(10.0, -2.5, 0.5),
        horizontal: Matrix2::new(4.0, -1.1, -1.1, 9.1),
        vertical_m2: 4.0,
        velocity_covariance: Matrix2::new(0.25, 0.0, 0.0, 0.26),
        position_velocity: Matrix2::zeros(),
        height_climb: 0.0,
        climb_m2s2: 0.01,
        lie_m2: 0.0,
        basis: Basis::Measured,
        last_measurement: Some(noon_and(-0.1)),
    }
}

/// Records of datagrams with one block each.
fn read(datagrams: &[Vec<u8>]) -> Vec<Record> {
    let blocks = datagrams.iter().flat_map(|datagram| {
        assert!(datagram.len() <= DATAGRAM_MAX);
        blocks(datagram).map(Result::unwrap)
    });
    blocks.flat_map(|block| block.records::<Record>().map(|located| located.unwrap().record)).collect()
}

#[test]
fn fused_track_is_encoded_octet_by_octet() {
    let source = fused(radar(11, noon_and(0.1)), transponder(b"1596F3A2B4C6", 7, Some(noon_and(-6.0))));
    let mut track = track(70_011, source, Some(estimate()));
    track.point.integrity = Some(PointIntegrity {
        state: State::Suspect,
        index: 9.0,
        protection_level_m: None,
        offset_m: None,
        reasons: Reasons::default(),
    });
    let expected: [&[u8]; 14] = [
        &[62, 0, 92],
        // FRN 1, 3, 4, 5, 7; 10, 11, 12, 13, 14; 18, 20; 27; 35.
        &[0xbb, 0x3f, 0x15, 0x05, 0x02],
        // 010, 015, 070: 43,200 s of 1/128 s; 105: 60 and 30 degrees of 180 / 2^25.
        &[70, 1, 1, 0x54, 0x60, 0x00],
        &[0x00, 0xaa, 0xaa, 0xab, 0x00, 0x55, 0x55, 0x55],
        // 185: 40 and -10 quarters of a metre a second.
        &[0x00, 0x28, 0xff, 0xf6],
        // 245: F3A2B4C6, downlinked.
        &[0x00, 0x1b, 0x30, 0x72, 0x0b, 0x40, 0xf6],
        // 380: ID and EMC, an unmanned aircraft.
        &[0x41, 0x01, 0x02, 0x1b, 0x30, 0x72, 0x0b, 0x40, 0xf6, 13],
        // 040: 70,011 - 65,536.
        &[0x11, 0x7b],
        // 080: MRH, SRC GNSS; TSB, AFF; no bits; SSR, MDS, and ADS after 6 s without a report; combined.
        &[0x25, 0x29, 0x01, 0x39, 0x00],
        // 290: TRK, PSR and ES: 0, 0 and 24 quarters of a second.
        &[0xc4, 0, 0, 24],
        // 130: 100 times 6.25 ft; 220: 16 times 6.25 ft a minute.
        &[0x00, 0x64, 0x00, 0x10],
        // 500: APC 2 and 3.5 m, COV -1 m, AGA 2 of 6.25 ft, ATV 0.5 and 0.75 m/s, ARC 4 of 6.25 ft a minute.
        &[0xd5, 0x80, 0, 4, 0, 7, 0xff, 0xfe, 2, 2, 3, 4],
        // SP, as in CAT129: fused, number, radar track, transponder,
        &[22, b'U', b'F', 1, 1, 0, 1, 0x11, 0x7b, 0, 11, 0, 0, 0, 7],
        // deviations of 2.6 and 2.0 m, suspect, probability.
        &[0, 26, 0, 20, 4, 127, 0],
    ];
    let mut encoder = encoder();
    assert_eq!(encoder.encode(track.time, [&track]), [expected.concat()]);
    // The second message of a track is not its first.
    let again = read(&encoder.encode(track.time, [&track]));
    assert!(!again[0].track_status.unwrap().is_first());
}

#[test]
fn unmeasured_items_are_omitted() {
    let serial = transponder(b"Drone-1     ", 9, None);
    let mut heard = track(90_000, Source::Transponder(serial), None);
    heard.altitude_amsl_m = None;
    let [record] = &read(&encoder().encode(heard.time, [&heard]))[..] else { panic!() };
    assert_eq!((record.velocity, record.climb_rate, record.geometric_altitude), (None, None, None));
    assert!(record.accuracies.is_none() && record.update_ages.is_none());
    assert_eq!(record.target_identification, None, "no character of I062/245 stands for a hyphen");
    let derived = record.aircraft_derived.as_ref().unwrap();
    assert_eq!((derived.identification, derived.emitter.map(EmitterCategory::code)), (None, Some(UNMANNED)));
    let status = record.track_status.unwrap();
    assert_eq!(status.height_source(), HeightSource::None);
    assert!(status.is_monosensor() && !status.is_geometric_reliable() && !status.lacks_adsb());
    assert!(status.lacks_primary() && status.surveillance() == 1);

    // A transponder configured as crewed has no category.
    let mut crewed = encoder();
    crewed.crewed.insert("Drone-1".to_owned());
    let record = read(&crewed.encode(heard.time, [&heard])).remove(0);
    assert_eq!(record.aircraft_derived, None);
}

#[test]
fn coasting_track_names_the_missing_sensor() {
    let coasting =
        Estimate { basis: Basis::Extrapolated, last_measurement: Some(noon_and(-80.0)), ..estimate() };
    let track = track(12_345, Source::Radar(radar(5, noon_and(-80.0))), Some(coasting));
    let record = read(&encoder().encode(track.time, [&track])).remove(0);
    let status = record.track_status.unwrap();
    assert!(status.is_coasted() && status.lacks_primary() && status.lacks_adsb());
    assert_eq!((status.height_source(), status.surveillance()), (HeightSource::Radar3D, 2));
    let ages = record.update_ages.unwrap();
    // 63.75 s means this age or more.
    assert_eq!(ages.track.map(Age::seconds), Some(63.75));
    assert_eq!((ages.psr.map(Age::seconds), ages.squitter), (Some(63.75), None));
}

#[test]
fn track_end_releases_its_number() {
    let mut encoder = encoder();
    let at = |number: u32, seconds: f64| {
        let mut track = track(number, Source::Radar(radar(5, noon_and(0.0))), Some(estimate()));
        track.time = noon_and(seconds);
        track
    };
    let numbers = |records: &[Record]| -> Vec<(u16, bool, bool)> {
        let said = |record: &Record| {
            let status = record.track_status.unwrap();
            (record.track_number.unwrap().number(), status.is_first(), status.is_last())
        };
        records.iter().map(said).collect()
    };
    let mut encode = |seconds: f64, tracks: &[u32]| {
        let tracks: Vec<_> = tracks.iter().map(|&number| at(number, seconds)).collect();
        numbers(&read(&encoder.encode(noon_and(seconds), &tracks)))
    };
    // Three numbers with the same low bits: the first keeps them, the others get the next free numbers.
    assert_eq!(
        encode(0.0, &[65_536 + 40_000, 40_000, 131_072 + 40_000]),
        [(40_000, true, false), (40_001, true, false), (40_002, true, false)]
    );
    assert_eq!(encode(9.75, &[40_000]), [(40_001, false, false)]);
    assert_eq!(encode(10.0, &[40_000]), [(40_001, false, false)]);
    // A track that begins does not get a number that ends in the same picture.
    assert_eq!(
        encode(10.25, &[40_000, 196_608 + 40_000]),
        [(40_001, false, false), (40_003, true, false), (40_000, false, true), (40_002, false, true)]
    );
    assert_eq!(encode(10.5, &[65_536 + 40_000]), [(40_000, true, false)]);
    let last = read(&encoder.encode(noon_and(100.0), []));
    assert_eq!(last.len(), 3);
    assert!(last.iter().all(|record| record.position.is_none() && record.time_of_day.is_some()));
}

fn sources() -> impl Strategy<Value = Source> {
    let ages = (0.0..100.0_f64, 0.0..100.0_f64);
    (0..3, ages, any::<u16>(), "[0-9A-Z -]{12}").prop_filter_map(
        "a serial",
        |(kind, (plot_s, report_s), number, serial)| {
            let radar = radar(number & 0xfff, noon_and(-plot_s));
            let serial: [u8; 12] = serial.as_bytes().try_into().ok()?;
            Identity::new(&serial, None)?;
            let transponder = transponder(&serial, number.into(), Some(noon_and(-report_s)));
            Some(match kind {
                0 => fused(radar, transponder),
                1 => Source::Radar(radar),
                _ => Source::Transponder(transponder),
            })
        },
    )
}

proptest! {
    #[test]
    fn decoded_track_is_never_more_accurate_than_the_original(
        source in sources(), number in 10_000..u32::MAX,
        latitude in -90.0..90.0_f64, longitude in -180.0..180.0_f64, height in -500.0..20_000.0_f64,
        velocity in [-400.0..400.0_f64, -400.0..400.0, -100.0..100.0],
        deviations in [0.0..300.0_f64, 0.0..300.0, 0.0..29.0, 0.0..60.0, 0.0..60.0, 0.0..8.0], correlation in -1.0..1.0_f64,
    ) {
        let [east, north, up, speed_east, speed_north, climb] = deviations;
        let both = east * north * correlation;
        let known = Estimate {
            velocity: velocity.into(),
            horizontal: Matrix2::new(east * east, both, both, north * north),
            vertical_m2: up * up,
            velocity_covariance: Matrix2::new(speed_east * speed_east, 0.0, 0.0, speed_north * speed_north),
            climb_m2s2: climb * climb,
            ..estimate()
        };
        let mut track = track(number, source.clone(), Some(known));
        track.position = Geodetic::from_degrees(latitude, longitude, height);
        let record = read(&encoder().encode(track.time, [&track])).remove(0);

        prop_assert_eq!(record.track_number.unwrap().number(), number as u16);
        let position = record.position.unwrap();
        prop_assert!((position.latitude_deg() - latitude).abs() < 2.7e-6);
        prop_assert!((position.longitude_deg() - longitude).abs() < 2.7e-6);
        prop_assert!((record.geometric_altitude.unwrap().height_m() - height).abs() < 0.953);
        let moves = record.velocity.unwrap();
        prop_assert!((moves.east_m_s() - velocity[0]).abs() <= 0.125 && (moves.north_m_s() - velocity[1]).abs() <= 0.125);
        prop_assert!((record.climb_rate.unwrap().up_m_s() - velocity[2]).abs() < 0.016);

        let said = record.accuracies.unwrap();
        let (place, speed) = (said.position.unwrap(), said.velocity.unwrap());
        for (said, known, lsb) in [
            (place.east_m(), east, 0.5), (place.north_m(), north, 0.5), (said.geometric.unwrap().metres(), up, HEIGHT_LSB_M),
            (speed.east_m_s(), speed_east, 0.25), (speed.north_m_s(), speed_north, 0.25),
            (said.climb.unwrap().up_m_s(), climb, CLIMB_LSB_M_S),
        ] {
            prop_assert!(said >= known - 1e-9 && said < known + lsb + 1e-9, "{} of {}", said, known);
        }
        let covariance = said.covariance.unwrap().square_metres();
        prop_assert!(covariance.abs() <= place.east_m() * place.north_m());
        prop_assert!(covariance.abs() <= both.abs() + 1e-9 && covariance * both >= 0.0);

        let status = record.track_status.unwrap();
        prop_assert_eq!(status.is_monosensor(), !matches!(source, Source::Fused(..)));
        let serial = source.transponder().map(|part| String::from_utf8(part.identity.serial().unwrap().to_vec()).unwrap());
        let named = record.target_identification.map(|name| name.identification().to_string());
        match serial {
            Some(serial) if !serial[serial.len().saturating_sub(8)..].contains('-') => {
                let named = named.unwrap();
                prop_assert!(serial.ends_with(named.trim()) && serial.len().min(8) == named.len());
            }
            _ => prop_assert_eq!(named, None),
        }
    }

    #[test]
    fn live_tracks_have_distinct_numbers(
        pictures in prop::collection::vec((1..8_i64, prop::collection::btree_set(0..12_u32, 0..8)), 1..60),
    ) {
        let mut encoder = encoder();
        let mut time = noon_and(0.0);
        // Tracks by number.
        let mut alive: BTreeMap<u16, u32> = BTreeMap::new();
        // Time of the last picture, by track.
        let mut seen: BTreeMap<u32, Time> = BTreeMap::new();
        for (seconds, shown) in pictures {
            time = time + SignedDuration::from_secs(seconds);
            // Only three low parts, so that many numbers clash.
            let own = |which: u32| 65_534 + which % 3 + 65_536 * (which / 3);
            let tracks: Vec<PictureTrack> = shown.iter().map(|&which| {
                let mut track = track(own(which), Source::Radar(radar(5, time)), Some(estimate()));
                track.time = time;
                track
            }).collect();
            let records = read(&encoder.encode(time, &tracks));
            let (shown_records, last) = records.split_at(tracks.len());
            for (track, record) in tracks.iter().zip(shown_records) {
                let (number, is_first) = (record.track_number.unwrap().number(), record.track_status.unwrap().is_first());
                let before = alive.insert(number, track.point.number);
                prop_assert_eq!(before, (!is_first).then_some(track.point.number));
                prop_assert_eq!(is_first, !seen.contains_key(&track.point.number));
                seen.insert(track.point.number, time);
            }
            for record in last {
                prop_assert!(record.track_status.unwrap().is_last());
                let whose = alive.remove(&record.track_number.unwrap().number()).unwrap();
                prop_assert!(time - seen.remove(&whose).unwrap() > SignedDuration::from_secs(10));
            }
            prop_assert!(seen.values().all(|&seen| time - seen <= SignedDuration::from_secs(10)));
            prop_assert_eq!(alive.values().collect::<BTreeSet<_>>().len(), alive.len());
        }
    }

    #[test]
    fn records_fill_as_few_datagrams_as_possible_in_order(count in 0..70_u32) {
        let tracks: Vec<_> =
            (0..count).map(|n| track(10_000 + n, Source::Radar(radar(5, noon_and(0.0))), Some(estimate()))).collect();
        let datagrams = encoder().encode(noon_and(0.0), &tracks);
        let numbers: Vec<u32> =
            read(&datagrams).iter().map(|record| record.track_number.unwrap().number().into()).collect();
        prop_assert_eq!(numbers, (10_000..10_000 + count).collect::<Vec<_>>());
        for pair in datagrams.windows(2) {
            let next = (pair[1].len() - 3) / read(&pair[1..]).len();
            prop_assert!(pair[0].len() + next > DATAGRAM_MAX, "no more datagrams than needed");
        }
    }
}
