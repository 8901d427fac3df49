//! A replay without any record from a configured sensor.

use std::collections::BTreeMap;

use super::table::grouped;
use crate::config::Config;
use crate::pipeline::Tally;

/// Most sources that are named; a network may have hundreds.
const NAMED: usize = 8;

/// The error message where there were records, but none from a configured sensor: another site's configuration.
/// `site` and `input` are the names of their files.
pub fn unmatched(tally: &Tally, config: &Config, site: &str, input: &str) -> Option<String> {
    let unknown: u64 = tally.unknown_sources.values().sum();
    let is_matched = !tally.accepted.is_empty()
        || !tally.service.is_empty()
        || tally.refused.keys().any(|(sensor, _)| sensor.is_some());
    if unknown == 0 || is_matched {
        return None;
    }
    // The busiest first.
    let mut sources: Vec<_> = tally.unknown_sources.iter().collect();
    sources.sort_by_key(|(_, count)| std::cmp::Reverse(**count));
    let mut seen: Vec<String> = sources
        .iter()
        .take(NAMED)
        .map(|((category, source), _)| format!("CAT{category:03} {}/{}", source.sac, source.sic))
        .collect();
    if sources.len() > NAMED {
        seen.push(format!("{} more", sources.len() - NAMED));
    }
    let mut configured: BTreeMap<&str, Vec<String>> = BTreeMap::new();
    for sensor in &config.sensors {
        configured.entry(sensor.kind.language()).or_default().push(format!("{}/{}", sensor.sac, sensor.sic));
    }
    let configured: Vec<String> =
        configured.iter().map(|(category, codes)| format!("{category} {}", codes.join(", "))).collect();
    Some(format!(
        "none of the {} records is from a sensor of {site}, so there is no output. By SAC/SIC the input has {}; \
         {site} has {}. Correct sac and sic there, or have a configuration written for this input: \
         utm-fusion info {input} --config-out FILE",
        grouped(unknown),
        seen.join(", "),
        configured.join(", ")
    ))
}
