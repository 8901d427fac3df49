//! `replay`: earlier reports are repeated, octet by octet, with a constant time difference.

use jiff::SignedDuration;
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

use super::history::TimedReport;
use super::places::{EarlierReport, ReportPlaces};
use crate::time::Time;

/// Time for which positions are remembered.
pub(super) const REMEMBERED: SignedDuration = SignedDuration::from_mins(30);
/// Minimum time difference of a replay. A shorter one may be one report on two paths, which differ by a few seconds. At
/// another receiver of the same identity, whose clock may be wrong, the minimum is longer.
const LAG_MIN: SignedDuration = SignedDuration::from_secs(5);
const LAG_MIN_RECEIVERS: SignedDuration = SignedDuration::from_secs(10);
/// Tolerance of the constant time difference.
const LAG_SPREAD: SignedDuration = SignedDuration::from_millis(500);
/// Minimum number of repeated positions, and minimum distance between them, metres. A smoothed position that wanders by
/// some centimetres in hover repeats its own positions (observed with a real autopilot within half a minute).
const PLACES: usize = 5;
const APART_M: f64 = 0.3;
/// Minimum number of repeated positions for each new one: not all of the earlier reports were received.
const HITS_PER_MISS: u32 = 4;
/// Minimum log-likelihood ratio of a replay to a receiver with a coarse grid of positions.
const EVIDENCE: f64 = 10.0;
/// Prior number of new positions.
const NEW_BEFORE: f64 = 10.0;
/// Maximum number of candidates that are followed at a time.
const CHAINS_MAX: usize = 4;

/// Positions of a stream that were reported before.
#[derive(Debug, Default, Serialize, Deserialize)]
pub(super) struct Replay {
    chains: Vec<ReplayChain>,
    /// Number of positions that differed from the previous one.
    places: u32,
    /// Number of these that were reported before, at no followed time difference: many with a coarse grid.
    strays: u32,
    /// Position of the previous report.
    place: Option<[u64; 3]>,
}

/// Reports that were repeated with one time difference.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
struct ReplayChain {
    source: u32,
    lag: SignedDuration,
    hits: u32,
    misses: u32,
    last: Time,
    /// The first different positions, metres.
    places: [Vector3<f64>; PLACES],
    different: usize,
}

impl Replay {
    /// Adds a report of the stream `own` and its position; `kin` are the streams of its identity.
    pub(super) fn add_report(
        &mut self,
        heard: TimedReport,
        own: u32,
        places: &mut ReportPlaces,
        kin: SiblingStreams,
    ) {
        let (place, time) = (heard.place(), heard.time);
        if self.place.replace(place) == Some(place) {
            return;
        }
        self.places = self.places.saturating_add(1);
        let oldest = time - REMEMBERED;
        let mut is_known = false;
        let mut first: Option<EarlierReport> = None;
        let mut is_hit = [false; CHAINS_MAX];
        for seen in places.reports_at(place) {
            let lag = time - seen.time;
            let lag_min = if kin.is_other_receiver(seen.stream, own) { LAG_MIN_RECEIVERS } else { LAG_MIN };
            if lag <= lag_min || seen.time < oldest {
                continue;
            }
            let matches =
                |chain: &ReplayChain| chain.source == seen.stream && (chain.lag - lag).abs() <= LAG_SPREAD;
            match self.chains.iter().position(matches) {
                Some(at) => {
                    is_known = true;
                    if !std::mem::replace(&mut is_hit[at], true) {
                        self.chains[at].extend(heard);
                    }
                }
                None => first = first.or(Some(seen)),
            }
        }
        for (chain, is_hit) in self.chains.iter_mut().zip(is_hit) {
            chain.misses += u32::from(!is_hit);
        }
        self.chains.retain(|chain| chain.misses <= 1 + chain.hits / HITS_PER_MISS);
        if let (false, Some(seen)) = (is_known, first) {
            self.strays = self.strays.saturating_add(1);
            self.begin(ReplayChain::new(seen, heard));
        }
        places.insert(place, own, time);
    }

    fn begin(&mut self, chain: ReplayChain) {
        if self.chains.len() == CHAINS_MAX {
            let least = self.chains.iter().enumerate().min_by_key(|(_, chain)| (chain.hits, chain.last));
            if let Some((at, _)) = least {
                self.chains.remove(at);
            }
        }
        self.chains.push(chain);
    }

    /// Whether the stream is a replay up to the newest report.
    pub(super) fn is_active(&self) -> bool {
        self.chains.iter().any(|chain| chain.different == PLACES && chain.evidence(self) >= EVIDENCE)
    }
}

impl ReplayChain {
    fn new(seen: EarlierReport, heard: TimedReport) -> Self {
        let lag = heard.time - seen.time;
        let mut chain = Self {
            source: seen.stream,
            lag,
            hits: 0,
            misses: 0,
            last: heard.time,
            places: [Vector3::zeros(); PLACES],
            different: 0,
        };
        chain.extend(heard);
        chain
    }

    /// Log-likelihood ratio of a replay to a receiver whose positions repeat by chance as often as in this stream.
    fn evidence(&self, replay: &Replay) -> f64 {
        let chance = f64::from(replay.strays + 1) / (f64::from(replay.places) + NEW_BEFORE);
        -chance.min(1.0).ln() * f64::from(self.hits)
    }

    fn extend(&mut self, heard: TimedReport) {
        self.hits += 1;
        self.last = self.last.max(heard.time);
        let is_apart = |place: &Vector3<f64>| (place - heard.position).norm() >= APART_M;
        if self.different < PLACES && self.places[..self.different].iter().all(is_apart) {
            self.places[self.different] = heard.position;
            self.different += 1;
        }
    }
}

/// Numbers of the streams of one identity.
#[derive(Clone, Copy, Debug)]
pub(super) struct SiblingStreams<'a>(pub(super) &'a [u32]);

impl SiblingStreams<'_> {
    fn is_other_receiver(self, stream: u32, own: u32) -> bool {
        stream != own && self.0.contains(&stream)
    }
}
