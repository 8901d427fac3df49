//! An evaluation as pictures: SVG figures as the paper's Figures 9 to 13, and one HTML page with its Table 1.
//!
//! Strings only, no file: the caller writes them. The same evaluation gives the same bytes. What is not finite is left
//! out; foreign text (the ids of drones) is escaped. An own writer of SVG, because what plotting libraries give rounds
//! each point to a whole pixel and spends a hundred octets on it, and knows neither `<title>` nor `<desc>`.

mod axis;
mod chart;
mod errors;
mod flat;
mod page;
mod space;
mod style;
mod svg;
#[cfg(test)]
mod tests;
mod thin;

pub use page::page;

use super::{Evaluation, Place, PointSource, Sample};
use axis::decimal;
use fusion::time::{SECOND, Time};
use style::Style;

/// One picture.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Figure {
    /// What it is called, fit for a file name: `error-over-time`.
    pub name: &'static str,
    /// What it shows, in a few words.
    pub title: String,
    /// How to read it, and what it leaves out.
    pub caption: String,
    /// A whole SVG document, which may as well stand within an HTML page.
    pub svg: String,
}

/// The true path of a drone.
#[derive(Clone, Copy, Debug)]
pub struct TruthLine<'a> {
    /// The drone's id.
    pub id: &'a str,
    /// Where it was, in order of time. Between points more than 5 s apart nothing is known, and nothing drawn.
    pub points: &'a [(Time, Place)],
}

/// The figures of an evaluation, always all of them: one with nothing to show says so.
///
/// `error-over-time`, `error-over-range`, `error-over-azimuth`, `plan-view`, `height-over-time`,
/// `error-distribution`.
pub fn figures(evaluation: &Evaluation, truth: &[TruthLine<'_>]) -> Vec<Figure> {
    let streams = streams(evaluation);
    let clock = Clock::of(&streams, truth);
    vec![
        errors::over_time(&streams, clock),
        errors::over_range(&streams),
        errors::over_azimuth(&streams),
        space::plan_view(&streams, truth),
        space::height_over_time(&streams[0], truth, clock),
        errors::distribution(&streams),
    ]
}

/// One of the streams of points that are compared.
struct Stream<'a> {
    name: &'static str,
    style: Style,
    samples: &'a [Sample],
}

/// The output first, then the inputs that there are.
fn streams(evaluation: &Evaluation) -> Vec<Stream<'_>> {
    let inputs = [
        ("fused output", PointSource::Fused, Some(&evaluation.fused)),
        ("radar plots", PointSource::Radar, evaluation.radar.as_ref()),
        ("transponder", PointSource::Transponder, evaluation.transponder.as_ref()),
    ];
    let there = inputs.into_iter().filter_map(|(name, source, scored)| Some((name, source, scored?)));
    there
        .map(|(name, source, scored)| Stream { name, style: Style::of(source), samples: &scored.samples })
        .collect()
}

/// Minutes since the first point, in whole seconds so that an axis can name it.
#[derive(Clone, Copy, Debug)]
struct Clock(Option<Time>);

impl Clock {
    /// The first point of a drone counts; without one any point, without points the truth.
    fn of(streams: &[Stream<'_>], truth: &[TruthLine<'_>]) -> Self {
        let samples = || streams.iter().flat_map(|stream| stream.samples);
        let of_drones = samples().filter(|sample| sample.drone.is_some()).map(|sample| sample.time).min();
        let first = of_drones
            .or_else(|| samples().map(|sample| sample.time).min())
            .or_else(|| truth.iter().flat_map(|line| line.points).map(|(time, _)| *time).min());
        Self(first.map(|time| Time::from_nanos(time.nanos().div_euclid(SECOND).saturating_mul(SECOND))))
    }

    fn minutes(self, time: Time) -> f64 {
        self.0.map_or(0.0, |zero| time.seconds_since(zero) / 60.0)
    }

    fn label(self) -> String {
        match self.0 {
            Some(zero) => format!("Time since {} UTC (min)", moment(zero)),
            None => "Time (min)".to_owned(),
        }
    }
}

/// A time to the second, as people write it.
fn moment(time: Time) -> String {
    let text = time.to_string();
    text.split('.').next().unwrap_or(&text).replace('T', " ")
}

/// A count with its thousands apart.
fn counted(count: usize) -> String {
    decimal(count as f64, 0)
}

/// The sentences of a caption that say something.
fn caption(sentences: &[String]) -> String {
    let said: Vec<&str> =
        sentences.iter().map(String::as_str).filter(|sentence| !sentence.is_empty()).collect();
    said.join(" ")
}

/// What a caption says about thinned points.
fn thinned(any: bool) -> String {
    if any { "Of points that nearly coincide one is drawn.".to_owned() } else { String::new() }
}
