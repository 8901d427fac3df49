//! A stand-in for the service: the page's files, the answers of the API and the stream, of a flight made beforehand.

use std::collections::BTreeSet;
use std::fs;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::{TcpListener, TcpStream};
use std::path::Path;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use serde_json::{Value, json};

const SLOT: Duration = Duration::from_millis(250);
/// Far enough into the flight for drones to be fused.
const FIRST_SLOT: usize = 200;

pub struct Server {
    url: String,
    shared: Arc<Shared>,
}

struct Shared {
    slots: Vec<Vec<Value>>,
    started: Instant,
    silent: AtomicBool,
    /// Goes up when all streams are cut.
    cuts: AtomicUsize,
    is_replay: AtomicBool,
    posts: Mutex<Vec<String>>,
    sensor: Mutex<&'static str>,
    alerts: Mutex<Vec<Value>>,
}

impl Server {
    pub fn start(slots: Vec<Vec<Value>>) -> Self {
        let listener = TcpListener::bind(("127.0.0.1", 0)).unwrap();
        let url = format!("http://{}/", listener.local_addr().unwrap());
        let shared = Arc::new(Shared {
            slots,
            started: Instant::now(),
            silent: AtomicBool::new(false),
            cuts: AtomicUsize::new(0),
            is_replay: AtomicBool::new(false),
            posts: Mutex::default(),
            sensor: Mutex::new("operational"),
            alerts: Mutex::new(Vec::new()),
        });
        let serving = Arc::clone(&shared);
        std::thread::spawn(move || {
            for connection in listener.incoming().flatten() {
                let shared = Arc::clone(&serving);
                // A browser that goes away in the middle is no failure of the page's.
                std::thread::spawn(move || drop(shared.answer(connection)));
            }
        });
        Self { url, shared }
    }

    /// Ends in a slash.
    pub fn url(&self) -> &str {
        &self.url
    }

    /// Whether the stream says nothing while its connection stays open.
    pub fn silent(&self, is_silent: bool) {
        self.shared.silent.store(is_silent, Ordering::Relaxed);
    }

    /// Ends every stream's connection, as a restart of the service does.
    pub fn cut(&self) {
        self.shared.cuts.fetch_add(1, Ordering::Relaxed);
    }

    /// Says from now on that it replays a recording.
    pub fn replay(&self) {
        self.shared.is_replay.store(true, Ordering::Relaxed);
    }

    /// The paths and bodies that were posted.
    pub fn posts(&self) -> Vec<String> {
        self.shared.posts.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    pub fn sensor(&self, state: &'static str) {
        *self.shared.sensor.lock().unwrap_or_else(PoisonError::into_inner) = state;
    }

    pub fn alert(&self, text: &str) {
        let since = self.shared.slots[FIRST_SLOT][0]["time"].clone();
        let alert =
            json!({"id": "1", "kind": "integrity", "severity": "warning", "since": since, "text": text});
        self.shared.alerts.lock().unwrap_or_else(PoisonError::into_inner).push(alert);
    }
}

impl Shared {
    fn answer(&self, mut connection: TcpStream) -> std::io::Result<()> {
        let mut reader = BufReader::new(connection.try_clone()?);
        let mut request = String::new();
        reader.read_line(&mut request)?;
        let mut length = 0;
        loop {
            let mut header = String::new();
            reader.read_line(&mut header)?;
            match header.trim_end().to_ascii_lowercase().split_once(": ") {
                Some(("content-length", value)) => length = value.parse().unwrap_or(0),
                Some(_) => {}
                None => break,
            }
        }
        let mut body = vec![0; length];
        reader.read_exact(&mut body)?;
        let path = request.split(' ').nth(1).unwrap_or_default();
        if request.starts_with("POST ") {
            let post = format!("{path} {}", String::from_utf8_lossy(&body));
            self.posts.lock().unwrap_or_else(PoisonError::into_inner).push(post);
            return send(&mut connection, "application/json", b"{}");
        }
        match path.strip_prefix("/api/v1/") {
            Some("stream") => self.stream(connection),
            Some(name) => send(&mut connection, "application/json", self.api(name).to_string().as_bytes()),
            None => {
                let name = if path == "/" { "index.html" } else { &path[1..] };
                let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/api/page");
                match fs::read(page.join(name)) {
                    Ok(body) => send(&mut connection, content_type(name), &body),
                    Err(_) => connection.write_all(
                        b"HTTP/1.1 404 Not Found\r\ncontent-length: 0\r\nconnection: close\r\n\r\n",
                    ),
                }
            }
        }
    }

