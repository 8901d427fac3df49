//! Table of all routes, from which the router and the OpenAPI document are made.

use std::sync::LazyLock;

use serde_json::{Map, Value};

use super::auth::issue_ticket;
use super::filter::{COMPETITORS, NOT_JUDGED};
use super::ground::{AreaCollection, Coverage};
use super::history::{Trail, TrailFormat};
use super::request::{ApiRequest, ApiResult, GEO_JSON, JSON};
use super::route::{Binary, Reply};
pub use super::route::{QueryParameter, Route};
use super::slot_json::{TrackCollection, TrackFeature};
use super::tokens::Scope;
use super::{
    alerts, asyncapi, basemap, cluster, conflicts, correlations, cueing, events, history, integrity, metrics,
    ogc, openapi, page, raw, readsb, relocations, remote_id, replay, sensors, service, stream, tracks, uss,
    websocket, zones,
};
use ::service::net::listen::POSTED_TO;
use fusion::integrity::State;
use fusion::operational::Verdict;
use input::gateways::remote_id::RemoteIdLine;
use input::names::{configured, with};
use picture::conflicts::levels;
use picture::{TrackClass, TrackSource};
use site::config::{AlertKind, PictureKind};

const FILTER: [QueryParameter; 13] = [
    QueryParameter::new(
        "bbox",
        "string",
        "lon_min,lat_min,lon_max,lat_max, degrees; lon_min above lon_max spans the antimeridian",
    ),
    QueryParameter::new("source", "string", "of fused, radar, transponder, camera, separated by commas")
        .some_of(|| TrackSource::NAMES.to_vec()),
    QueryParameter::new(
        "class",
        "string",
        "of drone (with a transponder, or the radar says so), crewed (conflicts.crewed names its transponder, or it is heard by \
         ADS-B), vehicle (on the ground of an aerodrome; left out unless it is named), other (the radar holds it for something \
         else), unknown (the radar does not say), separated by commas",
    )
    .some_of(|| TrackClass::NAMES.to_vec()),
    QueryParameter::new(
        "integrity",
        "string",
        "of unverified, verified, suspect, failed, none (without a transponder that is judged), separated by commas",
    )
    .some_of(|| with(&State::NAMES, NOT_JUDGED)),
    QueryParameter::new("sensor", "string", "ids of sensors that took part, separated by commas"),
    QueryParameter::new(
        "alt_min",
        "number",
        "least height above mean sea level, metres; tracks of unknown height are left out",
    )
    .within(-1_000.0, 100_000.0),
    QueryParameter::new(
        "alt_max",
        "number",
        "greatest height above mean sea level, metres; tracks of unknown height are left out",
    )
    .within(-1_000.0, 100_000.0),
    QueryParameter::new("ids", "string", "ids of tracks, separated by commas"),
    QueryParameter::new(
        "max_accuracy_m",
        "number",
        "interpolated and extrapolated tracks are left out where accuracy_h_m is above it, 1 to 10000; default: 100; what a \
         sensor measured is always there",
    )
    .within(1.0, 10_000.0),
    QueryParameter::new(
        "limit",
        "integer",
        "tracks at most, 1 to 10000, in the order of their ids; where more are matched, next is there",
    )
    .within(1.0, 10_000.0),
    QueryParameter::new("trail_s", "integer", "each track with its trail of the last seconds, 1 to 600")
        .within(1.0, 600.0),
    QueryParameter::new(
        "include",
        "string",
        "competitors: who else could be each part of a track; default: left out",
    )
    .some_of(|| vec![COMPETITORS]),
    QueryParameter::new(
        "at",
        "string",
        "lagged (default): the slot as it is published; now: where aircraft are predicted to be by then",
    )
    .one_of(configured::<PictureKind>),
];

/// Parameters of a page of the picture.
const PAGE: [QueryParameter; 14] = {
    let [a, b, c, d, e, f, g, h, i, j, k, l, m] = FILTER;
    let after = QueryParameter::new(
        "after",
        "string",
        "next of the page before: tracks behind it, in the order of their ids, which lasts from slot to slot",
    );
    [a, b, c, d, e, f, g, h, i, j, k, l, m, after]
};

