//! The polygons of `[[areas]]`: GeoJSON files (RFC 7946), looked at once at the start.

mod zones;

use std::collections::BTreeMap;
use std::path::PathBuf;

use geo::orient::{Direction, Orient};
use geo::{BoundingRect, Geometry, Intersects, MultiPolygon, Point, Rect};
use geojson::{Feature, GeoJson};

use crate::config::{Area, AreaKind, Config, Sensor, SensorKind};

/// The polygons of a file.
type Polygons = Vec<Shape>;

/// A polygon of a file.
#[derive(Clone, Debug, PartialEq)]
struct Shape {
    /// The property `name` of its feature, where that is a text.
    name: Option<String>,
    bounds: Rect,
    polygon: MultiPolygon,
}

impl Shape {
    fn contains(&self, place: &Point) -> bool {
        self.bounds.intersects(place) && self.polygon.intersects(place)
    }
}

/// A polygon with what it is part of.
#[derive(Clone, Debug)]
pub struct NamedPolygon<'a> {
    /// As it is configured.
    pub area: &'a Area,
    /// What people call it: its feature's property `name`, or else the file's name without its ending.
    pub name: String,
    /// The outer ring counterclockwise, holes clockwise, as RFC 7946 has them.
    pub polygon: MultiPolygon,
}

/// Where plots are dropped: roads, wind farms, fixed echoes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Masks(Polygons);

/// A file of `[[areas]]` that cannot be used.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{}: {problem}", file.display())]
pub struct AreaError {
    /// The file.
    pub file: PathBuf,
    /// What is wrong with it, and what an area has to be.
    pub problem: String,
}

/// Where a track raises an alert: polygons of one name are one area.
#[derive(Clone, Debug, Default)]
pub struct AlertAreas(BTreeMap<String, Polygons>);

/// Where a transponder is heard: the coverage of those receivers that have an area of it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct HeardAreas(Polygons);

/// All areas of a configuration, masks first, as their files were when they were read.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Areas(Vec<(Area, Polygons)>);

impl Areas {
    /// Reads the files.
    ///
    /// # Errors
    /// One cannot be read or holds something else than polygons.
    pub fn load(areas: &[Area]) -> Result<Self, AreaError> {
        let mut areas: Vec<(Area, Polygons)> =
            areas.iter().map(|area| Ok((area.clone(), read(area)?))).collect::<Result<_, _>>()?;
        areas.sort_by_key(|(area, _)| area.kind != AreaKind::Mask);
        Ok(Self(areas))
    }

    /// Those of kind `mask`.
    pub fn masks(&self) -> Masks {
        Masks(self.of_kind(&AreaKind::Mask).flat_map(|(_, polygons)| polygons.iter().cloned()).collect())
    }

    /// Those of kind `alert`.
    pub fn alerts(&self) -> AlertAreas {
        let mut areas = BTreeMap::<String, Polygons>::new();
        for (area, shapes) in self.of_kind(&AreaKind::Alert) {
            for shape in shapes {
                areas.entry(name(area, shape)).or_default().push(shape.clone());
            }
        }
        AlertAreas(areas)
    }

    /// Those of kind `coverage` of a transponder receiver.
    pub fn heard(&self, config: &Config) -> HeardAreas {
        let heard = self.0.iter().filter(|(area, _)| is_heard(area, config));
        HeardAreas(heard.flat_map(|(_, polygons)| polygons.iter().cloned()).collect())
    }

    /// Each polygon with its area and its name.
    pub fn polygons(&self) -> impl Iterator<Item = NamedPolygon<'_>> {
        let named = |area, shape: &Shape| NamedPolygon {
            area,
            name: name(area, shape),
            polygon: shape.polygon.orient(Direction::Default),
        };
        self.0.iter().flat_map(move |(area, shapes)| shapes.iter().map(move |shape| named(area, shape)))
    }

    /// The areas as they are configured.
    pub fn configured(&self) -> impl Iterator<Item = &Area> {
        self.0.iter().map(|(area, _)| area)
    }

    /// The same with other masks: those that are in force.
    #[must_use]
    pub fn with_masks_of(&self, other: &Self) -> Self {
        let others = self.0.iter().filter(|(area, _)| area.kind != AreaKind::Mask);
        Self(other.of_kind(&AreaKind::Mask).chain(others).cloned().collect())
    }

    fn of_kind(&self, kind: &AreaKind) -> impl Iterator<Item = &(Area, Polygons)> {
        self.0.iter().filter(move |(area, _)| area.kind == *kind)
    }
}

