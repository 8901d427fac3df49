//! Masks of `[[areas]]`: plots inside are dropped and counted; everything else is unchanged.

use std::fs;
use std::net::TcpListener;

use super::common::{Scratch, csv_lines, demo, ran, utm_fusion};

const AREAS: &str = "\n[[areas]]\nkind = \"mask\"\nfile = \"mask.geojson\"\n";

/// A box around the demo's radar (53.0817 N, 10.3264 E), from `west_deg` to the east.
fn mask_from(west_deg: f64) -> String {
    let ring = format!("[[{west_deg},53],[10.5,53],[10.5,53.2],[{west_deg},53.2],[{west_deg},53]]");
    format!(
        r#"{{"type":"Feature","properties":{{}},"geometry":{{"type":"Polygon","coordinates":[{ring}]}}}}"#
    )
}

#[test]
fn plots_inside_are_dropped_and_counted() {
    let flight = demo();
    let scratch = Scratch::new();
    let site = scratch.file("site.toml", [fs::read(flight.site()).unwrap(), AREAS.into()].concat());
    let replay = |mask: &str| {
        scratch.file("mask.geojson", mask.as_bytes());
        let mut command = utm_fusion("replay");
        let out = scratch.path("out.csv");
        let ran = ran(command.arg(flight.capture()).arg("--config").arg(&site).arg("-o").arg(&out));
        assert_eq!(ran.code, 0, "{}", ran.stderr);
        (ran.text().to_owned(), csv_lines(fs::read(out).unwrap()))
    };

    // Everything is masked: only the transponders are left.
    let (summary, lines) = replay(&mask_from(10.2));
    assert!(summary.contains("halfmoon (radar): 0 plots; dropped: 1175 masked"), "{summary}");
    assert!(!lines.is_empty() && lines.iter().all(|line| line.split(',').nth(2) == Some("transponder")));

    // A far corner: the same as without a mask.
    let (summary, lines) = replay(&mask_from(10.499));
    assert!(summary.contains("halfmoon (radar): 1175 plots"), "{summary}");
    assert_eq!(lines, flight.csv());

    // The east is masked: radar points are left in the west only.
    let (summary, lines) = replay(&mask_from(10.33));
    assert!(summary.contains(" masked"), "{summary}");
    let radar: Vec<f64> = lines
        .iter()
        .map(|line| line.split(',').collect::<Vec<_>>())
        .filter(|columns| columns[2] == "radar")
        .map(|columns| columns[7].parse().unwrap())
        .collect();
    assert!(!radar.is_empty() && radar.iter().all(|&longitude_deg| longitude_deg < 10.33), "{radar:?}");
}

/// A layer of 50 m to 120 m that is taken for all heights causes false alarms, or masks traffic above it.
#[test]
fn unknown_zone_member_is_refused_by_name() {
    let flight = demo();
    let scratch = Scratch::new();
    let corners = "[[[10,53],[11,53],[11,54],[10,53]]]";
    let zone = format!(
        "{{\"type\":\"FeatureCollection\",\"features\":[{{\"type\":\"Feature\",\"properties\":{{\"identifier\":\"U74\",\
         \"type\":\"PROHIBITED\"}},\"geometry\":{{\"type\":\"Polygon\",\"coordinates\":{corners},\
         \"layer\":{{\"lower\":50,\"lowerReference\":\"AGL\",\"uom\":\"m\"}}}}}}]}}"
    );
    scratch.file("zone.geojson", zone.as_bytes());
    // The address is in use, so a service that accepted the zone would end here.
    let taken = TcpListener::bind("127.0.0.1:0").unwrap();
    for (kind, subcommands, told) in [
        // A replay needs the masks alone.
        ("mask", &["check", "run", "replay"][..], "zone U74 holds at some heights or times only"),
        ("alert", &["check", "run"], "zone 1 (\"U74\"): geometry.layer.lower = 50"),
    ] {
        let area = format!("\n[[areas]]\nkind = \"{kind}\"\nfile = \"zone.geojson\"\n");
        let site = scratch.file("site.toml", [fs::read(flight.site()).unwrap(), area.into()].concat());
        for subcommand in subcommands {
            let mut command = utm_fusion(subcommand);
            command.arg("--config").arg(&site);
            command.env("UTM_FUSION__HTTP__LISTEN", taken.local_addr().unwrap().to_string());
            if *subcommand == "replay" {
                command.arg(flight.capture());
            }
            let ran = ran(&mut command);
            assert_eq!(ran.code, 3, "{subcommand}: {}", ran.stderr);
            for words in ["zone.geojson: ", told] {
                assert!(ran.stderr.contains(words), "{subcommand} does not say {words}: {}", ran.stderr);
            }
        }
    }
}

#[test]
fn invalid_area_exits_with_code_3() {
    let flight = demo();
    let scratch = Scratch::new();
    let site = scratch.file("site.toml", [fs::read(flight.site()).unwrap(), AREAS.into()].concat());
    scratch.file("mask.geojson", br#"{"type":"Point","coordinates":[10,53]}"#);
    for subcommand in ["check", "replay"] {
        let mut command = utm_fusion(subcommand);
        command.arg("--config").arg(&site);
        if subcommand == "replay" {
            command.arg(flight.capture());
        }
        let ran = ran(&mut command);
        assert_eq!(ran.code, 3, "{}", ran.stderr);
        assert!(ran.stderr.contains("it is no polygon"), "{}", ran.stderr);
    }
    // Settings of the service are checked as well.
    for (area, told) in [
        ("[[areas]]\nkind = \"alert\"\nfile = \"mask.geojson\"\n", "it is no polygon"),
        ("", "tokens.toml: the tokens cannot be read"),
    ] {
        let text = String::from_utf8(fs::read(flight.site()).unwrap()).unwrap() + "\n" + area;
        let text = match area {
            "" => text.replace("mode = \"none\"", "mode = \"tokens\", tokens_file = \"tokens.toml\""),
            _ => text,
        };
        scratch.file("site.toml", text.as_bytes());
        let ran = ran(utm_fusion("check").arg("--config").arg(&site));
        assert_eq!(ran.code, 3, "{}", ran.stderr);
        assert!(ran.stderr.contains(told), "{}", ran.stderr);
    }
}
