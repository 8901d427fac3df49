//! Lines and rings from few numbers.

use std::f64::consts::TAU;

use crate::feature::Place;

/// Length of the pieces of a curve, metres.
const PIECE_M: f64 = 60.0;

/// A number from 0 to 1 that depends on a key only (SplitMix64).
pub fn chance(key: u64) -> f64 {
    let mut mixed = key.wrapping_add(1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    mixed = (mixed ^ (mixed >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    (mixed ^ (mixed >> 31)) as f64 / u64::MAX as f64
}

/// Distance of two places, metres.
pub fn apart([ax, ay]: Place, [bx, by]: Place) -> f64 {
    (ax - bx).hypot(ay - by)
}

/// The place between two, at a share of the way.
pub fn between([ax, ay]: Place, [bx, by]: Place, share: f64) -> Place {
    [ax + (bx - ax) * share, ay + (by - ay) * share]
}

/// A smooth curve through the places (Catmull–Rom spline).
pub fn curve(through: &[Place]) -> Vec<Place> {
    let at = |index: usize| through[index.min(through.len() - 1)];
    let mut line = vec![through[0]];
    for index in 0..through.len() - 1 {
        let [a, b, c, d] = [at(index.saturating_sub(1)), at(index), at(index + 1), at(index + 2)];
        let pieces = (apart(b, c) / PIECE_M).ceil().max(1.0) as usize;
        for piece in 1..=pieces {
            let t = piece as f64 / pieces as f64;
            line.push([0, 1].map(|axis| {
                let (a, b, c, d) = (a[axis], b[axis], c[axis], d[axis]);
                let bend = (2.0 * a - 5.0 * b + 4.0 * c - d) + (3.0 * b - a - 3.0 * c + d) * t;
                0.5 * (2.0 * b + (c - a + bend * t) * t)
            }));
        }
    }
    line
}

/// The line moved to the left by a distance that may differ along it, metres.
pub fn beside(line: &[Place], distance_m: impl Fn(usize) -> f64) -> Vec<Place> {
    let moved = |index: usize| {
        let [before, behind] = [line[index.saturating_sub(1)], line[(index + 1).min(line.len() - 1)]];
        let length = apart(before, behind);
        let [along, across] = [behind[0] - before[0], behind[1] - before[1]].map(|part| part / length);
        let [x, y] = line[index];
        [x - across * distance_m(index), y + along * distance_m(index)]
    };
    (0..line.len()).map(moved).collect()
}

/// The area along a line, with a width that varies by a fifth, metres.
pub fn band(line: &[Place], width_m: f64, key: u64) -> Vec<Place> {
    let half = |side: u64| {
        move |index: usize| width_m * (0.4 + 0.2 * chance(key ^ (side << 40) ^ ((index / 3) as u64)))
    };
    let mut ring = beside(line, half(1));
    let right = half(2);
    ring.extend(beside(line, move |index| -right(index)).into_iter().rev());
    ring
}

/// A rounded area about a place with an irregular edge.
pub fn blob([x, y]: Place, radius_m: f64, key: u64) -> Vec<Place> {
    let lobe = |number: u64, waves: f64, size: f64| {
        let phase = TAU * chance(key.wrapping_mul(31) + number);
        move |angle: f64| size * (waves * angle + phase).sin()
    };
    let lobes = [lobe(1, 2.0, 0.22), lobe(2, 3.0, 0.14), lobe(3, 7.0, 0.05)];
    let corners = 36;
    (0..corners)
        .map(|corner| {
            let angle = TAU * f64::from(corner) / f64::from(corners);
            let radius = radius_m * (1.0 + lobes.iter().map(|lobe| lobe(angle)).sum::<f64>());
            [x + radius * angle.cos(), y + radius * angle.sin()]
        })
        .collect()
}

/// A rectangle about a place: length along a bearing in degrees, width across it, metres.
pub fn rectangle([x, y]: Place, length_m: f64, width_m: f64, bearing_deg: f64) -> Vec<Place> {
    let (east, north) = bearing_deg.to_radians().sin_cos();
    [(1.0, 1.0), (1.0, -1.0), (-1.0, -1.0), (-1.0, 1.0)]
        .map(|(along, across)| {
            let (along, across) = (along * length_m / 2.0, across * width_m / 2.0);
            [x + along * east + across * north, y + along * north - across * east]
        })
        .to_vec()
}

/// Distance of a place from a line, metres.
pub fn distance_to(line: &[Place], [x, y]: Place) -> f64 {
    let of = |pair: &[Place]| {
        let [[ax, ay], [bx, by]] = [pair[0], pair[1]];
        let (dx, dy) = (bx - ax, by - ay);
        let share = (((x - ax) * dx + (y - ay) * dy) / (dx * dx + dy * dy)).clamp(0.0, 1.0);
        apart([x, y], between([ax, ay], [bx, by], share))
    };
    line.windows(2).map(of).fold(f64::INFINITY, f64::min)
}
