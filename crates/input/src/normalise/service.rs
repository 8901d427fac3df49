//! State that a radar reports of itself.

/// Contents of a radar's service message (CAT034); `None`: not stated.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct Service {
    /// NOGO (I034/050): not released for operational use.
    pub nogo: Option<bool>,
    /// RDPR (I034/050): the processor chain restarts, and track numbers start again.
    pub reset: Option<bool>,
    /// TSV (I034/050): the time source is invalid.
    pub time_invalid: Option<bool>,
    /// A north marker (I034/000 = 1).
    pub north_marker: bool,
    /// Distance between the reported position (I034/120) and the configured one, in whole metres.
    pub displaced_m: Option<u32>,
}
