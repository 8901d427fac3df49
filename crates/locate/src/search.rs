//! Global search: each piece of a radar track, laid on each path, votes for where the radar is and how it is turned.
//!
//! With complex numbers for points over ground (east + i north), w of the path and z of the plots around the radar, w = t + z
//! exp(i b): t is the antenna, b the bearing. For one clock and one bearing a pair votes for one antenna. Correct pairs agree.

use std::collections::BTreeMap;

use nalgebra::{Complex, Vector2};

use crate::path::Path;
use crate::pieces::Piece;

/// A pose found by the search.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Candidate {
    /// Antenna, east and north, metres.
    pub(crate) antenna: Vector2<f64>,
    /// Bearing, radians.
    pub(crate) bearing: f64,
    /// Paths are compared this much later than plots, seconds.
    pub(crate) later_s: f64,
    pub(crate) votes: f64,
}

/// Steps and limits of the search.
const BEARING_STEP_DEG: f64 = 2.0;
const LATER_STEP_S: f64 = 1.0;
const LATEST_S: f64 = 10.0;
/// Size of a cell of votes, metres and as a share of the median range.
const CELL_M: f64 = 60.0;
const CELL_SHARE: f64 = 0.035;
/// Distance, after rotation and shift, between piece and path up to which the pair votes: metres and share of the range.
const SHAPE_M: f64 = 15.0;
const SHAPE_SHARE: f64 = 0.02;
/// Extent of a piece from which it counts in full, metres. A hovering drone votes for every bearing.
const EXTENT_M: f64 = 60.0;
/// Maximum number of pieces and paths that vote.
const PIECES: usize = 160;
const PATHS: usize = 40;
/// Number of candidates returned.
const CANDIDATES: usize = 48;
/// Candidates nearer than this to a better one are left out: bearing in degrees, seconds, and cells.
const APART: (f64, f64, f64) = (5.0, 1.5, 2.0);

/// A pair at one time shift.
struct Pair {
    piece: usize,
    mean_path: Complex<f64>,
    mean_plots: Complex<f64>,
    /// Sums of squares about the means, per plot.
    square: f64,
    /// Correlation of both curves, per plot.
    correlation: Complex<f64>,
    gate_m: f64,
    weight: f64,
}

/// Limits the search to poses near a guess: antenna, and radius in metres.
pub(crate) type Neighbourhood = (Vector2<f64>, f64);

/// The best candidates, best first. `ground` converts a plot to east + i north about the radar, with its north mark as north.
pub(crate) fn search(
    pieces: &[Piece],
    paths: &[Path],
    ground: impl Fn(f64, f64, Option<f64>) -> Complex<f64>,
    near: Option<Neighbourhood>,
) -> Vec<Candidate> {
    let chosen = chosen(pieces, &ground);
    let paths = most_reported(paths);
    let mut ranges: Vec<f64> = chosen.iter().map(|&(piece, _)| piece.plots[0].range_m).collect();
    ranges.sort_by(f64::total_cmp);
    let Some(&median_m) = ranges.get(ranges.len() / 2) else { return Vec::new() };
    let cell_m = CELL_M.max(CELL_SHARE * median_m);
    let bearings = (360.0 / BEARING_STEP_DEG) as usize;
    let shifts = (LATEST_S / LATER_STEP_S) as i32;
    let mut found = Vec::new();
    for shift in -shifts..=shifts {
        let later_s = f64::from(shift) * LATER_STEP_S;
        let pairs: Vec<Pair> = (chosen.iter().enumerate())
            .flat_map(|(index, (piece, points))| {
                let points = points.as_slice();
                paths.iter().filter_map(move |path| pair(index, piece, points, path, later_s))
            })
            .collect();
        for step in 0..bearings {
            let bearing = (step as f64 * BEARING_STEP_DEG).to_radians();
            let turn = Complex::from_polar(1.0, bearing);
            let cells = votes(&pairs, turn, cell_m, near);
            found.extend(peaks(&cells, cell_m).into_iter().map(|(antenna, votes)| Candidate {
                antenna,
                bearing,
                later_s,
                votes,
            }));
        }
    }
    best(found, cell_m)
}

/// The pieces with the largest extents, and their points around the radar.
fn chosen(
    pieces: &[Piece],
    ground: impl Fn(f64, f64, Option<f64>) -> Complex<f64>,
) -> Vec<(&Piece, Vec<Complex<f64>>)> {
    let points = |piece: &Piece| -> Vec<Complex<f64>> {
        piece.plots.iter().map(|plot| ground(plot.range_m, plot.azimuth, plot.height_m)).collect()
    };
    let mut chosen: Vec<_> = pieces.iter().map(|piece| (piece, points(piece))).collect();
    chosen.sort_by(|a, b| extent_m(&b.1).total_cmp(&extent_m(&a.1)));
    chosen.truncate(PIECES);
    chosen
}

fn extent_m(points: &[Complex<f64>]) -> f64 {
    (points[points.len() - 1] - points[0]).norm()
}

