//! The part of GeoJSON (RFC 7946) that the service uses.

use std::borrow::Cow;

use schemars::JsonSchema;
use serde::Serialize;

/// Longitude and latitude in degrees, and the ellipsoidal height in metres if known.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
#[schemars(extend("minItems" = 2, "maxItems" = 3))]
#[schemars(rename = "Position")]
pub struct GeoPosition(pub Vec<f64>);

impl GeoPosition {
    /// A position, with its height if known.
    pub fn new(lng: f64, lat: f64, height_m: Option<f64>) -> Self {
        Self([lng, lat].into_iter().chain(height_m).collect())
    }
}

/// A point, a line, or an area.
#[derive(Debug, PartialEq, Serialize, JsonSchema)]
#[serde(tag = "type", content = "coordinates")]
#[schemars(rename = "Geometry")]
pub enum GeoJsonGeometry {
    Point(GeoPosition),
    LineString(Vec<GeoPosition>),
    MultiLineString(Vec<Vec<GeoPosition>>),
    Polygon(Vec<Vec<GeoPosition>>),
    MultiPolygon(Vec<Vec<Vec<GeoPosition>>>),
}

impl From<&geo::MultiPolygon> for GeoJsonGeometry {
    fn from(polygons: &geo::MultiPolygon) -> Self {
        let ring =
            |line: &geo::LineString| line.coords().map(|at| GeoPosition::new(at.x, at.y, None)).collect();
        let rings = |polygon: &geo::Polygon| {
            [polygon.exterior()].into_iter().chain(polygon.interiors()).map(ring).collect()
        };
        Self::MultiPolygon(polygons.iter().map(rings).collect())
    }
}

/// A point.
#[derive(Serialize, JsonSchema)]
#[schemars(inline)]
pub struct Point {
    r#type: PointType,
    coordinates: GeoPosition,
}

impl Point {
    /// A point at a longitude and latitude.
    pub fn new(lng: f64, lat: f64, height_m: Option<f64>) -> Self {
        Self { r#type: PointType::Point, coordinates: GeoPosition::new(lng, lat, height_m) }
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

/// Type of a GeoJSON object with features.
#[derive(Default, Serialize, JsonSchema)]
#[schemars(inline)]
pub enum CollectionType {
    /// The only type.
    #[default]
    FeatureCollection,
}

/// A GeoJSON feature with an id.
#[derive(Serialize, JsonSchema)]
#[schemars(rename = "FeatureOf{P}")]
pub struct Feature<'a, G, P> {
    r#type: FeatureType,
    /// Same id as in the properties.
    id: Cow<'a, str>,
    geometry: G,
    properties: P,
}

impl<'a, G, P> Feature<'a, G, P> {
    /// Creates a feature with an id.
    pub fn new(id: impl Into<Cow<'a, str>>, geometry: G, properties: P) -> Self {
        Self { r#type: FeatureType::Feature, id: id.into(), geometry, properties }
    }
}

/// A GeoJSON feature without an id.
#[derive(Serialize, JsonSchema)]
#[schemars(rename = "FeatureOf{P}")]
pub struct UnnamedFeature<G, P> {
    r#type: FeatureType,
    geometry: G,
    properties: P,
}

impl<G, P> UnnamedFeature<G, P> {
    /// Creates a feature without an id.
    pub fn new(geometry: G, properties: P) -> Self {
        Self { r#type: FeatureType::Feature, geometry, properties }
    }
}

/// A GeoJSON feature collection.
#[derive(Serialize, JsonSchema)]
#[schemars(rename = "CollectionOf{F}")]
pub struct FeatureCollection<F> {
    r#type: CollectionType,
    features: Vec<F>,
}

impl<F> FromIterator<F> for FeatureCollection<F> {
    fn from_iter<T: IntoIterator<Item = F>>(features: T) -> Self {
        Self { r#type: CollectionType::default(), features: features.into_iter().collect() }
    }
}
