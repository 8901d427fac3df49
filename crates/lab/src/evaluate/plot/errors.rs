//! Errors over time, range and azimuth (the paper's Figures 11, 12 and 13), and their distribution.
//!
//! The error axis is always logarithmic: errors of a radar, a transponder and a seduced track differ by orders of
//! magnitude. On a linear axis, a few outliers would hide the rest.

use std::collections::BTreeMap;

use super::super::types::{ErrorSample, PolarPlace};
use super::axis::{PlotAxis, decimal, drawable, round_step};
use super::chart::Chart;
use super::figure::{Figure, PlotClock, PlotStream, caption, counted, thinned};
use super::style::Scale;
use input::statistics::quantile;

const SIZE: (f64, f64) = (600.0, 300.0);
const ERROR: &str =
    "Position error: distance in space to the drone's true place, horizontal where a height is not known.";
const NO_POINTS: &str = "no point belongs to a drone";
const NO_SITE: &str = "no point is seen from a known radar";

/// Smaller errors are drawn as this value, metres, to bound the logarithmic axis.
const ERROR_MIN: f64 = 1e-3;

/// Minimum number of points for a median.
const MEDIAN_OF: usize = 5;

/// Horizontal axis of an error figure.
struct Over {
    name: &'static str,
    title: &'static str,
    x: PlotAxis,
    /// Width of the intervals for medians, in units of x; `bin_said` states it in words.
    bin: f64,
    bin_said: String,
    /// Text of an empty figure.
    nothing: &'static str,
}

