//! `replay`: earlier reports come again, octet by octet, at one constant time difference.

use jiff::SignedDuration;
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

use super::history::Heard;
use super::places::{Places, Seen};
use crate::time::Time;

/// How far back places are remembered.
pub(super) const REMEMBERED: SignedDuration = SignedDuration::from_mins(30);
/// What comes again sooner may be one report over two ways, which differ by a few seconds; at another receiver of the same
/// identity, whose clock may be wrong by as much as is accepted at all.
const LAG_MIN: SignedDuration = SignedDuration::from_secs(5);
const LAG_MIN_RECEIVERS: SignedDuration = SignedDuration::from_secs(10);
/// The time difference is constant within this.
const LAG_SPREAD: SignedDuration = SignedDuration::from_millis(500);
/// Places that must have come again, all of them so far apart, metres: a smoothed position that wanders by some centimetres in
/// hover comes back on its own way (seen of a real autopilot within half a minute).
const PLACES: usize = 5;
const APART_M: f64 = 0.3;
/// Of the reports meanwhile so many may be new for one that is known: the earlier ones were not all received.
const HITS_PER_MISS: u32 = 4;
/// Logarithm of how much likelier a replay must be than a receiver with a coarse grid.
const EVIDENCE: f64 = 10.0;
/// As if so many places had been new before the first.
const NEW_BEFORE: f64 = 10.0;
/// Candidates that are followed at a time.
const CHAINS_MAX: usize = 4;

/// What of a stream has come before.
#[derive(Debug, Default, Serialize, Deserialize)]
pub(super) struct Replay {
    chains: Vec<Chain>,
    /// Places that differed from the one before.
    places: u32,
    /// Those of them that had come before at no known time difference: a coarse grid has many.
    strays: u32,
    /// The place of the report before.
    place: Option<[u64; 3]>,
}

/// Reports that have come again at one time difference.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
struct Chain {
    source: u32,
    lag: SignedDuration,
    hits: u32,
    misses: u32,
    last: Time,
    /// The first different places, metres.
    places: [Vector3<f64>; PLACES],
    different: usize,
}

impl Replay {
    /// Takes a report of the stream `own`, and keeps its place; `kin` are the streams of its identity.
    pub(super) fn hear(&mut self, heard: Heard, own: u32, places: &mut Places, kin: Kin) {
        let (place, time) = (heard.place(), heard.time);
        if self.place.replace(place) == Some(place) {
            return;
        }
        self.places = self.places.saturating_add(1);
        let oldest = time - REMEMBERED;
        let mut is_known = false;
        let mut first: Option<Seen> = None;
        let mut is_hit = [false; CHAINS_MAX];
        for seen in places.seen(place) {
            let lag = time - seen.time;
            let lag_min = if kin.is_other_receiver(seen.stream, own) { LAG_MIN_RECEIVERS } else { LAG_MIN };
            if lag <= lag_min || seen.time < oldest {
                continue;
            }
            let matches =
                |chain: &Chain| chain.source == seen.stream && (chain.lag - lag).abs() <= LAG_SPREAD;
            match self.chains.iter().position(matches) {
                Some(at) => {
                    is_known = true;
                    if !std::mem::replace(&mut is_hit[at], true) {
                        self.chains[at].hit(heard);
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
            self.begin(Chain::new(seen, heard));
        }
        places.insert(place, own, time);
    }

    fn begin(&mut self, chain: Chain) {
        if self.chains.len() == CHAINS_MAX {
            let least = self.chains.iter().enumerate().min_by_key(|(_, chain)| (chain.hits, chain.last));
            if let Some((at, _)) = least {
                self.chains.remove(at);
            }
        }
        self.chains.push(chain);
    }

    /// Whether it is one up to the newest report.
    pub(super) fn holds(&self) -> bool {
        self.chains.iter().any(|chain| chain.different == PLACES && chain.evidence(self) >= EVIDENCE)
    }
}

impl Chain {
    fn new(seen: Seen, heard: Heard) -> Self {
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
        chain.hit(heard);
        chain
    }

    /// Logarithm of how much likelier it is than a receiver of whose places as many come again by chance as of this one.
    fn evidence(&self, replay: &Replay) -> f64 {
        let chance = f64::from(replay.strays + 1) / (f64::from(replay.places) + NEW_BEFORE);
        -chance.min(1.0).ln() * f64::from(self.hits)
    }

    fn hit(&mut self, heard: Heard) {
        self.hits += 1;
        self.last = self.last.max(heard.time);
        let is_apart = |place: &Vector3<f64>| (place - heard.position).norm() >= APART_M;
        if self.different < PLACES && self.places[..self.different].iter().all(is_apart) {
            self.places[self.different] = heard.position;
            self.different += 1;
        }
    }
}

/// The streams of one identity, by their numbers.
#[derive(Clone, Copy, Debug)]
pub(super) struct Kin<'a>(pub(super) &'a [u32]);

impl Kin<'_> {
    fn is_other_receiver(self, stream: u32, own: u32) -> bool {
        stream != own && self.0.contains(&stream)
    }
}
