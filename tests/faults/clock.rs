//! A clock that is set ahead or back under the running service, with its own threads and sockets in this process.

use std::net::SocketAddr;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

use jiff::SignedDuration;
use tokio::runtime::Runtime;
use utm_fusion::api::{ApiState, Options, serve};
use utm_fusion::areas::Masks;
use utm_fusion::formats::Encoders;
use utm_fusion::live::{
    AlertMonitor, AlertSettings, Driver, Followers, Hub, LiveService, Outlets, WallClock, now, observe,
};
use utm_fusion::net::listen as udp;
use utm_fusion::net::send::UdpDestinations;
use utm_fusion::record::{RecordedContents, Recorder};

use crate::common::read;
use crate::http::{get, json, lights, metric, troubled, until};
use crate::recorded::{is_exact, pairs};
use crate::stage::Stage;
use crate::{quick, scenario};

/// Duration of the part of the flight that is sent, in seconds.
const LAST_S: f64 = 16.0;

/// The service of a site, with a clock that can be stepped.
struct Live {
    service: LiveService,
    recorder: Recorder,
    clock: WallClock,
    address: SocketAddr,
    runtime: Runtime,
}

impl Live {
    /// Assembles the service like the command `run`.
    fn start(stage: &Stage) -> Self {
        let config = Arc::new(stage.config.clone());
        let runtime =
            tokio::runtime::Builder::new_multi_thread().worker_threads(2).enable_all().build().unwrap();
        let inside = runtime.enter();
        let driver = Driver::new(&config, Masks::default(), now(), udp::lines(&config).len());
        let record = config.output.record.as_ref().unwrap();
        let (queue, recorder) =
            Recorder::start(&config, record, Vec::new(), RecordedContents::Service).unwrap();
        let (writer, hub) = Hub::new(config.clone(), Arc::new(driver.maker().clone()), now());
        let sinks = UdpDestinations::open(&config.output.asterix).unwrap();
        let encoders = Encoders::new(&config);
        let outlets = Outlets { hub: writer, sinks, encoders, recorder: Some(queue), keepers: None };
        let clock = WallClock::default();
        let service = LiveService::start(config, driver, outlets, clock.clone(), runtime.handle()).unwrap();
        runtime.spawn(observe(
            hub.clone(),
            AlertMonitor::new(AlertSettings::default(), now()),
            Followers::default(),
        ));
        let api = ApiState::start(hub, Options::default()).unwrap();
        let listener = runtime.block_on(tokio::net::TcpListener::bind("127.0.0.1:0")).unwrap();
        let address = listener.local_addr().unwrap();
        runtime.spawn(serve(listener, api));
        drop(inside);
        Self { service, recorder, clock, address, runtime }
    }

    fn step(&self, seconds: i64) {
        self.clock.step(SignedDuration::from_secs(seconds));
    }

    fn seq(&self) -> u64 {
        json(self.address, "/api/v1/tracks")["seq"].as_u64().unwrap_or(0)
    }

    fn has_tracks(&self) -> bool {
        metric(self.address, "utm_fusion_tracks", "") > 0.0
    }

    /// Ends the service; all received datagrams must be in the recording.
    fn stop(self) {
        let driver = self.service.stop().unwrap();
        let counts = self.recorder.join();
        assert_eq!((counts.unwritten, counts.lost), (0, 0));
        assert!(driver.pipeline().tally().received > 50);
        self.runtime.shutdown_background();
    }
}

/// Number of datagrams sent.
fn sent(stage: &Stage) -> usize {
    let datagrams = stage.simulation.datagrams.iter();
    datagrams.filter(|datagram| datagram.received.seconds_since(stage.start()) <= LAST_S).count()
}

fn recordings(stage: &Stage) -> std::path::PathBuf {
    stage.scratch.path("recordings")
}

#[test]
fn clock_step_of_one_second_loses_nothing() {
    let stage = Stage::new(&scenario(20), 23_400, |config, _| quick(config));
    let (stop, listener) = stage.listen();
    let live = Live::start(&stage);
    std::thread::scope(|scope| {
        scope.spawn(|| stage.send(0.0, LAST_S));
        until("tracks", Duration::from_secs(12), || live.has_tracks());
        for step in [1, -1] {
            std::thread::sleep(Duration::from_secs(3));
            live.step(step);
            // One second back: the slots of that second have been published, and the next one waits for its time.
            let (seq, start) = (live.seq(), Instant::now());
            until("slots go on", Duration::from_secs(3), || live.seq() > seq + 4);
            assert!(step > 0 || start.elapsed() > Duration::from_millis(1500), "{:?}", start.elapsed());
            assert_eq!(lights(live.address), ["operational"; 2]);
        }
    });
    assert_eq!(get(live.address, "/readyz").0, 200);
    for name in
        ["utm_fusion_restarts_total", "utm_fusion_clock_behind_total", "utm_fusion_records_refused_total"]
    {
        assert_eq!(metric(live.address, name, ""), 0.0, "{name}");
    }
    live.stop();
    stop.store(true, Ordering::Relaxed);
    let heard = listener.join().unwrap();
    let pairs = pairs(&recordings(&stage));
    assert_eq!(pairs.len(), 1);
    assert_eq!(is_exact(&stage.config, &pairs[0], true), heard.len());
    assert_eq!(read(&pairs[0].0).0.len(), sent(&stage));
}

