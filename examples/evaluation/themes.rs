//! Columns of the tables.

use crate::figures::*;
use crate::table::TableColumn;

const US: ScoreStream = OPERATIONAL;
const PAPER: ScoreStream = REFERENCE;

/// Streams, in the order of the columns.
const STREAMS: [(&str, ScoreStream); 4] =
    [("`reference`", PAPER), ("`operational`", US), ("radar", RADAR), ("transponder", TRANSPONDER)];
/// Numbers of streams: the profiles; with the radar; all.
const PROFILES: usize = 2;
const WITH_RADAR: usize = 3;
const EVERY: usize = 4;

/// A column for each of the first `streams` streams. The heading is above the first one.
fn columns(
    streams: usize,
    head: &str,
    of: fn(&ScoreStream) -> ScoreGroup,
    figure: ScoreFigure,
    decimals: usize,
) -> Vec<TableColumn> {
    let column = |(index, (name, stream)): (usize, &(&str, ScoreStream))| {
        let name =
            if index == 0 && !head.is_empty() { format!("{head}: {name}") } else { (*name).to_owned() };
        TableColumn::of(&name, of(stream), figure, decimals)
    };
    STREAMS.iter().take(streams).enumerate().map(column).collect()
}

const ALL: fn(&ScoreStream) -> ScoreGroup = |stream| stream.all;
const EQUIPPED: fn(&ScoreStream) -> ScoreGroup = |stream| stream.equipped;
const UNEQUIPPED: fn(&ScoreStream) -> ScoreGroup = |stream| stream.unequipped;

/// Tables of the simulated flights.
pub fn simulated() -> Vec<(&'static str, Vec<TableColumn>)> {
    vec![
        ("How often, percent of slots", often()),
        ("How exactly: mean position error of equipped drones, metres", equipped()),
        ("How exactly: mean position error of drones without a transponder, metres", unequipped()),
        ("How rightly", rightly()),
        ("All in one: GOSPA, metres", gospa()),
        ("How honest the deviations of `operational` are: mean NEES of its drones, 1 is honest", honestly()),
        ("The same over ground, by what the drone and the radar's track do", honestly_by_state()),
    ]
}

fn often() -> Vec<TableColumn> {
    let mut often = columns(EVERY, "PU, equipped", EQUIPPED, PU, 1);
    often.extend(columns(WITH_RADAR, "gap slots with a point within 50 m", EQUIPPED, GAP_WITHIN_50_M, 1));
    often.extend(columns(WITH_RADAR, "PU, without transponder", UNEQUIPPED, PU, 1));
    often
}

fn equipped() -> Vec<TableColumn> {
    let mut equipped = columns(PROFILES, "covered", EQUIPPED, COVERED, 2);
    equipped.push(TableColumn::of("transponder", TRANSPONDER.equipped, COVERED, 2));
    equipped.push(TableColumn::ratio(
        "`operational` / transponder",
        US.equipped,
        TRANSPONDER.equipped,
        COVERED,
    ));
    equipped.extend(columns(WITH_RADAR, "in gaps", EQUIPPED, GAP, 1));
    equipped.push(TableColumn::ratio("`operational` / radar", US.equipped, RADAR.equipped, GAP));
    equipped
}

fn unequipped() -> Vec<TableColumn> {
    let mut unequipped = columns(WITH_RADAR, "", UNEQUIPPED, EPOS, 1);
    unequipped.push(TableColumn::ratio("`reference` / radar", PAPER.unequipped, RADAR.unequipped, EPOS));
    unequipped.push(TableColumn::ratio("`operational` / radar", US.unequipped, RADAR.unequipped, EPOS));
    unequipped
}

fn rightly() -> Vec<TableColumn> {
    let mut rightly = columns(PROFILES, "association precision", ALL, PRECISION, 3);
    rightly.extend(columns(PROFILES, "recall", ALL, RECALL, 3));
    rightly.extend(columns(PROFILES, "identity changes a drone-minute, all", ALL, ID_CHANGES, 2));
    rightly.push(TableColumn::of("without transponder", US.unequipped, ID_CHANGES, 2));
    rightly.push(TableColumn::of("slots with two numbers, percent", US.all, TWO_NUMBERS, 2));
    rightly.push(TableColumn::of("ghosts, s a minute", US.all, GHOSTS, 1));
    rightly.extend(columns(PROFILES, "false track, s a minute", ALL, FALSE_TRACK, 1));
    rightly
}

