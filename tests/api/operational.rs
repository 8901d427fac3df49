//! Properties of the `operational` profile: motion of each aircraft, its accuracy, and a stable identity.

use std::collections::{BTreeMap, BTreeSet};

use asterix::cat129::fusion_report::Flags;
use asterix::cat129::{FusionReport, Record};
use asterix::{DataSource, blocks};
use fusion::point::Basis;
use fusion::time::Time;
use serde_json::Value;
use utm_fusion::config::SerialSource;
use utm_fusion::formats::Cat129Encoder;
use utm_fusion::live::PublishedPicture;
use utm_fusion::simulate::TruthSample;

use crate::common::{Reader, Site, estimated, flown};

const NEW: [&str; 8] = [
    "speed",
    "track",
    "vertical_speed",
    "accuracy_h_m",
    "accuracy_v_m",
    "accuracy_h",
    "accuracy_v",
    "last_measurement",
];

fn number(value: &Value, key: &str) -> f64 {
    value[key].as_f64().unwrap_or_else(|| panic!("no {key}: {value}"))
}

fn time(value: &Value) -> Time {
    let stamp: jiff::Timestamp = value.as_str().unwrap().parse().unwrap();
    Time::from_nanos(stamp.as_nanosecond() as i64)
}

/// Properties of all tracks in this number of slots.
async fn properties(site: &mut Site, slots: usize) -> Vec<Value> {
    let mut all = Vec::new();
    for _ in 0..slots {
        site.publish(1).await;
        let picture = site.get("/api/v1/tracks").await.json();
        all.extend(picture["features"].as_array().unwrap().iter().map(|f| f["properties"].clone()));
    }
    all
}

/// The drone nearest to a track, and its horizontal distance in metres.
fn truth(properties: &Value) -> (&'static TruthSample, f64) {
    let (lat, lng, at) =
        (number(properties, "lat"), number(properties, "lng"), time(&properties["time"]).nanos());
    let metres = |sample: &TruthSample| {
        let north = (sample.latitude_deg - lat) * 111_200.0;
        let east = (sample.longitude_deg - lng) * 111_200.0 * lat.to_radians().cos();
        // From the sample, at most 50 ms away, to the time of the track.
        let dt = (at - sample.time.nanos()) as f64 * 1e-9;
        (north + sample.velocity_ned_m_s[0] * dt).hypot(east + sample.velocity_ned_m_s[1] * dt)
    };
    let sample = |flight: &'static utm_fusion::simulate::SimulatedFlight| {
        flight.samples.iter().min_by_key(|sample| (sample.time.nanos() - at).abs()).unwrap()
    };
    estimated()
        .truth
        .iter()
        .map(sample)
        .map(|sample| (sample, metres(sample)))
        .min_by(|a, b| a.1.total_cmp(&b.1))
        .unwrap()
}

#[tokio::test]
async fn speeds_and_directions_are_those_that_were_flown() {
    let all = properties(&mut Site::operational(), 60).await;
    let (mut speed, mut climb, mut turned) = (Vec::new(), Vec::new(), Vec::new());
    for track in &all {
        let (sample, metres) = truth(track);
        let [north, east, down] = sample.velocity_ned_m_s;
        // Skips radar-only tracks, which may belong to any drone, and wrong matches.
        if track.get("uas_id").is_none() || metres > 30.0 {
            continue;
        }
        speed.push((number(track, "speed") - north.hypot(east)).abs());
        climb.push((number(track, "vertical_speed") + down).abs());
        if let Some(direction) = track["track"].as_f64() {
            let apart = (direction - east.atan2(north).to_degrees() + 540.0).rem_euclid(360.0) - 180.0;
            turned.push(apart.abs());
        }
    }
    let mean = |errors: &[f64]| errors.iter().sum::<f64>() / errors.len() as f64;
    assert!(speed.len() > 300 && turned.len() * 2 > speed.len());
    assert!(mean(&speed) < 1.0 && mean(&climb) < 1.0 && mean(&turned) < 15.0);
}

