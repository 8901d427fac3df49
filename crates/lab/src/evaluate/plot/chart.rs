//! A chart: a frame with two axes, the drawing inside, and a legend above.

use std::fmt::Write;

use super::axis::PlotAxis;
use super::figure::Figure;
use super::style::{Marker, Scale, Style};
use super::svg::{PathData, coordinate};
use super::thin::thin;
use picture::xml::escape;

/// Estimated width of a character of 11 px in common sans-serif fonts, with a margin, pixels. Text is not measured.
const CHARACTER: f64 = 5.8;
const LEGEND_ROW: f64 = 19.0;
const LINE_SAMPLE: f64 = 26.0;
const MARKER_SAMPLE: f64 = 14.0;
const MARGIN_RIGHT: f64 = 22.0;
const MARGIN_BOTTOM: f64 = 46.0;
const FONT: &str = "Helvetica, Arial, 'Liberation Sans', 'DejaVu Sans', sans-serif";

/// Result of drawing the points of a series.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct DrawnPoints {
    /// Number of points outside the axes.
    pub(super) outside: usize,
    /// Whether points were omitted because others hide them or the file would be too large.
    pub(super) thinned: bool,
}

/// An entry of the legend.
struct LegendEntry {
    sample: String,
    /// Width of the sample, pixels.
    width: f64,
    text: &'static str,
}

/// A figure under construction.
pub(super) struct Chart {
    pub(super) x: PlotAxis,
    pub(super) y: PlotAxis,
    width: f64,
    height: f64,
    body: String,
    legend: Vec<LegendEntry>,
}

impl Chart {
    /// An empty frame of `width` by `height` pixels.
    pub(super) fn new(x: PlotAxis, y: PlotAxis, (width, height): (f64, f64)) -> Self {
        Self { x, y, width, height, body: String::new(), legend: Vec::new() }
    }

    /// Offset from the upper left corner of the frame, pixels.
    pub(super) fn place(&self, (x, y): (f64, f64)) -> (f64, f64) {
        (self.x.fraction(x) * self.width, (1.0 - self.y.fraction(y)) * self.height)
    }

    /// Draws points as small markers, thinned if there are many. Points outside the axes are counted but not drawn.
    pub(super) fn points(&mut self, style: &Style, points: &[(f64, f64)]) -> DrawnPoints {
        let inside: Vec<_> = points
            .iter()
            .filter(|(x, y)| self.x.holds(*x) && self.y.holds(*y))
            .map(|point| self.place(*point))
            .collect();
        let (count, kept) = (inside.len(), thin(inside, (self.width, self.height)));
        self.markers(style.marker, Scale::Small, style.colour, &kept);
        DrawnPoints { outside: points.len() - count, thinned: kept.len() < count }
    }

    /// Draws lines over points, with a white outline for contrast, and optionally a large marker at each corner.
    pub(super) fn lines(&mut self, style: &Style, lines: &[Vec<(f64, f64)>], markers: bool) {
        let lines: Vec<Vec<_>> =
            lines.iter().map(|line| line.iter().map(|point| self.place(*point)).collect()).collect();
        let mut data = PathData::default();
        for line in lines.iter().filter(|line| line.len() > 1) {
            data.line(line);
        }
        let common = "fill=\"none\" stroke-linejoin=\"round\"";
        self.path(&data, &format!("{common} stroke=\"#fff\" stroke-width=\"3.6\" stroke-opacity=\".8\""));
        let dash = dashes(style.dash);
        self.path(&data, &format!("{common} stroke=\"{}\" stroke-width=\"1.6\"{dash}", style.line_colour));
        if markers {
            self.markers(style.marker, Scale::Large, style.line_colour, &lines.concat());
        }
    }

    /// Adds a path with a tooltip.
    pub(super) fn titled_path(&mut self, title: &str, data: &PathData, attributes: &str) {
        if data.is_empty() {
            return;
        }
        let title = escape(title);
        let _ =
            writeln!(self.body, "<path {attributes} d=\"{}\"><title>{title}</title></path>", data.as_str());
    }

    /// Draws markers at these pixels.
    pub(super) fn markers(&mut self, marker: Marker, scale: Scale, colour: &str, pixels: &[(f64, f64)]) {
        let (mark, attributes) = marker.drawn(scale, colour);
        let mut data = PathData::default();
        for pixel in pixels {
            data.mark(*pixel, mark);
        }
        self.path(&data, &attributes);
    }

