//! The picture in other formats, through the program's own sockets.

mod cot;
mod f3623;
mod hostile;
mod mqtt;
mod run;

use std::fs;
use std::path::Path;
use std::sync::{Arc, OnceLock};
use std::time::{Duration, Instant};

use fusion::time::Time;
use utm_fusion::areas::Masks;
use utm_fusion::capture::{Reception, ReceptionKind};
use utm_fusion::config::Config;
use utm_fusion::live::{Driver, DriverEvent, Hub, HubWriter, Outgoing, PublishedPicture};
use utm_fusion::picture::{PictureMaker, PictureTrack};
use utm_fusion::sinks::{PictureSinks, SinkCounts, SinkLoss, SinkMeter};

use crate::common::flight;

/// Timeout of all waits in these tests.
const PATIENCE: Duration = Duration::from_secs(60);

struct Flown {
    config: Config,
    maker: PictureMaker,
    /// Pictures that begin a second and show aircraft.
    frames: Vec<PublishedPicture>,
    /// One whose present picture begins a second and shows aircraft.
    of_now: PublishedPicture,
}

/// A minute of the crossing scenario through the driver, simulated once, with present pictures.
fn flown() -> &'static Flown {
    static FLOWN: OnceLock<Flown> = OnceLock::new();
    FLOWN.get_or_init(|| {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("config/scenarios/crossing.toml");
        let text = fs::read_to_string(path).unwrap().replace("duration_s = 300", "duration_s = 60");
        let mut flight = flight(&text, 1, None);
        flight.config.fusion.now = true;
        let mut driver = Driver::new(&flight.config, Masks::default(), flight.datagrams[0].received, 1);
        let mut frames = Vec::new();
        let keep = |driver: &mut Driver, frames: &mut Vec<PublishedPicture>| {
            while let Some(made) = driver.poll() {
                if let DriverEvent::Slot(frame) = made {
                    frames.push(frame);
                }
            }
        };
        for datagram in &flight.datagrams {
            driver.tick(datagram.received);
            keep(&mut driver, &mut frames);
            driver.receive(&Reception {
                received: Some(driver.reception(datagram.received, datagram.received)),
                input: 0,
                from: None,
                kind: ReceptionKind::Datagram,
                origin: 0,
                payload: datagram.payload.clone(),
            });
            keep(&mut driver, &mut frames);
        }
        let maker = driver.maker().clone();
        let shows_now = |frame: &&PublishedPicture| {
            frame.now.get().is_some_and(|now| maker.begins_second(now.slot) && !now.tracks.is_empty())
        };
        let of_now = frames.iter().rfind(shows_now).unwrap().clone();
        frames.retain(|frame| maker.begins_second(frame.picture.slot) && !frame.picture.tracks.is_empty());
        assert!(frames.len() > 10, "{}", frames.len());
        Flown { config: flight.config, maker, frames, of_now }
    })
}

/// A service of which only the sinks run.
struct Site {
    runtime: tokio::runtime::Runtime,
    meter: SinkMeter,
    deliveries: Option<utm_fusion::notices::Deliveries>,
    writer: HubWriter,
    _hub: Hub,
    next: usize,
}

impl Site {
    /// Opens a service with these sinks in `[output]`.
    fn open(output: &str) -> Self {
        let config = configured(output);
        let runtime = utm_fusion::app::runtime(2).unwrap();
        let sinks = PictureSinks::open(&config).unwrap();
        let (writer, hub) = Hub::new(Arc::new(config), Arc::new(flown().maker.clone()), Time::default());
        let (meter, deliveries) = runtime.block_on(async { sinks.start(hub.clone()) });
        // The follower has to subscribe before the first slot.
        std::thread::sleep(Duration::from_millis(100));
        Self { runtime, meter, deliveries: Some(deliveries), writer, _hub: hub, next: 0 }
    }

    /// Publishes the next second.
    fn publish(&mut self) -> &'static PublishedPicture {
        let frame = &flown().frames[self.next];
        self.next += 1;
        self.writer.publish(frame.clone());
        frame
    }

    fn counts(&self, sink: &str) -> SinkCounts {
        self.meter.counts().find(|(name, _)| *name == sink).unwrap().1
    }

    fn lost(&self, sink: &str, loss: SinkLoss) -> u64 {
        self.counts(sink).lost(loss)
    }

    fn troubles(&self) -> Vec<String> {
        self.meter.troubles().into_iter().map(|trouble| trouble.text).collect()
    }

    /// Ends like the service.
    fn close(&mut self) {
        let deliveries = self.deliveries.take().unwrap();
        self.runtime.block_on(deliveries.close());
    }
}

/// Site of the flight with these sinks.
fn configured(output: &str) -> Config {
    let site = "[site]\nname = \"north\"\nsac = 25\nsic = 1\n\n[[sensors]]\nid = \"radar\"\nkind = \"radar\"\n\
                sac = 25\nsic = 200\nlatitude_deg = 52.0\nlongitude_deg = -0.5\nheight_amsl_m = 90.0\n";
    let text = format!("{site}\n[fusion]\nnow = true\n\n{output}");
    let parsed = Config::parse(&text, "/site.toml", std::iter::empty());
    let mut config = flown().config.clone();
    config.output = parsed.unwrap_or_else(|errors| panic!("{errors}")).output;
    config
}

/// Tracks of this slot for a reader.
fn tracks(frame: &PublishedPicture) -> Vec<&PictureTrack> {
    frame.picture.within(100.0).collect()
}

/// Waits until a condition is met.
fn wait_for(what: &str, mut is_so: impl FnMut() -> bool) {
    let until = Instant::now() + PATIENCE;
    while !is_so() {
        assert!(Instant::now() < until, "{what}");
        std::thread::sleep(Duration::from_millis(20));
    }
}