#[tokio::test]
async fn the_circle_of_the_accuracy_holds_95_of_100_places() {
    let all = properties(&mut Site::operational(), 60).await;
    let known = all.iter().filter(|track| track.get("uas_id").is_some());
    let mut shares: Vec<f64> = known.map(|track| truth(track).1 / number(track, "accuracy_h_m")).collect();
    shares.sort_by(f64::total_cmp);
    // Errors are correlated in time, so there are fewer independent ones than positions.
    let held = shares.partition_point(|&share| share <= 1.0) as f64 / shares.len() as f64;
    assert!(held >= 0.88, "{held}");
    // The radius is not too large either: half of the positions are within 0.48 of it.
    let half = shares[shares.len() / 2];
    assert!((0.25..0.75).contains(&half), "{half}");
}

#[tokio::test]
async fn track_has_exactly_the_known_properties() {
    let all = properties(&mut Site::operational(), 60).await;
    let (mut bases, mut states) = (BTreeSet::new(), BTreeSet::new());
    for track in &all {
        assert!(track["id"].as_str().unwrap().starts_with("U-"), "{track}");
        assert!((0.0..60.0).contains(&number(track, "speed")), "{track}");
        assert!((0.05..120.0).contains(&number(track, "accuracy_h_m")), "{track}");
        assert!(track["accuracy_h"].as_str().unwrap().starts_with("HA"));
        // Vertical properties are present only with a height.
        for key in ["vertical_speed", "accuracy_v_m", "accuracy_v"] {
            assert_eq!(track.get(key).is_some(), track.get("alt_msl").is_some(), "{key}: {track}");
        }
        assert!(number(track, "speed") >= 0.5 || track.get("track").is_none(), "{track}");
        assert!(
            time(&track["last_measurement"]) <= Time::from_nanos(time(&track["time"]).nanos() + 125_000_000)
        );
        let (interpolated, extrapolated) = (&track["interpolated"] == true, &track["extrapolated"] == true);
        assert!(!(interpolated && extrapolated), "{track}");
        assert_eq!(track["state"], if extrapolated { "coasting" } else { "active" });
        bases.insert((interpolated, extrapolated));
        states.insert(track["source"].as_str().unwrap());
        for part in track["contributors"].as_array().unwrap() {
            assert!(part["time"].is_string(), "{part}");
        }
        if track.get("uas_id").is_some() {
            assert!(track["alt_msl"].is_f64(), "a transponder tells its height: {track}");
        }
    }
    assert!(bases.len() >= 2 && states.len() >= 2, "{bases:?} {states:?}");

    for track in properties(&mut Site::plain(), 20).await {
        for key in NEW {
            assert!(track.get(key).is_none(), "{key} in the reference profile: {track}");
        }
        assert_eq!((&track["state"], &track["extrapolated"]), (&"active".into(), &false.into()));
        for part in track["contributors"].as_array().unwrap() {
            assert_eq!(part.get("time").is_some(), part["kind"] == "radar", "{part}");
        }
    }
}

