//! SVG helpers: short numbers and path data.

use std::fmt::Write;

/// Largest coordinate written, pixels: far outside every figure.
const COORDINATE_MAX: f64 = 1e5;

/// A coordinate to a tenth of a pixel, without redundant characters: `12.3`, `12`, `-.5`.
pub(super) fn coordinate(pixels: f64) -> String {
    let mut text = String::new();
    push_coordinate(&mut text, pixels);
    text
}

fn push_coordinate(out: &mut String, pixels: f64) {
    debug_assert!(!pixels.is_nan(), "what has no place is left out before it is drawn");
    let tenths = (pixels.clamp(-COORDINATE_MAX, COORDINATE_MAX) * 10.0).round() as i64;
    let (whole, tenth) = (tenths.abs() / 10, tenths.abs() % 10);
    if tenths < 0 {
        out.push('-');
    }
    // Writing to a string cannot fail.
    let _ = match (whole, tenth) {
        (whole, 0) => write!(out, "{whole}"),
        (0, tenth) => write!(out, ".{tenth}"),
        (whole, tenth) => write!(out, "{whole}.{tenth}"),
    };
}

/// Path data: one `d` attribute for thousands of marks takes a tenth of the space of separate elements.
#[derive(Default)]
pub(super) struct PathData(String);

impl PathData {
    /// Moves to (x, y), then appends `rest`.
    pub(super) fn mark(&mut self, (x, y): (f64, f64), rest: &str) {
        self.command('M', (x, y));
        self.0.push_str(rest);
    }

    /// Draws a line through `points`; for a single point a dot.
    pub(super) fn line(&mut self, points: &[(f64, f64)]) {
        for (index, point) in points.iter().enumerate() {
            self.command(if index == 0 { 'M' } else { 'L' }, *point);
        }
        if points.len() == 1 {
            self.0.push_str("h.01");
        }
    }

    fn command(&mut self, letter: char, (x, y): (f64, f64)) {
        self.0.push(letter);
        push_coordinate(&mut self.0, x);
        self.0.push(' ');
        push_coordinate(&mut self.0, y);
    }

    pub(super) fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Value of `d`.
    pub(super) fn as_str(&self) -> &str {
        &self.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coordinates_are_short_and_finite() {
        let texts = [0.0, -0.04, 12.34, 12.0, -0.5, f64::INFINITY, f64::NEG_INFINITY].map(coordinate);
        assert_eq!(texts, ["0", "0", "12.3", "12", "-.5", "100000", "-100000"]);
    }
}
