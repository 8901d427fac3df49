//! What has become of notices.

/// Why a notice was lost.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Loss {
    /// Too many waited, and it was the oldest of the least severe ones.
    Full,
    /// The receiver does not want it.
    Refused,
    /// What it is about was long over.
    Stale,
}

impl Loss {
    /// All reasons.
    pub const ALL: [Self; 3] = [Self::Full, Self::Refused, Self::Stale];

    /// Its name in `/metrics`.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Full => "full",
            Self::Refused => "refused",
            Self::Stale => "stale",
        }
    }
}

/// Of one receiver, since the start.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Notices that it took; a summary counts as all that are in it.
    pub sent: u64,
    /// Attempts that failed.
    pub failed: u64,
    /// Notices that wait.
    pub waiting: usize,
    /// The last attempt failed.
    pub is_failing: bool,
    lost: [u64; Loss::ALL.len()],
}

impl Counts {
    /// Notices that were lost for that reason.
    pub fn lost(&self, loss: Loss) -> u64 {
        self.lost[loss as usize]
    }

    pub(super) fn lose(&mut self, loss: Loss) {
        self.lost[loss as usize] += 1;
    }
}