#[tokio::test]
async fn aircraft_is_one_track_with_one_trail() {
    let mut site = Site::operational();
    let all = properties(&mut site, 100).await;
    let mut ids: BTreeMap<&str, BTreeSet<&str>> = BTreeMap::new();
    let mut sources: BTreeMap<&str, BTreeSet<&str>> = BTreeMap::new();
    for track in &all {
        let id = track["id"].as_str().unwrap();
        sources.entry(id).or_default().insert(track["source"].as_str().unwrap());
        if let Some(serial) = track["uas_id"]["serial_number"].as_str() {
            ids.entry(serial).or_default().insert(id);
        }
    }
    assert!(ids.len() >= 3 && ids.values().all(|ids| ids.len() == 1), "{ids:?}");
    // The track with the most slots, because others disappear for a while.
    let slots = |id: &str| all.iter().filter(|track| track["id"] == id).count();
    let changed = sources.iter().filter(|(_, sources)| sources.len() > 1).max_by_key(|(id, _)| slots(id));
    let (id, _) = changed.unwrap_or_else(|| panic!("no source changes: {sources:?}"));
    let picture = site.get(&format!("/api/v1/tracks?ids={id}&trail_s=24")).await.json();
    let features = picture["features"].as_array().unwrap();
    assert_eq!((features.len(), &features[0]["id"]), (1, &(*id).into()));
    let times = features[0]["properties"]["trail"]["times"].as_array().unwrap();
    assert!(times.len() >= 20, "{} places of 24 s", times.len());

    // The stream filtered to this aircraft.
    let address = site.listen().await;
    let mut reader = Reader::open(address, &format!("/api/v1/stream?ids={id}"), "").await;
    assert_eq!(reader.next().await.unwrap().data["numberReturned"], 1);
    site.publish(1).await;
    let event = reader.next().await.unwrap();
    assert_eq!((event.name.as_str(), &event.data["features"][0]["id"]), ("tracks", &(*id).into()));
}

#[tokio::test]
async fn display_data_has_velocity_and_accuracy() {
    let mut site = Site::operational();
    site.publish(20).await;
    let tracks = site.get("/api/v1/tracks").await.json();
    let known =
        |t: &&Value| t["properties"].get("uas_id").is_some() && t["properties"].get("track").is_some();
    let track = &tracks["features"].as_array().unwrap().iter().find(known).unwrap()["properties"];
    let (lat, lng) = (number(track, "lat"), number(track, "lng"));
    let view = format!("/uss/flights?view={},{},{},{}", lat - 0.01, lng - 0.01, lat + 0.01, lng + 0.01);
    let flights = site.get(&view).await.json();
    let flight = flights["flights"].as_array().unwrap().iter().find(|f| f["id"] == track["id"]).unwrap();
    let state = &flight["current_state"];
    for key in ["speed", "track", "vertical_speed"] {
        assert_eq!(state[key], track[key], "{key}");
    }
    for key in ["accuracy_h", "accuracy_v", "extrapolated"] {
        assert_eq!(state["position"][key], track[key], "{key}");
    }
    let speed_accuracy = state["speed_accuracy"].as_str().unwrap();
    assert!(["SA03mps", "SA1mps", "SA3mps", "SA10mps"].contains(&speed_accuracy), "{speed_accuracy}");
    assert_eq!(state["timestamp"]["value"], track["time"]);

    let aircraft = site.get("/data/aircraft.json").await.json();
    let serial = &track["uas_id"]["serial_number"];
    let craft =
        aircraft["aircraft"].as_array().unwrap().iter().find(|craft| craft["flight"] == *serial).unwrap();
    assert!((number(craft, "gs") * 1852.0 / 3600.0 - number(track, "speed")).abs() < 0.04);
    assert!((number(craft, "track") - number(track, "track")).abs() < 0.06);
    assert!((number(craft, "geom_rate") * 0.3048 / 60.0 - number(track, "vertical_speed")).abs() < 0.01);
    // NACp: 95 % within 3, 10, 30 m.
    let nac_p = [(3.0, 11), (10.0, 10), (30.0, 9), (92.6, 8), (185.2, 7)];
    let expected = nac_p.iter().find(|(metres, _)| number(track, "accuracy_h_m") < *metres).unwrap().1;
    assert_eq!(craft["nac_p"], expected);
    assert!((1..=4).contains(&craft["nac_v"].as_u64().unwrap()) && craft["gva"].as_u64().unwrap() <= 2);

    // All tracks classified as drones have the drone icon, and no others.
    let drones = site.get("/api/v1/tracks?class=drone").await.json()["numberMatched"].as_u64();
    let crafts = aircraft["aircraft"].as_array().unwrap();
    assert_eq!(drones, Some(crafts.iter().filter(|craft| craft["category"] == "B6").count() as u64));
    assert!(
        crafts.iter().filter(|craft| craft["category"] != "B6").all(|craft| craft.get("category").is_none())
    );
    // tar1090 chooses the icon by the type designator first; a drone gets rotors.
    assert!(crafts.iter().all(|craft| (craft["category"] == "B6") == (craft["t"] == "UHEL")));

    let mut reference = Site::plain();
    reference.publish(1).await;
    let aircraft = reference.get("/data/aircraft.json").await.json();
    for key in ["gs", "track", "geom_rate", "nac_p", "nac_v", "gva"] {
        assert!(
            aircraft["aircraft"].as_array().unwrap().iter().all(|craft| craft.get(key).is_none()),
            "{key}"
        );
    }
}

