//! Aircraft that are marked as flying without a transponder.

use std::collections::BTreeMap;

use serde::Serialize;

use super::attacks::Attack;
use crate::evaluate::judged::Judged;
use crate::evaluate::labels::Labels;
use crate::evaluate::truth::Truth;
use crate::evaluate::types::{OutputPoint, PointSource};

/// An aircraft counts that is published by radar alone for so long, seconds: by then it should be marked.
const PUBLISHED_S: f64 = 20.0;

/// How often drones without a transponder are marked, and others.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Uncooperative {
    /// Aircraft (a number and whose it is) of drones without a transponder, published by radar alone for 20 s.
    pub aircraft: usize,
    /// Those among them that are marked by then.
    pub marked: usize,
    /// Marks that are put on drones with a transponder that does not lie. The aircraft keeps its mark wherever its number goes
    /// from there; that a number goes to another drone is counted as such elsewhere.
    pub false_marks: usize,
    /// Hours of these drones.
    pub equipped_h: f64,
    /// Marks that are put on drones whose transponder lies: one flies there, and no transponder says so.
    pub marked_liars: usize,
}

impl Uncooperative {
    /// `points`: those of the output that count, of all drones.
    pub(super) fn of(
        points: &[Judged<'_>],
        attacks: &[Attack],
        truth: &Truth,
        labels: &Labels,
        slot_s: f64,
    ) -> Self {
        let equipped = labels.equipped();
        let is_equipped: Vec<bool> =
            truth.tracks().iter().map(|track| equipped.contains(track.id())).collect();
        let lies = |drone: usize| {
            let id = truth.tracks()[drone].id();
            attacks.iter().filter(move |attack| attack.kind.is_lie() && attack.id == id)
        };
        let mut by_radar: Vec<&Judged<'_>> =
            points.iter().filter(|judged| judged.point.source == PointSource::Radar).collect();
        by_radar.sort_by_key(|judged| judged.slot); // stable
        let mut found = Self::default();
        // Whether each slot of an aircraft is marked, in order, and whether an aircraft was in its latest slot.
        let mut aircraft: BTreeMap<(usize, u32), BTreeMap<_, bool>> = BTreeMap::new();
        let mut was_marked: BTreeMap<u32, bool> = BTreeMap::new();
        for judged in by_radar {
            let OutputPoint { number, time, flags, .. } = *judged.point;
            let is_new = flags.is_uncooperative && !was_marked.get(&number).copied().unwrap_or_default();
            was_marked.insert(number, flags.is_uncooperative);
            let Some(drone) = judged.drone else { continue };
            if is_equipped[drone] {
                let is_liar = lies(drone).any(|lie| (lie.from..=lie.until).contains(&time));
                found.marked_liars += usize::from(is_new && is_liar);
                found.false_marks += usize::from(is_new && !is_liar);
            } else {
                let marks = aircraft.entry((drone, number)).or_default();
                *marks.entry(judged.slot).or_default() |= flags.is_uncooperative;
            }
        }
        let enough = (PUBLISHED_S / slot_s).ceil() as usize;
        for marks in aircraft.values().filter(|marks| marks.len() >= enough) {
            found.aircraft += 1;
            found.marked += usize::from(marks.values().take(enough).any(|&is_marked| is_marked));
        }
        for (drone, track) in truth.tracks().iter().enumerate().filter(|&(drone, _)| is_equipped[drone]) {
            let (first, last) = track.span();
            let lying_s = |lie: &Attack| lie.until.min(last).seconds_since(lie.from.max(first)).max(0.0);
            let lied_s: f64 = lies(drone).map(lying_s).sum();
            found.equipped_h += (last.seconds_since(first) - lied_s) / 3600.0;
        }
        found
    }
}
