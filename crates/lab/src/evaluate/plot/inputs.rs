//! Inputs of the output: the radar's plots by track number (the paper's Figure 9), and distances between radar and
//! transponder compared with the association threshold (Figure 6).

use std::collections::BTreeMap;

use super::super::types::{ErrorSample, PointSource};
use super::Setting;
use super::axis::{PlotAxis, drawable};
use super::chart::Chart;
use super::figure::{Figure, PlotClock, PlotStream, TruthLine, caption, counted, thinned};
use super::flat::Flat;
use super::space::{NOTHING, PlanView, height_frame, plan_frame};
use super::style::{FALSE, Marker, Scale, Style};
use super::thin::POINTS_MAX;
use input::statistics::quantile;

const SIZE: (f64, f64) = (600.0, 300.0);

/// Maximum time between a plot and a transponder position that are compared, nanoseconds: half a slot.
const APART: i64 = 125_000_000;

/// Colours of track numbers from low to high: dark to light, so that they can be distinguished in grey and by the
/// colour-blind.
const NUMBERS: [&str; 9] =
    ["#440154", "#472d7b", "#3b528b", "#2c728e", "#21918c", "#28ae80", "#5ec962", "#a5d52d", "#e3c51b"];

/// Dash of true paths: dotted, as in the paper.
const DOTTED: &str = "1 2.4";

/// Plots by track number: plan view, and height over time.
pub(super) fn radar_tracks(streams: &[PlotStream<'_>], truth: &[TruthLine<'_>], clock: PlotClock) -> Figure {
    const NAME: &str = "radar-tracks";
    const TITLE: &str = "Radar plots by track number";
    let without_radar =
        PlotStream { name: "radar plots", style: Style::of(PointSource::Radar), samples: &[] };
    let radar = streams.iter().find(|stream| stream.style.is(PointSource::Radar)).unwrap_or(&without_radar);
    let mut numbers: Vec<u32> = radar.samples.iter().map(|sample| sample.number).collect();
    numbers.sort_unstable();
    numbers.dedup();
    let flat = Flat::of(streams, truth);
    let above = PlanView::of(radar, truth, |_, place| flat.position(place));
    let aside = PlanView::of(radar, truth, |time, place| Some((clock.minutes(time), place.altitude_amsl_m?)));
    let extent = above.extent(|point| point.0).zip(above.extent(|point| point.1));
    let (x, y) = extent.unwrap_or(((-500.0, 500.0), (-300.0, 300.0)));
    let with_radar = flat.from_radar;
    let to_zero = |side: (f64, f64)| if with_radar { (side.0.min(0.0), side.1.max(0.0)) } else { side };
    let mut plan = plan_frame(to_zero(x), to_zero(y), if with_radar { "radar" } else { "centre" });
    let mut height = height_frame(&aside, clock);
    // The colours share the maximum number of points of a figure.
    let each = radar.samples.len().div_ceil(POINTS_MAX).max(1);
    let (mut outside, mut any_thinned) = (0, false);
    for (step, colour) in NUMBERS.iter().enumerate() {
        let is_of = |sample: &&ErrorSample| {
            let rank = numbers.partition_point(|&number| number < sample.number);
            rank * NUMBERS.len() / numbers.len().max(1) == step
        };
        let own = || radar.samples.iter().step_by(each).filter(is_of);
        let style = Style { marker: Marker::Dot, colour, line_colour: colour, dash: "" };
        let seen = |(x, y): &(f64, f64)| drawable(*x) && drawable(*y);
        let plan_points: Vec<_> =
            own().filter_map(|sample| flat.position(&sample.place)).filter(seen).collect();
        let time_points: Vec<_> = own()
            .filter_map(|sample| Some((clock.minutes(sample.time), sample.place.altitude_amsl_m?)))
            .filter(seen)
            .collect();
        let drawn = [plan.points(&style, &plan_points), height.points(&style, &time_points)];
        outside += drawn[0].outside;
        any_thinned |= drawn.iter().any(|drawn| drawn.thinned);
        if !numbers.is_empty() {
            let text = match step {
                0 => "lowest track number",
                _ if step + 1 == NUMBERS.len() => "highest",
                _ => "",
            };
            plan.key_marker(Marker::Dot, colour, text);
        }
    }
    let coarse = above.draw_truth(&mut plan, 1.1, "#000", DOTTED);
    let coarse = aside.draw_truth(&mut height, 1.1, "#000", DOTTED) || coarse;
    if !truth.is_empty() {
        let text = if truth.len() == 1 { "true path" } else { "true paths" };
        plan.key_line(&Style { line_colour: "#000", dash: DOTTED, ..FALSE }, 1.1, false, text);
    }
    if with_radar {
        let place = plan.place((0.0, 0.0));
        plan.markers(Marker::Radar, Scale::Large, "#000", &[place]);
        plan.key_marker(Marker::Radar, "#000", "radar");
    }
    let text = caption(&[
        "Plots from above, one scale on both axes, and their height over time; the colour is that of their track number, \
         which grows with time."
            .to_owned(),
        match (numbers.first(), numbers.last()) {
            (Some(first), Some(last)) => format!(
                "{} plots of {} tracks, numbers {} to {}.",
                counted(radar.samples.len()),
                counted(numbers.len()),
                counted(*first as usize),
                counted(*last as usize)
            ),
            _ => "There are no radar plots.".to_owned(),
        },
        if each == 1 { String::new() } else { format!("One plot of {each} is drawn.") },
        if outside == 0 { String::new() } else { format!("{} lie outside.", counted(outside)) },
        thinned(any_thinned),
        if coarse { "The true paths are simplified.".to_owned() } else { String::new() },
    ]);
    let note = extent.is_none().then_some(NOTHING);
    Chart::stacked(NAME, TITLE, text, &[(plan, note), (height, note)])
}

