//! Properties over arbitrary records and octets.

#![allow(clippy::unwrap_used, reason = "a test that meets the unexpected fails")]

mod common;

use asterix::cat048::{
    self, AircraftAddress, AircraftIdentification, FlightLevel, Height3D, Mode3A, PolarPosition,
    TargetReport, TrackNumber, TrackStatus, TrackVelocity, Warnings,
};
use asterix::cat129::{
    self, Altitude, DataDestination, FusionReport, GnssAccuracy, HorizontalVelocity, OperationalRisk,
    Position, VerticalVelocity,
    fusion_report::{Deviation, Flags, Source, UavProbability},
};
use asterix::{Chain, DataSource, Explicit, Format, Fspec, RawItem, Record, TimeOfDay, UapItem, blocks};
use common::{block, encode, read};
use proptest::collection::vec;
use proptest::option::of;
use proptest::prelude::*;

/// Octets of an item in this format; what is not fixed by the format is arbitrary.
fn item_octets(format: Format) -> BoxedStrategy<Vec<u8>> {
    match format {
        Format::Fixed(length) => vec(any::<u8>(), length).boxed(),
        Format::OneOrThree => prop_oneof![vec(any::<u8>(), 1), vec(any::<u8>(), 3)].boxed(),
        Format::Extended => vec(any::<u8>(), 1..=Chain::MAX_OCTETS)
            .prop_map(|mut octets| {
                octets.iter_mut().for_each(|octet| *octet |= 1);
                *octets.last_mut().unwrap() &= !1;
                octets
            })
            .boxed(),
        Format::Explicit => vec(any::<u8>(), 0..60)
            .prop_map(|contents| [&[contents.len() as u8 + 1], contents.as_slice()].concat())
            .boxed(),
        Format::Repetitive(size) => (0..8_u8)
            .prop_flat_map(move |count| (Just(count), vec(any::<u8>(), usize::from(count) * size)))
            .prop_map(|(count, octets)| [&[count], octets.as_slice()].concat())
            .boxed(),
        Format::Compound(subfields) => {
            let subfields: Vec<_> = subfields.iter().map(|&subfield| of(item_octets(subfield))).collect();
            (any::<u8>(), subfields)
                .prop_map(|(spare, subfields)| {
                    let mut octets = vec![spare & (0xff >> subfields.len()) & !1];
                    for (index, subfield) in subfields.into_iter().enumerate() {
                        let Some(subfield) = subfield else { continue };
                        octets[0] |= 0x80 >> index;
                        octets.extend(subfield);
                    }
                    octets
                })
                .boxed()
        }
    }
}

/// Octets of a whole record with arbitrary items of this profile, and its FRNs.
fn record_octets<const N: usize>(uap: [UapItem; N]) -> impl Strategy<Value = Vec<u8>> {
    let items: Vec<_> = uap.iter().map(|item| of(item_octets(item.format))).collect();
    (items, 0..4_u8).prop_map(|(items, padding)| {
        let mut octets = Vec::new();
        Fspec::of::<N>(std::array::from_fn(|index| items[index].is_some()), padding).encode_into(&mut octets);
        octets.extend(items.into_iter().flatten().flatten());
        octets
    })
}

fn data_source() -> impl Strategy<Value = DataSource> {
    any::<(u8, u8)>().prop_map(|(sac, sic)| DataSource { sac, sic })
}

fn time_of_day() -> impl Strategy<Value = TimeOfDay> {
    (0..1_u32 << 24).prop_map(|count| TimeOfDay::from_count(count).unwrap())
}

fn chain() -> impl Strategy<Value = Chain> {
    vec(any::<u8>(), 1..=Chain::MAX_OCTETS).prop_map(|octets| {
        let extend = |chain: Chain, (index, &octet)| chain.with(index, 0xff, octet);
        octets.iter().enumerate().fold(Chain::new(0), extend)
    })
}

fn explicit() -> impl Strategy<Value = Explicit> {
    vec(any::<u8>(), 0..=254).prop_map(|contents| Explicit::new(&contents).unwrap())
}

fn raw(frn: usize) -> impl Strategy<Value = RawItem> {
    let format = cat048::UAP[frn - 1].format;
    item_octets(format).prop_map(move |octets| RawItem::new(format, &octets).unwrap())
}