const STREAM: [QueryParameter; 15] = {
    let [a, b, c, d, e, f, g, h, i, j, k, l, m] = FILTER;
    let interval = QueryParameter::new(
        "interval_ms",
        "integer",
        "between two tracks events, 250 to 10000; default: each slot",
    )
    .within(250.0, 10_000.0);
    let ticket = QueryParameter::new("ticket", "string", "from POST /api/v1/stream-tickets, for browsers");
    [a, b, c, d, e, f, g, h, i, j, k, l, m, interval, ticket]
};

const WEBSOCKET: [QueryParameter; 16] = {
    let [a, b, c, d, e, f, g, h, i, j, k, l, m, interval, ticket] = STREAM;
    let last = QueryParameter::new(
        "last_event_id",
        "string",
        "id of the last event of before: the stream goes on there while it is remembered, as with the header Last-Event-ID",
    );
    [a, b, c, d, e, f, g, h, i, j, k, l, m, interval, ticket, last]
};

const VIEW: [QueryParameter; 2] = [
    QueryParameter::new("view", "string", "lat1,lng1,lat2,lng2: two corners, degrees; at most 7 km apart")
        .needed(),
    QueryParameter::new(
        "recent_positions_duration",
        "number",
        "seconds, 0 to 60: recent positions in the view, one per second",
    )
    .within(0.0, 60.0),
];

const ALERTS: [QueryParameter; 4] = [
    QueryParameter::new(
        "since",
        "time",
        "of those that ended, those that lasted at this time or began after it",
    ),
    QueryParameter::new("until", "time", "of those that ended, those that began by this time"),
    QueryParameter::new("kind", "string", "those of these kinds, separated by commas")
        .some_of(configured::<AlertKind>),
    QueryParameter::new(
        "limit",
        "integer",
        "alerts that ended at most, the latest first, 1 to 5000; default: 100",
    )
    .within(1.0, 5_000.0),
];

const CONFLICTS: [QueryParameter; 2] = [
    QueryParameter::new(
        "level",
        "string",
        "those of this level or a worse one: none (default), advisory, warning, violation",
    )
    .one_of(levels),
    QueryParameter::new("id", "string", "those of this track"),
];

const CUEING: [QueryParameter; 2] = [
    QueryParameter::new("sensor", "string", "of this camera only"),
    QueryParameter::new("limit", "integer", "targets of each camera at most, 1 to 100; default: 10")
        .within(1.0, 100.0),
];

const TRAIL: [QueryParameter; 3] = [
    QueryParameter::new("since", "time", "default: 10 minutes before until"),
    QueryParameter::new("until", "time", "default: now"),
    QueryParameter::new("format", "string", "geojson (default), gpx, kml or csv")
        .one_of(|| TrailFormat::NAMES.to_vec()),
];

const TIME: [QueryParameter; 1] = [QueryParameter::new("time", "time", "of the picture").needed()];

const SEEK: [QueryParameter; 1] = [QueryParameter::new(
    "time",
    "string",
    "RFC 3339 (2026-03-14T09:00:00Z), or a time of day that the recording has once (09:00:00)",
)
.needed()];

const TILE: [QueryParameter; 3] = [
    QueryParameter::new("z", "integer", "zoom, 0 to 31").within(0.0, 31.0).needed(),
    QueryParameter::new("x", "integer", "column from 180° W, below 2^z")
        .within(0.0, 2_147_483_647.0)
        .needed(),
    QueryParameter::new("y", "integer", "row from the north, below 2^z")
        .within(0.0, 2_147_483_647.0)
        .needed(),
];

const AFTER: [QueryParameter; 1] =
    [QueryParameter::new("after", "integer", "last of the answer before; default: everything that is kept")
        .within(0.0, 9e15)];

/// Parameters of OGC API – Features.
const ITEMS: [QueryParameter; 4] = [
    QueryParameter::new(
        "bbox",
        "string",
        "lon_min,lat_min,lon_max,lat_max, degrees; of six numbers the third and the last are heights, which are not compared",
    ),
    QueryParameter::new(
        "datetime",
        "string",
        "a time of RFC 3339, or an interval start/end with .. for an open end: nothing if the picture is of another time",
    ),
    QueryParameter::new("limit", "integer", "features at most, 1 to 10000; default: 1000")
        .within(1.0, 10_000.0),
    QueryParameter::new("after", "string", "as the link next has it"),
];

const SPEED: [QueryParameter; 1] =
    [QueryParameter::new("speed", "number", "how many times faster than it happened, 0.01 to 1000")
        .within(0.01, 1_000.0)
        .needed()];

