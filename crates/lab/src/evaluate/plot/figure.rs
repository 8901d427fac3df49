//! Figures and their building blocks.

use super::super::place::GeodeticPlace;
use super::super::types::ErrorSample;
use super::axis::decimal;
use super::style::Style;
use fusion::time::{SECOND, Time};

/// One figure.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Figure {
    /// Name, valid as a file name: `error-over-time`.
    pub name: &'static str,
    /// Title.
    pub title: String,
    /// Explanation of the figure and of what it omits.
    pub caption: String,
    /// Complete SVG document, which may also be embedded in HTML.
    pub svg: String,
}

/// True path of a drone.
#[derive(Clone, Copy, Debug)]
pub struct TruthLine<'a> {
    /// Id of the drone.
    pub id: &'a str,
    /// Positions in order of time. Gaps of more than 5 s are not bridged.
    pub points: &'a [(Time, GeodeticPlace)],
}

/// A stream of points in a comparison.
pub(super) struct PlotStream<'a> {
    pub(super) name: &'static str,
    pub(super) style: Style,
    pub(super) samples: &'a [ErrorSample],
}

/// Zero of the time axis, a whole second.
#[derive(Clone, Copy, Debug)]
pub(super) struct PlotClock(Option<Time>);

impl PlotClock {
    /// Time of the first point of a drone, else of any point, else of the truth.
    pub(super) fn of(streams: &[PlotStream<'_>], truth: &[TruthLine<'_>]) -> Self {
        let samples = || streams.iter().flat_map(|stream| stream.samples);
        let of_drones = samples().filter(|sample| sample.drone.is_some()).map(|sample| sample.time).min();
        let first = of_drones
            .or_else(|| samples().map(|sample| sample.time).min())
            .or_else(|| truth.iter().flat_map(|line| line.points).map(|(time, _)| *time).min());
        Self(first.map(|time| Time::from_nanos(time.nanos().div_euclid(SECOND).saturating_mul(SECOND))))
    }

    pub(super) fn minutes(self, time: Time) -> f64 {
        self.0.map_or(0.0, |zero| time.seconds_since(zero) / 60.0)
    }

    pub(super) fn label(self) -> String {
        match self.0 {
            Some(zero) => format!("Time since {} UTC (min)", moment(zero)),
            None => "Time (min)".to_owned(),
        }
    }
}

/// Formats a time to the second.
pub(super) fn moment(time: Time) -> String {
    let text = time.to_string();
    text.split('.').next().unwrap_or(&text).replace('T', " ")
}

/// Formats a count with separated thousands.
pub(super) fn counted(count: usize) -> String {
    decimal(count as f64, 0)
}

/// Joins the sentences of a caption that are not empty.
pub(super) fn caption(sentences: &[String]) -> String {
    let said: Vec<&str> =
        sentences.iter().map(String::as_str).filter(|sentence| !sentence.is_empty()).collect();
    said.join(" ")
}

/// Sentence of a caption about thinned points.
pub(super) fn thinned(any: bool) -> String {
    if any { "Of points that nearly coincide one is drawn.".to_owned() } else { String::new() }
}
