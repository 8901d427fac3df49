//! The tiles of the base map, for the page.

use axum::http::{StatusCode, header};
use schemars::JsonSchema;
use serde::Serialize;

use super::ask::{Answer, Ask, with_type};
use super::problem::Problem;
use crate::basemap::Basemap;

/// A vector tile.
pub const TILE: &str = "application/vnd.mapbox-vector-tile";
/// The same for clients that know no type of tiles: they ask for it by `Accept`.
pub const OCTETS: &str = "application/octet-stream";

/// Kept by browsers for an hour: a site changes its map rarely, and restarts the service when it does.
const KEPT: &str = "private, max-age=3600";

/// What there is to ask for.
#[derive(Serialize, JsonSchema)]
pub struct About {
    /// The coarsest zoom.
    min_zoom: u8,
    /// The finest zoom.
    max_zoom: u8,
    /// Whom the map is owed to.
    attribution: String,
}

impl From<&Basemap> for About {
    fn from(map: &Basemap) -> Self {
        let (min_zoom, max_zoom) = map.zooms();
        Self { min_zoom, max_zoom, attribution: map.attribution().to_owned() }
    }
}

/// `/api/v1/basemap`: a tile, empty where the map has none.
pub fn tile(ask: &Ask) -> Answer {
    let needed = |name, most: u32| {
        let rule = format!("a whole number, 0 to {most}");
        let value = ask.query.value(name, &rule, |value: &u32| *value <= most)?;
        value.ok_or_else(|| Problem::parameter(name, &rule))
    };
    let zoom = needed("z", 31)?;
    let last = (1 << zoom) - 1;
    let (x, y) = (needed("x", last)?, needed("y", last)?);
    let none = || Problem::not_found("there is no base map; map.pmtiles names its file");
    let map = ask.state.basemap.as_ref().ok_or_else(none)?;
    let zoom = u8::try_from(zoom).map_err(|_| none())?;
    let tile = map.tile(zoom, x, y).map_err(|error| {
        Problem::new(StatusCode::SERVICE_UNAVAILABLE, format!("the base map cannot be read: {error}"))
    })?;
    let accept = ask.headers.get(header::ACCEPT).and_then(|accept| accept.to_str().ok()).unwrap_or("");
    let kind = if accept.contains(OCTETS) && !accept.contains(TILE) { OCTETS } else { TILE };
    Ok(with_type(kind, KEPT, tile.unwrap_or_default()))
}
