//! Real bearings of six cameras whose orientation is stated wrongly, with the drone's RTK positions as transponder reports.

use std::fmt::Write;
use std::fs;
use std::io::{Cursor, Read};
use std::path::Path;

use asterix::cat015::{
    self, Angle, AngleDeviation, AzimuthInformation, ElevationInformation, ReportNumber, SignedAngle,
};
use asterix::cat015::{MessageKind, MessageType, TargetReport};
use asterix::cat129::{self, Altitude, Position};
use asterix::{DataSource, TimeOfDay, encode_block};
use flate2::read::GzDecoder;
use fusion::Enu;
use fusion::frames::{AtSite, Geodetic, TangentPlane};
use fusion::time::{SECOND, Time};
use nalgebra::{Matrix3, Rotation3, Vector3};
use serde::Deserialize;

use super::common::{Scratch, pcap, ran, utm_fusion};

/// A full hour, whole seconds since 1970.
const START_S: i64 = 1_700_002_800;
/// Time for which each camera sees the drone, seconds.
const IN_VIEW_S: f64 = 120.0;
/// Time between two bearings of one camera, seconds.
const APART_S: f64 = 0.2;

#[derive(Deserialize)]
struct CameraRow {
    east_m: f64,
    north_m: f64,
    up_m: f64,
    axis_azimuth_deg: f64,
    axis_elevation_deg: f64,
    roll_deg: f64,
}

#[derive(Deserialize)]
struct BearingRow {
    camera: usize,
    t_s: f64,
    x: f64,
    y: f64,
    z: f64,
}

#[derive(Deserialize)]
struct TruthRow {
    t_s: f64,
    east_m: f64,
    north_m: f64,
    up_m: f64,
    ok: u8,
}

fn rows<T: for<'a> Deserialize<'a>>(reader: impl Read) -> Vec<T> {
    csv::Reader::from_reader(reader).deserialize().map(Result::unwrap).collect()
}

/// Rotation from a camera's axes (right, down, forward) to east, north and up, for an azimuth and elevation of the optical axis
/// and a roll (right side down), degrees.
fn attitude(azimuth_deg: f64, elevation_deg: f64, roll_deg: f64) -> Matrix3<f64> {
    let [azimuth, elevation, roll] = [azimuth_deg, elevation_deg, roll_deg].map(f64::to_radians);
    let forward =
        Vector3::new(azimuth.sin() * elevation.cos(), azimuth.cos() * elevation.cos(), elevation.sin());
    let level = Vector3::new(azimuth.cos(), -azimuth.sin(), 0.0);
    let down = forward.cross(&level);
    let (right, down) = (level * roll.cos() + down * roll.sin(), down * roll.cos() - level * roll.sin());
    Matrix3::from_columns(&[right, down, forward])
}

fn at(seconds: f64) -> Time {
    Time::from_nanos(START_S * SECOND + (seconds * SECOND as f64) as i64)
}

fn time_of_day(time: Time) -> TimeOfDay {
    TimeOfDay::from_seconds(time.since_midnight() as f64 / SECOND as f64).unwrap()
}

