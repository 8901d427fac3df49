//! What has become of what was to be sent.

/// Why a second's picture did not reach a sink.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Loss {
    /// The receiver takes pictures more slowly than they come.
    Slow,
    /// There was no connection, or it broke.
    Unreachable,
    /// The receiver does not want it.
    Refused,
    /// The service itself had no time for it.
    Overload,
}

impl Loss {
    /// All reasons.
    pub const ALL: [Self; 4] = [Self::Slow, Self::Unreachable, Self::Refused, Self::Overload];

    /// Its name in `/metrics`.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Slow => "slow",
            Self::Unreachable => "unreachable",
            Self::Refused => "refused",
            Self::Overload => "overload",
        }
    }
}

/// Of one sink, since the start.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Messages that were sent.
    pub sent: u64,
    /// Tracks that its format cannot hold.
    pub left_out: u64,
    /// Attempts that failed.
    pub failed: u64,
    /// Seconds that wait.
    pub waiting: usize,
    /// The last attempt failed.
    pub is_failing: bool,
    lost: [u64; Loss::ALL.len()],
}

impl Counts {
    /// Seconds that were lost for that reason.
    pub fn lost(&self, loss: Loss) -> u64 {
        self.lost[loss as usize]
    }

    pub(super) fn lose(&mut self, loss: Loss, seconds: usize) {
        self.lost[loss as usize] += seconds as u64;
    }
}
