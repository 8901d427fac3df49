//! Every route, once: the router and the OpenAPI document are both made of this table.

use super::ask::{Answer, Ask};
use super::auth::{Scope, open_ticket};
use super::correlations::{self, Later};
use super::{history, metrics, openapi, page, raw, readsb, replay, service, sites, stream, tracks, uss};

/// A path and what is done there.
#[derive(Clone, Copy, Debug)]
pub struct Route {
    /// With `{id}` where a part is free.
    pub path: &'static str,
    /// `GET` (then also `HEAD`) or `POST`.
    pub post: bool,
    /// One line for the document.
    pub summary: &'static str,
    /// The parameters behind the `?`, which are then the only ones; `None`: whatever stands there is ignored.
    pub parameters: Option<&'static [Parameter]>,
    /// What a token needs; `None`: open to everybody.
    pub scope: Option<Scope>,
    /// The type of the answer.
    pub content_type: &'static str,
    /// Statuses beside 200, 400, 401, 403, 405 and, where it is limited, 429.
    pub problems: &'static [u16],
    /// Whether requests are counted against `http.requests_per_s`; those that watch over the service are not.
    pub limited: bool,
    /// What answers.
    pub(super) handler: fn(&Ask) -> Answer,
    /// What answers instead where the engine has to be waited for.
    pub(super) later: Option<fn(Ask) -> Later>,
}

/// A parameter of a query.
#[derive(Clone, Copy, Debug)]
pub struct Parameter {
    /// Its name.
    pub name: &'static str,
    /// `string`, `number`, `integer`, or `time` (RFC 3339).
    pub kind: &'static str,
    /// Its least and its greatest value, where it is a number.
    pub range: Option<(f64, f64)>,
    /// Whether it has to be given.
    pub required: bool,
    /// What it does.
    pub description: &'static str,
}

const fn parameter(name: &'static str, kind: &'static str, description: &'static str) -> Parameter {
    Parameter { name, kind, range: None, required: false, description }
}

impl Parameter {
    const fn within(self, least: f64, greatest: f64) -> Self {
        Self { range: Some((least, greatest)), ..self }
    }

    const fn needed(self) -> Self {
        Self { required: true, ..self }
    }
}

const FILTER: [Parameter; 9] = [
    parameter(
        "bbox",
        "string",
        "lon_min,lat_min,lon_max,lat_max, degrees; lon_min above lon_max spans the antimeridian",
    ),
    parameter("source", "string", "of fused, radar, transponder, separated by commas"),
    parameter("sensor", "string", "ids of sensors that took part, separated by commas"),
    parameter(
        "alt_min",
        "number",
        "least height above mean sea level, metres; a track of unknown height is left out",
    )
    .within(-1_000.0, 100_000.0),
    parameter(
        "alt_max",
        "number",
        "greatest height above mean sea level, metres; a track of unknown height is left out",
    )
    .within(-1_000.0, 100_000.0),
    parameter("ids", "string", "ids of tracks, separated by commas"),
    parameter("limit", "integer", "tracks at most, 1 to 10000").within(1.0, 10_000.0),
    parameter("trail_s", "integer", "each track with where it was in the last so many seconds, 1 to 600")
        .within(1.0, 600.0),
    parameter("include", "string", "competitors: who else could be each part of a track; default: left out"),
];

const STREAM: [Parameter; 11] = {
    let [a, b, c, d, e, f, g, h, i] = FILTER;
    let interval =
        parameter("interval_ms", "integer", "between two tracks events, 250 to 10000; default: each slot")
            .within(250.0, 10_000.0);
    let ticket = parameter("ticket", "string", "from POST /api/v1/stream-tickets, for browsers");
    [a, b, c, d, e, f, g, h, i, interval, ticket]
};

