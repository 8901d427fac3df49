//! Shared by the tests: a simulated flight through the driver, and a service that publishes it slot by slot.

use std::net::{Ipv4Addr, SocketAddr};
use std::path::Path;
use std::sync::{Arc, OnceLock};
use std::time::Duration;

use axum::Router;
use axum::body::{Body, to_bytes};
use axum::http::{HeaderMap, Request, StatusCode};
use fusion::time::Time;
use serde_json::Value;
use tokio::net::{TcpListener, TcpStream};
use tower::ServiceExt;
use utm_fusion::api::{ApiState, Options, router, serve};
use utm_fusion::areas::Masks;
use utm_fusion::capture::{Reception, ReceptionKind};
use utm_fusion::config::{Camera, Config, Conflicts, PictureKind, Profile, Sensor, SensorKind};
use utm_fusion::conflicts::ConflictWatch;
use utm_fusion::live::{
    AlertMonitor, AlertSettings, Driver, DriverEvent, Followers, Hub, HubWriter, LineStatus,
    PublishedPicture, Status, observe,
};
use utm_fusion::normalise::Normaliser;
use utm_fusion::picture::PictureMaker;
use utm_fusion::simulate::{Scenario, SimulatedFlight, simulate};

pub(crate) struct Flown {
    pub(crate) config: Config,
    pub(crate) maker: PictureMaker,
    pub(crate) frames: Vec<PublishedPicture>,
    pub(crate) status: Status,
    /// True positions.
    pub(crate) truth: Vec<SimulatedFlight>,
}

/// A minute of the stored crossing in the `reference` profile, simulated once.
pub(crate) fn flown() -> &'static Flown {
    static FLOWN: OnceLock<Flown> = OnceLock::new();
    FLOWN.get_or_init(|| Flown::of(Profile::Reference))
}

/// A minute of the stored crossing in the `operational` profile, simulated once.
pub(crate) fn estimated() -> &'static Flown {
    static ESTIMATED: OnceLock<Flown> = OnceLock::new();
    ESTIMATED.get_or_init(|| Flown::of(Profile::Operational))
}

impl Flown {
    pub(crate) fn of(profile: Profile) -> Self {
        Self::with_driver(profile).0
    }

    /// The flight with the driver in its final state.
    pub(crate) fn with_driver(profile: Profile) -> (Self, Driver) {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("config/scenarios/crossing.toml");
        let text = std::fs::read_to_string(path).unwrap().replace("duration_s = 300", "duration_s = 60");
        Self::in_scenario(&text, |config| config.fusion.profile = profile)
    }

    /// A flight in this scenario, with a changed configuration.
    pub(crate) fn in_scenario(text: &str, change: impl FnOnce(&mut Config)) -> (Self, Driver) {
        let mut flight = simulate(&Scenario::parse(text, "a.toml").unwrap(), 1, None).unwrap();
        change(&mut flight.config);
        let start = flight.datagrams[0].received;
        let mut driver = Driver::new(&flight.config, Masks::default(), start, 1);
        let mut frames = Vec::new();
        let mut keep = |driver: &mut Driver| {
            while let Some(made) = driver.poll() {
                if let DriverEvent::Slot(frame) = made {
                    frames.push(frame);
                }
            }
        };
        for datagram in &flight.datagrams {
            driver.tick(datagram.received);
            keep(&mut driver);
            let reception = Reception {
                received: Some(driver.reception(datagram.received, datagram.received)),
                input: 0,
                from: None,
                kind: ReceptionKind::Datagram,
                origin: 0,
                payload: datagram.payload.clone(),
            };
            driver.receive(&reception);
            keep(&mut driver);
        }
        let at = flight.datagrams.last().unwrap().received;
        let line = || LineStatus { name: "a line".to_owned(), joined: true, ..LineStatus::default() };
        let status = Status {
            at,
            sensors: driver.sensors(at, |_| vec![line()]),
            unknown: driver.health().unknown(),
            tally: driver.pipeline().tally().clone(),
            numbers_used: 2,
            lateness_s: Some([0.001, 0.002, 0.003]),
            failed_sends: 0,
            troubles: Vec::new(),
        };
        let maker = driver.maker().clone();
        (Self { config: flight.config, maker, frames, status, truth: flight.flights }, driver)
    }
}

