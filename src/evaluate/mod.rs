//! Scores a tracker's output, and each input alone, against the truth: the metrics of the paper's section 4 and of
//! `docs/METRICS.md`.
//!
//! Sans-IO: truth, labels and points in, an [`Evaluation`] out. [`read`] makes them from the octets of files.

mod alone;
mod conflicts;
mod counted;
mod integrity;
mod judged;
mod labels;
mod metrics;
mod nearby;
mod owner;
mod place;
pub mod plot;
pub mod read;
mod residuals;
mod score;
mod truth;
mod types;

pub use alone::{InputsAlone, output, output_at, reports};
pub use conflicts::{
    Bin, ConflictFlight, Encounter, Foreseen, Foresight, Outlook, Stated, encounter, foresight,
};
pub use integrity::{
    Alert, Attack, AttackKind, Clean, Detection, FalseFlag, Flight, Integrity, Jamming, Shown, Uncooperative,
    integrity,
};
pub use labels::{Attribution, Label, Labels};
pub use metrics::gospa::{Gospa, Near, gospa};
pub use metrics::nees::honest_band;
pub use place::{Offset, Place};
pub use residuals::{PlotResidual, RadarResiduals, Residual, misalignments, residuals};
pub use truth::{TrueTrack, Truth};
pub use types::{
    Covariance, Drone, ErrorStatistics, Evaluation, Flags, GospaParts, Nees, OutputPoint, PointSource,
    PolarPlace, Sample, Score, Scored, Scoring,
};

use counted::Counted;
use judged::{Judged, Reference, judge};
use metrics::scene::Inputs;
use owner::PointKind;
use score::Kind;

/// Scores `output` and, where given, each input alone, against the truth.
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
    let counted = Counted::new(truth, grid);
    let reference = Reference { truth, labels, counted: &counted, grid };
    let fused = judge(output, PointKind::Output, reference);
    let alone = alone.map(|alone| {
        (
            judge(&alone.radar, PointKind::Plots, reference),
            judge(&alone.transponder, PointKind::Output, reference),
        )
    });
    let drones = drones(truth, labels, alone.as_ref().map(|alone| alone.1.as_slice()));
    let inputs = alone.as_ref().map(|(radar, transponder)| Inputs {
        covered: Inputs::slots(transponder, drones.len(), |_| true),
        detected: Inputs::slots(radar, drones.len(), |plot| !plot.seduced),
        radars: Inputs::radars(radar, drones.len()),
        equipped: drones.iter().map(|drone| drone.equipped == Some(true)).collect(),
    });
    let scored = |judged: &[Judged<'_>], kind: Kind| {
        score::scored(judged, &drones, reference, inputs.as_ref(), settings, kind)
    };
    Evaluation {
        fused: scored(&fused, Kind::Output),
        radar: alone.as_ref().map(|alone| scored(&alone.0, Kind::Alone)),
        transponder: alone.as_ref().map(|alone| scored(&alone.1, Kind::Alone)),
        drones,
    }
}

/// The drones; one carries a transponder if the labels say so, or if the transponders alone have a point of it.
fn drones(truth: &Truth, labels: Option<&Labels>, transponder: Option<&[Judged<'_>]>) -> Vec<Drone> {
    let labelled = labels.map(Labels::equipped);
    let mut seen = vec![false; truth.tracks().len()];
    for drone in transponder.into_iter().flatten().filter_map(|judged| judged.drone) {
        seen[drone] = true;
    }
    let equipped = |index: usize, id: &str| {
        let is_known = labelled.is_some() || transponder.is_some();
        is_known.then(|| seen[index] || labelled.as_ref().is_some_and(|labelled| labelled.contains(id)))
    };
    let drone = |(index, id): (usize, &str)| Drone { id: id.to_owned(), equipped: equipped(index, id) };
    truth.tracks().iter().map(TrueTrack::id).enumerate().map(drone).collect()
}
