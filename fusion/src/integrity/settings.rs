//! Settings of the integrity checks.

/// Settings of the integrity checks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct IntegrityRules {
    /// Action on a transponder that reports false positions.
    pub action: Action,
    /// Index above which an identity is suspect (default 8.5).
    pub on: f64,
    /// Index below which an identity is no longer suspect (default 2).
    pub off: f64,
    /// Protection level up to which an identity is verified, metres (default 100).
    pub alert_limit_m: f64,
    /// Whether the covariance of a suspect includes its offset.
    pub accuracy: bool,
    /// Whether a radar track away from a suspect's positions is published as an aircraft of its own once it has lasted 2 s.
    pub show_twin: bool,
    /// Whether a suspect is ignored in the registration and in the association of others.
    pub protect: bool,
}

impl Default for IntegrityRules {
    fn default() -> Self {
        Self {
            action: Action::Flag,
            on: 8.5,
            off: 2.0,
            alert_limit_m: 100.0,
            accuracy: true,
            show_twin: true,
            protect: true,
        }
    }
}

/// Action on a transponder that reports false positions.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Action {
    /// Integrity is not computed.
    Off,
    /// The transponder is flagged.
    #[default]
    Flag,
    /// The transponder is flagged, and published at its reported position, separate from the radar's aircraft.
    Split,
}
