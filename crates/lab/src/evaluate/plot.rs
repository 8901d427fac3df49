//! Figures of an evaluation as SVG: the paper's Figures 6 and 9 to 13, registration residuals, and an encounter. Also
//! an HTML page with the paper's Table 1.
//!
//! This module returns strings; the caller writes the files. The same evaluation gives the same bytes. Values that are
//! not finite are omitted; ids are escaped. SVG is written here because plotting libraries round each point to a whole
//! pixel, use a hundred octets per point, and do not support `<title>` and `<desc>`.

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

use super::place::GeodeticPlace;
use super::residuals::RadarResiduals;
use super::types::{Evaluation, PointSource};
use figure::{PlotClock, PlotStream};
use fusion::settings::Threshold;
use style::Style;

/// Additional inputs of figures. Unknown ones are not drawn.
#[derive(Clone, Copy, Debug, Default)]
pub struct Setting<'a> {
    /// Position of the first radar.
    pub site: Option<GeodeticPlace>,
    /// Distance threshold of the reference profile.
    pub threshold: Option<&'a Threshold>,
    /// Residuals of the radars' registrations.
    pub residuals: &'a [RadarResiduals],
}

/// All figures of an evaluation; a figure without data says so.
///
/// `error-over-time`, `error-over-range`, `error-over-azimuth`, `plan-view`, `height-over-time`,
/// `error-distribution`, `radar-tracks`, `threshold`, `registration-residuals`.
pub fn figures(evaluation: &Evaluation, truth: &[TruthLine<'_>], setting: &Setting<'_>) -> Vec<Figure> {
    let streams = streams(evaluation);
    let clock = PlotClock::of(&streams, truth);
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

/// The output, then the available inputs.
fn streams(evaluation: &Evaluation) -> Vec<PlotStream<'_>> {
    let inputs = [
        ("fused output", PointSource::Fused, Some(&evaluation.fused)),
        ("radar plots", PointSource::Radar, evaluation.radar.as_ref()),
        ("transponder", PointSource::Transponder, evaluation.transponder.as_ref()),
    ];
    let there = inputs.into_iter().filter_map(|(name, source, scored)| Some((name, source, scored?)));
    there
        .map(|(name, source, scored)| PlotStream { name, style: Style::of(source), samples: &scored.samples })
        .collect()
}
