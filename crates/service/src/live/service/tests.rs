//! The engine's thread with waiting reports, as after seconds of overload.

use std::net::{Ipv4Addr, SocketAddrV4};
use std::sync::mpsc::sync_channel;

use jiff::SignedDuration;
use tokio::sync::broadcast::error::RecvError;

use super::troubles::numbers_low;
use super::*;
use crate::live::alerts::{ServiceFault, Severity};
use crate::live::{Hub, SensorState, ServiceLevel, now};
use crate::state::WarmFrame;
use lab::simulate::{Scenario, simulate};
use site::areas::Masks;
use site::config::Profile;

/// Length of the flight whose reports all wait, in seconds; the last was received just now.
const WAITS_S: i64 = 60;

struct Waiting {
    engine: EngineThread,
    hub: Hub,
    arrivals: Receiver<Arrival>,
    /// Source of further arrivals.
    sender: SyncSender<Arrival>,
}

fn waiting() -> Waiting {
    let text = include_str!("../../../../../config/scenarios/crossing.toml")
        .replace("duration_s = 300", "duration_s = 60");
    let start = now() + SignedDuration::from_secs(-WAITS_S);
    let flight = simulate(&Scenario::parse(&text, "crossing.toml").unwrap(), 1, Some(start)).unwrap();
    let config = Arc::new(flight.config);
    let driver = Driver::new(&config, Masks::default(), start, 1);
    let (writer, hub) = Hub::new(config.clone(), Arc::new(driver.maker().clone()), start);
    let sinks = UdpDestinations::open(&[]).unwrap();
    let encoders = Encoders::new(&config);
    let outlets = Outlets { hub: writer, sinks, encoders, recorder: None, keepers: None };
    let (sender, arrivals) = sync_channel(flight.datagrams.len());
    let from = SocketAddrV4::new(Ipv4Addr::LOCALHOST, 4711);
    for datagram in flight.datagrams.into_iter().filter(|datagram| datagram.received <= now()) {
        let (received, payload) = (datagram.received, datagram.payload);
        sender.try_send(Arrival { line: 0, received, from, payload }).unwrap();
    }
    let engine = EngineThread::new(config, driver, outlets, Vec::new(), WallClock::default());
    Waiting { engine, hub, arrivals, sender }
}

#[test]
fn delayed_engine_reports_overload_and_no_sensor_outage() {
    let Waiting { mut engine, hub, arrivals, .. } = waiting();
    assert_eq!(hub.lateness(), None, "nothing has been published");
    // Until half of it is handled, at any speed of this machine.
    let half = now() + SignedDuration::from_secs(-WAITS_S / 2);
    let mut until = Time::default();
    while until < half {
        let arrival = arrivals.try_recv().unwrap();
        until = arrival.received;
        engine.receive(arrival);
    }
    engine.publish_status(until);

    let lateness = hub.lateness().unwrap();
    assert!(lateness.is_late() && lateness.late.as_secs() >= 20, "{lateness:?}");
    let condition = hub.condition();
    assert_eq!(condition.level(), ServiceLevel::NotReady);
    let [picture] = condition.troubles() else { panic!("{condition:?}") };
    assert_eq!((&*picture.about, picture.severity), (ServiceFault::PICTURE, Severity::Critical));
    assert!(picture.text.starts_with("the engine is overloaded: the picture is "), "{}", picture.text);
    // Waiting reports count neither as silence of the sensors nor as a step of the clock.
    let status = hub.status().unwrap();
    assert!(status.sensors.iter().all(|sensor| sensor.state == SensorState::Operational), "{status:?}");
    assert_eq!((status.troubles.len(), status.tally.clock_behind), (0, 0));

    // The rest: everything is handled before the clock publishes a slot, and no report is rejected as too old.
    let handled = (0..10_000).map(|_| engine.catch_up(&arrivals)).find(|handled| handled.is_all).unwrap();
    engine.tick(handled.until);
    engine.publish_status(handled.until);
    let status = hub.status().unwrap();
    assert_eq!((status.tally.clock_behind, status.tally.restarts), (0, 0));
    assert_eq!(status.tally.refused, BTreeMap::new());
}

/// Writing a checkpoint can take as long as the time between making and sending a slot.
#[test]
fn checkpoint_follows_the_publication_of_a_made_slot() {
    let Waiting { mut engine, hub, arrivals, sender } = waiting();
    Arc::make_mut(&mut engine.config).state.checkpoint_s = 0.2;
    let (frames, kept) = sync_channel(1 << 16);
    let (numbers, _) = sync_channel(1);
    let texts = || sync_channel(1).0;
    engine.publisher.outlets.keepers = Some(KeeperQueues {
        numbers,
        registration: texts(),
        decisions: texts(),
        shelved: texts(),
        warm: Some(WarmQueue::to(frames)),
    });
    let mut pictures = hub.pictures();
    let mut published = BTreeMap::new();
    let stop = &AtomicBool::new(false);
    std::thread::scope(|scope| {
        scope.spawn(move || engine.run(&arrivals, stop));
        let end = now() + SignedDuration::from_secs(4);
        while now() < end {
            match pictures.blocking_recv() {
                Ok(frame) => _ = published.insert(frame.picture.time, frame.published_at),
                Err(RecvError::Lagged(_)) => {}
                Err(RecvError::Closed) => break,
            }
        }
        stop.store(true, Ordering::Relaxed);
    });
    drop(sender);
    let mut checkpoints: Vec<(Time, Time)> = kept
        .try_iter()
        .filter_map(|frame| match frame {
            WarmFrame::Checkpoint { at, published, .. } => Some((at, published?)),
            _ => None,
        })
        .collect();
    // Stopping writes one at once.
    checkpoints.pop();
    let of_seen = checkpoints.iter().filter_map(|(at, made)| Some((at, published.get(made)?)));
    let early: Vec<_> = of_seen.clone().filter(|(at, sent)| at < sent).collect();
    assert!(of_seen.count() >= 5, "{checkpoints:?} {published:?}");
    assert!(early.is_empty(), "{early:?}");
}

#[test]
fn low_number_supply_is_reported_before_it_ends() {
    let told = |used, profile| numbers_low(used, profile);
    assert_eq!(told(386_546, Profile::Operational), None);
    let text = told(386_547, Profile::Operational).unwrap();
    assert!(
        text.starts_with("386547 of 429496 transponder numbers are in use; when all are, a new"),
        "{text}"
    );
    assert!(told(429_496, Profile::Reference).unwrap().ends_with("new transponders are left out"));
}
