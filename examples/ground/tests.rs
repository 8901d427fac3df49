//! The committed file is the one that this program writes, and the service reads it.

use api::pmtiles::Basemap;

use crate::feature::Shape;
use crate::shapes::{chance, curve};
use crate::{clip, country, octets};

const COMMITTED: &[u8] = include_bytes!("../../config/ground.pmtiles");

#[test]
fn committed_file_is_written_to_the_octet() {
    assert!(octets() == COMMITTED, "cargo run --example ground writes another file");
    assert!(COMMITTED.len() < 200_000, "{} octets", COMMITTED.len());
}

#[test]
fn tile_of_the_showground_has_every_layer() {
    let map = Basemap::embedded(COMMITTED).unwrap();
    assert_eq!(map.zooms(), (10, 14));
    assert_eq!(map.attribution(), "Invented ground of the demo, no real map");
    let tile = |zoom: u8, latitude_deg: f64, longitude_deg: f64| {
        let side = f64::from(1_u32 << zoom);
        let y = 0.5 - latitude_deg.to_radians().sin().atanh() / std::f64::consts::TAU;
        let x = longitude_deg / 360.0 + 0.5;
        map.tile(zoom, (x * side) as u32, (y * side) as u32).unwrap()
    };
    let has = |tile: &[u8], text: &str| tile.windows(text.len()).any(|octets| octets == text.as_bytes());
    let showground = tile(14, 52.516, -0.572).unwrap();
    for layer in ["landcover", "landuse", "water", "building", "transportation", "place", "Ghost Farm"] {
        assert!(has(&showground, layer), "{layer}");
    }
    let far = tile(10, 52.516, -0.572).unwrap();
    assert!(has(&far, "water") && !has(&far, "building"));
    assert_eq!(tile(14, 53.5, -0.572), None);
}

#[test]
fn every_feature_lies_within_the_bounds() {
    for feature in country::features() {
        let (Shape::Line(places) | Shape::Area(places)) = &feature.shape else { continue };
        let is_near = places.iter().flatten().all(|metres| metres.abs() <= 11_200.0);
        assert!(is_near, "{} {}", feature.layer, feature.class);
        assert!(places.len() > 1);
    }
}

#[test]
fn clipped_shapes_stay_within_the_square() {
    let inside =
        |places: &[[f64; 2]]| places.iter().flatten().all(|value| (-1e-9..=10.0 + 1e-9).contains(value));
    let square = clip::area(&[[-5.0, -5.0], [15.0, -5.0], [15.0, 15.0], [-5.0, 15.0]], 0.0, 10.0);
    assert!(inside(&square) && square.len() == 4, "{square:?}");
    assert!(clip::area(&[[11.0, 0.0], [12.0, 0.0], [12.0, 5.0]], 0.0, 10.0).is_empty());
    // Leaves through one side and comes back through another.
    let parts = clip::line(&[[5.0, 5.0], [5.0, 20.0], [-20.0, 5.0], [5.0, 5.0]], 0.0, 10.0);
    assert_eq!(parts.len(), 2);
    assert!(parts.iter().all(|part| inside(part)));
    assert_eq!(parts[0], [[5.0, 5.0], [5.0, 10.0]]);
}

#[test]
fn curve_passes_through_its_places() {
    let places = [[0.0, 0.0], [100.0, 50.0], [300.0, -20.0]];
    let line = curve(&places);
    assert!(places.iter().all(|place| line.contains(place)));
    assert!((0..1000).all(|key| (0.0..=1.0).contains(&chance(key))));
}
