//! GeoJSON (RFC 7946): what of it is served.

use std::borrow::Cow;

use schemars::JsonSchema;
use serde::Serialize;

/// Longitude and latitude, degrees, and the ellipsoidal height, metres, where it is known.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
#[schemars(extend("minItems" = 2, "maxItems" = 3))]
pub struct Position(pub Vec<f64>);

impl Position {
    /// A position with its height, where it is known.
    pub fn new(lng: f64, lat: f64, height_m: Option<f64>) -> Self {
        Self([lng, lat].into_iter().chain(height_m).collect())
    }
}

/// A place, a line, or an area.
#[derive(Debug, PartialEq, Serialize, JsonSchema)]
#[serde(tag = "type", content = "coordinates")]
pub enum Geometry {
    Point(Position),
    LineString(Vec<Position>),
    MultiLineString(Vec<Vec<Position>>),
    Polygon(Vec<Vec<Position>>),
    MultiPolygon(Vec<Vec<Vec<Position>>>),
}

impl From<&geo::MultiPolygon> for Geometry {
    fn from(polygons: &geo::MultiPolygon) -> Self {
        let ring = |line: &geo::LineString| line.coords().map(|at| Position::new(at.x, at.y, None)).collect();
        let rings = |polygon: &geo::Polygon| {
            [polygon.exterior()].into_iter().chain(polygon.interiors()).map(ring).collect()
        };
        Self::MultiPolygon(polygons.iter().map(rings).collect())
    }
}

/// A place.
#[derive(Serialize, JsonSchema)]
#[schemars(inline)]
pub struct Point {
    r#type: PointType,
    coordinates: Position,
}

impl Point {
    /// At a longitude and latitude.
    pub fn new(lng: f64, lat: f64, height_m: Option<f64>) -> Self {
        Self { r#type: PointType::Point, coordinates: Position::new(lng, lat, height_m) }
    }
}

#[derive(Serialize, JsonSchema)]
#[schemars(inline)]
enum PointType {
    Point,
}

#[derive(Serialize, JsonSchema)]
#[schemars(inline)]
enum FeatureType {
    Feature,
}

/// A GeoJSON object with features.
#[derive(Default, Serialize, JsonSchema)]
#[schemars(inline)]
pub enum CollectionType {
    /// The only one.
    #[default]
    FeatureCollection,
}

/// Something with a geometry.
#[derive(Serialize, JsonSchema)]
#[schemars(rename = "FeatureOf{P}")]
pub struct Feature<'a, G, P> {
    r#type: FeatureType,
    /// As in the properties.
    id: Cow<'a, str>,
    geometry: G,
    properties: P,
}

impl<'a, G, P> Feature<'a, G, P> {
    /// A feature with an id.
    pub fn new(id: impl Into<Cow<'a, str>>, geometry: G, properties: P) -> Self {
        Self { r#type: FeatureType::Feature, id: id.into(), geometry, properties }
    }
}

/// Something with a geometry, that has no id.
#[derive(Serialize, JsonSchema)]
#[schemars(rename = "FeatureOf{P}")]
pub struct Unnamed<G, P> {
    r#type: FeatureType,
    geometry: G,
    properties: P,
}

impl<G, P> Unnamed<G, P> {
    /// A feature without an id.
    pub fn new(geometry: G, properties: P) -> Self {
        Self { r#type: FeatureType::Feature, geometry, properties }
    }
}

/// A GeoJSON feature collection.
#[derive(Serialize, JsonSchema)]
#[schemars(rename = "CollectionOf{F}")]
pub struct Collection<F> {
    r#type: CollectionType,
    features: Vec<F>,
}

impl<F> FromIterator<F> for Collection<F> {
    fn from_iter<T: IntoIterator<Item = F>>(features: T) -> Self {
        Self { r#type: CollectionType::default(), features: features.into_iter().collect() }
    }
}
