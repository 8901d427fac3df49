//! Trials without sensors: [`simulate`] writes what sensors would have sent in a scenario, [`evaluate`] compares a result with the
//! truth. [`assess`] reports what a recording shows of its sensors and of the picture.

pub mod assess;
pub mod evaluate;
pub mod simulate;