const PAIR: [QueryParameter; 5] = [
    QueryParameter::new("sensor", "string", "id of the radar").needed(),
    QueryParameter::new("track", "integer", "the radar's own number of its track (I048/161), 0 to 4095")
        .within(0.0, 4095.0)
        .needed(),
    QueryParameter::new("uas", "string", "serial number of the transponder, as in uas_id of a track")
        .needed(),
    QueryParameter::new(
        "country",
        "string",
        "its registration country, or none, where several have that serial number",
    ),
    QueryParameter::new(
        "verdict",
        "string",
        "correlated, decorrelated, or automatic: as if nothing had been said",
    )
    .one_of(|| Verdict::NAMES.to_vec())
    .needed(),
];

const WHOSE: [QueryParameter; 1] = [QueryParameter::new(
    "country",
    "string",
    "registration country of the transponder, or none, where several have that serial number",
)];

const OPERATOR: [QueryParameter; 1] = [QueryParameter::new(
    "by",
    "string",
    "name of the operator; only without tokens, otherwise the name of the token is used",
)];

/// All routes.
pub static ROUTES: LazyLock<Vec<Route>> = LazyLock::new(|| {
    vec![
        Route::get(
            "/api/v1/tracks",
            "The picture: a GeoJSON FeatureCollection, with a weak ETag",
            Reply::octets::<TrackCollection<'_>>(GEO_JSON, tracks::all),
        )
        .with(&PAGE)
        .or(&[304, 503])
        .weighs(tracks::weight),
        Route::get(
            "/api/v1/tracks/{id}",
            "One track with its contributors and their competitors",
            Reply::octets::<TrackFeature<'_>>(GEO_JSON, tracks::one),
        )
        .or(&[404]),
        Route::get(
            "/api/v1/tracks/{id}/trail",
            "Where a track was, one position per second",
            Reply::octets::<Trail<'_>>(GEO_JSON, history::trail)
                .or::<String>(history::GPX)
                .or::<String>(history::KML)
                .or::<String>(history::CSV),
        )
        .with(&TRAIL)
        .or(&[404, 503])
        .weighs(history::trail_weight),
        Route::get(
            "/api/v1/snapshot",
            "The picture at a past time, to a second",
            Reply::geo(history::snapshot),
        )
        .with(&TIME)
        .or(&[404, 503])
        .weighs(|_| 1),
        Route::get(
            "/api/v1/correlations",
            "Correlations that operators have decided and that are in force",
            Reply::json(correlations::all),
        ),
        Route::post(
            "/api/v1/correlations",
            "A radar track and a transponder are one aircraft, or are not, until its track number ends",
            Scope::Control,
            Reply::later(correlations::correlate),
        )
        .with(&PAIR)
        .or(&[404, 409, 413, 503]),
        Route::get(
            "/api/v1/integrity",
            "Whether the transponders heard in the last hour can be trusted, and why",
            Reply::json(integrity::all),
        ),
        Route::post(
            "/api/v1/integrity/{identity}",
            "What an operator says of a transponder: it overrides the state, not the index",
            Scope::Control,
            Reply::later(integrity::set_verdict),
        )
        .with(&WHOSE)
        .reads::<integrity::VerdictBody>()
        .or(&[404, 408, 409, 503]),
        Route::get(
            "/api/v1/relocations",
            "Radars that operators have moved to where their tracks show them",
            Reply::json(relocations::all),
        ),
        Route::post(
            "/api/v1/relocations/{sensor}",
            "Moves a radar whose tracks contradict its position to where they show it, until this is revoked",
            Scope::Control,
            Reply::later(relocations::apply),
        )
        .or(&[404, 409, 413, 503]),
        Route::post(
            "/api/v1/relocations/{sensor}/revoke",
            "The radar is where the configuration says again",
            Scope::Control,
            Reply::later(relocations::revoke),
        )
        .or(&[404, 409, 413, 503]),
        Route::post(
            POSTED_TO,
            "What a gateway has heard of Remote ID, an object a line with transmitter, message (hexadecimal) and, where it says so, \
             time and receiver: taken as if it had come in datagrams",
            Scope::Input,
            Reply::json(remote_id::post),
        )
        .reads_octets(remote_id::LINES)
        .or_reads::<RemoteIdLine>()
        .or(&[404, 408, 409, 503]),
        Route::post("/api/v1/replay/play", "The replay goes on", Scope::Control, Reply::json(replay::play))
            .or(&[409, 413]),
        Route::post(
            "/api/v1/replay/pause",
            "The replay stops where it is",
            Scope::Control,
            Reply::json(replay::pause),
        )
        .or(&[409, 413]),
        Route::post(
            "/api/v1/replay/seek",
            "The replay goes to a time",
            Scope::Control,
            Reply::json(replay::seek),
        )
        .with(&SEEK)
        .or(&[503]),
        Route::post(
            "/api/v1/replay/speed",
            "The replay goes faster or slower",
            Scope::Control,
            Reply::json(replay::speed),
        )
        .with(&SPEED)
        .or(&[409, 413]),
        Route::get(
            "/api/v1/stream",
            "Server-Sent Events; /api/v1/asyncapi.json describes each",
            Reply::octets::<String>("text/event-stream", stream::open),
        )
        .with(&STREAM)
        .needs(Some(Scope::Stream))
        .or(&[503])
        .streams(),
        Route::get(
            "/api/v1/stream/ws",
            "The same events as messages of a WebSocket, each the text of a JSON object",
            Reply::upgrade::<events::StreamMessage>(websocket::open),
        )
        .with(&WEBSOCKET)
        .needs(Some(Scope::Stream))
        .or(&[426, 503])
        .streams(),
        Route::post(
            "/api/v1/stream-tickets",
            "A ticket that opens one stream within 30 s",
            Scope::Stream,
            Reply::json(issue_ticket),
        )
        .or(&[413]),
        Route::get(
            "/api/v1/raw",
            "What the sensors said, as the engine took it, from the first time that somebody asks",
            Reply::geo(raw::all),
        )
        .with(&AFTER),
        Route::get(
            "/api/v1/sensors",
            "The sensors with their state; sources that are heard and not configured",
            Reply::geo(sensors::sensors),
        ),
        Route::get(
            "/api/v1/basemap",
            "A vector tile (MVT) of the base map, Web Mercator; empty where the map has none",
            Reply::octets::<Binary>(basemap::TILE, basemap::tile).or::<Binary>(basemap::OCTETS),
        )
        .with(&TILE)
        .or(&[404, 503]),
        Route::get("/api/v1/status", "Health with reasons, latency, counters", Reply::json(service::status)),
        Route::get(
            "/api/v1/cluster",
            "Who makes the picture where several machines do: owners, who stands by, gateways",
            Reply::json(cluster::members),
        )
        .or(&[404]),
        Route::get("/api/v1/info", "Version, site and settings", Reply::json(service::info)),
        Route::get(
            "/api/v1/coverage",
            "How far the sensors see, as polygons",
            Reply::octets::<Coverage>(GEO_JSON, sensors::coverage),
        ),
        Route::get(
            "/api/v1/areas",
            "The configured areas, and the zones of operators",
            Reply::geo::<AreaCollection>(sensors::areas),
        ),
        Route::get("/api/v1/zones", "Zones that operators have activated", Reply::json(zones::all)),
        Route::post(
            "/api/v1/zones/{id}",
            "Activates a zone, or replaces the zone of this name: an area of kind alert, kept over a restart",
            Scope::Control,
            Reply::later(zones::activate),
        )
        .with(&OPERATOR)
        .reads::<zones::ZoneBody>()
        .or(&[408, 409, 503, 507]),
        Route::post(
            "/api/v1/zones/{id}/revoke",
            "Revokes a zone that an operator has activated",
            Scope::Control,
            Reply::later(zones::revoke),
        )
        .with(&OPERATOR)
        .or(&[404, 409, 503]),
        Route::get("/api/v1/alerts", "What is wrong now, and what was", Reply::json(alerts::all)).with(&ALERTS),
        Route::post(
            "/api/v1/alerts/{id}/acknowledge",
            "Somebody has seen the alert; one that becomes worse is unseen again",
            Scope::Control,
            Reply::later(alerts::acknowledge),
        )
        .reads::<alerts::Acknowledgement>()
        .or(&[404, 408, 409, 503]),
        Route::post(
            "/api/v1/alerts/{id}/shelve",
            "Nobody is to be bothered with the alert for a while, also where it ends and comes again",
            Scope::Control,
            Reply::later(alerts::shelve),
        )
        .reads::<alerts::Shelving>()
        .or(&[404, 408, 409, 503]),
        Route::post(
            "/api/v1/alerts/{id}/unshelve",
            "That while is over",
            Scope::Control,
            Reply::later(alerts::unshelve),
        )
        .reads::<alerts::Acknowledgement>()
        .or(&[404, 408, 409, 503]),
        Route::get(
            "/api/v1/conflicts",
            "Who will come near whom; where `computed` is false an empty list does not mean that there are none",
            Reply::json(conflicts::conflicts),
        )
        .with(&CONFLICTS),
        Route::get(
            "/api/v1/cueing",
            "Where each camera should look: aircraft in conflict, without a trusted transponder, or unidentified",
            Reply::json(cueing::cues),
        )
        .with(&CUEING),
        Route::get("/data/aircraft.json", "The picture as readsb serves it", Reply::json(readsb::aircraft))
            .any_query(),
        Route::get("/data/receiver.json", "The site as readsb serves it", Reply::json(readsb::receiver))
            .any_query(),
        Route::get(
            "/uss/flights",
            "ASTM F3411-22a display data: flights that identify themselves, in a view",
            Reply::json(uss::flights),
        )
        .with(&VIEW)
        .or(&[413, 503])
        .weighs(uss::weight),
        Route::get(
            "/uss/flights/{id}/details",
            "ASTM F3411-22a display data: who a flight is",
            Reply::json(uss::details),
        )
        .or(&[404]),
        Route::get("/ogc", "OGC API - Features: the landing page", Reply::json(ogc::landing)),
        Route::get("/ogc/conformance", "OGC API - Features: core and GeoJSON", Reply::json(ogc::conformance)),
        Route::get("/ogc/collections", "OGC API - Features: tracks and areas", Reply::json(ogc::collections)),
        Route::get(
            "/ogc/collections/tracks",
            "OGC API - Features: the collection of tracks",
            Reply::json(ogc::tracks_collection),
        ),
        Route::get(
            "/ogc/collections/areas",
            "OGC API - Features: the collection of areas",
            Reply::json(ogc::areas_collection),
        ),
        Route::get(
            "/ogc/collections/tracks/items",
            "OGC API - Features: tracks of the latest slot",
            Reply::octets::<ogc::TrackItems<'_>>(GEO_JSON, ogc::tracks),
        )
        .with(&ITEMS)
        .weighs(|_| 1),
        Route::get(
            "/ogc/collections/tracks/items/{id}",
            "OGC API - Features: one track",
            Reply::octets::<TrackFeature<'_>>(GEO_JSON, tracks::one),
        )
        .or(&[404]),
        Route::get(
            "/ogc/collections/areas/items",
            "OGC API - Features: areas and zones",
            Reply::octets::<ogc::AreaItems>(GEO_JSON, ogc::area_items),
        )
        .with(&ITEMS)
        .weighs(|_| 1),
        Route::get(
            "/ogc/collections/areas/items/{id}",
            "OGC API - Features: one area",
            Reply::octets::<ogc::AreaItem>(GEO_JSON, ogc::area),
        )
        .or(&[404]),
        Route::get("/healthz", "The process is alive", Reply::json(service::health)).probe(),
        Route::get("/readyz", "Lines are joined and slots are published", Reply::json(service::ready))
            .probe()
            .or(&[503]),
        Route::get("/metrics", "Prometheus text", Reply::octets::<String>(metrics::TEXT, metrics::text)),
        Route::get("/openapi.json", "This document", Reply::octets::<Map<String, Value>>(JSON, document))
            .needs(None),
        Route::get(
            "/api/v1/asyncapi.json",
            "AsyncAPI of the stream",
            Reply::octets::<Map<String, Value>>(JSON, stream_document),
        )
        .needs(None),
        Route::get(
            "/api/docs",
            "All of this as a page",
            Reply::octets::<String>("text/html; charset=utf-8", page::docs),
        )
        .any_query()
        .needs(None),
        Route::get("/", "The page", Reply::octets::<String>("text/html; charset=utf-8", page::index))
            .any_query()
            .needs(None),
    ]
});

/// `/openapi.json`.
fn document(request: &ApiRequest) -> ApiResult {
    openapi::document(&ROUTES, request.state.needs_token())
}

/// `/api/v1/asyncapi.json`.
fn stream_document(_: &ApiRequest) -> ApiResult {
    asyncapi::document(&STREAM, &WEBSOCKET)
}
