//! UDP in and out.

pub mod listen;
pub mod send;
