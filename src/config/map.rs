//! `[map]`.

use std::path::PathBuf;

use tables::kinds::beside;
use tables::section;
use tables::table::absent;

section! {
    /// The map page.
    #[derive(Eq)]
    Map {
        /// The base map: a PMTiles file (version 3) of vector tiles, drawn below the tracks. The page asks no other server for it.
        pmtiles: Option<PathBuf> = absent("none, the map has no ground"), beside();
    }
}
