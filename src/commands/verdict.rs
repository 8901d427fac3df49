//! A simulated flight's score, for first-time users.

use super::table::Table;
use crate::evaluate::{ErrorStatistics, Evaluation, Score, Scored};

/// Mean error and probability of update of one stream.
type Figures = fn(&Scored) -> (Option<ErrorStatistics>, Option<f64>);

/// Circumstances, their scores, and the input that is compared with the output there.
const ROWS: [(&str, Figures, Input); 3] = [
    ("while its transponder spoke", |of| covered(&of.all), Input::Transponder),
    ("while its transponder was silent", |of| in_gaps(&of.all), Input::Radar),
    ("drones without a transponder", |of| (of.unequipped.epos, of.unequipped.pu_percent), Input::Radar),
];

#[derive(Clone, Copy)]
enum Input {
    Radar,
    Transponder,
}

fn covered(score: &Score) -> (Option<ErrorStatistics>, Option<f64>) {
    (score.epos_covered, score.pu_covered_percent)
}

fn in_gaps(score: &Score) -> (Option<ErrorStatistics>, Option<f64>) {
    (score.epos_gap, score.pu_gap_percent)
}

/// The output beside the available input, over the same slots of the same drones. Over all slots together the transponder
/// alone would look best, since it has no error where it is silent.
pub(super) fn verdict(evaluation: &Evaluation) -> String {
    let mut table = Table::new("lrrrrl", &["", "fused", "seen", "alone", "seen", ""]);
    for (name, figures, input) in ROWS {
        let (alone, input) = match input {
            Input::Radar => (&evaluation.radar, "radar"),
            Input::Transponder => (&evaluation.transponder, "transponder"),
        };
        let Some(alone) = alone else { continue };
        let [fused, alone] = [figures(&evaluation.fused), figures(alone)].map(cells);
        if let (Some(fused), Some(alone)) = (fused, alone) {
            let [[fused_m, fused_seen], [alone_m, alone_seen]] = [fused, alone];
            table.row([name.to_owned(), fused_m, fused_seen, alone_m, alone_seen, input.to_owned()]);
        }
    }
    if table.is_empty() {
        return String::new();
    }
    format!(
        "Mean distance from the true position, and share of the time with a position:\n\
         fused, and from the one sensor alone over the same time.\n\n{table}"
    )
}

/// A mean error and a share as shown.
fn cells((error, percent): (Option<ErrorStatistics>, Option<f64>)) -> Option<[String; 2]> {
    let (error, percent) = error.zip(percent)?;
    let decimals = if error.mean_m < 10.0 { 2 } else { 1 };
    Some([format!("{:.decimals$} m", error.mean_m), format!("{percent:.0} %")])
}
