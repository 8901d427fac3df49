//! The offset between plots of one radar and the track of another.

use super::{Offset, PairLikelihood};
use crate::filter::{LineOfSight, RadarErrors};
use crate::frames::Enu;
use crate::operational::settings::Radar;
use crate::report::Plot;
use crate::time::Time;

/// Where another radar's track was at the time of a plot.
#[derive(Clone, Copy, Debug)]
pub(in crate::operational) struct Reference {
    pub(in crate::operational) position: Enu,
    pub(in crate::operational) height_measured: bool,
    /// Sigma of interpolating between its plots, metres.
    pub(in crate::operational) between_m: f64,
    /// The other radar's place and errors.
    pub(in crate::operational) radar: Enu,
    pub(in crate::operational) errors: RadarErrors,
}

impl PairLikelihood {
    /// Takes in plots of a radar, each with where another radar's track was then, in the order in which they are given:
    /// forward or backward in time.
    pub(in crate::operational) fn add_mutual<'a>(
        &mut self,
        plots: impl Iterator<Item = (&'a Plot, Reference)>,
        radar: &Radar,
    ) {
        let mut before: Option<Time> = None;
        for (plot, reference) in plots {
            let dt = before.map_or(radar.period_s, |before| plot.time.seconds_since(before).abs());
            before = Some(plot.time);
            self.add(&offset(plot, &reference, radar), plot.time, dt);
        }
    }
}

/// Along the axes of the plot's radar, with the errors of both.
fn offset(plot: &Plot, reference: &Reference, radar: &Radar) -> Offset {
    let Reference { position, height_measured, between_m, errors: other, .. } = reference;
    let seen = LineOfSight::from(radar.position, plot.position);
    let seen_there = LineOfSight::from(reference.radar, *position);
    let bias = seen_there.spread(other.bias_range_m, other.bias_azimuth);
    let noise = seen_there.spread(other.noise_range_m, other.noise_azimuth);
    let [range, azimuth] = [seen.outward, seen.clockwise].map(|axis| {
        let along = |spread: &nalgebra::Matrix2<f64>| axis.dot(&(spread * axis)).sqrt();
        (along(&bias), along(&noise))
    });
    let own = &radar.errors;
    let both = RadarErrors {
        bias_range_m: own.bias_range_m.hypot(range.0),
        bias_azimuth: own.bias_azimuth.hypot(azimuth.0 / seen.range_m),
        bias_height_m: own.bias_height_m.hypot(other.bias_height_m),
        noise_range_m: own.noise_range_m.hypot(range.1),
        noise_azimuth: own.noise_azimuth.hypot(azimuth.1 / seen.range_m),
        noise_height_m: own.noise_height_m.hypot(other.noise_height_m),
        correlation_s: own.correlation_s.min(other.correlation_s),
    };
    let apart = plot.position.0 - position.0;
    let metres = [
        Some(seen.outward.dot(&apart.xy())),
        Some(seen.clockwise.dot(&apart.xy())),
        (plot.height_measured && *height_measured).then_some(apart.z),
    ];
    Offset::new(metres, seen.range_m, &both, *between_m, &Default::default())
}
