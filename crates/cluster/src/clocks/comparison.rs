//! Differences between gateways' clocks, by the timestamps of datagrams that both received.

use std::collections::BTreeMap;

use crate::gateway_report::GatewayReport;
use service::live::ClockDifference;

/// Difference above which two clocks disagree, in seconds.
const APART_ABOVE_S: f64 = 0.020;
/// Difference below which two clocks agree again, in seconds.
const TOGETHER_BELOW_S: f64 = 0.015;
/// Number of consecutive checks, one each second, needed for a change.
const CHECKS: u32 = 3;
/// Number of checks with too few common datagrams after which a pair is forgotten.
const FORGOTTEN_CHECKS: u32 = 10;
/// Minimum number of common datagrams.
const MIN_DATAGRAMS: usize = 5;

/// Compares the gateways' clocks each second, with hysteresis over consecutive checks.
#[derive(Debug, Default)]
pub struct ClockComparison(BTreeMap<(String, String), ClockPair>);

#[derive(Debug, Default)]
struct ClockPair {
    difference_s: f64,
    datagrams: u64,
    is_apart: bool,
    /// Number of consecutive checks that contradict `is_apart`.
    contradictions: u32,
    /// Number of consecutive checks without a result.
    nothing: u32,
}

impl ClockComparison {
    /// Compares the reports once. Returns the known state of each pair.
    pub fn update(&mut self, reports: &[GatewayReport]) -> Vec<ClockDifference> {
        self.0.values_mut().for_each(|pair| pair.nothing += 1);
        for ClockDifference { gateway, other, difference_s, datagrams, .. } in differences(reports) {
            let pair = self.0.entry((gateway, other)).or_default();
            let is_contradiction = match pair.is_apart {
                false => difference_s.abs() > APART_ABOVE_S,
                true => difference_s.abs() < TOGETHER_BELOW_S,
            };
            pair.contradictions = if is_contradiction { pair.contradictions + 1 } else { 0 };
            if pair.contradictions >= CHECKS {
                (pair.is_apart, pair.contradictions) = (!pair.is_apart, 0);
            }
            (pair.difference_s, pair.datagrams, pair.nothing) = (difference_s, datagrams, 0);
        }
        self.0.retain(|_, pair| pair.nothing < FORGOTTEN_CHECKS);
        let known = self.0.iter().map(|((gateway, other), pair)| ClockDifference {
            gateway: gateway.clone(),
            other: other.clone(),
            difference_s: pair.difference_s,
            datagrams: pair.datagrams,
            apart: pair.is_apart,
        });
        known.collect()
    }
}

/// Median difference of each pair of gateways with enough common datagrams, in these reports.
pub fn differences(reports: &[GatewayReport]) -> Vec<ClockDifference> {
    let mut stamps: Vec<_> =
        reports.iter().map(|report| (&report.node, unique_stamps(&report.recent_datagrams))).collect();
    stamps.sort_by_key(|(node, _)| *node);
    let mut found = Vec::new();
    for (place, (gateway, own)) in stamps.iter().enumerate() {
        for (other, theirs) in &stamps[place + 1..] {
            let later = |(hash, stamp): (&u64, &i64)| Some(stamp.saturating_sub(*theirs.get(hash)?));
            let mut later_ns: Vec<i64> = own.iter().filter_map(later).collect();
            if later_ns.len() < MIN_DATAGRAMS {
                continue;
            }
            later_ns.sort_unstable();
            let difference_s = later_ns[later_ns.len() / 2] as f64 * 1e-9;
            found.push(ClockDifference {
                gateway: (*gateway).clone(),
                other: (*other).clone(),
                difference_s,
                datagrams: later_ns.len() as u64,
                apart: difference_s.abs() > APART_ABOVE_S,
            });
        }
    }
    found
}

/// Timestamps by hash, of hashes that occur once. Copies of a datagram are indistinguishable.
fn unique_stamps(stamps: &[(u64, i64)]) -> BTreeMap<u64, i64> {
    let mut known = BTreeMap::<u64, Option<i64>>::new();
    for (hash, stamp) in stamps {
        known.entry(*hash).and_modify(|stamp| *stamp = None).or_insert(Some(*stamp));
    }
    known.into_iter().filter_map(|(hash, stamp)| Some((hash, stamp?))).collect()
}
