//! 20,527 pairs of aircraft with the results of DAIDALUS.

use std::collections::BTreeMap;

use conflict::{AcceptedKinds, Extrapolation, Preset, Relative, SteadyFlightRatios, Vertical, Volume};
use nalgebra::Matrix4;

use crate::table::{Row, folder, number, numbers, rows};

const HORIZON_S: f64 = 60.0;
/// Times agree as printed.
const SAME_S: f64 = 2e-6;
/// Distances agree as printed.
const SAME_M: f64 = 2e-5;
const AHEAD: Extrapolation = Extrapolation {
    horizon_s: HORIZON_S,
    acceleration: 1.0,
    straight_s: 30.0,
    steady: SteadyFlightRatios::MEASURED,
};

/// The volumes, by the names of the oracle.
fn volumes() -> [(&'static str, Volume); 7] {
    let drone = Volume {
        name: "drone".to_owned(),
        horizontal_m: 50.0,
        vertical_m: 15.0,
        tau_s: 0.0,
        between: [AcceptedKinds::Any; 2],
    };
    let cylinder = Volume { tau_s: 0.0, ..Preset::Do365Enroute.volume() };
    [
        ("drone_50_15", drone),
        ("nmac", Preset::Nmac.volume()),
        ("f3442", Preset::F3442.volume()),
        ("do365_terminal", Preset::Do365Terminal.volume()),
        ("do365_noncooperative", Preset::Do365Noncooperative.volume()),
        ("do365_enroute_cylinder", cylinder),
        ("do365_enroute", Preset::Do365Enroute.volume()),
    ]
}

/// The relative state of a row, nearly exact.
fn relative(row: &Row) -> Relative {
    let [east, north, up] = numbers(row, ["rel_east_m", "rel_north_m", "rel_up_m"]);
    let own = numbers(row, ["own_ve_ms", "own_vn_ms", "own_vu_ms"]);
    let other = numbers(row, ["int_ve_ms", "int_vn_ms", "int_vu_ms"]);
    let [ve, vn, vu] = [0, 1, 2].map(|axis| other[axis] - own[axis]);
    Relative {
        position: [east, north].into(),
        velocity: [ve, vn].into(),
        covariance: Matrix4::from_diagonal(&[1e-8, 1e-8, 1e-10, 1e-10].into()),
        vertical: Some(Vertical { height_m: up, climb: vu, covariance: [1e-8, 0.0, 1e-10] }),
    }
}

fn is_same(found: f64, expected: f64, tolerance: f64) -> bool {
    (found - expected).abs() <= tolerance
}

/// Rows of kind `edge` lie exactly on a rim or lid, where DAIDALUS' volumes are open or closed (docs/CONFLICTS.md): of these
/// only those with an interval on both sides are compared.
#[test]
fn intervals_and_closest_approaches_are_those_of_daidalus() {
    let Some(folder) = folder() else { return };
    let rows = rows(&folder.join("pairs.csv.gz"));
    assert_eq!(rows.len(), 20_527);
    // By volume: intervals, no intervals, and rows on a rim that differ.
    let mut counts = BTreeMap::<&str, [u32; 3]>::new();
    for row in &rows {
        let (id, is_edge) = (&row["id"], row["kind"] == "edge");
        let relative = relative(row);
        let approach = relative.approach(&AHEAD);
        let [t_cpa_s, d_cpa_m] = numbers(row, ["tcpa_0_60_s", "dcpa_0_60_m"]);
        assert!(is_same(approach.t_cpa_s, t_cpa_s, 2e-5), "{id}: {} and {t_cpa_s} s", approach.t_cpa_s);
        assert!(is_same(approach.horizontal_m(), d_cpa_m, SAME_M), "{id}: {d_cpa_m} m");
        for (name, volume) in volumes() {
            let expected = number(row, &format!("{name}_in_s")).zip(number(row, &format!("{name}_out_s")));
            let found = volume.interval(&relative, HORIZON_S);
            let count = counts.entry(name).or_default();
            match (found, expected) {
                (Some(found), Some((in_s, out_s))) => {
                    let is_same =
                        is_same(found.entry_s, in_s, SAME_S) && is_same(found.exit_s, out_s, SAME_S);
                    assert!(is_same, "{name}, {id}: {found:?}, expected {in_s} to {out_s} s");
                    count[0] += 1;
                }
                (None, None) => count[1] += 1,
                _ if is_edge => count[2] += 1,
                _ => panic!("{name}, {id}: {found:?}, expected {expected:?}"),
            }
        }
    }
    for (name, [same, none, rim]) in &counts {
        println!("{name:<23} {same:>6} intervals, {none:>6} without, {rim:>3} on a rim differ");
        assert!(*rim <= 65, "{name}");
    }
}

/// With exact states, each entry ahead reaches the thresholds of its level before the volume begins, and a row without
/// conflict has the probability of a turn only.
#[test]
fn probabilities_of_exact_states_decide_as_daidalus() {
    let Some(folder) = folder() else { return };
    let mut counts = BTreeMap::<&str, [u32; 2]>::new();
    for row in rows(&folder.join("pairs.csv.gz")).iter().filter(|row| row["kind"] != "edge") {
        let relative = relative(row);
        for (name, volume) in volumes() {
            let passage = relative.passage(&volume, &AHEAD, 0.0);
            let is_expected = number(row, &format!("{name}_in_s")).is_some();
            let straight = (-passage.entry_s / AHEAD.straight_s).exp();
            let [right, wrong] = counts.entry(name).or_default();
            let is_right = match is_expected {
                true => passage.probability > 0.9 * straight && passage.exit_s.is_some(),
                false => passage.probability < 1.0 - 0.9 * straight,
            };
            *if is_right { right } else { wrong } += 1;
        }
    }
    for (name, [right, wrong]) in &counts {
        println!("{name:<23} {right:>6} as DAIDALUS, {wrong} exactly on a rim");
        assert!(*wrong <= 1, "{name}");
    }
}
