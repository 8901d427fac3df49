//! Compression and caching of answers: fewer octets, the same content.

use std::io::{Read, Write};
use std::time::Duration;

use axum::body::{Body, to_bytes};
use axum::http::{HeaderMap, Request, StatusCode};
use flate2::read::GzDecoder;
use tokio::net::TcpStream;
use tower::ServiceExt;

use crate::common::{Site, estimated, receive, send};

/// Status, headers and octets, as received.
async fn raw(
    site: &Site,
    method: &str,
    path: &str,
    headers: &[(&str, &str)],
) -> (StatusCode, HeaderMap, Vec<u8>) {
    let mut request = Request::builder().method(method).uri(path);
    for (name, value) in headers {
        request = request.header(*name, *value);
    }
    let response = site.app.clone().oneshot(request.body(Body::empty()).unwrap()).await.unwrap();
    let (parts, body) = response.into_parts();
    (parts.status, parts.headers, to_bytes(body, 1 << 26).await.unwrap().to_vec())
}

fn unpacked(octets: &[u8]) -> Vec<u8> {
    let mut plain = Vec::new();
    GzDecoder::new(octets).read_to_end(&mut plain).unwrap();
    plain
}

fn text<'a>(headers: &'a HeaderMap, name: &str) -> &'a str {
    headers.get(name).map_or("", |value| value.to_str().unwrap())
}

const GZIP: (&str, &str) = ("accept-encoding", "gzip, deflate, br");

#[tokio::test]
async fn whole_texts_are_gzip_where_the_client_takes_it() {
    let mut site = Site::plain();
    site.publish_status(site.status()).await;
    site.publish(40).await;
    for path in [
        "/api/v1/tracks",
        "/api/v1/tracks?source=fused,radar",
        "/api/v1/tracks?trail_s=5",
        "/data/aircraft.json",
        "/metrics",
        "/openapi.json",
        "/",
        "/app.js",
        "/style.css",
    ] {
        let (_, headers, plain) = raw(&site, "GET", path, &[]).await;
        assert_eq!(
            (text(&headers, "content-encoding"), text(&headers, "vary")),
            ("", "accept-encoding"),
            "{path}"
        );
        let (status, headers, packed) = raw(&site, "GET", path, &[GZIP]).await;
        assert_eq!((status, text(&headers, "content-encoding")), (StatusCode::OK, "gzip"), "{path}");
        assert_eq!(text(&headers, "vary"), "accept-encoding", "{path}");
        assert!(2 * packed.len() < plain.len(), "{path}: {} of {}", packed.len(), plain.len());
        // Counters in the metrics have changed since.
        assert!(path == "/metrics" || unpacked(&packed) == plain, "{path}");
        let (_, headers, _) = raw(&site, "GET", path, &[("accept-encoding", "gzip;q=0, br")]).await;
        assert_eq!(text(&headers, "content-encoding"), "", "{path}");
        let (status, headers, head) = raw(&site, "HEAD", path, &[GZIP]).await;
        assert_eq!(
            (status, head.len(), text(&headers, "vary")),
            (StatusCode::OK, 0, "accept-encoding"),
            "{path}"
        );
    }
    // Too short to compress, and a problem.
    for path in ["/healthz", "/nothing"] {
        let (_, headers, _) = raw(&site, "GET", path, &[GZIP]).await;
        assert_eq!(text(&headers, "content-encoding"), "", "{path}");
    }
}

#[tokio::test]
async fn a_file_of_the_page_is_fetched_once() {
    let site = Site::plain();
    for path in ["/", "/app.js", "/style.css", "/icon.svg"] {
        let (_, plain, _) = raw(&site, "GET", path, &[]).await;
        let (_, packed, _) = raw(&site, "GET", path, &[GZIP]).await;
        let (plain, packed) = (text(&plain, "etag").to_owned(), text(&packed, "etag").to_owned());
        assert!(
            plain.starts_with('"') && packed.starts_with('"') && plain != packed,
            "{path}: {plain} {packed}"
        );
        for (known, accept, now) in [
            (&*plain, "", &plain),
            (&packed, "gzip", &packed),
            // The tag of either encoding matches, because the file is the same.
            (&plain, "gzip", &packed),
            (&format!("\"other\", W/{plain}"), "", &plain),
            ("*", "", &plain),
        ] {
            let sent = [("if-none-match", known), ("accept-encoding", accept)];
            let (status, headers, body) = raw(&site, "GET", path, &sent).await;
            assert_eq!((status, body.len()), (StatusCode::NOT_MODIFIED, 0), "{path} {known}");
            assert_eq!((text(&headers, "etag"), text(&headers, "vary")), (now.as_str(), "accept-encoding"));
            assert_eq!(
                (text(&headers, "cache-control"), text(&headers, "content-encoding")),
                ("no-cache", "")
            );
        }
        let (status, ..) = raw(&site, "GET", path, &[("if-none-match", "\"other\"")]).await;
        assert_eq!(status, StatusCode::OK);
    }
}

