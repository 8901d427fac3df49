//! The sensors that a configuration for the capture would list.

use std::collections::BTreeSet;
use std::net::IpAddr;

use super::report::{EditionReport, LineHint, SensorHint, SourceReport};
use crate::capture::Endpoints;

/// A source with less than one part in this of the records of the busiest source is a stray.
const STRAY: u64 = 20;

/// Radars and receivers of transponders and of ADS-B among the sources, and one receiver if there is Remote ID. Remote ID has no
/// SAC and SIC, so this sensor gets a SIC that is not in use.
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

/// The median as a period for the configuration, at most an hour, rounded to two decimals.
fn period_s(median_s: f64) -> Option<f64> {
    let rounded = (median_s * 100.0).round() / 100.0;
    (rounded > 0.0 && rounded <= 3600.0).then_some(rounded)
}

/// The value of the key `classification`, from the items that most records have.
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

/// An input for these endpoints; the configuration supports IPv4 only.
fn input(endpoints: &Endpoints) -> Option<LineHint> {
    match endpoints.destination.ip() {
        IpAddr::V4(address) => {
            Some(LineHint { multicast: address.is_multicast(), address, port: endpoints.destination.port() })
        }
        IpAddr::V6(_) => None,
    }
}
