//! Residual misalignment of a radar after registration, as vectors over azimuth and elevation, after Figure 13 of
//! Fasano et al. (2010), with the root mean square of their Figure 12.

use std::collections::BTreeMap;

use super::super::residuals::{AngularResidual, PlotResidual, RadarResiduals};
use super::axis::{PlotAxis, decimal, drawable, round_step, span};
use super::chart::Chart;
use super::figure::{Figure, caption, counted};
use super::style::{Marker, Scale, Style};

const SIZE: (f64, f64) = (600.0, 260.0);

/// Number of cells per axis.
const CELLS: (f64, f64) = (18.0, 6.0);

/// Minimum number of plots for a mean.
const MEAN_OF: usize = 20;

const BEFORE: Style = Style { marker: Marker::Square, colour: "#ecab38", line_colour: "#b3760a", dash: "" };
const AFTER: Style = Style { marker: Marker::Dot, colour: "#154f9c", line_colour: "#052c5c", dash: "" };

/// Residuals of each radar, one chart below the other.
pub(super) fn registration(radars: &[RadarResiduals]) -> Figure {
    let charts: Vec<_> = radars.iter().map(chart).collect();
    let mut sentences = vec![
        "Mean residual of azimuth and elevation in each cell of the radar's field of view with 20 plots or more, as a vector from the true \
         direction, before and after the plots are corrected by the registration; what all have in common is \
         misalignment that is left."
            .to_owned(),
    ];
    sentences.extend(radars.iter().zip(&charts).map(|(radar, (_, times, _))| said(radar, *times)));
    if radars.is_empty() {
        let chart = Chart::new(azimuths(0.0, 360.0), elevations(0.0, 10.0), SIZE);
        sentences.truncate(1);
        return Chart::stacked(
            NAME,
            TITLE,
            caption(&sentences),
            &[(chart, Some("no point: no radar is registered"))],
        );
    }
    let charts: Vec<_> = charts.into_iter().map(|(chart, _, note)| (chart, note)).collect();
    Chart::stacked(NAME, TITLE, caption(&sentences), &charts)
}

const NAME: &str = "registration-residuals";
const TITLE: &str = "Residuals of azimuth and elevation before and after registration";

fn azimuths(from: f64, to: f64) -> PlotAxis {
    PlotAxis::linear("Azimuth from the radar (°)", from, to)
}

fn elevations(from: f64, to: f64) -> PlotAxis {
    PlotAxis::linear("Elevation (°)", from, to)
}

/// Chart of a radar, magnification of its residuals, and the note inside the chart.
fn chart(radar: &RadarResiduals) -> (Chart, f64, Option<&'static str>) {
    let plots: Vec<_> = radar.plots.iter().filter(|plot| drawable(plot.azimuth_deg)).collect();
    let mut azimuth: Vec<f64> = plots.iter().map(|plot| plot.azimuth_deg).collect();
    let mut elevation: Vec<f64> = plots.iter().map(|plot| plot.elevation_deg).collect();
    let Some((x, y)) = span(&mut azimuth).zip(span(&mut elevation)) else {
        let chart = Chart::new(azimuths(0.0, 360.0), elevations(0.0, 10.0), SIZE);
        return (chart, 1.0, Some("no point of a drone with a measured height"));
    };
    let padded = |(low, high): (f64, f64), least: f64| {
        let pad = 0.12 * (high - low).max(least);
        (low - pad, high + pad)
    };
    let (x, y) = (padded(x, 10.0), padded(y, 4.0));
    let cell = ((x.1 - x.0) / CELLS.0, (y.1 - y.0) / CELLS.1);
    let mut cells = BTreeMap::<(i64, i64), Vec<&PlotResidual>>::new();
    for plot in plots {
        let place = (plot.azimuth_deg / cell.0, plot.elevation_deg / cell.1);
        cells.entry((place.0.floor() as i64, place.1.floor() as i64)).or_default().push(plot);
    }
    cells.retain(|_, plots| plots.len() >= MEAN_OF);
    let means: Vec<_> = cells
        .values()
        .map(|plots| {
            let mean = |of: fn(&PlotResidual) -> f64| {
                plots.iter().map(|plot| of(plot)).sum::<f64>() / plots.len() as f64
            };
            let at = (mean(|plot| plot.azimuth_deg), mean(|plot| plot.elevation_deg));
            let before = (mean(|plot| plot.before.azimuth_deg), mean(|plot| plot.before.elevation_deg));
            let after = (mean(|plot| plot.after.azimuth_deg), mean(|plot| plot.after.elevation_deg));
            (at, before, after)
        })
        .collect();
    // One magnification for both axes, so that a typical vector spans about one cell.
    let mut lengths: Vec<f64> =
        means.iter().map(|(_, before, _)| (before.0 / cell.0).hypot(before.1 / cell.1)).collect();
    lengths.sort_unstable_by(f64::total_cmp);
    let usual = input::statistics::quantile(&lengths, 0.5).unwrap_or(1.0).max(1e-3);
    let times = (round_step(1.0 / usual) / 2.0).clamp(0.5, 100.0);
    let mut chart = Chart::new(azimuths(x.0, x.1), elevations(y.0, y.1), SIZE);
    for (style, of_after) in [(BEFORE, false), (AFTER, true)] {
        let lines: Vec<Vec<(f64, f64)>> = means
            .iter()
            .map(|(at, before, after)| {
                let by = if of_after { after } else { before };
                vec![*at, (at.0 + times * by.0, at.1 + times * by.1)]
            })
            .collect();
        chart.lines(&style, &lines, false);
    }
    let at: Vec<_> = means.iter().map(|(at, _, _)| chart.place(*at)).collect();
    chart.markers(Marker::Dot, Scale::Large, "#000", &at);
    chart.key_marker(Marker::Dot, "#000", "true direction");
    chart.key_line(&BEFORE, 1.6, false, "before");
    chart.key_line(&AFTER, 1.6, false, "after");
    let note = means.is_empty().then_some("no cell has twenty plots: no point");
    (chart, times, note)
}

/// Sentence with the numbers of a radar.
fn said(radar: &RadarResiduals, times: f64) -> String {
    if radar.plots.is_empty() {
        return format!("{}: no plots.", radar.radar);
    }
    let count = radar.plots.len() as f64;
    let mean = |of: fn(&PlotResidual) -> f64| radar.plots.iter().map(of).sum::<f64>() / count;
    let rms = |of: fn(&PlotResidual) -> &AngularResidual| {
        let squares = radar.plots.iter().map(|plot| of(plot).angle_deg.powi(2));
        decimal((squares.sum::<f64>() / count).sqrt(), 2)
    };
    let bias =
        |azimuth: f64, elevation: f64| format!("{}° and {}°", decimal(azimuth, 2), decimal(elevation, 2));
    format!(
        "{}: {} plots, {} tracks; angle between measured and true direction {}° before and {}° after (root mean square); mean \
         of azimuth and elevation {} before, {} after; vectors {} times as long.",
        radar.radar,
        counted(radar.plots.len()),
        decimal(radar.tracks, 1),
        rms(|plot| &plot.before),
        rms(|plot| &plot.after),
        bias(mean(|plot| plot.before.azimuth_deg), mean(|plot| plot.before.elevation_deg)),
        bias(mean(|plot| plot.after.azimuth_deg), mean(|plot| plot.after.elevation_deg)),
        decimal(times, usize::from(times.fract() > 0.0)),
    )
}
