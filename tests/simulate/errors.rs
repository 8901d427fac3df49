//! Invalid scenarios and calls: exit code, line, key and remedy.

use std::path::Path;

use utm_fusion::simulate::Scenario;

use crate::common::{Scratch, ran, utm_fusion};

/// Error message for a scenario with `name = "x"` in line 1 and this text from line 2 on.
fn said(toml: &str) -> String {
    Scenario::parse(&format!("name = \"x\"\n{toml}"), "x.toml").unwrap_err().to_string()
}

#[test]
fn scenario_errors_name_line_and_key() {
    let cases = [
        (
            "[drones]\nmultirotor = 3",
            "x.toml:3: drones.multirotor: this key is unknown; did you mean multirotors?",
        ),
        ("colour = \"red\"", "x.toml:2: colour: this key is unknown"),
        ("duration_s = 5", "x.toml:2: duration_s = 5: a scenario lasts 20 to 43200 seconds"),
        ("start = \"yesterday\"", "x.toml:2: start = \"yesterday\": write it in quotes as"),
        ("[[radars]]\ndetection = 1.5", "x.toml:3: radars[0].detection = 1.5: this is between 0 and 1"),
        ("[birds]\ncount = 2.5", "x.toml:3: birds.count = 2.5: this is between 0 and 2000, a whole number"),
        ("[[radars]]\nheights = 1", "x.toml:3: radars[0].heights = 1: expected true or false"),
        (
            "[drones]\npattern = \"loop\"",
            "x.toml:3: drones.pattern = \"loop\": there is no such pattern; use \"free\" or \"crossing\"",
        ),
        (
            "[multirotor]\nspeed_m_s = [16, 8]",
            "x.toml:3: multirotor.speed_m_s = [16, 8]: two numbers are expected, the lower first",
        ),
        ("[multirotor]\nspeed_m_s = 8", "x.toml:3: multirotor.speed_m_s = 8: expected a list"),
        (
            "[multirotor]\nspeed_m_s = [0, 8]",
            "x.toml:3: multirotor.speed_m_s[0] = 0: this is between 1 and 60",
        ),
        ("[drones]\nmultirotors = 2\nequipped = 3", "x.toml:4: drones.equipped = 3: there are only 2 drones"),
        (
            "[drones]\nmultirotors = 2\nequipped = 2\nspoofed = 2\njammed = 1",
            "x.toml:5: drones.spoofed = 2: spoofed and jammed together are more than equipped",
        ),
        (
            "[[radars]]\n[[radars]]\nid = \"b\"",
            "x.toml:3: radars[1]: sic: each radar needs its own SAC and SIC",
        ),
        ("[[radars]]\nsic = 1", "x.toml:3: radars[0].sic = 1: each radar needs its own SAC and SIC"),
        ("[[radars]]\n[[radars]]\nsic = 7", "x.toml:3: radars[1]: id: another sensor has this id already"),
        (
            "[[radars]]\nid = \"drone-it\"",
            "x.toml:3: radars[0].id = \"drone-it\": another sensor has this id",
        ),
        ("[[radars]]\nmin_range_m = 9000", "x.toml:2: radars[0]: max_range_m: this is not above min_range_m"),
        (
            "[transponder]\nsac = 25\nsic = 1",
            "x.toml:4: transponder.sic = 1: SAC and SIC are the service's own",
        ),
        (
            "[[radars]]\nid = \"a b\"",
            "x.toml:3: radars[0].id = \"a b\": use only letters A-Z a-z, digits, _ and -",
        ),
        (
            "[place]\nsic = 200",
            "x.toml: sic: each radar needs its own SAC and SIC, which are not the service's ([place])",
        ),
        ("[place]\nsac = 0\nsic = 0", "x.toml: sic: SAC and SIC are the service's own ([place])"),
        ("[[radars]\n", "x.toml:2: "),
    ];
    for (toml, expected) in cases {
        let said = said(toml);
        assert!(said.starts_with(expected), "{toml}\n  said:   {said}\n  wanted: {expected}");
        assert_eq!(said.lines().count(), 1, "{said}");
    }
    let radars: String =
        (0..255).map(|n| format!("[[radars]]\nsac = 9\nsic = {n}\nid = \"r{n}\"\n")).collect();
    assert!(said(&radars).ends_with("radars[254]: there are at most 254 radars"));
    let all = said("duration_s = 5\n[birds]\ncount = -1\n[network]\nlost = 2");
    assert_eq!(all.lines().count(), 3, "all at once: {all}");
    let nameless = Scenario::parse("duration_s = 30", "x.toml").unwrap_err().to_string();
    assert!(nameless.contains("name: this key is missing"), "{nameless}");
}

/// Runs the program on this scenario: exit code and error messages.
fn flown(scenario: &Path, more: &[&str]) -> (i32, String) {
    let (code, _, errors) = ran(utm_fusion("simulate").arg(scenario).args(more));
    (code, errors)
}

#[test]
fn exit_codes_match_the_failure() {
    let scratch = Scratch::new();
    let out = scratch.path("out");
    let out = ["--out", out.to_str().unwrap()];

    let wrong = scratch.file("wrong.toml", "name = \"x\"\n[drones]\nequipped = 1\n");
    let (code, said) = flown(&wrong, &out);
    assert_eq!(code, 3, "{said}");
    assert!(said.contains("wrong.toml:3: drones.equipped = 1: there are only 0 drones"), "{said}");

    let crowded = "name = \"x\"\nduration_s = 20\n[drones]\nmultirotors = 200\n[airspace]\nradius_m = 50\n";
    let (code, said) = flown(&scratch.file("crowded.toml", crowded), &out);
    assert_eq!(code, 3, "{said}");
    assert!(said.contains("no way was found for drone") && said.contains("drones.separation_m"), "{said}");

    let (code, said) = flown(Path::new("nowhere.toml"), &out);
    assert_eq!(code, 3, "{said}");
    assert!(said.contains("nowhere.toml: cannot be read"), "{said}");

    let right = scratch.file("right.toml", "name = \"x\"\nduration_s = 20\n");
    let (code, said) = flown(&right, &[]);
    assert_eq!(code, 2, "{said}");
    assert!(said.contains("--out <DIR>"), "{said}");
    let (code, said) = flown(&right, &["--seed", "one", "--out", "x"]);
    assert_eq!(code, 2, "{said}");

    let (code, said) = flown(&right, &["--out", right.to_str().unwrap()]);
    assert_eq!(code, 1, "{said}");
    assert!(said.contains("right.toml: cannot be written"), "{said}");

    assert_eq!(flown(&right, &out).0, 0);
}
