//! The map page and the API page. Their files are part of the program.

use std::collections::HashMap;
use std::sync::LazyLock;

use axum::Router;
use axum::http::{HeaderMap, HeaderValue, header};
use axum::response::Response;
use axum::routing::get;
use sha2::{Digest, Sha256};

use super::gzip;
use super::payload::Payload;
use super::request::{ApiRequest, ApiResult, matches, not_modified, with_type};
use super::state::ApiState;

/// Files besides `index.html`: path, media type and content.
const FILES: &[(&str, &str, &str)] = &[
    ("/activezones.js", JAVASCRIPT, include_str!("../web/activezones.js")),
    ("/advice.js", JAVASCRIPT, include_str!("../web/advice.js")),
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
    ("/clock.js", JAVASCRIPT, include_str!("../web/clock.js")),
    ("/cluster.js", JAVASCRIPT, include_str!("../web/cluster.js")),
    ("/condition.js", JAVASCRIPT, include_str!("../web/condition.js")),
    ("/conflicts.js", JAVASCRIPT, include_str!("../web/conflicts.js")),
    ("/crowds.js", JAVASCRIPT, include_str!("../web/crowds.js")),
    ("/detail.js", JAVASCRIPT, include_str!("../web/detail.js")),
    ("/dom.js", JAVASCRIPT, include_str!("../web/dom.js")),
    ("/exports.js", JAVASCRIPT, include_str!("../web/exports.js")),
    ("/failures.js", JAVASCRIPT, include_str!("../web/failures.js")),
    ("/filter.js", JAVASCRIPT, include_str!("../web/filter.js")),
    ("/filterpanel.js", JAVASCRIPT, include_str!("../web/filterpanel.js")),
    ("/fixtures.js", JAVASCRIPT, include_str!("../web/fixtures.js")),
    ("/format.js", JAVASCRIPT, include_str!("../web/format.js")),
    ("/freespace.js", JAVASCRIPT, include_str!("../web/freespace.js")),
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
    ("/sensors.js", JAVASCRIPT, include_str!("../web/sensors.js")),
    ("/settings.js", JAVASCRIPT, include_str!("../web/settings.js")),
    ("/shapes.js", JAVASCRIPT, include_str!("../web/shapes.js")),
    ("/sound.js", JAVASCRIPT, include_str!("../web/sound.js")),
    ("/sprites.js", JAVASCRIPT, include_str!("../web/sprites.js")),
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
    ("/welcome.js", JAVASCRIPT, include_str!("../web/welcome.js")),
    ("/zones.js", JAVASCRIPT, include_str!("../web/zones.js")),
    ("/zonetool.js", JAVASCRIPT, include_str!("../web/zonetool.js")),
];

const JAVASCRIPT: &str = "text/javascript; charset=utf-8";

const INDEX: (&str, &str, &str) = ("/", "text/html; charset=utf-8", include_str!("../web/index.html"));

const DOCS: (&str, &str, &str) = ("/api/docs", "text/html; charset=utf-8", include_str!("docs/index.html"));

/// A file as served.
struct File {
    content_type: &'static str,
    payload: Payload,
    /// Entity tags of the plain and of the compressed content.
    tags: [HeaderValue; 2],
}

/// Files by path, compressed on the first request.
static SERVED: LazyLock<HashMap<&str, File>> = LazyLock::new(|| {
    let file = |&(path, content_type, text): &(&'static str, &'static str, &'static str)| {
        let hash = input::hex::text(&Sha256::digest(text)[..8]);
        let tag = |tag| HeaderValue::try_from(tag).expect("hexadecimal digits in quotes");
        let tags = [tag(format!("\"{hash}\"")), tag(format!("\"{hash}-gzip\""))];
        (path, File { content_type, payload: Payload::from(text.as_bytes()), tags })
    };
    FILES.iter().chain([&INDEX, &DOCS]).map(file).collect()
});

/// `/`.
pub fn index(request: &ApiRequest) -> ApiResult {
    Ok(serve(INDEX.0, &request.headers))
}

/// `/api/docs`.
pub fn docs(request: &ApiRequest) -> ApiResult {
    Ok(serve(DOCS.0, &request.headers))
}

/// Router of the other files, public like the page itself.
pub fn files() -> Router<ApiState> {
    FILES.iter().fold(Router::new(), |router, &(path, ..)| {
        router.route(path, get(async move |headers: HeaderMap| serve(path, &headers)))
    })
}

/// Whether the path is one of these files. They are many, small and in memory, so loading the page does not count against the
/// client's request limit.
pub fn is_file(path: &str) -> bool {
    path != INDEX.0 && SERVED.contains_key(path)
}

/// The file in the wanted encoding, or 304 if the client has it.
fn serve(path: &'static str, headers: &HeaderMap) -> Response {
    let file = &SERVED[path];
    let is_gzip = gzip::is_accepted(headers);
    let known = headers.get(header::IF_NONE_MATCH).and_then(|tags| tags.to_str().ok());
    let is_known = known.is_some_and(|known| file.tags.iter().any(|tag| matches(known, tag)));
    let mut response = if is_known {
        not_modified()
    } else {
        let body = if is_gzip { file.payload.gzip() } else { file.payload.plain() };
        // Clients may cache the file but must revalidate it, because a new version of the program has other files.
        with_type(file.content_type, "no-cache", body)
    };
    gzip::label(response.headers_mut(), is_gzip && !is_known);
    response.headers_mut().insert(header::ETAG, file.tags[usize::from(is_gzip)].clone());
    response
}
