//! One air picture of drone traffic: radar plots (ASTERIX CAT048) and transponder reports (CAT129) in, fused CAT129 out.

pub mod fusion;
pub mod normalise;
pub mod time;
