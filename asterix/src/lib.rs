//! ASTERIX.
#![allow(clippy::module_inception)]
mod block;
mod fault;
mod fspec;
mod items;
mod uap;
mod variable;

pub mod cat048;
pub mod cat129;

pub use block::{Block, BlockTooLong, Blocks, Located, Record, Records, blocks, encode_block};
pub use fault::{Fault, FaultKind};
pub use fspec::Fspec;
pub use items::{DataSource, TimeOfDay};
pub use uap::{Format, UapItem};
pub use variable::{Chain, Explicit, RawItem};
