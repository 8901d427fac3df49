//! Figure of an encounter: joined lines, width of the band, and the note of an empty figure.

use roxmltree::{Document, Node};

use super::super::super::{ClosestApproach, Encounter, PredictedApproach};
use super::super::encounter;
use super::well_formed;
use fusion::time::{SECOND, Time};

const CLOSEST: Time = Time::from_nanos(1_773_478_860 * SECOND);

fn approach(second: i64, t_cpa_s: f64, d_cpa_m: f64) -> ClosestApproach {
    ClosestApproach { time: Time::from_nanos(CLOSEST.nanos() + second * SECOND), t_cpa_s, d_cpa_m }
}

/// Two drones that pass 40 m from each other; the prediction at the given seconds is 100 m.
fn met(stated: &[i64]) -> Encounter {
    let of = |second: i64, d_cpa_m| approach(second, (-second).max(0) as f64, d_cpa_m);
    Encounter {
        ids: ["A<".to_owned(), "B".to_owned()],
        time: CLOSEST,
        distance_m: 50.0,
        ground_m: 40.0,
        truth: (-30..=5).map(|second| of(second, 40.0)).collect(),
        foreseen: stated
            .iter()
            .map(|&second| PredictedApproach { approach: of(second, 100.0), sigma_m: 25.0 })
            .collect(),
    }
}

/// Path data of elements with this attribute, in the order of the charts.
fn data<'a>(document: &'a Document<'_>, name: &str, value: &str) -> Vec<&'a str> {
    let inside = |node: &Node<'_, '_>| {
        node.parent_element().is_some_and(|group| group.has_attribute("clip-path"))
            && node.attribute(name) == Some(value)
    };
    document.descendants().filter(inside).filter_map(|node| node.attribute("d")).collect()
}

#[test]
fn both_charts_have_both_lines_and_a_two_sigma_band() {
    let figure = encounter(Some(&met(&[-20, -19, -18, -10, -9])));
    well_formed(&figure);
    let document = Document::parse(&figure.svg).unwrap();
    assert_eq!(data(&document, "stroke-dasharray", "7 3").len(), 2, "the truth in both");
    // Predictions one second apart are joined.
    let stated = data(&document, "stroke", "#052c5c");
    assert_eq!(stated.len(), 2);
    assert!(stated.iter().all(|line| line.matches('M').count() == 2), "{stated:?}");
    // Band of the distances: from 100 m - 50 m to 100 m + 50 m, with a twentieth free above.
    let bands = data(&document, "fill", "#c9d8ee");
    let heights: Vec<f64> =
        bands[0].split(['M', 'L']).filter_map(|at| at.split(' ').nth(1)?.parse().ok()).collect();
    let pixels = |metres: f64| 210.0 * (1.0 - metres / 157.5);
    for (height, metres) in heights.iter().zip([150.0, 150.0, 150.0, 50.0, 50.0, 50.0]) {
        assert!((height - pixels(metres)).abs() < 0.1, "{heights:?}");
    }
    assert_eq!((bands.len(), heights.len()), (2, 6));
    assert!(
        figure.caption.contains("A< and B came closest")
            && figure.caption.contains("50.0 m, over ground 40.0 m")
    );
}

#[test]
fn missing_predictions_are_noted_beside_the_truth() {
    let figure = encounter(Some(&met(&[])));
    well_formed(&figure);
    let document = Document::parse(&figure.svg).unwrap();
    assert_eq!(data(&document, "stroke-dasharray", "7 3").len(), 2);
    assert!(
        figure.svg.contains(">nothing was foreseen of A&lt; and B<") && !figure.svg.contains("as stated")
    );
    let figure = encounter(None);
    well_formed(&figure);
    assert!(figure.svg.contains(">no two drones with a transponder flew at one time<"));
}

#[test]
fn non_finite_values_are_omitted() {
    let mut met = met(&[-20, -19, -18]);
    met.truth[3].d_cpa_m = f64::NAN;
    met.foreseen[1].sigma_m = f64::INFINITY;
    met.foreseen[2].approach.t_cpa_s = f64::NAN;
    well_formed(&encounter(Some(&met)));
}
