//! What the fuzz targets do with their input. The same is done to the committed corpus by the project's tests
//! (`asterix/tests/all.rs`, `asterix/tests/corpus.rs`, `tests/captures/corpus.rs`, `tests/decode/corpus.rs`, `tests/gateways/corpus.rs`), which include these modules.

#![forbid(unsafe_code)]

pub mod all;
pub mod captures;
pub mod gateways;
pub mod json;
pub mod records;
