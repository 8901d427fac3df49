//! Which piece of a radar track belongs to which path, at a given pose.

use crate::path::Path;
use crate::pieces::Piece;
use crate::pose::{Pose, residual};

/// Limits of an association.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Gate {
    /// Standard deviations of a plot: azimuth, radians, and slant range, metres.
    pub(crate) azimuth: f64,
    pub(crate) range_m: f64,
    /// Standard deviation of the pose over ground, metres; of both axes.
    pub(crate) ground_m: f64,
    /// Root mean square of the normalised distances up to which a piece belongs to a path.
    pub(crate) deviations: f64,
}

/// A piece that belongs to a path.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Match {
    pub(crate) piece: usize,
    pub(crate) path: usize,
    /// Mean square of the normalised distances, over that of the gate: 0 to 1.
    pub(crate) distance: f64,
}

/// Normalised distance above which a plot counts no further for its piece.
const CAPPED: f64 = 5.0;
/// Overlap of two tracks of one path that is permitted, seconds.
const OVERLAP_S: f64 = 2.0;

/// Each piece with at most one path, and at one time each path with one piece; the nearest first.
pub(crate) fn matches(pieces: &[Piece], paths: &[Path], pose: &Pose, gate: &Gate) -> Vec<Match> {
    let mut found: Vec<Match> = Vec::new();
    for (index, piece) in pieces.iter().enumerate() {
        let near = paths.iter().enumerate().filter_map(|(path, of)| {
            let distance = distance(piece, of, pose, gate)?;
            (distance < 1.0).then_some(Match { piece: index, path, distance })
        });
        found.extend(near);
    }
    found.sort_by(|a, b| {
        let key = |of: &Match| of.distance;
        key(a).total_cmp(&key(b)).then((a.piece, a.path).cmp(&(b.piece, b.path)))
    });
    let mut is_taken = vec![false; pieces.len()];
    let mut of_path: Vec<Vec<(f64, f64)>> = vec![Vec::new(); paths.len()];
    let mut kept = Vec::new();
    for one in found {
        let (from_s, to_s) = pieces[one.piece].span_s();
        let overlaps = |&(other_from_s, other_to_s): &(f64, f64)| {
            to_s.min(other_to_s) - from_s.max(other_from_s) > OVERLAP_S
        };
        if is_taken[one.piece] || of_path[one.path].iter().any(overlaps) {
            continue;
        }
        is_taken[one.piece] = true;
        of_path[one.path].push((from_s, to_s));
        kept.push(one);
    }
    kept.sort_by_key(|one| (one.piece, one.path));
    kept
}

/// Mean square distance over the gate's; `None` if the path is unknown at most of the plots.
fn distance(piece: &Piece, path: &Path, pose: &Pose, gate: &Gate) -> Option<f64> {
    let (mut sum, mut count) = (0.0, 0_usize);
    for plot in &piece.plots {
        let Some(point) = path.at(plot.time_s + pose.later_s) else { continue };
        let of = residual(plot, &point, pose)?;
        let ground_m = gate.ground_m.hypot(point.sigma_m);
        let azimuth = of.azimuth.powi(2) / (gate.azimuth.powi(2) + (ground_m / of.over_ground_m).powi(2));
        let range = of.range_m.powi(2) / (gate.range_m.powi(2) + ground_m * ground_m);
        sum += ((azimuth + range) / 2.0).min(CAPPED * CAPPED);
        count += 1;
    }
    let is_known = count >= 3 && count * 10 >= piece.plots.len() * 6;
    is_known.then(|| sum / count as f64 / (gate.deviations * gate.deviations))
}
