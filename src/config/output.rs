//! `[output]`, `[http]` and `[state]`.

use std::net::{Ipv4Addr, SocketAddr};
use std::path::{self, Path, PathBuf};

use super::network::read_sink;
use super::reader::{Item, Section, each};
use super::types::{Auth, Http, Output, RateLimit, Record, SerialSource, State, Tiles};

pub(super) fn read_output(mut section: Section<'_>) -> Option<Output> {
    let asterix = each(section.item("asterix"), read_sink);
    let serial = section
        .item("serial")
        .and_then(|i| i.word(&[("uas", SerialSource::Uas), ("track-number", SerialSource::TrackNumber)]));
    let status = section.item("status").and_then(|item| item.flag());
    let flush_on_stop = section.item("flush_on_stop").and_then(|item| item.flag());
    let record = section.item("record").and_then(|item| read_record(item.section()?));
    section.finish();
    Some(Output {
        asterix: asterix?,
        serial: serial.unwrap_or(SerialSource::Uas),
        status: status.unwrap_or(true),
        flush_on_stop: flush_on_stop.unwrap_or(true),
        record,
    })
}

fn read_record(mut section: Section<'_>) -> Option<Record> {
    let dir = read_dir(section.need("dir", "dir = …, the directory of the recordings"));
    let rotate_mib = section
        .item("rotate_mib")
        .and_then(|i| i.whole(1..=1_048_576u32, "a file grows to a whole number of MiB, 1 to 1048576"));
    let keep = section
        .item("keep")
        .and_then(|i| i.whole(1..=1_000_000u32, "the files kept are a whole number, 1 to 1000000"));
    section.finish();
    Some(Record { dir: dir?, rotate_mib: rotate_mib.unwrap_or(256), keep: keep.unwrap_or(16) })
}

pub(super) fn read_http(mut section: Section<'_>, config: &Path) -> Option<Http> {
    let listen_item = section.item("listen");
    let listen = listen_item.as_ref().map_or(Some(SocketAddr::from((Ipv4Addr::LOCALHOST, 8080))), |item| {
        let listen = item.text()?.parse().ok();
        if listen.is_none() {
            item.refuse(
                "expected an address and a port, such as \"127.0.0.1:8080\"; names are not looked up",
            );
        }
        listen
    });
    let auth = section.item("auth").map(|item| read_auth(item.section()?, config));
    let cors = section.item("cors").map_or(Some(Vec::new()), |list| {
        let read: Vec<_> = list.list()?.iter().map(read_origin).collect();
        read.into_iter().collect()
    });
    let limit = read_limit(&mut section);
    let tiles = section.item("tiles").map(|item| read_tiles(item.section()?));
    section.finish();
    let http = Http {
        listen: listen?,
        auth: auth.unwrap_or(Some(Auth::None))?,
        cors: cors?,
        limit: limit?,
        tiles: tiles.map_or(Some(None), |tiles| tiles.map(Some))?,
    };
    if let (Auth::None, false, Some(item)) = (&http.auth, http.is_local(), listen_item) {
        item.refuse(
            "without authentication the service listens on a loopback address only; write 127.0.0.1, \
             or auth = { mode = \"tokens\", tokens_file = … }",
        );
    }
    Some(http)
}

/// `requests_per_s` and `requests_burst`.
fn read_limit(section: &mut Section<'_>) -> Option<Option<RateLimit>> {
    const RULE: &str = "requests a second of one address are a whole number, 0 (no limit) to 1000000";
    let usual = RateLimit::default();
    let requests_per_s = section
        .item("requests_per_s")
        .map_or(Some(usual.requests_per_s), |i| i.whole(0..=1_000_000u32, RULE));
    if requests_per_s == Some(0) {
        if let Some(item) = section.stray("requests_burst") {
            item.refuse("with requests_per_s = 0 there is no limit; remove this key or set a rate");
        }
        return Some(None);
    }
    let rule = "requests at once are a whole number, 1 to 1000000";
    let burst = section.item("requests_burst").map(|item| item.whole(1..=1_000_000u32, rule));
    let requests_per_s = requests_per_s?;
    // As the defaults are to each other: four seconds' worth.
    let burst = burst.unwrap_or(Some(requests_per_s.saturating_mul(usual.burst / usual.requests_per_s)))?;
    Some(Some(RateLimit { requests_per_s, burst }))
}

fn read_auth(mut section: Section<'_>, config: &Path) -> Option<Auth> {
    let mode = section.need("mode", "mode = \"none\" or mode = \"tokens\"");
    let mode = mode.and_then(|item| item.word(&[("none", false), ("tokens", true)]));
    let auth = match mode {
        Some(true) => section
            .need("tokens_file", "tokens_file = …, the file of the tokens' hashes and scopes")
            .and_then(|item| {
                let written = config.parent().unwrap_or(Path::new("")).join(item.text()?);
                Some(Auth::Tokens { tokens_file: path::absolute(&written).unwrap_or(written) })
            }),
        Some(false) => {
            if let Some(item) = section.stray("tokens_file") {
                item.refuse(
                    "without mode = \"tokens\" nobody reads this file; remove the key or change the mode",
                );
            }
            Some(Auth::None)
        }
        None => {
            section.abandon();
            None
        }
    };
    section.finish();
    auth
}

fn read_tiles(mut section: Section<'_>) -> Option<Tiles> {
    let url = section.need("url", "url = \"https://host/{z}/{x}/{y}.png\"").and_then(|item| {
        let tiles = Tiles { url: item.text()?.to_owned(), attribution: String::new() };
        let whole = ["/{z}", "{x}", "{y}"].iter().all(|part| tiles.url.contains(part));
        if !whole || !is_origin(tiles.origin()) {
            item.refuse("tiles are at https://host/… or http://host/…, with {z}, {x} and {y} in the path");
        }
        Some(tiles.url)
    });
    let attribution = section.item("attribution").map(|item| Some(item.text()?.to_owned()));
    section.finish();
    Some(Tiles { url: url?, attribution: attribution.unwrap_or(Some(String::new()))? })
}

/// Whether it is `scheme://host[:port]`, as a browser writes it.
fn is_origin(text: &str) -> bool {
    let host = text.strip_prefix("https://").or_else(|| text.strip_prefix("http://"));
    let plain = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || "-.:[]".contains(c);
    host.is_some_and(|host| !host.is_empty() && host.chars().all(plain))
}

fn read_origin(item: &Item<'_>) -> Option<String> {
    let text = item.text()?;
    if !is_origin(text) {
        item.refuse(
            "an origin is https://host or http://host, in lower case, with :port where it is no usual one",
        );
    }
    Some(text.to_owned())
}

pub(super) fn read_state(mut section: Section<'_>) -> Option<State> {
    let dir = section.item("dir").map(|item| read_dir(Some(item)));
    let hours = section.item("history_hours").map(|item| {
        item.number("the history goes back 0 (none) to 8784 hours", |hours| (0.0..=8784.0).contains(&hours))
    });
    let mib = section
        .item("history_mib")
        .map(|item| item.whole(1..=1_048_576u32, "the history takes a whole number of MiB, 1 to 1048576"));
    section.finish();
    Some(State {
        dir: dir.unwrap_or(Some(PathBuf::from("state")))?,
        history_hours: hours.unwrap_or(Some(24.0))?,
        history_mib: mib.unwrap_or(Some(512))?,
    })
}

fn read_dir(item: Option<Item<'_>>) -> Option<PathBuf> {
    Some(item?.text()?.into())
}