const VIEW: [Parameter; 2] = [
    parameter("view", "string", "lat1,lng1,lat2,lng2: two corners, degrees; at most 7 km apart").needed(),
    parameter(
        "recent_positions_duration",
        "number",
        "seconds, 0 to 60: recent positions in the view, one a second",
    )
    .within(0.0, 60.0),
];

const TRAIL: [Parameter; 3] = [
    parameter("since", "time", "default: 10 minutes before until"),
    parameter("until", "time", "default: now"),
    parameter("format", "string", "geojson (default), gpx, kml or csv"),
];

const TIME: [Parameter; 1] = [parameter("time", "time", "of the picture").needed()];

const SEEK: [Parameter; 1] = [parameter(
    "time",
    "string",
    "RFC 3339 (2026-03-14T09:00:00Z), or a time of day that the recording has once (09:00:00)",
)
.needed()];

const AFTER: [Parameter; 1] =
    [parameter("after", "integer", "last of the answer before; default: everything that is kept")
        .within(0.0, 9e15)];

const SPEED: [Parameter; 1] =
    [parameter("speed", "number", "how many times faster than it happened, 0.01 to 1000")
        .within(0.01, 1_000.0)
        .needed()];

const PAIR: [Parameter; 5] = [
    parameter("sensor", "string", "id of the radar").needed(),
    parameter("track", "integer", "the radar's own number of its track (I048/161), 0 to 4095")
        .within(0.0, 4095.0)
        .needed(),
    parameter("uas", "string", "serial number of the transponder, as in uas_id of a track").needed(),
    parameter(
        "country",
        "string",
        "its registration country, or none, where several have that serial number",
    ),
    parameter("verdict", "string", "correlated, decorrelated, or automatic: as if nothing had been said")
        .needed(),
];

const CONTROL: Route =
    Route { post: true, scope: Some(Scope::Control), problems: &[409, 413], handler: replay::play, ..GET };

const GET: Route = Route {
    path: "",
    post: false,
    summary: "",
    parameters: Some(&[]),
    scope: Some(Scope::Read),
    content_type: "application/json",
    problems: &[],
    limited: true,
    handler: service::health,
    later: None,
};

const GEO_JSON: &str = "application/geo+json";

