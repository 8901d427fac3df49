//! What figures are made of, and what they are.

use super::super::place::Place;
use super::super::types::Sample;
use super::axis::decimal;
use super::style::Style;
use fusion::time::{SECOND, Time};

/// One picture.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Figure {
    /// Name, fit for a file: `error-over-time`.
    pub name: &'static str,
    /// Title.
    pub title: String,
    /// How to read it, and what it omits.
    pub caption: String,
    /// A complete SVG document, which may also be embedded in HTML.
    pub svg: String,
}

/// The true path of a drone.
#[derive(Clone, Copy, Debug)]
pub struct TruthLine<'a> {
    /// The drone's id.
    pub id: &'a str,
    /// Positions in order of time. Gaps of more than 5 s are not bridged.
    pub points: &'a [(Time, Place)],
}

/// One of the streams of points that are compared.
pub(super) struct Stream<'a> {
    pub(super) name: &'static str,
    pub(super) style: Style,
    pub(super) samples: &'a [Sample],
}

/// The zero of the time axis, a whole second.
#[derive(Clone, Copy, Debug)]
pub(super) struct Clock(Option<Time>);

impl Clock {
    /// The first point of a drone counts; without one any point, without points the truth.
    pub(super) fn of(streams: &[Stream<'_>], truth: &[TruthLine<'_>]) -> Self {
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

/// A time to the second, as people write it.
pub(super) fn moment(time: Time) -> String {
    let text = time.to_string();
    text.split('.').next().unwrap_or(&text).replace('T', " ")
}

/// A count with its thousands apart.
pub(super) fn counted(count: usize) -> String {
    decimal(count as f64, 0)
}

/// The sentences of a caption that say something.
pub(super) fn caption(sentences: &[String]) -> String {
    let said: Vec<&str> =
        sentences.iter().map(String::as_str).filter(|sentence| !sentence.is_empty()).collect();
    said.join(" ")
}

/// What a caption says about thinned points.
pub(super) fn thinned(any: bool) -> String {
    if any { "Of points that nearly coincide one is drawn.".to_owned() } else { String::new() }
}
