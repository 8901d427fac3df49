//! The sensors that a configuration for the capture would list.

use std::collections::BTreeSet;
use std::net::IpAddr;

use super::report::{EditionReport, LineHint, SensorHint, SourceReport};
use crate::capture::Endpoints;

/// A sensor sends at least a twentieth of the busiest one's records; others are strays.
const STRAY: u64 = 20;

/// Radars, receivers of transponders and of ADS-B among the sources, and one receiver where Remote ID was heard: Remote ID itself
/// has no SAC and SIC, so the sensor gets a SIC that no other one has.
pub(super) fn sensors(
    sources: &[SourceReport],
    editions: &[EditionReport],
    has_remote_id: bool,
) -> Vec<SensorHint> {
    let busiest = |category: u8| {
        let records = sources.iter().filter(|other| other.category == category).map(|other| other.records);
        records.max().unwrap_or(0)
    };
    let hint = |source: &SourceReport| {
        let kind = match source.category {
            21 => "adsb",
            48 => "radar",
            129 => "transponder",
            _ => return None,
        };
        let is_stray = source.records.saturating_mul(STRAY) < busiest(source.category);
        let (sac, sic) = source.sac.zip(source.sic).filter(|_| !is_stray)?;
        let inputs: BTreeSet<_> = source.lines.iter().filter_map(input).collect();
        let period = source.interval.filter(|interval| kind != "adsb" && interval.of != "record");
        let edition = editions.iter().find(|edition| (edition.sac, edition.sic) == (Some(sac), Some(sic)));
        Some(SensorHint {
            kind,
            sac,
            sic,
            period_s: period.and_then(|interval| period_s(interval.median_s)),
            classification: (kind == "radar").then(|| classification(source)),
            edition: edition.filter(|_| kind == "adsb").and_then(|edition| edition.edition),
            inputs: inputs.into_iter().collect(),
        })
    };
    let mut sensors: Vec<SensorHint> = sources.iter().filter_map(hint).collect();
    if has_remote_id {
        let sac = sensors.first().map_or(0, |sensor| sensor.sac);
        let is_free =
            |&sic: &u8| !sources.iter().any(|other| (other.sac, other.sic) == (Some(sac), Some(sic)));
        sensors.push(SensorHint {
            kind: "remote-id",
            sac,
            sic: (1..u8::MAX).rev().find(is_free).unwrap_or(u8::MAX),
            period_s: None,
            classification: None,
            edition: None,
            inputs: Vec::new(),
        });
    }
    sensors
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
