//! A small flight whose metrics are all computed by hand.
//!
//! ALPHA hovers at latitude 0, longitude 0; BRAVO hovers 1000 m east of it. Both are at sea level from 0 to 40 s. The
//! counted centres are from 10 to 32.5 s: slots 40 (10.125) to 129 (32.375), which is 90 slots, 22.5 s or 0.375 min per
//! drone.

use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::path::PathBuf;

use fusion::time::Time;
use utm_fusion::evaluate::read::{self, DayReference};
use utm_fusion::evaluate::{Covariance, Evaluation, InputsAlone, Labels, Nees, OutputPoint, Scoring, Truth};

use super::common::{START_S, Scratch, assert_near, centre_s, east, evaluate, north, ran};

/// Slot, source, number, radar track, transponder, metres east and north, height.
type Point = (i64, &'static str, u32, &'static str, &'static str, f64, f64, &'static str);

const POINTS: [Point; 9] = [
    (39, "fused", 70011, "11", "7", 0.0, 0.0, "0"), // before the counted slots
    (40, "fused", 70011, "11", "7", 3.0, 4.0, "12"), // 5 m and 12 m off: 13 m
    (41, "fused", 70011, "11", "7", 0.0, 3.0, "-4"), // 3 m and 4 m: 5 m
    (42, "transponder", 7, "", "7", 0.0, 0.0, "0"),
    (43, "radar", 14, "14", "", 1006.0, 0.0, ""), // BRAVO, 6 m off, without height
    (44, "fused", 70012, "12", "7", 8.0, 0.0, "0"), // radar track 12 is BRAVO's: a wrong pair
    (48, "radar", 99, "99", "", 5000.0, 0.0, "50"), // a bird
    (49, "radar", 99, "99", "", 5000.0, 0.0, "50"),
    (50, "fused", 70013, "13", "7", 0.0, 0.0, "0"), // radar track 13 is seduced
];

/// Sensor, number, drone, seduced, slots.
const LABELS: [(&str, u32, &str, &str, &[i64]); 6] = [
    ("radar", 11, "ALPHA", "0", &[39, 40, 41, 42]),
    ("radar", 12, "BRAVO", "0", &[44]),
    ("radar", 13, "ALPHA", "1", &[50]),
    ("radar", 14, "BRAVO", "", &[43]),
    ("radar", 99, "", "0", &[48, 49]),
    ("squitter", 7, "ALPHA", "0", &[32, 40, 48]),
];

fn output(points: &[Point]) -> String {
    let mut text =
        String::from("time,id,source,track_number,radar_track,transponder,lat,lon,alt_msl,flags\n");
    for &(slot, source, number, radar, transponder, east_m, north_m, height) in points {
        let (time, lat, lon) = (centre_s(slot), north(north_m), east(east_m));
        writeln!(text, "{time},X-1,{source},{number},{radar},{transponder},{lat:.12},{lon:.12},{height},")
            .unwrap();
    }
    text
}

fn labels() -> String {
    let mut text = String::from("time,sensor,number,id,seduced\n");
    for (sensor, number, id, seduced, slots) in LABELS {
        for slot in slots {
            writeln!(text, "{},{sensor},{number},{id},{seduced}", centre_s(*slot) - 0.0625).unwrap();
        }
    }
    text
}

/// Samples of both drones at these seconds.
fn truth(seconds: &[f64]) -> String {
    let mut text = String::from("time,id,lat,lon,alt_msl,vn,ve,vd\n");
    for second in seconds {
        for (id, east_m) in [("ALPHA", 0.0), ("BRAVO", 1000.0)] {
            writeln!(text, "{},{id},0,{:.12},0,,,", START_S + second, east(east_m)).unwrap();
        }
    }
    text
}

fn whole_flight() -> Vec<f64> {
    (0..=8).map(|step| f64::from(step) * 5.0).collect()
}

struct Files {
    scratch: Scratch,
    truth: PathBuf,
    labels: PathBuf,
    output: PathBuf,
}

fn files() -> Files {
    let scratch = Scratch::new();
    Files {
        truth: scratch.file("truth.csv", truth(&whole_flight())),
        labels: scratch.file("labels.csv", labels()),
        output: scratch.file("out.csv", output(&POINTS)),
        scratch,
    }
}

