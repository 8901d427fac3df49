//! UAS zones: the files that are published, and what is inside by another program's reckoning.

#![expect(clippy::unwrap_used, clippy::disallowed_methods, reason = "a test")]

mod geometry;
mod published;
