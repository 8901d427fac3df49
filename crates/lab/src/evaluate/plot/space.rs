//! Positions of the output: plan view (the paper's Figure 9), and height over time (Figure 10).

use super::super::place::GeodeticPlace;
use super::super::types::{ErrorSample, PointSource};
use super::axis::{PlotAxis, drawable, round_step, span};
use super::chart::{Chart, dashes};
use super::figure::{Figure, PlotClock, PlotStream, TruthLine, caption, counted, thinned};
use super::flat::Flat;
use super::style::{FALSE, Marker, Scale, Style};
use super::svg::PathData;
use super::thin::simplify;
use fusion::time::{SECOND, Time};

/// Maximum time between true points that are joined by a line, nanoseconds.
const TRUTH_GAP: i64 = 5 * SECOND;
/// Maximum number of true paths that are drawn over the points; more are drawn under them.
const LINES_OVER_POINTS: usize = 20;
const HEIGHT_SIZE: (f64, f64) = (600.0, 300.0);
const PLAN_WIDTH: f64 = 560.0;
const PLAN_HEIGHT: (f64, f64) = (300.0, 600.0);
pub(super) const NOTHING: &str = "no point and no true path";

/// Kinds of output points, by source or `None` for points of no drone, in the order of the legend.
const KINDS: [(Option<PointSource>, &str); 5] = [
    (Some(PointSource::Fused), "fused"),
    (Some(PointSource::Radar), "radar only"),
    (Some(PointSource::Transponder), "transponder only"),
    (Some(PointSource::Camera), "cameras only"),
    (None, "of no drone"),
];

type PlanePoint = (f64, f64);
type PlaneInterval = (f64, f64);

/// Plan view of true paths and output, with the same scale on both axes.
pub(super) fn plan_view(streams: &[PlotStream<'_>], truth: &[TruthLine<'_>]) -> Figure {
    let flat = Flat::of(streams, truth);
    let scene = PlanView::of(&streams[0], truth, |_, place| flat.position(place));
    let extent = scene.extent(|point| point.0).zip(scene.extent(|point| point.1));
    let (mut x, mut y) = extent.unwrap_or(((-500.0, 500.0), (-300.0, 300.0)));
    let with_radar = ((x.0.min(0.0), x.1.max(0.0)), (y.0.min(0.0), y.1.max(0.0)));
    // A radar far from the flight would reduce the flight to a speck.
    let size = |x: PlaneInterval, y: PlaneInterval| (x.1 - x.0).max(y.1 - y.0).max(1.0);
    let radar_shown = flat.from_radar && size(with_radar.0, with_radar.1) <= 3.0 * size(x, y);
    if radar_shown {
        (x, y) = with_radar;
    }
    let mut chart = plan_frame(x, y, if flat.from_radar { "radar" } else { "centre" });
    let left_out = scene.draw(&mut chart);
    if radar_shown {
        let place = chart.place((0.0, 0.0));
        chart.markers(Marker::Radar, Scale::Large, "#000", &[place]);
        chart.key_marker(Marker::Radar, "#000", "radar");
    }
    let origin = match (flat.from_radar, radar_shown) {
        (true, true) => "",
        (true, false) => "The radar itself lies outside the figure.",
        (false, _) => "No site is known: the centre is that of the true paths, without them of the points.",
    };
    let what =
        "Output by what each point is made of, and the true paths, from above; one scale on both axes.";
    let text = caption(&[what.to_owned(), origin.to_owned(), left_out]);
    chart.finish("plan-view", "Plan view", text, extent.is_none().then_some(NOTHING))
}

