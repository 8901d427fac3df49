//! Counts of sent and lost messages.

/// Reason why a second's picture did not reach a sink.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SinkLoss {
    /// The receiver accepts pictures more slowly than they are made.
    Slow,
    /// There was no connection, or it broke.
    Unreachable,
    /// The receiver rejected it.
    Refused,
    /// The service itself was overloaded.
    Overload,
}

impl SinkLoss {
    /// All reasons.
    pub const ALL: [Self; 4] = [Self::Slow, Self::Unreachable, Self::Refused, Self::Overload];

    /// Name of the reason in `/metrics`.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Slow => "slow",
            Self::Unreachable => "unreachable",
            Self::Refused => "refused",
            Self::Overload => "overload",
        }
    }
}

/// Counts of one sink, since the start.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SinkCounts {
    /// Messages sent.
    pub sent: u64,
    /// Tracks that the format cannot represent.
    pub left_out: u64,
    /// Failed attempts.
    pub failed: u64,
    /// Waiting seconds.
    pub waiting: usize,
    /// Whether the last attempt failed.
    pub is_failing: bool,
    lost: [u64; SinkLoss::ALL.len()],
}

impl SinkCounts {
    /// Seconds lost for that reason.
    pub fn lost(&self, loss: SinkLoss) -> u64 {
        self.lost[loss as usize]
    }

    pub(super) fn lose(&mut self, loss: SinkLoss, seconds: usize) {
        self.lost[loss as usize] += seconds as u64;
    }
}
