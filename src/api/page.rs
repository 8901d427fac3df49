//! The page: the files of `page/`, which are part of the program.

use axum::Router;
use axum::routing::get;

use super::ApiState;
use super::ask::{Answer, Ask, with_type};

/// Every file beside `index.html`: its path, its type and what is in it.
const FILES: &[(&str, &str, &str)] = &[];

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
