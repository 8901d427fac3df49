//! A real flight's log as broadcasts of its drone: each position becomes a report with the place and time of the log.

use std::fs;

use fusion::Report;
use fusion::time::{SECOND, Time};
use remote_id::{BasicId, IdType, Location, LocationContent, Message, Status, UaType};
use utm_fusion::areas::Masks;
use utm_fusion::capture::{Reception, ReceptionKind};
use utm_fusion::config::Config;
use utm_fusion::pipeline::{Event, Output, Pipeline};

use super::shared;

const SITE: &str = r#"
[site]
name = "shore"
sac = 25
sic = 1
latitude_deg = 60.13
longitude_deg = 24.515
height_amsl_m = 10
[[sensors]]
id = "broadcasts"
kind = "remote-id"
sac = 25
sic = 2
"#;

/// Delay of the receiver of that flight, in nanoseconds.
const LATE: i64 = 4 * SECOND;

/// A gateway's line.
fn line(message: &Message) -> String {
    let digits: String = message.octets().iter().map(|octet| format!("{octet:02x}")).collect();
    format!(r#"{{"transmitter":"90:3a:e6:5b:c8:a8","message":"{digits}"}}"#)
}

/// Time of day, latitude, longitude and a height in each row of a log.
fn flown(text: &str, height: &str) -> Vec<[f64; 4]> {
    let mut lines = text.lines();
    let names: Vec<&str> = lines.next().unwrap().split(',').collect();
    let columns =
        ["t_utc_s", "lat", "lon", height].map(|name| names.iter().position(|own| *own == name).unwrap());
    lines
        .map(|line| {
            let cells: Vec<&str> = line.split(',').collect();
            columns.map(|column| cells[column].parse().unwrap())
        })
        .collect()
}

#[test]
fn flight_positions_match_their_log() {
    let Some(folder) = shared::recordings().map(|data| data.join("remote-id")) else { return };
    for (file, height) in
        [("flight1_dronetag_1hz.csv", "geo_alt_m"), ("flight1_autopilot_5hz.csv", "alt_msl_m")]
    {
        let rows = flown(&fs::read_to_string(folder.join(file)).unwrap(), height);
        let config = Config::parse(SITE, "site.toml", std::iter::empty()).unwrap();
        let mut pipeline = Pipeline::new(&config, Masks::default());
        let (mut reports, mut furthest_deg, mut highest_m) = (0, 0.0_f64, 0.0_f64);
        for [seconds, latitude_deg, longitude_deg, height_m] in &rows {
            let content = LocationContent {
                status: Status::Airborne,
                course_deg: None,
                speed_m_s: None,
                climb_m_s: None,
                place_deg: Some([*latitude_deg, *longitude_deg]),
                pressure_altitude_m: None,
                geodetic_altitude_m: Some(*height_m),
                height_m: None,
                accuracy_h_m: Some(10.0),
                accuracy_v_m: None,
                accuracy_pressure_m: None,
                accuracy_speed_m_s: None,
                seconds_of_hour: Some(seconds.rem_euclid(3600.0)),
                accuracy_time_s: None,
            };
            let id = BasicId::new(IdType::SerialNumber, UaType::Rotorcraft, b"1596F35744600073");
            let lines = [line(&Message::BasicId(id)), line(&Message::Location(Location::new(&content)))];
            let sent = Time::from_nanos((seconds * 10.0).round() as i64 * (SECOND / 10));
            pipeline.receive(&Reception {
                received: Some(Time::from_nanos(sent.nanos() + LATE)),
                input: 0,
                from: None,
                kind: ReceptionKind::Datagram,
                origin: 0,
                payload: lines.join("\n").into_bytes(),
            });
            let mut fixes = Vec::new();
            while let Some(output) = pipeline.poll() {
                if let Output::Event(Event::Accepted { report: Report::Fix(fix), .. }) = output {
                    fixes.push(fix);
                }
            }
            assert_eq!(fixes.len(), 1, "{file}: {seconds}");
            let place = pipeline.normaliser().frame().to_geodetic(fixes[0].position);
            let off_deg = [place.latitude_deg() - latitude_deg, place.longitude_deg() - longitude_deg];
            furthest_deg = off_deg.iter().fold(furthest_deg, |most, off| most.max(off.abs()));
            highest_m = highest_m.max((place.height_m - height_m).abs());
            assert_eq!(fixes[0].time, sent);
            assert_eq!(fixes[0].identity.name(), b"1596F35744600073");
            reports += 1;
        }
        println!(
            "{file}: {reports} of {} positions; {furthest_deg:.1e} degrees, {highest_m:.2} m",
            rows.len()
        );
        assert!(reports > 300 && furthest_deg <= 2e-7 && highest_m <= 0.5);
    }
}