    /// Fills the area between two lines, from left to right: x, and both values of y.
    pub(super) fn band(&mut self, colour: &str, points: &[(f64, f64, f64)]) {
        let upper = points.iter().map(|&(x, _, high)| self.place((x, high)));
        let lower = points.iter().rev().map(|&(x, low, _)| self.place((x, low)));
        let mut data = PathData::default();
        data.line(&upper.chain(lower).collect::<Vec<_>>());
        self.path(&data, &format!("fill=\"{colour}\""));
    }

    /// Draws a thin straight line across the frame at a value of the y axis.
    pub(super) fn level(&mut self, value: f64) {
        let y = coordinate(self.place((self.x.from, value)).1);
        let _ = writeln!(
            self.body,
            "<path stroke=\"#888\" stroke-width=\".8\" d=\"M0 {y}H{}\"/>",
            coordinate(self.width)
        );
    }

    fn path(&mut self, data: &PathData, attributes: &str) {
        if !data.is_empty() {
            let _ = writeln!(self.body, "<path {attributes} d=\"{}\"/>", data.as_str());
        }
    }

    /// Adds a marker to the legend.
    pub(super) fn key_marker(&mut self, marker: Marker, colour: &str, text: &'static str) {
        let (mark, attributes) = marker.drawn(Scale::Large, colour);
        let sample = format!("<path {attributes} d=\"M{} 0{mark}\"/>", MARKER_SAMPLE / 2.0);
        self.legend.push(LegendEntry { sample, width: MARKER_SAMPLE, text });
    }

    /// Adds a line to the legend, optionally with its marker.
    pub(super) fn key_line(&mut self, style: &Style, width: f64, marker: bool, text: &'static str) {
        let dash = dashes(style.dash);
        let mut sample = format!(
            "<path fill=\"none\" stroke=\"{}\" stroke-width=\"{width}\"{dash} d=\"M0 0h{LINE_SAMPLE}\"/>",
            style.line_colour
        );
        if marker {
            let (mark, attributes) = style.marker.drawn(Scale::Large, style.line_colour);
            let _ = write!(sample, "<path {attributes} d=\"M{} 0{mark}\"/>", LINE_SAMPLE / 2.0);
        }
        self.legend.push(LegendEntry { sample, width: LINE_SAMPLE, text });
    }

    /// Completes the figure. `name` is a constant that is valid as an id; `note` is shown in the frame.
    pub(super) fn finish(
        self,
        name: &'static str,
        title: &str,
        caption: String,
        note: Option<&str>,
    ) -> Figure {
        Self::stacked(name, title, caption, &[(self, note)])
    }