/// All routes.
pub const ROUTES: &[Route] = &[
    Route {
        path: "/api/v1/tracks",
        summary: "The picture: a GeoJSON FeatureCollection, with a weak ETag",
        parameters: Some(&FILTER),
        content_type: GEO_JSON,
        problems: &[304],
        handler: tracks::all,
        ..GET
    },
    Route {
        path: "/api/v1/tracks/{id}",
        summary: "One track with its contributors and their competitors",
        content_type: GEO_JSON,
        problems: &[404],
        handler: tracks::one,
        ..GET
    },
    Route {
        path: "/api/v1/tracks/{id}/trail",
        summary: "Where a track was, a place a second",
        parameters: Some(&TRAIL),
        content_type: GEO_JSON,
        problems: &[404, 503],
        handler: history::trail,
        ..GET
    },
    Route {
        path: "/api/v1/snapshot",
        summary: "The picture at a past time, to a second",
        parameters: Some(&TIME),
        content_type: GEO_JSON,
        problems: &[404, 503],
        handler: history::snapshot,
        ..GET
    },
    Route {
        path: "/api/v1/correlations",
        summary: "What operators have decided of radar tracks and transponders, and is in force",
        handler: correlations::all,
        ..GET
    },
    Route {
        path: "/api/v1/correlations",
        summary: "A radar track and a transponder are one aircraft, or are not, until its track number ends",
        parameters: Some(&PAIR),
        problems: &[404, 409, 413, 503],
        later: Some(correlations::correlate),
        ..CONTROL
    },
    Route { path: "/api/v1/replay/play", summary: "The replay goes on", ..CONTROL },
    Route {
        path: "/api/v1/replay/pause",
        summary: "The replay stops where it is",
        handler: replay::pause,
        ..CONTROL
    },
    Route {
        path: "/api/v1/replay/seek",
        summary: "The replay goes to a time",
        parameters: Some(&SEEK),
        problems: &[503],
        handler: replay::seek,
        ..CONTROL
    },
    Route {
        path: "/api/v1/replay/speed",
        summary: "The replay goes faster or slower",
        parameters: Some(&SPEED),
        handler: replay::speed,
        ..CONTROL
    },
    Route {
        path: "/api/v1/stream",
        summary: "Server-Sent Events: snapshot, tracks, ended, sensor, alert, heartbeat, resync, closed",
        parameters: Some(&STREAM),
        scope: Some(Scope::Stream),
        content_type: "text/event-stream",
        problems: &[503],
        handler: stream::open,
        ..GET
    },
    Route {
        path: "/api/v1/stream-tickets",
        post: true,
        summary: "A ticket that opens one stream within 30 s",
        scope: Some(Scope::Stream),
        problems: &[413],
        handler: open_ticket,
        ..GET
    },
    Route {
        path: "/api/v1/raw",
        summary: "What the sensors said, as the engine took it, from the first time that somebody asks",
        parameters: Some(&AFTER),
        content_type: GEO_JSON,
        handler: raw::all,
        ..GET
    },
    Route {
        path: "/api/v1/sensors",
        summary: "The sensors with their state; sources that are heard and not configured",
        content_type: GEO_JSON,
        handler: sites::sensors,
        ..GET
    },
    Route {
        path: "/api/v1/status",
        summary: "Health with reasons, latency, counters",
        handler: service::status,
        ..GET
    },
    Route { path: "/api/v1/info", summary: "Version, site and settings", handler: service::info, ..GET },
    Route {
        path: "/api/v1/coverage",
        summary: "How far the sensors see, as polygons",
        content_type: GEO_JSON,
        handler: sites::coverage,
        ..GET
    },
    Route {
        path: "/api/v1/areas",
        summary: "The configured areas",
        content_type: GEO_JSON,
        handler: sites::areas,
        ..GET
    },
    Route { path: "/api/v1/alerts", summary: "What is wrong now", handler: sites::alerts, ..GET },
    Route {
        path: "/api/v1/conflicts",
        summary: "Conflicts between tracks; not computed in any profile of this version: `computed` is false, the list empty",
        handler: sites::conflicts,
        ..GET
    },
    Route {
        path: "/data/aircraft.json",
        summary: "The picture as readsb serves it",
        parameters: None,
        handler: readsb::aircraft,
        ..GET
    },
    Route {
        path: "/data/receiver.json",
        summary: "The site as readsb serves it",
        parameters: None,
        handler: readsb::receiver,
        ..GET
    },
    Route {
        path: "/uss/flights",
        summary: "ASTM F3411-22a display data: flights that identify themselves, in a view",
        parameters: Some(&VIEW),
        problems: &[413],
        handler: uss::flights,
        ..GET
    },
    Route {
        path: "/uss/flights/{id}/details",
        summary: "ASTM F3411-22a display data: who a flight is",
        problems: &[404],
        handler: uss::details,
        ..GET
    },
    Route {
        path: "/healthz",
        summary: "The process is alive",
        scope: None,
        limited: false,
        handler: service::health,
        ..GET
    },
    Route {
        path: "/readyz",
        summary: "Lines are joined and slots are put out",
        scope: None,
        problems: &[503],
        limited: false,
        handler: service::ready,
        ..GET
    },
    Route {
        path: "/metrics",
        summary: "Prometheus text",
        content_type: "text/plain; version=0.0.4; charset=utf-8",
        handler: metrics::text,
        ..GET
    },
    Route { path: "/openapi.json", summary: "This document", scope: None, handler: openapi::document, ..GET },
    Route {
        path: "/",
        summary: "The page",
        parameters: None,
        scope: None,
        content_type: "text/html; charset=utf-8",
        handler: page::index,
        ..GET
    },
];
