//! Short score of a simulated flight, for first-time users.

use std::collections::BTreeSet;

use super::table::TextTable;
use fusion::slots::{Slot, SlotGrid};
use lab::evaluate::{ErrorStatistics, Evaluation, ScoredStream};
use lab::simulate::SimulatedAttack;

/// Mean error in metres, and share of the time with a position in percent.
type StreamScore = (Option<f64>, Option<f64>);

/// Difference of two shares that is explained below the table, in percent.
const EXPLAINED_PERCENT: f64 = 5.0;
/// Reason of a lower share of the output.
const LOWER_SHARE: &str = "\nThe radar alone counts each plot of a drone, because the simulation states which plots are birds. The fused \
    picture has\nto tell them apart: it publishes a track without a transponder once a drone is more probable than a bird.\n";

/// Slots of a drone in which its transponder has a position.
type CoveredSlots = BTreeSet<(usize, Slot)>;

/// Compares the output with the available input over the same slots of the same drones. Over all slots, the transponder alone
/// would look best, because it has no error while it is silent. Slots in which a transponder reports false positions have a row
/// of their own.
pub(super) fn demo_score(evaluation: &Evaluation, attacks: &[SimulatedAttack], grid: SlotGrid) -> String {
    let mut table = TextTable::new("lrrrrl", &["", "fused", "seen", "alone", "seen", ""]);
    let mut is_lower = false;
    let fused = &evaluation.fused;
    let mut row = |name: &str, fused: StreamScore, alone: StreamScore, input: &str| {
        is_lower |= input == "radar"
            && fused.1.zip(alone.1).is_some_and(|(fused, alone)| alone - fused > EXPLAINED_PERCENT);
        if let Some(([fused_m, fused_seen], [alone_m, alone_seen])) = cells(fused).zip(cells(alone)) {
            table.row([name.to_owned(), fused_m, fused_seen, alone_m, alone_seen, input.to_owned()]);
        }
    };
    if let Some(transponder) = &evaluation.transponder {
        let samples = transponder.samples.iter();
        let covered = samples.filter_map(|sample| Some((sample.drone?, grid.of(sample.time))));
        let is_false = |&(drone, slot): &(usize, Slot)| {
            attacks.iter().any(|attack| {
                attack.attack.is_some()
                    && attack.id == evaluation.drones[drone].id
                    && (grid.of(attack.from)..=grid.of(attack.until)).contains(&slot)
            })
        };
        let (lying, honest): (CoveredSlots, CoveredSlots) = covered.partition(is_false);
        for (name, slots) in
            [("while its transponder spoke", honest), ("while it sent false positions", lying)]
        {
            let of = |stream| score_in(stream, &slots, grid);
            row(name, of(fused), of(transponder), "transponder");
        }
    }
    if let Some(radar) = &evaluation.radar {
        let mean = |error: Option<ErrorStatistics>| error.map(|error| error.mean_m);
        let silent = |stream: &ScoredStream| (mean(stream.all.epos_gap), stream.all.pu_gap_percent);
        row("while its transponder was silent", silent(fused), silent(radar), "radar");
        let unequipped = |stream: &ScoredStream| (mean(stream.unequipped.epos), stream.unequipped.pu_percent);
        row("drones without a transponder", unequipped(fused), unequipped(radar), "radar");
    }
    if table.is_empty() {
        return String::new();
    }
    format!(
        "Mean distance from the true position, and share of the time with a position:\n\
         fused, and from the one sensor alone over the same time.\n\n{table}{}",
        if is_lower { LOWER_SHARE } else { "" }
    )
}

/// Score of a stream in these slots.
fn score_in(stream: &ScoredStream, slots: &CoveredSlots, grid: SlotGrid) -> StreamScore {
    let (mut errors_m, mut updated) = (Vec::new(), BTreeSet::new());
    for sample in &stream.samples {
        let Some(at) = sample.drone.map(|drone| (drone, grid.of(sample.time))) else { continue };
        if slots.contains(&at) {
            updated.insert(at);
            errors_m.extend(sample.error.map(|error| error.distance_m()));
        }
    }
    let ratio = |sum: f64, count: usize| (count > 0).then(|| sum / count as f64);
    (ratio(errors_m.iter().sum(), errors_m.len()), ratio(100.0 * updated.len() as f64, slots.len()))
}

/// Formatted mean error and percentage.
fn cells((error_m, percent): StreamScore) -> Option<[String; 2]> {
    let (error_m, percent) = error_m.zip(percent)?;
    let decimals = if error_m < 10.0 { 2 } else { 1 };
    Some([format!("{error_m:.decimals$} m"), format!("{percent:.0} %")])
}
