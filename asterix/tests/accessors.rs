//! Hand-written items agree with their layouts.

#![allow(clippy::unwrap_used, reason = "a test that meets the unexpected fails")]

mod common;

use common::{block, read};
use proptest::collection::vec;
use proptest::prelude::*;
use utm_asterix::cat048::{self, TargetReport, TrackStatus};
use utm_asterix::cat129::{
    self, FusionReport,
    fusion_report::{Flags, Source},
};
use utm_asterix::{Chain, Explicit, Field, Fspec, Kind, Layout, Record};

/// The value of the field with this key: a physical value, or a count.
fn value(fields: &[Field], octets: &[u8], key: &str) -> f64 {
    let mut at = 0;
    for field in fields {
        if field.key == key {
            let count = field.count(octets, at);
            return match field.kind {
                Kind::Quantity(quantity) => quantity.value(count, usize::from(field.bits)),
                Kind::CountFrom(first) => (first + count) as f64,
                _ => count as f64,
            };
        }
        at += usize::from(field.bits);
    }
    panic!("no field {key:?}")
}

/// A record with one item, whose octets begin `octets`, and a function that reads its fields by its layout.
fn with_item<R: Record<Edition: Default>>(number: &str, octets: &[u8]) -> (R, impl Fn(&str) -> f64) {
    let item = R::UAP.iter().find(|item| item.item == number).unwrap();
    let (Layout::Fields(fields) | Layout::OneOrThree(fields)) = item.layout else { panic!() };
    let octets = octets[..utm_asterix::octets_of(fields)].to_vec();
    let mut present = [false; 7 * Fspec::MAX_OCTETS];
    present[usize::from(item.frn) - 1] = true;
    let mut contents = Vec::new();
    Fspec::of(present, 0).encode_into(&mut contents);
    contents.extend_from_slice(&octets);
    let (mut records, fault) = read::<R>(&block(R::CATEGORY, &contents));
    assert_eq!((records.len(), fault), (1, None));
    (records.remove(0), move |key: &str| value(fields, &octets, key))
}

/// Whether two values are equal except for rounding.
fn close(ours: f64, layout: f64) -> bool {
    (ours - layout).abs() <= 1e-12 * layout.abs().max(1e-9)
}

/// The count of the field with this key; `None` if the chain ends before it.
fn in_chain(layout: Layout, chain: &Chain, key: &str) -> Option<u64> {
    let Layout::Extended(octets) = layout else { panic!() };
    let (index, fields) =
        octets.iter().enumerate().find(|(_, fields)| fields.iter().any(|field| field.key == key)).unwrap();
    chain.octet(index).map(|octet| value(fields, &[octet], key) as u64)
}

fn chain() -> impl Strategy<Value = Chain> {
    vec(any::<u8>(), 1..=8).prop_map(|octets| {
        let extend = |chain: Chain, (index, &octet)| chain.with(index, 0xff, octet);
        octets.iter().enumerate().fold(Chain::new(0), extend)
    })
}

