//! For any octets nothing is counted twice or left out.

use std::net::SocketAddr;

use asterix::{Record, blocks, cat048, cat129};
use fusion::time::Time;
use proptest::prelude::*;
use utm_fusion::capture::{CapturedDatagram, Endpoints};
use utm_fusion::survey::{SOURCES, STREAMS, Survey, SurveyReport};

use super::{block, fix, plot};

fn survey(datagrams: impl IntoIterator<Item = CapturedDatagram>) -> SurveyReport {
    let mut survey = Survey::default();
    datagrams.into_iter().for_each(|datagram| survey.datagram(&datagram));
    survey.report()
}

fn datagram(payload: Vec<u8>) -> CapturedDatagram {
    CapturedDatagram { payload, ..CapturedDatagram::default() }
}

/// Blocks of records, complete and truncated.
fn any_payload() -> impl Strategy<Value = Vec<u8>> {
    let time = 0.0..131_000.0;
    let plots =
        (any::<u8>(), time.clone(), 0..4096_u16).prop_map(|(sic, time, track)| plot(sic, time, track));
    let fixes = (time, any::<u8>()).prop_map(|(time, serial)| fix(time, serial));
    let any_block = prop_oneof![
        prop::collection::vec(plots, 0..4).prop_map(|records| block(48, &records)),
        fixes.prop_map(|record| block(129, &[record])),
        (any::<u8>(), prop::collection::vec(any::<u8>(), 0..9)).prop_map(|(category, octets)| {
            [&[category, 0, octets.len() as u8 + 3], octets.as_slice()].concat()
        }),
    ];
    (prop::collection::vec(any_block, 0..6), prop::option::of((any::<prop::sample::Index>(), any::<u8>())))
        .prop_map(|(blocks, damage)| {
            let mut payload = blocks.concat();
            if let (Some((place, octet)), false) = (damage, payload.is_empty()) {
                let place = place.index(payload.len());
                payload[place] = octet;
            }
            payload
        })
}

fn records<R: Record<Edition = ()>>(payload: &[u8]) -> (u64, u64) {
    let of_category = blocks(payload).flatten().filter(|block| block.category == R::CATEGORY);
    let all: Vec<_> = of_category.flat_map(|block| block.records::<R>()).collect();
    let read = all.iter().filter(|located| located.is_ok()).count();
    (read as u64, (all.len() - read) as u64)
}

proptest! {
    #[test]
    fn records_octets_and_errors_add_up(payloads in prop::collection::vec((any_payload(), any::<Option<u32>>()), 1..8)) {
        let report = survey(payloads.iter().map(|(payload, received)| CapturedDatagram {
            received: received.map(|seconds| Time::from_nanos(i64::from(seconds) * 1_000_000_000)),
            ..datagram(payload.clone())
        }));
        for (category, count) in
            [(48, records::<cat048::Record> as fn(&[u8]) -> (u64, u64)), (129, records::<cat129::Record>)]
        {
            let (read, bad) = payloads.iter().map(|(payload, _)| count(payload)).fold((0, 0), |a, b| (a.0 + b.0, a.1 + b.1));
            let of_sources: u64 = report.sources.iter().filter(|s| s.category == category).map(|s| s.records).sum();
            let of_category = report.categories.iter().find(|c| c.category == category);
            prop_assert_eq!(of_sources, read);
            prop_assert_eq!(of_category.map_or(0, |c| c.records.unwrap_or(0)), read);
            let in_records = |kind: &str| !kind.starts_with("block_");
            let errors = report.errors.iter().filter(|e| e.category == Some(category) && in_records(e.kind));
            prop_assert_eq!(errors.map(|error| error.count).sum::<u64>(), bad);
        }
        let octets: u64 = report.categories.iter().map(|category| category.octets).sum();
        let no_block: usize = payloads.iter().map(|(payload, _)| {
            blocks(payload).find_map(Result::err).map_or(0, |fault| payload.len() - fault.offset)
        }).sum();
        prop_assert_eq!(octets + no_block as u64, report.octets);
        prop_assert_eq!(report.octets, payloads.iter().map(|(payload, _)| payload.len() as u64).sum::<u64>());
        for source in &report.sources {
            let items: Vec<u64> = source.items.0.iter().map(|(_, count)| *count).collect();
            prop_assert!(items.iter().all(|&count| 0 < count && count <= source.records));
        }
    }
}

#[test]
fn what_is_told_apart_is_bounded_and_the_rest_is_counted() {
    let count = 2_000_u16;
    let report = survey((0..count).map(|number| {
        let record = format!("c110 {number:04x} 000100 0001");
        let at = |port| SocketAddr::from(([10, 0, 0, 1], port));
        let endpoints = Some(Endpoints { source: at(number), destination: at(8048) });
        CapturedDatagram { endpoints, ..datagram(block(48, &[record])) }
    }));
    assert_eq!((report.sources.len(), report.streams.len()), (SOURCES, STREAMS));
    assert_eq!(report.records_of_more_sources, u64::from(count) - SOURCES as u64);
    assert_eq!(report.datagrams_of_more_streams, u64::from(count) - STREAMS as u64);
    assert_eq!(report.categories[0].records, Some(u64::from(count)));
}