/// Error over time, as in the paper's Figure 11.
pub(super) fn over_time(streams: &[PlotStream<'_>], clock: PlotClock) -> Figure {
    let points = points_over(streams, |sample| Some(clock.minutes(sample.time)));
    let (first, last) = ends(&points).unwrap_or((0.0, 1.0));
    let bin = round_step(((last - first) / 40.0).max(1.0 / 60.0));
    let over = Over {
        name: "error-over-time",
        title: "Position error over time",
        x: PlotAxis::linear(clock.label(), first, last),
        bin,
        bin_said: format!("{} s", decimal(bin * 60.0, usize::from(bin < 0.1))),
        nothing: NO_POINTS,
    };
    scatter(over, streams, &points)
}

/// Error over the distance from the radar, as in the paper's Figure 12.
pub(super) fn over_range(streams: &[PlotStream<'_>]) -> Figure {
    let points = points_over(streams, |sample| sample.seen.map(|PolarPlace { range_m, .. }| range_m));
    let (nearest, farthest) = ends(&points).unwrap_or((0.0, 1000.0));
    // Include the radar itself if that takes little space.
    let nearest = if nearest < 0.3 * farthest { 0.0 } else { nearest };
    let bin = round_step(((farthest - nearest) / 30.0).max(1.0));
    let over = Over {
        name: "error-over-range",
        title: "Position error over range",
        x: PlotAxis::linear("Range of the drone from the radar (m)", nearest, farthest),
        bin,
        bin_said: format!("{} m", decimal(bin, 0)),
        nothing: NO_SITE,
    };
    scatter(over, streams, &points)
}

/// Error over the direction from the radar, as in the paper's Figure 13.
pub(super) fn over_azimuth(streams: &[PlotStream<'_>]) -> Figure {
    let points = points_over(streams, |sample| sample.seen.map(|PolarPlace { azimuth_deg, .. }| azimuth_deg));
    let over = Over {
        name: "error-over-azimuth",
        title: "Position error over azimuth",
        x: PlotAxis::stepped(
            "Azimuth of the drone from the radar (°, clockwise from north)",
            0.0,
            360.0,
            Some(45.0),
        ),
        bin: 10.0,
        bin_said: "10°".to_owned(),
        nothing: NO_SITE,
    };
    scatter(over, streams, &points)
}

/// For each stream, the points that have an x and an error.
fn points_over(streams: &[PlotStream<'_>], x: impl Fn(&ErrorSample) -> Option<f64>) -> Vec<Vec<(f64, f64)>> {
    let point = |sample: &ErrorSample| Some((x(sample)?, sample.error?.distance_m().max(ERROR_MIN)));
    let usable = |(x, error): &(f64, f64)| drawable(*x) && drawable(*error);
    streams.iter().map(|stream| stream.samples.iter().filter_map(point).filter(usable).collect()).collect()
}

/// Axis for all errors except the smallest half percent of each stream.
fn error_axis(sorted: &[Vec<f64>]) -> PlotAxis {
    let low = sorted.iter().filter_map(|errors| quantile(errors, 0.005)).min_by(f64::total_cmp);
    let high = sorted.iter().filter_map(|errors| quantile(errors, 1.0)).max_by(f64::total_cmp);
    let (low, high) = low.zip(high).unwrap_or((1.0, 100.0));
    PlotAxis::logarithmic("Position error (m)", low, high)
}

/// Errors of each stream, sorted.
fn sorted_errors(points: &[Vec<(f64, f64)>]) -> Vec<Vec<f64>> {
    let sorted = |points: &Vec<(f64, f64)>| {
        let mut errors: Vec<f64> = points.iter().map(|(_, error)| *error).collect();
        errors.sort_unstable_by(f64::total_cmp);
        errors
    };
    points.iter().map(sorted).collect()
}

/// Lowest and highest x.
fn ends(points: &[Vec<(f64, f64)>]) -> Option<(f64, f64)> {
    let xs = || points.iter().flatten().map(|(x, _)| *x);
    Some((xs().min_by(f64::total_cmp)?, xs().max_by(f64::total_cmp)?))
}

/// Points of all streams with their running medians.
fn scatter(over: Over, streams: &[PlotStream<'_>], points: &[Vec<(f64, f64)>]) -> Figure {
    let mut chart = Chart::new(over.x, error_axis(&sorted_errors(points)), SIZE);
    let (mut below, mut any_thinned) = (0, false);
    // The output is drawn last, over its inputs; its medians are drawn over everything.
    for (stream, points) in streams.iter().zip(points).rev() {
        let drawn = chart.points(&stream.style, points);
        below += drawn.outside;
        any_thinned |= drawn.thinned;
    }
    for (stream, points) in streams.iter().zip(points).rev() {
        chart.lines(&stream.style, &medians(points, over.bin), true);
    }
    for (stream, points) in streams.iter().zip(points) {
        if !points.is_empty() {
            chart.key_line(&stream.style, 1.6, true, stream.name);
        }
    }
    let count: usize = points.iter().map(Vec::len).sum();
    if count == 0 {
        let text = caption(&[ERROR.to_owned(), format!("There is nothing to show: {}.", over.nothing)]);
        return chart.finish(over.name, over.title, text, Some(over.nothing));
    }
    let text = caption(&[
        ERROR.to_owned(),
        format!("Lines: median of each {} with {MEDIAN_OF} points or more.", over.bin_said),
        if below == 0 {
            String::new()
        } else {
            format!("{} of {} points lie below the axis.", counted(below), counted(count))
        },
        thinned(any_thinned),
    ]);
    chart.finish(over.name, over.title, text, None)
}

/// Medians of the intervals, each at the mean x of its points. The lines are interrupted where an interval has too few
/// points.
fn medians(points: &[(f64, f64)], bin: f64) -> Vec<Vec<(f64, f64)>> {
    let mut bins: BTreeMap<i64, (f64, Vec<f64>)> = BTreeMap::new();
    for (x, error) in points {
        let (sum, errors) = bins.entry((x / bin).floor() as i64).or_default();
        *sum += x;
        errors.push(*error);
    }
    let mut lines: Vec<Vec<(f64, f64)>> = Vec::new();
    let mut previous = None;
    for (number, (sum, mut errors)) in bins {
        if errors.len() < MEDIAN_OF {
            continue;
        }
        errors.sort_unstable_by(f64::total_cmp);
        let Some(median) = quantile(&errors, 0.5) else { continue };
        let point = (sum / errors.len() as f64, median);
        match lines.last_mut() {
            Some(line) if previous == Some(number - 1) => line.push(point),
            _ => lines.push(vec![point]),
        }
        previous = Some(number);
    }
    lines
}

/// Cumulative distribution of the errors of each stream.
pub(super) fn distribution(streams: &[PlotStream<'_>]) -> Figure {
    const CORNERS: usize = 400;
    let sorted = sorted_errors(&points_over(streams, |_| Some(0.0)));
    let shares = PlotAxis::stepped("Points with at most this error (%)", 0.0, 100.0, Some(20.0));
    let mut chart = Chart::new(error_axis(&sorted), shares, SIZE);
    chart.level(50.0);
    chart.level(95.0);
    let filled = || streams.iter().zip(&sorted).filter(|(_, errors)| !errors.is_empty());
    for (stream, errors) in filled().rev() {
        let corners = CORNERS.min(errors.len() - 1).max(1);
        let at = |share: f64| Some((quantile(errors, share)?, 100.0 * share));
        let curve = (0..=corners).filter_map(|corner| at(corner as f64 / corners as f64)).collect();
        chart.lines(&stream.style, &[curve], false);
        let marks: Vec<_> = [0.5, 0.95].into_iter().filter_map(at).map(|mark| chart.place(mark)).collect();
        chart.markers(stream.style.marker, Scale::Large, stream.style.line_colour, &marks);
    }
    for (stream, _) in filled() {
        chart.key_line(&stream.style, 1.6, true, stream.name);
    }
    let nothing = filled().next().is_none();
    let how = if nothing {
        format!("There is nothing to show: {NO_POINTS}.")
    } else {
        "Marked: the median and the 95th percentile of each stream.".to_owned()
    };
    let text = caption(&[ERROR.to_owned(), how]);
    chart.finish(
        "error-distribution",
        "Distribution of the position error",
        text,
        nothing.then_some(NO_POINTS),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn median_line_breaks_at_sparse_points() {
        let at = |x: f64, errors: &[f64]| errors.iter().map(|error| (x, *error)).collect::<Vec<_>>();
        let full = [9.0, 1.0, 3.0, 2.0, 800.0];
        let points = [at(3.0, &full), at(14.0, &full), at(25.0, &full[1..]), at(39.0, &full)].concat();
        assert_eq!(medians(&points, 10.0), [vec![(3.0, 3.0), (14.0, 3.0)], vec![(39.0, 3.0)]]);
    }
}
