//! Tests of the configuration as users meet it: the files of `config/`, the environment, the effective configuration.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use proptest::prelude::*;
use utm_fusion::config::{
    Action, AreaKind, Auth, Config, ConfigErrors, Fusion, Integrity, Place, Profile, SensorKind,
};

const EXAMPLE: &str = include_str!("../config/example.toml");

/// A small configuration that contains characters to be escaped.
const SMALL: &str = r#"[site]
name = "a \"b\" \\ \u0001\n"
sac = 25
sic = 1

[[sensors]]
id = "north"
kind = "radar"
sac = 25
sic = 200
latitude_deg = 52.123456789012
longitude_deg = -0.1
height_amsl_m = 1e-7
classification = { source = "constant", value = 0.3 }

[fusion]
slot_s = 0.1
latency_s = 0.7
window_s = 12.1
suppress_s = 0.3
max_future_s = 0.123456789
transponder_numbers = { "A \"B\" 1" = 9, 007 = 3 }
"#;

fn parse(text: &str, env: &[(&str, &str)]) -> Result<Config, ConfigErrors> {
    let env = env.iter().map(|&(name, value)| (name.to_owned(), value.to_owned()));
    Config::parse(text, "config/site.toml", env)
}

fn load(name: &str) -> Config {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("config").join(name);
    Config::load(&path).unwrap_or_else(|errors| panic!("{errors}"))
}

#[test]
fn the_example_is_valid_and_shows_the_defaults() {
    let config = load("example.toml");
    let numbers = [("DRONE-ALPHA".to_owned(), 7)].into();
    assert_eq!(config.fusion, Fusion { transponder_numbers: numbers, ..Fusion::default() });
    assert_eq!(config.integrity, Integrity::default());
    assert_eq!(config.areas, []);
}

/// The example with its commented-out keys enabled, except files that a copy of it lacks.
fn whole_example() -> String {
    let keys = [
        "[[areas]]",
        "kind = ",
        "file = ",
        "sensor = ",
        "tls = ",
        "pmtiles = ",
        "floor_m = ",
        "ceiling_m = ",
        "ground_m = ",
        "predict_s = ",
        "severity = ",
        "allow = ",
        "language = ",
        "[cluster]",
        "servers = ",
        "credentials = ",
        "inbox = ",
        "node = ",
        "machine = ",
        "region = ",
        "roles = ",
        "cells = ",
        "halo_m = ",
        "hysteresis_m = ",
        "gateways = ",
        "owns = ",
        "replicas = ",
        "lease_s = ",
        "wait_s = ",
        "checkpoint_s = ",
        "time_zone = ",
        "[[alerts.webhooks]]",
        "id = ",
        "url = ",
        "secret_file = ",
        "authorization_file = ",
        "ca = ",
        "connections = ",
        "kinds = ",
        "min_severity = ",
        "timeout_s = ",
        "[alerts.mqtt]",
        "host = ",
        "port = ",
        "username = ",
        "password_file = ",
        "client_id = ",
        "prefix = ",
        "[[output.cot]]",
        "server_name = ",
        "certificate = ",
        "key = ",
        "picture = ",
        "stale_s = ",
        "interface = ",
        "ttl = ",
        "[[output.f3623]]",
        "token_file = ",
        "[[output.sapient]]",
        "node_id = ",
        "status_interval_s = ",
        "[[output.mqtt]]",
        "retain = ",
    ];
    let uncommented = |line: &str| match line.strip_prefix("# ") {
        Some(text) if keys.iter().any(|key| text.starts_with(key)) => format!("{text}\n"),
        _ => format!("{line}\n"),
    };
    EXAMPLE.lines().map(uncommented).collect()
}

#[test]
fn the_areas_of_the_example_are_valid() {
    let text = whole_example();
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("config/example.toml");
    let config = Config::parse(&text, file.to_str().unwrap(), std::iter::empty());
    let config = config.unwrap_or_else(|errors| panic!("{errors}"));
    assert_eq!(config.areas.len(), 3);
    assert_eq!(config.areas[1].kind, AreaKind::Coverage { sensor: "ground-station".into() });
    assert!(config.areas.iter().all(|area| area.file.is_absolute()));
}

