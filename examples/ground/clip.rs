//! Parts of lines and areas within a square.

use crate::feature::Place;

/// The area within the square from `low` to `high` on both axes (Sutherland and Hodgman, 1974). It is empty if nothing is.
pub fn area(ring: &[Place], low: f64, high: f64) -> Vec<Place> {
    let mut ring = ring.to_vec();
    for axis in 0..2 {
        for (limit, sign) in [(low, 1.0), (high, -1.0)] {
            let depth = |place: Place| sign * (place[axis] - limit);
            let mut kept = Vec::with_capacity(ring.len() + 4);
            for index in 0..ring.len() {
                let (from, to) = (ring[(index + ring.len() - 1) % ring.len()], ring[index]);
                if (depth(from) < 0.0) != (depth(to) < 0.0) {
                    kept.push(crate::shapes::between(from, to, depth(from) / (depth(from) - depth(to))));
                }
                if depth(to) >= 0.0 {
                    kept.push(to);
                }
            }
            ring = kept;
        }
    }
    ring
}

/// The parts of a line within the square from `low` to `high` on both axes.
pub fn line(line: &[Place], low: f64, high: f64) -> Vec<Vec<Place>> {
    let mut parts: Vec<Vec<Place>> = Vec::new();
    for pair in line.windows(2) {
        let Some((from, to)) = piece(pair[0], pair[1], low, high) else { continue };
        match parts.last_mut() {
            Some(part) if part.last() == Some(&from) => part.push(to),
            _ => parts.push(vec![from, to]),
        }
    }
    parts
}

/// The piece of a straight line within the square (Liang and Barsky, 1984).
fn piece(from: Place, to: Place, low: f64, high: f64) -> Option<(Place, Place)> {
    let (mut enters, mut leaves) = (0.0_f64, 1.0_f64);
    for (start, end) in from.into_iter().zip(to) {
        let step = end - start;
        if step == 0.0 {
            if !(low..=high).contains(&start) {
                return None;
            }
            continue;
        }
        let (one, other) = ((low - start) / step, (high - start) / step);
        enters = enters.max(one.min(other));
        leaves = leaves.min(one.max(other));
    }
    let at = |share: f64| match share {
        0.0 => from,
        1.0 => to,
        _ => crate::shapes::between(from, to, share),
    };
    (enters < leaves).then(|| (at(enters), at(leaves)))
}
