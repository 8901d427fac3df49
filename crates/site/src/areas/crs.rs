//! The coordinate reference system that a GeoJSON file may name (GeoJSON of 2008); RFC 7946 allows WGS-84 only.

use serde_json::Value;

use super::member::Member;

/// WGS-84 with and without heights, and ETRS89, which differs from it by less than a metre.
const KNOWN: [&str; 6] = ["CRS84", "CRS84H", "4326", "4979", "4258", "4937"];

/// Refuses a member `crs` of the file, its features or their geometries that names an unsupported system.
pub(super) fn check(file: &Value) -> Result<(), String> {
    let of_features = file.get("features").and_then(Value::as_array).into_iter().flatten();
    let objects = [file].into_iter().chain(of_features);
    objects.map(Member::top).flat_map(|object| [object.get("geometry"), Some(object)]).flatten().try_for_each(
        |object| match object.get("crs") {
            Some(crs) if !is_known(&crs) => Err(crs.refused(
                "positions are understood in degrees of WGS-84 (EPSG:4326); convert the file: ogr2ogr -t_srs EPSG:4326 OUT IN",
            )),
            _ => Ok(()),
        },
    )
}

fn is_known(crs: &Member<'_>) -> bool {
    let name = crs.get("properties").and_then(|properties| properties.get("name"));
    let Some(Ok(name)) = name.as_ref().map(Member::text) else { return false };
    let name = name.to_ascii_uppercase();
    let is_registered = name.contains("EPSG") || name.contains("OGC");
    is_registered && name.rsplit([':', '/']).next().is_some_and(|code| KNOWN.contains(&code))
}
