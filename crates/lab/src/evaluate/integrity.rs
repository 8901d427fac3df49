//! Scores the detection of false transponder reports: `evaluate --integrity`.

mod attacks;
mod clean;
mod course;
mod detection;
mod flags;
mod jamming;
mod shown;
mod transponders;
mod uncooperative;

use std::collections::BTreeMap;

use serde::Serialize;

pub use attacks::{Attack, AttackKind};
pub use clean::{FalseFlag, FalseFlagScore};
pub use detection::AttackDetection;
pub use jamming::{AlertLine, JammingScore};
pub use shown::FlaggedCoverage;
pub use uncooperative::UncooperativeScore;

use super::counted_slots::CountedSlots;
use super::labels::Labels;
use super::point_owner::PointKind;
use super::scored_point::{ScoringReference, score_points};
use super::truth::Truth;
use super::types::{OutputPoint, Scoring};
use course::AttackCourse;
use transponders::{StreamTransponders, TransponderKey};

/// Inputs for scoring a flight's flags.
#[derive(Clone, Copy, Debug)]
pub struct IntegrityFlight<'a> {
    /// True paths of the drones.
    pub truth: &'a Truth,
    /// The drone behind each plot and each report.
    pub labels: &'a Labels,
    /// Every accepted transponder report, at its own time, under its number.
    pub reports: &'a [OutputPoint],
    /// Attacks on transponders.
    pub attacks: &'a [Attack],
    /// The output.
    pub output: &'a [OutputPoint],
    /// Alerts of the output, if known.
    pub alerts: Option<&'a [AlertLine]>,
    /// Slot grid and latency.
    pub settings: &'a Scoring,
}

/// Score of the flags.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct IntegrityScore {
    /// Each attack, in the given order.
    pub attacks: Vec<AttackDetection>,
    /// Flags without an attack.
    pub clean: FalseFlagScore,
    /// Marks of drones that fly without a transponder.
    pub uncooperative: UncooperativeScore,
    /// The alert `jamming`; `None` if alerts are not known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub jamming: Option<JammingScore>,
}

/// Scores the flags of an output.
pub fn integrity(flight: &IntegrityFlight<'_>) -> IntegrityScore {
    let IntegrityFlight { truth, labels, attacks, output, settings, .. } = *flight;
    let mut reports: BTreeMap<TransponderKey<'_>, Vec<&OutputPoint>> = BTreeMap::new();
    for report in flight.reports {
        if let Some(transponder) = TransponderKey::of(report) {
            reports.entry(transponder).or_default().push(report);
        }
    }
    reports.values_mut().for_each(|reports| reports.sort_by_key(|report| report.time)); // stable
    let flagged = flags::by_transponder(output, settings);
    let (reporting, published) = (StreamTransponders::of(flight.reports), StreamTransponders::of(output));
    let counted = CountedSlots::new(truth, settings.grid);
    let reference = ScoringReference { truth, labels: Some(labels), counted: &counted, grid: settings.grid };
    let points = score_points(output, PointKind::Output, reference);
    let detection = |attack: &Attack| {
        let index = truth.index_of(&attack.id)?;
        let drone = &truth.tracks()[index];
        let published = published.attacked(attack);
        let flagged = published.and_then(|of| flagged.get(&of)).map_or(&[][..], Vec::as_slice);
        let reports =
            reporting.attacked(attack).and_then(|of| reports.get(&of)).map_or(&[][..], Vec::as_slice);
        let course = AttackCourse::of(attack, reports, drone, flight);
        let own = output.iter().filter(|point| published.is_some() && TransponderKey::of(point) == published);
        let shown = FlaggedCoverage::of(attack, (flagged, own), (index, drone), &points, flight);
        Some(AttackDetection::new(attack, &course, flagged, shown))
    };
    IntegrityScore {
        attacks: attacks.iter().filter(|attack| attack.kind.is_attack()).filter_map(detection).collect(),
        clean: FalseFlagScore::of(
            (&reports, &reporting.attack_begins(attacks)),
            (&flagged, &published.attack_begins(attacks)),
        ),
        uncooperative: UncooperativeScore::of(&points, attacks, truth, labels, settings.grid.slot_s()),
        jamming: flight.alerts.map(|alerts| JammingScore::of(alerts, attacks, settings)),
    }
}
