//! Measurements of a target from transponder reports and plots, as input of its filter.

use super::ids::TrackletId;
use super::likelihood::PairLikelihood;
use super::settings::{OperationalSettings, RadarSettings};
use super::transponder::{Transponder, lowered};
use super::tuning::{
    FRESH_SHARE, RADAR_VELOCITY_CORRELATION_S, TRANSPONDER_CLIMB_M_S, TRANSPONDER_VELOCITY_M_S,
};
use crate::filter::{Bias, By, LineOfSight, Measurement, Owner};
use crate::report::{Fix, Plot};
use crate::time::Time;

/// Measurement from a transponder's report. A coarse height is ignored if a radar measures the aircraft's height.
pub(super) fn measured_by_transponder(
    fix: &Fix,
    transponder: &Transponder,
    has_radar_height: bool,
    settings: &OperationalSettings,
) -> Option<Measurement> {
    let [horizontal_m, vertical_m] = transponder.white_m(settings.transponder(fix.sensor)?);
    // Most of the stated height error is common to successive reports.
    let vertical_m = fix.height_sigma_m.map_or(vertical_m, |sigma_m| vertical_m.max(sigma_m * FRESH_SHARE));
    Some(Measurement {
        time: fix.time,
        position: lowered(fix.position, settings.height_offset_m(&fix.identity)),
        height_measured: if has_radar_height { fix.has_fine_height() } else { fix.height_measured },
        by: By::Transponder { horizontal_m, vertical_m },
        velocity: fix.velocity.map(|velocity| (velocity, TRANSPONDER_VELOCITY_M_S)),
        climb: fix.climb_m_s.map(|climb| (climb, TRANSPONDER_CLIMB_M_S)),
    })
}

/// Measurement from a plot after the transponder's report of `last`. `pair` estimates the radar's bias up to that report.
pub(super) fn measured_by_radar(
    plot: &Plot,
    tracklet: TrackletId,
    radar: &RadarSettings,
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

/// Measurement of the height of a plot alone.
pub(super) fn height_by_radar(plot: &Plot, radar: &RadarSettings) -> Measurement {
    let errors = &radar.errors;
    // The bias is not a filter state here. Together, the plots of one correlation time have the weight of a single one.
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

/// Sigma of a radar track's velocity for a filter that treats each error as independent. `sigma_m_s`: the true sigma; `period_s`:
/// time between plots, above zero. For errors x' = ρx + w, ρ = exp(-T/τ), the variance of the mean of many is larger by the
/// factor (1+ρ)/(1-ρ) = coth(T/2τ) than with independent errors.
fn correlated_m_s(sigma_m_s: f64, period_s: f64) -> f64 {
    sigma_m_s / (period_s / (2.0 * RADAR_VELOCITY_CORRELATION_S)).tanh().sqrt()
}
