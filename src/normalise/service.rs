//! What a radar says of itself.

/// What a service message (CAT034) tells about its radar; `None`: the message does not say.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct Service {
    /// NOGO (I034/050): not released for operational use.
    pub nogo: Option<bool>,
    /// RDPR (I034/050): the processor chain restarts, track numbers begin anew.
    pub reset: Option<bool>,
    /// TSV (I034/050): the time source is invalid.
    pub time_invalid: Option<bool>,
    /// A north marker (I034/000 = 1).
    pub north_marker: bool,
    /// How far the position that it says (I034/120) is from the configured one, whole metres.
    pub displaced_m: Option<u32>,
}
