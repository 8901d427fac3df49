//! The engine's thread with reports that wait for it, as after seconds in which more came than it could handle.

use std::net::{Ipv4Addr, SocketAddrV4};
use std::sync::mpsc::sync_channel;

use jiff::SignedDuration;
use tokio::sync::broadcast::error::RecvError;

use super::troubles::numbers_low;
use super::*;
use crate::areas::Masks;
use crate::config::Profile;
use crate::live::alerts::{Severity, Trouble};
use crate::live::{Hub, Level, SensorState, now};
use crate::simulate::{Scenario, simulate};
use crate::state::Frame;

/// A minute of a flight that waits whole, in the order in which it came; the last of it came this moment.
const WAITS_S: i64 = 60;

struct Waiting {
    engine: Engine,
    hub: Hub,
    arrivals: Receiver<Arrival>,
    /// Where further ones would come from.
    sender: SyncSender<Arrival>,
}

fn waiting() -> Waiting {
    let text = include_str!("../../../config/scenarios/crossing.toml")
        .replace("duration_s = 300", "duration_s = 60");
    let start = now() + SignedDuration::from_secs(-WAITS_S);
    let flight = simulate(&Scenario::parse(&text, "crossing.toml").unwrap(), 1, Some(start)).unwrap();
    let config = Arc::new(flight.config);
    let driver = Driver::new(&config, Masks::default(), start, 1);
    let (writer, hub) = Hub::new(config.clone(), Arc::new(driver.maker().clone()), start);
    let sinks = Sinks::open(&[]).unwrap();
    let encoders = Encoders::new(&config);
    let outlets = Outlets { hub: writer, sinks, encoders, recorder: None, keepers: None };
    let (sender, arrivals) = sync_channel(flight.datagrams.len());
    let from = SocketAddrV4::new(Ipv4Addr::LOCALHOST, 4711);
    for datagram in flight.datagrams.into_iter().filter(|datagram| datagram.received <= now()) {
        let (received, payload) = (datagram.received, datagram.payload);
        sender.try_send(Arrival { line: 0, received, from, payload }).unwrap();
    }
    let engine = Engine::new(config, driver, outlets, Vec::new(), Clock::default());
    Waiting { engine, hub, arrivals, sender }
}

#[test]
fn an_engine_that_is_behind_says_that_it_is_overloaded_and_blames_nobody_else() {
    let Waiting { mut engine, hub, arrivals, .. } = waiting();
    assert_eq!(hub.lateness(), None, "nothing has been published");
    // Until half of it has been handled, however fast this machine is.
    let half = now() + SignedDuration::from_secs(-WAITS_S / 2);
    let mut until = Time::default();
    while until < half {
        let arrival = arrivals.try_recv().unwrap();
        until = arrival.received;
        engine.receive(arrival);
    }
    engine.tell(until);

    let lateness = hub.lateness().unwrap();
    assert!(lateness.is_late() && lateness.late.as_secs() >= 20, "{lateness:?}");
    let condition = hub.condition();
    assert_eq!(condition.level(), Level::NotReady);
    let [picture] = condition.troubles() else { panic!("{condition:?}") };
    assert_eq!((&*picture.about, picture.severity), (Trouble::PICTURE, Severity::Critical));
    assert!(picture.text.starts_with("the engine is overloaded: the picture is "), "{}", picture.text);
    // What waits is not silence of the sensors, nor did a clock step back.
    let status = hub.status().unwrap();
    assert!(status.sensors.iter().all(|sensor| sensor.state == SensorState::Operational), "{status:?}");
    assert_eq!((status.troubles.len(), status.tally.clock_behind), (0, 0));

    // The rest: everything is handled before the clock publishes a slot, and nothing of it is refused as too old.
    let handled = (0..10_000).map(|_| engine.catch_up(&arrivals)).find(|handled| handled.is_all).unwrap();
    engine.tick(handled.until);
    engine.tell(handled.until);
    let status = hub.status().unwrap();
    assert_eq!((status.tally.clock_behind, status.tally.restarts), (0, 0));
    assert_eq!(status.tally.refused, BTreeMap::new());
}

/// It takes as long as there is between the making of a slot and its sending.
#[test]
fn a_checkpoint_waits_for_the_slot_that_is_made_to_be_sent() {
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
            Frame::Checkpoint { at, published, .. } => Some((at, published?)),
            _ => None,
        })
        .collect();
    // On stopping there is one at once.
    checkpoints.pop();
    let of_seen = checkpoints.iter().filter_map(|(at, made)| Some((at, published.get(made)?)));
    let early: Vec<_> = of_seen.clone().filter(|(at, sent)| at < sent).collect();
    assert!(of_seen.count() >= 5, "{checkpoints:?} {published:?}");
    assert!(early.is_empty(), "{early:?}");
}

#[test]
fn few_numbers_left_are_told_before_none_is() {
    let told = |used, profile| numbers_low(used, profile);
    assert_eq!(told(386_546, Profile::Operational), None);
    let text = told(386_547, Profile::Operational).unwrap();
    assert!(
        text.starts_with("386547 of 429496 transponder numbers are in use; when all are, a new"),
        "{text}"
    );
    assert!(told(429_496, Profile::Reference).unwrap().ends_with("new transponders are left out"));
}