fn cat048_record() -> impl Strategy<Value = cat048::Record> {
    let word = any::<u16>;
    let plot = (
        of(data_source()),
        of(time_of_day()),
        of(chain().prop_map(TargetReport::from)),
        of((word(), word()).prop_map(|(rho, theta)| PolarPosition { rho, theta })),
        of(word().prop_map(Mode3A::from_word)),
        of(word().prop_map(FlightLevel::from_word)),
        of(raw(7)),
        of((0..1_u32 << 24).prop_map(|address| AircraftAddress::new(address).unwrap())),
        of("[A-Z0-9 ]{0,8}".prop_map(|text| AircraftIdentification::new(&text).unwrap())),
        of(raw(10)),
    );
    let track = (
        of(word().prop_map(TrackNumber::from_word)),
        of(any::<[u8; 4]>()),
        of((word(), word()).prop_map(|(speed, heading)| TrackVelocity { speed, heading })),
        of(chain().prop_map(TrackStatus::from)),
        of(any::<[u8; 4]>()),
        of(vec(0..0x80_u8, 1..=Chain::MAX_OCTETS).prop_map(|codes| Warnings::new(&codes).unwrap())),
    );
    let rest = (
        of(any::<[u8; 2]>()),
        of(any::<[u8; 4]>()),
        of(word().prop_map(Height3D::from_word)),
        of(raw(20)),
        of(any::<[u8; 2]>()),
        of(any::<[u8; 7]>()),
        of(any::<([u8; 1], [u8; 2], [u8; 1], [u8; 2])>()),
        of(explicit()),
        of(explicit()),
        0..=4_u8,
    );
    (plot, track, rest).prop_map(|(plot, track, rest)| cat048::Record {
        data_source: plot.0,
        time_of_day: plot.1,
        target_report: plot.2,
        polar_position: plot.3,
        mode_3a: plot.4,
        flight_level: plot.5,
        plot_characteristics: plot.6,
        aircraft_address: plot.7,
        aircraft_identification: plot.8,
        bds_registers: plot.9,
        track_number: track.0,
        cartesian_position: track.1,
        track_velocity: track.2,
        track_status: track.3,
        track_quality: track.4,
        warnings: track.5,
        mode_3a_confidence: rest.0,
        mode_c: rest.1,
        height_3d: rest.2,
        radial_doppler: rest.3,
        capability: rest.4,
        acas_advisory: rest.5,
        mode_1: rest.6.map(|modes| modes.0),
        mode_2: rest.6.map(|modes| modes.1),
        mode_1_confidence: rest.6.map(|modes| modes.2),
        mode_2_confidence: rest.6.map(|modes| modes.3),
        special_purpose: rest.7,
        reserved_expansion: rest.8,
        fspec_padding: rest.9,
    })
}

fn cat129_record() -> impl Strategy<Value = cat129::Record> {
    let altitude = || (-0x80_0000..=0x7f_ffff_i32).prop_map(|count| Altitude::from_count(count).unwrap());
    let velocity = || (-0x8_0000..=0x7_ffff_i32).prop_map(|count| f64::from(count) / 100.0);
    let who = (
        of(data_source()),
        of(any::<(u8, u8)>().prop_map(|(dac, dic)| DataDestination { dac, dic })),
        of(any::<[u8; 3]>()),
        of(any::<[u8; 3]>()),
        of(any::<[u8; 12]>()),
        of(any::<[u8; 2]>()),
    );
    let what = (
        of(time_of_day()),
        of(any::<(i32, i32)>().prop_map(|(latitude, longitude)| Position { latitude, longitude })),
        of(altitude()),
        of(altitude()),
        of(any::<u16>().prop_map(GnssAccuracy::from_count)),
        of((any::<u8>(), of(any::<[u8; 2]>()))
            .prop_map(|(octet, undescribed)| OperationalRisk { octet, undescribed })),
        of(explicit()),
        of((velocity(), velocity()).prop_map(|(east, north)| HorizontalVelocity::new(east, north).unwrap())),
        of(velocity().prop_map(|up| VerticalVelocity::new(up).unwrap())),
        0..=5_u8,
    );
    (who, what).prop_map(|(who, what)| cat129::Record {
        data_source: who.0,
        data_destination: who.1,
        manufacturer: who.2,
        model: who.3,
        serial_number: who.4,
        registration_country: who.5,
        time_of_day: what.0,
        position: what.1,
        altitude_amsl: what.2,
        altitude_agl: what.3,
        gnss_accuracy: what.4,
        // Before an SP the two lengths of I129/120 cannot always be told apart.
        special_purpose: what.6.filter(|_| what.5.is_none_or(|risk| risk.undescribed.is_none())),
        operational_risk: what.5,
        horizontal_velocity: what.7,
        vertical_velocity: what.8,
        fspec_padding: what.9,
    })
}

/// The octets are one whole record, and it encodes to the same octets.
fn comes_back<R: Record>(contents: &[u8]) {
    let (records, fault) = read::<R>(&block(R::CATEGORY, contents));
    assert_eq!((records.len(), fault), (1, None));
    assert_eq!(encode(&records[0]), contents);
}