/// Checks the metrics that do not depend on labels.
fn assert_without_pairs(json: &serde_json::Value) {
    let near = |way, expected| assert_near(json, way, expected);
    // ALPHA in slots 40, 41, 42, 44, 50; BRAVO in 43: 6 of 180.
    near("fused.all.pu_percent", 100.0 * 6.0 / 180.0);
    near("drones.0.fused.pu_percent", 100.0 * 5.0 / 90.0);
    near("drones.1.fused.pu_percent", 100.0 / 90.0);
    // Distances 13, 5, 0, 8, 0 and 6: sum 32, of squares 294; (294 - 32²/6) / 5 = 24.6667, / 6 = 4.1111.
    near("fused.all.epos.count", 6.0);
    near("fused.all.epos.mean_m", 32.0 / 6.0);
    near("fused.all.epos.sem_m", 4.111_111_f64.sqrt());
    // Sorted 0 0 5 6 8 13: ranks 2.5 and 4.75.
    near("fused.all.epos.p50_m", 5.5);
    near("fused.all.epos.p95_m", 8.0 + 0.75 * 5.0);
    // Horizontally 5, 3, 0, 8, 0, 6; vertically 12, 4, 0, 0, 0: BRAVO's point has no height.
    near("fused.all.eposh.mean_m", 22.0 / 6.0);
    near("fused.all.eposv.count", 5.0);
    near("fused.all.eposv.mean_m", 16.0 / 5.0);
    near("drones.1.fused.epos.mean_m", 6.0);
    assert!(json["drones"][1]["fused"].get("eposv").is_none());
    // 70011 70011 7 70012 70013: 3 changes in 2 · 0.375 minutes.
    near("fused.all.id_changes", 3.0 / 0.75);
    near("drones.0.fused.id_changes", 3.0 / 0.375);
    // The bird's two slots of 0.25 s in 0.375 minutes.
    near("fused.all.false_track_s", 0.5 / 0.375);
    // Slots 40, 44, …, 128: 23. One has a pair of 13 m and one missed; one a pair of 8 m; one two missed and a bird;
    // the others two missed.
    let sum = 1419_f64.sqrt() + 1314_f64.sqrt() + 3750_f64.sqrt() + 20.0 * 50.0;
    near("fused.all.gospa_m", sum / 23.0);
    near("fused.all.gospa_parts.matched", 2.0 / 23.0);
    near("fused.all.gospa_parts.missed", 44.0 / 23.0);
    near("fused.all.gospa_parts.unmatched", 1.0 / 23.0);
    near("fused.all.gospa_parts.localisation_rms_m", ((169.0 + 64.0) / 2.0_f64).sqrt());
    for absent in ["epos_covered", "epos_gap", "recall"] {
        assert!(json["fused"]["all"].get(absent).is_none(), "{absent} needs a capture");
    }
    assert!(json.get("radar").is_none() && json.get("transponder").is_none());
}

#[test]
fn with_labels() {
    let files = files();
    let json =
        ran(evaluate(&files.truth, &files.output).arg("--labels").arg(&files.labels).arg("--json")).json();
    assert_without_pairs(&json);
    // Correct in slots 40 and 41, wrong in 44; the seduced track of slot 50 does not count.
    assert_near(&json, "fused.all.precision", 2.0 / 3.0);
    assert_near(&json, "fused.equipped.precision", 2.0 / 3.0);
    assert_eq!(
        (&json["drones"][0]["equipped"], &json["drones"][1]["equipped"]),
        (&true.into(), &false.into())
    );
    assert_near(&json, "fused.equipped.epos.mean_m", 26.0 / 5.0);
    assert_near(&json, "fused.unequipped.epos.mean_m", 6.0);
    assert_near(&json, "fused.unequipped.pu_percent", 100.0 / 90.0);
}