/// A service that shows the pictures published by a test.
pub(crate) struct Site {
    pub(crate) writer: HubWriter,
    pub(crate) state: ApiState,
    pub(crate) app: Router,
    flown: &'static Flown,
    watch: Option<ConflictWatch>,
    next: usize,
}

pub(crate) struct Answered {
    pub(crate) status: StatusCode,
    pub(crate) headers: HeaderMap,
    pub(crate) text: String,
}

impl Answered {
    pub(crate) fn json(&self) -> Value {
        serde_json::from_str(&self.text).unwrap_or_else(|error| panic!("{error}: {}", self.text))
    }

    pub(crate) fn header(&self, name: &str) -> &str {
        self.headers.get(name).map_or("", |value| value.to_str().unwrap())
    }
}

impl Site {
    pub(crate) fn plain() -> Self {
        Self::with(Options::default(), |_| {})
    }

    /// A service in the `operational` profile.
    pub(crate) fn operational() -> Self {
        Self::of(estimated(), Options::default(), |_| {})
    }

    /// A service with other options and a changed configuration.
    pub(crate) fn with(options: Options, change: impl FnOnce(&mut Config)) -> Self {
        Self::of(flown(), options, change)
    }

    /// A service that computes conflicts on `picture`.
    pub(crate) fn foreseeing(picture: PictureKind) -> Self {
        Self::of(estimated(), Options::default(), |config| {
            config.conflicts = Conflicts { enabled: true, picture, ..Conflicts::default() };
        })
    }

    /// A service that computes conflicts and has a camera at this latitude and longitude, degrees.
    pub(crate) fn with_camera([latitude_deg, longitude_deg]: [f64; 2]) -> Self {
        Self::of(estimated(), Options::default(), |config| {
            config.conflicts = Conflicts { enabled: true, picture: PictureKind::Now, ..Conflicts::default() };
            let camera = Camera { latitude_deg, longitude_deg, height_amsl_m: 60.0, ..Camera::default() };
            let like = config.sensors[0].clone();
            config.sensors.push(Sensor { id: "mast".to_owned(), kind: SensorKind::Camera(camera), ..like });
        })
    }

    fn of(flown: &'static Flown, options: Options, change: impl FnOnce(&mut Config)) -> Self {
        let mut config = flown.config.clone();
        change(&mut config);
        let watch = ConflictWatch::of(&config);
        // This configuration defines which aircraft are crewed.
        let maker = PictureMaker::new(&config, &Normaliser::new(&config, Masks::default()));
        let (writer, hub) = Hub::new(Arc::new(config), maker.into(), flown.frames[0].due);
        tokio::spawn(observe(
            hub.clone(),
            AlertMonitor::new(AlertSettings::default(), Time::default()),
            Followers::default(),
        ));
        let state = ApiState::start(hub, options).unwrap();
        // The first slots are empty; most tests want traffic.
        Self { writer, app: router(state.clone()), state, flown, watch, next: flown.frames.len() / 2 }
    }

    /// Publishes this number of slots and waits until they are shown.
    pub(crate) async fn publish(&mut self, slots: usize) {
        for _ in 0..slots {
            let frame = self.writer.publish(self.flown.frames[self.next].clone());
            let watch = self.watch.as_mut();
            if let Some(outlook) = watch.and_then(|watch| frame.conflicts(watch, &self.flown.maker)) {
                self.writer.conflict_reports.publish(outlook);
            }
            self.next += 1;
        }
        self.shown(self.flown.frames[self.next - 1].seq).await;
    }

    pub(crate) async fn shown(&self, seq: u64) {
        while self.get("/api/v1/tracks?limit=1").await.json()["seq"].as_u64() < Some(seq) {
            tokio::task::yield_now().await;
        }
    }

    /// Status of the service at the end of the flight.
    pub(crate) fn status(&self) -> Status {
        self.flown.status.clone()
    }