/// Frame that contains both intervals, with the same number of metres per pixel on both axes.
pub(super) fn plan_frame(x: PlaneInterval, y: PlaneInterval, origin: &str) -> Chart {
    let padded = |side: PlaneInterval| 1.06 * (side.1 - side.0).max(20.0);
    let height = (PLAN_WIDTH * padded(y) / padded(x)).clamp(PLAN_HEIGHT.0, PLAN_HEIGHT.1).round();
    let metres_a_pixel = (padded(x) / PLAN_WIDTH).max(padded(y) / height);
    let step = round_step(metres_a_pixel * PLAN_WIDTH / 9.0);
    let axis = |direction: &str, side: PlaneInterval, pixels: f64| {
        let (middle, half) = (0.5 * (side.0 + side.1), 0.5 * metres_a_pixel * pixels);
        PlotAxis::stepped(
            format!("{direction} of the {origin} (m)"),
            middle - half,
            middle + half,
            Some(step),
        )
    };
    Chart::new(axis("East", x, PLAN_WIDTH), axis("North", y, height), (PLAN_WIDTH, height))
}

/// Height of the output and of the truth over time.
pub(super) fn height_over_time(output: &PlotStream<'_>, truth: &[TruthLine<'_>], clock: PlotClock) -> Figure {
    let scene =
        PlanView::of(output, truth, |time, place| Some((clock.minutes(time), place.altitude_amsl_m?)));
    let is_empty = scene.extent(|point| point.0).is_none();
    let mut chart = height_frame(&scene, clock);
    let left_out = scene.draw(&mut chart);
    let flat = output.samples.iter().filter(|sample| sample.place.altitude_amsl_m.is_none()).count();
    let flat = if flat == 0 { String::new() } else { format!("{} points have no height.", counted(flat)) };
    let what = "Height of the output by what each point is made of, and of the true paths.";
    let text = caption(&[what.to_owned(), flat, left_out]);
    chart.finish("height-over-time", "Height over time", text, is_empty.then_some(NOTHING))
}

/// Frame of heights over time that contains a scene.
pub(super) fn height_frame(scene: &PlanView<'_>, clock: PlotClock) -> Chart {
    let extent = scene.extent(|point| point.0).zip(scene.extent(|point| point.1));
    let (x, y) = extent.unwrap_or(((0.0, 1.0), (0.0, 100.0)));
    let pad = 0.06 * (y.1 - y.0).max(10.0);
    Chart::new(
        PlotAxis::linear(clock.label(), x.0, x.1),
        PlotAxis::linear("Height above mean sea level (m)", y.0 - pad, y.1 + pad),
        HEIGHT_SIZE,
    )
}

/// Points of the output by kind, and the true paths, split at gaps.
pub(super) struct PlanView<'a> {
    kinds: [Vec<PlanePoint>; KINDS.len()],
    truth: Vec<(&'a str, Vec<Vec<PlanePoint>>)>,
}

impl<'a> PlanView<'a> {
    /// Collects the points and paths that can be drawn; `place` returns their coordinates.
    pub(super) fn of(
        output: &PlotStream<'_>,
        truth: &[TruthLine<'a>],
        place: impl Fn(Time, &GeodeticPlace) -> Option<PlanePoint>,
    ) -> Self {
        let place = |time, at: &GeodeticPlace| place(time, at).filter(|(x, y)| drawable(*x) && drawable(*y));
        let kinds = KINDS.map(|(kind, _)| {
            let of_kind = |sample: &&ErrorSample| sample.drone.map(|_| sample.source) == kind;
            output
                .samples
                .iter()
                .filter(of_kind)
                .filter_map(|sample| place(sample.time, &sample.place))
                .collect()
        });
        let pieces = |line: &TruthLine<'_>| {
            let mut pieces: Vec<Vec<PlanePoint>> = Vec::new();
            let mut last: Option<Time> = None;
            for (time, at) in line.points {
                let Some(point) = place(*time, at) else { continue };
                let since = last.map(|last| time.nanos().saturating_sub(last.nanos()));
                match pieces.last_mut() {
                    Some(piece) if since.is_some_and(|since| (0..=TRUTH_GAP).contains(&since)) => {
                        piece.push(point);
                    }
                    _ => pieces.push(vec![point]),
                }
                last = Some(*time);
            }
            pieces
        };
        Self { kinds, truth: truth.iter().map(|line| (line.id, pieces(line))).collect() }
    }