fn gospa() -> Vec<TableColumn> {
    let mut gospa = columns(EVERY, "", ALL, GOSPA, 1);
    gospa.push(TableColumn::ratio("`operational` / `reference`", US.all, PAPER.all, GOSPA));
    gospa
}

fn honestly() -> Vec<TableColumn> {
    vec![
        TableColumn::of_drones("over ground, covered", US.each_equipped, NEES_COVERED),
        TableColumn::of_drones("in gaps", US.each_equipped, NEES_GAP),
        TableColumn::of_drones("without transponder", US.each_unequipped, NEES),
        TableColumn::of_drones("height, covered", US.each_equipped, NEES_V_COVERED),
        TableColumn::of_drones("in gaps", US.each_equipped, NEES_V_GAP),
        TableColumn::of_drones("without transponder", US.each_unequipped, NEES_V),
    ]
}

fn honestly_by_state() -> Vec<TableColumn> {
    vec![
        TableColumn::of_drones("equipped: straight", US.each_equipped, NEES_STRAIGHT),
        TableColumn::of_drones("turning", US.each_equipped, NEES_TURNING),
        TableColumn::of_drones("walked off", US.each_equipped, NEES_WALKED_OFF),
        TableColumn::of_drones("without transponder: straight", US.each_unequipped, NEES_STRAIGHT),
        TableColumn::of_drones("turning", US.each_unequipped, NEES_TURNING),
        TableColumn::of_drones("walked off", US.each_unequipped, NEES_WALKED_OFF),
    ]
}

/// The most important figures of `operational`.
pub fn in_short() -> Vec<TableColumn> {
    vec![
        TableColumn::ratio("covered / transponder's", US.equipped, TRANSPONDER.equipped, COVERED),
        TableColumn::ratio("gaps / radar's", US.equipped, RADAR.equipped, GAP),
        TableColumn::of("gap slots within 50 m, percent", US.equipped, GAP_WITHIN_50_M, 1),
        TableColumn::of("PU: equipped", US.equipped, PU, 1),
        TableColumn::of("others", US.unequipped, PU, 1),
        TableColumn::of("error of others, m", US.unequipped, EPOS, 1),
        TableColumn::of("recall", US.all, RECALL, 3),
        TableColumn::of("identity changes, all", US.all, ID_CHANGES, 2),
        TableColumn::of("two numbers, percent", US.all, TWO_NUMBERS, 2),
        TableColumn::of("false track, s a minute", US.all, FALSE_TRACK, 1),
        TableColumn::ratio("GOSPA / `reference`'s", US.all, PAPER.all, GOSPA),
    ]
}

/// Effect of radar errors that differ from the data sheet.
pub fn sheet() -> Vec<TableColumn> {
    vec![
        TableColumn::of("recall", US.all, RECALL, 3),
        TableColumn::of("precision", US.all, PRECISION, 3),
        TableColumn::ratio("covered / transponder's", US.equipped, TRANSPONDER.equipped, COVERED),
        TableColumn::ratio("gaps / radar's", US.equipped, RADAR.equipped, GAP),
        TableColumn::of("gap slots within 50 m, percent", US.equipped, GAP_WITHIN_50_M, 1),
        TableColumn::of("identity changes, all", US.all, ID_CHANGES, 2),
        TableColumn::ratio("GOSPA / `reference`'s", US.all, PAPER.all, GOSPA),
    ]
}

/// Real flights.
pub fn real() -> Vec<TableColumn> {
    let mut real = columns(EVERY, "PU", ALL, PU, 1);
    real.extend(columns(EVERY, "ePosH", ALL, EPOSH, 2));
    real.extend(columns(PROFILES, "ghosts, s a minute", ALL, GHOSTS, 2));
    real
}

/// Real flights, in slots with and without an interpolated transponder.
pub fn real_by_slots() -> Vec<TableColumn> {
    vec![
        TableColumn::ratio("covered: `reference` / transponder", PAPER.all, TRANSPONDER.all, COVERED),
        TableColumn::ratio("`operational` / transponder", US.all, TRANSPONDER.all, COVERED),
        TableColumn::of("in gaps, m: `reference`", PAPER.all, GAP, 1),
        TableColumn::of("`operational`", US.all, GAP, 1),
        TableColumn::of("radar", RADAR.all, GAP, 1),
        TableColumn::of("gap slots within 50 m, percent", US.all, GAP_WITHIN_50_M, 1),
        TableColumn::of_drones("NEES, covered", US.each_equipped, NEES_COVERED),
        TableColumn::of_drones("in gaps", US.each_equipped, NEES_GAP),
    ]
}
