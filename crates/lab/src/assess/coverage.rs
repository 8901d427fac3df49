//! Maps of the probability of update over ground (SVG).

use std::collections::BTreeMap;
use std::fmt::Write as _;

use super::bins::{RANGE_STEPS_M, bin, step};
use super::subject::AssessedSubject;

/// Most cells from the middle to the edge.
const CELLS: f64 = 10.0;
/// Fewest updates due in a cell that is filled.
const DUE_MIN: u64 = 10;
/// Side of a map, pixels, without its margins.
const SIDE: f64 = 300.0;
/// Margin, pixels.
const MARGIN: f64 = 12.0;
/// Colours of the shares 0 to 20 %, ... 80 to 100 %: lightness falls, for grey prints.
const COLOURS: [&str; 5] = ["#f3e9c6", "#c6d9a8", "#86bf9a", "#3f8f9b", "#1d4f7c"];

/// Map of a subject, with its caption; `None` without updates due.
pub(super) fn map(subject: &AssessedSubject<'_>) -> Option<(String, String)> {
    let offsets: Vec<([f64; 2], bool)> = (subject.updates.due.iter())
        .map(|due| {
            let offset = due.place.offset_from(&subject.origin);
            ([offset.east_m, offset.north_m], due.is_made)
        })
        .collect();
    let furthest = offsets.iter().map(|([east_m, north_m], _)| east_m.abs().max(north_m.abs()));
    let cell_m = step(furthest.clone(), &RANGE_STEPS_M, CELLS);
    let reach = furthest.fold(0.0, f64::max);
    let cells = ((reach / cell_m).floor() + 1.0).min(CELLS);
    let mut counts: BTreeMap<[i64; 2], [u64; 2]> = BTreeMap::new();
    for ([east_m, north_m], is_made) in &offsets {
        let count = counts.entry([bin(*north_m, cell_m), bin(*east_m, cell_m)]).or_default();
        count[0] += u64::from(*is_made);
        count[1] += 1;
    }
    if counts.is_empty() {
        return None;
    }
    let side = SIDE / (2.0 * cells);
    let mut svg = String::new();
    let size = SIDE + 2.0 * MARGIN;
    // Writing to a string cannot fail.
    let _ = write!(
        svg,
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {size} {size}\" width=\"{size}\" height=\"{size}\" role=\"img\">\
        <title>Probability of update over ground</title>"
    );
    for ([north, east], [made, due]) in &counts {
        let (east, north) = (*east as f64 + cells, cells - 1.0 - *north as f64);
        if !(0.0..2.0 * cells).contains(&east) || !(0.0..2.0 * cells).contains(&north) {
            continue;
        }
        let fill = if *due < DUE_MIN { "#e6e6e6" } else { COLOURS[((5 * made / due) as usize).min(4)] };
        let (x, y) = (MARGIN + east * side, MARGIN + north * side);
        let _ = write!(
            svg,
            "<rect x=\"{x:.1}\" y=\"{y:.1}\" width=\"{side:.1}\" height=\"{side:.1}\" fill=\"{fill}\">\
            <title>{made} of {due}</title></rect>"
        );
    }
    let middle = MARGIN + SIDE / 2.0;
    let (near, far) = (middle - 5.0, middle + 5.0);
    let _ = write!(
        svg,
        "<rect x=\"{MARGIN}\" y=\"{MARGIN}\" width=\"{SIDE}\" height=\"{SIDE}\" fill=\"none\" stroke=\"#888\"/>\
        <path d=\"M{near} {middle}H{far}M{middle} {near}V{far}\" stroke=\"#000\" stroke-width=\"1.5\"/></svg>"
    );
    let caption = format!(
        "{}: north is up, one cell is {cell_m} m. The darker, the more of the updates due were made: below 20, 40, 60, 80 and up to \
        100 %. Grey: fewer than {DUE_MIN} updates due. The cross is the origin of ranges.",
        subject.title
    );
    Some((svg, caption))
}
