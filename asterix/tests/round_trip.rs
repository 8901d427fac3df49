//! Properties of records and their values: encoded values are decoded again.

#![allow(clippy::unwrap_used, reason = "a test that meets the unexpected fails")]

mod common;

use common::{block, encode, read};
use proptest::collection::vec;
use proptest::option::of;
use proptest::prelude::*;
use utm_asterix::cat048::{
    self, AcasAdvisory, AircraftAddress, AircraftIdentification, Amplitude, AzimuthDifference, BdsRegister,
    CalculatedDoppler, Capability, CartesianPosition, FlightLevel, Height3D, Mode1, Mode1Confidence, Mode2,
    Mode2Confidence, Mode3A, Mode3AConfidence, ModeC, PlotCharacteristics, PolarPosition, RadialDoppler,
    RangeDifference, RawDoppler, Replies, RunLength, TargetReport, TrackNumber, TrackQuality, TrackStatus,
    TrackVelocity, Warnings,
};
use utm_asterix::cat129::{
    self, Altitude, DataDestination, FusionReport, GnssAccuracy, HorizontalVelocity, OperationalRisk,
    Position, RiskCategories, VerticalVelocity,
    fusion_report::{Deviation, Flags, Source, UavProbability},
};
use utm_asterix::{Chain, DataSource, Explicit, Repeated, TimeOfDay};

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

fn plot_characteristics() -> impl Strategy<Value = PlotCharacteristics> {
    let octet = || of(any::<[u8; 1]>());
    (octet(), octet(), octet(), octet(), octet(), octet(), octet()).prop_map(|octets| PlotCharacteristics {
        ssr_run_length: octets.0.map(RunLength::from_octets),
        ssr_replies: octets.1.map(Replies::from_octets),
        ssr_amplitude: octets.2.map(Amplitude::from_octets),
        psr_run_length: octets.3.map(RunLength::from_octets),
        psr_amplitude: octets.4.map(Amplitude::from_octets),
        range_difference: octets.5.map(RangeDifference::from_octets),
        azimuth_difference: octets.6.map(AzimuthDifference::from_octets),
    })
}

fn radial_doppler() -> impl Strategy<Value = RadialDoppler> {
    let raw = vec(any::<[u8; 6]>().prop_map(RawDoppler::from_octets), 0..=255);
    (of(any::<[u8; 2]>()), of(raw)).prop_map(|(calculated, raw)| RadialDoppler {
        calculated: calculated.map(CalculatedDoppler::from_octets),
        raw: raw.map(|parts| Repeated::new(&parts).unwrap()),
    })
}

fn bds_registers() -> impl Strategy<Value = Repeated<BdsRegister>> {
    vec(any::<[u8; 8]>().prop_map(BdsRegister::from_octets), 0..=255)
        .prop_map(|parts| Repeated::new(&parts).unwrap())
}

fn cat048_record() -> impl Strategy<Value = cat048::Record> {
    let plot = (
        of(data_source()),
        of(time_of_day()),
        of(chain().prop_map(TargetReport::from)),
        of(any::<[u8; 4]>().prop_map(PolarPosition::from_octets)),
        of(any::<[u8; 2]>().prop_map(Mode3A::from_octets)),
        of(any::<[u8; 2]>().prop_map(FlightLevel::from_octets)),
        of(plot_characteristics()),
        of((0..1_u32 << 24).prop_map(|address| AircraftAddress::new(address).unwrap())),
        of("[A-Z0-9 ]{0,8}".prop_map(|text| AircraftIdentification::new(&text).unwrap())),
        of(bds_registers()),
    );
    let track = (
        of(any::<[u8; 2]>().prop_map(TrackNumber::from_octets)),
        of(any::<[u8; 4]>().prop_map(CartesianPosition::from_octets)),
        of(any::<[u8; 4]>().prop_map(TrackVelocity::from_octets)),
        of(chain().prop_map(TrackStatus::from)),
        of(any::<[u8; 4]>().prop_map(TrackQuality::from_octets)),
        of(vec(0..0x80_u8, 1..=Chain::MAX_OCTETS).prop_map(|codes| Warnings::new(&codes).unwrap())),
    );
    let rest = (
        of(any::<[u8; 2]>().prop_map(Mode3AConfidence::from_octets)),
        of(any::<[u8; 4]>().prop_map(ModeC::from_octets)),
        of(any::<[u8; 2]>().prop_map(Height3D::from_octets)),
        of(radial_doppler()),
        of(any::<[u8; 2]>().prop_map(Capability::from_octets)),
        of(any::<[u8; 7]>().prop_map(AcasAdvisory::from_octets)),
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
        mode_1: rest.6.map(|modes| Mode1::from_octets(modes.0)),
        mode_2: rest.6.map(|modes| Mode2::from_octets(modes.1)),
        mode_1_confidence: rest.6.map(|modes| Mode1Confidence::from_octets(modes.2)),
        mode_2_confidence: rest.6.map(|modes| Mode2Confidence::from_octets(modes.3)),
        special_purpose: rest.7,
        reserved_expansion: rest.8,
        fspec_padding: rest.9,
    })
}

fn cat129_record() -> impl Strategy<Value = cat129::Record> {
    let altitude = || any::<[u8; 3]>().prop_map(Altitude::from_octets);
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
        of(any::<[u8; 8]>().prop_map(Position::from_octets)),
        of(altitude()),
        of(altitude()),
        of(any::<u16>().prop_map(GnssAccuracy::from_count)),
        of((any::<[u8; 1]>(), of(any::<[u8; 2]>())).prop_map(|(octet, undescribed)| OperationalRisk {
            categories: RiskCategories::from_octets(octet),
            undescribed,
        })),
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
        // Before an SP the two lengths of I129/120 are not always distinguishable.
        special_purpose: what.6.filter(|_| what.5.is_none_or(|risk| risk.undescribed.is_none())),
        operational_risk: what.5,
        horizontal_velocity: what.7,
        vertical_velocity: what.8,
        fspec_padding: what.9,
    })
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
    fn physical_values_come_back(
        range_m in 0.0..474_100.0, azimuth_deg in -720.0..720.0, height_m in -62_000.0..62_000.0,
        latitude_deg in -90.0..=90.0, longitude_deg in -180.0..=180.0, altitude_m in -800_000.0..800_000.0,
        velocity_m_s in -5000.0..5000.0, seconds in 0.0..86_399.99,
    ) {
        // Half an LSB, with a margin for rounding.
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
