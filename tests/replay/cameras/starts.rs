//! Two real cameras begin a target by themselves: the transponder is withheld.

use super::*;

/// Standard deviation of the stated orientations, degrees.
const ORIENTATION_DEG: f64 = 0.1;

/// Points of one pair of cameras.
struct Started {
    /// Errors in space, metres.
    errors_m: Vec<f64>,
    /// Number of points with an error over ground, and in height, within the stated radius of 95 %.
    within: [usize; 2],
    /// Track numbers.
    numbers: Vec<String>,
    /// Time for which both cameras see the drone, seconds.
    seen_s: f64,
}

impl BearingRow {
    /// The bearing with the clock and the lens that the source of the data publishes.
    fn as_published(&self, camera: &CameraRow) -> Self {
        let (u, v) =
            ((self.u_px - camera.src_cx) / camera.src_fx, (self.v_px - camera.src_cy) / camera.src_fy);
        let (mut x, mut y) = (u, v);
        // The inverse of OpenCV's model of a lens.
        for _ in 0..30 {
            let r2 = x * x + y * y;
            let radial = 1.0 + r2 * (camera.src_k1 + r2 * (camera.k2 + r2 * camera.k3));
            let dx = 2.0 * camera.p1 * x * y + camera.p2 * (r2 + 2.0 * x * x);
            let dy = camera.p1 * (r2 + 2.0 * y * y) + 2.0 * camera.p2 * x * y;
            (x, y) = ((u - dx) / radial, (v - dy) / radial);
        }
        let direction = Vector3::new(x, y, 1.0).normalize();
        let t_s = (self.frame - camera.frame_beta) / camera.fps + 61.854;
        Self { t_s, x: direction.x, y: direction.y, z: direction.z, ..*self }
    }
}

impl Recording {
    /// Replays the second halves of the bearings of two cameras. The first halves give the orientation.
    fn started(&self, pair: [usize; 2], accuracy_deg: f64) -> Started {
        let frame = TangentPlane::<AtSite>::at(Geodetic::from_degrees(52.0, 0.0, 0.0));
        let mut site = String::from(
            "[site]\nname = \"two cameras\"\nsac = 25\nsic = 1\nlatitude_deg = 52.0\nlongitude_deg = 0.0\n\
             height_amsl_m = 0.0\ngeoid_undulation_m = 0.0\n[fusion]\nprofile = \"operational\"\n",
        );
        let mut sent: Vec<(Time, Vec<u8>)> = Vec::new();
        let mut times: Vec<Vec<f64>> = Vec::new();
        for number in pair {
            let own: Vec<&BearingRow> = self.bearings.iter().filter(|row| row.camera == number).collect();
            let (first, second) = own.split_at(own.len() / 2);
            let directions = first.iter().filter_map(|row| {
                Some(DirectionPair {
                    measured: row.direction(),
                    reference: self.reference(row)?,
                    weight: 1.0,
                })
            });
            let turn = registration::attitude(directions).unwrap();
            let place = frame.to_geodetic(Enu::from(Vector3::from(self.cameras[number].place())));
            write!(
                site,
                "[[sensors]]\nid = \"camera-{number}\"\nkind = \"camera\"\nsac = 25\nsic = {}\nlatitude_deg = {:.9}\n\
                 longitude_deg = {:.9}\nheight_amsl_m = {:.3}\norientation_deg = {ORIENTATION_DEG}\n\
                 accuracy = {{ azimuth_deg = {accuracy_deg}, elevation_deg = {accuracy_deg} }}\n",
                230 + number,
                place.latitude_deg(),
                place.longitude_deg(),
                place.height_m,
            )
            .unwrap();
            let mut latest = f64::NEG_INFINITY;
            times.push(Vec::new());
            for row in second {
                if row.t_s - latest >= APART_S {
                    latest = row.t_s;
                    sent.push((at(row.t_s + 0.1), bearing(row, turn.inverse() * row.direction())));
                    times.last_mut().unwrap().push(row.t_s);
                }
            }
        }
        let is_seen = |t_s: f64| times.iter().all(|times| times.iter().any(|time| (time - t_s).abs() < 0.3));
        let seen_s = (0..700).filter(|&second| is_seen(f64::from(second))).count() as f64;
        sent.sort_by_key(|(time, _)| *time);
        let scratch = Scratch::new();
        let site = scratch.file("site.toml", site);
        let capture = scratch
            .file("cameras.pcap", pcap(sent.iter().map(|(time, payload)| (*time, payload.as_slice()))));
        let output = scratch.path("out.csv");
        let mut replay = utm_fusion("replay");
        replay.arg(&capture).arg("--config").arg(&site).arg("-o").arg(&output);
        let ran = ran(&mut replay);
        assert_eq!(ran.code, 0, "{}", ran.stderr);
        let mut started = Started { errors_m: Vec::new(), within: [0; 2], numbers: Vec::new(), seen_s };
        let mut reader = csv::Reader::from_path(output).unwrap();
        let names = reader.headers().unwrap().clone();
        let column = |name: &str| names.iter().position(|known| known == name).unwrap();
        let columns = ["time", "lat", "lon", "alt_msl", "accuracy_h_m", "accuracy_v_m"].map(column);
        let (number, source) = (column("track_number"), column("source"));
        for row in reader.records() {
            let row = row.unwrap();
            assert_eq!(&row[source], "camera");
            let [time, latitude, longitude, height, accuracy_h, accuracy_v] =
                columns.map(|column| row[column].parse::<f64>().unwrap());
            let Some(truth) = self.drone_at(time - START_S as f64) else { continue };
            let place: Enu = frame.from_geodetic(Geodetic::from_degrees(latitude, longitude, height));
            let error = place.0 - truth;
            started.errors_m.push(error.norm());
            started.within[0] += usize::from(error.xy().norm() <= accuracy_h);
            started.within[1] += usize::from(error.z.abs() <= accuracy_v);
            if !started.numbers.iter().any(|known| *known == row[number]) {
                started.numbers.push(row[number].to_owned());
            }
        }
        started
    }
}