    fn api(&self, name: &str) -> Value {
        match name {
            "info" => json!({"version": "0", "site": "crossing", "profile": "reference", "slot_s": 0.25,
                "latency_s": 6.25, "fusion": {"ratio_min": 0.9},
                "mode": if self.is_replay.load(Ordering::Relaxed) { "replay" } else { "live" }}),
            "sensors" => json!({"type": "FeatureCollection", "unknown": [], "features": [
                {"type": "Feature", "properties": self.radar(),
                    "geometry": {"type": "Point", "coordinates": [-0.588, 52.5065]}},
                {"type": "Feature", "geometry": null,
                    "properties": {"id": "drone-it", "kind": "transponder", "state": "operational", "reasons": []}},
            ]}),
            "alerts" => json!({"alerts": *self.alerts.lock().unwrap_or_else(PoisonError::into_inner)}),
            _ => json!({"type": "FeatureCollection", "features": []}),
        }
    }

    fn radar(&self) -> Value {
        let state = *self.sensor.lock().unwrap_or_else(PoisonError::into_inner);
        let reasons = if state == "operational" { json!([]) } else { json!(["nothing heard for 12 s"]) };
        json!({"id": "gamekeeper", "kind": "radar", "state": state, "reasons": reasons})
    }

    fn stream(&self, mut connection: TcpStream) -> std::io::Result<()> {
        connection.write_all(
            b"HTTP/1.1 200 OK\r\ncontent-type: text/event-stream\r\ncache-control: no-store\r\nconnection: close\r\n\r\n",
        )?;
        let mut said = (Value::Null, 0);
        let mut before = BTreeSet::new();
        let mut name = "snapshot";
        let cuts = self.cuts.load(Ordering::Relaxed);
        while cuts == self.cuts.load(Ordering::Relaxed) {
            let slot = FIRST_SLOT + (self.started.elapsed().as_millis() / SLOT.as_millis()) as usize;
            let tracks = &self.slots[slot % self.slots.len()];
            if !self.silent.load(Ordering::Relaxed) {
                event(&mut connection, name, &collection(tracks, slot))?;
                name = "tracks";
                let ids: BTreeSet<_> = tracks.iter().filter_map(|track| track["id"].as_str()).collect();
                let ended: Vec<_> = before.difference(&ids).collect();
                event(&mut connection, "ended", &json!({"time": tracks[0]["time"], "ids": ended}))?;
                before = ids;
                let alerts = self.alerts.lock().unwrap_or_else(PoisonError::into_inner).clone();
                for alert in &alerts[said.1..] {
                    event(&mut connection, "alert", alert)?;
                }
                let radar = self.radar();
                if radar != said.0 {
                    event(&mut connection, "sensor", &radar)?;
                }
                said = (radar, alerts.len());
            }
            std::thread::sleep(SLOT);
        }
        Ok(())
    }
}

fn collection(tracks: &[Value], seq: usize) -> Value {
    let features: Vec<_> = tracks
        .iter()
        .map(|track| {
            let point = json!({"type": "Point", "coordinates": [track["lng"], track["lat"]]});
            json!({"type": "Feature", "geometry": point, "properties": track})
        })
        .collect();
    json!({"type": "FeatureCollection", "time": tracks[0]["time"], "latency_s": 6.25, "seq": seq, "features": features})
}

fn event(connection: &mut TcpStream, name: &str, data: &Value) -> std::io::Result<()> {
    connection.write_all(format!("event: {name}\ndata: {data}\n\n").as_bytes())
}

fn send(connection: &mut TcpStream, content_type: &str, body: &[u8]) -> std::io::Result<()> {
    let head = format!(
        "HTTP/1.1 200 OK\r\ncontent-type: {content_type}\r\ncontent-length: {}\r\n\
         content-security-policy: default-src 'self'\r\nx-content-type-options: nosniff\r\nconnection: close\r\n\r\n",
        body.len()
    );
    connection.write_all(head.as_bytes())?;
    connection.write_all(body)
}

fn content_type(name: &str) -> &'static str {
    match Path::new(name).extension().and_then(|end| end.to_str()) {
        Some("html") => "text/html; charset=utf-8",
        Some("js") => "text/javascript; charset=utf-8",
        Some("css") => "text/css; charset=utf-8",
        Some("svg") => "image/svg+xml",
        _ => "application/octet-stream",
    }
}
