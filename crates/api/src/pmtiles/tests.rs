//! A file written by the specification's reference library, and invalid files.

use std::fs;
use std::path::{Path, PathBuf};

use super::*;

fn kept() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../testdata/basemap/site.pmtiles")
}

/// A new file for this test.
fn scratch(name: &str) -> PathBuf {
    std::env::temp_dir().join(format!("utm-fusion-basemap-{}-{name}", std::process::id()))
}

#[test]
fn tiles_are_numbered_along_the_curve() {
    // Numbers from the specification: zoom 0, the four tiles of zoom 1, the first and one of the last of other zooms.
    let numbers = [
        ((0, 0, 0), 0),
        ((1, 0, 0), 1),
        ((1, 0, 1), 2),
        ((1, 1, 1), 3),
        ((1, 1, 0), 4),
        ((2, 0, 0), 5),
        ((12, 3423, 1763), 19_078_479),
    ];
    for ((zoom, x, y), number) in numbers {
        assert_eq!(tile_number(zoom, x, y), Some(number), "{zoom}/{x}/{y}");
    }
    assert_eq!(tile_number(1, 2, 0), None);
    assert_eq!(tile_number(32, 0, 0), None);
    // Consecutive tiles on the curve are adjacent on the map.
    let mut tiles: Vec<_> = (0..16_u32).flat_map(|x| (0..16_u32).map(move |y| (x, y))).collect();
    tiles.sort_by_key(|&(x, y)| tile_number(4, x, y).unwrap());
    assert!(tiles.windows(2).all(|pair| pair[0].0.abs_diff(pair[1].0) + pair[0].1.abs_diff(pair[1].1) == 1));
}

#[test]
fn exactly_the_tiles_of_a_file_are_found() {
    let map = Basemap::open(&kept()).unwrap();
    assert_eq!(map.zooms(), (0, 14));
    assert_eq!(map.attribution(), "© nobody & everybody");
    // The leaf directories are read in the first round and taken from the cache in the second.
    for _ in 0..2 {
        for zoom in 0..=14_u8 {
            let (x, y) = (8165_u32 >> (14 - zoom), 5374_u32 >> (14 - zoom));
            let tile = map.tile(zoom, x, y).unwrap();
            assert!(tile.is_some_and(|tile| tile.windows(5).any(|name| name == b"water")), "{zoom}/{x}/{y}");
        }
    }
    assert_eq!(map.tile(14, 0, 0).unwrap(), None);
    assert_eq!(map.tile(15, 16_330, 10_748).unwrap(), None);
}

#[test]
fn invalid_file_is_refused_with_a_reason() {
    let whole = fs::read(kept()).unwrap();
    let with = |at: usize, octet: u8| {
        let mut octets = whole.clone();
        octets[at] = octet;
        octets
    };
    let path = scratch("wrong");
    for (octets, cause) in [
        (whole[..100].to_vec(), "shorter than the header"),
        (b"SQLite format 3\0".repeat(10), "no PMTiles file"),
        (with(7, 2), "version 2"),
        (with(98, 3), "Brotli"),
        (with(99, 2), "pictures"),
        (whole[..200].to_vec(), "cut short"),
        (with(15, 255), "cut short"),
    ] {
        fs::write(&path, octets).unwrap();
        let error = Basemap::open(&path).unwrap_err().to_string();
        assert!(error.contains(cause), "{error}, not {cause}");
    }
}

#[test]
fn broken_directories_are_errors_without_panic() {
    let whole = fs::read(kept()).unwrap();
    let path = scratch("broken");
    for at in (8..whole.len()).step_by(3) {
        let mut octets = whole.clone();
        octets[at] ^= 0x5a;
        fs::write(&path, octets).unwrap();
        if let Ok(map) = Basemap::open(&path) {
            for zoom in 0..=14_u8 {
                let _ = map.tile(zoom, 8165 >> (14 - zoom), 5374 >> (14 - zoom));
            }
        }
    }
}
