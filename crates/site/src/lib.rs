//! A site as its owner describes it: the configuration file, its areas and zones, and the territories of a cluster's cells.
//!
//! All other crates read it. It does not know sensors' data, pictures, sockets or HTTP.

pub mod areas;
pub mod config;
pub mod territory;
