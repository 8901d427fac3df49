//! Breakdown of the product's and the limit's errors: by part of the flight, motion and sensors.

use super::{LimitPoint, LimitResults, WAYS, mean};

/// Maximum speed of a hover, m/s. `FAST_M_S` is the minimum speed of a fast drone.
const HOVERS_M_S: f64 = 1.0;
const FAST_M_S: f64 = 15.0;

type PointFilter = fn(&LimitPoint, f64) -> bool;

const KINDS: [(&str, PointFilter); 14] = [
    ("covered", |point, _| point.is_covered()),
    ("covered, first third", |point, share| point.is_covered() && share < 1.0 / 3.0),
    ("covered, second third", |point, share| point.is_covered() && (1.0 / 3.0..2.0 / 3.0).contains(&share)),
    ("covered, last third", |point, share| point.is_covered() && share >= 2.0 / 3.0),
    ("covered, plots", |point, _| point.is_covered() && point.has_plots),
    ("covered, no plots", |point, _| point.is_covered() && !point.has_plots),
    ("covered, straight", |point, _| point.is_covered() && !point.is_turning && speed(point) >= HOVERS_M_S),
    ("covered, turning", |point, _| point.is_covered() && point.is_turning),
    ("covered, hovering", |point, _| point.is_covered() && speed(point) < HOVERS_M_S),
    ("covered, fast", |point, _| point.is_covered() && speed(point) >= FAST_M_S),
    ("gap, plots", |point, _| point.is_gap() && point.has_plots),
    ("gap, no plots", |point, _| point.is_gap() && !point.has_plots),
    ("without, plots", |point, _| !point.is_equipped && point.has_plots),
    ("without, no plots", |point, _| !point.is_equipped && !point.has_plots),
];

/// A figure of a point and an estimator.
type PointValue = fn(&LimitPoint, usize) -> f64;

/// All figures; in metres, except for the last.
const FIGURES: [(&str, PointValue); 6] = [
    ("horizontal", LimitPoint::horizontal_m),
    ("vertical", LimitPoint::vertical_m),
    ("along", |point, way| axes(point, way)[0]),
    ("|along|", |point, way| axes(point, way)[0].abs()),
    ("|across|", |point, way| axes(point, way)[1].abs()),
    ("|delay|, s", |point, way| point.delays_off_s[way]),
];

fn speed(point: &LimitPoint) -> f64 {
    point.velocity_m_s[0].hypot(point.velocity_m_s[1])
}

/// Error along and across the course.
fn axes(point: &LimitPoint, way: usize) -> [f64; 2] {
    let [east, north, _] = point.errors_m[way];
    let [v_east, v_north] = point.velocity_m_s;
    let speed = speed(point).max(1e-3);
    [(east * v_east + north * v_north) / speed, (north * v_east - east * v_north) / speed]
}

/// A block for each scenario, over all flights.
pub fn parts(measured: &[LimitResults]) -> String {
    let mut text = String::new();
    for row in measured {
        text += &format!("{}: m, product and limits in the order of the table\n", row.name);
        for (name, is_selected) in KINDS {
            let points = || {
                row.flights.iter().flat_map(move |flown| {
                    flown
                        .points
                        .iter()
                        .filter(move |point| is_selected(point, point.time_s / flown.duration_s))
                })
            };
            let count = points().count();
            if count == 0 {
                continue;
            }
            let figures = FIGURES.map(|(figure, of)| {
                let ways = (0..WAYS.len()).filter_map(|way| mean(points(), |_| true, |point| of(point, way)));
                let ways: Vec<String> = ways.map(|value| format!("{value:.2}")).collect();
                format!("{figure} {}", ways.join(" "))
            });
            text += &format!("  {name:<22} {count:>6}  {}\n", figures.join("  "));
        }
    }
    text
}