    pub(crate) async fn publish_status(&self, status: Status) {
        self.writer.publish_status(status);
        for _ in 0..100 {
            tokio::task::yield_now().await;
        }
    }

    pub(crate) async fn get(&self, path: &str) -> Answered {
        self.ask(Request::get(path)).await
    }

    pub(crate) async fn ask(&self, request: axum::http::request::Builder) -> Answered {
        let response = self.app.clone().oneshot(request.body(Body::empty()).unwrap()).await.unwrap();
        let (parts, body) = response.into_parts();
        let octets = to_bytes(body, 1 << 26).await.unwrap();
        Answered {
            status: parts.status,
            headers: parts.headers,
            text: String::from_utf8(octets.to_vec()).unwrap(),
        }
    }

    /// Listens on a socket on loopback.
    pub(crate) async fn listen(&self) -> SocketAddr {
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, 0)).await.unwrap();
        let address = listener.local_addr().unwrap();
        tokio::spawn(serve(listener, self.state.clone()));
        address
    }
}

/// An event of a stream.
#[derive(Clone, Debug)]
pub(crate) struct Event {
    pub(crate) id: String,
    pub(crate) name: String,
    pub(crate) data: Value,
}

/// A reader of a stream, over a socket.
pub(crate) struct Reader {
    socket: TcpStream,
    text: String,
    pub(crate) head: String,
}

impl Reader {
    pub(crate) async fn open(address: SocketAddr, path: &str, headers: &str) -> Self {
        let socket = TcpStream::connect(address).await.unwrap();
        let request = format!("GET {path} HTTP/1.1\r\nHost: localhost\r\n{headers}\r\n");
        send(&socket, request.as_bytes()).await;
        let mut reader = Self { socket, text: String::new(), head: String::new() };
        while !reader.text.contains("\r\n\r\n") {
            assert!(reader.more().await, "no answer: {}", reader.text);
        }
        let (head, rest) = reader.text.split_once("\r\n\r\n").unwrap();
        (reader.head, reader.text) = (head.to_owned(), rest.to_owned());
        reader
    }

    async fn more(&mut self) -> bool {
        let mut octets = [0; 1 << 16];
        let read = tokio::time::timeout(Duration::from_secs(60), receive(&self.socket, &mut octets));
        let count = read.await.expect("nothing comes for 20 s");
        self.text.push_str(&String::from_utf8_lossy(&octets[..count]));
        count > 0
    }

    /// The next event except heartbeats; `None` at the end.
    pub(crate) async fn next(&mut self) -> Option<Event> {
        loop {
            let event = self.any().await?;
            if event.name != "heartbeat" {
                return Some(event);
            }
        }
    }

    pub(crate) async fn any(&mut self) -> Option<Event> {
        loop {
            // Chunk sizes are on lines of their own, between events and within split ones.
            if let Some(end) = self.text.find("\n\n") {
                let event: String = self.text.drain(..end + 2).collect();
                let field = |name: &str| {
                    let start = event.find(&format!("{name}: ")).map(|at| at + name.len() + 2);
                    start.map_or("", |start| event[start..].lines().next().unwrap_or("")).to_owned()
                };
                let data =
                    serde_json::from_str(&field("data")).unwrap_or_else(|error| panic!("{error}: {event}"));
                return Some(Event { id: field("id"), name: field("event"), data });
            }
            if !self.more().await {
                return None;
            }
        }
    }
}

/// Sends a few octets.
pub(crate) async fn send(socket: &TcpStream, octets: &[u8]) {
    socket.writable().await.unwrap();
    assert_eq!(socket.try_write(octets).unwrap(), octets.len());
}

/// Number of octets received; 0 at the end, whether the connection was closed or reset.
pub(crate) async fn receive(socket: &TcpStream, octets: &mut [u8]) -> usize {
    loop {
        socket.readable().await.unwrap();
        match socket.try_read(octets) {
            Err(error) if error.kind() == std::io::ErrorKind::WouldBlock => {}
            read => return read.unwrap_or(0),
        }
    }
}