#[test]
fn cat129_output_matches_the_api() {
    let encoder = Cat129Encoder { source: DataSource { sac: 1, sic: 2 }, serial: SerialSource::Uas };
    let read = |octets: &[u8]| {
        let block = blocks(octets).next().unwrap().unwrap();
        let record: Record = block.records().next().unwrap().unwrap().record;
        let report = FusionReport::read(record.special_purpose.as_ref().unwrap()).unwrap();
        (record, report)
    };
    let mut flags = BTreeSet::new();
    for track in estimated().frames.iter().flat_map(|frame| &frame.picture.tracks) {
        let mut octets = Vec::new();
        assert!(encoder.encode(track, &mut octets));
        let (record, report) = read(&octets);
        let motion = track.motion.unwrap();
        let estimate = track.point.estimate.unwrap();
        let half_m = record.gnss_accuracy.unwrap().metres().unwrap();
        assert!(half_m >= motion.half_h_m && half_m < motion.half_h_m + 1.0, "{half_m}: {motion:?}");
        assert!(motion.half_h_m < motion.accuracy_h_m);
        let velocity = record.horizontal_velocity.unwrap();
        assert!((velocity.east_m_s() - motion.velocity.x).abs() <= 0.005_001);
        assert!((velocity.north_m_s() - motion.velocity.y).abs() <= 0.005_001);
        let sigma_m = (estimate.horizontal.trace() / 2.0).sqrt();
        assert!((report.horizontal_deviation.metres().unwrap() - sigma_m).abs() <= 0.050_001);
        match track.altitude_amsl_m {
            Some(_) => {
                let up = record.vertical_velocity.unwrap().up_m_s();
                assert!((up - motion.velocity.z).abs() <= 0.005_001);
                let vertical_m = report.vertical_deviation.metres().unwrap();
                assert!((vertical_m - estimate.vertical_m2.sqrt()).abs() <= 0.050_001);
            }
            None => {
                let unknown = (record.vertical_velocity, report.vertical_deviation.metres());
                assert_eq!(unknown, (None, None));
            }
        }
        assert_eq!(report.flags.contains(Flags::INTERPOLATED), estimate.basis == Basis::Interpolated);
        assert_eq!(report.flags.contains(Flags::EXTRAPOLATED), estimate.basis == Basis::Extrapolated);
        flags.insert(report.flags.0);
    }
    assert!(flags.len() >= 2, "{flags:?}");
    for track in flown().frames.iter().flat_map(|frame| &frame.picture.tracks) {
        let mut octets = Vec::new();
        assert!(encoder.encode(track, &mut octets));
        let (record, report) = read(&octets);
        assert!(record.gnss_accuracy.is_none() && record.horizontal_velocity.is_none());
        assert!(record.vertical_velocity.is_none());
        assert_eq!((report.horizontal_deviation.metres(), report.vertical_deviation.metres()), (None, None));
    }
}

