//! That a radar track may have walked off its aircraft before it ended.
//!
//! A radar that loses a target follows something else for some seconds: clutter, a bird, its own prediction. Then the track
//! ends. What is published is seconds old, so by then it is known whether the track goes on; where it does not, its last
//! seconds may have been such a walk, and the place is known that much less well.

use super::cycle::Cycle;
use super::settings::periods;
use super::targets::Target;
use super::tracklets::Tracklets;
use super::tuning::{
    ENDED_AFTER_S, KNOWN_AHEAD_S, TRACK_LASTS_PERIODS, WALK_OFF_LASTS_S, WALK_OFF_SHARE, WALK_OFF_SPEED_M_S,
};

/// What that adds to the variance of a target's place on each axis over ground, m²: nothing while one of its radar tracks goes
/// on.
pub(super) fn of_target(target: &Target, tracklets: &Tracklets, cycle: &Cycle) -> f64 {
    let Some(last) = target.followed(tracklets).max_by_key(|tracklet| tracklet.last()) else { return 0.0 };
    let lasting_s = cycle
        .settings
        .radar(last.key.sensor)
        .map_or(0.0, |radar| periods(TRACK_LASTS_PERIODS, radar.period_s).as_secs_f64());
    let remaining_s = last.last().seconds_since(cycle.centre);
    let has_ended = KNOWN_AHEAD_S - remaining_s > ENDED_AFTER_S.max(lasting_s);
    if has_ended { variance_m2(remaining_s.max(0.0)) } else { 0.0 }
}

/// Variance of the place on each axis over ground, m², of a track that ends `remaining_s` later: the share of tracks that end
/// by walking off, times the mean square of how far one has got by then that lasts evenly between the two times.
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
    fn the_variance_is_that_of_simulated_walks() {
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
