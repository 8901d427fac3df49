//! Features as vector tiles (Mapbox Vector Tile 2.1, <https://github.com/mapbox/vector-tile-spec>).

use std::collections::BTreeMap;
use std::f64::consts::PI;

use nalgebra::Vector3;
use prost::Message;
use world::ground::Ground;
use world::scenario::Place as ScenarioPlace;

use crate::clip;
use crate::feature::{Feature, Place, Shape};

/// Zoom, column and row of a tile.
pub type TileId = (u8, u32, u32);

/// Lowest and highest zoom.
pub const ZOOMS: (u8, u8) = (10, 14);
/// Bounds of the ground: west, south, east and north, degrees.
pub const BOUNDS_DEG: [f64; 4] = [-0.75, 52.41, -0.41, 52.61];
/// Width and height of a tile, in units.
const EXTENT: f64 = 4096.0;
/// Features continue by this much beyond the edge of a tile, so that the ends of lines are not seen, in units.
const MARGIN: f64 = 64.0;
/// Minimum distance between two corners of a line or area, in units. A pixel of the page has 8.
const LEAST: i64 = 3;

/// A tile.
#[derive(Message)]
struct Tile {
    #[prost(message, repeated, tag = "3")]
    layers: Vec<Layer>,
}

/// A layer of a tile.
#[derive(Message)]
struct Layer {
    #[prost(string, tag = "1")]
    name: String,
    #[prost(message, repeated, tag = "2")]
    features: Vec<TileFeature>,
    #[prost(string, repeated, tag = "3")]
    keys: Vec<String>,
    #[prost(message, repeated, tag = "4")]
    values: Vec<TileValue>,
    #[prost(uint32, tag = "5")]
    extent: u32,
    #[prost(uint32, tag = "15")]
    version: u32,
}

/// A feature of a layer.
#[derive(Message)]
struct TileFeature {
    #[prost(uint32, repeated, tag = "2")]
    tags: Vec<u32>,
    #[prost(uint32, tag = "3")]
    kind: u32,
    #[prost(uint32, repeated, tag = "4")]
    geometry: Vec<u32>,
}

/// A value of an attribute.
#[derive(Message)]
struct TileValue {
    #[prost(string, tag = "1")]
    text: String,
}

const POINT: u32 = 1;
const LINE: u32 = 2;
const AREA: u32 = 3;

/// The tiles with these features, encoded.
pub fn tiles(features: &[Feature]) -> BTreeMap<TileId, Vec<u8>> {
    let ground = Ground::new(&ScenarioPlace::default());
    let projected: Vec<(&Feature, Vec<Place>)> = features
        .iter()
        .map(|feature| {
            let places = match &feature.shape {
                Shape::Point(place) => std::slice::from_ref(place),
                Shape::Line(places) | Shape::Area(places) => places,
            };
            (feature, places.iter().map(|place| mercator(&ground, *place)).collect())
        })
        .collect();
    let mut tiles = BTreeMap::new();
    for zoom in ZOOMS.0..=ZOOMS.1 {
        let scale = f64::from(1_u32 << zoom);
        let mut layers: BTreeMap<(u32, u32), Vec<Layer>> = BTreeMap::new();
        for (feature, places) in projected.iter().filter(|(feature, _)| feature.zoom <= zoom) {
            let bounds = |axis: usize, of: fn(f64, f64) -> f64| {
                let values = places.iter().map(|place| place[axis] * scale);
                values.reduce(of).expect("a feature has a place")
            };
            let margin = MARGIN / EXTENT;
            let columns = (bounds(0, f64::min) - margin) as u32..=(bounds(0, f64::max) + margin) as u32;
            let rows = (bounds(1, f64::min) - margin) as u32..=(bounds(1, f64::max) + margin) as u32;
            for (x, y) in columns.flat_map(|x| rows.clone().map(move |y| (x, y))) {
                let in_tile = |[px, py]: Place| {
                    [(px * scale - f64::from(x)) * EXTENT, (py * scale - f64::from(y)) * EXTENT]
                };
                let local: Vec<Place> = places.iter().copied().map(in_tile).collect();
                if let Some((kind, geometry)) = geometry(&feature.shape, &local) {
                    add(layers.entry((x, y)).or_default(), feature, kind, geometry);
                }
            }
        }
        tiles.extend(
            layers.into_iter().map(|((x, y), layers)| ((zoom, x, y), Tile { layers }.encode_to_vec())),
        );
    }
    tiles
}

