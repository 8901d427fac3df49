//! The code of the fuzz targets. Tests of the project include these modules and run them on the committed corpus
//! (`asterix/tests/all.rs`, `asterix/tests/corpus.rs`, `tests/captures/corpus.rs`, `tests/decode/corpus.rs`,
//! `tests/gateways/corpus.rs`).

#![forbid(unsafe_code)]

pub mod all;
pub mod captures;
pub mod gateways;
pub mod json;
pub mod records;