/// Value below which a share of the errors lies.
fn quantile(errors_m: &[f64], share: f64) -> f64 {
    let mut sorted = errors_m.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted.get((sorted.len() as f64 * share) as usize).copied().unwrap_or(f64::NAN)
}

#[test]
fn two_real_cameras_begin_the_drone() {
    let Some(mut recording) = Recording::read() else { return };
    for (name, accuracy_deg, median_m) in [("corrected", 0.1, 0.5), ("as published", 0.4, 5.0)] {
        if name != "corrected" {
            let rows = recording.bearings.iter();
            recording.bearings = rows.map(|row| row.as_published(&recording.cameras[row.camera])).collect();
            recording.bearings.sort_by(|a, b| a.t_s.total_cmp(&b.t_s));
        }
        let (mut medians, mut all, mut within, mut found) = (Vec::new(), Vec::new(), [0; 2], 0);
        for one in 0..recording.cameras.len() {
            for other in one + 1..recording.cameras.len() {
                let started = recording.started([one, other], accuracy_deg);
                let count = started.errors_m.len();
                println!(
                    "{name}, cameras {one} and {other}: {count} points in {:.0} s, error {:.2} m, 90 % {:.2} m, largest {:.1} m; \
                     within 95 %: {:.2}, {:.2}; numbers {:?}",
                    started.seen_s,
                    quantile(&started.errors_m, 0.5),
                    quantile(&started.errors_m, 0.9),
                    quantile(&started.errors_m, 0.9999),
                    started.within[0] as f64 / count as f64,
                    started.within[1] as f64 / count as f64,
                    started.numbers.len(),
                );
                if count > 0 {
                    found += 1;
                    medians.push(quantile(&started.errors_m, 0.5));
                }
                within = [within[0] + started.within[0], within[1] + started.within[1]];
                all.extend(started.errors_m);
            }
        }
        let share = |count: usize| count as f64 / all.len() as f64;
        println!(
            "{name}: {found} pairs, medians {:.2} to {:.2} m, all {:.2} m, 90 % {:.2} m, within 95 %: {:.3}, {:.3}",
            quantile(&medians, 0.0),
            quantile(&medians, 0.9999),
            quantile(&all, 0.5),
            quantile(&all, 0.9),
            share(within[0]),
            share(within[1]),
        );
        assert!(quantile(&all, 0.5) <= median_m, "{name}");
        assert!(found >= 10 && share(within[0]) > 0.8, "{name}");
    }
}
