//! Beast: a minute of a real receiver, compared with an independent decoder (dump1090), through the program.

use std::collections::BTreeMap;

use serde_json::Value;

use super::{decode, run, shared, unzip};

/// Positions by address and time, with altitude and place.
type Positions = BTreeMap<(String, i64), (Option<f64>, [f64; 2])>;

/// Fields of the BaseStation lines of this type.
fn lines<'a>(text: &'a str, kind: &'a str) -> impl Iterator<Item = Vec<&'a str>> {
    text.lines()
        .map(|line| line.split(',').collect::<Vec<_>>())
        .filter(move |fields| fields.starts_with(&["MSG", kind]))
}

/// Milliseconds of the day of such a line. Their clock began 136 ms after the second in the file's name.
fn ms(fields: &[&str]) -> i64 {
    let clock: Vec<f64> = fields[7].split(':').map(|part| part.parse().unwrap()).collect();
    ((clock[0] * 60.0 + clock[1]) * 60_000.0 + clock[2] * 1000.0).round() as i64 - 136
}

fn number(text: &str) -> Option<f64> {
    (!text.is_empty()).then(|| text.parse().unwrap())
}

/// Entry of an aircraft at most 8 ms (1/128 s) away.
fn at<T>(of: &BTreeMap<(String, i64), T>, address: &str, ms: i64) -> Option<T>
where
    T: Clone,
{
    of.range((address.to_owned(), ms - 8)..=(address.to_owned(), ms + 8))
        .next()
        .map(|(_, found)| found.clone())
}

#[test]
fn recorded_positions_match_an_independent_decoder() {
    let Some(folder) = shared::recordings().map(|data| data.join("adsb-beast")) else { return };
    let capture = folder.join("ulss7-20180403T190228Z.beast");
    let text = unzip(&folder.join("decoded_sbs.txt.gz"));
    let theirs: Positions = lines(&text, "3")
        .filter_map(|of| {
            let place = [number(of[14])?, number(of[15])?];
            Some(((of[4].to_owned(), ms(&of)), (number(of[11]), place)))
        })
        .collect();
    let moving: BTreeMap<(String, i64), [f64; 3]> = lines(&text, "4")
        .map(|of| ((of[4].to_owned(), ms(&of)), [12, 13, 16].map(|place| number(of[place]).unwrap())))
        .collect();
    let records = decode(&capture);
    let (mut velocities, mut worst) = (0, 0.0_f64);
    for record in &records {
        let items = &record["items"];
        let address = items["080"].as_str().unwrap();
        let time = |item: &str| items[item].as_f64().map(|seconds| (seconds * 1000.0).round() as i64);
        let (feet, place) = at(&theirs, address, time("073").unwrap()).unwrap_or_else(|| panic!("{record}"));
        let level = items["145"]["flight_level"].as_f64().or(items["145"].as_f64());
        assert_eq!(level.map(|level| level * 100.0), feet, "{record}");
        for (axis, theirs) in ["latitude_deg", "longitude_deg"].into_iter().zip(place) {
            worst = worst.max((items["131"][axis].as_f64().unwrap() - theirs).abs());
        }
        // The reference has five decimals.
        assert!(worst < 5.1e-6, "{record}");
        if let Some(vector) = items["160"].as_object() {
            let [knots, track, rate] =
                at(&moving, address, time("075").unwrap()).unwrap_or_else(|| panic!("{record}"));
            let ours = |name: &str, unit: f64| vector[name].as_f64().unwrap() / unit;
            // The reference truncates to whole knots; its directions are up to 1.5 degrees off those of the velocity's own
            // bits.
            assert!((ours("speed_m_s", 1852.0 / 3600.0) - knots - 0.5).abs() < 0.75, "{record}");
            assert!(
                ((ours("track_deg", 1.0) - track + 180.0).rem_euclid(360.0) - 180.0).abs() < 1.6,
                "{record}"
            );
            let climb = ["155", "157"].iter().find_map(|item| items[*item]["rate_m_s"].as_f64()).unwrap();
            assert!((climb * 60.0 / 0.3048 - rate).abs() < 4.5, "{record}");
            velocities += 1;
        }
    }
    assert_eq!((records.len(), theirs.len(), velocities), (728, 728, 727));
    println!("{} positions, {velocities} with velocity; farthest apart {worst:.2e} degrees", records.len());
    let times: Vec<&Value> = records.iter().map(|record| &record["time"]).collect();
    assert!(times[0].as_str().unwrap().starts_with("2018-04-03T19:02:28"), "the day of the file's name");
    let (info, _) = run(&["info", capture.to_str().unwrap()]);
    assert!(info.contains("5,259 without ADS-B") || info.contains("5259 without ADS-B"), "{info}");
}

#[test]
fn damaged_capture_is_recognised_and_loses_only_damage() {
    let frame = |stamp: u8, octet: u8| [&[0x1a, b'3', 0, 0, 0, 0, 0, stamp, 0x80][..], &[octet; 14]].concat();
    let frames = |from: u8| -> Vec<u8> { (from..from + 19).flat_map(|stamp| frame(stamp, 0x11)).collect() };
    let sound = frames(30);
    let folder = std::env::temp_dir().join(format!("gateways-beast-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let path = folder.join("stream");
    let info = |octets: &[u8]| {
        std::fs::write(&path, octets).unwrap();
        run(&["info", path.to_str().unwrap()]).0
    };
    let text = info(&sound);
    assert!(text.contains("Beast (1090 MHz)") && text.contains("19 without ADS-B"), "{text}");
    // Octets outside of frames, a frame of an unknown kind, a cut frame, and another at the end.
    let damaged =
        [&sound, &b"garbage"[..], &[0x1a, b'9'], &frame(50, 0x11)[..9], &frames(60), &frame(90, 0x11)[..15]]
            .concat();
    let text = info(&damaged);
    assert!(text.contains("38 without ADS-B"), "{text}");
    assert!(text.contains("1 malformed") && text.contains("2 cut short"), "{text}");
    assert!(text.contains("skipped"), "{text}");
    std::fs::remove_dir_all(folder).unwrap();
}
