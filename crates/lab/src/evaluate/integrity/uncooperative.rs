//! Aircraft that are marked as flying without a transponder.

use std::collections::BTreeMap;

use serde::Serialize;

use super::attacks::Attack;
use crate::evaluate::labels::Labels;
use crate::evaluate::scored_point::ScoredPoint;
use crate::evaluate::truth::Truth;
use crate::evaluate::types::{OutputPoint, PointSource};

/// Time for which a drone is published by radar alone before it should be marked, seconds.
const PUBLISHED_S: f64 = 20.0;

/// Marks on drones with and without a transponder.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct UncooperativeScore {
    /// Number of aircraft (pairs of track number and drone) without a transponder that are published by radar alone for
    /// 20 s.
    pub aircraft: usize,
    /// Number of these aircraft that are marked by then.
    pub marked: usize,
    /// Number of marks put on drones with a transponder that reports correctly. A mark stays with its track number;
    /// changes of the number to another drone are scored elsewhere.
    pub false_marks: usize,
    /// Flight time of these drones, hours.
    pub equipped_h: f64,
    /// Number of marks put on drones whose transponder sends false reports: these marks are correct, since no
    /// transponder reports that position.
    pub marked_liars: usize,
}

impl UncooperativeScore {
    /// Scores `points`, the counted points of the output, of all drones.
    pub(super) fn of(
        points: &[ScoredPoint<'_>],
        attacks: &[Attack],
        truth: &Truth,
        labels: &Labels,
        slot_s: f64,
    ) -> Self {
        let equipped = labels.equipped();
        let is_equipped: Vec<bool> =
            truth.tracks().iter().map(|track| equipped.contains(track.id())).collect();
        let attack_begins = |drone: usize| {
            let id = truth.tracks()[drone].id();
            attacks.iter().filter(move |attack| attack.kind.is_attack() && attack.id == id)
        };
        let mut by_radar: Vec<&ScoredPoint<'_>> =
            points.iter().filter(|scored_point| scored_point.point.source == PointSource::Radar).collect();
        by_radar.sort_by_key(|scored_point| scored_point.slot); // stable
        let mut found = Self::default();
        // For each aircraft, whether each of its slots is marked, in order; for each number, whether its latest slot
        // was marked.
        let mut aircraft: BTreeMap<(usize, u32), BTreeMap<_, bool>> = BTreeMap::new();
        let mut was_marked: BTreeMap<u32, bool> = BTreeMap::new();
        for scored_point in by_radar {
            let OutputPoint { number, time, flags, .. } = *scored_point.point;
            let is_new = flags.is_uncooperative && !was_marked.get(&number).copied().unwrap_or_default();
            was_marked.insert(number, flags.is_uncooperative);
            let Some(drone) = scored_point.drone else { continue };
            if is_equipped[drone] {
                let is_attacked =
                    attack_begins(drone).any(|attack| (attack.from..=attack.until).contains(&time));
                found.marked_liars += usize::from(is_new && is_attacked);
                found.false_marks += usize::from(is_new && !is_attacked);
            } else {
                let marks = aircraft.entry((drone, number)).or_default();
                *marks.entry(scored_point.slot).or_default() |= flags.is_uncooperative;
            }
        }
        let enough = (PUBLISHED_S / slot_s).ceil() as usize;
        for marks in aircraft.values().filter(|marks| marks.len() >= enough) {
            found.aircraft += 1;
            found.marked += usize::from(marks.values().take(enough).any(|&is_marked| is_marked));
        }
        for (drone, track) in truth.tracks().iter().enumerate().filter(|&(drone, _)| is_equipped[drone]) {
            let (first, last) = track.span();
            let attacked_s =
                |attack: &Attack| attack.until.min(last).seconds_since(attack.from.max(first)).max(0.0);
            let total_attacked_s: f64 = attack_begins(drone).map(attacked_s).sum();
            found.equipped_h += (last.seconds_since(first) - total_attacked_s) / 3600.0;
        }
        found
    }
}
