//! Effects of the network: arriving datagrams are compared with those over a perfect network.

use std::collections::{BTreeMap, HashMap};

use asterix::{DataSource, Record, blocks, cat048};
use utm_fusion::simulate::{Network, SimulatedDatagram, Span, simulate};

use crate::common::{between, mean, perfect};

/// Datagrams that arrive over this network, and over a perfect one.
fn over(network: Network) -> (Vec<SimulatedDatagram>, Vec<SimulatedDatagram>) {
    let mut scenario = perfect(5, 0, 0);
    let clean = simulate(&scenario, 1, None).unwrap().datagrams;
    scenario.network = network;
    (simulate(&scenario, 1, None).unwrap().datagrams, clean)
}

/// Delay of each datagram compared with the perfect network, seconds; by payload.
fn behind_s(arrived: &[SimulatedDatagram], clean: &[SimulatedDatagram]) -> BTreeMap<Vec<u8>, Vec<f64>> {
    let on_time: HashMap<&[u8], &SimulatedDatagram> =
        clean.iter().map(|datagram| (&datagram.payload[..], datagram)).collect();
    assert_eq!(on_time.len(), clean.len(), "every datagram is another");
    let mut behind: BTreeMap<Vec<u8>, Vec<f64>> = BTreeMap::new();
    for datagram in arrived {
        let sent = on_time[&datagram.payload[..]];
        behind
            .entry(datagram.payload.clone())
            .or_default()
            .push(datagram.received.seconds_since(sent.received));
    }
    behind
}

fn is_in_order(datagrams: &[SimulatedDatagram]) -> bool {
    datagrams.is_sorted_by_key(|datagram| datagram.received)
}

#[test]
fn fifth_of_datagrams_is_lost() {
    let (arrived, clean) = over(Network { lost: 0.2, ..Network::default() });
    assert!(behind_s(&arrived, &clean).values().all(|behind| *behind == [0.0]));
    between("share lost", 0.175, 1.0 - arrived.len() as f64 / clean.len() as f64, 0.225);
}

#[test]
fn fifth_of_datagrams_is_duplicated() {
    let span = Span::new(0.01, 0.8);
    let (arrived, clean) = over(Network { duplicated: 0.2, behind_s: span, ..Network::default() });
    let behind = behind_s(&arrived, &clean);
    assert_eq!(behind.len(), clean.len());
    assert!(behind.values().all(|times| times[0] == 0.0 && times.len() <= 2));
    let copies: Vec<f64> = behind.values().filter_map(|times| times.get(1)).copied().collect();
    between("share doubled", 0.175, copies.len() as f64 / clean.len() as f64, 0.225);
    assert!(copies.iter().all(|copy| (0.0099..=0.801).contains(copy)));
    between("mean of how far behind, s", 0.37, mean(&copies), 0.44);
    assert!(is_in_order(&arrived));
}

#[test]
fn fifth_of_datagrams_is_out_of_order() {
    let span = Span::new(0.4, 0.8);
    let (arrived, clean) = over(Network { reordered: 0.2, behind_s: span, ..Network::default() });
    let behind = behind_s(&arrived, &clean);
    assert_eq!((behind.len(), arrived.len()), (clean.len(), clean.len()));
    let late: Vec<f64> = behind.values().map(|times| times[0]).filter(|late| *late > 0.0).collect();
    between("share held back", 0.175, late.len() as f64 / clean.len() as f64, 0.225);
    assert!(late.iter().all(|late| (0.3999..=0.801).contains(late)));
    assert!(is_in_order(&arrived), "times of reception only grow");
    let order =
        |datagrams: &[SimulatedDatagram]| datagrams.iter().map(|one| one.payload.clone()).collect::<Vec<_>>();
    assert_ne!(order(&arrived), order(&clean));
}

#[test]
fn second_line_repeats_every_datagram() {
    let span = Span::new(0.02, 0.05);
    let (arrived, clean) =
        over(Network { second_line: true, second_line_behind_s: span, ..Network::default() });
    let behind = behind_s(&arrived, &clean);
    assert_eq!(arrived.len(), 2 * clean.len());
    assert!(behind.values().all(|times| times[0] == 0.0 && (0.0199..=0.0501).contains(&times[1])));
    for datagram in &arrived {
        let ports = if datagram.payload[0] == 129 { [8129, 8139] } else { [8048, 8058] };
        assert!(ports.contains(&datagram.flow.port), "{:?}", datagram.flow);
    }
    let second = arrived.iter().filter(|datagram| [8058, 8139].contains(&datagram.flow.port)).count();
    assert_eq!(second, clean.len());
}

#[test]
fn foreign_sources_send_datagrams() {
    let (arrived, clean) =
        over(Network { foreign_source_per_s: 2.0, foreign_category_per_s: 1.0, ..Network::default() });
    let ours: HashMap<&[u8], ()> = clean.iter().map(|datagram| (&datagram.payload[..], ())).collect();
    let (mut sources, mut categories) = (0, 0);
    for datagram in arrived.iter().filter(|datagram| !ours.contains_key(&datagram.payload[..])) {
        let block = blocks(&datagram.payload).next().unwrap().unwrap();
        if block.category == cat048::Record::CATEGORY {
            let record = block.records::<cat048::Record>().next().unwrap().unwrap().record;
            assert_eq!(record.data_source, Some(DataSource { sac: 99, sic: 98 }));
            sources += 1;
        } else {
            assert!(![34, 48, 65, 129].contains(&block.category), "{}", block.category);
            categories += 1;
        }
    }
    assert_eq!(arrived.len(), clean.len() + sources + categories);
    between("foreign sources a second", 1.75, sources as f64 / 300.0, 2.25);
    between("foreign categories a second", 0.8, categories as f64 / 300.0, 1.2);
}