/// Paths of the keys of a table; entries of a list have no index.
fn paths(path: &str, value: &toml::Value, found: &mut BTreeSet<String>) {
    match value {
        toml::Value::Array(list) => list.iter().for_each(|entry| paths(path, entry, found)),
        toml::Value::Table(table) => {
            for (key, value) in table {
                let path = if path.is_empty() { key.clone() } else { format!("{path}.{key}") };
                found.insert(path.clone());
                paths(&path, value, found);
            }
        }
        _ => {}
    }
}

#[test]
fn keys_page_and_example_have_the_same_keys() {
    // Keys that the example has only in a comment, as alternatives to others.
    let left_out = [
        "site.latitude_deg",
        "site.longitude_deg",
        "site.height_amsl_m",
        "sensors.classification.drones",
        "sensors.classification.offset",
        "sensors.classification.probability_octet",
        "sensors.classification.scale",
        "sensors.classification.value",
        "sensors.inputs.trailer_octets",
        "http.auth.tokens_file",
        "alerts.webhooks.secret_env",
        "alerts.mqtt.password_env",
        "sensors.connections.drone_classes",
        "sensors.connections.fields.azimuth",
        "sensors.connections.fields.class",
        "sensors.connections.fields.course",
        "sensors.connections.fields.east",
        "sensors.connections.fields.elevation",
        "sensors.connections.fields.north",
        "sensors.connections.fields.probability",
        "sensors.connections.fields.range",
        "sensors.connections.fields.speed",
        "sensors.connections.fields.track",
        "sensors.connections.fields.up",
        "sensors.connections.password_env",
        "output.mqtt.password_env",
        "cluster.grid_deg",
        "cluster.nkey",
    ];
    // Tables, and tables whose keys are chosen by the user.
    let no_keys = [
        "site",
        "sensors",
        "fusion",
        "integrity",
        "conflicts",
        "alerts",
        "areas",
        "output",
        "http",
        "map",
        "state",
        "cluster",
        "fusion.transponder_numbers.DRONE-ALPHA",
    ];
    let keys: BTreeSet<String> = utm_fusion::config::keys().into_iter().collect();

    let mut example = BTreeSet::new();
    paths("", &whole_example().parse::<toml::Table>().unwrap().into(), &mut example);
    no_keys.iter().for_each(|path| assert!(example.remove(*path), "{path}"));
    for path in left_out {
        let key = path.rsplit('.').next().unwrap();
        assert!(EXAMPLE.contains(key) && example.insert(path.to_owned()), "{path}");
    }
    assert_eq!(example, keys);

    let page = include_str!("../docs/CONFIGURATION.md");
    let mut on_page = BTreeSet::new();
    let mut section = "";
    for line in page.lines() {
        if let Some(name) = line.strip_prefix("## ") {
            section = name.split([',', ' ']).next().unwrap().trim_matches(['[', ']']);
        } else if let Some((key, _)) = line.strip_prefix("| `").and_then(|row| row.split_once('`')) {
            on_page.insert(format!("{section}.{key}"));
        }
    }
    assert_eq!(on_page, keys);
}

#[test]
fn the_trial_site_is_valid() {
    let config = load("deenethorpe.toml");
    // The site of the paper, with the method of the paper.
    assert_eq!(config.fusion, Fusion { profile: Profile::Reference, now: false, ..Fusion::default() });
    let (sensor, radar) = config.radars().next().unwrap();
    assert_eq!((sensor.sac, sensor.sic, sensor.period_s), (25, 200, Some(0.25)));
    assert_eq!((radar.height_amsl_m, radar.assumed_height_amsl_m), (105.0, 150.0));
    assert!(matches!(config.sensors[1].kind, SensorKind::Transponder(_)));
}

