//! Tests that a service starts without the contents of damaged state files, and keeps its state from then on.

use std::fs;
use std::path::{Path, PathBuf};

use jiff::SignedDuration;

use super::*;
use fusion::numbering::NumberChange;
use input::capture::{Reception, ReceptionKind};
use lab::simulate::{Scenario, Simulation, simulate};
use service::live::DriverEvent;
use service::state::{CORRELATIONS, NUMBERS, REGISTRATION, SHELVED, WarmFrame, numbers_text, parse_numbers};
use site::areas::Masks;

use damage::{Random, damage};

#[path = "../../../crates/service/src/state/damage.rs"]
mod damage;

const WARM: &str = "engine.warm";
/// Number of datagrams after which tracks are published again.
const FLIGHT: usize = 600;

fn reception(simulation: &Simulation, index: usize) -> Reception {
    let datagram = &simulation.datagrams[index];
    Reception {
        received: Some(datagram.received),
        input: usize::from(datagram.payload[0] == 129),
        from: Some("127.0.0.1:40000".parse().unwrap()),
        kind: ReceptionKind::Datagram,
        origin: 0,
        payload: datagram.payload.clone(),
    }
}

/// A flight up to the end of the first service, and the state files of that service.
struct Before {
    simulation: Simulation,
    config: Arc<Config>,
    directory: PathBuf,
    /// Start of the next service, and index of the first datagram it receives.
    restart: Time,
    next: usize,
    files: Vec<(&'static str, Vec<u8>)>,
    given: Given,
}

impl Before {
    fn new() -> Self {
        let directory = std::env::temp_dir().join(format!("utm-fusion-state-{}", std::process::id()));
        let _ = fs::remove_dir_all(&directory);
        let text = include_str!("../../../config/scenarios/crossing.toml")
            .replace("duration_s = 300", "duration_s = 60");
        let start = Time::from_nanos(1_795_168_800_000_000_000);
        let simulation = simulate(&Scenario::parse(&text, "crossing.toml").unwrap(), 1, Some(start)).unwrap();
        let mut config = simulation.config.clone();
        config.state.dir.clone_from(&directory);
        config.state.history_hours = 0.0;
        let mut driver = Driver::new(&config, Masks::default(), start, 2);
        let next = simulation.datagrams.len() * 2 / 3;
        for index in 0..next {
            driver.receive(&reception(&simulation, index));
        }
        let restart = simulation.datagrams[next - 1].received + SignedDuration::from_secs(1);
        let given: Vec<Given> = driver.pipeline().engine().numbers().given().collect();
        let (radar, first) = (&config.sensors[0].id, given[0]);
        let heard_ns = restart.nanos() - 500_000_000;
        let serial = first.identity.name().escape_ascii().to_string();
        let slot = restart.nanos() / 250_000_000;
        let decisions = format!(
            "{{\"slot\":{slot},\"sensor\":\"{radar}\",\"track_number\":1,\"serial\":\"{serial}\",\"verdict\":\"correlated\",\"last_heard_ns\":{heard_ns}}}\n\
             {{\"slot\":{slot},\"serial\":\"{serial}\",\"verdict\":\"distrusted\"}}\n"
        );
        let shelved = "{\"alert\":\"area\",\"subject\":\"U-60000\",\"area\":\"Runway 27\",\"act\":\"shelved\",\"by\":\"tower\",\
             \"time\":\"2026-11-20T10:00:05.125Z\",\"until\":\"2026-11-20T10:35:05.125Z\",\"after_ns\":1795168798875000000}\n";
        let registrations = registration_text(&SavedRegistrations::of(&config, driver.pipeline().engine()));
        let (mut queue, keeper) = WarmKeeper::start(&directory, &StateHealth::default()).unwrap();
        let begun = queue.begin(WarmFrame::Checkpoint {
            at: restart,
            engine: driver.checkpoint(&config),
            encoders: Encoders::new(&config).checkpoint().into(),
            published: driver.published(),
        });
        assert!(begun);
        for index in next - 5..next {
            let Reception { received, from, payload, input, .. } = reception(&simulation, index);
            let (received, from) = (received.unwrap(), from.unwrap());
            queue.offer(|| WarmFrame::Input { received, line: input, from, payload });
        }
        drop(queue);
        keeper.join();
        let files = vec![
            (NUMBERS, numbers_text(&given).into_bytes()),
            (REGISTRATION, registrations.into_bytes()),
            (CORRELATIONS, decisions.into_bytes()),
            (SHELVED, shelved.as_bytes().to_vec()),
            (WARM, fs::read(directory.join(WARM)).unwrap()),
        ];
        Self { simulation, config: Arc::new(config), directory, restart, next, files, given: first }
    }

