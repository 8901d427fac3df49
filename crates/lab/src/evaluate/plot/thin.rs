//! Thins points without visible change: an SVG with every point of a long recording would not open.

use std::collections::HashSet;

/// Maximum number of points of one series in a figure; each takes 10 to 30 octets.
pub(super) const POINTS_MAX: usize = 10_000;
/// Maximum number of corners of all lines together.
const CORNERS_MAX: usize = 50_000;

/// Keeps the first point in each cell of a grid, which is as fine as [`POINTS_MAX`] allows. Input and output are pixels
/// in the same order, within a frame of `size`.
pub(super) fn thin(points: Vec<(f64, f64)>, size: (f64, f64)) -> Vec<(f64, f64)> {
    let mut points = points;
    let mut cell = 0.5;
    while points.len() > POINTS_MAX {
        let columns = (size.0 / cell) as usize + 1;
        let mut taken = vec![false; columns * ((size.1 / cell) as usize + 1)];
        points.retain(|(x, y)| {
            let taken = &mut taken[(y / cell) as usize * columns + (x / cell) as usize];
            !std::mem::replace(taken, true)
        });
        cell *= 1.25;
    }
    points
}

/// Reduces the corners of lines: as accurately as [`CORNERS_MAX`] for all lines allows, and never finer than visible. A
/// line shorter than that becomes a dot, or is emptied if there is already a dot at its place. Input and output are
/// pixels. Returns whether the reduction is visible.
pub(super) fn simplify(lines: Vec<Vec<(f64, f64)>>) -> (Vec<Vec<(f64, f64)>>, bool) {
    let mut lines = lines;
    let mut tolerance = 0.15;
    loop {
        let mut dots = HashSet::new();
        for line in &mut lines {
            *line = straightened(line, tolerance);
            // Coinciding dots become one; otherwise a path that consists of gaps would not be bounded.
            if let [(x, y)] = line[..]
                && !dots.insert(((x / tolerance).floor() as i64, (y / tolerance).floor() as i64))
            {
                line.clear();
            }
        }
        if lines.iter().map(Vec::len).sum::<usize>() <= CORNERS_MAX {
            return (lines, tolerance > 0.5);
        }
        tolerance *= 1.5;
    }
}

/// Ramer–Douglas–Peucker: drops corners that are off by at most `tolerance`. Uses an explicit stack, because a path may
/// be arbitrarily long.
fn straightened(line: &[(f64, f64)], tolerance: f64) -> Vec<(f64, f64)> {
    let Some(&start) = line.first() else { return Vec::new() };
    if line.iter().all(|point| distance(*point, start) <= tolerance) {
        return vec![start];
    }
    let mut keep = vec![false; line.len()];
    keep[0] = true;
    keep[line.len() - 1] = true;
    let mut spans = vec![(0, line.len() - 1)];
    while let Some((from, to)) = spans.pop() {
        let mut farthest = (tolerance, None);
        for between in from + 1..to {
            let off = distance_to_segment(line[between], line[from], line[to]);
            if off > farthest.0 {
                farthest = (off, Some(between));
            }
        }
        if let Some(corner) = farthest.1 {
            keep[corner] = true;
            spans.extend([(from, corner), (corner, to)]);
        }
    }
    line.iter().zip(keep).filter_map(|(point, keep)| keep.then_some(*point)).collect()
}

fn distance(one: (f64, f64), other: (f64, f64)) -> f64 {
    (one.0 - other.0).hypot(one.1 - other.1)
}

fn distance_to_segment(point: (f64, f64), from: (f64, f64), to: (f64, f64)) -> f64 {
    let (along_x, along_y) = (to.0 - from.0, to.1 - from.1);
    let length2 = along_x * along_x + along_y * along_y;
    if length2 == 0.0 {
        return distance(point, from);
    }
    let share = ((point.0 - from.0) * along_x + (point.1 - from.1) * along_y) / length2;
    let share = share.clamp(0.0, 1.0);
    distance(point, (from.0 + share * along_x, from.1 + share * along_y))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn few_points_are_not_thinned() {
        let points = vec![(1.0, 2.0), (1.0, 2.0), (3.0, 4.0)];
        assert_eq!(thin(points.clone(), (9.0, 9.0)), points);
    }

    #[test]
    fn many_points_are_thinned_to_at_most_the_bound() {
        let points = (0..200_000).map(|n| (f64::from(n % 620), f64::from(n * 7 % 331))).collect();
        let thinned = thin(points, (620.0, 331.0)).len();
        assert!((POINTS_MAX / 4..=POINTS_MAX).contains(&thinned), "{thinned}");
    }

    #[test]
    fn a_straight_line_keeps_its_ends_and_a_corner_stays() {
        let line = (0..100).map(|n| (f64::from(n), f64::from((n - 50).max(0)))).collect();
        assert_eq!(simplify(vec![line]), (vec![vec![(0.0, 0.0), (50.0, 0.0), (99.0, 49.0)]], false));
    }

    #[test]
    fn a_path_of_gaps_alone_is_bounded_too() {
        let dots = (0..100_000).map(|n| vec![(f64::from(n % 600), f64::from(n / 600))]).collect();
        let (lines, coarse) = simplify(dots);
        let kept = lines.concat().len();
        assert!(coarse && (CORNERS_MAX / 4..=CORNERS_MAX).contains(&kept), "{kept}");
    }
}
