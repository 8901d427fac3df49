//! How far apart the clocks of gateways are, by when both heard the same datagrams.

use std::collections::BTreeMap;

use crate::cluster::gateway::GatewayReport;
use crate::live::ClockDifference;

/// Clocks are apart from this difference on, seconds.
const APART_S: f64 = 0.020;
/// And no longer below this one, seconds.
const TOGETHER_S: f64 = 0.015;
/// In so many looks in a row, of one a second.
const LOOKS: u32 = 3;
/// Nothing is known of a pair after so many looks in which both had heard too little alike.
const FORGOTTEN: u32 = 10;
/// Fewer datagrams than this say nothing.
const LEAST: usize = 5;

/// Whoever looks at the gateways each second: what is apart has been so in some looks in a row, and so has what no longer is.
#[derive(Debug, Default)]
pub struct Comparison(BTreeMap<(String, String), Pair>);

#[derive(Debug, Default)]
struct Pair {
    difference_s: f64,
    datagrams: u64,
    is_apart: bool,
    /// Looks in a row that speak against that.
    otherwise: u32,
    /// Looks in a row that say nothing.
    nothing: u32,
}

impl Comparison {
    /// Looks once; what is known of each pair.
    pub fn look(&mut self, reports: &[GatewayReport]) -> Vec<ClockDifference> {
        self.0.values_mut().for_each(|pair| pair.nothing += 1);
        for ClockDifference { gateway, other, difference_s, datagrams, .. } in differences(reports) {
            let pair = self.0.entry((gateway, other)).or_default();
            let is_otherwise = match pair.is_apart {
                false => difference_s.abs() > APART_S,
                true => difference_s.abs() < TOGETHER_S,
            };
            pair.otherwise = if is_otherwise { pair.otherwise + 1 } else { 0 };
            if pair.otherwise >= LOOKS {
                (pair.is_apart, pair.otherwise) = (!pair.is_apart, 0);
            }
            (pair.difference_s, pair.datagrams, pair.nothing) = (difference_s, datagrams, 0);
        }
        self.0.retain(|_, pair| pair.nothing < FORGOTTEN);
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

/// The median difference of each two gateways that heard enough alike, by one look.
pub fn differences(reports: &[GatewayReport]) -> Vec<ClockDifference> {
    let mut heard: Vec<_> = reports.iter().map(|report| (&report.node, once(&report.heard))).collect();
    heard.sort_by_key(|(node, _)| *node);
    let mut found = Vec::new();
    for (place, (gateway, own)) in heard.iter().enumerate() {
        for (other, theirs) in &heard[place + 1..] {
            let later = |(hash, stamp): (&u64, &i64)| Some(stamp.saturating_sub(*theirs.get(hash)?));
            let mut later_ns: Vec<i64> = own.iter().filter_map(later).collect();
            if later_ns.len() < LEAST {
                continue;
            }
            later_ns.sort_unstable();
            let difference_s = later_ns[later_ns.len() / 2] as f64 * 1e-9;
            found.push(ClockDifference {
                gateway: (*gateway).clone(),
                other: (*other).clone(),
                difference_s,
                datagrams: later_ns.len() as u64,
                apart: difference_s.abs() > APART_S,
            });
        }
    }
    found
}

/// By hash, what is there once: of what came again nobody knows which is which.
fn once(heard: &[(u64, i64)]) -> BTreeMap<u64, i64> {
    let mut known = BTreeMap::<u64, Option<i64>>::new();
    for (hash, stamp) in heard {
        known.entry(*hash).and_modify(|stamp| *stamp = None).or_insert(Some(*stamp));
    }
    known.into_iter().filter_map(|(hash, stamp)| Some((hash, stamp?))).collect()
}
