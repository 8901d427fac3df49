//! Coverage area of transponders: the whole airspace of a scenario.

use std::fs;
use std::path::PathBuf;
use std::sync::atomic::{AtomicU32, Ordering};

use utm_fusion::areas::Areas;
use utm_fusion::config::{Area, AreaKind, Config};
use utm_fusion::simulate::{Scenario, TRANSPONDER_ID};

use crate::flights::EvaluationFailure;

/// Half of the width of the area, degrees.
const HALF_DEG: f64 = 0.5;

/// Adds a coverage area around the scenario's origin, and reads it.
pub fn add(config: &mut Config, scenario: &Scenario) -> Result<Areas, EvaluationFailure> {
    static COUNT: AtomicU32 = AtomicU32::new(0);
    let (lat, lon) = (scenario.place.latitude_deg, scenario.place.longitude_deg);
    let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0)];
    let ring: Vec<[f64; 2]> =
        corners.iter().map(|(east, north)| [lon + east * HALF_DEG, lat + north * HALF_DEG]).collect();
    let polygon = serde_json::json!({ "type": "Polygon", "coordinates": [ring] });
    let (process, count) = (std::process::id(), COUNT.fetch_add(1, Ordering::Relaxed));
    let file: PathBuf = std::env::temp_dir().join(format!("utm-fusion-evaluation-{process}-{count}.geojson"));
    fs::write(&file, polygon.to_string())?;
    let kind = AreaKind::Coverage { sensor: TRANSPONDER_ID.to_owned() };
    config.areas.push(Area { kind, file: file.clone() });
    let areas = Areas::load(&config.areas);
    fs::remove_file(&file)?;
    Ok(areas?)
}