/// Distances between radar and transponder over slant range, and the threshold.
pub(super) fn threshold(streams: &[PlotStream<'_>], setting: &Setting<'_>) -> Figure {
    const NAME: &str = "threshold";
    const TITLE: &str = "Distance of radar and transponder, and the threshold";
    let pairs = RangePairs::of(streams, setting);
    let farthest = pairs.points().map(|point| point.0).fold(0.0, f64::max);
    let (farthest, threshold) = (if farthest > 0.0 { farthest } else { 1000.0 }, setting.threshold);
    let widest = threshold.map_or(100.0, |threshold| threshold.at(farthest));
    let mut own: Vec<f64> = pairs.own.iter().map(|pair| pair.1).collect();
    own.sort_unstable_by(f64::total_cmp);
    let most = quantile(&own, 0.99).unwrap_or(0.0).min(3.0 * widest).max(1.5 * widest);
    let mut chart = Chart::new(
        PlotAxis::linear("Slant range of the plot (m)", 0.0, farthest),
        PlotAxis::linear("Distance of radar and transponder (m)", 0.0, most),
        SIZE,
    );
    let other = Style { colour: "#999", ..FALSE };
    let same = Style::of(PointSource::Fused);
    let drawn = [chart.points(&other, &pairs.others), chart.points(&same, &pairs.own)];
    if let Some(threshold) = threshold {
        let corners = threshold.corners().filter(|corner| *corner < farthest);
        let ranges = std::iter::once(0.0).chain(corners.filter(|corner| *corner > 0.0)).chain([farthest]);
        let line = ranges.map(|range| (range, threshold.at(range))).collect();
        chart.lines(&BLACK, &[line], false);
    }
    if !pairs.own.is_empty() {
        chart.key_marker(same.marker, same.colour, "of one drone");
    }
    if !pairs.others.is_empty() {
        chart.key_marker(other.marker, other.colour, "of two objects");
    }
    if threshold.is_some() {
        chart.key_line(&BLACK, 1.6, false, "threshold D(ρ)");
    }
    let share = |points: &[(f64, f64)], what: &str| {
        let within = points.iter().filter(|(range, apart)| threshold.is_some_and(|d| *apart <= d.at(*range)));
        let within = within.count();
        if points.is_empty() || threshold.is_none() {
            return String::new();
        }
        format!("Within the threshold: {} of {} {what}.", counted(within), counted(points.len()))
    };
    let text = caption(&[
        "Distance of a plot to the transponder of its drone, and of each plot to the nearest other transponder, at the \
         same time; horizontal where the plot has no height."
            .to_owned(),
        share(&pairs.own, "pairs of one drone"),
        share(&pairs.others, "pairs of two objects"),
        match drawn.iter().map(|drawn| drawn.outside).sum() {
            0 => String::new(),
            outside => format!("{} lie above the axis.", counted(outside)),
        },
        thinned(drawn.iter().any(|drawn| drawn.thinned)),
    ]);
    let note = if setting.site.is_none() {
        Some("no point: the place of the radar is not known")
    } else {
        pairs.points().next().is_none().then_some("no point of a radar with a transponder beside it")
    };
    chart.finish(NAME, TITLE, text, note)
}

/// Style of the threshold.
const BLACK: Style = Style { marker: Marker::Dot, colour: "#000", line_colour: "#000", dash: "" };

/// Pairs of slant range and distance, metres.
#[derive(Default)]
struct RangePairs {
    /// A plot and the transponder of the same drone.
    own: Vec<(f64, f64)>,
    /// A plot and the nearest transponder of another drone.
    others: Vec<(f64, f64)>,
}

impl RangePairs {
    fn of(streams: &[PlotStream<'_>], setting: &Setting<'_>) -> Self {
        let samples =
            |source| streams.iter().find(|stream| stream.style.is(source)).map(|stream| stream.samples);
        let (Some(plots), Some(fixes), Some(site)) =
            (samples(PointSource::Radar), samples(PointSource::Transponder), setting.site)
        else {
            return Self::default();
        };
        let mut slots = BTreeMap::<i64, Vec<&ErrorSample>>::new();
        for fix in fixes {
            slots.entry(fix.time.nanos()).or_default().push(fix);
        }
        let mut pairs = Self::default();
        for plot in plots {
            let time = plot.time.nanos();
            let near = slots.range(time.saturating_sub(APART)..=time.saturating_add(APART));
            let Some((_, fixes)) = near.min_by_key(|(at, _)| at.abs_diff(time)) else { continue };
            let range_m = plot.place.offset_from(&site).distance_m();
            let apart = |fix: &ErrorSample| plot.place.offset_from(&fix.place).distance_m();
            let is_own = |fix: &ErrorSample| plot.drone.is_some() && fix.drone == plot.drone;
            let is_seen = |pair: &(f64, f64)| drawable(pair.0) && drawable(pair.1);
            // Both refer to the time of the plot, so their distance is the difference of their errors.
            let own = fixes.iter().find(|fix| is_own(fix)).and_then(|fix| {
                let (plot, fix) = (plot.error?, fix.error?);
                let ground = (plot.east_m - fix.east_m).hypot(plot.north_m - fix.north_m);
                Some(ground.hypot(plot.up_m.zip(fix.up_m).map_or(0.0, |(plot, fix)| plot - fix)))
            });
            let other = fixes.iter().filter(|fix| !is_own(fix)).map(|fix| apart(fix)).min_by(f64::total_cmp);
            pairs.own.extend(own.map(|apart| (range_m, apart)).filter(is_seen));
            pairs.others.extend(other.map(|apart| (range_m, apart)).filter(is_seen));
        }
        pairs
    }

    fn points(&self) -> impl Iterator<Item = &(f64, f64)> {
        self.own.iter().chain(&self.others)
    }
}
