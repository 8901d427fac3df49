//! An evaluation as pictures: SVG figures as the paper's Figures 6 and 9 to 13, one of what a registration leaves, one of an encounter, and one HTML page with its Table 1.
//!
//! Strings only: the caller writes the files. The same evaluation gives the same bytes. Values that are not finite are
//! left out; ids are escaped. SVG is written here because plotting libraries round each point to a whole pixel, spend a
//! hundred octets on it, and know neither `<title>` nor `<desc>`.

mod axis;
mod chart;
pub mod curves;
mod encounter;
mod errors;
mod figure;
mod flat;
mod inputs;
mod page;
mod residuals;
mod space;
mod style;
mod svg;
#[cfg(test)]
mod tests;
mod thin;

pub use encounter::encounter;
pub use figure::{Figure, TruthLine};
pub use page::page;

use super::place::Place;
use super::residuals::RadarResiduals;
use super::types::{Evaluation, PointSource};
use figure::{Clock, Stream};
use fusion::settings::Threshold;
use style::Style;

/// What figures need besides an evaluation; what is not known is not drawn.
#[derive(Clone, Copy, Debug, Default)]
pub struct Setting<'a> {
    /// The first radar's position.
    pub site: Option<Place>,
    /// The reference profile's threshold of distances.
    pub threshold: Option<&'a Threshold>,
    /// What the radars' registrations leave.
    pub residuals: &'a [RadarResiduals],
}

/// All figures of an evaluation; one with nothing to show says so.
///
/// `error-over-time`, `error-over-range`, `error-over-azimuth`, `plan-view`, `height-over-time`,
/// `error-distribution`, `radar-tracks`, `threshold`, `registration-residuals`.
pub fn figures(evaluation: &Evaluation, truth: &[TruthLine<'_>], setting: &Setting<'_>) -> Vec<Figure> {
    let streams = streams(evaluation);
    let clock = Clock::of(&streams, truth);
    vec![
        errors::over_time(&streams, clock),
        errors::over_range(&streams),
        errors::over_azimuth(&streams),
        space::plan_view(&streams, truth),
        space::height_over_time(&streams[0], truth, clock),
        errors::distribution(&streams),
        inputs::radar_tracks(&streams, truth, clock),
        inputs::threshold(&streams, setting),
        residuals::registration(setting.residuals),
    ]
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
