//! `[map]`.

use std::path::PathBuf;

use tables::kinds::beside;
use tables::section;
use tables::table::absent;

section! {
    /// The map page.
    #[derive(Eq)]
    Map {
        /// Base map below the tracks: a PMTiles file (version 3) of vector tiles. The page loads it from this service only.
        pmtiles: Option<PathBuf> = absent("none, the map has no ground"), beside();
    }
}