/// A slot whose first two tracks have this accuracy. The first is extrapolated, the second measured.
fn poor_slot(accuracy_h_m: f64) -> (PublishedPicture, [String; 2]) {
    let mut frame = estimated().frames[estimated().frames.len() / 2].clone();
    assert!(frame.picture.tracks.len() > 2);
    let ids = [0, 1].map(|index| estimated().maker.track_id(&frame.picture.tracks[index]));
    for (track, basis) in frame.picture.tracks.iter_mut().zip([Basis::Extrapolated, Basis::Measured]) {
        let motion = track.motion.as_mut().unwrap();
        (motion.basis, motion.accuracy_h_m) = (basis, accuracy_h_m);
    }
    (frame, ids)
}

fn ids(collection: &Value) -> Vec<String> {
    let id = |feature: &Value| feature["id"].as_str().unwrap().to_owned();
    collection["features"].as_array().unwrap().iter().map(id).collect()
}

#[tokio::test]
async fn max_accuracy_selects_tracks() {
    let site = Site::operational();
    let (frame, [unseen, measured]) = poor_slot(150.0);
    let all: Vec<String> =
        frame.picture.tracks.iter().map(|track| estimated().maker.track_id(track)).collect();
    let seq = frame.seq;
    site.writer.publish(frame);
    site.shown(seq).await;
    for (query, is_there) in [
        ("", false),
        ("?max_accuracy_m=149.9", false),
        ("?max_accuracy_m=150", true),
        ("?max_accuracy_m=250", true),
        ("?max_accuracy_m=250&include=competitors", true),
        ("?include=competitors", false),
        ("?trail_s=10", false),
        ("?limit=10000", false),
        ("?max_accuracy_m=1", false),
    ] {
        let picture = site.get(&format!("/api/v1/tracks{query}")).await.json();
        let ids = ids(&picture);
        assert_eq!(ids.contains(&unseen), is_there, "{query}");
        assert!(ids.contains(&measured), "{query}");
        assert_eq!(picture["numberMatched"], ids.len(), "{query}");
        if query != "?max_accuracy_m=1" {
            assert_eq!(ids.len(), all.len() - usize::from(!is_there), "{query}: the others are there");
        }
    }
    let one = site.get(&format!("/api/v1/tracks/{unseen}")).await;
    assert_eq!(one.json()["id"], unseen.as_str(), "who asks for it by name gets it");
    let aircraft = site.get("/data/aircraft.json").await.json();
    assert_eq!(aircraft["aircraft"].as_array().unwrap().len(), all.len() - 1);
}

#[tokio::test]
async fn track_beyond_max_accuracy_ends_for_its_reader() {
    let site = Site::operational();
    let address = site.listen().await;
    let (mut frame, [id, _]) = poor_slot(90.0);
    site.writer.publish(frame.clone());
    site.shown(frame.seq).await;
    let mut usual = Reader::open(address, "/api/v1/stream", "").await;
    let mut patient = Reader::open(address, "/api/v1/stream?max_accuracy_m=250", "").await;
    for reader in [&mut usual, &mut patient] {
        assert!(ids(&reader.next().await.unwrap().data).contains(&id));
    }
    let later = |time: &mut Time| *time = *time + jiff::SignedDuration::from_millis(250);
    for slot in 1..=8 {
        frame.seq += 1;
        let picture = &mut frame.picture;
        picture.tracks[0].motion.as_mut().unwrap().accuracy_h_m = 150.0;
        [&mut frame.due, &mut frame.published_at, &mut picture.time].into_iter().for_each(later);
        picture.tracks.iter_mut().for_each(|track| later(&mut track.time));
        site.writer.publish(frame.clone());
        for (reader, is_there) in [(&mut usual, false), (&mut patient, true)] {
            let event = reader.next().await.unwrap();
            assert_eq!((&*event.name, ids(&event.data).contains(&id)), ("tracks", is_there), "slot {slot}");
        }
    }
    let event = usual.next().await.unwrap();
    assert_eq!((&*event.name, &event.data["ids"]), ("ended", &serde_json::json!([id])));
}
