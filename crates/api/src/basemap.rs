//! Tiles of the base map for the map page.

use axum::http::{StatusCode, header};
use schemars::JsonSchema;
use serde::Serialize;

use super::problem::Problem;
use super::request::{ApiRequest, ApiResult, with_type};
use crate::pmtiles::Basemap;

/// Media type of vector tiles.
pub const TILE: &str = "application/vnd.mapbox-vector-tile";
/// Media type for clients that do not list the type of tiles in `Accept`.
pub const OCTETS: &str = "application/octet-stream";

/// Browsers cache tiles for an hour: a site rarely changes its map, and restarts the service for it.
const KEPT: &str = "private, max-age=3600";

/// Description of the base map.
#[derive(Serialize, JsonSchema)]
#[schemars(rename = "About")]
pub struct BasemapInfo {
    /// Lowest zoom level.
    min_zoom: u8,
    /// Highest zoom level.
    max_zoom: u8,
    /// Copyright notice of the map.
    attribution: String,
}

impl From<&Basemap> for BasemapInfo {
    fn from(map: &Basemap) -> Self {
        let (min_zoom, max_zoom) = map.zooms();
        Self { min_zoom, max_zoom, attribution: map.attribution().to_owned() }
    }
}

/// `/api/v1/basemap`: a tile, empty if the map has none there.
pub fn tile(request: &ApiRequest) -> ApiResult {
    let needed = |name, most: u32| {
        let rule = format!("a whole number, 0 to {most}");
        let value = request.query.value(name, &rule, |value: &u32| *value <= most)?;
        value.ok_or_else(|| Problem::parameter(name, &rule))
    };
    let zoom = needed("z", 31)?;
    let last = (1 << zoom) - 1;
    let (x, y) = (needed("x", last)?, needed("y", last)?);
    let none = || Problem::not_found("there is no base map; map.pmtiles names its file");
    let map = request.state.basemap.as_ref().ok_or_else(none)?;
    let zoom = u8::try_from(zoom).map_err(|_| none())?;
    let tile = map.tile(zoom, x, y).map_err(|error| {
        Problem::new(StatusCode::SERVICE_UNAVAILABLE, format!("the base map cannot be read: {error}"))
    })?;
    let accept = request.headers.get(header::ACCEPT).and_then(|accept| accept.to_str().ok()).unwrap_or("");
    let kind = if accept.contains(OCTETS) && !accept.contains(TILE) { OCTETS } else { TILE };
    Ok(with_type(kind, KEPT, tile.unwrap_or_default()))
}
