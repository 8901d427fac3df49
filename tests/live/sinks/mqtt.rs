//! Tracks at a broker of MQTT 5.

use std::collections::BTreeSet;

use serde_json::Value;

use super::{Site, flown, tracks, wait_for};
use crate::notices::broker::Broker;

const STATUS: &str = "north/tracks-status";

fn sink(broker: &Broker, retain: bool) -> String {
    let port = broker.port;
    format!(
        "[[output.mqtt]]\nid = \"city\"\nhost = \"127.0.0.1\"\nport = {port}\nprefix = \"north\"\nretain = {retain}\n"
    )
}

#[test]
fn each_track_is_a_message_and_its_end_an_empty_one() {
    let Some(broker) = Broker::start("") else { return };
    let mut listener = broker.listener().ready();
    let mut site = Site::open(&sink(&broker, false));
    assert_eq!(listener.next(), (STATUS.to_owned(), "online".to_owned(), false));
    let mut shown = BTreeSet::new();
    let mut sent = 0;
    for _ in 0..3 {
        let frame = site.publish();
        let mut current = BTreeSet::new();
        for track in tracks(frame) {
            let (topic, text, _) = listener.next();
            let id = flown().maker.track_id(track);
            assert_eq!(topic, format!("north/tracks/{id}"));
            let json: Value = serde_json::from_str(&text).unwrap();
            assert_eq!(json["id"], *id);
            assert!((json["lat"].as_f64().unwrap() - track.position.latitude_deg()).abs() < 1e-6, "{json}");
            current.insert(id);
            sent += 1;
        }
        for id in shown.difference(&current) {
            assert_eq!(listener.next(), (format!("north/tracks/{id}"), String::new(), false));
        }
        shown = current;
    }
    wait_for("it is counted", || site.counts("mqtt:city").sent == sent);
    site.close();
    for id in shown {
        assert_eq!(listener.next(), (format!("north/tracks/{id}"), String::new(), false));
    }
    assert_eq!(listener.next(), (STATUS.to_owned(), "offline".to_owned(), false));
}

#[test]
fn retained_tracks_match_the_picture_and_are_cleared() {
    let Some(broker) = Broker::start("") else { return };
    let mut site = Site::open(&sink(&broker, true));
    let frame = (0..3).map(|_| site.publish()).last().unwrap();
    let mut topics: Vec<String> =
        tracks(frame).iter().map(|track| format!("north/tracks/{}", flown().maker.track_id(track))).collect();
    topics.push(STATUS.to_owned());
    topics.sort_unstable();
    broker.comes_to_retain(&topics.iter().map(String::as_str).collect::<Vec<_>>());
    site.close();
    let retained: Vec<_> = broker.retained().into_iter().collect();
    assert_eq!(retained, [(STATUS.to_owned(), "offline".to_owned())]);
}

#[test]
fn seconds_lost_while_the_broker_is_gone_are_counted() {
    let Some(mut broker) = Broker::start("") else { return };
    let mut site = Site::open(&sink(&broker, false));
    site.publish();
    wait_for("the first second is sent", || site.counts("mqtt:city").sent > 0);
    broker.stop();
    wait_for("it fails", || site.counts("mqtt:city").is_failing);
    (0..3).for_each(|_| _ = site.publish());
    broker.start_again();
    wait_for("it works again", || !site.counts("mqtt:city").is_failing);
    let sent = site.counts("mqtt:city").sent;
    let frame = site.publish();
    wait_for("tracks are sent again", || site.counts("mqtt:city").sent >= sent + tracks(frame).len() as u64);
}
