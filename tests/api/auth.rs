//! Tokens, tickets, CORS.

use axum::http::{Request, StatusCode};
use utm_fusion::api::{ApiState, Options};
use utm_fusion::config::Auth;

use crate::common::Site;

/// A site with the hashes (SHA-256) of the tokens "reader" and "watcher".
pub(crate) fn site() -> Site {
    let file = std::env::temp_dir().join(format!("utm-fusion-tokens-{}.toml", std::process::id()));
    let text = "reader = { sha256 = \"3d0941964aa3ebdcb00ccef58b1bb399f9f898465e9886d5aec7f31090a0fb30\", scopes = [\"read\"] }\n\
                watcher = { sha256 = \"WATCHER\", scopes = [\"stream\"] }\n";
    std::fs::write(&file, text.replace("WATCHER", WATCHER)).unwrap();
    Site::with(Options::default(), |config| config.http.auth = Auth::Tokens { tokens_file: file })
}

const WATCHER: &str = "0e7f3c5c909ce8afb978a208d639e85af2171df2ec0003a07f13ad97878ef053";

fn bearing(path: &str, token: &str) -> axum::http::request::Builder {
    Request::get(path).header("authorization", format!("Bearer {token}"))
}

#[tokio::test]
async fn a_token_opens_what_its_scopes_say() {
    let site = site();
    let tracks = "/api/v1/tracks";
    assert_eq!(site.ask(bearing(tracks, "reader")).await.status, StatusCode::OK);
    assert_eq!(site.ask(bearing(tracks, "watcher")).await.status, StatusCode::FORBIDDEN);
    for request in [
        Request::get(tracks),
        bearing(tracks, "nobody"),
        Request::get(tracks).header("authorization", "reader"),
    ] {
        let answer = site.ask(request).await;
        assert_eq!(answer.status, StatusCode::UNAUTHORIZED);
        assert_eq!(
            (answer.header("www-authenticate"), answer.header("content-type")),
            ("Bearer", "application/problem+json")
        );
    }
    for open in ["/healthz", "/openapi.json", "/"] {
        assert_eq!(site.get(open).await.status, StatusCode::OK, "{open}");
    }
}

#[tokio::test]
async fn a_ticket_opens_one_stream() {
    let site = site();
    let post = |token: &str| {
        Request::post("/api/v1/stream-tickets").header("authorization", format!("Bearer {token}"))
    };
    assert_eq!(site.ask(post("reader")).await.status, StatusCode::FORBIDDEN);
    let answer = site.ask(post("watcher")).await.json();
    assert_eq!(answer["expires_in_s"], 30);
    let address = site.listen().await;
    let path = format!("/api/v1/stream?ticket={}", answer["ticket"].as_str().unwrap());
    let mut reader = crate::common::Reader::open(address, &path, "").await;
    assert_eq!(reader.next().await.unwrap().name, "snapshot");
    assert_eq!(site.get(&path).await.status, StatusCode::UNAUTHORIZED);
    assert_eq!(site.get("/api/v1/stream").await.status, StatusCode::UNAUTHORIZED);
}

#[tokio::test]
async fn missing_token_file_is_reported() {
    let file: std::path::PathBuf = "/nowhere/tokens.toml".into();
    let flown = crate::common::flown();
    let mut config = flown.config.clone();
    config.http.auth = Auth::Tokens { tokens_file: file };
    let (_, hub) = utm_fusion::live::Hub::new(config.into(), flown.maker.clone().into(), flown.frames[0].due);
    let error = ApiState::start(hub, Options::default()).unwrap_err();
    assert!(error.to_string().contains("/nowhere/tokens.toml"), "{error}");
}

#[tokio::test]
async fn pages_of_listed_origins_may_ask() {
    let site =
        Site::with(Options::default(), |config| config.http.cors = vec!["https://map.example".to_owned()]);
    let allowed = site.ask(Request::get("/api/v1/info").header("origin", "https://map.example")).await;
    assert_eq!(allowed.header("access-control-allow-origin"), "https://map.example");
    let other = site.ask(Request::get("/api/v1/info").header("origin", "https://other.example")).await;
    assert_eq!(other.header("access-control-allow-origin"), "");
    let preflight = Request::options("/api/v1/tracks")
        .header("origin", "https://map.example")
        .header("access-control-request-method", "GET");
    assert_eq!(site.ask(preflight).await.status, StatusCode::NO_CONTENT);
}
