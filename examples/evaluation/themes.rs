//! The columns of the tables.

use crate::figures::*;
use crate::table::Column;

const US: Stream = OPERATIONAL;
const PAPER: Stream = REFERENCE;

/// In the order of the columns.
const STREAMS: [(&str, Stream); 4] =
    [("`reference`", PAPER), ("`operational`", US), ("radar", RADAR), ("transponder", TRANSPONDER)];
/// How many of them: the profiles; with the radar; all.
const PROFILES: usize = 2;
const WITH_RADAR: usize = 3;
const EVERY: usize = 4;

/// A column of each of so many streams. The head stands over the first, where there is one.
fn columns(
    streams: usize,
    head: &str,
    of: fn(&Stream) -> Group,
    figure: Figure,
    decimals: usize,
) -> Vec<Column> {
    let column = |(index, (name, stream)): (usize, &(&str, Stream))| {
        let name =
            if index == 0 && !head.is_empty() { format!("{head}: {name}") } else { (*name).to_owned() };
        Column::of(&name, of(stream), figure, decimals)
    };
    STREAMS.iter().take(streams).enumerate().map(column).collect()
}

const ALL: fn(&Stream) -> Group = |stream| stream.all;
const EQUIPPED: fn(&Stream) -> Group = |stream| stream.equipped;
const UNEQUIPPED: fn(&Stream) -> Group = |stream| stream.unequipped;