#[test]
fn without_labels_the_nearest_drone_within_150_m_has_the_point() {
    let files = files();
    let json = ran(evaluate(&files.truth, &files.output).arg("--json")).json();
    assert_without_pairs(&json);
    assert!(json["fused"]["all"].get("precision").is_none(), "precision needs labels");
    assert!(json["drones"][0].get("equipped").is_none());

    // 149 m and 151 m north of ALPHA; 120 m north and 120 m up (169.7 m), and the same without a height.
    let points = [
        (60, "radar", 1, "1", "", 0.0, 149.0, ""),
        (61, "radar", 1, "1", "", 0.0, 151.0, ""),
        (62, "radar", 1, "1", "", 0.0, 120.0, "120"),
        (63, "radar", 1, "1", "", 0.0, 120.0, ""),
        (64, "radar", 1, "1", "", 520.0, 0.0, ""),
        (65, "radar", 1, "1", "", 880.0, 0.0, ""),
    ];
    let far = files.scratch.file("far.csv", output(&points));
    let json = ran(evaluate(&files.truth, &far).arg("--json")).json();
    assert_near(&json, "drones.0.fused.eposh.count", 2.0);
    assert_near(&json, "drones.0.fused.eposh.mean_m", (149.0 + 120.0) / 2.0);
    assert_near(&json, "drones.1.fused.eposh.mean_m", 120.0);
    assert_near(&json, "fused.all.false_track_s", 3.0 * 0.25 / 0.375);
}

#[test]
fn holes_of_the_truth_do_not_count() {
    // The truth has no sample between 20 and 30.1 s. Slots 80 (20.125) to 119 (29.875) do not count, which leaves 50 slots.
    let seconds = [0.0, 5.0, 10.0, 15.0, 20.0, 30.1, 35.0, 40.0];
    let scratch = Scratch::new();
    let truth = scratch.file("truth.csv", truth(&seconds));
    let points = [
        (79, "fused", 70011, "11", "7", 2.0, 0.0, "0"),
        (100, "fused", 70099, "11", "7", 50.0, 0.0, "0"), // in the hole: no error, no change of number
        (104, "radar", 5, "5", "", 20.0, 0.0, "0"),       // not a false track either
        (120, "fused", 70011, "11", "7", 4.0, 0.0, "0"),
    ];
    let out = scratch.file("out.csv", output(&points));
    let labels = scratch.file("labels.csv", labels());
    for labels in [None, Some(labels)] {
        let mut command = evaluate(&truth, &out);
        command.arg("--json").args(labels.iter().flat_map(|path| ["--labels".into(), path.clone()]));
        let json = ran(&mut command).json();
        assert_near(&json, "drones.0.fused.pu_percent", 100.0 * 2.0 / 50.0);
        assert_near(&json, "drones.0.fused.eposh.mean_m", 3.0);
        assert_near(&json, "drones.0.fused.id_changes", 0.0);
        assert_near(&json, "fused.all.false_track_s", 0.0);
        // Slots 40 to 128 by 4 without 80 to 116. Only slot 120 has a point: 4 m off, with BRAVO missed.
        assert_near(&json, "fused.all.gospa_m", (12.0 * 50.0 + 1266_f64.sqrt()) / 13.0);
    }
}

#[test]
fn number_is_kept_while_any_point_has_it() {
    let fused = |slot, number, radar| (slot, "fused", number, radar, "7", 0.0, 0.0, "0");
    let points = [
        fused(40, 70011, "11"),
        fused(40, 70012, "12"), // both: 70011 is followed
        fused(41, 70012, "12"),
        fused(41, 70011, "11"), // still there, though not first
        fused(42, 70012, "12"), // gone: the first change
        fused(43, 70011, "11"), // and back: the second
        fused(44, 70012, "12"),
        fused(44, 70011, "11"),
    ];
    let scratch = Scratch::new();
    let truth = scratch.file("truth.csv", truth(&whole_flight()));
    let out = scratch.file("out.csv", output(&points));
    let json = ran(evaluate(&truth, &out).arg("--json")).json();
    assert_near(&json, "drones.0.fused.id_changes", 2.0 / 0.375);
}

#[test]
fn a_gpx_truth_is_the_same() {
    let files = files();
    let track = |id: &str, east_m: f64| {
        let point = |second: f64| {
            format!(
                "<trkpt lat=\"0.0\" lon=\"{:.12}\"><ele>0</ele><time>2026-03-14T09:00:{second:02}Z</time></trkpt>",
                east(east_m)
            )
        };
        let points: String = whole_flight().into_iter().map(point).collect();
        format!("<trk>{id}<trkseg>{points}</trkseg></trk>")
    };
    let gpx = |tracks: &str| {
        format!(
            "<?xml version=\"1.0\"?>\n<gpx version=\"1.1\" xmlns=\"http://www.topografix.com/GPX/1/1\">\n{tracks}</gpx>"
        )
    };
    let both = track("<name>ALPHA</name>", 0.0) + &track("<name>BRAVO</name>", 1000.0);
    let one_file = files.scratch.file("truth", gpx(&both));
    let csv =
        ran(evaluate(&files.truth, &files.output).arg("--labels").arg(&files.labels).arg("--json")).stdout;
    let told =
        ran(evaluate(&one_file, &files.output).arg("--labels").arg(&files.labels).arg("--json")).stdout;
    assert_eq!(told, csv);
    // A track without a name takes the name of its file.
    let alpha = files.scratch.file("ALPHA.gpx", gpx(&track("", 0.0)));
    let bravo = files.scratch.file("BRAVO.gpx", gpx(&track("", 1000.0)));
    let mut two = evaluate(&alpha, &files.output);
    let told = ran(two.arg("--truth").arg(bravo).arg("--labels").arg(&files.labels).arg("--json")).stdout;
    assert_eq!(told, csv);
}

