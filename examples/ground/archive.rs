//! Writes vector tiles into a PMTiles file (version 3, <https://github.com/protomaps/PMTiles>), uncompressed, so that the octets
//! do not depend on a compressor.

use std::collections::BTreeMap;

use api::pmtiles::tile_number;
use serde_json::json;

use crate::tiles::{BOUNDS_DEG, TileId, ZOOMS};

/// Length of the header, in octets.
const HEADER: usize = 127;
/// The copyright notice: nothing here is to be taken for a real map.
const ATTRIBUTION: &str = "Invented ground of the demo, no real map";

/// The file with these tiles.
pub fn archive(tiles: &BTreeMap<TileId, Vec<u8>>) -> Vec<u8> {
    let number = |&(zoom, x, y): &TileId| tile_number(zoom, x, y).expect("the tile exists");
    let mut sorted: Vec<(u64, &Vec<u8>)> =
        tiles.iter().map(|(tile, octets)| (number(tile), octets)).collect();
    sorted.sort_unstable_by_key(|(number, _)| *number);

    let count = sorted.len() as u64;
    let mut directory = Vec::new();
    varint(&mut directory, count);
    let mut before = 0;
    for (number, _) in &sorted {
        varint(&mut directory, number - before);
        before = *number;
    }
    sorted.iter().for_each(|_| varint(&mut directory, 1));
    sorted.iter().for_each(|(_, octets)| varint(&mut directory, octets.len() as u64));
    // Each tile follows the one before it; the first is at position 0, written as the position plus one.
    (0..sorted.len()).for_each(|index| varint(&mut directory, u64::from(index == 0)));

    let metadata = json!({
        "name": "Invented ground",
        "attribution": ATTRIBUTION,
        "type": "baselayer",
        "vector_layers": LAYERS.map(|id| json!({"id": id, "fields": {"class": "String"}})),
    });
    let metadata = metadata.to_string();
    let data: u64 = sorted.iter().map(|(_, octets)| octets.len() as u64).sum();

    let mut file = b"PMTiles\x03".to_vec();
    let directory_at = HEADER as u64;
    let metadata_at = directory_at + directory.len() as u64;
    let data_at = metadata_at + metadata.len() as u64;
    for (at, length) in [
        (directory_at, directory.len() as u64),
        (metadata_at, metadata.len() as u64),
        (data_at, 0),
        (data_at, data),
    ] {
        file.extend(at.to_le_bytes());
        file.extend(length.to_le_bytes());
    }
    // Tiles addressed, entries, and contents: here the same.
    (0..3).for_each(|_| file.extend(count.to_le_bytes()));
    // In the order of tile numbers; directories and tiles uncompressed; vector tiles.
    file.extend([1, 1, 1, 1]);
    file.extend([ZOOMS.0, ZOOMS.1]);
    let [west, south, east, north] = BOUNDS_DEG;
    let degrees = |value: f64| ((value * 1e7).round() as i32).to_le_bytes();
    [west, south, east, north].map(degrees).iter().for_each(|octets| file.extend(octets));
    file.push(ZOOMS.1);
    [(west + east) / 2.0, (south + north) / 2.0].map(degrees).iter().for_each(|octets| file.extend(octets));
    debug_assert_eq!(file.len(), HEADER);
    file.extend(&directory);
    file.extend(metadata.as_bytes());
    sorted.iter().for_each(|(_, octets)| file.extend(*octets));
    file
}

/// Layers of the tiles.
const LAYERS: [&str; 8] =
    ["landcover", "landuse", "water", "waterway", "building", "transportation", "aeroway", "place"];

/// Appends an integer: seven bits per octet, lowest first; all octets but the last have their highest bit set.
fn varint(octets: &mut Vec<u8>, mut value: u64) {
    while value >= 0x80 {
        octets.push(value as u8 | 0x80);
        value >>= 7;
    }
    octets.push(value as u8);
}
