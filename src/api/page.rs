//! The page: the files of `page/`, which are part of the program.

use axum::Router;
use axum::routing::get;

use super::ApiState;
use super::ask::{Answer, Ask, with_type};

/// Every file beside `index.html`: its path, its type and what is in it.
const FILES: &[(&str, &str, &str)] = &[
    ("/alerts.js", JAVASCRIPT, include_str!("page/alerts.js")),
    ("/api.js", JAVASCRIPT, include_str!("page/api.js")),
    ("/app.js", JAVASCRIPT, include_str!("page/app.js")),
    ("/detail.js", JAVASCRIPT, include_str!("page/detail.js")),
    ("/dom.js", JAVASCRIPT, include_str!("page/dom.js")),
    ("/failures.js", JAVASCRIPT, include_str!("page/failures.js")),
    ("/format.js", JAVASCRIPT, include_str!("page/format.js")),
    ("/furniture.js", JAVASCRIPT, include_str!("page/furniture.js")),
    ("/geo.js", JAVASCRIPT, include_str!("page/geo.js")),
    ("/ground.js", JAVASCRIPT, include_str!("page/ground.js")),
    ("/icon.svg", "image/svg+xml", include_str!("page/icon.svg")),
    ("/keyboard.js", JAVASCRIPT, include_str!("page/keyboard.js")),
    ("/lines.js", JAVASCRIPT, include_str!("page/lines.js")),
    ("/map.js", JAVASCRIPT, include_str!("page/map.js")),
    ("/news.js", JAVASCRIPT, include_str!("page/news.js")),
    ("/overlays.js", JAVASCRIPT, include_str!("page/overlays.js")),
    ("/palette.js", JAVASCRIPT, include_str!("page/palette.js")),
    ("/picture.js", JAVASCRIPT, include_str!("page/picture.js")),
    ("/raw.js", JAVASCRIPT, include_str!("page/raw.js")),
    ("/reads.js", JAVASCRIPT, include_str!("page/reads.js")),
    ("/replay.js", JAVASCRIPT, include_str!("page/replay.js")),
    ("/sensors.js", JAVASCRIPT, include_str!("page/sensors.js")),
    ("/settings.js", JAVASCRIPT, include_str!("page/settings.js")),
    ("/shapes.js", JAVASCRIPT, include_str!("page/shapes.js")),
    ("/status.js", JAVASCRIPT, include_str!("page/status.js")),
    ("/style.css", "text/css; charset=utf-8", include_str!("page/style.css")),
    ("/symbols.js", JAVASCRIPT, include_str!("page/symbols.js")),
    ("/table.js", JAVASCRIPT, include_str!("page/table.js")),
    ("/tiles.js", JAVASCRIPT, include_str!("page/tiles.js")),
    ("/view.js", JAVASCRIPT, include_str!("page/view.js")),
];

const JAVASCRIPT: &str = "text/javascript; charset=utf-8";

/// `/`.
pub fn index(_: &Ask) -> Answer {
    Ok(with_type("text/html; charset=utf-8", "no-cache", include_str!("page/index.html")))
}

/// The other files; open to everybody, as the page is.
pub fn files() -> Router<ApiState> {
    FILES.iter().fold(Router::new(), |router, &(path, content_type, text)| {
        router.route(path, get(async move || with_type(content_type, "no-cache", text)))
    })
}
