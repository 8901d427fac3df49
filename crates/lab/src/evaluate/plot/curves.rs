//! Curves over a common axis, for experiments other than the evaluation of a flight: panels one below the other, or a
//! plan view with equal scales.

use std::fmt::Write;

use super::axis::{PlotAxis, drawable, round_step, span};
use super::chart::Chart;
use super::figure::Figure;
use super::style::{Marker, Scale, Style};
use super::svg::{PathData, coordinate};

const WIDTH: f64 = 600.0;
/// Maximum number of points that are drawn large.
const FEW: usize = 60;
const PLAN_HEIGHT: (f64, f64) = (260.0, 620.0);

/// Appearance of a curve. The curves of one figure differ in colour, dash and marker.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CurveStyle {
    /// A black line, for the truth.
    Truth,
    /// A dark blue line.
    First,
    /// An amber line, dashed.
    Second,
    /// A dusky red line, dotted.
    Third,
    /// Dark blue crosses.
    FirstPoints,
    /// Amber squares.
    SecondPoints,
    /// A thin dark blue line, for the bounds of the first curve.
    FirstBound,
    /// A thin amber line, for the bounds of the second curve.
    SecondBound,
}

impl CurveStyle {
    const fn style(self) -> Style {
        let (marker, colour, line_colour, dash) = match self {
            Self::Truth => (Marker::Dot, "#000", "#000", ""),
            Self::First | Self::FirstBound => (Marker::Dot, "#154f9c", "#154f9c", ""),
            Self::FirstPoints => (Marker::Cross, "#154f9c", "#154f9c", ""),
            Self::Second => (Marker::Square, "#c98200", "#8a5600", "7 3"),
            Self::SecondPoints | Self::SecondBound => (Marker::Square, "#c98200", "#8a5600", ""),
            Self::Third => (Marker::Triangle, "#cf5f88", "#7d1f40", "2 2.5"),
        };
        Style { marker, colour, line_colour, dash }
    }

    const fn is_points(self) -> bool {
        matches!(self, Self::FirstPoints | Self::SecondPoints)
    }
}

/// One curve.
#[derive(Clone, Debug)]
pub struct PlotCurve {
    /// Name in the legend. Curves with the same name have one entry; curves with an empty name have none.
    pub name: &'static str,
    /// Appearance of the curve.
    pub look: CurveStyle,
    /// Points in order; a value that is not finite interrupts the line.
    pub points: Vec<(f64, f64)>,
}

/// One frame.
#[derive(Clone, Debug)]
pub struct Panel {
    /// Label of the vertical axis.
    pub label: &'static str,
    /// Curves, from bottom to top.
    pub curves: Vec<PlotCurve>,
    /// Interval of the vertical axis; `None`: all values.
    pub between: Option<(f64, f64)>,
}

impl Panel {
    /// Panel with one curve of non-negative values, from zero up.
    pub fn from_zero(label: &'static str, points: Vec<(f64, f64)>) -> Self {
        let most = points.iter().map(|point| point.1).fold(0.0, f64::max);
        let curve = PlotCurve { name: "", look: CurveStyle::First, points };
        Self { label, curves: vec![curve], between: (most > 0.0).then_some((0.0, 1.1 * most)) }
    }
}

/// Panels one below the other, over a common axis. `name` is valid as a file name.
pub fn panels(name: &'static str, title: &str, caption: &str, across: &str, panels: &[Panel]) -> Figure {
    let all = panels.iter().flat_map(|panel| &panel.curves);
    let (from, to) = extent(all, |point| point.0).unwrap_or((0.0, 1.0));
    let drawn: Vec<Figure> = panels
        .iter()
        .enumerate()
        .map(|(index, panel)| {
            let (low, high) = panel.between.unwrap_or_else(|| {
                let (low, high) = extent(panel.curves.iter(), |point| point.1).unwrap_or((0.0, 1.0));
                let pad = 0.05 * (high - low);
                (low - pad, high + pad)
            });
            let axes = (PlotAxis::linear(across, from, to), PlotAxis::linear(panel.label, low, high));
            let chart = draw(Chart::new(axes.0, axes.1, (WIDTH, 210.0)), &panel.curves);
            chart.finish(PANEL_NAMES[index % PANEL_NAMES.len()], title, caption.to_owned(), None)
        })
        .collect();
    stacked(name, title, caption, &drawn)
}

