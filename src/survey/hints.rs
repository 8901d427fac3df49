//! The sensors that a configuration for the capture would list.

use std::collections::BTreeSet;
use std::net::IpAddr;

use super::report::{LineHint, SensorHint, SourceReport};
use crate::capture::Endpoints;

/// A sensor sends at least a twentieth of the busiest one's records; others are strays.
const STRAY: u64 = 20;

/// Radars and transponder receivers among the sources.
pub(super) fn sensors(sources: &[SourceReport]) -> Vec<SensorHint> {
    let busiest = |category: u8| {
        let records = sources.iter().filter(|other| other.category == category).map(|other| other.records);
        records.max().unwrap_or(0)
    };
    let hint = |source: &SourceReport| {
        let kind = match source.category {
            48 => "radar",
            129 => "transponder",
            _ => return None,
        };
        let is_stray = source.records.saturating_mul(STRAY) < busiest(source.category);
        let (sac, sic) = source.sac.zip(source.sic).filter(|_| !is_stray)?;
        let inputs: BTreeSet<_> = source.lines.iter().filter_map(input).collect();
        Some(SensorHint {
            kind,
            sac,
            sic,
            period_s: source
                .interval
                .filter(|interval| interval.of != "record")
                .and_then(|interval| period_s(interval.median_s)),
            classification: (kind == "radar").then(|| classification(source)),
            inputs: inputs.into_iter().collect(),
        })
    };
    sources.iter().filter_map(hint).collect()
}

/// Two decimals are enough for a period of the configuration, which is at most an hour.
fn period_s(median_s: f64) -> Option<f64> {
    let rounded = (median_s * 100.0).round() / 100.0;
    (rounded > 0.0 && rounded <= 3600.0).then_some(rounded)
}

/// By what most records have.
fn classification(radar: &SourceReport) -> &'static str {
    let in_most = |item| radar.items.count(item) * 2 > radar.records;
    if in_most("SP") {
        "special-purpose"
    } else if in_most("030") {
        "target-classification"
    } else {
        "constant"
    }
}

/// The configuration knows IPv4 only.
fn input(endpoints: &Endpoints) -> Option<LineHint> {
    match endpoints.destination.ip() {
        IpAddr::V4(address) => {
            Some(LineHint { multicast: address.is_multicast(), address, port: endpoints.destination.port() })
        }
        IpAddr::V6(_) => None,
    }
}