#[test]
fn open_connection_beside_a_source_is_an_error() {
    let (line, host) = ("port = 8129, interface = \"127.0.0.1\"", ", source = \"127.0.0.1\"");
    let mavlink =
        EXAMPLE.replace("# connections = [{ format = \"mavlink\"", "connections = [{ format = \"mavlink\"");
    parse(&mavlink, &[]).unwrap();
    let errors = parse(&mavlink.replace(line, &format!("{line}{host}")), &[]).unwrap_err();
    assert!(errors.to_string().contains("takes what any host sends"), "{errors}");
}

#[test]
fn the_effective_configuration_reads_back_to_the_same() {
    for text in
        [EXAMPLE, SMALL, include_str!("../config/deenethorpe.toml"), include_str!("../config/demo.toml")]
    {
        let config = parse(text, &[]).unwrap_or_else(|errors| panic!("{errors}"));
        let shown = config.to_string();
        // Another directory, because no path may depend on where the file was.
        let back = Config::parse(&shown, "/elsewhere/site.toml", std::iter::empty());
        assert_eq!(back.unwrap_or_else(|errors| panic!("{errors}\n{shown}")), config, "{shown}");
    }
}

/// The first site in the README uses the default profile. Tests of `reference` use the same site with that profile.
#[test]
fn demonstration_site_has_the_default_profile() {
    let mut demo = parse(include_str!("../config/demo.toml"), &[]).unwrap();
    let reference = parse(include_str!("../testdata/demo/site.toml"), &[]).unwrap();
    assert_eq!(
        demo.fusion.profile,
        Config::parse(SMALL, "small.toml", std::iter::empty()).unwrap().fusion.profile
    );
    assert_ne!(demo.fusion.profile, reference.fusion.profile);
    demo.fusion = demo.fusion.with_profile(reference.fusion.profile).unwrap();
    assert_eq!(demo, reference);
}

#[test]
fn effective_configuration_has_defaults() {
    let shown = parse(SMALL, &[]).unwrap().to_string();
    for line in [
        "# geoid_undulation_m: EGM96 at the origin of the local frame",
        "# period_s: not stated, 0.25 is assumed",
        "assumed_height_amsl_m = 1e-7",
        "latency_s = 0.7",
        "listen = \"127.0.0.1:8080\"",
        "dir = \"state\"",
    ] {
        assert!(shown.lines().any(|shown| shown == line), "{line}\nis not in\n{shown}");
    }
}