    /// Restores all files undamaged.
    fn put_back(&self) {
        for (name, octets) in &self.files {
            let path = self.directory.join(name);
            if path.is_dir() {
                fs::remove_dir_all(&path).unwrap();
            }
            fs::write(path, octets).unwrap();
        }
    }

    /// Starts a service and continues the flight. Returns what the service noted about the file `name`.
    async fn start(&self, name: &str, how: &str, datagrams: usize) -> (bool, bool) {
        let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
        let mut builder = LiveBuilder::new(self.config.clone(), Areas::default(), listener);
        builder.started = self.restart;
        builder.driver = Driver::new(&self.config, Masks::default(), self.restart, 2);
        let mut builder = builder.keep_state().unwrap_or_else(|error| panic!("{how}: {error}"));
        // A start without the engine's state publishes the first slot after its latency.
        let end = self.next + datagrams;
        let mut tracks = 0;
        for index in self.next..end.min(self.simulation.datagrams.len()) {
            builder.driver.receive(&reception(&self.simulation, index));
            while let Some(made) = builder.driver.poll() {
                if let DriverEvent::Slot(slot) = made {
                    tracks = tracks.max(slot.picture.tracks.len());
                }
            }
        }
        assert!(datagrams < FLIGHT || tracks > 3, "{how}: {tracks} tracks");
        let warm = builder.kept_by.take().unwrap();
        let queues = builder.keepers.take().unwrap();
        queues.numbers.send(NumberChange::Heard(self.given)).unwrap();
        queues.shelved.send("".into()).unwrap();
        drop(queues);
        warm.0.into_iter().for_each(StateKeeper::join);
        warm.1.into_iter().for_each(WarmKeeper::join);
        let text = fs::read(self.directory.join(NUMBERS)).unwrap_or_else(|error| panic!("{how}: {error}"));
        let text = String::from_utf8(text).unwrap();
        assert!(parse_numbers(&text).unwrap().contains(&self.given), "{how}");
        let health = builder.health.all();
        assert!(health.values().all(|file| file.failing.is_none()), "{how}: {health:?}");
        (health.contains_key(name), health.is_empty())
    }
}

fn asides(directory: &Path) -> usize {
    let names = fs::read_dir(directory).unwrap().map(|entry| entry.unwrap().file_name());
    names.filter(|name| name.to_str().unwrap().contains(".damaged-")).count()
}

async fn damaged(kinds: &[&str], count: usize, seed: u64) {
    let before = Before::new();
    before.put_back();
    assert_eq!(before.start(NUMBERS, "whole", FLIGHT).await, (false, true), "whole files are used");
    let mut random = Random::new(seed);
    for (name, octets) in before.files.iter().filter(|(name, _)| kinds.contains(name)) {
        let mut set_aside = 0;
        for number in 0..count {
            before.put_back();
            if *name != WARM {
                // Otherwise the engine's own state would be used instead of the other files.
                fs::remove_file(before.directory.join(WARM)).unwrap();
            }
            let how = damage(&before.directory.join(name), octets, &mut random);
            let how = format!("{name} {number}: {how}");
            set_aside +=
                usize::from(before.start(name, &how, if number % 25 == 0 { FLIGHT } else { 20 }).await.0);
        }
        assert!(set_aside * 4 > count, "{name}: {set_aside} of {count} were set aside");
    }
    assert!(asides(&before.directory) <= 3 * kinds.len(), "the damaged ones are bounded");
    fs::remove_dir_all(&before.directory).unwrap();
}

/// One test for all files, because the whole process shares the directory.
#[tokio::test]
async fn service_starts_with_any_damaged_state_file() {
    damaged(&[NUMBERS, REGISTRATION, CORRELATIONS, SHELVED, WARM], 200, 7).await;
}