/// The tables of the simulated flights.
pub fn simulated() -> Vec<(&'static str, Vec<Column>)> {
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

fn often() -> Vec<Column> {
    let mut often = columns(EVERY, "PU, equipped", EQUIPPED, PU, 1);
    often.extend(columns(WITH_RADAR, "gap slots with a point within 50 m", EQUIPPED, GAP_WITHIN_50_M, 1));
    often.extend(columns(WITH_RADAR, "PU, without transponder", UNEQUIPPED, PU, 1));
    often
}

fn equipped() -> Vec<Column> {
    let mut equipped = columns(PROFILES, "covered", EQUIPPED, COVERED, 2);
    equipped.push(Column::of("transponder", TRANSPONDER.equipped, COVERED, 2));
    equipped.push(Column::ratio("`operational` / transponder", US.equipped, TRANSPONDER.equipped, COVERED));
    equipped.extend(columns(WITH_RADAR, "in gaps", EQUIPPED, GAP, 1));
    equipped.push(Column::ratio("`operational` / radar", US.equipped, RADAR.equipped, GAP));
    equipped
}

fn unequipped() -> Vec<Column> {
    let mut unequipped = columns(WITH_RADAR, "", UNEQUIPPED, EPOS, 1);
    unequipped.push(Column::ratio("`reference` / radar", PAPER.unequipped, RADAR.unequipped, EPOS));
    unequipped.push(Column::ratio("`operational` / radar", US.unequipped, RADAR.unequipped, EPOS));
    unequipped
}

fn rightly() -> Vec<Column> {
    let mut rightly = columns(PROFILES, "association precision", ALL, PRECISION, 3);
    rightly.extend(columns(PROFILES, "recall", ALL, RECALL, 3));
    rightly.extend(columns(PROFILES, "identity changes a drone-minute, all", ALL, ID_CHANGES, 2));
    rightly.push(Column::of("without transponder", US.unequipped, ID_CHANGES, 2));
    rightly.push(Column::of("slots with two numbers, percent", US.all, TWO_NUMBERS, 2));
    rightly.push(Column::of("ghosts, s a minute", US.all, GHOSTS, 1));
    rightly.extend(columns(PROFILES, "false track, s a minute", ALL, FALSE_TRACK, 1));
    rightly
}

fn gospa() -> Vec<Column> {
    let mut gospa = columns(EVERY, "", ALL, GOSPA, 1);
    gospa.push(Column::ratio("`operational` / `reference`", US.all, PAPER.all, GOSPA));
    gospa
}

fn honestly() -> Vec<Column> {
    vec![
        Column::of_drones("over ground, covered", US.each_equipped, NEES_COVERED),
        Column::of_drones("in gaps", US.each_equipped, NEES_GAP),
        Column::of_drones("without transponder", US.each_unequipped, NEES),
        Column::of_drones("height, covered", US.each_equipped, NEES_V_COVERED),
        Column::of_drones("in gaps", US.each_equipped, NEES_V_GAP),
        Column::of_drones("without transponder", US.each_unequipped, NEES_V),
    ]
}

fn honestly_by_state() -> Vec<Column> {
    vec![
        Column::of_drones("equipped: straight", US.each_equipped, NEES_STRAIGHT),
        Column::of_drones("turning", US.each_equipped, NEES_TURNING),
        Column::of_drones("walked off", US.each_equipped, NEES_WALKED_OFF),
        Column::of_drones("without transponder: straight", US.each_unequipped, NEES_STRAIGHT),
        Column::of_drones("turning", US.each_unequipped, NEES_TURNING),
        Column::of_drones("walked off", US.each_unequipped, NEES_WALKED_OFF),
    ]
}

/// The figures of `operational` that say most.
pub fn in_short() -> Vec<Column> {
    vec![
        Column::ratio("covered / transponder's", US.equipped, TRANSPONDER.equipped, COVERED),
        Column::ratio("gaps / radar's", US.equipped, RADAR.equipped, GAP),
        Column::of("gap slots within 50 m, percent", US.equipped, GAP_WITHIN_50_M, 1),
        Column::of("PU: equipped", US.equipped, PU, 1),
        Column::of("others", US.unequipped, PU, 1),
        Column::of("error of others, m", US.unequipped, EPOS, 1),
        Column::of("recall", US.all, RECALL, 3),
        Column::of("identity changes, all", US.all, ID_CHANGES, 2),
        Column::of("two numbers, percent", US.all, TWO_NUMBERS, 2),
        Column::of("false track, s a minute", US.all, FALSE_TRACK, 1),
        Column::ratio("GOSPA / `reference`'s", US.all, PAPER.all, GOSPA),
    ]
}

/// What errors of another size than the data sheet's do.
pub fn sheet() -> Vec<Column> {
    vec![
        Column::of("recall", US.all, RECALL, 3),
        Column::of("precision", US.all, PRECISION, 3),
        Column::ratio("covered / transponder's", US.equipped, TRANSPONDER.equipped, COVERED),
        Column::ratio("gaps / radar's", US.equipped, RADAR.equipped, GAP),
        Column::of("gap slots within 50 m, percent", US.equipped, GAP_WITHIN_50_M, 1),
        Column::of("identity changes, all", US.all, ID_CHANGES, 2),
        Column::ratio("GOSPA / `reference`'s", US.all, PAPER.all, GOSPA),
    ]
}

/// Real flights.
pub fn real() -> Vec<Column> {
    let mut real = columns(EVERY, "PU", ALL, PU, 1);
    real.extend(columns(EVERY, "ePosH", ALL, EPOSH, 2));
    real.extend(columns(PROFILES, "ghosts, s a minute", ALL, GHOSTS, 2));
    real
}

/// Real flights, where the transponder speaks and where it is silent.
pub fn real_by_slots() -> Vec<Column> {
    vec![
        Column::ratio("covered: `reference` / transponder", PAPER.all, TRANSPONDER.all, COVERED),
        Column::ratio("`operational` / transponder", US.all, TRANSPONDER.all, COVERED),
        Column::of("in gaps, m: `reference`", PAPER.all, GAP, 1),
        Column::of("`operational`", US.all, GAP, 1),
        Column::of("radar", RADAR.all, GAP, 1),
        Column::of("gap slots within 50 m, percent", US.all, GAP_WITHIN_50_M, 1),
        Column::of_drones("NEES, covered", US.each_equipped, NEES_COVERED),
        Column::of_drones("in gaps", US.each_equipped, NEES_GAP),
    ]
}