#[test]
fn real_cameras_learn_their_orientation() {
    let Some(root) = std::env::var_os("UTM_FUSION_SHARED_DATA") else {
        println!("skipped: UTM_FUSION_SHARED_DATA is not set");
        return;
    };
    let folder = Path::new(&root).join("cameras");
    let cameras: Vec<CameraRow> = rows(fs::read(folder.join("cameras.csv")).unwrap().as_slice());
    let packed = |name: &str| GzDecoder::new(Cursor::new(fs::read(folder.join(name)).unwrap()));
    let frame = TangentPlane::<AtSite>::at(Geodetic::from_degrees(52.0, 0.0, 0.0));
    let geodetic = |place: [f64; 3]| frame.to_geodetic(Enu::from(Vector3::from(place)));
    let mut site = String::from(
        "[site]\nname = \"six cameras\"\nsac = 25\nsic = 1\nlatitude_deg = 52.0\nlongitude_deg = 0.0\nheight_amsl_m = 0.0\n\
         geoid_undulation_m = 0.0\n[fusion]\nprofile = \"operational\"\n\
         [[sensors]]\nid = \"rtk\"\nkind = \"transponder\"\nsac = 0\nsic = 0\nperiod_s = 1.0\ndelay_s = 0.0\n\
         accuracy = { horizontal_m = 0.5, vertical_m = 0.5 }\n",
    );
    let (mut wrong, mut expected) = (Vec::new(), Vec::new());
    for (number, camera) in cameras.iter().enumerate() {
        let place = geodetic([camera.east_m, camera.north_m, camera.up_m]);
        write!(
            site,
            "[[sensors]]\nid = \"camera-{number}\"\nkind = \"camera\"\nsac = 25\nsic = {}\nlatitude_deg = {:.9}\n\
             longitude_deg = {:.9}\nheight_amsl_m = {:.3}\norientation_deg = 5.0\n\
             accuracy = {{ azimuth_deg = 0.1, elevation_deg = 0.1 }}\n",
            230 + number,
            place.latitude_deg(),
            place.longitude_deg(),
            place.height_m,
        )
        .unwrap();
        let CameraRow { axis_azimuth_deg, axis_elevation_deg, roll_deg, .. } = camera;
        let sign = if number % 2 == 0 { 1.0 } else { -1.0 };
        let right = attitude(*axis_azimuth_deg, *axis_elevation_deg, *roll_deg);
        let stated = attitude(axis_azimuth_deg + 4.0 * sign, axis_elevation_deg - 2.0 * sign, 0.0);
        let turn = Rotation3::from_matrix(&(stated * right.transpose())).scaled_axis();
        expected.push([-turn.z, turn.x, turn.y].map(f64::to_degrees));
        wrong.push(stated);
    }
    let mut sent: Vec<(Time, Vec<u8>)> = Vec::new();
    for truth in rows::<TruthRow>(packed("truth.csv.gz")).iter().filter(|row| row.ok == 1).step_by(5) {
        let place = geodetic([truth.east_m, truth.north_m, truth.up_m]);
        let stamp = time_of_day(at(truth.t_s));
        let position = Position::new(place.latitude_deg(), place.longitude_deg());
        let record = cat129::Record::builder(DataSource { sac: 0, sic: 0 }, *b"CH", stamp, position)
            .serial_number(*b"RTK000000001")
            .altitude_amsl(Altitude::from_metres(place.height_m))
            .build()
            .unwrap();
        let mut payload = Vec::new();
        encode_block(&[record], &mut payload).unwrap();
        sent.push((at(truth.t_s + 0.1), payload));
    }
    let mut latest = vec![f64::NEG_INFINITY; cameras.len()];
    let mut in_view_s = vec![0.0; cameras.len()];
    for row in rows::<BearingRow>(packed("bearings.csv.gz")) {
        let since_s = row.t_s - latest[row.camera];
        if since_s < APART_S || in_view_s[row.camera] >= IN_VIEW_S {
            continue;
        }
        in_view_s[row.camera] += since_s.min(1.0);
        latest[row.camera] = row.t_s;
        let there = wrong[row.camera] * Vector3::new(row.x, row.y, row.z);
        let source = DataSource { sac: 25, sic: 230 + row.camera as u8 };
        let kind = MessageType::default().with_kind(MessageKind::MeasurementTrack);
        let record = cat015::Record::builder(source, kind, time_of_day(at(row.t_s)))
            .number(ReportNumber::default().with_number(1))
            .target_report(TargetReport::default())
            .azimuth(AzimuthInformation {
                azimuth: Angle::default().with_degrees(there.x.atan2(there.y).to_degrees().rem_euclid(360.0)),
                deviation: AngleDeviation::default().with_degrees(0.1),
                ..AzimuthInformation::default()
            })
            .elevation(ElevationInformation {
                elevation: SignedAngle::default().with_degrees(there.z.asin().to_degrees()),
                deviation: AngleDeviation::default().with_degrees(0.1),
                ..ElevationInformation::default()
            })
            .build()
            .unwrap();
        let mut payload = Vec::new();
        encode_block(&[record], &mut payload).unwrap();
        sent.push((at(row.t_s + 0.1), payload));
    }
    sent.sort_by_key(|(time, _)| *time);
    let scratch = Scratch::new();
    let site = scratch.file("site.toml", site);
    let capture =
        scratch.file("cameras.pcap", pcap(sent.iter().map(|(time, payload)| (*time, payload.as_slice()))));
    let mut replay = utm_fusion("replay");
    replay.arg(&capture).arg("--config").arg(&site).arg("-o").arg(scratch.path("out.ndjson"));
    let said = String::from_utf8(ran(&mut replay).stdout).unwrap();
    for (number, expected) in expected.iter().enumerate() {
        let line =
            said.lines().find(|line| line.starts_with(&format!("oriented   camera-{number}:"))).unwrap();
        println!("{line}; expected {expected:.2?}");
        for (name, expected) in ["bearing", "tilt east", "tilt north"].iter().zip(expected) {
            let (_, value) = line.split_once(&format!("{name} ")).unwrap();
            let value: f64 = value.split_whitespace().next().unwrap().parse().unwrap();
            assert!((value - expected).abs() <= 0.1, "camera {number}: {name} {value} {expected}");
        }
    }
}
