//! Possibility that a radar track has drifted off its aircraft.
//!
//! A radar that loses a target follows something else for some seconds: clutter, a bird, its own prediction. Then the
//! track ends. Slots are decided seconds later, so by then it is known whether the track continues. If it does not, its
//! last seconds may be such a drift, and the variance of the position is larger. If it continues for as long as is
//! known, the drift may last even longer, which is much less likely.

use super::cycle::Cycle;
use super::settings::periods;
use super::targets::Target;
use super::tracklets::{Tracklet, Tracklets};
use super::tuning::{
    ENDED_AFTER_S, KNOWN_AHEAD_S, TRACK_LASTS_PERIODS, WALK_OFF_LASTS_S, WALK_OFF_SHARE, WALK_OFF_SPEED_M_S,
    WALK_OFFS_HZ,
};

/// Variance added to a target's position on each axis over ground, m²; zero while two radars detect it.
pub(super) fn of_target(target: &Target, tracklets: &Tracklets, cycle: &Cycle) -> f64 {
    let Some(last) = target.followed(tracklets).max_by_key(|tracklet| tracklet.last()) else { return 0.0 };
    let remaining_s = last.last().seconds_since(cycle.centre);
    match cycle.silent_s(last.last()) > ended_after_s(last, cycle) {
        true => variance_m2(remaining_s.max(0.0)),
        // Another radar's track would have separated from it.
        false if target.followed(tracklets).nth(1).is_some() => 0.0,
        false => continuing_m2(remaining_s),
    }
}

/// Time without plots after which a radar track counts as ended, seconds.
fn ended_after_s(tracklet: &Tracklet, cycle: &Cycle) -> f64 {
    let radar = cycle.settings.radar(tracklet.key.sensor);
    let lasting_s = radar.map_or(0.0, |radar| periods(TRACK_LASTS_PERIODS, radar.period_s).as_secs_f64());
    ENDED_AFTER_S.max(lasting_s)
}

/// Whether a radar track is present in the slot: it spans the slot or, if later plots are not known yet, it has not
/// ended.
pub(super) fn is_present(tracklet: &Tracklet, cycle: &Cycle) -> bool {
    let may_go_on = || cycle.silent_s(tracklet.last()) <= ended_after_s(tracklet, cycle).min(KNOWN_AHEAD_S);
    tracklet.first() < cycle.end && (tracklet.last() >= cycle.begin || may_go_on())
}

/// Variance for a track that continues for at least `known_s`, m²: the rate at which drifts begin, times the integral
/// over their possible starts of the mean square distance, for those that last longer.
fn continuing_m2(known_s: f64) -> f64 {
    let [least_s, most_s] = WALK_OFF_LASTS_S;
    let fourth = |lasts_s: f64| (lasts_s - known_s).max(0.0).powi(4);
    let elapsed_s3 = (fourth(most_s) - fourth(least_s)) / (12.0 * (most_s - least_s));
    0.5 * WALK_OFFS_HZ * WALK_OFF_SPEED_M_S * WALK_OFF_SPEED_M_S * elapsed_s3
}

/// Variance of the position on each axis over ground, m², for a track that ends `remaining_s` later: the share of
/// tracks that end by drifting off, times the mean square distance by then, for durations distributed evenly between
/// the two limits.
pub(super) fn variance_m2(remaining_s: f64) -> f64 {
    let [least_s, most_s] = WALK_OFF_LASTS_S;
    let cubed = |lasts_s: f64| (lasts_s - remaining_s).max(0.0).powi(3);
    let elapsed_s2 = (cubed(most_s) - cubed(least_s)) / (3.0 * (most_s - least_s));
    0.5 * WALK_OFF_SHARE * WALK_OFF_SPEED_M_S * WALK_OFF_SPEED_M_S * elapsed_s2
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn continuing_track_variance_matches_simulated_walks() {
        for known_s in [0.0, 3.5, 6.0, 9.9, 12.0] {
            let [least_s, most_s] = WALK_OFF_LASTS_S;
            let (steps, step_s) = (1000, 0.01);
            let mut sum = 0.0;
            for lasting in 0..steps {
                let lasts_s = least_s + (most_s - least_s) * (f64::from(lasting) + 0.5) / f64::from(steps);
                // The drift began `began_s` ago, and lasts for longer than is known.
                let began = (0..1000).map(|index| (f64::from(index) + 0.5) * step_s);
                let on_it = began.take_while(|began_s| began_s + known_s < lasts_s);
                sum += on_it.map(|began_s| (began_s * WALK_OFF_SPEED_M_S).powi(2) * step_s).sum::<f64>();
            }
            let expected_m2 = 0.5 * WALK_OFFS_HZ * sum / f64::from(steps);
            let is_m2 = continuing_m2(known_s);
            assert!(
                (is_m2 - expected_m2).abs() < 0.01 + 1e-3 * expected_m2,
                "{known_s}: {is_m2} {expected_m2}"
            );
            assert!(is_m2 < variance_m2(0.0), "a walk that is over was likelier");
        }
    }

    #[test]
    fn variance_matches_simulated_walks() {
        for remaining_s in [0.0, 1.5, 4.0, 7.0, 9.9, 12.0] {
            let [least_s, most_s] = WALK_OFF_LASTS_S;
            let count = 100_000;
            let squares = (0..count).map(|step| {
                let lasts_s = least_s + (most_s - least_s) * (step as f64 + 0.5) / f64::from(count);
                ((lasts_s - remaining_s).max(0.0) * WALK_OFF_SPEED_M_S).powi(2)
            });
            let mean = squares.sum::<f64>() / f64::from(count);
            assert!((variance_m2(remaining_s) - 0.5 * WALK_OFF_SHARE * mean).abs() < 1e-3, "{remaining_s}");
        }
    }
}
