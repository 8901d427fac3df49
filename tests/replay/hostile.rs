//! Invalid and random datagrams: nothing panics, everything is counted, and intact datagrams are not affected.

use std::collections::BTreeSet;
use std::sync::LazyLock;

use proptest::prelude::*;
use proptest::sample::Index;
use utm_fusion::capture::Reception;
use utm_fusion::config::Config;
use utm_fusion::pipeline::Event;

use super::common::{Flown, contents, demo, fly};

/// Mutation of a datagram.
#[derive(Clone, Debug)]
enum Mutation {
    /// Inverts these bits of an octet.
    Flip(Index, u8),
    /// Truncates the datagram.
    Cut(Index),
    /// Duplicates the datagram.
    Duplicate,
    /// Inserts octets.
    Insert(Index, Vec<u8>),
    /// Appends a datagram of random octets.
    Noise(Vec<u8>),
}

fn mutation() -> impl Strategy<Value = Mutation> {
    let octets = || prop::collection::vec(any::<u8>(), 1..30);
    let noise = (prop_oneof![Just(48_u8), Just(129), any::<u8>()], octets())
        .prop_map(|(category, octets)| [&[category, 0, octets.len() as u8 + 3][..], &octets].concat());
    prop_oneof![
        4 => (any::<Index>(), 1..=u8::MAX).prop_map(|(at, bits)| Mutation::Flip(at, bits)),
        1 => any::<Index>().prop_map(Mutation::Cut),
        1 => Just(Mutation::Duplicate),
        1 => (any::<Index>(), octets()).prop_map(|(at, octets)| Mutation::Insert(at, octets)),
        1 => prop_oneof![noise, octets()].prop_map(Mutation::Noise),
    ]
}

/// A reception with its original index; `None` if it was modified or added.
type Traced = (Option<usize>, Reception);

/// Applies mutations. Reception times stay, so the engine's time is unchanged. Copies and noise follow directly.
fn mutated(receptions: &[Reception], plan: &[(Index, Mutation)]) -> Vec<Traced> {
    let mut traced: Vec<Traced> = receptions.iter().cloned().enumerate().map(|(i, r)| (Some(i), r)).collect();
    for (at, mutation) in plan {
        let at = at.index(traced.len());
        let mut extra = traced[at].1.clone();
        let (whole, reception) = &mut traced[at];
        let payload = &mut reception.payload;
        match mutation {
            Mutation::Duplicate => traced.insert(at + 1, (None, extra)),
            Mutation::Noise(octets) => {
                extra.payload.clone_from(octets);
                traced.insert(at + 1, (None, extra));
            }
            _ if payload.is_empty() => {}
            Mutation::Flip(octet, bits) => {
                let octet = octet.index(payload.len());
                payload[octet] ^= bits;
                *whole = None;
            }
            Mutation::Cut(length) => {
                payload.truncate(length.index(payload.len()));
                *whole = None;
            }
            Mutation::Insert(before, octets) => {
                let before = before.index(payload.len());
                payload.splice(before..before, octets.iter().copied());
                *whole = None;
            }
        }
    }
    traced
}

fn is_record(event: &Event) -> bool {
    matches!(event, Event::Accepted { .. } | Event::Refused { .. } | Event::Service { .. })
}

/// Checks that every datagram is handled or a copy, and that every record, fault and block of a handled one is in
/// exactly one counter.
fn assert_accounted(receptions: &[&Reception], flown: &Flown) -> Result<(), TestCaseError> {
    let tally = &flown.tally;
    prop_assert_eq!(tally.received, receptions.len() as u64);
    prop_assert_eq!(tally.octets, receptions.iter().map(|r| r.payload.len() as u64).sum::<u64>());
    let (mut copies, mut records, mut faults, mut others) = (0, 0, 0, 0);
    for (reception, events) in receptions.iter().zip(&flown.events) {
        if events.contains(&Event::DuplicateDatagram) {
            copies += 1;
            prop_assert_eq!(events.len(), 2, "received, and no more: {:?}", events);
            continue;
        }
        let contents = contents(&reception.payload);
        let whole = contents.plots.len() + contents.fixes.len() + contents.services.len();
        prop_assert_eq!(events.iter().filter(|event| is_record(event)).count(), whole);
        records += whole as u64;
        faults += contents.faults as u64;
        others += contents.others as u64;
    }
    prop_assert_eq!(tally.duplicates, copies);
    let accepted = tally.accepted.values().sum::<u64>() + tally.service.values().sum::<u64>();
    let refused = tally.refused.values().sum::<u64>() + tally.unknown_sources.values().sum::<u64>();
    prop_assert_eq!(accepted + refused, records);
    prop_assert_eq!(tally.faults.values().sum::<u64>(), faults);
    prop_assert_eq!(tally.skipped.values().sum::<u64>(), others);
    Ok(())
}

struct Calm {
    config: Config,
    receptions: Vec<Reception>,
    flown: Flown,
}

/// The unmodified flight.
static CALM: LazyLock<Calm> = LazyLock::new(|| {
    let flight = demo();
    let (config, receptions) = (flight.config(), flight.receptions());
    let flown = fly(&config, &receptions);
    Calm { config, receptions, flown }
});

proptest! {
    #![proptest_config(ProptestConfig { cases: 96, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn hostile_input_is_counted_and_costs_no_valid_record(
        plan in prop::collection::vec((any::<Index>(), mutation()), 1..60),
    ) {
        let Calm { config, receptions, flown: calm } = &*CALM;
        let traced = mutated(receptions, &plan);
        let (origins, mutated): (Vec<_>, Vec<_>) = traced.into_iter().unzip();
        let flown = fly(config, &mutated);
        assert_accounted(&mutated.iter().collect::<Vec<_>>(), &flown)?;

        // The outcome of a datagram depends on its octets, its reception time, the engine's time, and whether it is a
        // copy. The first three are unchanged for intact datagrams. The last may change only for octets of modified or
        // added datagrams.
        let left_whole: BTreeSet<_> = origins.iter().flatten().collect();
        let became_others = receptions.iter().enumerate().filter(|(index, _)| !left_whole.contains(index));
        let came_anew = mutated.iter().zip(&origins).filter(|(_, origin)| origin.is_none());
        let copies: BTreeSet<_> = became_others
            .map(|(_, reception)| &reception.payload)
            .chain(came_anew.map(|(reception, _)| &reception.payload))
            .collect();
        for ((reception, origin), events) in mutated.iter().zip(&origins).zip(&flown.events) {
            if let Some(origin) = origin && !copies.contains(&reception.payload) {
                prop_assert_eq!(events, &calm.events[*origin], "{:?}", reception);
            }
        }

        // Slots are emitted once and in order, with finite positions.
        prop_assert!(flown.emissions.windows(2).all(|pair| pair[0].slot < pair[1].slot));
        let points = flown.emissions.iter().flat_map(|emission| &emission.points);
        prop_assert!(points.into_iter().all(|point| point.position.0.iter().all(|metres| metres.is_finite())));
    }

    #[test]
    fn random_octets_are_counted(
        noise in prop::collection::vec(prop::collection::vec(any::<u8>(), 0..80), 0..40),
    ) {
        let Calm { config, receptions, .. } = &*CALM;
        let noisy = |(octets, reception): (Vec<u8>, &Reception)| Reception { payload: octets, ..reception.clone() };
        let receptions: Vec<_> = noise.into_iter().zip(receptions).map(noisy).collect();
        assert_accounted(&receptions.iter().collect::<Vec<_>>(), &fly(config, &receptions))?;
    }
}
