//! What the engine finds of transponders, on its way to the interfaces. Sans-IO: live and replay take the same steps.

mod flags;
mod lookout;

pub use flags::Flags;
pub use lookout::{Lookout, Resolved};