/// Ids of the frames within one figure; they clip the curves.
const PANEL_NAMES: [&str; 4] = ["first", "second", "third", "fourth"];

/// Plan view of curves, kilometres to the east and to the north, with equal scales.
pub fn from_above(name: &'static str, title: &str, caption: &str, curves: &[PlotCurve]) -> Figure {
    let (x, y) = extent(curves.iter(), |point| point.0)
        .zip(extent(curves.iter(), |point| point.1))
        .unwrap_or(((0.0, 1.0), (0.0, 1.0)));
    let padded = |(low, high): (f64, f64)| 1.08 * (high - low).max(0.1);
    let height = (WIDTH * padded(y) / padded(x)).clamp(PLAN_HEIGHT.0, PLAN_HEIGHT.1).round();
    let a_pixel = (padded(x) / WIDTH).max(padded(y) / height);
    let step = round_step(a_pixel * WIDTH / 9.0);
    let axis = |label: &str, (low, high): (f64, f64), pixels: f64| {
        let (middle, half) = (0.5 * (low + high), 0.5 * a_pixel * pixels);
        PlotAxis::stepped(label, middle - half, middle + half, Some(step))
    };
    let chart = Chart::new(axis("East (km)", x, WIDTH), axis("North (km)", y, height), (WIDTH, height));
    draw(chart, curves).finish(name, title, caption.to_owned(), None)
}

/// Interval that contains all curves.
fn extent<'a>(curves: impl Iterator<Item = &'a PlotCurve>, of: fn(&(f64, f64)) -> f64) -> Option<(f64, f64)> {
    let mut values: Vec<f64> =
        curves.flat_map(|curve| curve.points.iter().map(of)).filter(|value| drawable(*value)).collect();
    span(&mut values)
}

fn draw(mut chart: Chart, curves: &[PlotCurve]) -> Chart {
    for (index, PlotCurve { name, look, points }) in curves.iter().enumerate() {
        let style = look.style();
        let is_named = !name.is_empty() && curves[..index].iter().all(|before| before.name != *name);
        let is_there = |(x, y): &(f64, f64)| drawable(*x) && drawable(*y);
        if look.is_points() {
            let points: Vec<_> = points.iter().copied().filter(is_there).collect();
            if points.len() <= FEW {
                let inside = points.iter().filter(|(x, y)| chart.x.holds(*x) && chart.y.holds(*y));
                let places: Vec<_> = inside.map(|point| chart.place(*point)).collect();
                chart.markers(style.marker, Scale::Large, style.colour, &places);
            } else {
                chart.points(&style, &points);
            }
            if is_named {
                chart.key_marker(style.marker, style.colour, name);
            }
            continue;
        }
        let pieces: Vec<Vec<_>> = points.split(|point| !is_there(point)).map(<[_]>::to_vec).collect();
        if matches!(look, CurveStyle::FirstBound | CurveStyle::SecondBound) {
            let mut data = PathData::default();
            for piece in pieces.iter().filter(|piece| piece.len() > 1) {
                data.line(&piece.iter().map(|point| chart.place(*point)).collect::<Vec<_>>());
            }
            let attributes = format!("fill=\"none\" stroke=\"{}\" stroke-width=\".7\"", style.line_colour);
            chart.titled_path(name, &data, &attributes);
        } else {
            chart.lines(&style, &pieces, false);
        }
        if is_named {
            let width =
                if matches!(look, CurveStyle::FirstBound | CurveStyle::SecondBound) { 0.7 } else { 1.6 };
            chart.key_line(&style, width, false, name);
        }
    }
    chart
}

