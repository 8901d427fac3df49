//! UAS zones: the files that are published, and what is inside by another program's reckoning.

#![expect(clippy::unwrap_used, clippy::disallowed_methods, reason = "a test")]

mod field_cases;
mod geometry;
mod published;