#[test]
fn clock_step_of_an_hour_ahead_restarts_the_engine() {
    let stage = Stage::new(&scenario(50), 23_500, |config, _| quick(config));
    let live = Live::start(&stage);
    std::thread::scope(|scope| {
        scope.spawn(|| stage.send(0.0, 48.0));
        until("tracks", Duration::from_secs(12), || live.has_tracks());
        std::thread::sleep(Duration::from_secs(3));
        let seq = live.seq();
        live.step(3600);
        until("slots of an hour later", Duration::from_secs(3), || {
            let time = json(live.address, "/api/v1/tracks")["time"].as_str().unwrap().to_owned();
            let time: jiff::Timestamp = time.parse().unwrap();
            time.as_second() > (now().nanos() / 1_000_000_000) + 3500
        });
        assert!(live.seq() < seq + 100, "an hour of slots was published");
        assert_eq!(metric(live.address, "utm_fusion_restarts_total", ""), 1.0);
        // The sensors' clocks are unchanged: their reports are an hour old, and the sensors are degraded.
        until("yellow lights", Duration::from_secs(9), || lights(live.address) == ["degraded"; 2]);
        assert!(metric(live.address, "utm_fusion_records_refused_total", "late") > 0.0);
        // The map is empty: the picture cannot be relied on.
        assert!(!live.has_tracks());
        assert_eq!(get(live.address, "/readyz").0, 503);
        assert_eq!(troubled(live.address), ["clock"]);
        let (_, why) = get(live.address, "/readyz");
        assert!(why.contains("the clock of this machine seems wrong"), "{why}");
        // The clock is right again, after a step of an hour back.
        live.step(-3600);
        let undone = Instant::now();
        until("tracks again", Duration::from_secs(25), || live.has_tracks());
        until("ready again", Duration::from_secs(5), || get(live.address, "/readyz").0 == 200);
        println!("tracks and ready {:.1} s after the clock was right", undone.elapsed().as_secs_f64());
        assert_eq!(metric(live.address, "utm_fusion_restarts_total", ""), 2.0);
        until("green lights", Duration::from_secs(5), || lights(live.address) == ["operational"; 2]);
        assert_eq!(troubled(live.address), [""; 0]);
    });
    live.stop();
    // Until the step, the recording equals the data sent.
    let pairs = pairs(&recordings(&stage));
    assert_eq!(pairs.len(), 2, "an hour later files of their own begin");
    assert!(is_exact(&stage.config, &pairs[0], false) > 5);
    is_exact(&stage.config, &pairs[1], false);
}

#[test]
fn clock_step_of_an_hour_back_is_reported() {
    let stage = Stage::new(&scenario(20), 23_600, |config, _| quick(config));
    let live = Live::start(&stage);
    std::thread::scope(|scope| {
        scope.spawn(|| stage.send(0.0, LAST_S));
        until("tracks", Duration::from_secs(12), || live.has_tracks());
        std::thread::sleep(Duration::from_secs(2));
        live.step(-3600);
        until("an alarm", Duration::from_secs(3), || troubled(live.address) == ["clock"]);
        assert_eq!(metric(live.address, "utm_fusion_clock_behind_total", ""), 1.0);
        let seq = live.seq();
        until("not ready", Duration::from_secs(9), || get(live.address, "/readyz").0 == 503);
        let (_, why) = get(live.address, "/readyz");
        assert!(
            why.contains("was set back") && !why.contains("the picture is"),
            "one fault, told once: {why}"
        );
        let status = json(live.address, "/api/v1/status")["reasons"].to_string();
        assert!(status.contains("was set back"), "{status}");
        assert_eq!(live.seq(), seq, "nothing is published twice");
        // The clock is set right.
        live.step(3600);
        until("slots go on", Duration::from_secs(5), || live.seq() > seq + 4);
        until("ready", Duration::from_secs(5), || get(live.address, "/readyz").0 == 200);
        until("no alarm", Duration::from_secs(5), || troubled(live.address).is_empty());
        until("tracks again", Duration::from_secs(9), || live.has_tracks());
        assert_eq!(metric(live.address, "utm_fusion_clock_behind_total", ""), 1.0, "one alarm a step");
    });
    live.stop();
    let pairs = pairs(&recordings(&stage));
    assert_eq!(pairs.len(), 1);
    assert!(is_exact(&stage.config, &pairs[0], true) > 20);
    assert_eq!(read(&pairs[0].0).0.len(), sent(&stage), "all that came is recorded");
}
