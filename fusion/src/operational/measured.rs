//! What reports and plots measure of a target, as its filter takes it.

use super::ids::TrackletId;
use super::likelihood::PairLikelihood;
use super::settings::{Radar, Settings};
use super::transponder::Transponder;
use super::tuning::{
    FRESH_SHARE, RADAR_VELOCITY_CORRELATION_S, TRANSPONDER_CLIMB_M_S, TRANSPONDER_VELOCITY_M_S,
};
use crate::filter::{Bias, By, LineOfSight, Measurement, Owner};
use crate::report::{Fix, Plot};
use crate::time::Time;

/// A report of a transponder. A coarse height is passed over where a radar measures the aircraft's height.
pub(super) fn measured_by_transponder(
    fix: &Fix,
    transponder: &Transponder,
    has_radar_height: bool,
    settings: &Settings,
) -> Option<Measurement> {
    let [horizontal_m, vertical_m] = transponder.white_m(settings.transponder(fix.sensor)?);
    // Most of what is stated stays from report to report.
    let vertical_m = fix.height_sigma_m.map_or(vertical_m, |sigma_m| vertical_m.max(sigma_m * FRESH_SHARE));
    Some(Measurement {
        time: fix.time,
        position: fix.position,
        height_measured: if has_radar_height { fix.has_fine_height() } else { fix.height_measured },
        by: By::Transponder { horizontal_m, vertical_m },
        velocity: fix.velocity.map(|velocity| (velocity, TRANSPONDER_VELOCITY_M_S)),
        climb: fix.climb_m_s.map(|climb| (climb, TRANSPONDER_CLIMB_M_S)),
    })
}

/// A plot, after the transponder's report of `last`, up to which `pair` tells the radar's bias.
pub(super) fn measured_by_radar(
    plot: &Plot,
    tracklet: TrackletId,
    radar: &Radar,
    last: Option<Time>,
    pair: Option<PairLikelihood>,
) -> Measurement {
    let seen = LineOfSight::from(radar.position, plot.position);
    let known = pair
        .zip(last)
        .and_then(|(pair, last)| pair.bias(seen.range_m, plot.time.seconds_since(last), &radar.errors));
    Measurement {
        time: plot.time,
        position: plot.position,
        height_measured: plot.height_measured,
        by: By::Radar {
            owner: Owner { radar: plot.track.sensor, tracklet: tracklet.of_radar(), since: last },
            known: known.unwrap_or(Bias::of(&radar.errors)),
            seen,
            errors: radar.errors,
        },
        velocity: plot
            .velocity
            .zip(radar.velocity_sigma_m_s)
            .map(|(velocity, sigma_m_s)| (velocity, correlated_m_s(sigma_m_s, radar.period_s))),
        climb: None,
    }
}

/// The height of a plot, and nothing else of it.
pub(super) fn height_by_radar(plot: &Plot, radar: &Radar) -> Measurement {
    let errors = &radar.errors;
    // Its bias is no state here: as many plots as its correlation time spans tell of it as one would.
    let spans = (2.0 * errors.correlation_s / radar.period_s.max(0.01)).max(1.0);
    Measurement {
        time: plot.time,
        position: plot.position,
        height_measured: true,
        velocity: None,
        climb: None,
        by: By::Height {
            sensor: plot.track.sensor,
            sigma_m: (errors.bias_height_m * spans.sqrt()).hypot(errors.noise_height_m),
        },
    }
}

/// Sigma for a radar track's velocity, by itself so wrong, that comes every `period_s` seconds, above zero. Its errors are correlated, and the
/// filter takes each as new: the mean of many that go by x' = ρx + w, ρ = exp(-T/τ), has (1+ρ)/(1-ρ) = coth(T/2τ) times the
/// variance that it would have of new ones.
fn correlated_m_s(sigma_m_s: f64, period_s: f64) -> f64 {
    sigma_m_s / (period_s / (2.0 * RADAR_VELOCITY_CORRELATION_S)).tanh().sqrt()
}
