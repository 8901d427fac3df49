//! Scores a tracker's output, and each input alone, against the truth: the metrics of the paper's section 4 and of
//! `docs/METRICS.md`.
//!
//! Sans-IO: takes truth, labels and points, returns an [`Evaluation`]. [`read`] parses these from the contents of
//! files.

mod alerts;
mod alone;
mod conflicts;
mod counted_slots;
mod integrity;
mod labels;
mod metrics;
mod nearby;
mod place;
pub mod plot;
mod point_owner;
pub mod read;
mod residuals;
mod score;
mod scored_point;
mod track_owners;
mod truth;
mod types;

pub use alerts::{AlertFlight, AlertScore, MissedEvent, ScoredItem, score_alerts};
pub use alone::{InputsAlone, output, output_at, reports};
pub(crate) use alone::{fix_point, plot_point};
pub use conflicts::{
    ClosestApproach, ConflictFlight, ConflictPrediction, ConflictScore, Encounter, PredictedApproach,
    ReliabilityBin, encounter, score_conflicts,
};
pub use integrity::{
    AlertLine, Attack, AttackDetection, AttackKind, FalseFlag, FalseFlagScore, FlaggedCoverage,
    IntegrityFlight, IntegrityScore, JammingScore, UncooperativeScore, integrity,
};
pub use labels::{Attribution, Label, Labels};
pub use metrics::gospa::{Gospa, Near, gospa};
pub use place::{GeodeticPlace, LocalOffset};
pub use residuals::{AngularResidual, PlotResidual, RadarResiduals, misalignments, residuals};
pub use truth::{TrueTrack, Truth};
pub use types::{
    Covariance, ErrorSample, ErrorStatistics, Evaluation, GospaParts, Nees, OutputPoint, PointFlags,
    PointSource, PolarPlace, ScoredStream, Scoring, StreamMetrics, TrueDrone,
};

pub(crate) use counted_slots::CountedSlots;
pub(crate) use metrics::identity::changes;
pub(crate) use metrics::statistics::statistics;
pub(crate) use point_owner::PointKind;
pub(crate) use scored_point::{ScoredPoint, ScoringReference, score_points};

use metrics::scene::InputSlots;
use score::StreamKind;

/// Scores `output`, and each input alone if given, against the truth.
///
/// Precision and recall need labels; recall, and the errors inside and outside gaps, need the inputs alone.
pub fn evaluate(
    truth: &Truth,
    labels: Option<&Labels>,
    output: &[OutputPoint],
    alone: Option<&InputsAlone>,
    settings: &Scoring,
) -> Evaluation {
    let grid = settings.grid;
    let counted = CountedSlots::new(truth, grid);
    let reference = ScoringReference { truth, labels, counted: &counted, grid };
    let fused = score_points(output, PointKind::Output, reference);
    let alone = alone.map(|alone| {
        (
            score_points(&alone.radar, PointKind::Plots, reference),
            score_points(&alone.transponder, PointKind::Output, reference),
        )
    });
    let drones = drones(truth, labels, alone.as_ref().map(|alone| alone.1.as_slice()));
    let inputs = alone.as_ref().map(|(radar, transponder)| InputSlots {
        covered: InputSlots::slots(transponder, drones.len(), |_| true),
        detected: InputSlots::slots(radar, drones.len(), |plot| !plot.seduced),
        radars: InputSlots::radars(radar, drones.len()),
        equipped: drones.iter().map(|drone| drone.equipped == Some(true)).collect(),
    });
    let scored = |scored_point: &[ScoredPoint<'_>], kind: StreamKind| {
        score::scored(scored_point, &drones, reference, inputs.as_ref(), settings, kind)
    };
    Evaluation {
        fused: scored(&fused, StreamKind::Output),
        radar: alone.as_ref().map(|alone| scored(&alone.0, StreamKind::Alone)),
        transponder: alone.as_ref().map(|alone| scored(&alone.1, StreamKind::Alone)),
        drones,
    }
}

/// The drones of the truth. A drone carries a transponder if the labels say so, or if the transponder stream has a
/// point of it.
fn drones(truth: &Truth, labels: Option<&Labels>, transponder: Option<&[ScoredPoint<'_>]>) -> Vec<TrueDrone> {
    let labelled = labels.map(Labels::equipped);
    let mut seen = vec![false; truth.tracks().len()];
    for drone in transponder.into_iter().flatten().filter_map(|scored_point| scored_point.drone) {
        seen[drone] = true;
    }
    let equipped = |index: usize, id: &str| {
        let is_known = labelled.is_some() || transponder.is_some();
        is_known.then(|| seen[index] || labelled.as_ref().is_some_and(|labelled| labelled.contains(id)))
    };
    let drone = |(index, id): (usize, &str)| TrueDrone { id: id.to_owned(), equipped: equipped(index, id) };
    truth.tracks().iter().map(TrueTrack::id).enumerate().map(drone).collect()
}
