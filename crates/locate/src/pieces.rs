//! Radar tracks in pieces of a few seconds: the unit of association.

use std::collections::BTreeMap;

/// A plot with its time in seconds since the recording's beginning.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TimedPlot {
    pub(crate) track: u16,
    pub(crate) time_s: f64,
    pub(crate) range_m: f64,
    pub(crate) azimuth: f64,
    /// Measured height above the ellipsoid, metres.
    pub(crate) height_m: Option<f64>,
}

/// Consecutive plots of one track.
#[derive(Clone, Debug)]
pub(crate) struct Piece {
    pub(crate) plots: Vec<TimedPlot>,
    /// Number of the uninterrupted track.
    pub(crate) run: usize,
}

impl Piece {
    pub(crate) fn span_s(&self) -> (f64, f64) {
        (self.plots[0].time_s, self.plots[self.plots.len() - 1].time_s)
    }

    pub(crate) fn duration_s(&self) -> f64 {
        let (from_s, to_s) = self.span_s();
        to_s - from_s
    }
}

/// Interval to which plots are thinned, seconds: errors of a track hardly change within it.
const THINNED_S: f64 = 0.7;
/// Silence that ends a track, seconds: the number may then be another target's.
const SILENCE_S: f64 = 6.0;
/// Maximum duration of a piece, seconds.
const LONGEST_S: f64 = 12.0;
/// Minimum duration and number of plots of a piece.
const SHORTEST_S: f64 = 3.0;
const FEWEST: usize = 3;

/// Pieces of all tracks, by time of their first plot.
pub(crate) fn pieces(mut plots: Vec<TimedPlot>) -> Vec<Piece> {
    plots.sort_by(|a, b| a.time_s.total_cmp(&b.time_s).then(a.track.cmp(&b.track)));
    let mut tracks: BTreeMap<u16, Vec<TimedPlot>> = BTreeMap::new();
    for plot in plots {
        let track = tracks.entry(plot.track).or_default();
        if track.last().is_none_or(|last| plot.time_s - last.time_s >= THINNED_S) {
            track.push(plot);
        }
    }
    let mut pieces: Vec<Piece> = Vec::new();
    let mut run = 0;
    for track in tracks.into_values() {
        for unbroken in track.chunk_by(|a, b| b.time_s - a.time_s <= SILENCE_S) {
            run += 1;
            let duration_s = unbroken[unbroken.len() - 1].time_s - unbroken[0].time_s;
            let count = (duration_s / LONGEST_S).ceil().max(1.0);
            let length_s = duration_s / count + 1e-6;
            let part = |plot: &TimedPlot| ((plot.time_s - unbroken[0].time_s) / length_s) as usize;
            for plots in unbroken.chunk_by(|a, b| part(a) == part(b)) {
                let piece = Piece { plots: plots.to_vec(), run };
                if piece.plots.len() >= FEWEST && piece.duration_s() >= SHORTEST_S {
                    pieces.push(piece);
                }
            }
        }
    }
    pieces.sort_by(|a, b| a.span_s().0.total_cmp(&b.span_s().0).then(a.run.cmp(&b.run)));
    pieces
}
