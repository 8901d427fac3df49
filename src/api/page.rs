//! The pages, the map and that of the API: their files are part of the program.

use std::collections::HashMap;
use std::sync::LazyLock;

use axum::Router;
use axum::http::{HeaderMap, HeaderValue, header};
use axum::response::Response;
use axum::routing::get;
use sha2::{Digest, Sha256};

use super::ask::{Answer, Ask, matches, not_modified, with_type};
use super::gzip;
use super::payload::Payload;
use super::state::ApiState;

/// Every file beside `index.html`: its path, its type and what is in it.
const FILES: &[(&str, &str, &str)] = &[
    ("/alerthistory.js", JAVASCRIPT, include_str!("../web/alerthistory.js")),
    ("/alertitem.js", JAVASCRIPT, include_str!("../web/alertitem.js")),
    ("/alertlist.js", JAVASCRIPT, include_str!("../web/alertlist.js")),
    ("/alerts.js", JAVASCRIPT, include_str!("../web/alerts.js")),
    ("/api.js", JAVASCRIPT, include_str!("../web/api.js")),
    ("/api/docs.css", "text/css; charset=utf-8", include_str!("docs/docs.css")),
    ("/api/docs.js", JAVASCRIPT, include_str!("docs/docs.js")),
    ("/app.js", JAVASCRIPT, include_str!("../web/app.js")),
    ("/attention.js", JAVASCRIPT, include_str!("../web/attention.js")),
    ("/choices.js", JAVASCRIPT, include_str!("../web/choices.js")),
    ("/cluster.js", JAVASCRIPT, include_str!("../web/cluster.js")),
    ("/conflicts.js", JAVASCRIPT, include_str!("../web/conflicts.js")),
    ("/detail.js", JAVASCRIPT, include_str!("../web/detail.js")),
    ("/dom.js", JAVASCRIPT, include_str!("../web/dom.js")),
    ("/exports.js", JAVASCRIPT, include_str!("../web/exports.js")),
    ("/failures.js", JAVASCRIPT, include_str!("../web/failures.js")),
    ("/filter.js", JAVASCRIPT, include_str!("../web/filter.js")),
    ("/filterpanel.js", JAVASCRIPT, include_str!("../web/filterpanel.js")),
    ("/format.js", JAVASCRIPT, include_str!("../web/format.js")),
    ("/furniture.js", JAVASCRIPT, include_str!("../web/furniture.js")),
    ("/geo.js", JAVASCRIPT, include_str!("../web/geo.js")),
    ("/ground.js", JAVASCRIPT, include_str!("../web/ground.js")),
    ("/heights.js", JAVASCRIPT, include_str!("../web/heights.js")),
    ("/icon.svg", "image/svg+xml", include_str!("../web/icon.svg")),
    ("/keyboard.js", JAVASCRIPT, include_str!("../web/keyboard.js")),
    ("/labels.js", JAVASCRIPT, include_str!("../web/labels.js")),
    ("/legend.js", JAVASCRIPT, include_str!("../web/legend.js")),
    ("/lines.js", JAVASCRIPT, include_str!("../web/lines.js")),
    ("/map.js", JAVASCRIPT, include_str!("../web/map.js")),
    ("/measure.js", JAVASCRIPT, include_str!("../web/measure.js")),
    ("/mvt.js", JAVASCRIPT, include_str!("../web/mvt.js")),
    ("/names.js", JAVASCRIPT, include_str!("../web/names.js")),
    ("/news.js", JAVASCRIPT, include_str!("../web/news.js")),
    ("/operator.js", JAVASCRIPT, include_str!("../web/operator.js")),
    ("/overlays.js", JAVASCRIPT, include_str!("../web/overlays.js")),
    ("/palette.js", JAVASCRIPT, include_str!("../web/palette.js")),
    ("/past.js", JAVASCRIPT, include_str!("../web/past.js")),
    ("/picture.js", JAVASCRIPT, include_str!("../web/picture.js")),
    ("/picturetiles.js", JAVASCRIPT, include_str!("../web/picturetiles.js")),
    ("/print.js", JAVASCRIPT, include_str!("../web/print.js")),
    ("/raw.js", JAVASCRIPT, include_str!("../web/raw.js")),
    ("/reads.js", JAVASCRIPT, include_str!("../web/reads.js")),
    ("/replay.js", JAVASCRIPT, include_str!("../web/replay.js")),
    ("/room.js", JAVASCRIPT, include_str!("../web/room.js")),
    ("/sensors.js", JAVASCRIPT, include_str!("../web/sensors.js")),
    ("/settings.js", JAVASCRIPT, include_str!("../web/settings.js")),
    ("/shapes.js", JAVASCRIPT, include_str!("../web/shapes.js")),
    ("/sprites.js", JAVASCRIPT, include_str!("../web/sprites.js")),
    ("/sound.js", JAVASCRIPT, include_str!("../web/sound.js")),
    ("/status.js", JAVASCRIPT, include_str!("../web/status.js")),
    ("/style.css", "text/css; charset=utf-8", include_str!("../web/style.css")),
    ("/symbols.js", JAVASCRIPT, include_str!("../web/symbols.js")),
    ("/table.js", JAVASCRIPT, include_str!("../web/table.js")),
    ("/tiles.js", JAVASCRIPT, include_str!("../web/tiles.js")),
    ("/tools.js", JAVASCRIPT, include_str!("../web/tools.js")),
    ("/trails.js", JAVASCRIPT, include_str!("../web/trails.js")),
    ("/trust.js", JAVASCRIPT, include_str!("../web/trust.js")),
    ("/units.js", JAVASCRIPT, include_str!("../web/units.js")),
    ("/vectortiles.js", JAVASCRIPT, include_str!("../web/vectortiles.js")),
    ("/view.js", JAVASCRIPT, include_str!("../web/view.js")),
    ("/zones.js", JAVASCRIPT, include_str!("../web/zones.js")),
    ("/zonetool.js", JAVASCRIPT, include_str!("../web/zonetool.js")),
];

