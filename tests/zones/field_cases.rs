//! Zone files that caused problems in practice: each is read, or refused with feature and member.

use std::path::Path;

use utm_fusion::areas::Areas;
use utm_fusion::config::{AlertArea, Area, AreaKind};

#[test]
fn field_cases_are_read_or_refused_by_member() {
    let Some(folder) = std::env::var_os("UTM_FUSION_SHARED_DATA") else {
        println!("skipped: UTM_FUSION_SHARED_DATA is not set");
        return;
    };
    let folder = Path::new(&folder).join("field-cases");
    for (file, parts) in [
        ("50-national-zones/ed269-ch.json", &[][..]),
        ("50-national-zones/ed269-fi.json", &[]),
        ("50-national-zones/ed269-lu.json", &[]),
        ("50-national-zones/ed318-ie.json", &[]),
        ("50-national-zones/ed318-se.json", &[]),
        ("50-national-zones/eans-ee.json", &[]),
        ("50-national-zones/dronezoner-dk.json", &["zone 2 (\"Testlufthavn\"): geometry.type = \"Point\""]),
        (
            "50-national-zones/faa-uasfm.json",
            &["zone 1: properties.CEILING = 0", "zone 2: properties.CEILING"],
        ),
        ("51-qgis-geojson/am_181.geojson", &["beyond"]),
        ("51-qgis-geojson/am_cut.geojson", &[]),
        ("51-qgis-geojson/am_uncut.geojson", &["zone 1", "cut in two at 180"]),
        ("51-qgis-geojson/am_uncut_cw.geojson", &["zone 1", "cut in two at 180"]),
        ("51-qgis-geojson/far_uncut.geojson", &["zone 1", "cut in two at 180"]),
        ("51-qgis-geojson/open_ring.geojson", &["zone 1", "cut in two at 180"]),
        ("51-qgis-geojson/crs3857.geojson", &["crs = ", "EPSG:4326"]),
        ("51-qgis-geojson/crs3857_small.geojson", &["crs = ", "EPSG:4326"]),
        ("51-qgis-geojson/crs84.geojson", &[]),
        ("51-qgis-geojson/empty.geojson", &["no polygon"]),
        ("51-qgis-geojson/null_geom.geojson", &["no polygon"]),
        ("51-qgis-geojson/swapped.geojson", &["zone 1", "swapped"]),
        ("51-qgis-geojson/zero_area.geojson", &["zone 1", "has no area"]),
    ] {
        let settings = AlertArea {
            ground_m: Some(100.0),
            time_zone: Some("Europe/Berlin".to_owned()),
            ..AlertArea::default()
        };
        let area = Area { kind: AreaKind::Alert(settings), file: folder.join(file) };
        match Areas::load(&[area]) {
            Ok(areas) => assert!(parts.is_empty(), "{file}: read: {:?}", areas.zones().count()),
            Err(error) => {
                let text = error.to_string();
                let is_told = !parts.is_empty() && parts.iter().all(|part| text.contains(part));
                assert!(is_told, "{file}: {text}");
            }
        }
    }
}
