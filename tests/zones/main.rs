//! UAS zones: the files that are published, and what is inside them by another program's reckoning.

#[path = "../shared/mod.rs"]
mod shared;

mod geometry;
mod published;
