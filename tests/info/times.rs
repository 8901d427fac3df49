//! Times in files without reception times, gaps, and wrong clocks.

use serde_json::{Value, json};

use super::{block, fix, json, pcap, plot};

fn raw(name: &str, seconds: &[f64]) -> Value {
    let blocks: Vec<_> = seconds.iter().map(|&second| block(48, &[plot(7, second, 1)])).collect();
    json(name, &blocks.concat())
}

#[test]
fn a_file_without_reception_times_over_midnight() {
    let info = raw("midnight", &[86_396.0, 86_398.0, 0.0, 2.0, 4.0]);
    assert_eq!(
        info["span"],
        json!({
            "of": "time of day", "first": "23:59:56.000", "last": "00:00:04.000", "duration_s": 8.0,
            "steps_back": 0,
        })
    );
    let source = &info["sources"][0];
    assert_eq!((&source["first"], &source["last"]), (&json!("23:59:56.000"), &json!("00:00:04.000")));
    assert_eq!((&source["records_per_s"], &source["interval"]["median_s"]), (&json!(0.5), &json!(2.0)));
    assert_eq!((&source["silences"]["gaps"], &source["delay"]), (&json!(0), &json!(null)));
}

#[test]
fn sources_of_one_file_have_the_same_days() {
    let blocks = [
        block(48, &[plot(7, 86_399.0, 1)]),
        block(129, &[fix(1.0, 1)]),
        block(48, &[plot(7, 3.0, 1)]),
        block(129, &[fix(86_399.5, 1)]),
    ];
    let info = json("days", &blocks.concat());
    assert_eq!(info["span"]["duration_s"], 4.0);
    let firsts: Vec<_> = info["sources"].as_array().unwrap().iter().map(|source| &source["first"]).collect();
    assert_eq!(firsts, ["23:59:59.000", "23:59:59.500"]);
}

#[test]
fn a_day_and_a_half() {
    let hours: Vec<f64> = (0..=36).map(|hour| f64::from(hour % 24) * 3600.0).collect();
    let info = raw("long", &hours);
    assert_eq!(info["span"]["duration_s"], 36.0 * 3600.0);
    assert_eq!(info["sources"][0]["strays"], 0);
}

#[test]
fn strays_and_times_that_no_day_has_do_not_stretch_it() {
    let info = raw("stray", &[100.0, 101.0, 50_000.0, 102.0, 86_401.0, 103.0]);
    let source = &info["sources"][0];
    assert_eq!(info["span"]["duration_s"], 3.0);
    assert_eq!((&source["strays"], &source["out_of_range"]), (&json!(1), &json!(1)));
    assert_eq!(source["silences"]["longest_s"], 1.0);
}

#[test]
fn gaps_are_silences_of_five_usual_intervals() {
    let mut seconds: Vec<f64> = (0..100).map(|report| f64::from(report) * 2.0).collect();
    seconds.retain(|&second| !(50.0..60.0).contains(&second) && !(100.0..120.0).contains(&second));
    let silences = &raw("gaps", &seconds)["sources"][0]["silences"];
    assert_eq!(
        *silences,
        json!({"gap_above_s": 10.0, "gaps": 2, "longest_s": 22.0, "longest_from": "00:01:38.000"})
    );
}

#[test]
fn reception_clock_stepping_back_and_radar_ahead_are_shown() {
    let at = |received: f64, time: f64| (received, 8048, block(48, &[plot(7, time, 1)]));
    let info = json("clock", &pcap(&[at(100.0, 130.0), at(101.0, 131.0), at(90.0, 132.0), at(91.0, 133.0)]));
    let source = &info["sources"][0];
    assert_eq!((&info["span"]["steps_back"], &source["steps_back"]), (&json!(1), &json!(1)));
    assert_eq!(source["delay"], json!({"min_s": -42.0, "median_s": -42.0, "p99_s": -30.0, "max_s": -30.0}));
    assert_eq!((&info["span"]["duration_s"], &source["interval"]["median_s"]), (&json!(11.0), &json!(1.0)));
}
