//! How well an output says which transponders lie: `evaluate --integrity`.

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
pub use clean::{Clean, FalseFlag};
pub use detection::Detection;
pub use jamming::{Alert, Jamming};
pub use shown::Shown;
pub use uncooperative::Uncooperative;

use super::counted::Counted;
use super::judged::{Reference, judge};
use super::labels::Labels;
use super::owner::PointKind;
use super::truth::Truth;
use super::types::{OutputPoint, Scoring};
use course::Course;
use transponders::{Transponder, Transponders};

/// What a flight's flags are scored by.
#[derive(Clone, Copy, Debug)]
pub struct Flight<'a> {
    /// Where the drones were.
    pub truth: &'a Truth,
    /// What each plot and each report was.
    pub labels: &'a Labels,
    /// Every transponder report that was accepted, at its own time, under its number.
    pub reports: &'a [OutputPoint],
    /// What was done to transponders.
    pub attacks: &'a [Attack],
    /// The output.
    pub output: &'a [OutputPoint],
    /// The alerts of the output, where they are known.
    pub alerts: Option<&'a [Alert]>,
    /// Slots and latency.
    pub settings: &'a Scoring,
}

/// How well the flags are set.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Integrity {
    /// Each lie, in the order of the attacks.
    pub attacks: Vec<Detection>,
    /// Flags where there was none.
    pub clean: Clean,
    /// Marks of those that fly without a transponder.
    pub uncooperative: Uncooperative,
    /// The alert `jamming`; `None` where alerts are not known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub jamming: Option<Jamming>,
}

/// Scores the flags of an output.
pub fn integrity(flight: &Flight<'_>) -> Integrity {
    let Flight { truth, labels, attacks, output, settings, .. } = *flight;
    let mut reports: BTreeMap<Transponder<'_>, Vec<&OutputPoint>> = BTreeMap::new();
    for report in flight.reports {
        if let Some(transponder) = Transponder::of(report) {
            reports.entry(transponder).or_default().push(report);
        }
    }
    reports.values_mut().for_each(|reports| reports.sort_by_key(|report| report.time)); // stable
    let flagged = flags::by_transponder(output, settings);
    let (reporting, published) = (Transponders::of(flight.reports), Transponders::of(output));
    let counted = Counted::new(truth, settings.grid);
    let reference = Reference { truth, labels: Some(labels), counted: &counted, grid: settings.grid };
    let points = judge(output, PointKind::Output, reference);
    let detection = |attack: &Attack| {
        let index = truth.index_of(&attack.id)?;
        let drone = &truth.tracks()[index];
        let published = published.attacked(attack);
        let flagged = published.and_then(|of| flagged.get(&of)).map_or(&[][..], Vec::as_slice);
        let reports =
            reporting.attacked(attack).and_then(|of| reports.get(&of)).map_or(&[][..], Vec::as_slice);
        let course = Course::of(attack, reports, drone, flight);
        let own = output.iter().filter(|point| published.is_some() && Transponder::of(point) == published);
        let shown = Shown::of(attack, (flagged, own), (index, drone), &points, flight);
        Some(Detection::new(attack, &course, flagged, shown))
    };
    Integrity {
        attacks: attacks.iter().filter(|attack| attack.kind.is_lie()).filter_map(detection).collect(),
        clean: Clean::of((&reports, &reporting.lies(attacks)), (&flagged, &published.lies(attacks))),
        uncooperative: Uncooperative::of(&points, attacks, truth, labels, settings.grid.slot_s()),
        jamming: flight.alerts.map(|alerts| Jamming::of(alerts, attacks, settings)),
    }
}
