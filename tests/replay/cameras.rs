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
use fusion::registration::{self, DirectionPair};
use fusion::time::{SECOND, Time};
use nalgebra::{Matrix3, Rotation3, Vector3};
use serde::Deserialize;

use super::common::{Scratch, pcap, ran, utm_fusion};

mod starts;

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
    fps: f64,
    frame_beta: f64,
    k2: f64,
    p1: f64,
    p2: f64,
    k3: f64,
    src_fx: f64,
    src_fy: f64,
    src_cx: f64,
    src_cy: f64,
    src_k1: f64,
}

#[derive(Deserialize)]
struct BearingRow {
    camera: usize,
    frame: f64,
    t_s: f64,
    x: f64,
    y: f64,
    z: f64,
    u_px: f64,
    v_px: f64,
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

/// The six cameras with wrong orientations, and the drone.
struct Recording {
    cameras: Vec<CameraRow>,
    /// Rotation from each camera's axes to east, north and up, as it is stated to the program.
    stated: Vec<Matrix3<f64>>,
    /// Bearings by time.
    bearings: Vec<BearingRow>,
    /// Good positions by time.
    truth: Vec<TruthRow>,
}

/// Errors of the stated orientation of a camera, degrees: azimuth and elevation of the axis; the roll is stated as 0.
fn wrong_deg(number: usize) -> [f64; 2] {
    let sign = if number.is_multiple_of(2) { 1.0 } else { -1.0 };
    [4.0 * sign, -2.0 * sign]
}

impl Recording {
    /// `None`: the shared data are absent.
    fn read() -> Option<Self> {
        let Some(root) = std::env::var_os("UTM_FUSION_SHARED_DATA") else {
            println!("skipped: UTM_FUSION_SHARED_DATA is not set");
            return None;
        };
        let folder = Path::new(&root).join("cameras");
        let packed = |name: &str| GzDecoder::new(Cursor::new(fs::read(folder.join(name)).unwrap()));
        let cameras: Vec<CameraRow> = rows(fs::read(folder.join("cameras.csv")).unwrap().as_slice());
        let stated = cameras.iter().enumerate().map(|(number, camera)| {
            let [azimuth_deg, elevation_deg] = wrong_deg(number);
            attitude(camera.axis_azimuth_deg + azimuth_deg, camera.axis_elevation_deg + elevation_deg, 0.0)
        });
        let mut truth: Vec<TruthRow> = rows(packed("truth.csv.gz"));
        truth.retain(|row| row.ok == 1);
        Some(Self { stated: stated.collect(), bearings: rows(packed("bearings.csv.gz")), cameras, truth })
    }