    /// Combines several charts into one figure, one below the other, each with its note.
    pub(super) fn stacked(
        name: &'static str,
        title: &str,
        caption: String,
        charts: &[(Self, Option<&str>)],
    ) -> Figure {
        let widest =
            charts.iter().flat_map(|(chart, _)| &chart.y.ticks).map(|(_, text)| text.chars().count());
        let left = 38.0 + CHARACTER * widest.max().unwrap_or(0) as f64;
        let mut drawn = String::new();
        let (mut width, mut height) = (0.0_f64, 0.0);
        for (number, (chart, note)) in charts.iter().enumerate() {
            let frame = if number == 0 { format!("{name}-frame") } else { format!("{name}-frame-{number}") };
            height = chart.write(&mut drawn, &frame, (left, height), *note);
            width = width.max(left + chart.width + MARGIN_RIGHT);
        }
        let (width, height) = (coordinate(width.ceil()), coordinate(height.ceil()));
        let svg = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" \
             viewBox=\"0 0 {width} {height}\" role=\"img\" font-family=\"{FONT}\" font-size=\"11\">\n\
             <title>{}</title>\n<desc>{}</desc>\n<rect width=\"{width}\" height=\"{height}\" fill=\"#fff\"/>\n\
             {drawn}</svg>\n",
            escape(title),
            escape(&caption),
        );
        Figure { name, title: title.to_owned(), caption, svg }
    }

    /// Writes the legend and the frame below it, at these offsets from the left and the top. Returns the offset of the
    /// lower end. `frame` is the id of the frame.
    fn write(&self, svg: &mut String, frame: &str, (left, above): (f64, f64), note: Option<&str>) -> f64 {
        let (legend, legend_height) = self.legend_drawn();
        let top = above + 12.0 + legend_height;
        let (frame_width, frame_height) = (coordinate(self.width), coordinate(self.height));
        let _ = writeln!(
            svg,
            "<g transform=\"translate({} {})\">\n<clipPath id=\"{frame}\">\
             <rect width=\"{frame_width}\" height=\"{frame_height}\"/></clipPath>",
            coordinate(left),
            coordinate(top),
        );
        self.write_grid(svg);
        let _ = writeln!(svg, "<g clip-path=\"url(#{frame})\">\n{}</g>", self.body);
        let _ = writeln!(
            svg,
            "<rect width=\"{frame_width}\" height=\"{frame_height}\" fill=\"none\" stroke=\"#000\"/>"
        );
        self.write_labels(svg, left);
        if let Some(note) = note {
            let (x, y) = (coordinate(self.width / 2.0), coordinate(self.height / 2.0));
            let _ = writeln!(
                svg,
                "<text x=\"{x}\" y=\"{y}\" text-anchor=\"middle\" fill=\"#555\" \
                 stroke=\"#fff\" stroke-width=\"4\" paint-order=\"stroke\">{}</text>",
                escape(note)
            );
        }
        svg.push_str(&legend);
        svg.push_str("</g>\n");
        top + self.height + MARGIN_BOTTOM
    }

    /// Draws the legend in as many rows as it needs. Returns it with its height.
    fn legend_drawn(&self) -> (String, f64) {
        const BETWEEN: f64 = 16.0;
        let (mut row, mut x) = (0_i32, 0.0);
        let mut places = Vec::new();
        for key in &self.legend {
            let width = key.width + 5.0 + CHARACTER * key.text.chars().count() as f64;
            if x > 0.0 && x + width > self.width {
                (row, x) = (row + 1, 0.0);
            }
            places.push((x, row));
            x += width + BETWEEN;
        }
        let rows = if places.is_empty() { 0 } else { row + 1 };
        let mut drawn = String::new();
        for (key, (x, row)) in self.legend.iter().zip(places) {
            let (x, y) = (coordinate(x), coordinate(LEGEND_ROW * f64::from(row - rows) + 6.0));
            let (sample, after, text) = (&key.sample, key.width + 5.0, escape(key.text));
            let _ = writeln!(
                drawn,
                "<g transform=\"translate({x} {y})\">{sample}<text x=\"{after}\" y=\"3.8\">{text}</text></g>"
            );
        }
        (drawn, f64::from(rows) * LEGEND_ROW)
    }

    fn write_grid(&self, svg: &mut String) {
        let mut grid = PathData::default();
        let labelled = |axis: &'_ PlotAxis| {
            let ticks = axis.ticks.iter().filter(|(_, text)| !text.is_empty());
            ticks.map(|(value, _)| axis.fraction(*value)).collect::<Vec<_>>()
        };
        for fraction in labelled(&self.x) {
            grid.mark((fraction * self.width, 0.0), &format!("v{}", coordinate(self.height)));
        }
        for fraction in labelled(&self.y) {
            grid.mark((0.0, (1.0 - fraction) * self.height), &format!("h{}", coordinate(self.width)));
        }
        let _ = writeln!(svg, "<path stroke=\"#e4e4e4\" stroke-width=\".8\" d=\"{}\"/>", grid.as_str());
    }

    fn write_labels(&self, svg: &mut String, left: f64) {
        let mut ticks = PathData::default();
        svg.push_str("<g text-anchor=\"middle\">\n");
        for (value, text) in &self.x.ticks {
            let x = self.x.fraction(*value) * self.width;
            ticks.mark((x, self.height), if text.is_empty() { "v-3" } else { "v-5" });
            if !text.is_empty() {
                let (x, y) = (coordinate(x), coordinate(self.height + 15.0));
                let _ = writeln!(svg, "<text x=\"{x}\" y=\"{y}\">{text}</text>");
            }
        }
        let (x, y) = (coordinate(self.width / 2.0), coordinate(self.height + 35.0));
        let _ = writeln!(svg, "<text x=\"{x}\" y=\"{y}\" font-size=\"12\">{}</text>", escape(&self.x.label));
        let (x, y) = (coordinate(14.0 - left), coordinate(self.height / 2.0));
        let _ = writeln!(
            svg,
            "<text transform=\"translate({x} {y}) rotate(-90)\" font-size=\"12\">{}</text>\n</g>",
            escape(&self.y.label)
        );
        svg.push_str("<g text-anchor=\"end\">\n");
        for (value, text) in &self.y.ticks {
            let y = (1.0 - self.y.fraction(*value)) * self.height;
            ticks.mark((0.0, y), if text.is_empty() { "h3" } else { "h5" });
            if !text.is_empty() {
                let _ = writeln!(svg, "<text x=\"-6\" y=\"{}\">{text}</text>", coordinate(y + 3.8));
            }
        }
        let _ = writeln!(svg, "</g>\n<path stroke=\"#000\" stroke-width=\".8\" d=\"{}\"/>", ticks.as_str());
    }
}

pub(super) fn dashes(pattern: &str) -> String {
    if pattern.is_empty() { String::new() } else { format!(" stroke-dasharray=\"{pattern}\"") }
}