impl AlertAreas {
    /// Loads the areas of kind `alert`.
    ///
    /// # Errors
    /// A file cannot be read or holds something else than polygons.
    pub fn load(areas: &[Area]) -> Result<Self, AreaError> {
        Ok(Areas::load(&only(areas, &AreaKind::Alert))?.alerts())
    }

    /// The names of the areas that a place (degrees) is in.
    pub fn around(&self, longitude_deg: f64, latitude_deg: f64) -> impl Iterator<Item = &str> {
        let place = Point::new(longitude_deg, latitude_deg);
        let is_in =
            move |(_, shapes): &(&String, &Polygons)| shapes.iter().any(|shape| shape.contains(&place));
        self.0.iter().filter(is_in).map(|(name, _)| name.as_str())
    }
}

impl HeardAreas {
    /// Loads them.
    ///
    /// # Errors
    /// A file cannot be read or holds something else than polygons.
    pub fn load(config: &Config) -> Result<Self, AreaError> {
        let areas: Vec<Area> = config.areas.iter().filter(|area| is_heard(area, config)).cloned().collect();
        Ok(Areas::load(&areas)?.heard(config))
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Whether a place (degrees) is inside one of them or on its edge.
    pub fn contain(&self, longitude_deg: f64, latitude_deg: f64) -> bool {
        let place = Point::new(longitude_deg, latitude_deg);
        self.0.iter().any(|area| area.contains(&place))
    }
}

fn is_heard(area: &Area, config: &Config) -> bool {
    let AreaKind::Coverage { sensor: id } = &area.kind else { return false };
    let of_receiver = |sensor: &Sensor| sensor.id == *id && matches!(sensor.kind, SensorKind::Transponder(_));
    config.sensors.iter().any(of_receiver)
}

impl Masks {
    /// Loads the areas of kind `mask`; the others are for the live service.
    ///
    /// # Errors
    /// A file cannot be read or holds something else than polygons.
    pub fn load(areas: &[Area]) -> Result<Self, AreaError> {
        Ok(Areas::load(&only(areas, &AreaKind::Mask))?.masks())
    }

