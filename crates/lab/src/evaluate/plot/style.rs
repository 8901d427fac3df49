//! Appearance of streams. Sources are distinguished by colour (dark blue, dusky red and amber also differ in lightness,
//! for grey prints and the colour-blind), by marker, and by dash.

use super::super::types::PointSource;

/// Appearance of one kind of point.
#[derive(Clone, Copy, Debug)]
pub(super) struct Style {
    pub(super) marker: Marker,
    /// Colour of the points.
    pub(super) colour: &'static str,
    /// Colour of lines over the points: darker.
    pub(super) line_colour: &'static str,
    /// `stroke-dasharray` of lines; empty: solid.
    pub(super) dash: &'static str,
}

/// Shape of a point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Marker {
    Dot,
    Square,
    Triangle,
    Cross,
    Radar,
}

impl Marker {
    /// Path data after the move to the centre, and the attributes of the path. Dots and squares are line caps.
    pub(super) fn drawn(self, scale: Scale, colour: &str) -> (&'static str, String) {
        let (data, width) = match (self, scale) {
            (Self::Dot, Scale::Small) => ("h.01", 2.4),
            (Self::Dot, Scale::Large) => ("h.01", 6.5),
            (Self::Square, Scale::Small) => ("h.01", 2.2),
            (Self::Square, Scale::Large) => ("h.01", 5.5),
            (Self::Triangle, Scale::Small) => ("m0-2l2 3h-4z", 0.0),
            (Self::Triangle, Scale::Large) => ("m0-4.2l4 7h-8z", 0.0),
            (Self::Cross, Scale::Small) => ("m-2-2l4 4m0-4l-4 4", 0.8),
            (Self::Cross, Scale::Large) => ("m-3-3l6 6m0-6l-6 6", 1.2),
            (Self::Radar, _) => ("m-5 0a5 5 0 1 0 10 0a5 5 0 1 0-10 0m-3 0h16m-8-8v16", 1.4),
        };
        let attributes = match self {
            Self::Dot => {
                format!("fill=\"none\" stroke=\"{colour}\" stroke-width=\"{width}\" stroke-linecap=\"round\"")
            }
            Self::Square => {
                format!(
                    "fill=\"none\" stroke=\"{colour}\" stroke-width=\"{width}\" stroke-linecap=\"square\""
                )
            }
            Self::Triangle => format!("fill=\"{colour}\""),
            Self::Cross | Self::Radar => {
                format!("fill=\"none\" stroke=\"{colour}\" stroke-width=\"{width}\"")
            }
        };
        (data, attributes)
    }
}

/// Size of a marker.
#[derive(Clone, Copy, Debug)]
pub(super) enum Scale {
    /// For one of thousands of points.
    Small,
    /// For the legend and on lines.
    Large,
}

/// Style of points of no drone.
pub(super) const FALSE: Style =
    Style { marker: Marker::Cross, colour: "#555", line_colour: "#555", dash: "" };

impl Style {
    /// Whether this is the style of points of this source.
    pub(super) fn is(&self, source: PointSource) -> bool {
        self.colour == Self::of(source).colour
    }

    /// Style of a stream, or of an output point by its source.
    pub(super) const fn of(source: PointSource) -> Self {
        match source {
            PointSource::Fused => {
                Self { marker: Marker::Dot, colour: "#154f9c", line_colour: "#052c5c", dash: "" }
            }
            PointSource::Radar => {
                Self { marker: Marker::Square, colour: "#ecab38", line_colour: "#8a5600", dash: "7 3" }
            }
            PointSource::Transponder => {
                Self { marker: Marker::Triangle, colour: "#cf5f88", line_colour: "#7d1f40", dash: "2 2.5" }
            }
            PointSource::Camera => {
                Self { marker: Marker::Square, colour: "#3f9a57", line_colour: "#1f5c31", dash: "4 2" }
            }
        }
    }
}
