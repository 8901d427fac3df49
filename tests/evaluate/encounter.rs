//! Figure of the closest encounter, as `evaluate --conflicts FILE --plot DIR` writes it.

use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::path::Path;

use super::common::{START_S, Scratch, east, evaluate, north, ran};

const OUTPUT: &str = "time,id,source,track_number,radar_track,transponder,lat,lon,alt_msl,flags\n";
/// Transponder receiver of the demo's site.
const RECEIVER: &str = "squitter";

/// ALPHA flies east and BRAVO west, 40 m to the north, each at 10 m/s; they pass after 60 s. Returns the figure and the
/// page.
fn figure(conflicts: &str) -> (String, String) {
    let scratch = Scratch::new();
    let mut truth = "time,id,lat,lon,alt_msl\n".to_owned();
    let (mut labels, mut output) = ("time,sensor,number,id,seduced\n".to_owned(), OUTPUT.to_owned());
    for second in 0..90 {
        let (time, along_m) = (START_S + f64::from(second), 10.0 * f64::from(second - 60));
        for (id, number, lat, lon) in
            [("ALPHA", 1, 0.0, east(along_m)), ("BRAVO", 2, north(40.0), east(-along_m))]
        {
            writeln!(truth, "{time},{id},{lat:.9},{lon:.9},100").unwrap();
            writeln!(labels, "{time},{RECEIVER},{number},{id},0").unwrap();
            let track = 10_000 * number;
            writeln!(output, "{time},U-{track},transponder,{track},,{number},{lat:.9},{lon:.9},100,")
                .unwrap();
        }
    }
    let site = Path::new(env!("CARGO_MANIFEST_DIR")).join("testdata/demo/site.toml");
    let mut command = evaluate(&scratch.file("truth.csv", truth), &scratch.file("out.csv", output));
    command.arg("--labels").arg(scratch.file("labels.csv", labels)).arg("--config").arg(site);
    command.arg("--conflicts").arg(scratch.file("conflicts.ndjson", conflicts));
    let told = ran(command.arg("--plot").arg(scratch.path("plots")));
    assert_eq!(told.code, 0, "{}", told.stderr);
    let read =
        |name: &str| String::from_utf8(std::fs::read(scratch.path("plots").join(name)).unwrap()).unwrap();
    (read("conflicts.svg"), read("index.html"))
}

/// A line of `replay --conflicts` with the fields that are read.
fn line(second: u32) -> String {
    let left_s = 60 - second;
    format!(
        "{{\"time\":\"2026-03-14T09:00:{second:02}Z\",\"a\":\"U-10000\",\"b\":\"U-20000\",\"volume\":\"drone\",\"level\":\"none\",\
         \"t_cpa_s\":{left_s},\"probability\":0.5,\"miss\":{{\"across_m\":40,\"covariance_m2\":[[100,0],[0,1]]}},\
         \"relative\":{{\"position_m\":[{},40,0],\"velocity_ms\":[-20,0,0]}}}}\n",
        20 * left_s
    )
}

#[test]
fn predicted_and_true_approach_share_a_figure() {
    let (svg, page) = figure(&(35..60).map(line).collect::<String>());
    let document = roxmltree::Document::parse(&svg).unwrap();
    let title =
        |tag| document.root_element().children().find(|node| node.has_tag_name(tag)).unwrap().text().unwrap();
    assert!(title("desc").contains("ALPHA and BRAVO came closest"), "{}", title("desc"));
    assert!(title("desc").contains("40.0 m, over ground 40.0 m"), "{}", title("desc"));
    assert!(
        svg.contains(">by the true states<")
            && svg.contains(">as stated<")
            && !svg.contains("nothing was foreseen")
    );
    // Both fly straight on, so the predicted line coincides with the true one.
    let corners = |colour: &str| -> BTreeSet<&str> {
        let line = document.descendants().find(|node| {
            node.attribute("stroke") == Some(colour)
                && node.parent_element().is_some_and(|group| group.has_attribute("clip-path"))
        });
        line.unwrap().attribute("d").unwrap().trim_start_matches('M').split('L').collect()
    };
    let (stated, truth) = (corners("#052c5c"), corners("#8a5600"));
    assert_eq!(stated.len(), 25);
    assert!(stated.is_subset(&truth), "{stated:?} {truth:?}");
    assert!(page.contains("id=\"conflicts\""));
}

#[test]
fn pair_without_predictions_is_reported() {
    let (svg, _) = figure("");
    assert!(svg.contains(">nothing was foreseen of ALPHA and BRAVO<"), "{svg}");
    assert!(svg.contains(">by the true states<") && !svg.contains(">as stated<"));
}
