//! Errors of a replay without any record of a configured sensor.

use std::collections::BTreeMap;

use super::table::grouped;
use input::pipeline::Tally;
use site::config::Config;

/// Maximum number of sources that are named; a network may have hundreds.
const NAMED: usize = 8;

/// Error if there were records, but none from a configured sensor, as with the configuration of another site. `site` and `input`
/// are file names.
pub fn unmatched(tally: &Tally, config: &Config, site: &str, input: &str) -> Option<String> {
    let unknown: u64 = tally.unknown_sources.values().sum();
    if unknown == 0 || is_matched(tally) {
        return None;
    }
    // Busiest sources first.
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

/// Error if there was no record at all. `frames` describes the frames without a datagram, if any; `input` is the file name.
pub fn nothing(tally: &Tally, frames: &str, input: &str) -> Option<String> {
    let unknown: u64 = tally.unknown_sources.values().sum();
    if unknown > 0 || is_matched(tally) {
        return None;
    }
    let advice = format!("`utm-fusion info {input}` shows what the input holds");
    let mut reasons: Vec<String> = Vec::new();
    let faults: u64 = tally.faults.values().sum();
    if faults > 0 {
        let kinds = tally.faults.iter().map(|((category, reason), count)| {
            let category = category.map_or_else(String::new, |category| format!("CAT{category:03} "));
            format!("{category}{reason} {}", grouped(*count))
        });
        let kinds = kinds.take(NAMED).collect::<Vec<_>>().join(", ");
        reasons.push(format!("{} blocks, records or messages cannot be read ({kinds})", grouped(faults)));
    }
    let skipped: u64 = tally.skipped.values().sum();
    if skipped > 0 {
        let categories = tally.skipped.keys().take(NAMED).map(|category| format!("CAT{category:03}"));
        let categories = categories.collect::<Vec<_>>().join(", ");
        reasons
            .push(format!("{} blocks are of categories that are not used ({categories})", grouped(skipped)));
    }
    let refused = tally.refused.iter().map(|((_, reason), count)| format!("{} {reason}", grouped(*count)));
    let refused = refused.collect::<Vec<_>>();
    if !refused.is_empty() {
        reasons.push(format!("records were refused ({})", refused.join(", ")));
    }
    if !frames.is_empty() {
        reasons.push(format!("frames hold no UDP datagram or message ({frames})"));
    }
    if reasons.is_empty() {
        reasons.push(match tally.received {
            0 => "it holds nothing; did the recording start?".to_owned(),
            received => format!("its {} datagrams hold no record", grouped(received)),
        });
    }
    Some(format!("{input}: no record could be used, so there is no output: {}; {advice}", reasons.join("; ")))
}

/// Whether there was a record of a configured sensor.
fn is_matched(tally: &Tally) -> bool {
    let of_sensors = [&tally.accepted, &tally.elsewhere, &tally.shed, &tally.service];
    of_sensors.iter().any(|counts| !counts.is_empty())
        || tally.refused.keys().any(|(sensor, _)| sensor.is_some())
}
