//! Trials without sensors: [`simulate`] writes what sensors would have sent in a scenario, [`evaluate`] compares a result with the
//! truth.

pub mod evaluate;
pub mod simulate;