#[test]
fn the_environment_overrides_keys() {
    let config = parse(
        SMALL,
        &[
            ("HOME", "/root"),
            ("UTM_FUSION_SHARED_DATA", "not an override"),
            ("UTM_FUSION__SITE__NAME", "bare text"),
            ("UTM_FUSION__SITE__SAC", " 0x1A "),
            ("UTM_FUSION__FUSION__LATENCY_S", "5"),
            ("UTM_FUSION__FUSION__THRESHOLD_M", "[[0, 50]]"),
            ("UTM_FUSION__FUSION__TRANSPONDER_NUMBERS", "{ X = 1 }"),
            ("UTM_FUSION__HTTP__LISTEN", "0.0.0.0:80"),
            ("UTM_FUSION__HTTP__AUTH__MODE", "tokens"),
            ("UTM_FUSION__HTTP__AUTH__TOKENS_FILE", "/etc/tokens"),
            ("UTM_FUSION__OUTPUT__RECORD__DIR", "\"quoted\""),
            ("UTM_FUSION__OUTPUT__ASTERIX", r#"[{ address = "10.0.0.1", port = 8130 }]"#),
        ],
    )
    .unwrap_or_else(|errors| panic!("{errors}"));
    assert_eq!((config.site.name.as_str(), config.site.sac), ("bare text", 26));
    assert_eq!(config.fusion.latency_slots, 50);
    assert_eq!(config.fusion.threshold_m, [(0.0, 50.0)]);
    assert_eq!(config.fusion.transponder_numbers, [("X".to_owned(), 1)].into());
    assert_eq!(
        (config.http.listen.to_string().as_str(), config.http.auth),
        ("0.0.0.0:80", Auth::Tokens { tokens_file: "/etc/tokens".into() })
    );
    assert_eq!(config.output.record.unwrap().dir.to_str(), Some("quoted"));
    assert_eq!(config.output.asterix[0].ttl, 64);
}

#[test]
fn an_override_that_is_wrong_is_named() {
    for (name, value, key, message) in [
        ("UTM_FUSION__FUSION__LATENCY_S", "soon", "fusion.latency_s = \"soon\"", "expected a number"),
        ("UTM_FUSION__FUSION__LATENCY_S", "5\nwindow_s = 9", "fusion.latency_s", "expected a number"),
        ("UTM_FUSION__FUSION__LATENCY_S", "0.75", "fusion.latency_s = 0.75", "whole number of slots"),
        (
            "UTM_FUSION__FUSION__PROFILE",
            "fast",
            "fusion.profile = \"fast\"",
            "use \"operational\" or \"reference\"",
        ),
        ("UTM_FUSION__FUSION__LATENCY", "5", "fusion.latency", "did you mean latency_s?"),
        ("UTM_FUSION__FUSIN__LATENCY_S", "5", "fusin", "did you mean fusion?"),
        ("UTM_FUSION__SITE__NAME", "25", "site.name = 25", "expected text in quotes"),
        ("UTM_FUSION__SENSORS__0__SAC", "1", "sensors.0.sac", "set in the file only"),
        ("UTM_FUSION__AREAS", "[]", "areas", "set in the file only"),
        ("UTM_FUSION__FUSION", "{}", "fusion", "names no key"),
        ("UTM_FUSION__", "5", "this", "names no key"),
        ("UTM_FUSION__FUSION__", "5", "fusion.\"\"", "unknown"),
        ("UTM_FUSION__SITE__NAME__X", "5", "site.name.x", "set name as a whole"),
        ("UTM_FUSION__FUSION__TRANSPONDER_NUMBERS__X", "5", "fusion.transponder_numbers.x", "set together"),
    ] {
        let Err(errors) = parse(SMALL, &[(name, value)]) else { panic!("{name}={value} was accepted") };
        let shown = errors.to_string();
        assert_eq!(errors.iter().count(), 1, "{shown}");
        let rest = shown.strip_prefix(&format!("environment variable {name}: {key}"));
        assert!(rest.is_some_and(|rest| rest.starts_with([':', ' '])), "{shown}");
        assert!(shown.contains(message), "{shown}");
    }
}

/// `[integrity]` is read, and its errors are reported with their lines.
#[test]
fn integrity() {
    let with = |lines: &str| parse(&format!("{SMALL}\n[integrity]\n{lines}\n"), &[]);
    assert_eq!(parse(SMALL, &[]).unwrap().integrity, Integrity::default());
    let read = with("action = \"split\"\non = 9\noff = 0\nprotect = false").unwrap().integrity;
    let wanted =
        Integrity { action: Action::Split, on: 9.0, off: 0.0, protect: false, ..Integrity::default() };
    assert_eq!(read, wanted);
    for (lines, told) in [
        (
            "action = \"correct\"",
            ":25: integrity.action = \"correct\": there is no such action; use \"off\" or",
        ),
        ("on = 2.0", ":25: integrity.on = 2.0: on is above off"),
        ("alert_limit_m = 9\noff = 14.5", ":26: integrity.off = 14.5: on is above off"),
        ("on = nan", ":25: integrity.on = NaN: an index is at least 0"),
        ("off = -1", ":25: integrity.off = -1: an index is at least 0"),
        ("alert_limit_m = inf", ":25: integrity.alert_limit_m = inf: an alert limit is above 0"),
        ("protect = 1", ":25: integrity.protect = 1: expected true or false"),
        ("alert_limit = 60", ":25: integrity.alert_limit: this key is unknown; did you mean alert_limit_m?"),
    ] {
        let errors = with(lines).unwrap_err().to_string();
        assert!(errors.starts_with(&format!("config/site.toml{told}")), "{lines}: {errors}");
    }
}

/// Receivers of alerts are read, and contradicting keys are refused.
#[test]
fn receivers_of_alerts() {
    let with = |lines: &str| parse(&format!("{SMALL}\n{lines}\n"), &[]);
    let hook = "[[alerts.webhooks]]\nid = \"a\"\nurl = \"https://a.example/\"\n";
    let mqtt = "[alerts.mqtt]\nhost = \"b.example\"\n";
    let alerts = with(&format!("{hook}{mqtt}")).unwrap().alerts;
    assert_eq!((alerts.webhooks.len(), alerts.mqtt.map(|mqtt| mqtt.port)), (1, Some(1883)));
    let port = |lines: &str| with(&format!("{mqtt}{lines}")).unwrap().alerts.mqtt.unwrap().port;
    assert_eq!([port("tls = true"), port("tls = true\nport = 1")], [8883, 1]);
    for (lines, told) in [
        (hook.repeat(2), "there are two webhooks of id \"a\""),
        (hook.replace("https", "ftp"), "expected https://host/path or http://host/path"),
        (hook.replace("a.ex", "me:secret@a.ex"), "no password belongs into this file"),
        (hook.replace("https://a.example/", "/path"), "expected https://host/path or http://host/path"),
        (format!("{hook}secret_file = \"s\"\nsecret_env = \"S\""), "there is a file of it too"),
        (format!("{hook}kinds = []"), "nothing would ever be sent"),
        (format!("{hook}kinds = [\"weather\"]"), "there is no such kind of alert"),
        (format!("{hook}secret = \"s\""), "this key is unknown; did you mean secret_file?"),
        (format!("{hook}timeout_s = 0"), "a timeout is between 0.1 and 60 seconds"),
        (format!("{}ca = \"ca.pem\"", hook.replace("https", "http")), "nobody proves anything over http"),
        (format!("{mqtt}ca = \"ca.pem\""), "nobody proves anything without tls = true"),
        (format!("{mqtt}password_file = \"p\""), "a password belongs to a username"),
        (format!("{mqtt}prefix = \"a/+\""), "a prefix is made of names with / between them"),
        (format!("{mqtt}prefix = \"/a\""), "a prefix is made of names with / between them"),
        (mqtt.replace("b.ex", "mqtt://b.ex"), "a host is a name or an address"),
    ] {
        let errors = with(&lines).unwrap_err();
        assert!(errors.iter().count() == 1 && errors.to_string().contains(told), "{lines}: {errors}");
    }
}

/// Contradicting keys of `[conflicts]` are reported with a remedy.
#[test]
fn conflicts() {
    for (lines, told) in [
        ("advisory = { probability = 0.5 }", ":25: conflicts.advisory: an advisory is given before"),
        ("horizon_s = 15", ":25: conflicts.horizon_s = 15: nothing is warned of that lies beyond"),
        (
            "horizon_s = 30\nvolumes = [{ preset = \"do365-enroute\" }]",
            ":25: conflicts.horizon_s = 30: volume \"do365-enroute\" counts as entered 35 s before",
        ),
        (
            "volumes = [{ preset = \"nmac\" }, { preset = \"nmac\" }]",
            ":25: conflicts.volumes: two volumes are called \"nmac\"",
        ),
    ] {
        let errors = parse(&format!("{SMALL}\n[conflicts]\n{lines}\n"), &[]).unwrap_err().to_string();
        assert!(errors.starts_with(&format!("config/site.toml{told}")), "{lines}: {errors}");
    }
}

#[test]
fn all_faults_are_reported_in_the_order_of_the_file() {
    let text = SMALL
        .replace("sac = 25\nsic = 1\n", "sac = 256\n")
        .replace("52.1", "152.1")
        .replace("slot_s", "slot")
        .replace("0.123456789", "\"1\"");
    let errors = parse(&text, &[("UTM_FUSION__HTTP__LISTEN", "8080")]).unwrap_err();
    let places: Vec<_> = errors.iter().map(|error| (error.place.clone(), error.key.as_str())).collect();
    let variable = Place::Variable("UTM_FUSION__HTTP__LISTEN".into());
    let wanted = [
        (Place::Line(1), "site.sic"),
        (Place::Line(3), "site.sac"),
        (Place::Line(10), "sensors[0].latitude_deg"),
        (Place::Line(16), "fusion.slot"),
        (Place::Line(17), "fusion.latency_s"),
        (Place::Line(18), "fusion.window_s"),
        (Place::Line(19), "fusion.suppress_s"),
        (Place::Line(20), "fusion.max_future_s"),
        (variable, "http.listen"),
    ];
    assert_eq!(places, wanted, "{errors}");
    let line = "config/site.toml:10: sensors[0].latitude_deg = 152.123456789012: \
                a latitude is between -90 and 90 degrees; ";
    assert!(errors.to_string().contains(line), "{errors}");
}

/// `UPDATE=1 cargo test --test config reference_page` writes the page.
#[test]
fn the_reference_page_is_up_to_date() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/CONFIGURATION.md");
    let page = utm_fusion::config::reference();
    if std::env::var_os("UPDATE").is_some() {
        return std::fs::write(&path, page).unwrap();
    }
    assert_eq!(include_str!("../docs/CONFIGURATION.md"), page, "UPDATE=1 writes it anew");
}

