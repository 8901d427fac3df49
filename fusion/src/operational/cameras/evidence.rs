//! Evidence that tracks of two cameras show one aircraft.

use serde::{Deserialize, Serialize};

use super::crossing::Passing;
use crate::operational::cycle::{EARLIEST, LATEST};
use crate::operational::likelihood::{OffsetAxis, PlotErrors};
use crate::operational::tuning::{
    CAMERA_CORRELATION_S, CAMERA_LLR_MAX, CAMERA_START_LLR, CAMERA_START_LOOKS, CAMERA_START_S,
    CAMERA_TOGETHER_S, PLOT_LLR_MAX, SEPARATION_IN_HEIGHT,
};
use crate::report::CameraTrackKey;
use crate::time::Time;

/// Two tracks of different cameras, in order.
pub(super) type TrackPair = (CameraTrackKey, CameraTrackKey);

/// Pairs of camera tracks that have begun no target.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct CameraStarts {
    /// Number of pairs in the last slot whose lines cross as those of one aircraft do, while other pairs explain their tracks as well.
    pub undecided: u32,
    /// Number of pairs left out since the start, summed over the slots, because there were too many.
    pub left_out: u64,
}

/// Evidence that two tracks show one aircraft.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct PairEvidence {
    /// Sum of the log-likelihood ratios, one aircraft against two.
    llr: f64,
    /// Penalty for the size of the lasting error that would explain the distance of the lines.
    penalty: f64,
    gap: Option<OffsetAxis>,
    /// Time of the first look compared.
    first: Time,
    /// Time up to which looks are compared.
    pub(super) until: Time,
    /// Time of the last look at which the lines crossed.
    last: Time,
    looks: u32,
}

impl Default for PairEvidence {
    fn default() -> Self {
        Self { llr: 0.0, penalty: 0.0, gap: None, first: LATEST, until: EARLIEST, last: EARLIEST, looks: 0 }
    }
}

impl PairEvidence {
    pub(super) fn total(&self) -> f64 {
        self.llr - self.penalty
    }

    pub(super) fn add(&mut self, time: Time, passing: &Passing) {
        let crossing = match passing {
            Passing::Near(crossing) => crossing,
            Passing::Behind => {
                self.llr = (self.llr - PLOT_LLR_MAX).max(-CAMERA_LLR_MAX);
                return;
            }
            Passing::Parallel => return,
        };
        let errors = PlotErrors::of_lines(crossing.lasting_m, crossing.white_m);
        let axis = match self.gap.take() {
            Some(mut axis) => {
                let dt = time.seconds_since(self.last);
                axis.predict(dt, (-dt / CAMERA_CORRELATION_S).exp(), &errors, &SEPARATION_IN_HEIGHT);
                axis
            }
            None => OffsetAxis::new(&errors, &SEPARATION_IN_HEIGHT),
        };
        let axis = self.gap.insert(axis);
        let llr = axis.observe(crossing.gap_m, &errors).clamp(-PLOT_LLR_MAX, PLOT_LLR_MAX);
        self.llr = (self.llr + llr).clamp(-CAMERA_LLR_MAX, CAMERA_LLR_MAX);
        self.penalty = axis.bias_penalty(&errors);
        self.first = self.first.min(time);
        self.last = time;
        self.looks += 1;
    }

    /// Whether it is likely to be one aircraft, by looks for long enough up to `time`.
    pub(super) fn is_ready(&self, time: Time) -> bool {
        self.total() >= CAMERA_START_LLR
            && self.looks >= CAMERA_START_LOOKS
            && self.last.seconds_since(self.first) >= CAMERA_START_S
            && time.seconds_since(self.last) <= CAMERA_TOGETHER_S
    }
}
