//! Aircraft that are marked as flying without a transponder.

use std::collections::BTreeMap;

use serde::Serialize;

use crate::evaluate::judged::Judged;
use crate::evaluate::labels::Labels;
use crate::evaluate::truth::Truth;
use crate::evaluate::types::PointSource;

/// An aircraft counts that is published by radar alone for so long, seconds: by then it should be marked.
const PUBLISHED_S: f64 = 20.0;

/// How often drones without a transponder are marked, and others.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Uncooperative {
    /// Aircraft (a number and whose it is) of drones without a transponder, published by radar alone for 20 s.
    pub aircraft: usize,
    /// Those among them that are marked by then.
    pub marked: usize,
    /// Aircraft of drones with a transponder that are marked.
    pub false_marks: usize,
    /// Hours of these drones.
    pub equipped_h: f64,
}

impl Uncooperative {
    /// `points`: those of the output that count, of all drones.
    pub(super) fn of(points: &[Judged<'_>], truth: &Truth, labels: &Labels, slot_s: f64) -> Self {
        let equipped = labels.equipped();
        let is_equipped: Vec<bool> =
            truth.tracks().iter().map(|track| equipped.contains(track.id())).collect();
        // Whether each slot of an aircraft is marked, in order.
        let mut aircraft: BTreeMap<(usize, u32), BTreeMap<_, bool>> = BTreeMap::new();
        for judged in points.iter().filter(|judged| judged.point.source == PointSource::Radar) {
            if let Some(drone) = judged.drone {
                let marks = aircraft.entry((drone, judged.point.number)).or_default();
                *marks.entry(judged.slot).or_default() |= judged.point.flags.is_uncooperative;
            }
        }
        let enough = (PUBLISHED_S / slot_s).ceil() as usize;
        let mut found = Self::default();
        for ((drone, _), marks) in &aircraft {
            if is_equipped[*drone] {
                found.false_marks += usize::from(marks.values().any(|&is_marked| is_marked));
            } else if marks.len() >= enough {
                found.aircraft += 1;
                found.marked += usize::from(marks.values().take(enough).any(|&is_marked| is_marked));
            }
        }
        let hours =
            |track: &crate::evaluate::TrueTrack| track.span().1.seconds_since(track.span().0) / 3600.0;
        let of_equipped = truth.tracks().iter().zip(&is_equipped).filter(|(_, is_equipped)| **is_equipped);
        found.equipped_h = of_equipped.map(|(track, _)| hours(track)).sum();
        found
    }
}
