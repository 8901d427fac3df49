//! How long an aircraft flies straight on.

/// Maximum number of earlier legs that are remembered.
pub(super) const LEGS: usize = 6;
/// Weight of the prior distribution, in legs.
const PRIOR: f64 = 1.0;
/// Shape of the prior distribution (Lomax): the longer an aircraft has flown straight, the longer it will.
const SHAPE: i32 = 3;
/// Deviation of the duration of a leg from that of an earlier one: share of it, and seconds.
const DEVIATION: f64 = 0.15;
const DEVIATION_S: f64 = 5.0;
/// Ratio of the scales of a logistic and a normal distribution.
const LOGISTIC: f64 = 1.7;

/// Expectation of how long straight flight lasts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum LegOutlook {
    /// Mean duration, seconds; the aircraft has no known leg.
    Unknown(f64),
    /// The leg has lasted for a while, after others.
    Leg {
        lasted_s: f64,
        /// Mean duration without earlier legs, seconds.
        prior_s: f64,
        /// Durations of earlier legs, seconds, of which `count` are valid.
        before_s: [f64; LEGS],
        count: usize,
    },
}

impl LegOutlook {
    /// The outlook of a leg that has lasted `lasted_s` seconds, after legs of these durations.
    pub(super) fn after(lasted_s: f64, prior_s: f64, before: &[f64]) -> Self {
        let mut before_s = [0.0; LEGS];
        let count = before.len().min(LEGS);
        before_s[..count].copy_from_slice(&before[..count]);
        Self::Leg { lasted_s, prior_s, before_s, count }
    }

    /// Probability that it lasts for `t` seconds from now.
    pub(super) fn survival(&self, t: f64) -> f64 {
        match self {
            Self::Unknown(mean_s) => (-t / mean_s).exp(),
            Self::Leg { lasted_s, prior_s, before_s, count } => {
                let longer = |at_s: f64| {
                    let prior = (1.0 + at_s / (f64::from(SHAPE) * prior_s)).powi(-SHAPE);
                    let earlier = before_s[..*count].iter().map(|leg_s| {
                        let away = (at_s - leg_s) / (DEVIATION * leg_s + DEVIATION_S);
                        (1.0 + libm::exp(LOGISTIC * away)).recip()
                    });
                    PRIOR * prior + earlier.sum::<f64>()
                };
                (longer(lasted_s + t) / longer(*lasted_s)).min(1.0)
            }
        }
    }
}