/// Combines figures, one below the other, into one.
fn stacked(name: &'static str, title: &str, caption: &str, figures: &[Figure]) -> Figure {
    let (mut width, mut height, mut body) = (0.0_f64, 0.0, String::new());
    for figure in figures {
        let (own_width, own_height) = size(&figure.svg);
        let moved = figure.svg.replacen("<svg ", &format!("<svg y=\"{}\" ", coordinate(height)), 1);
        body.push_str(&moved);
        width = width.max(own_width);
        height += own_height;
    }
    let (width, height) = (coordinate(width), coordinate(height));
    let mut svg = String::new();
    let _ = write!(
        svg,
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" \
         viewBox=\"0 0 {width} {height}\" role=\"img\">\n{body}</svg>\n"
    );
    Figure { name, title: title.to_owned(), caption: caption.to_owned(), svg }
}

/// Width and height stated in an SVG of this module.
fn size(svg: &str) -> (f64, f64) {
    let stated = |attribute: &str| {
        let (_, rest) = svg.split_once(attribute)?;
        rest.split_once('"')?.0.parse().ok()
    };
    (stated(" width=\"").unwrap_or(WIDTH), stated(" height=\"").unwrap_or(WIDTH))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn curve(look: CurveStyle, points: &[(f64, f64)]) -> PlotCurve {
        PlotCurve { name: "a curve", look, points: points.to_vec() }
    }

    fn parsed(figure: &Figure) -> roxmltree::Document<'_> {
        roxmltree::Document::parse(&figure.svg).unwrap()
    }

    #[test]
    fn panels_are_stacked_and_name_each_curve_once() {
        let lines = [(0.0, 1.0), (1.0, 3.0), (2.0, f64::NAN), (3.0, 2.0), (4.0, 2.5)];
        let panel = |between| Panel {
            label: "error (m)",
            curves: vec![
                curve(CurveStyle::First, &lines),
                curve(CurveStyle::FirstBound, &lines),
                curve(CurveStyle::SecondPoints, &lines),
            ],
            between,
        };
        let figure =
            panels("name", "A title", "A caption.", "time (s)", &[panel(None), panel(Some((0.0, 9.0)))]);
        let document = parsed(&figure);
        let frames: Vec<f64> = document
            .root_element()
            .children()
            .filter(|child| child.has_tag_name("svg"))
            .map(|frame| frame.attribute("y").unwrap().parse().unwrap())
            .collect();
        assert!(frames.len() == 2 && frames[0] == 0.0 && frames[1] > 200.0, "{frames:?}");
        let texts =
            document.descendants().filter(|node| node.text() == Some("a curve") && node.has_tag_name("text"));
        assert_eq!(texts.count(), 2, "once a panel");
        assert!(!figure.svg.contains("NaN"));
    }

    #[test]
    fn unnamed_curve_has_no_legend() {
        let points = vec![(0.0, 1.0), (1.0, 3.0)];
        let figure = panels("name", "A title", "", "time (h)", &[Panel::from_zero("memory (MiB)", points)]);
        let drawn = figure.svg.matches("#154f9c").count();
        assert_eq!(drawn, 1, "the curve, and no sample of it\n{}", figure.svg);
    }

    #[test]
    fn from_above_a_kilometre_is_as_long_either_way() {
        let figure = from_above(
            "plan",
            "Seen from above",
            "",
            &[curve(CurveStyle::Truth, &[(0.0, 0.0), (10.0, 0.0), (10.0, 4.0)])],
        );
        let document = parsed(&figure);
        let path = document.descendants().find(|node| {
            node.attribute("stroke") == Some("#000")
                && node.attribute("fill") == Some("none")
                && node.has_tag_name("path")
        });
        let data = path.unwrap().attribute("d").unwrap();
        let numbers: Vec<f64> =
            data.split(['M', 'L', ' ']).filter_map(|number| number.parse().ok()).collect();
        let (along, up) = (numbers[2] - numbers[0], numbers[3] - numbers[5]);
        assert!((along / up - 2.5).abs() < 0.01, "{numbers:?}");
    }
}