#[tokio::test]
async fn compressed_stream_delivers_each_event_at_once() {
    let mut site = Site::plain();
    site.publish(1).await;
    let address = site.listen().await;
    for query in ["", "?source=fused,radar,transponder"] {
        let socket = TcpStream::connect(address).await.unwrap();
        // With HTTP/1.0 the answer ends with the connection.
        let request = format!("GET /api/v1/stream{query} HTTP/1.0\r\nAccept-Encoding: gzip\r\n\r\n");
        send(&socket, request.as_bytes()).await;
        let (mut head, mut unpacker) = (Vec::new(), flate2::write::GzDecoder::new(Vec::new()));
        let mut more = async |unpacker: &mut flate2::write::GzDecoder<Vec<u8>>| {
            let mut octets = [0; 1 << 16];
            let count = tokio::time::timeout(Duration::from_secs(60), receive(&socket, &mut octets));
            let count = count.await.expect("an event waits for the next one");
            let mut rest = &octets[..count];
            if !head.ends_with(b"\r\n\r\n") {
                head.extend_from_slice(rest);
                let end = head.windows(4).position(|part| part == b"\r\n\r\n");
                let Some(end) = end else { return count > 0 };
                rest = &rest[rest.len() - (head.len() - end - 4)..];
                let lines = String::from_utf8_lossy(&head[..end]).to_lowercase();
                assert!(
                    lines.contains("content-encoding: gzip") && lines.contains("vary: accept-encoding"),
                    "{lines}"
                );
                head.truncate(end + 4);
            }
            unpacker.write_all(rest).unwrap();
            unpacker.flush().unwrap();
            count > 0
        };
        let holds = |unpacker: &flate2::write::GzDecoder<Vec<u8>>, part: &str| {
            String::from_utf8_lossy(unpacker.get_ref()).contains(part)
        };
        while !holds(&unpacker, "event: snapshot") {
            assert!(more(&mut unpacker).await);
        }
        for _ in 0..5 {
            site.publish(1).await;
            let seq = site.get("/api/v1/tracks?limit=1").await.json()["seq"].as_u64().unwrap();
            // The next slot is published only after this one was received.
            let told = format!("\"seq\":{seq},\"site\"");
            while !holds(&unpacker, &told) || !unpacker.get_ref().ends_with(b"\n\n") {
                assert!(more(&mut unpacker).await);
            }
        }
        if query.is_empty() {
            continue;
        }
        site.state.close();
        while more(&mut unpacker).await {}
        // The decoder has verified the checksum.
        let plain = unpacker.finish().unwrap();
        let plain = String::from_utf8(plain).unwrap();
        assert!(plain.contains("event: closed\ndata: "), "{plain}");
        assert!(plain.matches("event: tracks\n").count() == 5, "{plain}");
    }
}

#[tokio::test]
async fn competitors_are_included_on_request() {
    let mut site = Site::operational();
    let rival = |frame: &&utm_fusion::live::PublishedPicture| {
        frame.picture.tracks.iter().any(|track| !track.point.competitors.is_empty())
    };
    let frame =
        estimated().frames.iter().rfind(rival).expect("two come near each other in this flight").clone();
    site.publish(1).await;
    let seq = frame.seq + 1_000;
    site.writer.publish(utm_fusion::live::PublishedPicture { seq, ..frame.clone() });
    site.shown(seq).await;
    let whole = site.get("/api/v1/tracks?include=competitors").await.json();
    let lean = site.get("/api/v1/tracks").await.json();
    let features = |value: &serde_json::Value| value["features"].as_array().unwrap().clone();
    let mut seen = 0;
    for (mut full, lean) in features(&whole).into_iter().zip(features(&lean)) {
        let id = lean["id"].as_str().unwrap();
        assert_eq!(site.get(&format!("/api/v1/tracks/{id}")).await.json(), full);
        for part in full["properties"]["contributors"].as_array_mut().unwrap() {
            seen += usize::from(part.as_object_mut().unwrap().remove("competitors").is_some());
        }
        assert_eq!(full, lean, "nothing else is different");
    }
    assert!(seen > 0);
    let address = site.listen().await;
    for (query, told) in
        [("", false), ("?include=competitors", true), ("?include=competitors&trail_s=5", true)]
    {
        let path = format!("/api/v1/stream{query}");
        let snapshot = crate::common::Reader::open(address, &path, "").await.next().await.unwrap();
        assert_eq!(snapshot.data.to_string().contains("\"competitors\""), told, "{query}");
    }
    assert_eq!(site.get("/api/v1/tracks?include=everything").await.json()["parameter"], "include");
}