proptest! {
    #[test]
    fn items_of_cat048(octets in any::<[u8; 8]>()) {
        let (record, field) = with_item::<cat048::Record>("010", &octets);
        let source = record.data_source.unwrap();
        prop_assert_eq!((f64::from(source.sac), f64::from(source.sic)), (field("sac"), field("sic")));

        let (record, field) = with_item::<cat048::Record>("140", &octets);
        prop_assert_eq!(record.time_of_day.unwrap().seconds(), field(""));

        let (record, field) = with_item::<cat048::Record>("040", &octets);
        let position = record.polar_position.unwrap();
        prop_assert_eq!((position.range_m(), position.azimuth_deg()), (field("rho_m"), field("theta_deg")));
        prop_assert_eq!(position.range_m(), field("rho_m"));

        let (record, field) = with_item::<cat048::Record>("070", &octets);
        let code = record.mode_3a.unwrap();
        prop_assert_eq!(f64::from(code.code()), field("mode_3a"));
        let flags = [!code.is_validated(), code.is_garbled(), code.is_not_extracted()];
        prop_assert_eq!(flags.map(|flag| f64::from(u8::from(flag))), ["v", "g", "l"].map(&field));

        let (record, field) = with_item::<cat048::Record>("090", &octets);
        let level = record.flight_level.unwrap();
        prop_assert_eq!(level.flight_level(), field("flight_level"));
        let flags = [!level.is_validated(), level.is_garbled()];
        prop_assert_eq!(flags.map(|flag| f64::from(u8::from(flag))), ["v", "g"].map(&field));

        let (record, field) = with_item::<cat048::Record>("110", &octets);
        prop_assert!(close(record.height_3d.unwrap().height_m(), field("height_m")));

        let (record, field) = with_item::<cat048::Record>("220", &octets);
        prop_assert_eq!(f64::from(record.aircraft_address.unwrap().address()), field(""));

        let (record, field) = with_item::<cat048::Record>("161", &octets);
        prop_assert_eq!(f64::from(record.track_number.unwrap().number()), field("track_number"));

        let (record, field) = with_item::<cat048::Record>("200", &octets);
        let velocity = record.track_velocity.unwrap();
        prop_assert_eq!(velocity.speed_m_s(), field("speed_m_s"));
        prop_assert_eq!(velocity.heading_deg(), field("heading_deg"));
    }

    #[test]
    fn items_of_cat129(octets in any::<[u8; 8]>()) {
        let (record, field) = with_item::<cat129::Record>("015", &octets);
        let destination = record.data_destination.unwrap();
        prop_assert_eq!((f64::from(destination.dac), f64::from(destination.dic)), (field("dac"), field("dic")));

        let (record, field) = with_item::<cat129::Record>("070", &octets);
        prop_assert_eq!(record.time_of_day.unwrap().seconds(), field(""));

        let (record, field) = with_item::<cat129::Record>("080", &octets);
        let position = record.position.unwrap();
        prop_assert!(close(position.latitude_deg(), field("latitude_deg")));
        prop_assert!(close(position.longitude_deg(), field("longitude_deg")));

        let (record, field) = with_item::<cat129::Record>("090", &octets);
        prop_assert!(close(record.altitude_amsl.unwrap().metres(), field("altitude_m")));
        let (record, field) = with_item::<cat129::Record>("100", &octets);
        prop_assert!(close(record.altitude_agl.unwrap().metres(), field("altitude_m")));

        let (record, field) = with_item::<cat129::Record>("110", &octets);
        prop_assert_eq!(f64::from(record.gnss_accuracy.unwrap().count()), field("accuracy_m"));

        let (record, field) = with_item::<cat129::Record>("120", &octets);
        let risk = record.operational_risk.unwrap();
        prop_assert_eq!(f64::from(risk.categories.certification() as u8), field("certification_category"));
        prop_assert_eq!(f64::from(risk.categories.air_risk()), field("air_risk_category"));
        prop_assert_eq!(f64::from(risk.categories.airspace_encounter()), field("airspace_encounter_category"));

        let (record, field) = with_item::<cat129::Record>("185", &octets);
        let velocity = record.horizontal_velocity.unwrap();
        prop_assert!(close(velocity.east_m_s(), field("east_m_s")));
        prop_assert!(close(velocity.north_m_s(), field("north_m_s")));

        let (record, field) = with_item::<cat129::Record>("220", &octets);
        prop_assert!(close(record.vertical_velocity.unwrap().up_m_s(), field("up_m_s")));
    }

    #[test]
    fn target_report(chain in chain()) {
        let report = TargetReport::from(chain);
        let count = |key: &str| in_chain(cat048::UAP[2].layout, &chain, key);
        let flag = |key: &str| count(key).unwrap_or(0) == 1;
        prop_assert_eq!(report.detection() as u64, count("typ").unwrap());
        prop_assert_eq!(report.is_simulated(), flag("sim"));
        prop_assert_eq!(u64::from(report.is_chain_2()), count("rdp").unwrap());
        prop_assert_eq!(report.is_special_position(), flag("spi"));
        prop_assert_eq!(report.is_field_monitor(), flag("rab"));
        prop_assert_eq!(report.is_test(), flag("tst"));
        prop_assert_eq!(report.is_extended_range(), flag("err"));
        prop_assert_eq!(report.has_x_pulse(), flag("xpp"));
        prop_assert_eq!(report.is_military_emergency(), flag("me"));
        prop_assert_eq!(report.is_military_identification(), flag("mi"));
        prop_assert_eq!(report.friend_or_foe() as u64, count("foe_fri").unwrap_or(0));
        let populated = |key: &str| count(key).filter(|_| flag(&format!("{key}_ep")));
        for (key, ours) in [
            ("adsb", report.on_site_adsb()),
            ("scn", report.surveillance_cluster()),
            ("pai", report.passive_acquisition()),
            ("poxpr", report.phase_overlay_supported()),
            ("poact", report.phase_overlay_active()),
            ("dtfxpr", report.dataflash_supported()),
            ("dtfact", report.dataflash_active()),
            ("irmxpr", report.reply_monitoring_supported()),
            ("irmact", report.reply_monitoring_active()),
        ] {
            prop_assert_eq!(ours.map(u64::from), populated(key), "{}", key);
        }
        prop_assert_eq!(report.acas_version().map(u64::from), populated("acasxv"));
    }

    #[test]
    fn track_status(chain in chain()) {
        let status = TrackStatus::from(chain);
        let count = |key: &str| in_chain(cat048::UAP[13].layout, &chain, key).unwrap_or(0);
        prop_assert_eq!(u64::from(status.is_tentative()), count("cnf"));
        prop_assert_eq!(status.sensor() as u64, count("rad"));
        prop_assert_eq!(u64::from(status.is_doubtful()), count("dou"));
        prop_assert_eq!(u64::from(status.is_manoeuvring()), count("mah"));
        prop_assert_eq!(status.climb_mode() as u64, count("cdm"));
        prop_assert_eq!(u64::from(status.is_last_report()), count("tre"));
        prop_assert_eq!(u64::from(status.is_ghost()), count("gho"));
        prop_assert_eq!(u64::from(status.is_supplemented()), count("sup"));
        prop_assert_eq!(u64::from(status.is_slant_range_corrected()), count("tcc"));
    }

    #[test]
    fn fusion_report(mut contents in any::<[u8; 21]>(), source in 1..=4_u8) {
        contents[..4].copy_from_slice(&[b'U', b'F', 1, source]);
        let report = FusionReport::read(&Explicit::new(&contents).unwrap()).unwrap();
        let field = |key: &str| value(FusionReport::FIELDS, &contents, key);
        let number = match report.source {
            Source::Fused => 1.0,
            Source::Radar => 2.0,
            Source::Transponder => 3.0,
            Source::Camera => 4.0,
        };
        prop_assert_eq!(number, field("source"));
        prop_assert_eq!(f64::from(report.track_number), field("track_number"));
        prop_assert_eq!(f64::from(report.radar_track.unwrap_or(u16::MAX)), field("radar_track"));
        prop_assert_eq!(f64::from(report.transponder.unwrap_or(u32::MAX)), field("transponder"));
        let metres = report.horizontal_deviation.metres();
        prop_assert!(metres.is_none_or(|metres| close(metres, field("horizontal_deviation_m"))));
        let metres = report.vertical_deviation.metres();
        prop_assert!(metres.is_none_or(|metres| close(metres, field("vertical_deviation_m"))));
        let probability = report.uav_probability.probability();
        prop_assert!(probability.is_none_or(|probability| close(probability, field("uav_probability"))));
        for (flag, key) in [
            (Flags::INTERPOLATED, "interpolated"),
            (Flags::EXTRAPOLATED, "extrapolated"),
            (Flags::INTEGRITY_SUSPECT, "integrity_suspect"),
            (Flags::INTEGRITY_FAILED, "integrity_failed"),
            (Flags::UNCOOPERATIVE, "uncooperative"),
            (Flags::HEIGHT_NOT_MEASURED, "height_not_measured"),
        ] {
            prop_assert_eq!(report.flags.contains(flag), field(key) == 1.0, "{}", key);
        }
    }
}
