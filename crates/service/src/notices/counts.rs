//! Counts of notices.

/// Reason for the loss of a notice.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NoticeLoss {
    /// The queue was full, and the notice was the oldest of the least severe ones.
    Full,
    /// The receiver rejected it.
    Refused,
    /// The alert had ended too long ago.
    Stale,
}

impl NoticeLoss {
    /// All reasons.
    pub const ALL: [Self; 3] = [Self::Full, Self::Refused, Self::Stale];

    /// Name of the reason in `/metrics`.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Full => "full",
            Self::Refused => "refused",
            Self::Stale => "stale",
        }
    }
}

/// Counts of one receiver, since the start.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct NoticeCounts {
    /// Notices delivered; a summary counts each of its notices.
    pub sent: u64,
    /// Failed attempts.
    pub failed: u64,
    /// Waiting notices.
    pub waiting: usize,
    /// Whether the last attempt failed.
    pub is_failing: bool,
    lost: [u64; NoticeLoss::ALL.len()],
}

impl NoticeCounts {
    /// Notices lost for that reason.
    pub fn lost(&self, loss: NoticeLoss) -> u64 {
        self.lost[loss as usize]
    }

    pub(super) fn lose(&mut self, loss: NoticeLoss) {
        self.lost[loss as usize] += 1;
    }
}