const JAVASCRIPT: &str = "text/javascript; charset=utf-8";

const INDEX: (&str, &str, &str) = ("/", "text/html; charset=utf-8", include_str!("../web/index.html"));

const DOCS: (&str, &str, &str) = ("/api/docs", "text/html; charset=utf-8", include_str!("docs/index.html"));

/// A file as it is served.
struct File {
    content_type: &'static str,
    payload: Payload,
    /// Which version of it that is, plain and compressed.
    tags: [HeaderValue; 2],
}

/// Compressed when somebody first asks.
static SERVED: LazyLock<HashMap<&str, File>> = LazyLock::new(|| {
    let file = |&(path, content_type, text): &(&'static str, &'static str, &'static str)| {
        let hash = crate::hex::text(&Sha256::digest(text)[..8]);
        let tag = |tag| HeaderValue::try_from(tag).expect("hexadecimal digits in quotes");
        let tags = [tag(format!("\"{hash}\"")), tag(format!("\"{hash}-gzip\""))];
        (path, File { content_type, payload: Payload::from(text.as_bytes()), tags })
    };
    FILES.iter().chain([&INDEX, &DOCS]).map(file).collect()
});

/// `/`.
pub fn index(ask: &Ask) -> Answer {
    Ok(serve(INDEX.0, &ask.headers))
}

/// `/api/docs`.
pub fn docs(ask: &Ask) -> Answer {
    Ok(serve(DOCS.0, &ask.headers))
}

/// The other files; open to everybody, as the page is.
pub fn files() -> Router<ApiState> {
    FILES.iter().fold(Router::new(), |router, &(path, ..)| {
        router.route(path, get(async move |headers: HeaderMap| serve(path, &headers)))
    })
}

/// Whether it is one of them. They are many, small and in memory: loading the page takes nothing of a client's requests.
pub fn is_file(path: &str) -> bool {
    path != INDEX.0 && SERVED.contains_key(path)
}

/// The file as the client takes it, or 304 where it has it.
fn serve(path: &'static str, headers: &HeaderMap) -> Response {
    let file = &SERVED[path];
    let is_gzip = gzip::is_accepted(headers);
    let known = headers.get(header::IF_NONE_MATCH).and_then(|tags| tags.to_str().ok());
    let is_known = known.is_some_and(|known| file.tags.iter().any(|tag| matches(known, tag)));
    let mut response = if is_known {
        not_modified()
    } else {
        let body = if is_gzip { file.payload.gzip() } else { file.payload.plain() };
        // To be kept, and compared before it is used again: a new version of the program has other files.
        with_type(file.content_type, "no-cache", body)
    };
    gzip::label(response.headers_mut(), is_gzip && !is_known);
    response.headers_mut().insert(header::ETAG, file.tags[usize::from(is_gzip)].clone());
    response
}
