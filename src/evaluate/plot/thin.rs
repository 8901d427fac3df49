//! Fewer points for the same picture: an SVG of every point of a long recording would not open.

use std::collections::HashSet;

/// Points of one series that a figure holds at most: 10 to 30 octets each.
pub(super) const POINTS_MAX: usize = 10_000;
/// Corners of all lines together.
const CORNERS_MAX: usize = 50_000;

/// Each cell of a grid keeps its first point; the grid is as fine as [`POINTS_MAX`] allows. Pixels in, pixels out, in
/// the same order; all of them within a frame of `size`.
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

/// The lines with fewer corners: as true to them as [`CORNERS_MAX`] in all of them allows, and never finer than what
/// can be seen. A line shorter than that becomes a dot, and is empty if another dot is there already. Pixels in, pixels
/// out; whether more than the invisible was taken.
pub(super) fn simplify(lines: Vec<Vec<(f64, f64)>>) -> (Vec<Vec<(f64, f64)>>, bool) {
    let mut lines = lines;
    let mut tolerance = 0.15;
    loop {
        let mut dots = HashSet::new();
        for line in &mut lines {
            *line = straightened(line, tolerance);
            // Dots on top of each other are one; nothing else bounds a path that is all gaps.
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

/// Ramer, Douglas and Peucker: the fewest corners found such that none that was dropped is off by more than `tolerance`.
/// With a stack of its own, because a path may be as long as it likes.
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
    fn what_is_few_stays_as_it_is() {
        let points = vec![(1.0, 2.0), (1.0, 2.0), (3.0, 4.0)];
        assert_eq!(thin(points.clone(), (9.0, 9.0)), points);
    }

    #[test]
    fn many_points_become_at_most_the_bound_and_no_empty_picture() {
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