/// The same flight evaluated in process, with inputs alone made by hand.
fn with_inputs() -> Evaluation {
    with_inputs_and(|_| {})
}

/// The same flight, with a change to the output's points.
fn with_inputs_and(change: impl FnOnce(&mut [OutputPoint])) -> Evaluation {
    let points = |points: &[Point]| -> Vec<OutputPoint> {
        read::output("out.csv", output(points).into_bytes(), DayReference::Near(Time::default()))
            .unwrap()
            .points
    };
    let transponder: Vec<Point> =
        [40, 41, 42, 44].map(|slot| (slot, "transponder", 7, "", "7", 0.0, 1.0, "0")).into();
    // Radar track 11 also has a plot in slot 42, where it was not fused; track 13 is seduced.
    let radar: Vec<Point> = [(40, 11), (41, 11), (42, 11), (44, 12), (50, 13), (48, 99)]
        .map(|(slot, number)| (slot, "radar", number, "", "", 0.0, 20.0, "0"))
        .into();
    let mut alone =
        InputsAlone { radar: points(&radar), transponder: points(&transponder), ..InputsAlone::default() };
    for plot in &mut alone.radar {
        plot.radar_track = u16::try_from(plot.number).ok();
    }
    let truth = Truth::new(read::truth("truth.csv", "", truth(&whole_flight()).as_bytes()).unwrap());
    let rows = read::labels("labels.csv", labels().as_bytes()).unwrap();
    let labels = Labels::with_receivers(rows, &BTreeSet::from(["squitter".to_owned()]));
    let settings = Scoring { site: truth.tracks()[0].at(truth.span().unwrap().0), ..Scoring::default() };
    let mut output = points(&POINTS);
    change(&mut output);
    utm_fusion::evaluate::evaluate(&truth, Some(&labels), &output, Some(&alone), &settings)
}

#[test]
fn beside_each_input_alone() {
    let evaluation = with_inputs();
    let all = &evaluation.fused.all;
    // ALPHA has both inputs in slots 40, 41, 42; it is correctly fused in 40 and 41.
    assert!((all.recall.unwrap() - 2.0 / 3.0).abs() < 1e-9);
    // Covered: 13, 5, 0, 8; gap: 0 (slot 50). BRAVO has no transponder and counts for neither.
    assert!((all.epos_covered.unwrap().mean_m - 26.0 / 4.0).abs() < 1e-3);
    assert_eq!((all.epos_gap.unwrap().count, all.epos_covered.unwrap().count), (1, 4));
    // ALPHA's transponder interpolates in 4 of its 90 slots. The output has a point in each, and in one of the 86
    // others. The radar has plots of ALPHA in 3 of the 4; the plot in slot 44 is of BRAVO's track.
    let radar = &evaluation.radar.as_ref().unwrap().all;
    for (told, expected) in [
        (all.pu_covered_percent, 100.0),
        (all.pu_gap_percent, 100.0 / 86.0),
        (radar.pu_covered_percent, 75.0),
        (evaluation.transponder.as_ref().unwrap().all.pu_gap_percent, 0.0),
    ] {
        assert!((told.unwrap() - expected).abs() < 1e-9, "{told:?} is not {expected}");
    }
    let (radar, transponder) = (evaluation.radar.unwrap(), evaluation.transponder.unwrap());
    // ALPHA's plots are in 40, 41, 42 and 50; BRAVO's is in 44, 1000 m off: 1000.2 m.
    assert!((radar.all.pu_percent.unwrap() - 100.0 * 5.0 / 180.0).abs() < 1e-9);
    assert!((radar.drones[0].eposh.unwrap().mean_m - 20.0).abs() < 1e-3);
    assert!((radar.drones[1].eposh.unwrap().mean_m - 1000.2).abs() < 1e-2);
    assert!((radar.all.false_track_s.unwrap() - 0.25 / 0.375).abs() < 1e-9);
    assert!((transponder.equipped.pu_percent.unwrap() - 100.0 * 4.0 / 90.0).abs() < 1e-9);
    assert!((transponder.equipped.epos.unwrap().mean_m - 1.0).abs() < 1e-3);
    assert_eq!((radar.all.precision, radar.all.recall), (None, None));
}

