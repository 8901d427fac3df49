//! Map and residuals of located radars, as SVG.

use std::fmt::Write as _;

use fusion::frames::{Geodetic, TangentPlane};
use locate::AlignmentData;

use super::Found;

/// Width and height of a radar's row, and of the frame around each panel, pixels.
const WIDTH: f64 = 1080.0;
const HEIGHT: f64 = 420.0;
const FRAME: f64 = 46.0;

/// A page with one row per radar: map, azimuth residuals, range residuals.
pub(super) fn svg(found: &[Found], data: &AlignmentData) -> String {
    let height = HEIGHT * found.len() as f64;
    let mut text = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{WIDTH}\" height=\"{height}\" viewBox=\"0 0 {WIDTH} {height}\" \
         font-family=\"sans-serif\" font-size=\"12\">\n<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n"
    );
    for (row, (source, result)) in found.iter().enumerate() {
        _ = writeln!(text, "<g transform=\"translate(0 {})\">", HEIGHT * row as f64);
        let name = format!("Radar {}/{}", source.sac, source.sic);
        match result {
            Ok(located) => {
                title(&mut text, 10.0, &format!("{name}: drones as reported, radar as located"));
                map(&mut text, located, data);
                let of = |pick: &dyn Fn(&(f64, f64)) -> f64| -> Vec<(f64, f64, f64)> {
                    let first = located.residuals.first().map(|residual| residual.time).unwrap_or_default();
                    let point = |residual: &locate::PlotResidual| {
                        (residual.time.seconds_since(first), pick(&residual.before), pick(&residual.after))
                    };
                    located.residuals.iter().map(point).collect()
                };
                panel(&mut text, 440.0, 20.0, "azimuth residual, degrees", &of(&|both| both.0));
                panel(&mut text, 440.0, HEIGHT / 2.0 + 10.0, "range residual, metres", &of(&|both| both.1));
            }
            Err(reason) => title(&mut text, 10.0, &format!("{name}: not located: {reason}")),
        }
        text += "</g>\n";
    }
    text += "</svg>\n";
    text
}

fn title(text: &mut String, left: f64, title: &str) {
    let escaped = title.replace('&', "&amp;").replace('<', "&lt;");
    _ = writeln!(text, "<text x=\"{left}\" y=\"16\">{escaped}</text>");
}

/// Drones' reports at the plots, and the radar with three deviations.
fn map(text: &mut String, located: &locate::LocatedRadar, data: &AlignmentData) {
    let plane = TangentPlane::at_site(located.antenna);
    let at = |place: Geodetic| plane.from_geodetic(place).0.xy();
    let mut points: Vec<(f64, f64)> =
        data.reports.iter().map(|report| at(report.place)).map(|at| (at.x, at.y)).collect();
    points.push((0.0, 0.0));
    let range = |values: &dyn Fn(&(f64, f64)) -> f64| {
        points
            .iter()
            .map(values)
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| (low.min(value), high.max(value)))
    };
    let ((west, east), (south, north)) = (range(&|at| at.0), range(&|at| at.1));
    let size = HEIGHT - FRAME;
    let scale = (size - 20.0) / (east - west).max(north - south).max(1.0);
    let x = |east: f64| 10.0 + (east - west) * scale;
    let y = |up: f64| 30.0 + (north - up) * scale;
    for (east, north) in points.iter().take(points.len() - 1) {
        _ = writeln!(text, "<circle cx=\"{:.1}\" cy=\"{:.1}\" r=\"1\" fill=\"#bbb\"/>", x(*east), y(*north));
    }
    for residual in &located.residuals {
        let place = at(residual.reported);
        let (x, y) = (x(place.x), y(place.y));
        _ = writeln!(text, "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"1.5\" fill=\"#1f77b4\"/>");
    }
    let radius = (3.0 * located.position_sigma_m() / std::f64::consts::SQRT_2 * scale).max(3.0);
    let (x, y) = (x(0.0), y(0.0));
    _ = writeln!(
        text,
        "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{radius:.1}\" fill=\"none\" stroke=\"#d62728\"/>\n\
         <path d=\"M{x:.1} {:.1} l5 12 h-10 z\" fill=\"#d62728\"/>",
        y - 7.0
    );
    let length_m = 10_f64.powf(((east - west).max(north - south).max(10.0) / 2.0).log10().floor());
    _ = writeln!(
        text,
        "<path d=\"M12 {0:.1} h{1:.1}\" stroke=\"black\" stroke-width=\"2\"/><text x=\"12\" y=\"{2:.1}\">{length_m} m</text>",
        HEIGHT - 8.0,
        length_m * scale,
        HEIGHT - 14.0
    );
}

/// Residuals over time: before in grey, after in blue.
fn panel(text: &mut String, left: f64, top: f64, title: &str, points: &[(f64, f64, f64)]) {
    let (width, height) = (WIDTH - left - FRAME, HEIGHT / 2.0 - FRAME);
    let last_s = points.iter().fold(1.0_f64, |last, point| last.max(point.0));
    let mut sizes: Vec<f64> = points.iter().map(|point| point.1.abs().max(point.2.abs())).collect();
    sizes.sort_by(f64::total_cmp);
    let most = sizes.get(sizes.len().saturating_sub(1) * 98 / 100).copied().unwrap_or(1.0).max(1e-3);
    let middle = top + height / 2.0;
    _ = writeln!(
        text,
        "<rect x=\"{left}\" y=\"{top}\" width=\"{width}\" height=\"{height}\" fill=\"none\" stroke=\"#888\"/>\n\
         <path d=\"M{left} {middle} h{width}\" stroke=\"#888\"/>\n\
         <text x=\"{left}\" y=\"{:.1}\">{title} (± {most:.1}): before grey, after blue; {last_s:.0} s</text>",
        top - 4.0
    );
    for (colour, pick) in [("#bbb", 1_u8), ("#1f77b4", 2)] {
        for &(time_s, before, after) in points {
            let value = (if pick == 1 { before } else { after }).clamp(-most, most);
            let x = left + time_s / last_s * width;
            let y = middle - value / most * height / 2.0;
            _ = writeln!(text, "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"1.2\" fill=\"{colour}\"/>");
        }
    }
}
