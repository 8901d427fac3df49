//! `velocity`: the motion of an identity contradicts its reported velocity.

use jiff::SignedDuration;
use nalgebra::Vector2;
use serde::{Deserialize, Serialize};

use super::history::{ReportHistory, TimedReport};
use crate::time::Time;

/// Length of the evaluated period, seconds.
const LOOK_BACK_S: f64 = 20.0;
/// Minimum part of that period with reports, seconds.
const HEARD_S: f64 = 14.0;
/// Longest gap between two reports, seconds.
const GAP_MAX_S: f64 = 5.0;
/// Minimum number of reports in that period.
const REPORTS: u32 = 5;
/// Number of standard deviations beyond which both differ.
const SIGMAS: f64 = 5.0;
/// Minimum share of the difference in each half: a jump lies in one of them.
const HALF_SHARE: f64 = 0.25;
/// Persistent error of reported velocities, m/s: some are truncated to whole m/s.
const STATED_M_S: f64 = 0.5;
/// Maximum age of a reported velocity, seconds, because receivers filter it.
const AGE_S: f64 = 1.0;
/// Acceleration that is not visible between two reports, m/s².
const HIDDEN_M_S2: f64 = 1.0;
/// Minimum white noise of a position on each axis, metres, which covers persistent errors that change within 20 s.
const NOISE_MIN_M: f64 = 2.0;
/// Time for which the finding holds.
const HOLDS: SignedDuration = SignedDuration::from_secs(12);

/// Time of the last contradiction between reported velocity and motion.
#[derive(Debug, Default, Serialize, Deserialize)]
pub(super) struct Velocity {
    last: Option<Time>,
}

/// Displacement minus that of the reported velocity, metres.
#[derive(Debug, Default)]
struct ExcessDisplacement {
    /// Difference in the later and in the earlier half.
    halves: [Vector2<f64>; 2],
    variance_m2: f64,
    reports: u32,
    /// Whether the reported velocity ever changed.
    varies: bool,
}

impl Velocity {
    /// Compares the motion up to the newest report; `noise_m` is the white noise of the receiver, metres on each axis.
    pub(super) fn evaluate(&mut self, history: &ReportHistory, noise_m: impl Fn() -> f64) {
        let Some((newest, velocity)) = history.newest().and_then(with_velocity) else { return };
        let mut excess = ExcessDisplacement::default();
        let (mut later, mut later_velocity) = (newest, velocity);
        for (earlier, earlier_velocity) in history.before(history.len() - 1).map_while(with_velocity) {
            let (step_s, ago_s) = (later.apart_s(earlier), newest.apart_s(earlier));
            if step_s > GAP_MAX_S || ago_s > LOOK_BACK_S {
                break;
            }
            let change = later_velocity - earlier_velocity;
            let stated = (earlier_velocity + later_velocity) * (step_s / 2.0);
            let half = usize::from(ago_s > LOOK_BACK_S / 2.0);
            excess.halves[half] += (later.position - earlier.position).xy() - stated;
            let turned_m = change.norm() * step_s / 6.0;
            let hidden_m = HIDDEN_M_S2 * step_s * step_s / 2.0;
            excess.variance_m2 += turned_m * turned_m + hidden_m * hidden_m;
            excess.varies |= change != Vector2::zeros();
            excess.reports += 1;
            (later, later_velocity) = (earlier, earlier_velocity);
        }
        let heard_s = newest.apart_s(later);
        if heard_s < HEARD_S || excess.reports + 1 < REPORTS || !excess.varies {
            return;
        }
        let aged_m = AGE_S * (velocity - later_velocity).norm();
        excess.variance_m2 += (STATED_M_S * heard_s).powi(2) + aged_m * aged_m;
        if excess.differs(NOISE_MIN_M) && excess.differs(noise_m().max(NOISE_MIN_M)) {
            self.last = Some(newest.time);
        }
    }

    pub(super) fn is_active(&self, deadline: Time) -> bool {
        self.last.is_some_and(|last| deadline <= last + HOLDS)
    }
}

impl ExcessDisplacement {
    fn differs(&self, noise_m: f64) -> bool {
        let [later, earlier] = self.halves;
        let whole = later + earlier;
        let square = whole.norm_squared();
        // The noise of both ends.
        let variance_m2 = self.variance_m2 + 2.0 * noise_m * noise_m;
        square > SIGMAS * SIGMAS * variance_m2
            && self.halves.iter().all(|half| half.dot(&whole) >= HALF_SHARE * square)
    }
}

fn with_velocity(heard: &TimedReport) -> Option<(&TimedReport, Vector2<f64>)> {
    heard.velocity.map(|velocity| (heard, velocity))
}
