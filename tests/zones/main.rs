//! UAS zones: published files, and positions compared with another program.

#![expect(clippy::unwrap_used, clippy::disallowed_methods, reason = "a test")]

mod field_cases;
mod geometry;
mod published;