    /// Site file, the drone's reports every second, and the bearings that `is_sent`, at most five a second and camera.
    fn replayed(&self, mut is_sent: impl FnMut(&BearingRow) -> bool) -> String {
        let frame = TangentPlane::<AtSite>::at(Geodetic::from_degrees(52.0, 0.0, 0.0));
        let geodetic = |place: [f64; 3]| frame.to_geodetic(Enu::from(Vector3::from(place)));
        let mut site = String::from(
            "[site]\nname = \"six cameras\"\nsac = 25\nsic = 1\nlatitude_deg = 52.0\nlongitude_deg = 0.0\n\
             height_amsl_m = 0.0\ngeoid_undulation_m = 0.0\n[fusion]\nprofile = \"operational\"\n\
             [[sensors]]\nid = \"rtk\"\nkind = \"transponder\"\nsac = 0\nsic = 0\nperiod_s = 1.0\ndelay_s = 0.0\n\
             accuracy = { horizontal_m = 0.5, vertical_m = 0.5 }\n",
        );
        for (number, camera) in self.cameras.iter().enumerate() {
            let place = geodetic(camera.place());
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
        }
        let mut sent: Vec<(Time, Vec<u8>)> = Vec::new();
        for truth in self.truth.iter().step_by(5) {
            let place = geodetic(truth.place());
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
        let mut latest = vec![f64::NEG_INFINITY; self.cameras.len()];
        for row in &self.bearings {
            if row.t_s - latest[row.camera] < APART_S || !is_sent(row) {
                continue;
            }
            latest[row.camera] = row.t_s;
            sent.push((at(row.t_s + 0.1), bearing(row, self.stated[row.camera] * row.direction())));
        }
        sent.sort_by_key(|(time, _)| *time);
        let scratch = Scratch::new();
        let site = scratch.file("site.toml", site);
        let capture = scratch
            .file("cameras.pcap", pcap(sent.iter().map(|(time, payload)| (*time, payload.as_slice()))));
        let mut replay = utm_fusion("replay");
        replay.arg(&capture).arg("--config").arg(&site).arg("-o").arg(scratch.path("out.ndjson"));
        String::from_utf8(ran(&mut replay).stdout).unwrap()
    }

    /// Direction from a camera to the drone; `None` where its position is missing.
    fn reference(&self, row: &BearingRow) -> Option<Vector3<f64>> {
        Some((self.drone_at(row.t_s)? - Vector3::from(self.cameras[row.camera].place())).normalize())
    }

    /// Position of the drone, from positions on both sides; `None` where one is missing.
    fn drone_at(&self, t_s: f64) -> Option<Vector3<f64>> {
        let after = self.truth.partition_point(|truth| truth.t_s <= t_s);
        let around = self.truth.get(after.checked_sub(2)?..after + 2)?;
        if around.windows(2).any(|pair| pair[1].t_s - pair[0].t_s > 0.25) {
            return None;
        }
        // Cubic interpolation through four positions 0.2 s apart (Catmull and Rom).
        let share = (t_s - around[1].t_s) / (around[2].t_s - around[1].t_s);
        let [p, q, r, s] = [0, 1, 2, 3].map(|index: usize| Vector3::from(around[index].place()));
        let curve = q * 2.0
            + (r - p) * share
            + (p * 2.0 - q * 5.0 + r * 4.0 - s) * share.powi(2)
            + (q * 3.0 - p - r * 3.0 + s) * share.powi(3);
        Some(curve / 2.0)
    }
}

impl CameraRow {
    fn place(&self) -> [f64; 3] {
        [self.east_m, self.north_m, self.up_m]
    }
}

impl TruthRow {
    fn place(&self) -> [f64; 3] {
        [self.east_m, self.north_m, self.up_m]
    }
}

impl BearingRow {
    fn direction(&self) -> Vector3<f64> {
        Vector3::new(self.x, self.y, self.z)
    }
}

/// A look (CAT015) in a direction of the site's axes.
fn bearing(row: &BearingRow, there: Vector3<f64>) -> Vec<u8> {
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
    payload
}

/// Bearing and tilts of a camera in the lines `oriented`, degrees.
fn oriented(said: &str, number: usize) -> [f64; 3] {
    let line = said.lines().find(|line| line.starts_with(&format!("oriented   camera-{number}:"))).unwrap();
    ["bearing", "tilt east", "tilt north"].map(|name| {
        let (_, value) = line.split_once(&format!("{name} ")).unwrap();
        value.split_whitespace().next().unwrap().parse().unwrap()
    })
}

#[test]
fn real_cameras_learn_their_orientation() {
    let Some(recording) = Recording::read() else { return };
    let mut latest = vec![f64::NEG_INFINITY; recording.cameras.len()];
    let mut in_view_s = vec![0.0; recording.cameras.len()];
    let said = recording.replayed(|row| {
        let is_early = in_view_s[row.camera] < IN_VIEW_S;
        in_view_s[row.camera] += (row.t_s - latest[row.camera]).min(1.0);
        latest[row.camera] = row.t_s;
        is_early
    });
    for (number, CameraRow { axis_azimuth_deg, axis_elevation_deg, roll_deg, .. }) in
        recording.cameras.iter().enumerate()
    {
        let right = attitude(*axis_azimuth_deg, *axis_elevation_deg, *roll_deg);
        let turn = Rotation3::from_matrix(&(recording.stated[number] * right.transpose())).scaled_axis();
        let expected = [-turn.z, turn.x, turn.y].map(f64::to_degrees);
        let learnt = oriented(&said, number);
        println!("camera {number}: {learnt:.2?}; expected {expected:.2?}");
        for (value, expected) in learnt.iter().zip(expected) {
            assert!((value - expected).abs() <= 0.1, "camera {number}: {learnt:?} {expected:?}");
        }
    }
}

/// Median, degrees.
fn median_deg(mut residuals: Vec<f64>) -> f64 {
    residuals.sort_by(f64::total_cmp);
    residuals[residuals.len() / 2].to_degrees()
}

/// The orientation is learnt from the first half of each camera's bearings. An offline fit of the same half, with all of its
/// bearings and the drone's position at each of them, is the limit.
#[test]
fn orientation_of_first_half_fits_the_second() {
    let Some(recording) = Recording::read() else { return };
    let ends: Vec<f64> = (0..recording.cameras.len())
        .map(|number| {
            let own: Vec<&BearingRow> =
                recording.bearings.iter().filter(|row| row.camera == number).collect();
            own[own.len() / 2].t_s
        })
        .collect();
    let said = recording.replayed(|row| row.t_s < ends[row.camera]);
    for (number, &end_s) in ends.iter().enumerate() {
        let own = recording.bearings.iter().filter(|row| row.camera == number);
        let pairs = own.filter_map(|row| Some((row.t_s, row.direction(), recording.reference(row)?)));
        let (first, second): (Vec<_>, Vec<_>) = pairs.partition(|(t_s, ..)| *t_s < end_s);
        let pair = |&(_, measured, reference): &(f64, Vector3<f64>, Vector3<f64>)| DirectionPair {
            measured,
            reference,
            weight: 1.0,
        };
        let offline = registration::attitude(first.iter().map(pair)).unwrap();
        let offline_deg = median_deg(
            second.iter().map(|(_, measured, reference)| measured.angle(&(offline * reference))).collect(),
        );
        let [bearing, tilt_east, tilt_north] = oriented(&said, number).map(f64::to_radians);
        // From stated to true directions: the inverse of the misalignment.
        let learnt = Rotation3::new(Vector3::new(-tilt_east, -tilt_north, bearing));
        let live_deg = median_deg(
            second
                .iter()
                .map(|(_, measured, reference)| {
                    (learnt * recording.stated[number] * measured).angle(reference)
                })
                .collect(),
        );
        println!(
            "camera {number}: median residual {live_deg:.3}°, offline {offline_deg:.3}°, ratio {:.2}, {} bearings",
            live_deg / offline_deg,
            second.len()
        );
        assert!(live_deg <= 1.5 * offline_deg, "camera {number}: {live_deg} {offline_deg}");
    }
}