#[test]
fn a_file_that_cannot_be_read_says_so() {
    let errors = Config::load("no/such/site.toml").unwrap_err().to_string();
    assert!(errors.starts_with("no/such/site.toml: cannot be read: "), "{errors}");
}

/// The site files of the recorded and simulated flights load.
#[test]
fn every_site_of_the_shared_data_loads() {
    let Some(root) = std::env::var_os("UTM_FUSION_SHARED_DATA") else {
        println!("skipped: UTM_FUSION_SHARED_DATA is not set");
        return;
    };
    let mut dirs = vec![PathBuf::from(root)];
    let mut loaded = 0;
    while let Some(dir) = dirs.pop() {
        for entry in std::fs::read_dir(&dir).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                dirs.push(path);
            } else if path.file_name().is_some_and(|name| name == "site.toml") {
                Config::load(&path).unwrap_or_else(|errors| panic!("{errors}"));
                loaded += 1;
            }
        }
    }
    assert!(loaded > 0, "there is no site.toml under UTM_FUSION_SHARED_DATA");
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn arbitrary_text_never_panics(text in "(?s).{0,200}", name in "[A-Z_]{0,20}", value in "(?s).{0,40}") {
        let _ = parse(&text, &[(&format!("UTM_FUSION__{name}"), &value)]);
    }

    /// Mutations of the example: one value replaced, or two lines swapped or cut. They reach further into the reader than random
    /// text.
    #[test]
    fn broken_example_names_what_it_refuses(
        at in 0..EXAMPLE.lines().count(),
        to in 0..EXAMPLE.lines().count(),
        value in prop_oneof!["[-+.0-9einf]{0,9}", "\"[ -~]{0,8}\"", "[\\[\\]{}=,a-z0-9 ]{0,12}", "1e-?[0-9]{1,3}"],
        how in 0..3,
    ) {
        let mut lines: Vec<String> = EXAMPLE.lines().map(str::to_owned).collect();
        match how {
            0 => if let Some((key, _)) = lines[at].split_once('=') { lines[at] = format!("{key}= {value}"); },
            1 => lines.swap(at, to),
            _ => lines[at] = lines[at].chars().take(to).collect(),
        }
        match parse(&lines.join("\n"), &[]) {
            Ok(config) => {
                let shown = config.to_string();
                prop_assert_eq!(parse(&shown, &[]), Ok(config), "{}", shown);
            }
            Err(errors) => prop_assert!(errors.iter().all(|error| !error.message.is_empty())),
        }
    }
}