fn most_reported(paths: &[Path]) -> Vec<&Path> {
    let mut paths: Vec<&Path> = paths.iter().collect();
    paths.sort_by_key(|path| std::cmp::Reverse(path.len()));
    paths.truncate(PATHS);
    paths
}

/// Compares a piece with a path; `None` if the path has no position for most of its plots.
fn pair(index: usize, piece: &Piece, points: &[Complex<f64>], path: &Path, later_s: f64) -> Option<Pair> {
    let on_path: Vec<(Complex<f64>, Complex<f64>)> = (piece.plots.iter().zip(points))
        .filter_map(|(plot, &point)| {
            let there = path.at(plot.time_s + later_s)?.position;
            Some((Complex::new(there.x, there.y), point))
        })
        .collect();
    if on_path.len() < 3 || on_path.len() * 10 < points.len() * 6 {
        return None;
    }
    let count = on_path.len() as f64;
    let mean_path = on_path.iter().map(|both| both.0).sum::<Complex<f64>>() / count;
    let mean_plots = on_path.iter().map(|both| both.1).sum::<Complex<f64>>() / count;
    let (mut square, mut correlation) = (0.0, Complex::new(0.0, 0.0));
    for (w, z) in on_path {
        let (w, z) = (w - mean_path, z - mean_plots);
        square += (w.norm_sqr() + z.norm_sqr()) / count;
        correlation += z.conj() * w / count;
    }
    let gate_m = SHAPE_M + SHAPE_SHARE * mean_plots.norm();
    // The best rotation of all leaves this distance.
    if square - 2.0 * correlation.norm() > gate_m * gate_m {
        return None;
    }
    let extent = (extent_m(points) / EXTENT_M).min(1.0);
    let weight = piece.duration_s() * (0.1 + 0.9 * extent * extent);
    Some(Pair { piece: index, mean_path, mean_plots, square, correlation, gate_m, weight })
}

type Cells = BTreeMap<(i32, i32), f64>;

/// Votes by cell; a piece counts once per cell, with its best path.
fn votes(pairs: &[Pair], turn: Complex<f64>, cell_m: f64, near: Option<Neighbourhood>) -> Cells {
    let mut cells = Cells::new();
    let mut of_piece: Vec<((i32, i32), f64)> = Vec::new();
    for same in pairs.chunk_by(|a, b| a.piece == b.piece) {
        of_piece.clear();
        for pair in same {
            let left = pair.square - 2.0 * (turn.conj() * pair.correlation).re;
            let vote = pair.weight * (1.0 - left / (pair.gate_m * pair.gate_m));
            if vote <= 0.0 {
                continue;
            }
            let antenna = pair.mean_path - turn * pair.mean_plots;
            let is_near = near.is_none_or(|(guess, radius_m)| {
                (Vector2::new(antenna.re, antenna.im) - guess).norm() <= radius_m
            });
            if !is_near {
                continue;
            }
            let cell = ((antenna.re / cell_m).floor() as i32, (antenna.im / cell_m).floor() as i32);
            match of_piece.iter_mut().find(|of| of.0 == cell) {
                Some(of) => of.1 = of.1.max(vote),
                None => of_piece.push((cell, vote)),
            }
        }
        for &(cell, vote) in &of_piece {
            *cells.entry(cell).or_default() += vote;
        }
    }
    cells
}

/// The two best cells with their neighbours, as positions and sums of votes.
fn peaks(cells: &Cells, cell_m: f64) -> Vec<(Vector2<f64>, f64)> {
    let mut sums: Vec<(Vector2<f64>, f64)> = (cells.keys())
        .map(|&(east, north)| {
            let (mut sum, mut at) = (0.0, Vector2::zeros());
            for (by_east, by_north) in (-1..=1).flat_map(|e| (-1..=1).map(move |n| (e, n))) {
                let cell = (east + by_east, north + by_north);
                let share = 0.5_f64.powi(by_east.abs() + by_north.abs());
                let votes = share * cells.get(&cell).copied().unwrap_or(0.0);
                sum += votes;
                at += Vector2::new(f64::from(cell.0) + 0.5, f64::from(cell.1) + 0.5) * votes;
            }
            (at / sum * cell_m, sum)
        })
        .collect();
    sums.sort_by(|a, b| b.1.total_cmp(&a.1));
    sums.truncate(2);
    sums
}

/// The best candidates that are not beside a better one.
fn best(mut found: Vec<Candidate>, cell_m: f64) -> Vec<Candidate> {
    found.sort_by(|a, b| b.votes.total_cmp(&a.votes));
    let mut kept: Vec<Candidate> = Vec::new();
    for candidate in found {
        let is_beside = |other: &Candidate| {
            let turned = crate::pose::wrapped(candidate.bearing - other.bearing).abs().to_degrees();
            turned < APART.0
                && (candidate.later_s - other.later_s).abs() < APART.1
                && (candidate.antenna - other.antenna).norm() < APART.2 * cell_m
        };
        if !kept.iter().any(is_beside) {
            kept.push(candidate);
            if kept.len() == CANDIDATES {
                break;
            }
        }
    }
    kept
}