/// Of any octets, what is read encodes to the same octets.
fn what_is_read_comes_back<R: Record>(contents: &[u8]) {
    let (records, _) = read::<R>(&block(R::CATEGORY, contents));
    let encoded: Vec<u8> = records.iter().flat_map(encode).collect();
    assert!(contents.starts_with(&encoded));
}

proptest! {
    #[test]
    fn cat048_records(record in cat048_record()) {
        let (records, fault) = read::<cat048::Record>(&block(48, &encode(&record)));
        prop_assert_eq!(fault, None);
        prop_assert_eq!(records, [record]);
    }

    #[test]
    fn cat129_records(record in cat129_record()) {
        let (records, fault) = read::<cat129::Record>(&block(129, &encode(&record)));
        prop_assert_eq!(fault, None);
        prop_assert_eq!(records, [record]);
    }

    #[test]
    fn cat048_octets(contents in record_octets(cat048::UAP)) {
        comes_back::<cat048::Record>(&contents);
    }

    #[test]
    fn cat129_octets(contents in record_octets(cat129::UAP)) {
        comes_back::<cat129::Record>(&contents);
    }

    #[test]
    fn cat048_records_cut_anywhere(contents in record_octets(cat048::UAP), cut in any::<prop::sample::Index>()) {
        let length = cut.index(contents.len());
        let (records, fault) = read::<cat048::Record>(&block(48, &contents[..length]));
        prop_assert!(records.is_empty());
        prop_assert_eq!(fault.is_some(), length > 0);
    }

    #[test]
    fn arbitrary_octets(contents in vec(any::<u8>(), 0..200)) {
        what_is_read_comes_back::<cat048::Record>(&contents);
        what_is_read_comes_back::<cat129::Record>(&contents);
        for block in blocks(&contents).flatten() {
            prop_assert_eq!(block.octets, &contents[block.offset..block.offset + block.octets.len()]);
        }
    }

    #[test]
    fn physical_values_come_back(
        range_m in 0.0..474_100.0, azimuth_deg in -720.0..720.0, height_m in -62_000.0..62_000.0,
        latitude_deg in -90.0..=90.0, longitude_deg in -180.0..=180.0, altitude_m in -800_000.0..800_000.0,
        velocity_m_s in -5000.0..5000.0, seconds in 0.0..86_399.99,
    ) {
        // Half an LSB, and a little for the arithmetic.
        let near = |read: f64, value: f64, lsb: f64| (read - value).abs() <= lsb * 0.500_001;
        let polar = PolarPosition::new(range_m, azimuth_deg).unwrap();
        prop_assert!(near(polar.range_m(), range_m, 1852.0 / 256.0));
        let turn = (polar.azimuth_deg() - azimuth_deg).rem_euclid(360.0);
        prop_assert!(near(turn.min(360.0 - turn), 0.0, 360.0 / 65536.0));
        prop_assert!(near(Height3D::from_metres(height_m).unwrap().height_m(), height_m, 7.62));
        let position = Position::new(latitude_deg, longitude_deg).unwrap();
        prop_assert!(position.in_range());
        prop_assert!(near(position.latitude_deg(), latitude_deg, 180.0 / f64::from(1 << 30)));
        prop_assert!(near(position.longitude_deg(), longitude_deg, 180.0 / f64::from(1 << 30)));
        prop_assert!(near(Altitude::from_metres(altitude_m).unwrap().metres(), altitude_m, 0.1));
        let horizontal = HorizontalVelocity::new(velocity_m_s, -velocity_m_s).unwrap();
        prop_assert!(near(horizontal.east_m_s(), velocity_m_s, 0.01));
        prop_assert!(near(horizontal.north_m_s(), -velocity_m_s, 0.01));
        prop_assert!(near(VerticalVelocity::new(velocity_m_s).unwrap().up_m_s(), velocity_m_s, 0.01));
        prop_assert!(near(TimeOfDay::from_seconds(seconds).unwrap().seconds(), seconds, 1.0 / 128.0));
    }

    #[test]
    fn fusion_reports(
        source in prop_oneof![Just(Source::Fused), Just(Source::Radar), Just(Source::Transponder)],
        track_number in any::<u32>(), radar_track in of(0..u16::MAX), transponder in of(0..u32::MAX),
        deviations_m in (0.0..7000.0, 0.0..7000.0), flags in any::<u8>(), probability in of(0.0..=1.0),
    ) {
        let report = FusionReport {
            source,
            track_number,
            radar_track,
            transponder,
            horizontal_deviation: Deviation::from_metres(deviations_m.0),
            vertical_deviation: Deviation::from_metres(deviations_m.1),
            flags: Flags(flags),
            uav_probability: probability.map_or(UavProbability::UNKNOWN, UavProbability::from_probability),
        };
        prop_assert_eq!(report.to_field().octets().len(), 22);
        prop_assert_eq!(FusionReport::read(&report.to_field()), Some(report));
    }
}