#[test]
fn samples_contain_every_scored_point() {
    let evaluation = with_inputs();
    let drones: Vec<_> = evaluation.fused.samples.iter().map(|sample| sample.drone).collect();
    assert_eq!(drones, [Some(0), Some(0), Some(0), Some(1), Some(0), None, None, Some(0)]);
    let bravo = &evaluation.fused.samples[3];
    let seen = bravo.seen.unwrap();
    // The site of this test is where ALPHA hovers: the true BRAVO is 1000 m east of it.
    assert!((seen.range_m - 1000.0).abs() < 1e-2 && (seen.azimuth_deg - 90.0).abs() < 1e-6, "{seen:?}");
    assert!((bravo.error.unwrap().east_m - 6.0).abs() < 1e-3 && bravo.error.unwrap().up_m.is_none());
    assert!(evaluation.fused.samples[5].error.is_none() && evaluation.fused.samples[5].seen.is_none());
}

#[test]
fn table_names_missing_metrics() {
    let files = files();
    let told = ran(&mut evaluate(&files.truth, &files.output));
    assert_eq!(told.code, 0, "{}", told.stderr);
    for line in [
        "PU, 4 Hz ref. (%)                 3.33",
        "mean ePosV (m)                  3.2000",
        "association recall                   -",
        "Without --capture and --config each input alone",
        "Without --labels a point belongs to the nearest drone within 150 m",
    ] {
        assert!(told.stdout.contains(line), "{line} is not in\n{}", told.stdout);
    }
}

#[test]
fn deviations_are_held_against_errors() {
    let honest = |east_m2: f64, north_m2: f64, vertical_m2: f64| {
        Some(Covariance { east_m2, north_m2, east_north_m2: 0.0, vertical_m2 })
    };
    let told = with_inputs_and(|points| {
        // Slots 40, 41 and 50 of ALPHA, 43 of BRAVO; other points have no covariance.
        points[1].covariance = honest(9.0, 16.0, 36.0); // 3 and 4 m off, 12 m up: (1 + 1) / 2, and 4
        points[2].covariance = honest(1.0, 9.0, 4.0); // 3 m north, 4 m down: 1 / 2, and 4
        points[4].covariance = honest(4.0, 1.0, 1.0); // 6 m east, no height: 9 / 2
        points[8].covariance = honest(1.0, 1.0, 1.0); // no error
    });
    let near = |nees: Option<Nees>, count: u64, horizontal: f64, vertical: Option<f64>| {
        let nees = nees.unwrap();
        assert_eq!(nees.count, count);
        assert!((nees.horizontal - horizontal).abs() < 1e-3, "{nees:?}");
        assert_eq!(nees.vertical.is_some(), vertical.is_some());
        assert!((nees.vertical.unwrap_or(0.0) - vertical.unwrap_or(0.0)).abs() < 1e-2, "{nees:?}");
    };
    let fused = &told.fused;
    near(fused.all.nees, 4, (1.0 + 0.5 + 4.5) / 4.0, Some(8.0 / 3.0));
    near(fused.equipped.nees, 3, 1.5 / 3.0, Some(8.0 / 3.0));
    near(fused.unequipped.nees, 1, 4.5, None);
    near(fused.drones[0].nees_covered, 2, 0.75, Some(4.0));
    near(fused.drones[0].nees_gap, 1, 0.0, Some(0.0));
    assert_eq!((fused.drones[1].nees_covered, fused.drones[1].nees_gap), (None, None), "it carries none");
    assert_eq!(told.radar.unwrap().all.nees, None, "plots tell no deviation");
    assert_eq!(with_inputs().fused.all.nees, None, "nor does a file");
}