    /// Interval of the true paths and of the drones' points, without outliers. Points of no drone may be anywhere; they
    /// stretch it to at most three times its length.
    pub(super) fn extent(&self, side: fn(&PlanePoint) -> f64) -> Option<PlaneInterval> {
        let mut drones: Vec<f64> = self.kinds[..3].iter().flatten().map(side).collect();
        let truth = || self.truth.iter().flat_map(|(_, pieces)| pieces.iter().flatten().map(side));
        let truth = truth().min_by(f64::total_cmp).zip(truth().max_by(f64::total_cmp));
        let inner = match (span(&mut drones), truth) {
            (Some(drones), Some(truth)) => Some((drones.0.min(truth.0), drones.1.max(truth.1))),
            (drones, truth) => drones.or(truth),
        };
        let outer = span(&mut self.kinds[3].iter().map(side).collect::<Vec<_>>());
        match (inner, outer) {
            (Some((low, high)), Some(outer)) => {
                let reach = high - low;
                Some((low.min(outer.0.max(low - reach)), high.max(outer.1.min(high + reach))))
            }
            (inner, outer) => inner.or(outer),
        }
    }

    /// Draws everything with its legend. Returns the caption's sentences about omitted data.
    fn draw(&self, chart: &mut Chart) -> String {
        let (mut outside, mut any_thinned) = (0, false);
        // A few lines are drawn over the points, which would hide them; hundreds of lines would hide the points.
        let few = self.truth.len() <= LINES_OVER_POINTS;
        let (width, colour) = if few { (0.8, "#000") } else { (0.5, "#777") };
        let mut coarse = !few && self.draw_truth(chart, width, colour, "");
        for ((kind, _), points) in KINDS.iter().zip(&self.kinds).rev() {
            let drawn = chart.points(&style_of(*kind), points);
            outside += drawn.outside;
            any_thinned |= drawn.thinned;
        }
        coarse |= few && self.draw_truth(chart, width, colour, "");
        for ((kind, text), points) in KINDS.iter().zip(&self.kinds) {
            if !points.is_empty() {
                let style = style_of(*kind);
                chart.key_marker(style.marker, style.colour, text);
            }
        }
        if !self.truth.is_empty() {
            let text = if self.truth.len() == 1 { "true path" } else { "true paths" };
            chart.key_line(&Style { line_colour: colour, ..FALSE }, width, false, text);
        }
        caption(&[
            if outside == 0 { String::new() } else { format!("{} points lie outside.", counted(outside)) },
            thinned(any_thinned),
            if coarse { "The true paths are simplified.".to_owned() } else { String::new() },
        ])
    }

    /// Draws the true paths with this width, colour and dash. Returns whether they were visibly simplified.
    pub(super) fn draw_truth(&self, chart: &mut Chart, width: f64, colour: &str, dash: &str) -> bool {
        let owners =
            self.truth.iter().enumerate().flat_map(|(line, (_, pieces))| pieces.iter().map(move |_| line));
        let pieces = self.truth.iter().flat_map(|(_, pieces)| pieces);
        let pixels = pieces.map(|piece| piece.iter().map(|point| chart.place(*point)).collect()).collect();
        let (pixels, coarse) = simplify(pixels);
        let mut paths: Vec<PathData> = self.truth.iter().map(|_| PathData::default()).collect();
        for (owner, piece) in owners.zip(&pixels) {
            paths[owner].line(piece);
        }
        let attributes = format!(
            "fill=\"none\" stroke=\"{colour}\" stroke-width=\"{width}\" stroke-linecap=\"round\"{}",
            dashes(dash)
        );
        for ((id, _), path) in self.truth.iter().zip(&paths) {
            chart.titled_path(id, path, &attributes);
        }
        coarse
    }
}

fn style_of(kind: Option<PointSource>) -> Style {
    kind.map_or(FALSE, Style::of)
}
