//! UAS zones: the files that are published, and what is inside by another program's reckoning.

mod geometry;
mod published;
