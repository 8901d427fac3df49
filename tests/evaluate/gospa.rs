//! GOSPA and its components compared with Stone Soup (`testdata/oracle/gospa.csv`), and the time for a crowded slot.

use std::time::Instant;

use utm_fusion::evaluate::{Gospa, Near, gospa};

const TABLE: &str = include_str!("../../testdata/oracle/gospa.csv");

/// Parses points, each a list of coordinates.
fn points(cell: &str) -> Vec<Vec<f64>> {
    let coordinates = |point: &str| point.split(' ').map(|x| x.parse().unwrap()).collect();
    cell.split(';').filter(|point| !point.is_empty()).map(coordinates).collect()
}

fn of(truths: &[Vec<f64>], points: &[Vec<f64>], cut_off_m: f64) -> Gospa {
    let mut near = Vec::new();
    for (truth, at) in truths.iter().enumerate() {
        for (point, other) in points.iter().enumerate() {
            let distance_m = at.iter().zip(other).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt();
            if distance_m < cut_off_m {
                near.push(Near { truth, point, distance_m });
            }
        }
    }
    gospa(truths.len(), points.len(), &near, cut_off_m)
}

#[test]
fn equals_another_implementation() {
    let (mut cases, mut largest) = (0, 0.0_f64);
    for line in TABLE.lines().skip(2) {
        let cells: Vec<&str> = line.split(',').collect();
        let number = |index: usize| cells[index].parse::<f64>().unwrap();
        let told = of(&points(cells[2]), &points(cells[3]), number(1));
        for (ours, theirs) in [(told.value_m, number(4)), (told.localisation_m2, number(5))] {
            let difference = (ours - theirs).abs() / theirs.max(1.0);
            largest = largest.max(difference);
            assert!(difference <= 1e-9, "case {}: {ours} is not {theirs}", cells[0]);
        }
        assert_eq!((told.missed as f64, told.unmatched as f64), (number(6), number(7)), "case {}", cells[0]);
        cases += 1;
    }
    println!("GOSPA: {cases} cases, maximum deviation {largest:.1e}");
    assert_eq!(cases, 100);
}

#[test]
fn a_crowded_slot_is_fast() {
    // 500 drones 25 m apart, so that all of them are connected by the cut-off, with a point each.
    let mut state = 1_u64;
    let mut random = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
    };
    let truths: Vec<Vec<f64>> =
        (0..500).map(|i| vec![f64::from(i % 25) * 25.0, f64::from(i / 25) * 25.0]).collect();
    let mut points: Vec<Vec<f64>> =
        truths.iter().map(|at| at.iter().map(|x| x + 60.0 * random()).collect()).collect();
    points.reverse();
    #[expect(clippy::disallowed_methods, reason = "how long it takes")]
    let started = Instant::now();
    let told = of(&truths, &points, 50.0);
    let took = started.elapsed();
    println!("500 x 500 in one crowd: {took:?}, {told:?}");
    assert!(told.matched > 450, "{told:?}");
    assert!(took.as_secs_f64() < 1.0, "{took:?} on whatever machine this is");
}