/// Position in the square of Web Mercator, 0 to 1, to the right and down.
fn mercator(ground: &Ground, [east, north]: Place) -> Place {
    let place = ground.geodetic(&Vector3::new(east, north, 0.0));
    let sin = place.latitude_deg().to_radians().sin();
    [place.longitude_deg() / 360.0 + 0.5, 0.5 - sin.atanh() / (2.0 * PI)]
}

/// Adds a feature to its layer.
fn add(layers: &mut Vec<Layer>, feature: &Feature, kind: u32, geometry: Vec<u32>) {
    let index = layers.iter().position(|layer| layer.name == feature.layer).unwrap_or_else(|| {
        let (name, keys) = (feature.layer.to_owned(), vec!["class".to_owned()]);
        layers.push(Layer { name, keys, extent: EXTENT as u32, version: 2, ..Layer::default() });
        layers.len() - 1
    });
    let layer = &mut layers[index];
    let mut tags = Vec::new();
    for (key, value) in [("class", Some(feature.class)), ("name", feature.name)] {
        let Some(value) = value else { continue };
        tags.push(position(&mut layer.keys, |known| known == key, || key.to_owned()));
        let text = || TileValue { text: value.to_owned() };
        tags.push(position(&mut layer.values, |known| known.text == value, text));
    }
    layer.features.push(TileFeature { tags, kind, geometry });
}

/// Position of an item, which is appended if it is missing.
fn position<T>(items: &mut Vec<T>, is_it: impl Fn(&T) -> bool, make: impl Fn() -> T) -> u32 {
    let found = items.iter().position(is_it).unwrap_or_else(|| {
        items.push(make());
        items.len() - 1
    });
    found as u32
}

/// Kind and commands of the part of a shape within the tile; `None` if there is no such part.
fn geometry(shape: &Shape, places: &[Place]) -> Option<(u32, Vec<u32>)> {
    let mut pen = Pen::default();
    let kind = match shape {
        Shape::Point(_) => {
            let is_inside = places[0].iter().all(|value| (0.0..EXTENT).contains(value));
            is_inside.then(|| pen.draw(&places.iter().map(rounded).collect::<Vec<_>>(), false))?;
            POINT
        }
        Shape::Line(_) => {
            for part in clip::line(places, -MARGIN, EXTENT + MARGIN) {
                pen.draw(&thinned(&part, false), false);
            }
            LINE
        }
        Shape::Area(_) => {
            let mut ring = thinned(&clip::area(places, -MARGIN, EXTENT + MARGIN), true);
            let double_area: i64 = (0..ring.len())
                .map(|index| {
                    let ([ax, ay], [bx, by]) = (ring[index], ring[(index + 1) % ring.len()]);
                    ax * by - bx * ay
                })
                .sum();
            // An exterior ring has a positive area.
            if double_area < 0 {
                ring.reverse();
            }
            if ring.len() > 2 && double_area != 0 {
                pen.draw(&ring, true);
            }
            AREA
        }
    };
    (!pen.commands.is_empty()).then_some((kind, pen.commands))
}

fn rounded(place: &Place) -> [i64; 2] {
    place.map(|value| value.round() as i64)
}

/// Rounded places, without those that are hardly apart from the one before.
fn thinned(places: &[Place], is_ring: bool) -> Vec<[i64; 2]> {
    let mut kept: Vec<[i64; 2]> = Vec::with_capacity(places.len());
    let is_near = |a: [i64; 2], b: [i64; 2]| (0..2).all(|axis| (a[axis] - b[axis]).abs() < LEAST);
    for (index, place) in places.iter().map(rounded).enumerate() {
        let is_end = !is_ring && index + 1 == places.len();
        match kept.last() {
            Some(last) if is_near(*last, place) && !is_end => {}
            _ => kept.push(place),
        }
    }
    kept
}

/// Commands that draw, each with the steps from the place before.
#[derive(Default)]
struct Pen {
    at: [i64; 2],
    commands: Vec<u32>,
}

impl Pen {
    /// Draws a point, a line or a ring.
    fn draw(&mut self, places: &[[i64; 2]], is_ring: bool) {
        for (count, command, places) in [(1, 1, &places[..1]), (places.len() - 1, 2, &places[1..])] {
            if count == 0 {
                continue;
            }
            self.commands.push(((count as u32) << 3) | command);
            for place in places {
                for (to, from) in place.iter().zip(self.at) {
                    let step = to - from;
                    self.commands.push(((step << 1) ^ (step >> 63)) as u32);
                }
                self.at = *place;
            }
        }
        if is_ring {
            self.commands.push((1 << 3) | 7);
        }
    }
}