    /// Whether there is none: then no position need be worked out.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Whether a place (degrees) is inside one of them or on its edge. Straight lines in longitude and latitude.
    pub fn contain(&self, longitude_deg: f64, latitude_deg: f64) -> bool {
        let place = Point::new(longitude_deg, latitude_deg);
        self.0.iter().any(|mask| mask.contains(&place))
    }
}

/// Of the path only the file's name: where files lie is nobody's business.
fn name(area: &Area, shape: &Shape) -> String {
    let stem = || area.file.file_stem().map_or_else(String::new, |stem| stem.to_string_lossy().into_owned());
    shape.name.clone().unwrap_or_else(stem)
}

fn only(areas: &[Area], kind: &AreaKind) -> Vec<Area> {
    areas.iter().filter(|area| area.kind == *kind).cloned().collect()
}

fn read(area: &Area) -> Result<Polygons, AreaError> {
    let error = |problem: String| AreaError { file: area.file.clone(), problem };
    #[expect(clippy::disallowed_methods, reason = "the one place that reads areas")]
    let text =
        std::fs::read_to_string(&area.file).map_err(|cause| error(format!("cannot be read: {cause}")))?;
    polygons(&text).map_err(error)
}

fn polygons(text: &str) -> Result<Polygons, String> {
    if let Some(problem) = serde_json::from_str(text).ok().and_then(|file| zones::refused(&file)) {
        return Err(problem);
    }
    plain_polygons(text).map_err(|problem| {
        format!("{problem}; areas are polygons in GeoJSON (RFC 7946), longitude before latitude")
    })
}

fn plain_polygons(text: &str) -> Result<Polygons, String> {
    let json: GeoJson = text.parse().map_err(|cause| format!("is no GeoJSON: {cause}"))?;
    let features = match json {
        GeoJson::FeatureCollection(collection) => collection.features,
        GeoJson::Feature(feature) => vec![feature],
        GeoJson::Geometry(geometry) => vec![geometry.into()],
    };
    let mut shapes = Vec::new();
    for feature in features {
        let name = feature.property("name").and_then(|name| name.as_str()).map(str::trim);
        let name = name.filter(|name| !name.is_empty()).map(str::to_owned);
        for polygon in polygons_of(feature)? {
            let bounds = polygon.bounding_rect().ok_or("holds an empty polygon")?;
            let (min, max) = (bounds.min(), bounds.max());
            if min.x < -180.0 || max.x > 180.0 || min.y < -90.0 || max.y > 90.0 {
                return Err("holds a position beyond ±180 degrees of longitude or ±90 of latitude".to_owned());
            }
            shapes.push(Shape { name: name.clone(), bounds, polygon });
        }
    }
    if shapes.is_empty() { Err("holds no polygon".to_owned()) } else { Ok(shapes) }
}

/// Those of a feature; a collection of polygons is several, a feature without a geometry none.
fn polygons_of(feature: Feature) -> Result<Vec<MultiPolygon>, String> {
    let Some(geometry) = feature.geometry else { return Ok(Vec::new()) };
    let geometry = Geometry::try_from(geometry).map_err(|cause| format!("is no GeoJSON: {cause}"))?;
    let one = |geometry| match geometry {
        Geometry::Polygon(polygon) => Ok(polygon.into()),
        Geometry::MultiPolygon(polygons) => Ok(polygons),
        _ => Err("holds something that is no polygon".to_owned()),
    };
    match geometry {
        Geometry::GeometryCollection(collection) => collection.into_iter().map(one).collect(),
        geometry => Ok(vec![one(geometry)?]),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const RING: &str = "[[[10, 50], [11, 50], [11, 51], [10, 51], [10, 50]], [[10.4, 50.4], [10.6, 50.4], [10.6, 50.6], [10.4, 50.4]]]";

    #[test]
    fn a_mask_has_edges_and_holes() {
        let masks = Masks(polygons(&format!(r#"{{"type": "Polygon", "coordinates": {RING}}}"#)).unwrap());
        for (longitude_deg, latitude_deg, inside) in [
            (10.1, 50.1, true),
            (10.0, 50.5, true),
            (10.55, 50.45, false),
            (9.9, 50.5, false),
            (50.5, 10.5, false),
        ] {
            assert_eq!(masks.contain(longitude_deg, latitude_deg), inside, "{longitude_deg} {latitude_deg}");
        }
        assert!(!Masks::default().contain(10.1, 50.1));
    }

    #[test]
    fn an_area_is_called_what_its_feature_says_or_else_as_its_file() {
        let feature = |properties: &str, west: u8| {
            let east = west + 1;
            let ring = format!("[[{west}, 50], [{east}, 50], [{east}, 51], [{west}, 50]]");
            format!(
                r#"{{"type": "Feature", "properties": {properties},
                    "geometry": {{"type": "Polygon", "coordinates": [{ring}]}}}}"#
            )
        };
        let named = [
            feature(r#"{"name": "Runway 27"}"#, 10),
            feature(r#"{"name": "Runway 27"}"#, 20),
            feature(r#"{"name": " "}"#, 30),
            feature("null", 40),
        ];
        let text = format!(r#"{{"type": "FeatureCollection", "features": [{}]}}"#, named.join(","));
        let area = Area { kind: AreaKind::Alert, file: PathBuf::from("secret/field.geojson") };
        let areas = Areas(vec![(area, polygons(&text).unwrap())]);
        let names: Vec<String> = areas.polygons().map(|polygon| polygon.name).collect();
        assert_eq!(names, ["Runway 27", "Runway 27", "field", "field"]);
        let alerts = areas.alerts();
        let around = |longitude_deg| alerts.around(longitude_deg, 50.1).collect::<Vec<_>>();
        assert_eq!(
            [10.5, 20.5, 30.5, 40.5].map(around),
            [["Runway 27"], ["Runway 27"], ["field"], ["field"]]
        );
    }

    #[test]
    fn what_is_no_area_is_refused_with_the_reason() {
        for (text, part) in [
            ("", "no GeoJSON"),
            ("{}", "no GeoJSON"),
            (r#"{"type": "Point", "coordinates": [10, 50]}"#, "no polygon"),
            (r#"{"type": "FeatureCollection", "features": []}"#, "no polygon"),
            (r#"{"type": "Polygon", "coordinates": [[[10, 95], [11, 95], [11, 96], [10, 95]]]}"#, "beyond"),
        ] {
            let problem = polygons(text).unwrap_err();
            assert!(problem.contains(part), "{text}: {problem}");
        }
    }
}
